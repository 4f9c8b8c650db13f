//! Static operating point: contact states and tangent stiffness under mean loads.
//!
//! A free train under loads that do not balance accelerates; its inertia forces are put against them first (inertia relief).
//! Then `Σ w F(δ) = f` with `F = k (δ ∓ backlash/2)` beyond the play and zero inside: the minimum of a convex energy, found by
//! changing the flank of the worst contact until none is wrong. What is not linear is taken by its secant `F/δ(F)`, again until
//! its force stays; about that point it resists small motions by its tangent.

use super::characteristic::{MAX_SECANT_ITERATIONS, SECANT_TOLERANCE};
use super::components::{Branch, BranchLaw, Machine};
use super::direction::Direction;
use super::kinematics::Kinematics;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Matrix;
use crate::numeric::symmetric;

/// State of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ActiveFlank {
    /// Closed so that δ > 0, or without play.
    Drive,
    /// Closed so that δ < 0.
    Coast,
    /// Open: no stiffness here.
    Open,
}

impl ActiveFlank {
    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            ActiveFlank::Drive => "drive",
            ActiveFlank::Coast => "coast",
            ActiveFlank::Open => "open",
        }
    }
}

/// The state of every contact that has play, and of what is not linear.
#[derive(Debug, Clone, Default)]
pub struct OperatingPoint {
    /// Branch, state, and the static force in it, N or N·m (none where no load was stated).
    pub contacts: Vec<(usize, ActiveFlank, Option<f64>)>,
    /// Meshes without play whose mean force presses the coast flank, which has a direction of its own.
    pub coast: Vec<usize>,
    /// Nonlinear branches, as tangent stiffnesses.
    pub tangents: Vec<TangentStiffness>,
}

/// A branch with a characteristic, at its operating point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TangentStiffness {
    /// The branch.
    pub branch: usize,
    /// The static force in it, N or N·m.
    pub force: f64,
    /// dF/dδ there, N/m or N·m/rad.
    pub stiffness: f64,
}

impl OperatingPoint {
    /// The state of a branch; those without play are always closed.
    pub fn state(&self, branch: usize) -> ActiveFlank {
        let closed = match self.coast.contains(&branch) {
            true => ActiveFlank::Coast,
            false => ActiveFlank::Drive,
        };
        self.contacts
            .iter()
            .find(|c| c.0 == branch)
            .map_or(closed, |c| c.1)
    }

    /// The stiffness that small motions find in a branch, where it is not linear.
    pub fn tangent(&self, branch: usize) -> Option<f64> {
        let found = self.tangents.iter().find(|t| t.branch == branch);
        found.map(|t| t.stiffness)
    }

    /// Finds the state of every contact with play, the flanks that meshes without play press, and the force in what is not linear. Without
    /// loads all contacts stand closed on the drive flank, and characteristics at rest; so do meshes without play of machines with more than
    /// 2 000 degrees of freedom.
    ///
    /// # Errors
    /// No state of the contacts balances the loads; forces in what is not linear that do not settle.
    pub fn solve(machine: &Machine, kinematics: &Kinematics) -> Result<OperatingPoint, Error> {
        let playing = playing_branches(machine);
        let curved = |b: &&Branch| b.characteristic.is_some();
        let is_linear = !machine.branches.iter().any(|b| curved(&b));
        let has_flanks = has_closed_flanks(machine, kinematics);
        if machine.loads.is_empty() || (playing.is_empty() && is_linear && !has_flanks) {
            let contacts = playing
                .into_iter()
                .map(|b| (b, ActiveFlank::Drive, None))
                .collect();
            let at_rest = machine.branches.iter().enumerate();
            let tangents = at_rest.filter_map(|(at, b)| tangent(at, b, 0.0)).collect();
            return Ok(OperatingPoint {
                contacts,
                coast: Vec::new(),
                tangents,
            });
        }
        let mut search = ContactSearch::new(machine, kinematics, playing, &[])?;
        let forces = search.solve_equilibrium()?;
        Ok(search.operating_point(&forces))
    }
}

/// Whether meshes without play have flanks of different directions, in a machine small enough to find the pressed ones.
fn has_closed_flanks(machine: &Machine, kinematics: &Kinematics) -> bool {
    let mut meshes = machine.branches.iter().filter(|b| b.backlash == 0.0);
    kinematics.independent_dofs.len() <= MAX_DENSE_DOFS && meshes.any(|b| b.coast.is_some())
}

/// Static forces under the mean loads.
#[derive(Debug, Clone)]
pub struct MeanForces {
    /// Branch and the force in it, N or N·m.
    pub forces: Vec<(usize, f64)>,
    /// The loads do not balance, and the machine accelerates under them.
    pub accelerates: bool,
}

/// Work of the loads on a rigid-body motion, as a share of its terms, from which they do not balance: torques are stated to a few digits.
const UNBALANCED: f64 = 1e-3;

/// Static forces of the elastic branches under the mean loads, the degrees of freedom `held` moving evenly.
///
/// # Errors
/// `Conflict`: a held degree of freedom that rigid joints tie to several others. As [`OperatingPoint::solve`].
pub fn mean_forces(
    machine: &Machine,
    kinematics: &Kinematics,
    held: &[usize],
) -> Result<MeanForces, Error> {
    let playing = playing_branches(machine);
    let mut search = ContactSearch::new(machine, kinematics, playing, held)?;
    let forces = search.solve_equilibrium()?;
    Ok(MeanForces {
        accelerates: search.accelerates,
        forces: (search.springs.iter().zip(forces))
            .map(|(spring, force)| (spring.branch, force))
            .collect(),
    })
}

/// Elastic branches with play.
fn playing_branches(machine: &Machine) -> Vec<usize> {
    let plays = |b: &usize| {
        machine.branches[*b].backlash > 0.0 && machine.branches[*b].law != BranchLaw::Rigid
    };
    (0..machine.branches.len()).filter(plays).collect()
}

fn tangent(branch: usize, part: &Branch, force: f64) -> Option<TangentStiffness> {
    let law = part.characteristic.as_ref()?;
    let stiffness = law.tangent(law.deflection(force));
    Some(TangentStiffness {
        branch,
        force,
        stiffness,
    })
}

/// Degrees of freedom for which the operating point is solved at most.
const MAX_DENSE_DOFS: usize = 2000;

/// A force this small is rounding of a branch that carries nothing.
fn idle_force(forces: &[f64]) -> f64 {
    1e-9 * forces.iter().fold(0.0f64, |m, f| m.max(f.abs()))
}

/// Share of its stiffness that an open contact keeps in the search: without a force it rests in the middle of its play, and with one it is
/// pushed out of it.
const OPEN_STIFFNESS_RATIO: f64 = 1e-9;

struct ContactSpring<'a> {
    branch: usize,
    part: &'a Branch,
    direction: Direction,
    stiffness: f64,
    play: f64,
    state: ActiveFlank,
}

struct ContactSearch<'a> {
    n: usize,
    springs: Vec<ContactSpring<'a>>,
    load: Vec<f64>,
    /// Inertia forces were put against the loads.
    accelerates: bool,
}

impl<'a> ContactSearch<'a> {
    fn new(
        machine: &'a Machine,
        kinematics: &Kinematics,
        playing: Vec<usize>,
        held: &[usize],
    ) -> Result<ContactSearch<'a>, Error> {
        let n = kinematics.independent_dofs.len();
        if n > MAX_DENSE_DOFS {
            let message = format!(
                "the operating point of {n} degrees of freedom with play would need a dense solve of that size"
            );
            let hint =
                "omit the loads (contacts are then closed on the drive flank), or the backlash";
            return Err(Error::new(Code::BudgetExceeded, message).with_hint(hint));
        }
        let mut still = Vec::new();
        for &dof in held {
            match kinematics.in_independent_dofs(dof)[..] {
                [(j, _)] => still.push(j),
                _ => return Err(tied_dof_error(machine, dof)),
            }
        }
        let mut springs = Vec::new();
        for (branch, b) in machine.branches.iter().enumerate() {
            let BranchLaw::Linear { stiffness, .. } = b.law else {
                continue;
            };
            let mut direction = Direction {
                scale: b.direction.scale,
                terms: kinematics.reduce_row(&b.direction.terms),
            };
            direction.terms.retain(|(j, _)| !still.contains(j));
            if stiffness > 0.0 && !direction.terms.is_empty() {
                let play = if playing.contains(&branch) {
                    b.backlash
                } else {
                    0.0
                };
                springs.push(ContactSpring {
                    branch,
                    part: b,
                    direction,
                    stiffness,
                    play,
                    state: ActiveFlank::Drive,
                });
            }
        }
        let mut load = vec![0.0; n];
        for &(dof, torque) in &machine.loads {
            kinematics
                .in_independent_dofs(dof)
                .into_iter()
                .filter(|(j, _)| !still.contains(j))
                .for_each(|(j, a)| load[j] += a * torque);
        }
        let mut mass = vec![0.0; n];
        for term in &machine.masses {
            for (j, a) in kinematics.reduce_row(&term.direction.terms) {
                mass[j] += term.value * (term.direction.scale * a).powi(2);
            }
        }
        let strained = machine
            .branches
            .iter()
            .filter(|b| matches!(b.law, BranchLaw::Linear { stiffness, .. } if stiffness > 0.0));
        let all = kinematics
            .undeformed_motions(strained)
            .basis(machine.dofs.len());
        let reduced = |motion: Vec<f64>| -> Vec<f64> {
            let own = kinematics.independent_dofs.iter();
            own.map(|&i| motion[i]).collect()
        };
        let motions = without(all.into_iter().map(reduced).collect(), &still);
        let mut accelerates = false;
        for r in motions {
            let (push, inertia): (f64, f64) = (0..n).fold((0.0, 0.0), |(f, m), j| {
                (f + r[j] * load[j], m + mass[j] * r[j] * r[j])
            });
            let size: f64 = (0..n).map(|j| (r[j] * load[j]).abs()).sum();
            accelerates |= push.abs() > UNBALANCED * size;
            if inertia > 0.0 {
                (0..n).for_each(|j| load[j] -= mass[j] * r[j] * push / inertia);
            }
        }
        Ok(ContactSearch {
            n,
            springs,
            load,
            accelerates,
        })
    }

    /// Forces that balance the loads: secants of what is not linear are taken again until they stay.
    fn solve_equilibrium(&mut self) -> Result<Vec<f64>, Error> {
        // On a tree forces do not depend on stiffness, and the second round is the last; loops take more.
        for _ in 0..MAX_SECANT_ITERATIONS {
            let forces = self.find_active_flanks()?;
            let mut moved = 0.0f64;
            for (spring, &force) in self.springs.iter_mut().zip(&forces) {
                if let Some(law) = &spring.part.characteristic {
                    moved = moved.max(law.update_secant(&mut spring.stiffness, force));
                }
            }
            if moved <= SECANT_TOLERANCE {
                return Ok(forces);
            }
        }
        let message = "the forces in couplings and teeth that are not linear do not settle under the mean loads";
        Err(Error::new(Code::NoConvergence, message)
            .with_hint("change a load slightly, or give the stiffness that is meant as k"))
    }

    /// The operating point of such forces.
    fn operating_point(&self, forces: &[f64]) -> OperatingPoint {
        let contact = |(s, &f): (&ContactSpring, &f64)| {
            let force = match s.state {
                ActiveFlank::Open => 0.0,
                _ => f,
            };
            (s.play > 0.0).then_some((s.branch, s.state, Some(force)))
        };
        let springs = || self.springs.iter().zip(forces);
        let idle = idle_force(forces);
        let presses_coast =
            |s: &ContactSpring, f: f64| s.play == 0.0 && s.part.coast.is_some() && f < -idle;
        OperatingPoint {
            contacts: springs().filter_map(contact).collect(),
            coast: springs()
                .filter_map(|(s, &f)| presses_coast(s, f).then_some(s.branch))
                .collect(),
            tangents: springs()
                .filter_map(|(s, &f)| tangent(s.branch, s.part, f))
                .collect(),
        }
    }

    fn find_active_flanks(&mut self) -> Result<Vec<f64>, Error> {
        // The first answer, all closed and centred, decides the flanks of a tree once and for all.
        let forces = self.forces(true)?;
        let idle = idle_force(&forces);
        for (spring, &force) in self.springs.iter_mut().zip(&forces) {
            if spring.play > 0.0 {
                spring.state = state_of(force, idle);
            }
        }
        for _ in 0..4 * self.springs.len() + 10 {
            let forces = self.forces(false)?;
            let wrong = self
                .springs
                .iter()
                .zip(&forces)
                .enumerate()
                .filter(|(_, (s, _))| s.play > 0.0);
            let wrong = wrong
                .filter_map(|(at, (s, &f))| match s.state {
                    ActiveFlank::Drive if f < -idle => Some((at, -f, ActiveFlank::Open)),
                    ActiveFlank::Coast if f > idle => Some((at, f, ActiveFlank::Open)),
                    ActiveFlank::Open if f.abs() > idle => Some((at, f.abs(), state_of(f, 0.0))),
                    _ => None,
                })
                .max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((at, _, state)) = wrong else {
                return Ok(forces);
            };
            self.springs[at].state = state;
        }
        let message = "no state of the contacts with play balances the loads: the iteration cycles";
        Err(Error::new(Code::NoConvergence, message)
            .with_hint("omit the smallest backlash, or change a load slightly"))
    }

    /// Branch forces under the present states; an open contact reports what it would carry beyond its play.
    fn forces(&self, centred: bool) -> Result<Vec<f64>, Error> {
        let offset = |s: &ContactSpring| match s.state {
            _ if centred => 0.0,
            ActiveFlank::Drive => s.play / 2.0,
            ActiveFlank::Coast => -s.play / 2.0,
            ActiveFlank::Open => 0.0,
        };
        let mut k = Matrix::zeros(self.n, self.n);
        let mut f = self.load.clone();
        for s in &self.springs {
            let stiffness = match s.state {
                ActiveFlank::Open if !centred => OPEN_STIFFNESS_RATIO * s.stiffness,
                _ => s.stiffness,
            };
            for (i, a) in s.direction.entries() {
                f[i] += stiffness * a * offset(s);
                for (j, b) in s.direction.entries() {
                    k[(i, j)] += stiffness * a * b;
                }
            }
        }
        let x = symmetric::solve_semidefinite(&k, &f)?;
        Ok(self
            .springs
            .iter()
            .map(|s| {
                let delta = s.direction.dot(&x);
                match s.state {
                    ActiveFlank::Open if !centred => {
                        s.stiffness * (delta - delta.clamp(-s.play / 2.0, s.play / 2.0))
                    }
                    _ => s.stiffness * (delta - offset(s)),
                }
            })
            .collect())
    }
}

/// Combinations of rigid-body motions that leave the coordinates `still` where they are.
fn without(mut motions: Vec<Vec<f64>>, still: &[usize]) -> Vec<Vec<f64>> {
    for &j in still {
        let largest = |r: &[f64]| r.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let share = |r: &[f64]| r[j].abs() / largest(r).max(f64::MIN_POSITIVE);
        let Some(most) =
            (0..motions.len()).max_by(|&a, &b| share(&motions[a]).total_cmp(&share(&motions[b])))
        else {
            continue;
        };
        if share(&motions[most]) < 1e-9 {
            continue; // relative; rounding of motions found in exact fractions is 1e-16
        }
        let pivot = motions.swap_remove(most);
        for r in &mut motions {
            let factor = r[j] / pivot[j];
            r.iter_mut().zip(&pivot).for_each(|(x, p)| *x -= factor * p);
        }
    }
    motions
}

fn tied_dof_error(machine: &Machine, dof: usize) -> Error {
    let message = format!(
        "rigid joints tie {} to several others, so that it cannot be held while the loads are balanced",
        machine.dof_name(dof)
    );
    Error::new(Code::Conflict, message).with_hint("give one of the joints its stiffness k")
}

fn state_of(force: f64, idle: f64) -> ActiveFlank {
    if force > idle {
        ActiveFlank::Drive
    } else if force < -idle {
        ActiveFlank::Coast
    } else {
        ActiveFlank::Open
    }
}
