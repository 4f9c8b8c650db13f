//! A rigid body: `J θ̈ = T` about its shaft, `m ẍ = F` across and along it, `J_d` about a diameter.
//!
//! A body that tilts while it spins has the gyroscopic moments `M_x = −J Ω ṙ_y`, `M_y = J Ω ṙ_x` (Lalanne & Ferraris,
//! Rotordynamics Prediction in Engineering, 2nd ed. 1998, eq. (1.13)).

use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::builder::MachineBuilder;
use crate::machine::components::GyroscopicTerms;
use crate::scene::model::{Axis, Inertia};

/// Puts the body's masses on the degrees of freedom its node has.
pub fn add(builder: &mut MachineBuilder, element: usize, body: &Inertia) -> Result<(), Error> {
    let theta = builder.theta(&body.name)?;
    builder.mass(element, theta, body.polar);
    for axis in [Axis::X, Axis::Y, Axis::Z, Axis::TiltX, Axis::TiltY] {
        let Some(dof) = builder.dof(&body.name, axis)? else {
            continue;
        };
        let (value, key) = match axis.is_rotation() {
            true => (body.diametral, "J_diametral"),
            false => (body.mass, "mass"),
        };
        let value = value.ok_or_else(|| {
            let what = format!(
                "`{}` has the axis {} by a bearing, and its {key} is not stated",
                body.name.text,
                axis.name()
            );
            let hint =
                format!("add `{key}` (0 if it has none), or omit that stiffness of the bearing");
            Error::new(Code::MissingKey, what)
                .with_span(&body.name.span)
                .with_hint(hint)
        })?;
        builder.mass(element, dof, value);
    }
    let tilts = (
        builder.dof(&body.name, Axis::TiltX)?,
        builder.dof(&body.name, Axis::TiltY)?,
    );
    if let (Some(rx), Some(ry)) = tilts {
        let gyroscopic = vec![(rx, ry, body.polar)];
        builder.machine.gyroscopic.push(GyroscopicTerms {
            element,
            spin_dof: theta,
            gyroscopic,
            centripetal: Vec::new(),
            outwards: None,
            across: None,
        });
    }
    Ok(())
}
