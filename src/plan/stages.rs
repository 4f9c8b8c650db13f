//! Stage table of a modes study: order, condition and reason of every stage.
//!
//! `geardyn plan` prints it, and the run goes through it row by row, so that what is announced is what happens.

pub use super::decision::StageDecision;
use super::prepared_machine::PreparedMachine;
use crate::base::text::pluralise;
use crate::machine::operating_point::ActiveFlank;
use crate::modes::modal_basis::{LISTED_SHAPE_TOLERANCE, UndampedSolver};
use crate::numeric::energy_modes::MIN_TREE_NODES;
use crate::scene::study::{ModesStudy, ReductionKind};

/// One stage of a study.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Meshes of gear files at their torques.
    Meshes,
    /// Rigid joints eliminated.
    Joints,
    /// Which contacts carry.
    OperatingPoint,
    /// Coordinates without inertia condensed.
    Massless,
    /// All undamped modes.
    Basis,
    /// A few undamped modes.
    Lowest,
    /// Mean speed of every shaft.
    Speeds,
    /// Complex modes.
    Complex,
    /// Energy shares.
    Energies,
    /// Sensitivities of the natural frequencies.
    Sensitivities,
    /// Modes over speed.
    Campbell,
    /// A, B, C, D.
    StateSpace,
    /// A smaller machine.
    Reduction,
}

/// A row of the table.
pub struct StageEntry {
    /// The stage.
    pub stage: Stage,
    /// Name of the stage.
    pub name: &'static str,
    /// Decides for one machine and one study.
    pub decide: fn(&PreparedMachine, &ModesStudy) -> StageDecision,
}

/// The stages in the order they run.
pub const STAGES: &[StageEntry] = &[
    StageEntry {
        stage: Stage::Meshes,
        name: "meshes",
        decide: meshes,
    },
    StageEntry {
        stage: Stage::Joints,
        name: "rigid joints",
        decide: joints,
    },
    StageEntry {
        stage: Stage::OperatingPoint,
        name: "operating point",
        decide: operating_point,
    },
    StageEntry {
        stage: Stage::Massless,
        name: "massless degrees of freedom",
        decide: massless,
    },
    StageEntry {
        stage: Stage::Basis,
        name: "undamped modes",
        decide: basis,
    },
    StageEntry {
        stage: Stage::Lowest,
        name: "few modes",
        decide: lowest,
    },
    StageEntry {
        stage: Stage::Speeds,
        name: "speeds",
        decide: speeds,
    },
    StageEntry {
        stage: Stage::Complex,
        name: "complex modes",
        decide: complex,
    },
    StageEntry {
        stage: Stage::Energies,
        name: "energies",
        decide: energies,
    },
    StageEntry {
        stage: Stage::Sensitivities,
        name: "sensitivities",
        decide: sensitivities,
    },
    StageEntry {
        stage: Stage::Campbell,
        name: "Campbell diagram",
        decide: campbell,
    },
    StageEntry {
        stage: Stage::StateSpace,
        name: "state space",
        decide: state_space,
    },
    StageEntry {
        stage: Stage::Reduction,
        name: "reduction",
        decide: reduction,
    },
];

/// The plan of one study: every stage with its verdict.
#[derive(Debug, Clone)]
pub struct ModesPlan {
    /// Stage, its name, its verdict.
    pub stages: Vec<(Stage, &'static str, StageDecision)>,
}

impl ModesPlan {
    /// Decides every stage.
    pub fn plan_modes(machine: &PreparedMachine, study: &ModesStudy) -> ModesPlan {
        let decided = |row: &StageEntry| (row.stage, row.name, (row.decide)(machine, study));
        ModesPlan {
            stages: STAGES.iter().map(decided).collect(),
        }
    }

    /// Whether a stage runs.
    pub fn runs(&self, stage: Stage) -> bool {
        self.stages
            .iter()
            .any(|(s, _, decision)| *s == stage && matches!(decision, StageDecision::Runs(_)))
    }

    /// Every stage's name with its verdict.
    pub fn rows(&self) -> impl Iterator<Item = (&str, &StageDecision)> + Clone {
        self.stages
            .iter()
            .map(|(_, name, decision)| (*name, decision))
    }
}

/// Up to this many all modes are found densely; beyond only the lowest, unless the study names a number.
pub const MAX_DENSE_DOFS: usize = 2000;

/// Number of coordinates below which a dense solution is quicker than an iteration, however few modes are requested.
const MIN_ITERATIVE_DOFS: usize = 300;

/// Default number of modes of a large machine.
pub const DEFAULT_MODE_COUNT: usize = 20;

/// The largest order whose complex modes are found all at once.
pub const MAX_COMPLEX_ORDER: usize = 1000;

/// Solver of all undamped modes: damped, gyroscopic and reduced machines are written over their shapes, which then need all digits.
pub fn undamped_solver(study: &ModesStudy) -> UndampedSolver {
    let built_on_shapes = study.damped
        || study.speed.is_some()
        || study.campbell.is_some()
        || study.state_space.is_some()
        || study.reduce.is_some();
    match built_on_shapes {
        true => UndampedSolver::Factored,
        false => UndampedSolver::Symmetric(LISTED_SHAPE_TOLERANCE),
    }
}

/// Whether only some modes are looked for, by iteration.
fn uses_iteration(machine: &PreparedMachine, study: &ModesStudy) -> bool {
    let n = machine.model.n;
    let few = study.lowest.is_some() || study.near.is_some();
    let all_needed =
        !machine.model.is_sum_of_squares() || study.state_space.is_some() || study.reduce.is_some();
    !all_needed && ((few && n > MIN_ITERATIVE_DOFS) || n > MAX_DENSE_DOFS)
}

fn meshes(machine: &PreparedMachine, _: &ModesStudy) -> StageDecision {
    machine.meshes.decision.clone()
}

fn joints(machine: &PreparedMachine, _: &ModesStudy) -> StageDecision {
    let (all, stay) = (machine.machine.dofs.len(), machine.model.n);
    match all - stay {
        0 => StageDecision::LeftOut("no rigid joint".to_string()),
        gone => StageDecision::Runs(format!(
            "{gone} of {all} degrees of freedom eliminated exactly, {stay} remain"
        )),
    }
}

fn operating_point(machine: &PreparedMachine, _: &ModesStudy) -> StageDecision {
    let contacts = machine.operating.contacts.len();
    match (contacts, machine.machine.loads.is_empty()) {
        (0, _) => match machine.operating.tangents.len() {
            0 => StageDecision::LeftOut("no contact has play".to_string()),
            n => StageDecision::Runs(format!("{n} characteristics linearised at the mean loads")),
        },
        (_, true) => StageDecision::LeftOut(format!(
            "no load is stated: {contacts} contacts with play assumed closed on their drive flanks"
        )),
        (_, false) => {
            let count = |state| {
                machine
                    .operating
                    .contacts
                    .iter()
                    .filter(|c| c.1 == state)
                    .count()
            };
            let (drive, coast) = (count(ActiveFlank::Drive), count(ActiveFlank::Coast));
            let open = count(ActiveFlank::Open);
            StageDecision::Runs(format!(
                "under the mean loads {drive} contacts with play carry on the drive flank, {coast} on the coast flank, {open} are open"
            ))
        }
    }
}

fn massless(machine: &PreparedMachine, _: &ModesStudy) -> StageDecision {
    match machine.model.massless.len() {
        0 => StageDecision::LeftOut("every degree of freedom has inertia".to_string()),
        n => StageDecision::Runs(format!(
            "{n} degrees of freedom without inertia condensed statically"
        )),
    }
}

/// Solver of the modes of a tree.
const ONE_BY_ONE: &str = "bisection and inverse iteration on the tree, one by one";

fn basis(prepared_machine: &PreparedMachine, study: &ModesStudy) -> StageDecision {
    if uses_iteration(prepared_machine, study) {
        return StageDecision::LeftOut(
            "only some modes of a large machine are requested".to_string(),
        );
    }
    let n = prepared_machine.model.n - prepared_machine.model.massless.len();
    let kind = match prepared_machine.machine.is_lateral() {
        true => "torsional and lateral",
        false => "torsional degrees of freedom only, since no bearing supports a lateral one",
    };
    StageDecision::Runs(match undamped_solver(study) {
        UndampedSolver::Factored => format!("all {n}, as singular values of √k W M^-½; {kind}"),
        UndampedSolver::Symmetric(_) => {
            let is_tree = prepared_machine
                .forest
                .as_ref()
                .is_some_and(|f| f.n_loops() == 0);
            let solver = match is_tree && n == prepared_machine.model.n && n >= MIN_TREE_NODES {
                true => ONE_BY_ONE,
                false => "the symmetric eigenproblem",
            };
            format!("all {n}, by {solver}, frequencies from energies; {kind}")
        }
    })
}

fn lowest(machine: &PreparedMachine, study: &ModesStudy) -> StageDecision {
    if !uses_iteration(machine, study) {
        return StageDecision::LeftOut("all modes are computed".to_string());
    }
    let count = study.lowest.map_or(DEFAULT_MODE_COUNT, |n| n as usize);
    let which = match study.near {
        Some(omega) => format!("{count} nearest {:.6} Hz", omega / std::f64::consts::TAU),
        None => format!("the lowest {count}"),
    };
    let solver = match &machine.forest {
        Some(forest) if forest.n_loops() == 0 && study.near.is_none() => ONE_BY_ONE.to_string(),
        Some(forest) if forest.n_loops() == 0 => "Lanczos on a tree".to_string(),
        Some(forest) => format!(
            "Lanczos on a tree with {}",
            pluralise(forest.n_loops(), "loop")
        ),
        None => "Lanczos on sparse LDLᵀ".to_string(),
    };
    StageDecision::Runs(format!(
        "{which} of {}, by {solver}, checked by a Sturm count",
        machine.model.n
    ))
}

fn speeds(machine: &PreparedMachine, study: &ModesStudy) -> StageDecision {
    if study.speed.is_none() && study.campbell.is_none() {
        return StageDecision::LeftOut("no speed is requested".to_string());
    }
    StageDecision::Runs(format!(
        "mean speed of {} nodes from exact ratios",
        machine.machine.nodes.len()
    ))
}

fn complex(machine: &PreparedMachine, study: &ModesStudy) -> StageDecision {
    let gyroscopic = study.speed.is_some() && !machine.machine.gyroscopic.is_empty();
    let damped = study.damped && machine.model.is_damped(&machine.machine);
    let mut reasons = Vec::new();
    if damped {
        reasons.push("damping");
    }
    if gyroscopic {
        reasons.push("gyroscopic terms");
    }
    if !machine.model.is_sum_of_squares() {
        reasons.push("stiffness that is negative or not symmetric");
    }
    if !reasons.is_empty() {
        let losses = match !study.damped && machine.model.is_damped(&machine.machine) {
            true => "; damping is neglected, --damped includes it",
            false => "",
        };
        return StageDecision::Runs(format!("because of {}{losses}", reasons.join(", ")));
    }
    StageDecision::LeftOut(match (study.damped, study.speed.is_some()) {
        (true, _) => "no damping".to_string(),
        (_, true) => "no spinning body tilts".to_string(),
        _ => "damping was not requested; real modes suffice".to_string(),
    })
}

fn energies(_: &PreparedMachine, _: &ModesStudy) -> StageDecision {
    StageDecision::Runs("kinetic and strain energy by element".to_string())
}

fn sensitivities(machine: &PreparedMachine, study: &ModesStudy) -> StageDecision {
    match complex(machine, study) {
        StageDecision::Runs(_) => StageDecision::LeftOut("defined for real modes only".to_string()),
        StageDecision::LeftOut(_) => {
            StageDecision::Runs("of every frequency to every element".to_string())
        }
    }
}

fn campbell(machine: &PreparedMachine, study: &ModesStudy) -> StageDecision {
    let Some(range) = study.campbell else {
        return StageDecision::LeftOut("not requested".to_string());
    };
    if machine.machine.gyroscopic.is_empty() {
        return StageDecision::Runs(
            "the modes do not change with speed: solved once, crossed with the orders".to_string(),
        );
    }
    StageDecision::Runs(format!("{} speeds, branches followed by MAC", range.count))
}

fn state_space(machine: &PreparedMachine, study: &ModesStudy) -> StageDecision {
    let Some(wanted) = &study.state_space else {
        return StageDecision::LeftOut("not requested".to_string());
    };
    if machine.model.branches.iter().any(|b| b.loss_factor != 0.0) {
        return StageDecision::Runs("refused: a loss factor has no state-space form".to_string());
    }
    let count = |names: &[String]| match names.len() {
        0 => "all".to_string(),
        n => n.to_string(),
    };
    let sampled = match wanted.sample_time {
        None => "continuous".to_string(),
        Some(h) => format!("sampled every {h} s with {} hold", wanted.method.name()),
    };
    let (inputs, outputs) = (count(&wanted.inputs), count(&wanted.outputs));
    StageDecision::Runs(format!("{sampled}, {inputs} inputs, {outputs} outputs"))
}

fn reduction(machine: &PreparedMachine, study: &ModesStudy) -> StageDecision {
    let Some(wanted) = &study.reduce else {
        return StageDecision::LeftOut("not requested".to_string());
    };
    let method = match wanted.method {
        ReductionKind::Guyan => "Guyan's condensation".to_string(),
        ReductionKind::Dynamic(hz) => format!("condensation at {hz} Hz"),
        ReductionKind::CraigBampton => "Craig–Bampton".to_string(),
        ReductionKind::Modal => "modes with a static residual".to_string(),
    };
    let n = machine.model.n;
    StageDecision::Runs(format!(
        "{method} of {n} degrees of freedom, compared with all of them up to {} Hz",
        wanted.max_frequency_hz
    ))
}
