//! A screw and its nut: `δ = (p/2π) θ − z`, − (p/2π) θ for a left-hand thread, p the lead; where the bearings of the screw give way along
//! its axis, its own z is added.
//!
//! The lead counts in whole nanometres and z by `−2π·10⁹`, so that screws on one slide turn in exact ratios.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::builder::MachineBuilder;
use crate::machine::components::Gear;
use crate::machine::direction::Direction;
use crate::scene::model::{Axis, Hand, Screw, Slide};

/// m in a nanometre.
const NANOMETRE: f64 = 1e-9;

/// Puts the slide's mass.
pub fn add_slide(builder: &mut MachineBuilder, element: usize, slide: &Slide) -> Result<(), Error> {
    if let Some(z) = builder.dof(&slide.name, Axis::Z)? {
        builder.mass(element, z, slide.mass);
    }
    Ok(())
}

/// Puts the screw between what turns and what slides.
pub fn add(builder: &mut MachineBuilder, element: usize, screw: &Screw) -> Result<(), Error> {
    let [turns, slides] = &screw.between;
    let theta = builder.theta(turns)?;
    let z = match (
        builder.dof(slides, Axis::Theta)?,
        builder.dof(slides, Axis::Z)?,
    ) {
        (None, Some(z)) => z,
        _ => return Err(no_slide(screw)),
    };
    let hand = if screw.hand == Hand::Right { 1.0 } else { -1.0 };
    let along = TAU / NANOMETRE;
    let mut terms = vec![(theta, hand * screw.lead as f64), (z, -along)];
    terms.extend(builder.dof(turns, Axis::Z)?.map(|own| (own, along)));
    let branch = builder.machine.branches.len();
    let direction = Direction::new(NANOMETRE / TAU, terms);
    builder.contact(element, None, direction, None, &screw.contact);
    builder.machine.gears.push(Gear {
        element,
        rotation_dof: theta,
        teeth: None,
        carrier: None,
        branches: vec![branch],
        mesh_geometries: Vec::new(),
    });
    Ok(())
}

fn no_slide(screw: &Screw) -> Error {
    let [turns, slides] = &screw.between;
    let message = format!("`{}` is not a slide, and a screw moves one", slides.text);
    let hint = format!(
        "write between = [turning, sliding]: declare `{}` by a [[slide]], or exchange it with `{}`",
        slides.text, turns.text
    );
    Error::new(Code::Conflict, message)
        .with_span(&slides.span)
        .with_hint(hint)
}
