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

/// A whole machine before anything is eliminated or linearised.
#[derive(Debug, Clone, Default)]
pub struct Machine {
    /// Elements named in the file, in its order.
    pub elements: Vec<Element>,
    /// Places where motion is described.
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
    /// Lasting part of the torques, N·m, by degree of freedom.
    pub loads: Vec<(usize, f64)>,
    /// The torques over time, by degree of freedom, each with its place in the file.
    pub histories: Vec<(usize, LoadHistory, SourceSpan)>,
    /// Motors that drive by speed.
    pub motors: Vec<MotorDrive>,
    /// Dry friction.
    pub friction_elements: Vec<FrictionElement>,
    /// Errors of gears, couplings, belts and screws.
    pub errors: Vec<GeometricError>,
    /// Gears, for orders of excitation.
    pub gears: Vec<Gear>,
    /// Gears of planetary stages that may carry errors in addition to `gears`: planets, and a fixed sun or ring.
    pub members: Vec<StageMember>,
    /// Mean speeds stated in the file: degree of freedom, rad/s. The first is the reference.
    pub speeds: Vec<(usize, f64)>,
    /// Damping of no element.
    pub damping: GlobalDamping,
    /// Diagnostics of the elements for the reader of a result.
    pub diagnostics: Vec<Diagnostic>,
}

/// A bearing along one axis: spring, dashpot and cross terms are branches, and what it exerts there is a sum over them.
#[derive(Debug, Clone)]
pub struct Support {
    /// The bearing.
    pub element: usize,
    /// Along or about it.
    pub axis: Axis,
    /// Relative displacement of the ends along the axis.
    pub deflection: Direction,
    /// Branches with the share of their force that acts there.
    pub forces: Vec<(usize, f64)>,
}

/// A named thing of the file.
#[derive(Debug, Clone)]
pub struct Element {
    /// Name.
    pub name: String,
    /// Table of the element: `shaft`, `gear_pair`, ….
    pub kind: &'static str,
    /// Place of the name in the file.
    pub span: SourceSpan,
}

/// A place where motion is described.
#[derive(Debug, Clone)]
pub struct Node {
    /// Name.
    pub name: String,
    /// The element that made it.
    pub element: usize,
}

/// A degree of freedom: an axis of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dof {
    /// Node.
    pub node: usize,
    /// Axis.
    pub axis: Axis,
}

/// A term `m v vᵀ` of the mass matrix.
#[derive(Debug, Clone)]
pub struct Mass {
    /// Whose it is.
    pub element: usize,
    /// kg·m² along rotations, kg along displacements.
    pub value: f64,
    /// v.
    pub direction: Direction,
}

/// A connection that resists one deformation `δ = wᵀ q`.
#[derive(Debug, Clone)]
pub struct Branch {
    /// Whose it is.
    pub element: usize,
    /// Which part of the element, where it has several.
    pub part: Option<String>,
    /// w.
    pub direction: Direction,
    /// w of the coast flank, where it differs from the drive flank's.
    pub coast: Option<Direction>,
    /// u, where the force does not act along w.
    pub force: Option<Direction>,
    /// Force law of the branch.
    pub law: BranchLaw,
    /// Play, in the unit of δ; zero: none.
    pub backlash: f64,
    /// Damping law of the contact as it opens.
    pub contact_damping: Option<ContactDamping>,
    /// Stiffness over the mesh cycle.
    pub stiffness_variation: Option<StiffnessVariation>,
    /// Force over deflection, where it is not linear; the stiffness of `law` is then its secant at the rated deflection.
    pub characteristic: Option<Characteristic>,
    /// Springs that follow the load, for methods that locate events.
    pub mesh_springs: Option<MeshSprings>,
}

/// Motor that drives a degree of freedom by its speed.
#[derive(Debug, Clone)]
pub struct MotorDrive {
    /// Whose it is.
    pub element: usize,
    /// The degree of freedom.
    pub dof: usize,
    /// Motor model.
    pub drive: MotorModel,
}

/// Dry friction along a direction.
#[derive(Debug, Clone)]
pub struct FrictionElement {
    /// Whose it is.
    pub element: usize,
    /// Direction.
    pub direction: Direction,
    /// Friction law: of a clutch at its largest capacity, of what is pressed for a capacity of one.
    pub friction: FrictionLaw,
    /// Capacity of the dry friction.
    pub grip: FrictionCapacity,
}

/// Capacity of dry friction: constant, timed or load-dependent.
#[derive(Debug, Clone)]
pub enum FrictionCapacity {
    /// Nothing: it is the same always.
    Constant,
    /// Time: shares of the largest.
    Timed(LoadHistory),
    /// Forces of the machine itself.
    Pressed(LoadDependentCapacity),
}

/// A capacity `C₀ + μ l |N|`.
#[derive(Debug, Clone)]
pub struct LoadDependentCapacity {
    /// C₀, N·m.
    pub constant: f64,
    /// μ times a lever, m; of teeth μ alone, their lever being that of the path.
    pub coefficient: f64,
    /// Components of N: forces of branches, so much of each.
    pub force_components: Vec<Vec<(usize, f64)>>,
    /// Path of the tooth contact.
    pub path: Option<ToothFrictionPath>,
}

/// Path of the tooth contact, and the effect of its friction other than on the gears' rotation against each other.
#[derive(Debug, Clone)]
pub struct ToothFrictionPath {
    /// Sliding direction at the pitch point, for drive flanks and for coast flanks.
    pub pitch_point_sliding: [Direction; 2],
    /// Levers over the mesh cycle.
    pub pieces: Vec<MeshCycleSegment>,
    /// Degree of freedom and tooth number of the mesh cycle, and its phase at zero, rad; absent: levers are constant.
    pub cycle: Option<(usize, u32, f64)>,
}

/// An error that repeats with every turn of a gear, a coupling, a belt or a screw, in some branches.
#[derive(Debug, Clone)]
pub struct GeometricError {
    /// The node or element it is declared on, with the pair where one is named.
    pub location: String,
    /// The node or element alone.
    pub element: String,
    /// Place of the declaration.
    pub span: SourceSpan,
    /// Cause of the error.
    pub cause: ErrorCause,
    /// The degree of freedom whose turn it repeats with.
    pub rotation_dof: usize,
    /// The degree of freedom that carries the mesh round.
    pub carrier: Option<usize>,
    /// Periods of the shape a turn, as a fraction: 1/1 but of belts, whose joint passes once a turn of the belt, and of screws whose
    /// error is known over a travel.
    pub periods_per_rev: (i64, i64),
    /// Branches it acts in.
    pub acts: Vec<ErrorAction>,
    /// One period, in m, of couplings in rad; positive: the driven end leads.
    pub waveform: Waveform,
    /// The same where the stiffness of its branches is averaged over their mesh cycle, if that makes a difference.
    pub averaged: Option<Waveform>,
    /// True for a known phase in the turn.
    pub phase_known: bool,
    /// Half the width of what the amplitude may be, relative to it.
    pub tolerance: f64,
    /// Assumption behind the amplitude, where a grade was given in its place.
    pub assumed: Option<String>,
}

/// Action of an error in one branch: it takes `gain · waveform(φ + phase)` from its deflection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorAction {
    /// The branch.
    pub branch: usize,
    /// On the drive flank and on the coast flank.
    pub flanks: [FlankTransfer; 2],
}

/// Transfer of an error to the line of action of a flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlankTransfer {
    /// Unit of the branch's deflection per unit of the error.
    pub gain: f64,
    /// Phase of the error in its period at the flank, rad.
    pub phase: f64,
}

/// Force–deflection law of a branch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BranchLaw {
    /// δ = 0.
    Rigid,
    /// `F = k δ + losses`.
    Linear {
        /// k, N/m or N·m/rad.
        stiffness: f64,
        /// Damping of the branch.
        loss: BranchDamping,
    },
}

/// Terms proportional to the mean speed Ω of a node.
#[derive(Debug, Clone)]
pub struct GyroscopicTerms {
    /// Whose it is.
    pub element: usize,
    /// The degree of freedom whose mean speed is Ω.
    pub turning: usize,
    /// `G[a, b] += g Ω`, `G[b, a] −= g Ω`.
    pub gyroscopic: Vec<(usize, usize, f64)>,
    /// v and m of `K −= m Ω² v vᵀ`.
    pub centripetal: Vec<(Direction, f64)>,
    /// The degree of freedom that points outwards and m r, kg·m, of a mass that a carrier takes round at the radius r.
    pub outwards: Option<(usize, f64)>,
    /// x and y of a body about the axis of a frame that turns at Ω.
    pub across: Option<[usize; 2]>,
}

/// A toothed or eccentric member that excites orders of its own rotation.
#[derive(Debug, Clone)]
pub struct Gear {
    /// The element it belongs to.
    pub element: usize,
    /// The degree of freedom it turns with.
    pub rotation_dof: usize,
    /// Number of teeth; `None` for pulleys.
    pub teeth: Option<u32>,
    /// The degree of freedom its mesh turns with relative to it: the carrier of a planetary stage.
    pub carrier: Option<usize>,
    /// The branches its teeth act in.
    pub branches: Vec<usize>,
    /// Geometry of the gear in each of its meshes; none for pulleys.
    pub seats: Vec<MeshGeometry>,
}

/// A gear of a planetary stage by its name: `stage.planet_1`, `stage.sun`, `stage.ring`.
#[derive(Debug, Clone)]
pub struct StageMember {
    /// Name.
    pub name: String,
    /// Gear; for a fixed member, the rotating part is the carrier.
    pub gear: Gear,
    /// It is fixed to ground.
    pub is_fixed: bool,
}

/// Geometry of a gear in one of its meshes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshGeometry {
    /// Angle of the mesh round the gear's axis, from its x to its y, rad.
    pub angle: f64,
    /// Deflection per displacement of the gear along x and y: on the drive flank, on the coast flank.
    pub across: [[f64; 2]; 2],
    /// Deflection per displacement along its axis, on the drive flank.
    pub along: f64,
    /// Deflection per arc ahead on the pitch circle: the lever of the tooth force over the radius of the pitch circle.
    pub lever: f64,
    /// Normal module, m, and radius of the pitch circle, m, of a pair of parallel axes; tolerances are stated for these.
    pub cylindrical: Option<[f64; 2]>,
    /// The module is given, so that lengths mean something.
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

    /// The degree of freedom called `node.axis`, or `node` for its rotation, of a slide for its travel.
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

    /// The degree of freedom is that of a slide.
    pub fn is_slide(&self, dof: usize) -> bool {
        let node = &self.nodes[self.dofs[dof].node];
        self.elements[node.element].kind == "slide"
    }

    /// Name of a branch: its element's, with the part where it has several.
    pub fn branch_name(&self, branch: usize) -> String {
        let Branch { element, part, .. } = &self.branches[branch];
        match part {
            Some(part) => format!("{} {part}", self.elements[*element].name),
            None => self.elements[*element].name.clone(),
        }
    }

    /// The support called `stem`, such as `front x`; of a bearing with one axis its name will do.
    pub fn support(&self, stem: &str) -> Option<usize> {
        let name = |s: &Support| &self.elements[s.element].name;
        let whole = |s: &Support| format!("{} {}", name(s), s.axis.name()) == stem;
        let own = |at: &usize| name(&self.supports[*at]) == stem;
        let mut alone = (0..self.supports.len()).filter(own);
        self.supports
            .iter()
            .position(whole)
            .or_else(|| match (alone.next(), alone.next()) {
                (Some(only), None) => Some(only),
                _ => None,
            })
    }

    /// Some degree of freedom is neither a rotation about a shaft nor the travel of a slide.
    pub fn is_lateral(&self) -> bool {
        let lateral = |i: usize| self.dofs[i].axis != Axis::Theta && !self.is_slide(i);
        (0..self.dofs.len()).any(lateral)
    }
}
