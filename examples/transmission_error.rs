//! Transmission error of a chain by order: `cargo run --example transmission_error`.

use geardyn::prelude::*;

pub(crate) fn main() -> Result<(), Errors> {
    let machine = Model::open("examples/y2250_te.toml")?.machine()?;
    let error = machine.transmission_error(&TransmissionStudy {
        output: Some("work_spindle".into()),
        ..TransmissionStudy::default()
    })?;
    for component in &error.components {
        let (order, source) = (&component.order_fraction, &component.source);
        println!("{order:>12}  {:.3e} rad  {source}", component.value.norm());
    }
    println!(
        "worst case {:.3e} rad, rss {:.3e} rad",
        error.worst_case, error.rss
    );
    Ok(())
}
