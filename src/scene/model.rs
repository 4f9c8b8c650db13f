//! The model file as parameter structs: SI values, each with its source span.

use std::sync::Arc;

use super::bevel_file::BevelFile;
use super::gear_mesh::GearMesh;
use super::laws::{
    Characteristic, ContactDamping, FrictionLaw, LoadHistory, MotorModel, ToothFriction, Waveform,
};
use super::pair_mesh::PairMesh;
use crate::base::source_span::{SourceFile, SourceSpan};
pub use crate::gear::hand::Hand;
use crate::gear::load::load_table::LoadTable;

/// Parsed and validated model file, before assembly of the machine.
#[derive(Debug, Clone, Default)]
pub struct Model {
    /// Title of the machine, one line; the title of a scene replaces it.
    pub title: String,
    /// Source of the values: publication or method of estimation.
    pub source: String,
    /// Inertias; the name of each is the name of its node.
    pub inertias: Vec<Inertia>,
    /// Torsional shafts.
    pub shafts: Vec<Shaft>,
    /// Chains of equal discs and equal shafts.
    pub chains: Vec<DiscChain>,
    /// Spur, helical, bevel and hypoid pairs.
    pub gear_pairs: Vec<GearPair>,
    /// Worm pairs.
    pub worm_pairs: Vec<WormPair>,
    /// Planetary stages.
    pub planetaries: Vec<Planetary>,
    /// Belt and chain drives.
    pub belts: Vec<Belt>,
    /// Slides driven by screws.
    pub slides: Vec<Slide>,
    /// Screws and their nuts.
    pub screws: Vec<Screw>,
    /// Couplings.
    pub couplings: Vec<Coupling>,
    /// Bearings and supports.
    pub bearings: Vec<Bearing>,
    /// Dampers.
    pub dampers: Vec<Damper>,
    /// External torques and forces; their long-term values determine the flanks in contact.
    pub loads: Vec<Load>,
    /// Motors with a torque–speed curve or a prescribed motion.
    pub motors: Vec<Motor>,
    /// Brakes and clutches: dry friction between nodes.
    pub brakes: Vec<Brake>,
    /// Errors of gears, couplings, belts and screws.
    pub errors: Vec<DeclaredError>,
    /// Global damping of the machine.
    pub damping: GlobalDamping,
    /// Mean speeds of nodes; `--speed` replaces the first.
    pub speeds: Vec<MeanSpeed>,
    /// Workpiece of a gear generator; `None` for other machines.
    pub work: Option<Arc<GeneratorWork>>,
}

impl Model {
    /// Meshes with a gear file: element name, mesh, contact parameters.
    pub fn gear_meshes(&self) -> Vec<(&Name, PairMesh, &ContactParameters)> {
        let pairs = self.gear_pairs.iter();
        let pairs = pairs.filter_map(|p| Some((&p.name, p.gear.clone()?, &p.contact)));
        let stages = self.planetaries.iter().filter_map(|stage| {
            let [sun, ring] =
                (stage.gears.as_ref()?.each_ref()).map(|g| PairMesh::Cylindrical(g.clone()));
            Some([
                (&stage.name, sun, &stage.sun_contact),
                (&stage.name, ring, &stage.ring_contact),
            ])
        });
        pairs.chain(stages.flatten()).collect()
    }

    /// Gear files, generator files and chip files of the model, without duplicates.
    pub fn gear_files(&self) -> Vec<Arc<SourceFile>> {
        let mut files: Vec<Arc<SourceFile>> = Vec::new();
        for (_, mesh, _) in self.gear_meshes() {
            let source = &mesh.file().source;
            if !files.contains(source) {
                files.push(source.clone());
            }
        }
        let generators = self.gear_pairs.iter().filter_map(|p| p.cut_on.as_ref());
        let work = self.work.iter().map(|work| &work.bevel.source);
        let chips = self.loads.iter().filter_map(|load| load.history.chips());
        let worms = self.worm_pairs.iter().filter_map(|pair| pair.gear.as_ref());
        let generators = generators.map(|cut| &cut.source);
        for source in generators.chain(worms).chain(work).chain(chips) {
            if !files.contains(source) {
                files.push(source.clone());
            }
        }
        files
    }
}

/// Name with its source span.
#[derive(Debug, Clone)]
pub struct Name {
    /// The name as written.
    pub text: String,
    /// Source span.
    pub span: SourceSpan,
}

/// One end of a branch.
#[derive(Debug, Clone)]
pub enum BranchEnd {
    /// The fixed frame.
    Ground,
    /// A node, by the name of its inertia.
    Node(Name),
}

/// Damping model of one branch.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum BranchDamping {
    /// Undamped.
    #[default]
    None,
    /// Viscous coefficient, in the unit of the branch's stiffness times second.
    Viscous(f64),
    /// Damping ratio ζ: `c = 2ζ√(k mₑ)`, `mₑ = 1/(wᵀM⁻¹w)`.
    Ratio(f64),
    /// Loss factor η: the complex stiffness is `k (1 + iη)`.
    Factor(f64),
}

/// Inertia of the train. Rotation `theta` always exists; a bearing along another axis adds that axis.
#[derive(Debug, Clone)]
pub struct Inertia {
    /// Node name.
    pub name: Name,
    /// Polar moment of inertia, kg·m²; zero: massless node.
    pub polar: f64,
    /// Mass, kg.
    pub mass: Option<f64>,
    /// Moment of inertia about a diameter, kg·m².
    pub diametral: Option<f64>,
}

/// Torsional shaft between two ends.
#[derive(Debug, Clone)]
pub struct Shaft {
    /// Element name.
    pub name: Name,
    /// Both ends.
    pub between: [BranchEnd; 2],
    /// Stiffness, stated or from the bar geometry; absent: rigid.
    pub body: Option<ShaftBody>,
    /// Damping of each segment.
    pub loss: BranchDamping,
}

/// Source of a shaft's stiffness.
#[derive(Debug, Clone, Copy)]
pub enum ShaftBody {
    /// Torsional stiffness, N·m/rad.
    Stiffness(f64),
    /// Round bar divided into equal segments.
    Bar {
        /// Length, m.
        length: f64,
        /// Outer diameter, m.
        outer: f64,
        /// Bore diameter, m; zero: solid bar.
        inner: f64,
        /// Shear modulus, Pa.
        shear_modulus: f64,
        /// Density, kg/m³.
        density: f64,
        /// Number of equal segments.
        segments: usize,
        /// Mass discretisation.
        mass: BarMass,
    },
}

/// Mass discretisation of a bar.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BarMass {
    /// Massless bar.
    None,
    /// Half the inertia of each segment at each of its ends.
    Lumped,
    /// Consistent mass matrix `ρIₚh/6 [[2, 1], [1, 2]]` of a linear shape function.
    Consistent,
}

/// Equal discs `name.1 … name.count` joined by equal shafts.
#[derive(Debug, Clone)]
pub struct DiscChain {
    /// Element name.
    pub name: Name,
    /// Number of discs.
    pub count: usize,
    /// Inertia of each disc, kg·m².
    pub polar: f64,
    /// Stiffness of each shaft, N·m/rad.
    pub stiffness: f64,
    /// A further equal shaft connects the first disc to ground.
    pub start_fixed: bool,
    /// A further equal shaft connects the last disc to ground.
    pub end_fixed: bool,
    /// Damping of each shaft.
    pub loss: BranchDamping,
}

/// Contact parameters of teeth or coupling halves: along the tooth normal, in N and m, or the twist, in N·m and rad.
#[derive(Debug, Clone)]
pub struct ContactParameters {
    /// Stiffness, N/m or N·m/rad; absent: rigid.
    pub stiffness: Option<f64>,
    /// Damping.
    pub loss: BranchDamping,
    /// Backlash from flank to flank, m or rad.
    pub backlash: f64,
    /// Damping law of the opening and closing contact.
    pub damping_model: Option<ContactDamping>,
    /// Relative stiffness over one mesh cycle.
    pub wave: Option<StiffnessVariation>,
    /// Nonlinear force–deflection characteristic; `stiffness` is its secant at the rated deflection.
    pub characteristic: Option<Characteristic>,
    /// Flank data computed from a gear file, in addition to `wave`.
    pub flanks: Option<MeshFlanks>,
}

impl ContactParameters {
    /// Shifts the phase of all mesh-cycle functions by `shift`, rad.
    pub fn shift_phase(&mut self, shift: f64) {
        if let Some(wave) = &mut self.wave {
            wave.phase += shift;
        }
        if let Some(flanks) = &mut self.flanks {
            flanks.phase += shift;
            if let Some(MeshSprings::ToothPairs(pairs)) = &mut flanks.springs {
                let springs = pairs.flanks.iter_mut();
                springs.for_each(|spring| spring.phase += shift);
            }
        }
    }
}

/// Transmission errors of the loaded flanks over one mesh cycle, with the load-dependent springs of the mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshFlanks {
    /// Unloaded transmission error along the branch, m, for use with the periodic mesh stiffness.
    pub unloaded_te: Waveform,
    /// Loaded transmission error less the deflection of the mean stiffness, m, for use with the averaged stiffness.
    pub averaged_te: Waveform,
    /// Common phase of both waveforms at zero gear angles, rad of the mesh cycle.
    pub phase: f64,
    /// The coast flanks carry the load.
    pub is_coast: bool,
    /// Load-dependent springs.
    pub springs: Option<MeshSprings>,
}

/// Load-dependent springs of a mesh, for methods that locate events.
#[derive(Debug, Clone, PartialEq)]
pub enum MeshSprings {
    /// One-sided springs of the tooth pairs, for a mesh with backlash.
    ToothPairs(ToothPairs),
    /// Force divided by the mean stiffness, m, as a table over deflection, m, and phase of the stiffness variation.
    LoadTable(Arc<LoadTable>),
}

/// Tooth pairs of a mesh in possible contact, spaced by one mesh cycle.
#[derive(Debug, Clone, PartialEq)]
pub struct ToothPairs {
    /// Number of tooth pairs, equal to the period of their curves in mesh cycles.
    pub count: u32,
    /// Mean number of pairs in contact: the total contact ratio.
    pub carrying: f64,
    /// Curves of a pair on the drive flanks and on the coast flanks.
    pub flanks: [PairSpring; 2],
}

/// One tooth pair as a one-sided spring.
#[derive(Debug, Clone, PartialEq)]
pub struct PairSpring {
    /// Stiffness relative to the mean mesh stiffness.
    pub stiffness: Waveform,
    /// Gap in excess of half the backlash, m.
    pub gap: Waveform,
    /// Common phase of both waveforms at zero gear angles, rad of the mesh cycle.
    pub phase: f64,
}

/// Periodic mesh stiffness, relative to the branch stiffness.
#[derive(Debug, Clone, PartialEq)]
pub struct StiffnessVariation {
    /// Factor over one mesh cycle; a mean other than 1 is allowed.
    pub waveform: Waveform,
    /// Phase of the mesh at zero gear angles, rad of the mesh cycle.
    pub phase: f64,
}

/// Workpiece of a gear generator.
#[derive(Debug)]
pub struct GeneratorWork {
    /// Bevel pair of the workpiece.
    pub bevel: BevelFile,
    /// Member being cut: 0 pinion, 1 gear.
    pub member: usize,
    /// Node of the cradle.
    pub cradle: Name,
    /// Node of the work.
    pub work: Name,
    /// Node of the cutter, if named.
    pub cutter: Option<Name>,
    /// Source span of the file name.
    pub span: SourceSpan,
}

/// Generator model or scene referenced by a gear pair.
#[derive(Debug, Clone)]
pub struct CutOn {
    /// The file.
    pub source: Arc<SourceFile>,
    /// Source span of the file name.
    pub span: SourceSpan,
}

/// Pair of spur, helical, bevel or hypoid gears, in contact along one tooth normal.
#[derive(Debug, Clone)]
pub struct GearPair {
    /// Element name.
    pub name: Name,
    /// Both gears.
    pub between: [Name; 2],
    /// Tooth numbers, both at least 1.
    pub teeth: [u32; 2],
    /// The second gear is internal.
    pub internal: bool,
    /// Normal module (at the mean point for bevel and hypoid), m; absent where only the ratio matters.
    pub module: Option<f64>,
    /// Normal pressure angle, rad.
    pub pressure_angle: f64,
    /// Helix or mean spiral angle of each gear, rad, in [0, π/2); equal but for hypoids.
    pub spiral_angles: [f64; 2],
    /// Pitch cone angle of each gear, rad; zero for parallel axes.
    pub cone_angles: [f64; 2],
    /// Hand of the first gear.
    pub hand: Hand,
    /// Angular position of the mesh about each gear axis, from x to y, rad.
    pub mesh_angles: [f64; 2],
    /// The contact.
    pub contact: ContactParameters,
    /// Dry friction of the tooth flanks.
    pub friction: Option<ToothFriction>,
    /// Gear file with the tooth geometry of the pair.
    pub gear: Option<PairMesh>,
    /// The generator on which a member of the pair is cut.
    pub cut_on: Option<CutOn>,
}

/// A worm and its wheel on crossed axes at right angles.
#[derive(Debug, Clone)]
pub struct WormPair {
    /// Element name.
    pub name: Name,
    /// Worm, wheel.
    pub between: [Name; 2],
    /// Starts of the worm, teeth of the wheel.
    pub teeth: [u32; 2],
    /// Axial module, m; absent where only the ratio matters.
    pub module: Option<f64>,
    /// Lead angle, rad.
    pub lead_angle: f64,
    /// Normal pressure angle, rad.
    pub pressure_angle: f64,
    /// Hand of the worm.
    pub hand: Hand,
    /// Coefficient of friction of the flanks; absent: no losses.
    pub friction: Option<f64>,
    /// Angular position of the mesh about the axis of each member, rad.
    pub mesh_angles: [f64; 2],
    /// The contact.
    pub contact: ContactParameters,
    /// Gear file with the tooth geometry of the pair.
    pub gear: Option<Arc<SourceFile>>,
}

/// Planetary stage. Members are nodes or ground; the stage creates its planets.
#[derive(Debug, Clone)]
pub struct Planetary {
    /// The element; its planets are `name.planet_1 …`.
    pub name: Name,
    /// Sun.
    pub sun: BranchEnd,
    /// Ring.
    pub ring: BranchEnd,
    /// Carrier.
    pub carrier: BranchEnd,
    /// Tooth numbers or base radii.
    pub size: PlanetaryGeometry,
    /// Pressure angle at the sun and at the ring, rad.
    pub pressure_angles: [f64; 2],
    /// Angular position of each planet, rad; its length is the number of planets.
    pub positions: Vec<f64>,
    /// Polar moment of inertia of one planet, kg·m².
    pub planet_polar: f64,
    /// Mass of one planet, kg.
    pub planet_mass: Option<f64>,
    /// Contact of each planet with the sun.
    pub sun_contact: ContactParameters,
    /// Contact of each planet with the ring.
    pub ring_contact: ContactParameters,
    /// Radial and tangential stiffness of one planet's bearing, N/m; absent: rigid.
    pub planet_bearing: Option<f64>,
    /// Damping of the planet bearings.
    pub bearing_loss: BranchDamping,
    /// Planets have degrees of freedom x and y in the carrier frame; so have sun, ring and carrier where supported.
    pub lateral: bool,
    /// Gear files of the sun–planet mesh and of the planet–ring mesh.
    pub gears: Option<[Arc<GearMesh>; 2]>,
}

/// Tooth numbers or base radii of a planetary stage.
#[derive(Debug, Clone, Copy)]
pub enum PlanetaryGeometry {
    /// Tooth numbers of sun, planet, ring and transverse modules, m; modules are absent where only ratios matter.
    Teeth {
        /// Sun, planet, ring.
        teeth: [u32; 3],
        /// Transverse module at the working pitch circles of the sun's and of the ring's mesh, m.
        modules: Option<[f64; 2]>,
    },
    /// Base radii of sun, planet, ring and the radius of the planets' centres, m.
    Radii {
        /// Sun, planet, ring.
        base: [f64; 3],
        /// Radius of the planet centres, m.
        carrier: f64,
    },
}

/// Belt or chain drive between two pulleys with the same sense of rotation (crossed: opposite senses).
#[derive(Debug, Clone)]
pub struct Belt {
    /// Element name.
    pub name: Name,
    /// Both pulleys.
    pub between: [Name; 2],
    /// Effective radius of each pulley, m.
    pub radii: [f64; 2],
    /// Integers in the ratio of the radii: teeth of a timing belt or chain, or radii in nm.
    pub ratio_integers: [u64; 2],
    /// The belt is crossed.
    pub crossed: bool,
    /// Stiffness of both strands together along the belt, N/m; absent: rigid.
    pub stiffness: Option<f64>,
    /// Damping.
    pub loss: BranchDamping,
}

/// Body that translates along `z` without rotation.
#[derive(Debug, Clone)]
pub struct Slide {
    /// Node name.
    pub name: Name,
    /// Mass, kg; zero: massless node.
    pub mass: f64,
}

/// Screw and nut: rotation of one translates the slide by the lead per revolution.
#[derive(Debug, Clone)]
pub struct Screw {
    /// Element name.
    pub name: Name,
    /// Rotating node and sliding node.
    pub between: [Name; 2],
    /// Lead per revolution, nm; an integer makes ratios exact.
    pub lead: u64,
    /// Hand of the thread; right: forward rotation moves the slide forward.
    pub hand: Hand,
    /// Axial contact parameters, N and m.
    pub contact: ContactParameters,
}

/// A torsional coupling.
#[derive(Debug, Clone)]
pub struct Coupling {
    /// Element name.
    pub name: Name,
    /// Both ends.
    pub between: [BranchEnd; 2],
    /// Torsional contact parameters, N·m and rad; a negative stiffness excludes the factored form. Without a stiffness the halves
    /// are rigid, or connected by the Maxwell elements alone.
    pub contact: ContactParameters,
    /// Parallel Maxwell elements, for rubber: spring, N·m/rad, in series with damper, N·m·s/rad.
    pub maxwell: Vec<[f64; 2]>,
}

/// Axis of a degree of freedom at a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Axis {
    /// Rotation about the shaft, rad.
    Theta,
    /// Lateral displacement along x, m.
    X,
    /// Lateral displacement along y, m.
    Y,
    /// Axial displacement, m.
    Z,
    /// Tilt about x, rad.
    TiltX,
    /// Tilt about y, rad.
    TiltY,
}

impl Axis {
    /// Every axis, in the order degrees of freedom are numbered at a node.
    pub const ALL: [Axis; 6] = [
        Axis::Theta,
        Axis::X,
        Axis::Y,
        Axis::Z,
        Axis::TiltX,
        Axis::TiltY,
    ];

    /// Axis name, as in `node.axis`.
    pub fn name(self) -> &'static str {
        match self {
            Axis::Theta => "theta",
            Axis::X => "x",
            Axis::Y => "y",
            Axis::Z => "z",
            Axis::TiltX => "rx",
            Axis::TiltY => "ry",
        }
    }

    /// True for a rotation; its inertia is a moment of inertia.
    pub fn is_rotation(self) -> bool {
        matches!(self, Axis::Theta | Axis::TiltX | Axis::TiltY)
    }
}

/// A bearing or support of one node against ground, or of two nodes against each other.
#[derive(Debug, Clone)]
pub struct Bearing {
    /// Element name.
    pub name: Name,
    /// Supported node and supporting end.
    pub between: [BranchEnd; 2],
    /// Stiffness `(row, column, value)`: force along the row axis for a unit displacement along the column axis, SI.
    /// Direct terms have equal axes; all others are cross-coupling terms, symmetric only if both are listed with equal values.
    pub stiffness: Vec<(Axis, Axis, f64)>,
    /// Damping in the same form.
    pub damping: Vec<(Axis, Axis, f64)>,
    /// Damping model of the stiffness, used without `damping`.
    pub loss: BranchDamping,
    /// Dry friction on the rotation.
    pub friction: Option<BearingFriction>,
}

/// Bearing friction torque `T = T₀ + μ r F`, F the radial load.
#[derive(Debug, Clone)]
pub struct BearingFriction {
    /// Friction law for a capacity of 1 N·m.
    pub law: FrictionLaw,
    /// T₀ including the friction of constant loads, N·m.
    pub constant: f64,
    /// μ r, m; zero where no force of the machine loads the bearing.
    pub coefficient: f64,
    /// Pair whose tooth force loads the bearing, with the share; absent: the support forces of the bearing.
    pub loaded_by: Option<(Name, f64)>,
}

/// A viscous damper on the rotation of a node against ground, or of two nodes against each other.
#[derive(Debug, Clone)]
pub struct Damper {
    /// Element name.
    pub name: Name,
    /// Both ends.
    pub between: [BranchEnd; 2],
    /// Viscous coefficient, N·m·s/rad.
    pub coefficient: f64,
}

/// External torque on a rotating node, or external force on a slide.
#[derive(Debug, Clone)]
pub struct Load {
    /// Node name.
    pub at: Name,
    /// True for a force, false for a torque.
    pub is_force: bool,
    /// Load over time, N·m or N.
    pub history: LoadHistory,
}

/// Motor at a node: torque–speed curve or prescribed motion.
#[derive(Debug, Clone)]
pub struct Motor {
    /// Element name.
    pub name: Name,
    /// Node name.
    pub at: Name,
    /// Motor model.
    pub drive: MotorModel,
}

/// Dry friction on the rotation of a node against ground, or of two nodes against each other.
#[derive(Debug, Clone)]
pub struct Brake {
    /// Element name.
    pub name: Name,
    /// Both ends.
    pub between: [BranchEnd; 2],
    /// Friction law, N·m and rad/s; for a clutch at its largest capacity.
    pub friction: FrictionLaw,
    /// Share of the largest capacity over time; default: 1.
    pub capacity_history: Option<LoadHistory>,
}

/// Geometric error of an element, periodic in its rotation.
#[derive(Debug, Clone)]
pub struct DeclaredError {
    /// Node of the gear, or name of the coupling, belt or screw.
    pub on: Name,
    /// Element whose meshes have the error; default: all meshes of the gear.
    pub mesh: Option<Name>,
    /// Cause of the error.
    pub cause: ErrorCause,
    /// Size of the error.
    pub size: ErrorDefinition,
    /// True for a known phase; otherwise the phases of `size` are only initial values.
    pub phase_known: bool,
    /// Relative tolerance ± of the amplitude.
    pub tolerance: f64,
}

/// Cause of an error, which determines its transfer to the line of action.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ErrorCause {
    /// Any deviation, as excess material along the line of action.
    Form,
    /// Eccentricity of the pitch circle relative to the bore: a rotating vector.
    Eccentricity,
    /// Eccentricity of the gear seat relative to the shaft: a rotating vector.
    SeatEccentricity,
    /// Run-out of the shaft relative to its bearings: a rotating vector.
    RunOut,
    /// Cumulative pitch deviations, as arcs of the pitch circle.
    CumulativePitch,
    /// Single pitch deviations, as arcs of the pitch circle.
    SinglePitch,
    /// Profile deviation, as excess material along the line of action.
    Profile,
    /// Tooth-to-tooth deviation other than pitch, as excess material along the line of action.
    ToothForm,
    /// Axial displacement of a worm.
    Axial,
    /// Angle between the axes of a coupling: two cycles per revolution.
    Misalignment,
    /// Joint of a belt: one cycle per revolution of the belt.
    BeltJoint,
    /// Lead deviation of a screw.
    Lead,
}

impl ErrorCause {
    /// All causes with their keywords.
    pub const WORDS: &'static [(&'static str, ErrorCause)] = &[
        ("form", ErrorCause::Form),
        ("eccentricity", ErrorCause::Eccentricity),
        ("seat", ErrorCause::SeatEccentricity),
        ("run-out", ErrorCause::RunOut),
        ("cumulative-pitch", ErrorCause::CumulativePitch),
        ("single-pitch", ErrorCause::SinglePitch),
        ("profile", ErrorCause::Profile),
        ("tooth-form", ErrorCause::ToothForm),
        ("axial", ErrorCause::Axial),
        ("misalignment", ErrorCause::Misalignment),
        ("belt-joint", ErrorCause::BeltJoint),
        ("lead", ErrorCause::Lead),
    ];

    /// Keyword of the cause in files.
    pub fn name(self) -> &'static str {
        let entry = ErrorCause::WORDS.iter().find(|entry| entry.1 == self);
        entry.map_or("", |entry| entry.0)
    }

    /// True for a vector that rotates with the gear.
    pub fn is_offset(self) -> bool {
        matches!(
            self,
            ErrorCause::Eccentricity | ErrorCause::SeatEccentricity | ErrorCause::RunOut
        )
    }

    /// True for pitch deviations.
    pub fn is_pitch(self) -> bool {
        matches!(self, ErrorCause::CumulativePitch | ErrorCause::SinglePitch)
    }

    /// True for an error on an element that is no gear: a coupling, a belt, a screw.
    pub fn is_on_non_gear(self) -> bool {
        matches!(
            self,
            ErrorCause::Misalignment | ErrorCause::BeltJoint | ErrorCause::Lead
        )
    }

    /// True for a deviation of one flank, independent of the opposite flank.
    pub fn is_flank_specific(self) -> bool {
        matches!(
            self,
            ErrorCause::Form | ErrorCause::Profile | ErrorCause::ToothForm
        )
    }
}

/// Size of a geometric error, m; rad for a misaligned coupling.
#[derive(Debug, Clone, PartialEq)]
pub enum ErrorDefinition {
    /// Terms `a cos(n θ + φ)` as n, a, φ, with n cycles per revolution.
    Orders(Vec<(u32, f64, f64)>),
    /// Terms n, a, φ with n cycles per tooth.
    Mesh(Vec<(u32, f64, f64)>),
    /// Equally spaced values over one revolution.
    Table(Vec<f64>),
    /// Tolerance of a grade of ISO 1328-1:1995.
    Grade {
        /// Grade, 0 to 12.
        grade: u32,
        /// Phase, rad.
        phase: f64,
    },
    /// Angle between the axes of a joint, rad.
    Tilt {
        /// Angle β, rad.
        angle: f64,
        /// Phase of the joint, rad.
        phase: f64,
    },
    /// Amplitude and length of a belt, m, and the phase of its joint, rad.
    Joint {
        /// Amplitude along the belt, m.
        amplitude: f64,
        /// Belt length, m.
        length: f64,
        /// Phase of the joint, rad of the belt revolution.
        phase: f64,
    },
    /// Equally spaced values from one end of a travel to the other.
    Travel {
        /// Lead deviations, m.
        values: Vec<f64>,
        /// Length of the travel, m.
        travel: f64,
    },
}

/// A mean speed of a node.
#[derive(Debug, Clone)]
pub struct MeanSpeed {
    /// Node name.
    pub at: Name,
    /// Mean speed, rad/s.
    pub speed: f64,
}

/// Global damping: Rayleigh coefficients and modal damping ratios.
#[derive(Debug, Clone, Default)]
pub struct GlobalDamping {
    /// Rayleigh coefficient of the mass matrix, 1/s.
    pub mass: f64,
    /// Rayleigh coefficient of the stiffness matrix, s.
    pub stiffness: f64,
    /// Damping ratio of each elastic mode in ascending order of frequency; the last ratio applies to all higher modes.
    pub modal: Vec<f64>,
    /// Default damping law of opening and closing contacts.
    pub contacts: Option<ContactDamping>,
    /// Source span.
    pub span: Option<SourceSpan>,
}

impl GlobalDamping {
    /// True if any modal damping ratio is nonzero.
    pub fn is_modal(&self) -> bool {
        self.modal.iter().any(|&zeta| zeta != 0.0)
    }
}
