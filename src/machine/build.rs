//! Builds a `Machine` from a model file: nodes, degrees of freedom, masses, branches.

use std::collections::HashSet;

use super::builder::{MachineBuilder, relative_rotation};
use super::components::{FrictionCapacity, FrictionElement, Machine, MotorDrive};
use super::elements::{
    bearing, belt, body, chain, coupling, damper, gear_pair, geometric_error, planetary, screw,
    shaft, worm_pair,
};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::scene::laws::{FaceMill, LoadHistory};
use crate::scene::model::{self, Axis, BranchEnd, Model};

/// Builds the machine of a model. No lateral degree of freedom exists that no bearing or planetary stage gives.
///
/// # Errors
/// A machine without bodies, an unknown node, an axis whose mass is not stated.
pub fn build(model: &Model) -> Result<Machine, Error> {
    let mut builder = MachineBuilder::default();
    let numbers = declare_nodes(&mut builder, model)?;
    if builder.machine.nodes.is_empty() {
        let hint = "add an [[inertia]]; `geardyn new` writes a model to start from";
        return Err(Error::new(
            Code::EmptyMachine,
            "the model has no body, so nothing can move",
        )
        .with_hint(hint));
    }
    builder.number_dofs();
    add_elements(&mut builder, model, &numbers)?;
    let mut machine = builder.machine;
    machine.damping = model.damping.clone();
    Ok(machine)
}

/// Numbers of the elements, table by table.
struct ElementNumbers {
    bodies: Vec<usize>,
    chains: Vec<usize>,
    shafts: Vec<usize>,
    planetaries: Vec<usize>,
    couplings: Vec<usize>,
    slides: Vec<usize>,
}

/// Every node, and every axis some element gives it.
fn declare_nodes(builder: &mut MachineBuilder, model: &Model) -> Result<ElementNumbers, Error> {
    let mut numbers = ElementNumbers {
        bodies: Vec::new(),
        chains: Vec::new(),
        shafts: Vec::new(),
        planetaries: Vec::new(),
        couplings: Vec::new(),
        slides: Vec::new(),
    };
    for part in &model.inertias {
        let element = builder.element(&part.name, "inertia");
        builder.node(&part.name.text, element);
        numbers.bodies.push(element);
    }
    for part in &model.chains {
        let element = builder.element(&part.name, "chain");
        chain::discs(part).for_each(|disc| builder.node(&disc, element));
        numbers.chains.push(element);
    }
    for part in &model.shafts {
        let element = builder.element(&part.name, "shaft");
        shaft::inner_nodes(part).for_each(|node| builder.node(&node, element));
        numbers.shafts.push(element);
    }
    for part in &model.planetaries {
        let element = builder.element(&part.name, "planetary");
        for n in 1..=part.positions.len() {
            let mut name = part.name.clone();
            name.text = planetary::planet(part, n);
            builder.node(&name.text, element);
            if part.lateral {
                builder.axis(&name, Axis::X)?;
                builder.axis(&name, Axis::Y)?;
            }
        }
        numbers.planetaries.push(element);
    }
    for part in &model.couplings {
        let element = builder.element(&part.name, "coupling");
        coupling::inner_nodes(part).for_each(|node| builder.node(&node, element));
        numbers.couplings.push(element);
    }
    for part in &model.slides {
        let element = builder.element(&part.name, "slide");
        builder.slide(&part.name.text, element);
        numbers.slides.push(element);
    }
    for part in &model.bearings {
        for axis in bearing::axes(part) {
            for end in &part.between {
                if let BranchEnd::Node(node) = end {
                    builder.axis(node, axis)?;
                }
            }
        }
    }
    add_member_axes(builder, model)?;
    Ok(numbers)
}

/// Sun, ring and carrier of a lateral stage move across their axis where they have a mass.
fn add_member_axes(builder: &mut MachineBuilder, model: &Model) -> Result<(), Error> {
    let with_mass: HashSet<&str> = model
        .inertias
        .iter()
        .filter(|body| body.mass.is_some())
        .map(|body| body.name.text.as_str())
        .collect();
    for stage in model.planetaries.iter().filter(|stage| stage.lateral) {
        for member in planetary::members(stage) {
            if let BranchEnd::Node(node) = member
                && with_mass.contains(node.text.as_str())
            {
                builder.axis(node, Axis::X)?;
                builder.axis(node, Axis::Y)?;
            }
        }
    }
    Ok(())
}

fn add_elements(
    builder: &mut MachineBuilder,
    model: &Model,
    numbers: &ElementNumbers,
) -> Result<(), Error> {
    for (part, &element) in model.inertias.iter().zip(&numbers.bodies) {
        body::add(builder, element, part)?;
    }
    for (part, &element) in model.chains.iter().zip(&numbers.chains) {
        chain::add(builder, element, part);
    }
    for (part, &element) in model.shafts.iter().zip(&numbers.shafts) {
        shaft::add(builder, element, part)?;
    }
    for part in &model.gear_pairs {
        let element = builder.element(&part.name, "gear_pair");
        gear_pair::add(builder, element, part)?;
    }
    for part in &model.worm_pairs {
        let element = builder.element(&part.name, "worm_pair");
        worm_pair::add(builder, element, part)?;
    }
    for (part, &element) in model.planetaries.iter().zip(&numbers.planetaries) {
        planetary::add(builder, element, part)?;
        if part.lateral {
            add_carrier_frame_terms(builder, model, part, element)?;
        }
    }
    for part in &model.belts {
        let element = builder.element(&part.name, "belt");
        belt::add(builder, element, part)?;
    }
    for (part, &element) in model.slides.iter().zip(&numbers.slides) {
        screw::add_slide(builder, element, part)?;
    }
    for part in &model.screws {
        let element = builder.element(&part.name, "screw");
        screw::add(builder, element, part)?;
    }
    for (part, &element) in model.couplings.iter().zip(&numbers.couplings) {
        coupling::add(builder, element, part)?;
    }
    for part in &model.bearings {
        let element = builder.element(&part.name, "bearing");
        bearing::add(builder, element, part)?;
    }
    for part in &model.dampers {
        let element = builder.element(&part.name, "damper");
        damper::add(builder, element, part)?;
    }
    for load in &model.loads {
        let dof = match load.is_force {
            true => slide_dof(builder, &load.at)?,
            false => builder.theta(&load.at)?,
        };
        let lasting = load.history.long_term_value();
        if lasting != 0.0 {
            builder.machine.loads.push((dof, lasting));
        }
        let (history, span) = (load.history.clone(), load.at.span.clone());
        builder.machine.histories.push((dof, history, span));
        if let LoadHistory::FaceMill(mill) = &load.history {
            add_face_mill_forces(builder, &load.at, mill)?;
        }
    }
    add_excitations(builder, model)?;
    for mean in &model.speeds {
        let dof = builder.theta(&mean.at)?;
        builder.machine.speeds.push((dof, mean.speed));
    }
    Ok(())
}

/// The forces of a face mill along and about the axes that bearings give its head.
fn add_face_mill_forces(
    builder: &mut MachineBuilder,
    head: &model::Name,
    mill: &FaceMill,
) -> Result<(), Error> {
    for axis in Axis::ALL.into_iter().filter(|axis| *axis != Axis::Theta) {
        let Some(dof) = builder.dof(head, axis)? else {
            continue;
        };
        if mill.slot.is_none() && axis != Axis::Z {
            let message = format!(
                "`{}` also moves along {}, and its slot angle is not stated",
                head.text,
                axis.name()
            );
            return Err(Error::new(Code::Conflict, message)
                .with_span(&head.span)
                .with_hint(
                    "add `slot = \"0 deg\"`, the angle of the slot on the head from x to y",
                ));
        }
        let whole = LoadHistory::FaceMill(mill.clone());
        let span = head.span.clone();
        builder.machine.histories.push((dof, whole, span));
    }
    Ok(())
}

/// The degree of freedom that a force pushes.
fn slide_dof(builder: &MachineBuilder, node: &model::Name) -> Result<usize, Error> {
    let turns = builder.dof(node, Axis::Theta)?.is_some();
    let along = builder.dof(node, Axis::Z)?.filter(|_| !turns);
    along.ok_or_else(|| {
        let message = format!("`{}` turns, and a `force` acts on a slide", node.text);
        Error::new(Code::Conflict, message)
            .with_span(&node.span)
            .with_hint("give a `torque`, or name a [[slide]]")
    })
}

/// Motors, brakes and errors of gears.
fn add_excitations(builder: &mut MachineBuilder, model: &Model) -> Result<(), Error> {
    for part in &model.motors {
        let element = builder.element(&part.name, "motor");
        let dof = builder.theta(&part.at)?;
        let drive = part.drive.clone();
        builder.machine.motors.push(MotorDrive {
            element,
            dof,
            drive,
        });
    }
    for part in &model.brakes {
        let element = builder.element(&part.name, "brake");
        let ends = [
            builder.rotation_of_end(&part.between[0])?,
            builder.rotation_of_end(&part.between[1])?,
        ];
        builder.machine.friction_elements.push(FrictionElement {
            element,
            direction: relative_rotation(ends),
            friction: part.friction,
            capacity: match &part.capacity_history {
                Some(points) => FrictionCapacity::Timed(points.clone()),
                None => FrictionCapacity::Constant,
            },
        });
    }
    geometric_error::add_mesh_flanks(builder);
    for part in &model.errors {
        geometric_error::add(builder, model, part)?;
    }
    Ok(())
}

/// In a lateral stage all members are described in the carrier's frame, so that the meshes keep their place.
fn add_carrier_frame_terms(
    builder: &mut MachineBuilder,
    model: &Model,
    stage: &model::Planetary,
    element: usize,
) -> Result<(), Error> {
    let BranchEnd::Node(carrier) = &stage.carrier else {
        return Ok(());
    };
    let turning = builder.theta(carrier)?;
    for member in planetary::members(stage) {
        let BranchEnd::Node(node) = member else {
            continue;
        };
        let mass = model
            .inertias
            .iter()
            .find(|body| body.name.text == node.text)
            .and_then(|body| body.mass);
        let across = (builder.dof(node, Axis::X)?, builder.dof(node, Axis::Y)?);
        if let (Some(mass), (Some(x), Some(y))) = (mass, across) {
            builder
                .machine
                .gyroscopic
                .push(planetary::rotating_frame_terms(
                    element,
                    turning,
                    [x, y],
                    mass,
                ));
        }
    }
    Ok(())
}
