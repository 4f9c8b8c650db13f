//! Transmission error of a gear pair over torque: `cargo run --example gear_mesh`.

use geardyn::prelude::*;

pub(crate) fn main() -> Result<(), Errors> {
    let pair = GearPair::open("models/gears/fzg_c.toml")?;
    let study = MeshStudy {
        torques: vec![50.0, 100.0, 200.0, 400.0], // N·m at the pinion
        ..pair.study().clone()
    };
    println!("contact ratio {:.4}", pair.contact_ratio());
    for cycle in pair.mesh(&study)?.cycles {
        let (torque, micrometres) = (cycle.torque, 1e6 * cycle.peak_to_peak());
        println!("{torque:6.0} N·m  {micrometres:8.3} µm peak to peak");
    }
    Ok(())
}
