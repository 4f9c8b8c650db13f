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

/// A whole model file, read and checked value by value. Nothing is assembled yet.
#[derive(Debug, Clone, Default)]
pub struct Model {
    /// Title of the machine, in one line; of a scene with a title of its own, that.
    pub title: String,
    /// Who published the numbers, or how they were estimated.
    pub source: String,
    /// Bodies; each one's name is its node.
    pub inertias: Vec<Inertia>,
    /// Shaft lengths.
    pub shafts: Vec<Shaft>,
    /// Rows of equal discs on equal shafts.
    pub chains: Vec<DiscChain>,
    /// Spur, helical, bevel and hypoid pairs.
    pub gear_pairs: Vec<GearPair>,
    /// Worm pairs.
    pub worm_pairs: Vec<WormPair>,
    /// Planetary stages.
    pub planetaries: Vec<Planetary>,
    /// Belt and chain drives.
    pub belts: Vec<Belt>,
    /// Bodies that screws move along.
    pub slides: Vec<Slide>,
    /// Screws and their nuts.
    pub screws: Vec<Screw>,
    /// Couplings.
    pub couplings: Vec<Coupling>,
    /// Bearings and supports.
    pub bearings: Vec<Bearing>,
    /// Dampers.
    pub dampers: Vec<Damper>,
    /// Torques on nodes; what lasts of them holds the contacts on one flank.
    pub loads: Vec<Load>,
    /// Motors that drive nodes by their speed.
    pub motors: Vec<Motor>,
    /// Dry friction between nodes.
    pub brakes: Vec<Brake>,
    /// Errors of gears, couplings, belts and screws.
    pub errors: Vec<DeclaredError>,
    /// Damping of the whole machine.
    pub damping: GlobalDamping,
    /// Mean speeds of named nodes, the first being the one `--speed` refers to.
    pub speeds: Vec<MeanSpeed>,
    /// Work that the machine cuts, where it is a generator.
    pub work: Option<Arc<GeneratorWork>>,
}

impl Model {
    /// Meshes that name a gear file, with the names of their elements and their contacts.
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

    /// The gear files, the generators that cut them and files of chips, each once.
    pub fn gear_files(&self) -> Vec<Arc<SourceFile>> {
        let mut all: Vec<Arc<SourceFile>> = Vec::new();
        for (_, mesh, _) in self.gear_meshes() {
            let source = &mesh.file().source;
            if !all.contains(source) {
                all.push(source.clone());
            }
        }
        let generators = self.gear_pairs.iter().filter_map(|p| p.cut_on.as_ref());
        let work = self.work.iter().map(|work| &work.bevel.source);
        let chips = self.loads.iter().filter_map(|load| load.history.chips());
        let worms = self.worm_pairs.iter().filter_map(|pair| pair.gear.as_ref());
        let generators = generators.map(|cut| &cut.source);
        for source in generators.chain(worms).chain(work).chain(chips) {
            if !all.contains(source) {
                all.push(source.clone());
            }
        }
        all
    }
}

/// Name and its place in the file.
#[derive(Debug, Clone)]
pub struct Name {
    /// The name as written.
    pub text: String,
    /// Place in the file.
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
    /// Not at all.
    #[default]
    None,
    /// Viscous coefficient, in the unit of the branch's stiffness times second.
    Viscous(f64),
    /// Damping ratio ζ: `c = 2ζ√(k mₑ)`, `mₑ = 1/(wᵀM⁻¹w)`.
    Ratio(f64),
    /// Loss factor η: the complex stiffness is `k (1 + iη)`.
    Factor(f64),
}

/// An inertia of the train. Its rotation `theta` always exists; other axes only where a bearing gives it one.
#[derive(Debug, Clone)]
pub struct Inertia {
    /// The node.
    pub name: Name,
    /// Moment of inertia about its own axis, kg·m²; zero is a massless node.
    pub polar: f64,
    /// Mass, kg.
    pub mass: Option<f64>,
    /// Moment of inertia about a diameter, kg·m².
    pub diametral: Option<f64>,
}

/// A shaft length between two ends.
#[derive(Debug, Clone)]
pub struct Shaft {
    /// The element.
    pub name: Name,
    /// Both ends.
    pub between: [BranchEnd; 2],
    /// Stiffness given or from geometry; absent: rigid.
    pub body: Option<ShaftBody>,
    /// Losses of each length.
    pub loss: BranchDamping,
}

/// Source of a shaft's stiffness.
#[derive(Debug, Clone, Copy)]
pub enum ShaftBody {
    /// Torsional stiffness, N·m/rad.
    Stiffness(f64),
    /// A round bar cut in equal lengths.
    Bar {
        /// Length, m.
        length: f64,
        /// Outer diameter, m.
        outer: f64,
        /// Bore, m; zero where solid.
        inner: f64,
        /// Shear modulus, Pa.
        shear_modulus: f64,
        /// Density, kg/m³.
        density: f64,
        /// Number of equal lengths it is cut into.
        segments: usize,
        /// Treatment of its own inertia.
        mass: BarMass,
    },
}

/// Treatment of the inertia of a bar.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BarMass {
    /// Not at all.
    None,
    /// Half of each length at each of its ends.
    Lumped,
    /// `ρIₚh/6 [[2, 1], [1, 2]]`, the exact kinetic energy of a linear shape.
    Consistent,
}

/// Equal discs `name.1 … name.count` joined by equal shafts.
#[derive(Debug, Clone)]
pub struct DiscChain {
    /// The element.
    pub name: Name,
    /// Number of discs.
    pub count: usize,
    /// Inertia of each disc, kg·m².
    pub polar: f64,
    /// Stiffness of each shaft, N·m/rad.
    pub stiffness: f64,
    /// One more equal shaft from the first disc to ground.
    pub start_fixed: bool,
    /// One more equal shaft from the last disc to ground.
    pub end_fixed: bool,
    /// Losses of each shaft.
    pub loss: BranchDamping,
}

/// Contact parameters of teeth or coupling halves: along the tooth normal, in N and m, or the twist, in N·m and rad.
#[derive(Debug, Clone)]
pub struct ContactParameters {
    /// Stiffness; absent: rigid.
    pub stiffness: Option<f64>,
    /// Losses.
    pub loss: BranchDamping,
    /// Play, flank to flank.
    pub backlash: f64,
    /// Damping law of the contact as it opens.
    pub damping_model: Option<ContactDamping>,
    /// The stiffness over one mesh cycle, as a factor.
    pub wave: Option<StiffnessVariation>,
    /// Force over deflection, where it is not linear; `stiffness` is then its secant at the rated deflection.
    pub characteristic: Option<Characteristic>,
    /// Flanks as computed from a gear file, next to `wave`.
    pub flanks: Option<MeshFlanks>,
}

impl ContactParameters {
    /// Shifts the phase of all that goes by the mesh cycle, rad.
    pub fn shift_phase(&mut self, by: f64) {
        if let Some(wave) = &mut self.wave {
            wave.phase += by;
        }
        if let Some(flanks) = &mut self.flanks {
            flanks.phase += by;
            if let Some(MeshSprings::ToothPairs(pairs)) = &mut flanks.springs {
                let springs = pairs.flanks.iter_mut();
                springs.for_each(|spring| spring.phase += by);
            }
        }
    }
}

/// Transmission error of the flanks that carry, over one mesh cycle, and what motions take in place of one spring.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshFlanks {
    /// Transmission error without load along the branch, m: with the stiffness over the cycle it gives that under load.
    pub unloaded_te: Waveform,
    /// Transmission error under load beyond what the mean stiffness gives way, m: for a stiffness that is averaged.
    pub averaged_te: Waveform,
    /// Phase of both at zero gear angles, rad of the mesh cycle.
    pub phase: f64,
    /// The coast flanks carry.
    pub is_coast: bool,
    /// Springs that follow the load.
    pub springs: Option<MeshSprings>,
}

/// Springs of a mesh whose force follows the load, for methods that locate events.
#[derive(Debug, Clone, PartialEq)]
pub enum MeshSprings {
    /// One-sided springs of the tooth pairs, where there is play.
    ToothPairs(ToothPairs),
    /// Force over the mean stiffness, m, over the deflection, m, by the phase of the stiffness variation.
    LoadTable(Arc<LoadTable>),
}

/// The tooth pairs of a mesh that can touch, one behind the other by a mesh cycle.
#[derive(Debug, Clone, PartialEq)]
pub struct ToothPairs {
    /// Number of pairs; the curves of each have a period of so many mesh cycles.
    pub count: u32,
    /// Pairs that carry in the mean: the total contact ratio.
    pub carrying: f64,
    /// Curves of a pair on the drive flanks and on the coast flanks.
    pub flanks: [PairSpring; 2],
}

/// One tooth pair as a one-sided spring.
#[derive(Debug, Clone, PartialEq)]
pub struct PairSpring {
    /// Stiffness as a factor of the mean stiffness of the mesh.
    pub stiffness: Waveform,
    /// Gap beyond half the play, m.
    pub gap: Waveform,
    /// Phase of both at zero gear angles, rad of the mesh cycle.
    pub phase: f64,
}

/// Stiffness of a mesh over its cycle, as a factor.
#[derive(Debug, Clone, PartialEq)]
pub struct StiffnessVariation {
    /// One mesh cycle; its mean need not be one.
    pub waveform: Waveform,
    /// Phase of the mesh at zero gear angles, rad of the mesh cycle.
    pub phase: f64,
}

/// Work of a generator.
#[derive(Debug)]
pub struct GeneratorWork {
    /// The pair of which it cuts a member.
    pub bevel: BevelFile,
    /// The member that is cut: 0 pinion, 1 gear.
    pub member: usize,
    /// Node of the cradle.
    pub cradle: Name,
    /// Node of the work.
    pub work: Name,
    /// Node of the cutter, where it is named.
    pub cutter: Option<Name>,
    /// Place of the file's name.
    pub span: SourceSpan,
}

/// The model or scene of a generator that a pair names.
#[derive(Debug, Clone)]
pub struct CutOn {
    /// The file.
    pub source: Arc<SourceFile>,
    /// Place of its name.
    pub span: SourceSpan,
}

/// A pair of spur, helical, bevel or hypoid gears; all are one direction in space.
#[derive(Debug, Clone)]
pub struct GearPair {
    /// The element.
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
    /// Angle of the mesh round each gear's axis, from its x to its y, rad.
    pub mesh_angles: [f64; 2],
    /// The contact.
    pub contact: ContactParameters,
    /// Dry friction along the teeth.
    pub friction: Option<ToothFriction>,
    /// The gear file that the pair follows.
    pub gear: Option<PairMesh>,
    /// The generator on which a member of the pair is cut.
    pub cut_on: Option<CutOn>,
}

/// A worm and its wheel on crossed axes at right angles.
#[derive(Debug, Clone)]
pub struct WormPair {
    /// The element.
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
    /// Angle of the mesh round each member's axis, rad.
    pub mesh_angles: [f64; 2],
    /// The contact.
    pub contact: ContactParameters,
    /// The gear file that determines it.
    pub gear: Option<Arc<SourceFile>>,
}

/// A planetary stage. Members are nodes or ground; planets are made by the stage.
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
    /// Radii.
    pub size: PlanetaryGeometry,
    /// Pressure angle at the sun and at the ring, rad.
    pub pressure_angles: [f64; 2],
    /// Angular position of each planet, rad; its length is the number of planets.
    pub positions: Vec<f64>,
    /// Inertia of one planet about its own axis, kg·m².
    pub planet_polar: f64,
    /// Mass of one planet, kg.
    pub planet_mass: Option<f64>,
    /// Contact of each planet with the sun.
    pub sun_contact: ContactParameters,
    /// Contact of each planet with the ring.
    pub ring_contact: ContactParameters,
    /// Radial and tangential stiffness of one planet's bearing, N/m; absent: rigid.
    pub planet_bearing: Option<f64>,
    /// Losses of the planets' bearings.
    pub bearing_loss: BranchDamping,
    /// Planets move along x and y too, described in the carrier's frame, as do sun, ring and carrier where supported.
    pub lateral: bool,
    /// Gear files of sun and planet and of planet and ring that the stage follows.
    pub gears: Option<[Arc<GearMesh>; 2]>,
}

/// Radii of a planetary stage.
#[derive(Debug, Clone, Copy)]
pub enum PlanetaryGeometry {
    /// Tooth numbers of sun, planet, ring and the modules in the transverse plane, m; these are absent where only ratios matter.
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
        /// Radius of the planets' centres.
        carrier: f64,
    },
}

/// A belt or a chain between two pulleys turning the same way (crossed: opposite ways).
#[derive(Debug, Clone)]
pub struct Belt {
    /// The element.
    pub name: Name,
    /// Both pulleys.
    pub between: [Name; 2],
    /// Effective radius of each pulley, m.
    pub radii: [f64; 2],
    /// Whole numbers in the ratio of the radii: teeth of a timing belt or chain, or radii in nanometres.
    pub ratio_integers: [u64; 2],
    /// The belt is crossed.
    pub crossed: bool,
    /// Stiffness of both strands together along the belt, N/m; absent: rigid.
    pub stiffness: Option<f64>,
    /// Losses.
    pub loss: BranchDamping,
}

/// A body that moves along `z` and does not turn.
#[derive(Debug, Clone)]
pub struct Slide {
    /// The node.
    pub name: Name,
    /// Mass, kg; zero is a massless node.
    pub mass: f64,
}

/// A screw and its nut: one of them turns, the other, or what carries it, slides by the lead a turn.
#[derive(Debug, Clone)]
pub struct Screw {
    /// The element.
    pub name: Name,
    /// Rotating node and sliding node.
    pub between: [Name; 2],
    /// Travel a turn, nm: a whole number, so that ratios stay exact.
    pub lead: u64,
    /// Right: the slide goes forward while the screw turns forward.
    pub hand: Hand,
    /// Along the axis, N/m.
    pub contact: ContactParameters,
}

/// A torsional coupling.
#[derive(Debug, Clone)]
pub struct Coupling {
    /// The element.
    pub name: Name,
    /// Both ends.
    pub between: [BranchEnd; 2],
    /// Along the twist, N·m/rad and rad; a negative stiffness leaves the factored form. Without one the halves are rigid,
    /// or, where there are Maxwell elements, joined by these alone.
    pub contact: ContactParameters,
    /// Springs and dampers in series next to it, as rubber has them: N·m/rad, N·m·s/rad.
    pub maxwell: Vec<[f64; 2]>,
}

/// Axes of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Axis {
    /// Rotation about the shaft, rad.
    Theta,
    /// Across the shaft, m.
    X,
    /// Across the shaft, m.
    Y,
    /// Along the shaft, m.
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

    /// The word for it in `node.axis`.
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

    /// A rotation, so that its inertia is a moment of inertia.
    pub fn is_rotation(self) -> bool {
        matches!(self, Axis::Theta | Axis::TiltX | Axis::TiltY)
    }
}

/// A bearing or support of one node against ground, or of two nodes against each other.
#[derive(Debug, Clone)]
pub struct Bearing {
    /// The element.
    pub name: Name,
    /// Node, and the end that supports it.
    pub between: [BranchEnd; 2],
    /// Stiffness `(row, column, value)`: force along the row axis for a unit displacement along the column axis, SI.
    /// Direct terms have both axes equal; the rest are cross terms, symmetric only if both are listed equal.
    pub stiffness: Vec<(Axis, Axis, f64)>,
    /// Damping in the same form.
    pub damping: Vec<(Axis, Axis, f64)>,
    /// Losses of its stiffness, where no damping is given.
    pub loss: BranchDamping,
    /// Dry friction on the rotation.
    pub friction: Option<BearingFriction>,
}

/// Friction of a bearing: `T = T₀ + μ r F`, F its radial load.
#[derive(Debug, Clone)]
pub struct BearingFriction {
    /// For a capacity of one N·m.
    pub law: FrictionLaw,
    /// T₀ with what constant loads add, N·m.
    pub constant: f64,
    /// μ r, m; zero where nothing of the machine's own forces loads it.
    pub coefficient: f64,
    /// The pair whose tooth force loads it, and the share it takes; its own forces where absent.
    pub loaded_by: Option<(Name, f64)>,
}

/// A viscous damper on the rotation of a node against ground, or of two nodes against each other.
#[derive(Debug, Clone)]
pub struct Damper {
    /// The element.
    pub name: Name,
    /// Both ends.
    pub between: [BranchEnd; 2],
    /// N·m·s/rad.
    pub coefficient: f64,
}

/// A torque on a node that turns, or a force on one that slides.
#[derive(Debug, Clone)]
pub struct Load {
    /// The node.
    pub at: Name,
    /// It is a force.
    pub is_force: bool,
    /// N·m or N over time.
    pub history: LoadHistory,
}

/// Motor that drives a node by its speed.
#[derive(Debug, Clone)]
pub struct Motor {
    /// The element.
    pub name: Name,
    /// The node.
    pub at: Name,
    /// Motor model.
    pub drive: MotorModel,
}

/// Dry friction on the rotation of a node against ground, or of two nodes against each other.
#[derive(Debug, Clone)]
pub struct Brake {
    /// The element.
    pub name: Name,
    /// Both ends.
    pub between: [BranchEnd; 2],
    /// N·m and rad/s; of a clutch at its largest capacity.
    pub friction: FrictionLaw,
    /// The share of that capacity over time, s; always all of it by default.
    pub capacity_history: Option<LoadHistory>,
}

/// An error of an element that repeats with its turn.
#[derive(Debug, Clone)]
pub struct DeclaredError {
    /// A gear's node; a coupling, a belt or a screw.
    pub on: Name,
    /// Only in this element's meshes; in all of the gear's by default.
    pub mesh: Option<Name>,
    /// Cause of the error.
    pub cause: ErrorCause,
    /// Size of the error.
    pub size: ErrorDefinition,
    /// True for a known phase in the turn; else the phases of `size` are no more than initial values.
    pub phase_known: bool,
    /// Half the width of what the amplitude may be, relative to it.
    pub tolerance: f64,
}

/// Cause of an error, which determines its transfer to the line of action.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ErrorCause {
    /// Anything, as surplus along the line of action.
    Form,
    /// The gear's pitch circle next to its bore: a vector that turns with it.
    Eccentricity,
    /// The gear's seat next to its shaft: a vector that turns with it.
    SeatEccentricity,
    /// The shaft next to its bearings: a vector that turns with it.
    RunOut,
    /// Pitch deviations added up, as arcs of the pitch circle.
    CumulativePitch,
    /// Pitch deviations one by one, as arcs of the pitch circle.
    SinglePitch,
    /// Profiles, as surplus along the line of action.
    Profile,
    /// Tooth-to-tooth deviation other than pitch, as surplus along the line of action.
    ToothForm,
    /// A worm moves along its axis.
    Axial,
    /// The axes of a coupling's ends, not in line: two cycles a turn.
    Misalignment,
    /// The joint of a belt, once a turn of the belt.
    BeltJoint,
    /// The lead of a screw.
    Lead,
}

impl ErrorCause {
    /// Every cause by its word.
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

    /// The word for it in files.
    pub fn name(self) -> &'static str {
        let word = ErrorCause::WORDS.iter().find(|word| word.1 == self);
        word.map_or("", |word| word.0)
    }

    /// A vector that turns with the gear.
    pub fn is_offset(self) -> bool {
        matches!(
            self,
            ErrorCause::Eccentricity | ErrorCause::SeatEccentricity | ErrorCause::RunOut
        )
    }

    /// Teeth out of their places round the gear.
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

    /// Too much or too little material on a flank, so that the other flank has its own.
    pub fn is_flank_specific(self) -> bool {
        matches!(
            self,
            ErrorCause::Form | ErrorCause::Profile | ErrorCause::ToothForm
        )
    }
}

/// Size of an error: in m, of a misaligned coupling in rad.
#[derive(Debug, Clone, PartialEq)]
pub enum ErrorDefinition {
    /// n, a, φ of `a cos(n θ + φ)`, n cycles a turn.
    Orders(Vec<(u32, f64, f64)>),
    /// The same, n cycles a tooth.
    Mesh(Vec<(u32, f64, f64)>),
    /// Equally spaced values over one turn.
    Table(Vec<f64>),
    /// Tolerance of a grade of ISO 1328-1:1995.
    Grade {
        /// 0 to 12.
        grade: u32,
        /// rad.
        phase: f64,
    },
    /// Angle between the axes of a joint, rad.
    Tilt {
        /// rad.
        angle: f64,
        /// Phase of the joint, rad.
        phase: f64,
    },
    /// Amplitude and length of a belt, m, and the phase of its joint, rad.
    Joint {
        /// m along the belt.
        amplitude: f64,
        /// m.
        length: f64,
        /// rad of the belt's turn.
        phase: f64,
    },
    /// Equally spaced values from one end of a travel to the other.
    Travel {
        /// m.
        values: Vec<f64>,
        /// m.
        travel: f64,
    },
}

/// A mean speed of a node.
#[derive(Debug, Clone)]
pub struct MeanSpeed {
    /// The node.
    pub at: Name,
    /// rad/s.
    pub speed: f64,
}

/// Damping that belongs to no element.
#[derive(Debug, Clone, Default)]
pub struct GlobalDamping {
    /// Rayleigh's mass-proportional part, 1/s.
    pub mass: f64,
    /// Rayleigh's stiffness-proportional part, s.
    pub stiffness: f64,
    /// Damping ratio of each elastic mode in rising order; the last one holds for all above.
    pub modal: Vec<f64>,
    /// Damping law of open contacts, by default for every element.
    pub contacts: Option<ContactDamping>,
    /// Place in the file.
    pub span: Option<SourceSpan>,
}

impl GlobalDamping {
    /// Some mode has a damping ratio of its own.
    pub fn is_modal(&self) -> bool {
        self.modal.iter().any(|&zeta| zeta != 0.0)
    }
}
