//! Components of a machine: `M q̈ + (C + G) q̇ + Σ u_b F_b(w_bᵀ q) = f`.

use super::direction::Direction;
use crate::base::error::Diagnostic;
use crate::base::source_span::SourceSpan;
use crate::gear::cylindrical::path_of_contact::MeshCycleSegment;
use crate::scene::laws::{
    Characteristic, ContactDamping, FrictionLaw, LoadHistory, MotorModel, Waveform,
};
use crate::scene::model::{
    Axis, BranchDamping, ErrorCause, GlobalDamping, MeshSprings, StiffnessVariation,
};

/// Machine model before elimination of rigid joints and linearisation.
#[derive(Debug, Clone, Default)]
pub struct Machine {
    /// Elements named in the file, in its order.
    pub elements: Vec<Element>,
    /// Nodes, each with its axes of motion.
    pub nodes: Vec<Node>,
    /// Coordinates, grouped by node.
    pub dofs: Vec<Dof>,
    /// `M = Σ m v vᵀ`.
    pub masses: Vec<Mass>,
    /// Elastic, dissipative and rigid connections.
    pub branches: Vec<Branch>,
    /// Supports: the bearings along each of their axes.
    pub supports: Vec<Support>,
    /// Gyroscopic terms, which depend on the mean speed of a node.
    pub gyroscopic: Vec<GyroscopicTerms>,
    /// Long-term loads by degree of freedom, N·m or N.
    pub loads: Vec<(usize, f64)>,
    /// Load histories by degree of freedom, each with its source span.
    pub histories: Vec<(usize, LoadHistory, SourceSpan)>,
    /// Motors.
    pub motors: Vec<MotorDrive>,
    /// Dry friction elements.
    pub friction_elements: Vec<FrictionElement>,
    /// Errors of gears, couplings, belts and screws.
    pub errors: Vec<GeometricError>,
    /// Gears, for orders of excitation.
    pub gears: Vec<Gear>,
    /// Gears of planetary stages with errors, in addition to `gears`: planets, and a fixed sun or ring.
    pub members: Vec<StageMember>,
    /// Mean speeds stated in the file: degree of freedom, rad/s. The first is the reference.
    pub speeds: Vec<(usize, f64)>,
    /// Global damping of the machine.
    pub damping: GlobalDamping,
    /// Diagnostics of the elements, reported with the results.
    pub diagnostics: Vec<Diagnostic>,
}

/// Bearing along one axis; the support force is the sum over its branches: spring, dashpot and cross-coupling terms.
#[derive(Debug, Clone)]
pub struct Support {
    /// Index of the bearing element.
    pub element: usize,
    /// Axis of the force or moment.
    pub axis: Axis,
    /// Relative displacement of the ends along the axis.
    pub deflection: Direction,
    /// Branch indices with the share of the branch force along the axis.
    pub forces: Vec<(usize, f64)>,
}

/// Machine element named in the file.
#[derive(Debug, Clone)]
pub struct Element {
    /// Name.
    pub name: String,
    /// Table of the element: `shaft`, `gear_pair`, ….
    pub kind: &'static str,
    /// Source span of the name.
    pub span: SourceSpan,
}

/// Node of the machine, with up to six degrees of freedom.
#[derive(Debug, Clone)]
pub struct Node {
    /// Name.
    pub name: String,
    /// Index of the element of the node.
    pub element: usize,
}

/// A degree of freedom: an axis of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dof {
    /// Node index.
    pub node: usize,
    /// Axis.
    pub axis: Axis,
}

/// A term `m v vᵀ` of the mass matrix.
#[derive(Debug, Clone)]
pub struct Mass {
    /// Element index.
    pub element: usize,
    /// Moment of inertia, kg·m², for rotations; mass, kg, for displacements.
    pub value: f64,
    /// Direction v.
    pub direction: Direction,
}

/// A connection that resists one deformation `δ = wᵀ q`.
#[derive(Debug, Clone)]
pub struct Branch {
    /// Element index.
    pub element: usize,
    /// Name of the connection within its element, if the element has several.
    pub part: Option<String>,
    /// Deflection direction w.
    pub direction: Direction,
    /// Deflection direction w of the coast flank, if different from the drive flank.
    pub coast: Option<Direction>,
    /// Force direction u, if different from w.
    pub force: Option<Direction>,
    /// Force law of the branch.
    pub law: BranchLaw,
    /// Backlash, m or rad; zero: none.
    pub backlash: f64,
    /// Damping law of the opening and closing contact.
    pub contact_damping: Option<ContactDamping>,
    /// Periodic stiffness over the mesh cycle.
    pub stiffness_variation: Option<StiffnessVariation>,
    /// Nonlinear force–deflection characteristic; the stiffness of `law` is its secant at the rated deflection.
    pub characteristic: Option<Characteristic>,
    /// Load-dependent springs, for methods that locate events.
    pub mesh_springs: Option<MeshSprings>,
}

/// Motor on a degree of freedom: torque–speed curve or prescribed motion.
#[derive(Debug, Clone)]
pub struct MotorDrive {
    /// Element index.
    pub element: usize,
    /// Degree of freedom of the motor.
    pub dof: usize,
    /// Motor model.
    pub drive: MotorModel,
}

/// Dry friction along a direction.
#[derive(Debug, Clone)]
pub struct FrictionElement {
    /// Element index.
    pub element: usize,
    /// Sliding direction.
    pub direction: Direction,
    /// Friction law: of a clutch at its largest capacity, of load-dependent friction for a capacity of 1.
    pub friction: FrictionLaw,
    /// Capacity of the dry friction.
    pub capacity: FrictionCapacity,
}

/// Capacity of dry friction: constant, timed or load-dependent.
#[derive(Debug, Clone)]
pub enum FrictionCapacity {
    /// Constant capacity.
    Constant,
    /// Capacity over time, as a share of the largest.
    Timed(LoadHistory),
    /// Capacity from forces of the machine.
    Pressed(LoadDependentCapacity),
}

/// Load-dependent friction capacity `C₀ + μ l |N|`.
#[derive(Debug, Clone)]
pub struct LoadDependentCapacity {
    /// Constant capacity C₀, N·m.
    pub constant: f64,
    /// Coefficient of friction times lever μ l, m; of teeth μ alone, with the lever of the path.
    pub coefficient: f64,
    /// Components of N: branch indices with the share of their force.
    pub force_components: Vec<Vec<(usize, f64)>>,
    /// Path of the tooth contact.
    pub path: Option<ToothFrictionPath>,
}

/// Path of the tooth contact with the sliding directions and levers of its friction.
#[derive(Debug, Clone)]
pub struct ToothFrictionPath {
    /// Sliding direction at the pitch point, for drive flanks and for coast flanks.
    pub pitch_point_sliding: [Direction; 2],
    /// Segments of the mesh cycle with the friction levers.
    pub pieces: Vec<MeshCycleSegment>,
    /// Degree of freedom and tooth number of the mesh cycle, and the phase at zero, rad; absent: constant levers.
    pub cycle: Option<(usize, u32, f64)>,
}

/// Periodic geometric error of a gear, a coupling, a belt or a screw, in one or more branches.
#[derive(Debug, Clone)]
pub struct GeometricError {
    /// Node or element of the declaration, with the pair if named.
    pub location: String,
    /// Node or element of the declaration, without the pair.
    pub element: String,
    /// Source span of the declaration.
    pub span: SourceSpan,
    /// Cause of the error.
    pub cause: ErrorCause,
    /// Degree of freedom whose rotation sets the period.
    pub rotation_dof: usize,
    /// Degree of freedom of the planet carrier of the mesh.
    pub carrier: Option<usize>,
    /// Periods of the waveform per revolution, as a fraction: 1/1 except for belts, one period per belt revolution, and for screws with a
    /// table over the travel.
    pub periods_per_rev: (i64, i64),
    /// Action of the error in each branch.
    pub acts: Vec<ErrorAction>,
    /// One period of the error, m; rad for couplings; positive: the driven end leads.
    pub waveform: Waveform,
    /// Waveform for stiffness averaged over the mesh cycle, if different.
    pub averaged: Option<Waveform>,
    /// True for a known phase.
    pub phase_known: bool,
    /// Relative tolerance ± of the amplitude.
    pub tolerance: f64,
    /// Assumption behind an amplitude derived from a tolerance grade.
    pub assumed: Option<String>,
}

/// Action of a geometric error in one branch: the deflection decreases by `gain · waveform(φ + phase)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorAction {
    /// Branch index.
    pub branch: usize,
    /// Transfer to the drive flank and to the coast flank.
    pub flanks: [FlankTransfer; 2],
}

/// Transfer of an error to the line of action of a flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlankTransfer {
    /// Branch deflection per unit of error.
    pub gain: f64,
    /// Phase shift of the error at the flank, rad of the period.
    pub phase: f64,
}

/// Force–deflection law of a branch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BranchLaw {
    /// Rigid joint, δ = 0.
    Rigid,
    /// Linear spring with damping, `F = k δ + damping force`.
    Linear {
        /// Stiffness k, N/m or N·m/rad.
        stiffness: f64,
        /// Damping of the branch.
        loss: BranchDamping,
    },
}

/// Gyroscopic and centripetal terms from the mean speed Ω of a node.
#[derive(Debug, Clone)]
pub struct GyroscopicTerms {
    /// Element index.
    pub element: usize,
    /// The degree of freedom whose mean speed is Ω.
    pub spin_dof: usize,
    /// Entries a, b, g of the gyroscopic matrix: `G[a, b] += g Ω`, `G[b, a] −= g Ω`.
    pub gyroscopic: Vec<(usize, usize, f64)>,
    /// Centripetal stiffness `K −= m Ω² v vᵀ`: v and m.
    pub centripetal: Vec<(Direction, f64)>,
    /// Outward radial degree of freedom, and m r, kg·m, of a mass on a carrier at the radius r.
    pub outwards: Option<(usize, f64)>,
    /// Degrees of freedom x and y of a body on the axis of a frame rotating at Ω.
    pub across: Option<[usize; 2]>,
}

/// A toothed or eccentric member that excites orders of its own rotation.
#[derive(Debug, Clone)]
pub struct Gear {
    /// Element index.
    pub element: usize,
    /// Degree of freedom of the gear rotation.
    pub rotation_dof: usize,
    /// Number of teeth; `None` for pulleys.
    pub teeth: Option<u32>,
    /// Degree of freedom of the planet carrier that rotates the mesh position.
    pub carrier: Option<usize>,
    /// Branch indices of the tooth contacts.
    pub branches: Vec<usize>,
    /// Geometry of the gear in each of its meshes; none for pulleys.
    pub mesh_geometries: Vec<MeshGeometry>,
}

/// Gear of a planetary stage, named `stage.planet_1`, `stage.sun`, `stage.ring`.
#[derive(Debug, Clone)]
pub struct StageMember {
    /// Name.
    pub name: String,
    /// Gear; for a fixed member, the rotating part is the carrier.
    pub gear: Gear,
    /// True for a member fixed to ground.
    pub is_fixed: bool,
}

/// Geometry of a gear in one of its meshes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshGeometry {
    /// Angular position of the mesh about the gear axis, from x to y, rad.
    pub angle: f64,
    /// Deflection per unit displacement of the gear along x and y: on the drive flank, on the coast flank.
    pub across: [[f64; 2]; 2],
    /// Deflection per unit axial displacement, on the drive flank.
    pub along: f64,
    /// Deflection per unit arc of the pitch circle: lever of the tooth force divided by the pitch radius.
    pub lever: f64,
    /// Normal module, m, and pitch radius, m, of a cylindrical pair, the basis of tolerances.
    pub cylindrical: Option<[f64; 2]>,
    /// True with a given module, which defines the scale of lengths.
    pub has_module: bool,
}

impl Machine {
    /// `node.axis` of a degree of freedom.
    pub fn dof_name(&self, dof: usize) -> String {
        let Dof { node, axis } = self.dofs[dof];
        format!("{}.{}", self.nodes[node].name, axis.name())
    }

    /// Names of all degrees of freedom, `node.axis`, in their order.
    pub fn dof_names(&self) -> Vec<String> {
        (0..self.dofs.len()).map(|dof| self.dof_name(dof)).collect()
    }

    /// Degree of freedom named `node.axis`, or `node` for the rotation (of a slide the translation).
    pub fn dof(&self, name: &str) -> Option<usize> {
        let find = |node: &str, axis: &str| {
            self.dofs
                .iter()
                .position(|f| self.nodes[f.node].name == node && f.axis.name() == axis)
        };
        name.rsplit_once('.')
            .and_then(|(node, axis)| find(node, axis))
            .or_else(|| find(name, "theta"))
            .or_else(|| find(name, "z").filter(|&dof| self.is_slide(dof)))
    }

    /// True for the degree of freedom of a slide.
    pub fn is_slide(&self, dof: usize) -> bool {
        let node = &self.nodes[self.dofs[dof].node];
        self.elements[node.element].kind == "slide"
    }

    /// Branch name: element name, followed by the connection name if the element has several.
    pub fn branch_name(&self, branch: usize) -> String {
        let Branch { element, part, .. } = &self.branches[branch];
        match part {
            Some(part) => format!("{} {part}", self.elements[*element].name),
            None => self.elements[*element].name.clone(),
        }
    }

    /// Index of the support named `stem`, such as `front x`; the bearing name suffices for a bearing with one axis.
    pub fn support(&self, stem: &str) -> Option<usize> {
        let name = |s: &Support| &self.elements[s.element].name;
        let matches_axis = |s: &Support| format!("{} {}", name(s), s.axis.name()) == stem;
        let matches_bearing = |index: &usize| name(&self.supports[*index]) == stem;
        let mut candidates = (0..self.supports.len()).filter(matches_bearing);
        self.supports.iter().position(matches_axis).or_else(|| {
            match (candidates.next(), candidates.next()) {
                (Some(index), None) => Some(index),
                _ => None,
            }
        })
    }

    /// True if any degree of freedom is neither a shaft rotation nor the translation of a slide.
    pub fn is_lateral(&self) -> bool {
        let lateral = |i: usize| self.dofs[i].axis != Axis::Theta && !self.is_slide(i);
        (0..self.dofs.len()).any(lateral)
    }
}
