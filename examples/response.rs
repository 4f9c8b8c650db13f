//! Frequency response and its peaks: `cargo run --example response`.

use std::f64::consts::TAU;

use geardyn::prelude::*;

pub(crate) fn main() -> Result<(), Errors> {
    let machine = Model::open("models/y2250.toml")?.machine()?;
    let response = machine.response(&ResponseStudy {
        inputs: vec!["motor".into()],
        outputs: vec!["workpiece".into()],
        band: Some((TAU * 1.0, TAU * 400.0)),
        ..ResponseStudy::default()
    })?;
    for function in &response.functions {
        println!("{} / {}", function.output, function.input);
        for peak in &function.peaks {
            let (frequency, magnitude) = (peak.frequency_hz, peak.magnitude);
            println!("{frequency:10.4} Hz  {magnitude:.4e} {}", function.unit);
        }
    }
    Ok(())
}
