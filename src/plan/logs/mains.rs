//! Modes that may be lines of the mains: on a multiple of 50 or 60 Hz, and no wider than a line.

use std::f64::consts::TAU;

use crate::base::error::Diagnostic;
use crate::identify::modal_parameters::ModalParameters;
use crate::recording::frequency_responses::line_spacing_hz;
use crate::spectrum::mains::mains_multiple;

/// A line of the mains looks at most so many spectral lines wide: that of Hann's window at half power.
const LINES: f64 = 1.5;

/// And at most so wide, Hz, whatever the lines: a grid wanders less.
pub const WIDEST: f64 = 1.0;

/// Remedy for pick-up of the mains.
pub const HINT: &str = "check for electric pick-up: ground the sensors, measure once without excitation; pick-up remains, a mode does not";

/// The mains frequency and the multiple of a pole no wider than a line.
pub fn as_line(mode: &ModalParameters, line_hz: f64) -> Option<(f64, usize)> {
    let width = 2.0 * mode.pole.re.abs() / TAU;
    let on_mains = mains_multiple(mode.frequency_hz(), 0.5 * width.min(line_hz));
    on_mains.filter(|_| width <= (LINES * line_hz).min(WIDEST))
}

/// Warnings about modes at mains frequencies, as measured, found in responses over these lines, Hz.
pub fn mode_warnings(lines: &[f64], modes: &[ModalParameters]) -> Option<Diagnostic> {
    let apart = line_spacing_hz(lines);
    let one = |m: &ModalParameters| {
        let (mains, multiple) = as_line(m, apart)?;
        let width = 2.0 * m.pole.re.abs() / TAU;
        let f = m.frequency_hz();
        Some(format!(
            "{f:.4} Hz ({multiple} × {mains} Hz, half-power width {width:.4} Hz)"
        ))
    };
    let all: Vec<String> = modes.iter().filter_map(one).collect();
    (!all.is_empty()).then(|| Diagnostic {
        code: "mains",
        message: format!(
            "at a harmonic of the mains and no wider than a line: {}",
            all.join(", ")
        ),
        hint: Some(HINT.to_string()),
    })
}
