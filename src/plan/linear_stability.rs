//! Warnings about the linear model: growing roots (instability), and neglected speed-dependent or damping terms.

use std::f64::consts::TAU;

use super::prepared_machine::PreparedMachine;
use crate::base::error::Diagnostic;
use crate::base::text::pluralise;
use crate::machine::kinematics::mean_speeds;
use crate::machine::spin::SpinTerms;
use crate::modes::modal_basis::ModalBasis;
use crate::modes::modal_matrices::largest_spin_shift;
use crate::modes::mode::modulus;
use crate::numeric::Complex;
use crate::scene::study::ModesStudy;

/// Growth that counts as none, relative to |λ|: rounding of roots that neither grow nor decay.
pub const NO_GROWTH: f64 = 1e-10;

/// The code of roots that grow.
pub const UNSTABLE: &str = "unstable";

/// The code of terms that were left out.
pub const LEFT_OUT: &str = "speed-terms";

/// The root grows.
pub fn grows(root: Complex) -> bool {
    root.re > NO_GROWTH * modulus(root)
}

/// A warning that names the root that grows fastest, with its rate; none where all decay or stay.
pub fn unstable(roots: impl Iterator<Item = Complex>) -> Option<Diagnostic> {
    let growing: Vec<Complex> = roots.filter(|&root| grows(root)).collect();
    let fastest = growing.iter().max_by(|a, b| a.re.total_cmp(&b.re))?;
    let what = match fastest.im == 0.0 {
        true => "a non-oscillatory root".to_string(),
        false => format!("the mode at {:.6} Hz", modulus(*fastest) / TAU),
    };
    let more = match growing.len() {
        1 => String::new(),
        n => format!("; {} growing", pluralise(n - 1, "other root")),
    };
    let message = format!(
        "unstable: {what} grows by {:.4} 1/s, doubling every {:.4} s{more}",
        fastest.re,
        2f64.ln() / fastest.re
    );
    let hint = "no steady state is reached; check for cross terms of bearings, negative stiffness or damping, or a speed beyond the stability limit";
    Some(Diagnostic {
        code: UNSTABLE,
        message,
        hint: Some(hint.to_string()),
    })
}

/// A warning of terms that the study leaves out: those of speeds without a speed, dampers that circulate or drive without damping.
pub fn left_out(
    machine: &PreparedMachine,
    study: &ModesStudy,
    basis: Option<&ModalBasis>,
) -> Vec<Diagnostic> {
    let mut all = Vec::new();
    if study.speed.is_none() && study.campbell.is_none() {
        all.extend(without_speed(machine, basis));
    }
    if !study.damped {
        all.extend(without_damping(machine));
    }
    all
}

/// Speeds are shown to this share of an rpm.
const SHOWN: f64 = 1e3;

/// The speed at which the terms are weighed where the file states none, rad/s: 1 000 rpm.
const DEFAULT: f64 = 1000.0 * TAU / 60.0;

fn without_speed(
    prepared_machine: &PreparedMachine,
    basis: Option<&ModalBasis>,
) -> Option<Diagnostic> {
    let (machine, linear) = (&prepared_machine.machine, &prepared_machine.model);
    if machine.gyroscopic.is_empty() {
        return None;
    }
    let reference = machine.speeds.is_empty().then_some(DEFAULT);
    let speeds = mean_speeds(machine, &prepared_machine.kinematics, reference).ok()?;
    let terms = SpinTerms::new(machine, linear, &speeds, false);
    if terms.gyroscopic.is_empty() && terms.centripetal.is_empty() {
        return None;
    }
    let at = machine.speeds.first().map_or_else(
        || "at 1000 rpm of the first node that turns".to_string(),
        |&(dof, speed)| {
            format!(
                "at the {} rpm stated for {}",
                (speed * 60.0 / TAU * SHOWN).round() / SHOWN,
                machine.dof_name(dof)
            )
        },
    );
    let size = basis.map(|basis| largest_spin_shift(&terms, basis));
    if size.is_some_and(|size| size < NO_GROWTH) {
        return None;
    }
    let size = size.map_or(String::new(), |size| {
        format!(
            " {at} they are up to {:.2} % of the terms of a mode",
            100.0 * size
        )
    });
    let message = format!(
        "the machine is analysed at rest, without gyroscopic, Coriolis and centripetal terms;{size}"
    );
    Some(Diagnostic {
        code: LEFT_OUT,
        message: message.trim_end_matches(';').to_string(),
        hint: Some("add --speed to include them".to_string()),
    })
}

fn without_damping(machine: &PreparedMachine) -> Option<Diagnostic> {
    let drives = |b: &&crate::machine::linear::LinearBranch| {
        b.damping < 0.0 || (b.force.is_some() && b.damping != 0.0)
    };
    let lb = machine.model.branches.iter().find(drives)?;
    let message = format!(
        "damping is neglected, but that of {} ({:.4e} SI) is cross-coupled or negative",
        machine.machine.branch_name(lb.index),
        lb.damping
    );
    Some(Diagnostic {
        code: LEFT_OUT,
        message,
        hint: Some("add --damped to include it".to_string()),
    })
}
