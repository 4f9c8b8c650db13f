//! Natural modes of a model file: `cargo run --example modes`.

use geardyn::prelude::*;

pub(crate) fn main() -> Result<(), Errors> {
    let machine = Model::open("models/y2250.toml")?.machine()?;
    let modes = machine.modes(&ModesStudy::default())?;
    for (k, mode) in modes.iter().enumerate().take(5) {
        let element = mode.dominant_element().unwrap_or("rigid body");
        println!("{:3}  {:10.4} Hz  {element}", k + 1, mode.frequency_hz);
    }
    Ok(())
}
