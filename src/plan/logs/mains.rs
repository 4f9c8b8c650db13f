//! Modes that may be lines of the mains: on a multiple of 50 or 60 Hz, and no wider than a line.

use crate::base::error::Diagnostic;
use crate::identify::modal_parameters::ModalParameters;
use crate::recording::frequency_responses::line_spacing_hz;
use crate::spectrum::mains::mains_multiple;

/// A line of the mains looks at most so many spectral lines wide: that of Hann's window at half power.
const LINES: f64 = 1.5;

/// And at most so wide, Hz, whatever the lines: a grid wanders less.
const WIDEST: f64 = 1.0;

/// Warnings about modes at mains frequencies, as measured, found in responses over these lines, Hz.
pub fn mode_warnings(lines: &[f64], modes: &[ModalParameters]) -> Option<Diagnostic> {
    let apart = line_spacing_hz(lines);
    let one = |m: &ModalParameters| {
        let (f, width) = (m.frequency_hz(), 2.0 * m.damping_ratio() * m.frequency_hz());
        let (mains, multiple) = mains_multiple(f, 0.5 * width.min(apart))?;
        let text = format!("{f:.4} Hz ({multiple} × {mains} Hz, half-power width {width:.4} Hz)");
        (width <= (LINES * apart).min(WIDEST)).then_some(text)
    };
    let all: Vec<String> = modes.iter().filter_map(one).collect();
    (!all.is_empty()).then(|| Diagnostic {
        code: "mains",
        message: format!("on a multiple of the mains and no wider than a line: {}", all.join(", ")),
        hint: Some("look for electric pick-up: measure once without excitation, ground the sensors; a mode stays there".into()),
    })
}
