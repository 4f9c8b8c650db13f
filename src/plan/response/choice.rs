//! How a frequency response is found: line by line, or as a sum over modes.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::units::duration;
use crate::base::words::counted;
use crate::plan::motion::dense::ROOM;
use crate::plan::motion::scene::ALLOWED;
use crate::plan::prepared::Prepared;
use crate::plan::stages::Verdict;
use crate::response::frequency::Way;
use crate::scene::study::{ResponseStudy, ResponseWay};

/// Lines where a study names no number.
pub const LINES: u32 = 1001;

/// A way with its reason.
#[derive(Debug, Clone)]
pub struct Choice {
    /// The way.
    pub way: Way,
    /// Why.
    pub reason: String,
}

/// Up to so many lines are solved one by one whatever the machine.
const FEW_LINES: u32 = 30;

/// Machines of so many freedoms are solved line by line at no cost.
const FEW_FREEDOMS: usize = 3;

/// Machines beyond are not taken apart into modes: these would take a gigabyte and more.
const MOST: usize = 1500;

/// Seconds of all complex modes by n³: 2.0 s of 500 discs, 15 s of 1000.
const MODES: f64 = 1.5e-8;

/// Seconds of a line by coordinate, where each sees its neighbours alone: 0.3 s of 1001 lines of 200 discs, their peaks included.
const LINE: f64 = 1.4e-6;

/// Bytes of all complex modes by n².
const MODES_ROOM: f64 = 600.0;

/// Seconds by n³ of a line, and bytes by n², where modal damping leaves no entry at zero.
const FULL: (f64, f64) = (1e-9, 150.0);

/// Chooses how a study is answered.
pub fn choose(prepared: &Prepared, study: &ResponseStudy) -> Choice {
    let (n, lines) = (prepared.linear.n, study.lines.unwrap_or(LINES));
    let factors: Vec<f64> = prepared
        .linear
        .branches
        .iter()
        .map(|b| b.loss_factor)
        .collect();
    let unequal = factors.iter().any(|&eta| eta != 0.0 && eta != factors[0])
        || (factors.first() == Some(&0.0) && factors.iter().any(|&eta| eta != 0.0));
    let full = prepared.machine.damping.is_modal();
    let lined = f64::from(lines) * LINE * n as f64;
    let taken_apart = MODES * (n as f64).powi(3);
    let said = |way, reason: &str| Choice {
        way,
        reason: reason.to_string(),
    };
    match study.way {
        Some(ResponseWay::Direct) => said(Way::Direct, "as asked"),
        Some(ResponseWay::Modal) => said(Way::Modal, "as asked"),
        None if lines <= FEW_LINES => said(Way::Direct, "few lines"),
        None if n <= FEW_FREEDOMS => said(Way::Direct, "few freedoms"),
        None if n > MOST || (!full && lined < taken_apart) => said(
            Way::Direct,
            "all modes of so many freedoms would take longer",
        ),
        None if unequal => said(
            Way::Direct,
            "loss factors that differ from branch to branch leave no modes that come apart",
        ),
        None => said(
            Way::Modal,
            "many lines: all modes once, then a sum at each line",
        ),
    }
}

/// Refuses full matrices that would take longer or more room than is allowed.
///
/// # Errors
/// `Hopeless`, with the estimate and what to try.
pub fn refuse(prepared: &Prepared, study: &ResponseStudy, choice: &Choice) -> Result<(), Error> {
    let n = prepared.linear.n as f64;
    let full = prepared.machine.damping.is_modal();
    let lines = f64::from(study.lines.unwrap_or(LINES));
    let (what, seconds, room) = match choice.way {
        Way::Modal => ("all modes", MODES * n.powi(3), MODES_ROOM * n * n),
        Way::Direct if full => (
            "lines with modal damping, which couples every coordinate to every other,",
            (FULL.0 * lines + MODES) * n.powi(3),
            FULL.1 * n * n,
        ),
        Way::Direct => return Ok(()),
    };
    if seconds <= ALLOWED && room <= ROOM {
        return Ok(());
    }
    let message = format!(
        "{what} of {n} coordinates would take about {} and {:.1} GB in full matrices, and {} and {:.0} GB are allowed",
        duration(seconds),
        1e-9 * room,
        duration(ALLOWED),
        1e-9 * ROOM
    );
    let hint = match (choice.way, full) {
        (Way::Modal, false) => "leave --method modal out: lines go by what is not zero alone",
        _ => {
            "give branches a damping_ratio or c in place of the damping of modes, or model the machine with fewer coordinates"
        }
    };
    Err(Error::new(Code::Hopeless, message).hint(hint))
}

/// The plan of a response, row by row.
pub fn plan(prepared: &Prepared, study: &ResponseStudy) -> Vec<(&'static str, Verdict)> {
    let (n, choice) = (prepared.linear.n, choose(prepared, study));
    let lines = study.lines.unwrap_or(LINES) as usize;
    let runs = |text: String| Verdict::Runs(text);
    let out = |text: &str| Verdict::LeftOut(text.to_string());
    let modal = choice.way == Way::Modal;
    let mut rows = vec![
        (
            "equations",
            runs(format!(
                "{} behind rigid joints, {} and {}",
                counted(n, "coordinate"),
                counted(study.inputs.len(), "input"),
                counted(study.outputs.len(), "output")
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
                    "solved at 5 lines, to measure the error of the sum over modes".to_string(),
                ),
                false => runs(format!("solved at {}", counted(lines, "line"))),
            },
        ),
    ];
    rows.push(match study.speed {
        Some(_) => ("gyroscopic terms", runs("at the mean speeds".to_string())),
        None => ("gyroscopic terms", out("no speed was asked for")),
    });
    rows.push((
        "peaks",
        runs("found between the lines and near every natural frequency".to_string()),
    ));
    rows.push((
        "strain energy",
        runs("of the motion at each peak".to_string()),
    ));
    if !prepared.machine.is_lateral() {
        rows.push((
            "lateral motion",
            out("no bearing supports a lateral freedom"),
        ));
    }
    rows
}
