//! The table of stages of a study of modes: what each is, when it runs, when it is left out and why.
//!
//! `geardyn plan` prints it, and the run goes through it row by row, so that what is announced is what happens.

use super::prepared::Prepared;
use crate::machine::operating::ContactState;
use crate::modes::basis::Solver;
use crate::scene::study::{ModesStudy, ReduceMethod};

/// One stage of a study.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
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
    /// What frequencies depend on.
    Sensitivities,
    /// Modes over speed.
    Campbell,
    /// A, B, C, D.
    StateSpace,
    /// A smaller machine.
    Reduction,
}

/// Whether a stage runs, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// It runs: what it will do.
    Runs(String),
    /// It is left out: why.
    LeftOut(String),
}

/// A row of the table.
pub struct Row {
    /// The stage.
    pub stage: Stage,
    /// Its name.
    pub name: &'static str,
    /// Decides for one machine and one study.
    pub decide: fn(&Prepared, &ModesStudy) -> Verdict,
}

/// The stages in the order they run.
pub const STAGES: &[Row] = &[
    Row {
        stage: Stage::Joints,
        name: "rigid joints",
        decide: joints,
    },
    Row {
        stage: Stage::OperatingPoint,
        name: "operating point",
        decide: operating_point,
    },
    Row {
        stage: Stage::Massless,
        name: "massless freedoms",
        decide: massless,
    },
    Row {
        stage: Stage::Basis,
        name: "undamped modes",
        decide: basis,
    },
    Row {
        stage: Stage::Lowest,
        name: "few modes",
        decide: lowest,
    },
    Row {
        stage: Stage::Speeds,
        name: "speeds",
        decide: speeds,
    },
    Row {
        stage: Stage::Complex,
        name: "complex modes",
        decide: complex,
    },
    Row {
        stage: Stage::Energies,
        name: "energies",
        decide: energies,
    },
    Row {
        stage: Stage::Sensitivities,
        name: "sensitivities",
        decide: sensitivities,
    },
    Row {
        stage: Stage::Campbell,
        name: "Campbell diagram",
        decide: campbell,
    },
    Row {
        stage: Stage::StateSpace,
        name: "state space",
        decide: state_space,
    },
    Row {
        stage: Stage::Reduction,
        name: "reduction",
        decide: reduction,
    },
];

/// The plan of one study: every stage with its verdict.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Stage, its name, its verdict.
    pub steps: Vec<(Stage, &'static str, Verdict)>,
}

impl Plan {
    /// Decides every stage.
    pub fn modes(prepared: &Prepared, study: &ModesStudy) -> Plan {
        let decided = |row: &Row| (row.stage, row.name, (row.decide)(prepared, study));
        Plan {
            steps: STAGES.iter().map(decided).collect(),
        }
    }

    /// Whether a stage runs.
    pub fn runs(&self, stage: Stage) -> bool {
        self.steps
            .iter()
            .any(|(s, _, verdict)| *s == stage && matches!(verdict, Verdict::Runs(_)))
    }

    /// Every stage's name with its verdict.
    pub fn rows(&self) -> impl Iterator<Item = (&str, &Verdict)> + Clone {
        self.steps.iter().map(|(_, name, verdict)| (*name, verdict))
    }
}

/// Up to this many coordinates all modes come from the factored form at once: below a tenth of a second.
const FACTORED: usize = 200;

/// Up to this many all modes are found densely; beyond only the lowest, unless the study names a number.
pub const DENSE: usize = 2000;

/// Below this many coordinates a dense solution is quicker than an iteration, however few modes are asked.
const SMALL: usize = 300;

/// How many modes a large machine shows where the study names no number.
pub const USUAL: usize = 20;

/// The largest order whose complex modes are found all at once.
pub const COMPLEX: usize = 1000;

/// The solver of all undamped modes at first; digits may ask for the factored form afterwards.
pub fn solver(n: usize) -> Solver {
    if n <= FACTORED {
        Solver::Factored
    } else {
        Solver::Singular
    }
}

/// Whether only some modes are looked for, by iteration.
fn iterates(prepared: &Prepared, study: &ModesStudy) -> bool {
    let n = prepared.linear.n;
    let few = study.lowest.is_some() || study.near.is_some();
    let all_needed = !prepared.linear.is_sum_of_squares()
        || study.state_space.is_some()
        || study.reduce.is_some();
    !all_needed && ((few && n > SMALL) || n > DENSE)
}

fn joints(prepared: &Prepared, _: &ModesStudy) -> Verdict {
    let (all, stay) = (prepared.machine.freedoms.len(), prepared.linear.n);
    match all - stay {
        0 => Verdict::LeftOut("no rigid joint".to_string()),
        gone => Verdict::Runs(format!(
            "{gone} of {all} freedoms follow exactly, {stay} stay"
        )),
    }
}

fn operating_point(prepared: &Prepared, _: &ModesStudy) -> Verdict {
    let contacts = prepared.operating.contacts.len();
    match (contacts, prepared.machine.loads.is_empty()) {
        (0, _) => match prepared.operating.tangents.len() {
            0 => Verdict::LeftOut("no contact has play".to_string()),
            n => Verdict::Runs(format!(
                "{n} characteristics by their tangents under the mean loads"
            )),
        },
        (_, true) => Verdict::LeftOut(format!(
            "no load is stated: {contacts} contacts with play stand on their drive flanks"
        )),
        (_, false) => {
            let count = |state| {
                prepared
                    .operating
                    .contacts
                    .iter()
                    .filter(|c| c.1 == state)
                    .count()
            };
            let (drive, coast) = (count(ContactState::Drive), count(ContactState::Coast));
            let open = count(ContactState::Open);
            Verdict::Runs(format!(
                "under the mean loads {drive} contacts with play carry on the drive flank, {coast} on the coast flank, {open} stand open"
            ))
        }
    }
}

fn massless(prepared: &Prepared, _: &ModesStudy) -> Verdict {
    match prepared.linear.massless.len() {
        0 => Verdict::LeftOut("every freedom has inertia".to_string()),
        n => Verdict::Runs(format!("{n} freedoms without inertia follow statically")),
    }
}

fn basis(prepared: &Prepared, study: &ModesStudy) -> Verdict {
    if iterates(prepared, study) {
        return Verdict::LeftOut("only some modes are asked of a large machine".to_string());
    }
    let n = prepared.linear.n - prepared.linear.massless.len();
    let kind = match prepared.machine.is_lateral() {
        true => "torsional and lateral",
        false => "torsional freedoms only, since no bearing supports a lateral one",
    };
    Verdict::Runs(match solver(n) {
        Solver::Factored => format!("all {n}, as singular values of √k W M^-½; {kind}"),
        Solver::Singular => format!(
            "all {n}, as singular values of √k W M^-½ by bidiagonal reduction, in graded form where that leaves too few digits; {kind}"
        ),
    })
}

fn lowest(prepared: &Prepared, study: &ModesStudy) -> Verdict {
    if !iterates(prepared, study) {
        return Verdict::LeftOut("all modes are found at once".to_string());
    }
    let count = study.lowest.map_or(USUAL, |n| n as usize);
    let which = match study.near {
        Some(omega) => format!("{count} nearest {:.6} Hz", omega / std::f64::consts::TAU),
        None => format!("the lowest {count}"),
    };
    let how = match &prepared.forest {
        Some(forest) if forest.loops() == 0 => "a tree eliminated without subtraction".to_string(),
        Some(forest) => format!("a tree with {} loops", forest.loops()),
        None => "sparse LDLᵀ".to_string(),
    };
    Verdict::Runs(format!(
        "{which} of {}, by Lanczos on {how}, checked by a Sturm count",
        prepared.linear.n
    ))
}

fn speeds(prepared: &Prepared, study: &ModesStudy) -> Verdict {
    if study.speed.is_none() && study.campbell.is_none() {
        return Verdict::LeftOut("no speed is asked for".to_string());
    }
    Verdict::Runs(format!(
        "mean speed of {} nodes from exact ratios",
        prepared.machine.nodes.len()
    ))
}

fn complex(prepared: &Prepared, study: &ModesStudy) -> Verdict {
    let gyroscopic = study.speed.is_some() && !prepared.machine.spins.is_empty();
    let damped = study.damped && prepared.linear.is_damped(&prepared.machine);
    let mut reasons = Vec::new();
    if damped {
        reasons.push("damping");
    }
    if gyroscopic {
        reasons.push("gyroscopic terms");
    }
    if !prepared.linear.is_sum_of_squares() {
        reasons.push("stiffness that is negative or not symmetric");
    }
    if !reasons.is_empty() {
        let losses = match !study.damped && prepared.linear.is_damped(&prepared.machine) {
            true => "; losses are not counted, --damped counts them",
            false => "",
        };
        return Verdict::Runs(format!("because of {}{losses}", reasons.join(", ")));
    }
    Verdict::LeftOut(match (study.damped, study.speed.is_some()) {
        (true, _) => "nothing damps".to_string(),
        (_, true) => "nothing tilts while it spins".to_string(),
        _ => "damping was not asked for; real modes suffice".to_string(),
    })
}

fn energies(_: &Prepared, _: &ModesStudy) -> Verdict {
    Verdict::Runs("kinetic and strain energy by element".to_string())
}

fn sensitivities(prepared: &Prepared, study: &ModesStudy) -> Verdict {
    match complex(prepared, study) {
        Verdict::Runs(_) => Verdict::LeftOut("defined here for real modes".to_string()),
        Verdict::LeftOut(_) => Verdict::Runs("of every frequency to every element".to_string()),
    }
}

fn campbell(prepared: &Prepared, study: &ModesStudy) -> Verdict {
    let Some(range) = study.campbell else {
        return Verdict::LeftOut("not asked for".to_string());
    };
    if prepared.machine.spins.is_empty() {
        return Verdict::Runs(
            "the modes do not change with speed: solved once, crossed with the orders".to_string(),
        );
    }
    Verdict::Runs(format!("{} speeds, branches followed by MAC", range.count))
}

fn state_space(prepared: &Prepared, study: &ModesStudy) -> Verdict {
    let Some(wanted) = &study.state_space else {
        return Verdict::LeftOut("not asked for".to_string());
    };
    if prepared
        .linear
        .branches
        .iter()
        .any(|b| b.loss_factor != 0.0)
    {
        return Verdict::Runs("refused: a loss factor has no state-space form".to_string());
    }
    let count = |names: &[String]| match names.len() {
        0 => "all".to_string(),
        n => n.to_string(),
    };
    let sampled = match wanted.sample_time {
        None => "continuous".to_string(),
        Some(h) => format!("sampled every {h} s with {} hold", wanted.hold.name()),
    };
    let (inputs, outputs) = (count(&wanted.inputs), count(&wanted.outputs));
    Verdict::Runs(format!("{sampled}, {inputs} inputs, {outputs} outputs"))
}

fn reduction(prepared: &Prepared, study: &ModesStudy) -> Verdict {
    let Some(wanted) = &study.reduce else {
        return Verdict::LeftOut("not asked for".to_string());
    };
    let method = match wanted.method {
        ReduceMethod::Guyan => "Guyan's condensation".to_string(),
        ReduceMethod::Dynamic(hz) => format!("condensation at {hz} Hz"),
        ReduceMethod::CraigBampton => "Craig–Bampton".to_string(),
        ReduceMethod::Modal => "modes with a static residual".to_string(),
    };
    let n = prepared.linear.n;
    Verdict::Runs(format!(
        "{method} of {n} freedoms, compared with all of them up to {} Hz",
        wanted.below_hz
    ))
}
