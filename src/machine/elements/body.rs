//! A rigid body: `J θ̈ = T` about its shaft, `m ẍ = F` across and along it, `J_d` about a diameter.
//!
//! A body that tilts while it spins has the gyroscopic moments `M_x = −J Ω ṙ_y`, `M_y = J Ω ṙ_x` (Lalanne & Ferraris,
//! Rotordynamics Prediction in Engineering, 2nd ed. 1998, eq. (1.13)).

use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::builder::Builder;
use crate::machine::parts::Spin;
use crate::scene::model::{Axis, Inertia};

/// Puts the body's masses on the freedoms its node has.
pub fn add(builder: &mut Builder, element: usize, body: &Inertia) -> Result<(), Error> {
    let theta = builder.theta(&body.name)?;
    builder.mass(element, theta, body.polar);
    for axis in [Axis::X, Axis::Y, Axis::Z, Axis::TiltX, Axis::TiltY] {
        let Some(freedom) = builder.freedom(&body.name, axis)? else {
            continue;
        };
        let (value, key) = match axis.turns() {
            true => (body.diametral, "J_diametral"),
            false => (body.mass, "mass"),
        };
        let value = value.ok_or_else(|| {
            let what = format!(
                "a bearing gives `{}` the axis {}, and its {key} is not stated",
                body.name.text,
                axis.name()
            );
            let hint = format!(
                "add `{key}` (0 if it has none), or leave that stiffness out of the bearing"
            );
            Error::new(Code::MissingKey, what)
                .at(&body.name.place)
                .hint(hint)
        })?;
        builder.mass(element, freedom, value);
    }
    let tilts = (
        builder.freedom(&body.name, Axis::TiltX)?,
        builder.freedom(&body.name, Axis::TiltY)?,
    );
    if let (Some(rx), Some(ry)) = tilts {
        let gyroscopic = vec![(rx, ry, body.polar)];
        builder.machine.spins.push(Spin {
            element,
            turning: theta,
            gyroscopic,
            centripetal: Vec::new(),
            outwards: None,
            across: None,
        });
    }
    Ok(())
}
