//! Choice of the FRF method: direct (per line) or modal superposition.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_duration;
use crate::base::text::pluralise;
use crate::plan::motion::dense_cost::MAX_BYTES;
use crate::plan::motion::simulation_setup::DEFAULT_TIME_BUDGET_S;
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::stages::StageDecision;
use crate::response::frf::ResponseMethod;
use crate::scene::study::{ResponseMethodTag, ResponseStudy};

/// Lines where a study names no number.
pub const DEFAULT_LINES: u32 = 1001;

/// A way with its reason.
#[derive(Debug, Clone)]
pub struct ResponseMethodChoice {
    /// The way.
    pub method: ResponseMethod,
    /// Why.
    pub reason: String,
}

/// Up to so many lines are solved one by one whatever the machine.
const MAX_DIRECT_LINES: u32 = 30;

/// Machines of so many degrees of freedom are solved line by line at no cost.
const MAX_DIRECT_DOFS: usize = 3;

/// Machines beyond are not taken apart into modes: these would take a gigabyte and more.
const MAX_MODAL_DOFS: usize = 1500;

/// Seconds of all complex modes by n³: 2.0 s of 500 discs, 15 s of 1000.
const SECONDS_PER_MODAL_N3: f64 = 1.5e-8;

/// Seconds of a line by coordinate, where each sees its neighbours alone: 0.3 s of 1001 lines of 200 discs, their peaks included.
const SECONDS_PER_LINE_DOF: f64 = 1.4e-6;

/// Bytes of all complex modes by n².
const BYTES_PER_MODAL_N2: f64 = 600.0;

/// Seconds by n³ of a line, and bytes by n², where modal damping leaves no entry at zero.
const DENSE_LINE_COST: (f64, f64) = (1e-9, 150.0);

/// Chooses how a study is answered.
pub fn choose_method(machine: &PreparedMachine, study: &ResponseStudy) -> ResponseMethodChoice {
    let (n, lines) = (machine.model.n, study.lines.unwrap_or(DEFAULT_LINES));
    let factors: Vec<f64> = machine
        .model
        .branches
        .iter()
        .map(|b| b.loss_factor)
        .collect();
    let unequal = factors.iter().any(|&eta| eta != 0.0 && eta != factors[0])
        || (factors.first() == Some(&0.0) && factors.iter().any(|&eta| eta != 0.0));
    let full = machine.machine.damping.is_modal();
    let lined = f64::from(lines) * SECONDS_PER_LINE_DOF * n as f64;
    let taken_apart = SECONDS_PER_MODAL_N3 * (n as f64).powi(3);
    let said = |method, reason: &str| ResponseMethodChoice {
        method,
        reason: reason.to_string(),
    };
    match study.way {
        Some(ResponseMethodTag::Direct) => said(ResponseMethod::Direct, "as requested"),
        Some(ResponseMethodTag::Modal) => said(ResponseMethod::Modal, "as requested"),
        None if lines <= MAX_DIRECT_LINES => said(ResponseMethod::Direct, "few lines"),
        None if n <= MAX_DIRECT_DOFS => said(ResponseMethod::Direct, "few degrees of freedom"),
        None if n > MAX_MODAL_DOFS || (!full && lined < taken_apart) => said(
            ResponseMethod::Direct,
            "all modes of this number of degrees of freedom take longer",
        ),
        None if unequal => said(
            ResponseMethod::Direct,
            "loss factors that differ between branches couple the modes",
        ),
        None => said(
            ResponseMethod::Modal,
            "many lines: all modes once, then a sum at each line",
        ),
    }
}

/// Refuses full matrices that would take longer or more room than is allowed.
///
/// # Errors
/// `BudgetExceeded`, with the estimate and what to try.
pub fn check_budget(
    prepared_machine: &PreparedMachine,
    study: &ResponseStudy,
    choice: &ResponseMethodChoice,
) -> Result<(), Error> {
    let n = prepared_machine.model.n as f64;
    let full = prepared_machine.machine.damping.is_modal();
    let lines = f64::from(study.lines.unwrap_or(DEFAULT_LINES));
    let (what, seconds, room) = match choice.method {
        ResponseMethod::Modal => (
            "all modes",
            SECONDS_PER_MODAL_N3 * n.powi(3),
            BYTES_PER_MODAL_N2 * n * n,
        ),
        ResponseMethod::Direct if full => (
            "lines with modal damping, which couples every coordinate to every other,",
            (DENSE_LINE_COST.0 * lines + SECONDS_PER_MODAL_N3) * n.powi(3),
            DENSE_LINE_COST.1 * n * n,
        ),
        ResponseMethod::Direct => return Ok(()),
    };
    if seconds <= DEFAULT_TIME_BUDGET_S && room <= MAX_BYTES {
        return Ok(());
    }
    let message = format!(
        "{what} of {n} coordinates would take about {} and {:.1} GB in full matrices (limits {} and {:.0} GB)",
        format_duration(seconds),
        1e-9 * room,
        format_duration(DEFAULT_TIME_BUDGET_S),
        1e-9 * MAX_BYTES
    );
    let hint = match (choice.method, full) {
        (ResponseMethod::Modal, false) => {
            "omit --method modal: lines are solved by sparse matrices"
        }
        _ => {
            "give branches a damping_ratio or c in place of the damping of modes, or model the machine with fewer coordinates"
        }
    };
    Err(Error::new(Code::BudgetExceeded, message).with_hint(hint))
}

/// The plan of a response, row by row.
pub fn plan(
    machine: &PreparedMachine,
    study: &ResponseStudy,
) -> Vec<(&'static str, StageDecision)> {
    let (n, choice) = (machine.model.n, choose_method(machine, study));
    let lines = study.lines.unwrap_or(DEFAULT_LINES) as usize;
    let runs = |text: String| StageDecision::Runs(text);
    let out = |text: &str| StageDecision::LeftOut(text.to_string());
    let modal = choice.method == ResponseMethod::Modal;
    let mut rows = vec![
        (
            "equations",
            runs(format!(
                "{} behind rigid joints, {} and {}",
                pluralise(n, "coordinate"),
                pluralise(study.inputs.len(), "input"),
                pluralise(study.outputs.len(), "output")
            )),
        ),
        (
            "modes",
            if modal {
                runs(choice.reason.clone())
            } else {
                out(&choice.reason)
            },
        ),
        (
            "dynamic stiffness",
            match modal {
                true => runs(
                    "solved at 5 lines to measure the error of modal superposition".to_string(),
                ),
                false => runs(format!("solved at {}", pluralise(lines, "line"))),
            },
        ),
    ];
    rows.push(match study.speed {
        Some(_) => ("gyroscopic terms", runs("at the mean speeds".to_string())),
        None => ("gyroscopic terms", out("no speed was requested")),
    });
    rows.push((
        "peaks",
        runs("sought between the lines and near every natural frequency".to_string()),
    ));
    rows.push((
        "strain energy",
        runs("of the motion at each peak".to_string()),
    ));
    if !machine.machine.is_lateral() {
        rows.push((
            "lateral motion",
            out("no bearing supports a lateral degree of freedom"),
        ));
    }
    rows
}
