//! Terms of mean speeds: gyroscopic moments, and frames that turn: `C += g Ω (a bᵀ − b aᵀ)`, `K −= m Ω² v vᵀ`, `K += c Ω u (S w)ᵀ`.
//!
//! A lateral planetary stage is described in a frame that turns with its carrier; docs/signs.md derives its terms. A damper to
//! ground along w resists the absolute velocity `q̇ + Ω S q`, S turning x into y; that is the last term, which circulates.

use super::components::{Branch, BranchLaw, GyroscopicTerms, Machine};
use super::direction::Direction;
use super::kinematics::{Kinematics, mean_speeds};
use super::linear::LinearModel;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::scene::model::BranchDamping;

/// Terms of given mean speeds, over the independent coordinates.
#[derive(Debug, Clone, Default)]
pub struct SpinTerms {
    /// a, b, g Ω.
    pub gyroscopic: Vec<(Direction, Direction, f64)>,
    /// v, m Ω².
    pub centripetal: Vec<(Direction, f64)>,
    /// u, S w, c Ω: forces of dampers to ground along u.
    pub circulatory: Vec<(Direction, Direction, f64)>,
}

impl SpinTerms {
    /// The terms at mean speeds, rad/s by degree of freedom; dampers only where the study counts damping.
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
            let omega = speeds[spin.turning];
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
                let turned = branch.direction.entries().map(|(i, w)| match i == x {
                    true => (y, -w),
                    false => (x, w),
                });
                let along = reduced(&Direction::new(1.0, turned));
                let acts = reduced(branch.force.as_ref().unwrap_or(&branch.direction));
                terms.circulatory.push((acts, along, lb.damping * omega));
            }
        }
        terms
    }
}

/// Mean speed of every degree of freedom, rad/s, for studies that count the terms of speeds.
///
/// # Errors
/// Those of [`mean_speeds`]; a joint that is not the same at every angle of a frame that turns.
pub fn spinning(
    machine: &Machine,
    kinematics: &Kinematics,
    reference: Option<f64>,
) -> Result<Vec<f64>, Error> {
    let speeds = mean_speeds(machine, kinematics, reference)?;
    refuse_varying(machine, &speeds)?;
    Ok(speeds)
}

/// The branch joins these two degrees of freedom to ground and nothing else.
fn is_on(branch: &Branch, across: [usize; 2]) -> bool {
    let within = |d: &Direction| d.terms.iter().all(|t| across.contains(&t.0));
    within(&branch.direction) && branch.force.as_ref().is_none_or(within)
}

fn touches(branch: &Branch, dof: usize) -> bool {
    let on = |d: &Direction| d.terms.iter().any(|t| t.0 == dof);
    on(&branch.direction) || branch.force.as_ref().is_some_and(on)
}

/// Refuses what would make the equations in a turning frame periodic, or was left out of them.
///
/// # Errors
/// A support that is not the same in all directions, a joint to a body outside the frame, a body in two frames, damping
/// proportional to mass.
pub fn refuse_varying(machine: &Machine, speeds: &[f64]) -> Result<(), Error> {
    let turns = |spin: &&GyroscopicTerms| spin.across.is_some() && speeds[spin.turning] != 0.0;
    let frames: Vec<&GyroscopicTerms> = machine.gyroscopic.iter().filter(turns).collect();
    if let (Some(frame), true) = (frames.first(), machine.damping.mass != 0.0) {
        return Err(refused(
            machine,
            frame,
            frame.element,
            "`rayleigh_mass`, which brakes absolute velocity,",
        ));
    }
    for (at, frame) in frames.iter().enumerate() {
        let Some(across) = frame.across else { continue };
        let shared = |other: &&&GyroscopicTerms| {
            other.across == frame.across && other.turning != frame.turning
        };
        if let Some(other) = frames[..at].iter().find(shared) {
            return Err(refused(
                machine,
                frame,
                other.element,
                "a second stage whose carrier turns independently",
            ));
        }
        let inside = |dof: usize| {
            let same = frames.iter().filter(|f| f.turning == frame.turning);
            same.flat_map(|f| f.across.into_iter().flatten())
                .any(|i| i == dof)
        };
        let own = |b: &&Branch| {
            let stage = machine
                .gyroscopic
                .iter()
                .any(|s| s.across.is_some() && s.element == b.element);
            !stage && (touches(b, across[0]) || touches(b, across[1]))
        };
        for branch in machine.branches.iter().filter(own) {
            let force = branch.force.iter().flat_map(|u| &u.terms);
            let mut all = branch.direction.terms.iter().chain(force);
            if !is_on(branch, across) && !all.all(|t| inside(t.0)) {
                return Err(refused(
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
            .filter(own)
            .filter(|b| is_on(b, across))
            .collect();
        let of = |value: fn(&Branch) -> f64| -> bool {
            let entry = |row: usize, column: usize| -> f64 {
                let along = |d: &Direction, i: usize| -> f64 {
                    d.entries().filter(|t| t.0 == i).map(|t| t.1).sum()
                };
                let each = grounded.iter().map(|b| {
                    let acts = b.force.as_ref().unwrap_or(&b.direction);
                    value(b) * along(acts, row) * along(&b.direction, column)
                });
                each.sum()
            };
            let [x, y] = across;
            let size =
                entry(x, x).abs() + entry(y, y).abs() + entry(x, y).abs() + entry(y, x).abs();
            let apart = (entry(x, x) - entry(y, y)).abs() + (entry(x, y) + entry(y, x)).abs();
            apart > ALIKE * size
        };
        if [stiffness, viscous, ratio, hysteretic].into_iter().any(of) {
            let element = grounded.first().map_or(frame.element, |b| b.element);
            return Err(refused(
                machine,
                frame,
                element,
                "a support that is not the same in all directions",
            ));
        }
    }
    Ok(())
}

/// Relative difference of two stiffnesses that count as the same: digits of a file.
const ALIKE: f64 = 1e-9;

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

/// `k ζ`: with one stiffness in all directions it says whether the damper has.
fn ratio(branch: &Branch) -> f64 {
    match branch.law {
        BranchLaw::Linear {
            loss: BranchDamping::Ratio(zeta),
            ..
        } => stiffness(branch) * zeta,
        _ => 0.0,
    }
}

/// `k η`.
fn hysteretic(branch: &Branch) -> f64 {
    match branch.law {
        BranchLaw::Linear {
            loss: BranchDamping::Factor(eta),
            ..
        } => stiffness(branch) * eta,
        _ => 0.0,
    }
}

fn refused(machine: &Machine, frame: &GyroscopicTerms, element: usize, what: &str) -> Error {
    let (stage, other) = (&machine.elements[frame.element], &machine.elements[element]);
    let message = format!(
        "`{}` turns with its carrier, and {what} acts on one of its bodies (`{}`): its equations are not the same at every angle",
        stage.name, other.name
    );
    Error::new(Code::Conflict, message)
        .with_span(&other.span)
        .with_hint("give supports one radial stiffness and damping (`k_radial`, `c_radial`), study the stage with the carrier at rest, or leave out `lateral = true`")
}
