//! First elastic mode over the stiffness of a shaft: `cargo run --example parameter_study`.

use geardyn::prelude::*;

pub(crate) fn main() -> Result<(), Errors> {
    for stiffness in [0.8e4, 1.0e4, 1.2e4, 1.4e4] {
        let machine = Model::builder()
            .inertia("motor", 0.02)
            .inertia("work", 0.05)
            .shaft("motor", "work", stiffness)
            .build()?
            .machine()?;
        let modes = machine.modes(&ModesStudy::default())?;
        println!("{stiffness:8.0} N·m/rad  {:.3} Hz", modes[1].frequency_hz);
    }
    Ok(())
}
