//! Speed-dependent terms of gyroscopic moments and rotating frames: `C += g Ω (a bᵀ − b aᵀ)`, `K −= m Ω² v vᵀ`, `K += c Ω u (S w)ᵀ`.
//!
//! A lateral planetary stage is described in a frame that rotates with its carrier; docs/signs.md derives its terms. A damper to
//! ground along w resists the absolute velocity `q̇ + Ω S q`, S rotating x into y; this gives the last, circulatory term.

use super::components::{Branch, BranchLaw, GyroscopicTerms, Machine};
use super::direction::Direction;
use super::kinematics::{Kinematics, mean_speeds};
use super::linear::LinearModel;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::scene::model::BranchDamping;

/// Speed-dependent terms at given mean speeds, over the independent coordinates.
#[derive(Debug, Clone, Default)]
pub struct SpinTerms {
    /// Gyroscopic terms `(a, b, g Ω)`.
    pub gyroscopic: Vec<(Direction, Direction, f64)>,
    /// Centripetal terms `(v, m Ω²)`.
    pub centripetal: Vec<(Direction, f64)>,
    /// Circulatory terms `(u, S w, c Ω)` of dampers to ground with force along u.
    pub circulatory: Vec<(Direction, Direction, f64)>,
}

impl SpinTerms {
    /// Terms at mean speeds (rad/s by degree of freedom); those of dampers only if `damped`.
    pub fn new(machine: &Machine, model: &LinearModel, speeds: &[f64], damped: bool) -> SpinTerms {
        let reduced = |d: &Direction| {
            let rows = d.entries().flat_map(|(dof, x)| {
                let row = model.transform[dof].iter();
                row.map(move |&(j, a)| (j, x * a))
            });
            Direction::new(1.0, rows)
        };
        let mut terms = SpinTerms::default();
        for spin in &machine.gyroscopic {
            let omega = speeds[spin.spin_dof];
            if omega == 0.0 {
                continue;
            }
            for &(a, b, g) in &spin.gyroscopic {
                let [a, b] = [a, b].map(|dof| reduced(&Direction::unit(dof)));
                terms.gyroscopic.push((a, b, g * omega));
            }
            for (v, m) in &spin.centripetal {
                terms.centripetal.push((reduced(v), m * omega * omega));
            }
            let Some([x, y]) = spin.across.filter(|_| damped) else {
                continue;
            };
            for lb in model.branches.iter().filter(|b| b.damping != 0.0) {
                let branch = &machine.branches[lb.index];
                if !is_on(branch, [x, y]) {
                    continue;
                }
                let rotated = branch.direction.entries().map(|(i, w)| match i == x {
                    true => (y, -w),
                    false => (x, w),
                });
                let s_w = reduced(&Direction::new(1.0, rotated));
                let u = reduced(branch.force.as_ref().unwrap_or(&branch.direction));
                terms.circulatory.push((u, s_w, lb.damping * omega));
            }
        }
        terms
    }
}

/// Mean speed of every degree of freedom, rad/s, for studies that include the speed-dependent terms.
///
/// # Errors
/// Those of [`mean_speeds`] and of [`check_constant_coefficients`].
pub fn spin_speeds(
    machine: &Machine,
    kinematics: &Kinematics,
    reference: Option<f64>,
) -> Result<Vec<f64>, Error> {
    let speeds = mean_speeds(machine, kinematics, reference)?;
    check_constant_coefficients(machine, &speeds)?;
    Ok(speeds)
}

/// Returns `true` if the branch connects only these two degrees of freedom to ground.
fn is_on(branch: &Branch, across: [usize; 2]) -> bool {
    let is_within = |d: &Direction| d.terms.iter().all(|t| across.contains(&t.0));
    is_within(&branch.direction) && branch.force.as_ref().is_none_or(is_within)
}

fn acts_on(branch: &Branch, dof: usize) -> bool {
    let has_dof = |d: &Direction| d.terms.iter().any(|t| t.0 == dof);
    has_dof(&branch.direction) || branch.force.as_ref().is_some_and(has_dof)
}

/// Returns an error if the equations in a rotating frame would be periodic in time, or if they lack a term.
///
/// # Errors
/// `Conflict` for an anisotropic support, a joint to a body outside the frame, a body in two frames, or mass-proportional
/// damping.
pub fn check_constant_coefficients(machine: &Machine, speeds: &[f64]) -> Result<(), Error> {
    let rotates = |spin: &&GyroscopicTerms| spin.across.is_some() && speeds[spin.spin_dof] != 0.0;
    let frames: Vec<&GyroscopicTerms> = machine.gyroscopic.iter().filter(rotates).collect();
    if let (Some(frame), true) = (frames.first(), machine.damping.mass != 0.0) {
        return Err(conflict(
            machine,
            frame,
            frame.element,
            "`rayleigh_mass`, which damps absolute velocity,",
        ));
    }
    for (at, frame) in frames.iter().enumerate() {
        let Some(across) = frame.across else { continue };
        let shares_dofs = |other: &&&GyroscopicTerms| {
            other.across == frame.across && other.spin_dof != frame.spin_dof
        };
        if let Some(other) = frames[..at].iter().find(shares_dofs) {
            return Err(conflict(
                machine,
                frame,
                other.element,
                "a second stage whose carrier turns independently",
            ));
        }
        let is_in_frame = |dof: usize| {
            let set = frames.iter().filter(|f| f.spin_dof == frame.spin_dof);
            set.flat_map(|f| f.across.into_iter().flatten())
                .any(|i| i == dof)
        };
        let is_joint = |b: &&Branch| {
            let stage = machine
                .gyroscopic
                .iter()
                .any(|s| s.across.is_some() && s.element == b.element);
            !stage && (acts_on(b, across[0]) || acts_on(b, across[1]))
        };
        for branch in machine.branches.iter().filter(is_joint) {
            let force = branch.force.iter().flat_map(|u| &u.terms);
            let mut terms = branch.direction.terms.iter().chain(force);
            if !is_on(branch, across) && !terms.all(|t| is_in_frame(t.0)) {
                return Err(conflict(
                    machine,
                    frame,
                    branch.element,
                    "a joint to a body outside that frame",
                ));
            }
        }
        let grounded: Vec<&Branch> = machine
            .branches
            .iter()
            .filter(is_joint)
            .filter(|b| is_on(b, across))
            .collect();
        let varies = |value: fn(&Branch) -> f64| -> bool {
            let entry = |row: usize, column: usize| -> f64 {
                let component = |d: &Direction, i: usize| -> f64 {
                    d.entries().filter(|t| t.0 == i).map(|t| t.1).sum()
                };
                let entries = grounded.iter().map(|b| {
                    let force_direction = b.force.as_ref().unwrap_or(&b.direction);
                    value(b) * component(force_direction, row) * component(&b.direction, column)
                });
                entries.sum()
            };
            let [x, y] = across;
            let scale =
                entry(x, x).abs() + entry(y, y).abs() + entry(x, y).abs() + entry(y, x).abs();
            let difference = (entry(x, x) - entry(y, y)).abs() + (entry(x, y) + entry(y, x)).abs();
            difference > SYMMETRY_TOLERANCE * scale
        };
        if [stiffness, viscous, ratio, loss].into_iter().any(varies) {
            let element = grounded.first().map_or(frame.element, |b| b.element);
            return Err(conflict(
                machine,
                frame,
                element,
                "a support that is not the same in all directions",
            ));
        }
    }
    Ok(())
}

/// Largest relative anisotropy of a support that counts as isotropic: the digits of a file.
const SYMMETRY_TOLERANCE: f64 = 1e-9;

fn stiffness(branch: &Branch) -> f64 {
    match branch.law {
        BranchLaw::Linear { stiffness, .. } => stiffness,
        BranchLaw::Rigid => 0.0,
    }
}

fn viscous(branch: &Branch) -> f64 {
    match branch.law {
        BranchLaw::Linear {
            loss: BranchDamping::Viscous(c),
            ..
        } => c,
        _ => 0.0,
    }
}

/// Product `k ζ`: for an isotropic stiffness, isotropic exactly if the damping is.
fn ratio(branch: &Branch) -> f64 {
    match branch.law {
        BranchLaw::Linear {
            loss: BranchDamping::Ratio(zeta),
            ..
        } => stiffness(branch) * zeta,
        _ => 0.0,
    }
}

/// Product `k η` of stiffness and loss factor.
fn loss(branch: &Branch) -> f64 {
    match branch.law {
        BranchLaw::Linear {
            loss: BranchDamping::Factor(eta),
            ..
        } => stiffness(branch) * eta,
        _ => 0.0,
    }
}

fn conflict(machine: &Machine, frame: &GyroscopicTerms, element: usize, cause: &str) -> Error {
    let (stage, other) = (&machine.elements[frame.element], &machine.elements[element]);
    let message = format!(
        "`{}` turns with its carrier, and {cause} acts on one of its bodies (`{}`): its equations depend on the angle",
        stage.name, other.name
    );
    Error::new(Code::Conflict, message)
        .with_span(&other.span)
        .with_hint("give supports one radial stiffness and damping (`k_radial`, `c_radial`), study the stage with the carrier at rest, or leave out `lateral = true`")
}
