//! Static operating point: contact states and tangent stiffness under mean loads.
//!
//! A free train accelerates under unbalanced loads; inertia forces balance them first (inertia relief).
//! Then `Σ w F(δ) = f` with `F = k (δ ∓ backlash/2)` in contact and zero within the backlash: the minimum of a convex energy. The
//! solver changes the state of the most violated contact until all are consistent. A characteristic is iterated by its secant
//! `F/δ(F)` to a constant force; its tangent is the stiffness for small motions.

use super::characteristic::{MAX_SECANT_ITERATIONS, SECANT_TOLERANCE};
use super::components::{Branch, BranchLaw, Machine};
use super::direction::Direction;
use super::kinematics::Kinematics;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Matrix;
use crate::numeric::symmetric;

/// State of a contact with backlash: drive flank, coast flank or open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ActiveFlank {
    /// Contact on the drive flank, δ > 0, or without backlash.
    Drive,
    /// Contact on the coast flank, δ < 0.
    Coast,
    /// Open contact without stiffness.
    Open,
}

impl ActiveFlank {
    /// Keyword of the state.
    pub fn name(self) -> &'static str {
        match self {
            ActiveFlank::Drive => "drive",
            ActiveFlank::Coast => "coast",
            ActiveFlank::Open => "open",
        }
    }
}

/// Static operating point: states of all contacts with backlash and tangent stiffnesses of nonlinear branches.
#[derive(Debug, Clone, Default)]
pub struct OperatingPoint {
    /// Branch, state and static force, N or N·m (`None` without stated loads).
    pub contacts: Vec<(usize, ActiveFlank, Option<f64>)>,
    /// Meshes without backlash under mean load on the coast flank, with a separate coast direction.
    pub coast: Vec<usize>,
    /// Tangent stiffnesses of nonlinear branches.
    pub tangents: Vec<TangentStiffness>,
}

/// Tangent stiffness of a nonlinear branch at its operating point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TangentStiffness {
    /// Branch index.
    pub branch: usize,
    /// Static force, N or N·m.
    pub force: f64,
    /// Tangent stiffness dF/dδ, N/m or N·m/rad.
    pub stiffness: f64,
}

impl OperatingPoint {
    /// Contact state of a branch; branches without backlash are always closed.
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

    /// Tangent stiffness of a nonlinear branch, N/m or N·m/rad.
    pub fn tangent(&self, branch: usize) -> Option<f64> {
        let entry = self.tangents.iter().find(|t| t.branch == branch);
        entry.map(|t| t.stiffness)
    }

    /// Solves the states of contacts with backlash, the loaded flanks of meshes without backlash and the forces of nonlinear branches.
    /// Without loads all contacts are closed on the drive flank and characteristics are at zero force; so are meshes without backlash of
    /// machines with more than 2 000 degrees of freedom.
    ///
    /// # Errors
    /// No contact state balances the loads; the secant iteration does not converge.
    pub fn solve(machine: &Machine, kinematics: &Kinematics) -> Result<OperatingPoint, Error> {
        let playing = branches_with_backlash(machine);
        let is_nonlinear = |b: &&Branch| b.characteristic.is_some();
        let is_linear = !machine.branches.iter().any(|b| is_nonlinear(&b));
        let has_flanks = has_closed_flanks(machine, kinematics);
        if machine.loads.is_empty() || (playing.is_empty() && is_linear && !has_flanks) {
            let contacts = playing
                .into_iter()
                .map(|b| (b, ActiveFlank::Drive, None))
                .collect();
            let branches = machine.branches.iter().enumerate();
            let tangents = branches.filter_map(|(k, b)| tangent(k, b, 0.0)).collect();
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

/// True if meshes without backlash have flanks of different directions, in a machine small enough for a dense solve.
fn has_closed_flanks(machine: &Machine, kinematics: &Kinematics) -> bool {
    let mut meshes = machine.branches.iter().filter(|b| b.backlash == 0.0);
    kinematics.independent_dofs.len() <= MAX_DENSE_DOFS && meshes.any(|b| b.coast.is_some())
}

/// Static branch forces under the mean loads.
#[derive(Debug, Clone)]
pub struct MeanForces {
    /// Branch index and force, N or N·m.
    pub forces: Vec<(usize, f64)>,
    /// True if the loads do not balance: the machine accelerates.
    pub accelerates: bool,
}

/// Unbalance threshold: work of the loads on a rigid-body motion, relative to its terms; torques are stated to a few digits.
const UNBALANCED: f64 = 1e-3;

/// Static forces of the elastic branches under the mean loads; the degrees of freedom `prescribed` move at constant speed.
///
/// # Errors
/// `Conflict`: rigid joints connect a prescribed degree of freedom to several others. As [`OperatingPoint::solve`].
pub fn mean_forces(
    machine: &Machine,
    kinematics: &Kinematics,
    prescribed: &[usize],
) -> Result<MeanForces, Error> {
    let playing = branches_with_backlash(machine);
    let mut search = ContactSearch::new(machine, kinematics, playing, prescribed)?;
    let forces = search.solve_equilibrium()?;
    Ok(MeanForces {
        accelerates: search.accelerates,
        forces: (search.springs.iter().zip(forces))
            .map(|(spring, force)| (spring.branch, force))
            .collect(),
    })
}

/// Indices of elastic branches with backlash.
fn branches_with_backlash(machine: &Machine) -> Vec<usize> {
    let has_backlash = |b: &usize| {
        machine.branches[*b].backlash > 0.0 && machine.branches[*b].law != BranchLaw::Rigid
    };
    (0..machine.branches.len()).filter(has_backlash).collect()
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

/// Largest number of degrees of freedom for the dense solve of the operating point.
const MAX_DENSE_DOFS: usize = 2000;

/// Force threshold of an unloaded branch: rounding errors lie below.
fn idle_force(forces: &[f64]) -> f64 {
    1e-9 * forces.iter().fold(0.0f64, |m, f| m.max(f.abs()))
}

/// Stiffness ratio of an open contact during the search: without force δ is at the middle of the backlash, and under a force δ
/// leaves the backlash.
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
    /// True if inertia forces balance the loads.
    accelerates: bool,
}

impl<'a> ContactSearch<'a> {
    fn new(
        machine: &'a Machine,
        kinematics: &Kinematics,
        playing: Vec<usize>,
        prescribed: &[usize],
    ) -> Result<ContactSearch<'a>, Error> {
        let n = kinematics.independent_dofs.len();
        if n > MAX_DENSE_DOFS {
            let message = format!(
                "the operating point of {n} degrees of freedom with play needs a dense solve of that size"
            );
            let hint =
                "omit the loads (contacts are then closed on the drive flank), or the backlash";
            return Err(Error::new(Code::BudgetExceeded, message).with_hint(hint));
        }
        let mut fixed = Vec::new();
        for &dof in prescribed {
            match kinematics.in_independent_dofs(dof)[..] {
                [(j, _)] => fixed.push(j),
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
            direction.terms.retain(|(j, _)| !fixed.contains(j));
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
                .filter(|(j, _)| !fixed.contains(j))
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
        let motions = kinematics
            .undeformed_motions(strained)
            .basis(machine.dofs.len());
        let reduced = |motion: Vec<f64>| -> Vec<f64> {
            let independent = kinematics.independent_dofs.iter();
            independent.map(|&i| motion[i]).collect()
        };
        let motions = with_fixed(motions.into_iter().map(reduced).collect(), &fixed);
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

    /// Branch forces in equilibrium with the loads, by secant iteration of the nonlinear branches.
    fn solve_equilibrium(&mut self) -> Result<Vec<f64>, Error> {
        // Forces of a tree do not depend on stiffness: two iterations suffice; loops need more.
        for _ in 0..MAX_SECANT_ITERATIONS {
            let forces = self.find_active_flanks()?;
            let mut change = 0.0f64;
            for (spring, &force) in self.springs.iter_mut().zip(&forces) {
                if let Some(law) = &spring.part.characteristic {
                    change = change.max(law.update_secant(&mut spring.stiffness, force));
                }
            }
            if change <= SECANT_TOLERANCE {
                return Ok(forces);
            }
        }
        let message = "forces in nonlinear couplings and teeth do not converge under mean loads";
        Err(Error::new(Code::NoConvergence, message)
            .with_hint("change a load slightly, or give the stiffness that is meant as k"))
    }

    /// Operating point with the branch forces `forces`.
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
        let loads_coast =
            |s: &ContactSpring, f: f64| s.play == 0.0 && s.part.coast.is_some() && f < -idle;
        OperatingPoint {
            contacts: springs().filter_map(contact).collect(),
            coast: springs()
                .filter_map(|(s, &f)| loads_coast(s, f).then_some(s.branch))
                .collect(),
            tangents: springs()
                .filter_map(|(s, &f)| tangent(s.branch, s.part, f))
                .collect(),
        }
    }

    fn find_active_flanks(&mut self) -> Result<Vec<f64>, Error> {
        // The first solution, all contacts closed and centred, gives the final contact states of a tree.
        let forces = self.forces(true)?;
        let idle = idle_force(&forces);
        for (spring, &force) in self.springs.iter_mut().zip(&forces) {
            if spring.play > 0.0 {
                spring.state = state_of(force, idle);
            }
        }
        for _ in 0..4 * self.springs.len() + 10 {
            let forces = self.forces(false)?;
            let with_backlash = self
                .springs
                .iter()
                .zip(&forces)
                .enumerate()
                .filter(|(_, (s, _))| s.play > 0.0);
            let violated = with_backlash
                .filter_map(|(k, (s, &f))| match s.state {
                    ActiveFlank::Drive if f < -idle => Some((k, -f, ActiveFlank::Open)),
                    ActiveFlank::Coast if f > idle => Some((k, f, ActiveFlank::Open)),
                    ActiveFlank::Open if f.abs() > idle => Some((k, f.abs(), state_of(f, 0.0))),
                    _ => None,
                })
                .max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((index, _, state)) = violated else {
                return Ok(forces);
            };
            self.springs[index].state = state;
        }
        let message = "no contact state balances the loads: the iteration cycles";
        Err(Error::new(Code::NoConvergence, message)
            .with_hint("omit the smallest backlash, or change a load slightly"))
    }

    /// Branch forces for the current contact states; the force of an open contact is that of its deflection beyond the backlash.
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
                let deflection = s.direction.dot(&x);
                match s.state {
                    ActiveFlank::Open if !centred => {
                        s.stiffness * (deflection - deflection.clamp(-s.play / 2.0, s.play / 2.0))
                    }
                    _ => s.stiffness * (deflection - offset(s)),
                }
            })
            .collect())
    }
}

/// Combinations of rigid-body motions with zero displacement of the coordinates `fixed`.
fn with_fixed(mut motions: Vec<Vec<f64>>, fixed: &[usize]) -> Vec<Vec<f64>> {
    for &j in fixed {
        let largest = |r: &[f64]| r.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let share = |r: &[f64]| r[j].abs() / largest(r).max(f64::MIN_POSITIVE);
        let Some(pivot_index) =
            (0..motions.len()).max_by(|&a, &b| share(&motions[a]).total_cmp(&share(&motions[b])))
        else {
            continue;
        };
        if share(&motions[pivot_index]) < 1e-9 {
            continue; // relative; rounding of motions found in exact fractions is 1e-16
        }
        let pivot = motions.swap_remove(pivot_index);
        for r in &mut motions {
            let factor = r[j] / pivot[j];
            r.iter_mut().zip(&pivot).for_each(|(x, p)| *x -= factor * p);
        }
    }
    motions
}

fn tied_dof_error(machine: &Machine, dof: usize) -> Error {
    let message = format!(
        "rigid joints tie {} to several others, so that it cannot be fixed to balance the loads",
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
