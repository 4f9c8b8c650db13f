//! Values of a model that lie far outside what machines have: read as a wrong unit or a slip, each with the usual range and its source.

use std::f64::consts::TAU;

use crate::base::error::Diagnostic;
use crate::machine::components::{BranchLaw, Machine};
use crate::machine::kinematics::{Kinematics, mean_speeds};
use crate::scene::model::{BranchDamping, Model, PlanetaryGeometry};

/// Stiffness of a mesh by its face width: 14 N/(mm·µm) for one pair of steel teeth (ISO 6336-1), Pa.
const BY_WIDTH: f64 = 14e9;

/// Usual face width, modules.
const WIDTH: f64 = 10.0;

/// A stiffness so many times off the usual one is taken for a slip.
const FAR_OFF: f64 = 100.0;

/// Damping ratios beyond this are taken for a slip.
const RATIO: f64 = 0.5;

/// Modules beyond this are taken for a slip, m.
const MODULE: f64 = 1.0;

/// Rounding of a stated J_diametral, relative.
const ROUNDING_TOLERANCE: f64 = 1e-6;

/// Warnings about implausible values of a model.
pub fn warnings(model: &Model, machine: &Machine, kinematics: &Kinematics) -> Vec<Diagnostic> {
    let mut all = modules(model);
    all.extend(inertias(model));
    all.extend(ratios(machine));
    all.extend(modal_ratios(model));
    all.extend(speeds(machine, kinematics));
    all
}

fn warning(code: &'static str, message: String, hint: &str) -> Diagnostic {
    Diagnostic {
        code,
        message,
        hint: Some(hint.to_string()),
    }
}

/// Modules, and mesh stiffnesses against them.
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
        let own = |part: &str| format!("{name} at the {part}");
        [
            (own("sun"), module, p.sun_contact.stiffness),
            (own("ring"), module, p.ring_contact.stiffness),
        ]
    });
    let mut all = Vec::new();
    let mut large = Vec::new();
    for (name, module, stiffness) in pairs.chain(worms).chain(stages) {
        let Some(module) = module else { continue };
        if module > MODULE {
            let own = name
                .split(" at the ")
                .next()
                .unwrap_or_default()
                .to_string();
            if !large.contains(&own) {
                let message = format!(
                    "the module of {own} is {module} m, and gears have 0.3 to 50 mm (ISO 54 lists 1 to 50 mm)"
                );
                all.push(warning("implausible", message, "check its unit"));
                large.push(own);
            }
            continue;
        }
        let usual = BY_WIDTH * WIDTH * module;
        let Some(k) = stiffness.filter(|k| *k > 0.0) else {
            continue;
        };
        if !(usual / FAR_OFF..=usual * FAR_OFF).contains(&k) {
            let message = format!(
                "the mesh stiffness of {name} is {k:.2e} N/m, and usual is about {usual:.1e} N/m: 14 N/(mm·µm) (ISO 6336-1) times ten modules of face width"
            );
            let hint = "check the units of `k` and `module`; 400 N/µm is 4e8 N/m";
            all.push(warning("implausible", message, hint));
        }
    }
    all
}

/// `J_d ≥ J/2`: the moments of inertia about two diameters add up to the polar one and what the length adds.
fn inertias(model: &Model) -> Vec<Diagnostic> {
    let thin = model.inertias.iter().filter_map(|body| {
        let diametral = body.diametral.filter(|d| *d > 0.0)?;
        let least = 0.5 * body.polar;
        (diametral < least * (1.0 - ROUNDING_TOLERANCE)).then(|| {
            let message = format!(
                "J_diametral of `{}` is {diametral:.4e} kg·m², and no body has less than J/2 = {least:.4e} kg·m² (perpendicular-axis theorem; a thin disc has J/2)",
                body.name.text
            );
            warning("implausible", message, "check both moments of inertia")
        })
    });
    thin.collect()
}

/// Damping ratios and loss factors of elements; at resonance a loss factor η damps as ζ = η/2.
fn ratios(machine: &Machine) -> Vec<Diagnostic> {
    let branches = machine.branches.iter().enumerate();
    let large = branches.filter_map(|(at, b)| {
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
                format!("{key} of {} is {value}", machine.branch_name(at)),
                ratio,
            )
        })
    });
    let all = large.map(|(stated, ratio)| {
        let message = format!(
            "{stated}, a damping ratio of {ratio}, and usual is 0.03 to 0.17 for gear meshes (Kasuba and Evans 1981), less for steel shafts"
        );
        let hint = "0.05 is five per cent; a damper that is meant so strong is `c`";
        warning("implausible", message, hint)
    });
    all.collect()
}

/// Damping ratios of modes.
fn modal_ratios(model: &Model) -> Option<Diagnostic> {
    let largest = model.damping.modal.iter().copied().fold(0.0, f64::max);
    (largest > RATIO).then(|| {
        let message = format!(
            "[damping] modal is {largest}, and a mode with a damping ratio above {RATIO} hardly oscillates"
        );
        warning("implausible", message, "0.02 is two per cent")
    })
}

/// Stated speeds that the ratios do not allow.
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
        "the speeds stated ({}) do not fit the machine: {}",
        stated.join(", "),
        error.message
    );
    let hint = "motion and gyroscopic terms need speeds that fit: state one node of every part that turns independently";
    Some(warning("speeds-misfit", message, hint))
}
