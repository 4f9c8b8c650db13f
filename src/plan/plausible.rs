//! Plausibility check of model values: warnings for values that suggest a wrong unit or a typing error, with the usual range and its source.

use std::f64::consts::TAU;

use crate::base::error::Diagnostic;
use crate::machine::components::{BranchLaw, Machine};
use crate::machine::kinematics::{Kinematics, mean_speeds};
use crate::scene::model::{BranchDamping, Model, PlanetaryGeometry};

/// Mesh stiffness per face width, Pa: 14 N/(mm·µm) for one pair of steel teeth (ISO 6336-1).
const STIFFNESS_PER_WIDTH: f64 = 14e9;

/// Usual face width, relative to the module.
const USUAL_WIDTH: f64 = 10.0;

/// Factor between a plausible and the usual mesh stiffness, at most.
const MAX_FACTOR: f64 = 100.0;

/// Largest plausible damping ratio.
const RATIO: f64 = 0.5;

/// Largest plausible module, m.
const MAX_MODULE: f64 = 1.0;

/// Relative rounding tolerance of a stated J_diametral.
const ROUNDING_TOLERANCE: f64 = 1e-6;

/// Warnings about implausible values of a model.
pub fn warnings(model: &Model, machine: &Machine, kinematics: &Kinematics) -> Vec<Diagnostic> {
    let mut list = modules(model);
    list.extend(inertias(model));
    list.extend(ratios(machine));
    list.extend(modal_ratios(model));
    list.extend(speeds(machine, kinematics));
    list
}

fn warning(code: &'static str, message: String, hint: &str) -> Diagnostic {
    Diagnostic {
        code,
        message,
        hint: Some(hint.to_string()),
    }
}

/// Warnings for modules, and for mesh stiffnesses relative to the module.
fn modules(model: &Model) -> Vec<Diagnostic> {
    let pairs = model.gear_pairs.iter();
    let pairs = pairs.map(|p| (p.name.text.clone(), p.module, p.contact.stiffness));
    let worms = model.worm_pairs.iter();
    let worms = worms.map(|p| (p.name.text.clone(), p.module, p.contact.stiffness));
    let stages = model.planetaries.iter().flat_map(|p| {
        let module = match p.size {
            PlanetaryGeometry::Teeth { modules, .. } => modules.map(|m| m[0]),
            PlanetaryGeometry::Radii { .. } => None,
        };
        let name = &p.name.text;
        let mesh = |part: &str| format!("{name} at the {part}");
        [
            (mesh("sun"), module, p.sun_contact.stiffness),
            (mesh("ring"), module, p.ring_contact.stiffness),
        ]
    });
    let mut warnings = Vec::new();
    let mut reported = Vec::new();
    for (name, module, stiffness) in pairs.chain(worms).chain(stages) {
        let Some(module) = module else { continue };
        if module > MAX_MODULE {
            let own = name
                .split(" at the ")
                .next()
                .unwrap_or_default()
                .to_string();
            if !reported.contains(&own) {
                let message = format!(
                    "the module of {own} is {module} m; usual are 0.3 to 50 mm (ISO 54 lists 1 to 50 mm)"
                );
                warnings.push(warning("implausible", message, "check its unit"));
                reported.push(own);
            }
            continue;
        }
        let usual = STIFFNESS_PER_WIDTH * USUAL_WIDTH * module;
        let Some(k) = stiffness.filter(|k| *k > 0.0) else {
            continue;
        };
        if !(usual / MAX_FACTOR..=usual * MAX_FACTOR).contains(&k) {
            let message = format!(
                "the mesh stiffness of {name} is {k:.2e} N/m; usual is about {usual:.1e} N/m: 14 N/(mm·µm) (ISO 6336-1) times ten modules of face width"
            );
            let hint = "check the units of `k` and `module`; 400 N/µm is 4e8 N/m";
            warnings.push(warning("implausible", message, hint));
        }
    }
    warnings
}

/// Warnings for `J_d < J/2`: the two diametral moments of inertia sum to the polar one plus the contribution of the length.
fn inertias(model: &Model) -> Vec<Diagnostic> {
    let implausible = model.inertias.iter().filter_map(|body| {
        let diametral = body.diametral.filter(|d| *d > 0.0)?;
        let least = 0.5 * body.polar;
        (diametral < least * (1.0 - ROUNDING_TOLERANCE)).then(|| {
            let message = format!(
                "J_diametral of `{}` is {diametral:.4e} kg·m², below the minimum J/2 = {least:.4e} kg·m² (perpendicular-axis theorem; a thin disc has J/2)",
                body.name.text
            );
            warning("implausible", message, "check both moments of inertia")
        })
    });
    implausible.collect()
}

/// Warnings for damping ratios and loss factors of elements; a loss factor η corresponds to ζ = η/2 at resonance.
fn ratios(machine: &Machine) -> Vec<Diagnostic> {
    let branches = machine.branches.iter().enumerate();
    let large = branches.filter_map(|(index, b)| {
        let BranchLaw::Linear { loss, .. } = b.law else {
            return None;
        };
        let (key, value, ratio) = match loss {
            BranchDamping::Ratio(ratio) => ("damping_ratio", ratio, ratio),
            BranchDamping::Factor(factor) => ("loss_factor", factor, 0.5 * factor),
            BranchDamping::None | BranchDamping::Viscous(_) => return None,
        };
        (ratio > RATIO).then(|| {
            (
                format!("{key} of {} is {value}", machine.branch_name(index)),
                ratio,
            )
        })
    });
    let warnings = large.map(|(stated, ratio)| {
        let message = format!(
            "{stated}, a damping ratio of {ratio}; usual is 0.03 to 0.17 for gear meshes (Kasuba and Evans 1981), less for steel shafts"
        );
        let hint = "write five per cent as 0.05; state an intended strong damper as `c`";
        warning("implausible", message, hint)
    });
    warnings.collect()
}

/// Warning for modal damping ratios.
fn modal_ratios(model: &Model) -> Option<Diagnostic> {
    let largest = model.damping.modal.iter().copied().fold(0.0, f64::max);
    (largest > RATIO).then(|| {
        let message = format!(
            "[damping] modal is {largest}; a mode with a damping ratio above {RATIO} hardly oscillates"
        );
        warning("implausible", message, "write two per cent as 0.02")
    })
}

/// Warning for stated speeds that contradict the gear ratios.
fn speeds(machine: &Machine, kinematics: &Kinematics) -> Option<Diagnostic> {
    if machine.speeds.is_empty() {
        return None;
    }
    let error = mean_speeds(machine, kinematics, None).err()?;
    let stated: Vec<String> = (machine.speeds.iter())
        .map(|&(dof, speed)| {
            let rpm = speed * 60.0 / TAU;
            format!("{} {rpm:.6} rpm", machine.dof_name(dof))
        })
        .collect();
    let message = format!(
        "the speeds stated ({}) are inconsistent with the machine: {}",
        stated.join(", "),
        error.message
    );
    let hint = "state the speed of one node of every part that turns independently";
    Some(warning("speeds-misfit", message, hint))
}
