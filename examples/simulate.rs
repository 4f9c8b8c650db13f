//! Motion in time of a model built in code: `cargo run --example simulate`.

use geardyn::prelude::*;

pub(crate) fn main() -> Result<(), Errors> {
    let machine = Model::builder()
        .inertia("motor", 0.02)
        .inertia("work", 0.05)
        .shaft("motor", "work", 1.2e4)
        .element(
            "load",
            &[("at", "\"motor\"".into()), ("torque", "\"10 N·m\"".into())],
        )
        .build()?
        .machine()?;
    let motion = machine.simulate(&SimulateStudy {
        end_time: Some(0.05),
        outputs: vec!["motor.theta.speed".into(), "work.theta.speed".into()],
        ..SimulateStudy::default()
    })?;
    println!("{} instants by {}", motion.time_s.len(), motion.method);
    for output in &motion.outputs {
        let last = output.values.last().copied().unwrap_or(0.0);
        println!("{} ends at {last:.4} {}", output.name, output.unit);
    }
    Ok(())
}
