//! Modes with their standard deviations from a measured log: `cargo run --example identify`.

use geardyn::prelude::*;

pub(crate) fn main() -> Result<(), Errors> {
    let recording = Recording::open("data/spindle_impact.csv")?;
    let study = IdentifyStudy::default();
    let identified = recording.identify(&["force"], &["ax", "ay"], &study)?;
    for found in &identified.modes {
        let mode = &found.mode;
        let std = mode.frequency_std_hz().unwrap_or(f64::NAN);
        let damping = 100.0 * mode.damping_ratio();
        println!("{:.4} ± {std:.4} Hz  {damping:.3} %", mode.frequency_hz());
    }
    Ok(())
}
