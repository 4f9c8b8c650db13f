//! Elimination of prescribed coordinates, `q = Σ r x(t) + s`.
//!
//! If a rigid motion carries the prescribed coordinate, r is that motion: x deflects no branch, the other coordinates are loaded by
//! `−M r ẍ` and damping to ground, and a linear model remains linear with known forces. Else r is the coordinate alone, and
//! its motion is imposed on the branches that join it.

use super::combination::LinearCombination;
use super::dynamic_model::{
    AppliedForce, DynamicModel, ForceElement, ForceLaw, MassMatrix, Regime,
};
use super::normal_force::missing_normal_force;
use super::signal::Signal;
use super::wave::{PeriodicFunction, WavePhase};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::direction::Direction;
use crate::numeric::Matrix;

/// Rounding error of an exact cancellation, relative to the summed terms.
const ROUNDING: f64 = 1e-14;

/// Prescribed motion `q_j = x(t)` of a coordinate.
#[derive(Debug, Clone)]
pub struct PrescribedMotion {
    /// Name of the prescribing input.
    pub name: String,
    /// Index of the coordinate in the full model.
    pub coordinate: usize,
    /// Motion x(t), rad or m.
    pub signal: Signal,
    /// Influence vector r over the coordinates of the full model.
    pub influence: Vec<f64>,
}

/// Reduction by prescribed coordinates: the full model and the recovery of its state.
#[derive(Debug, Clone)]
pub struct PrescribedReduction {
    /// Full model with all coordinates.
    pub full_model: DynamicModel,
    /// Indices of the retained coordinates.
    pub retained: Vec<usize>,
    /// Index in the reduced model of every branch of the full model; `None` if it joins prescribed motions alone.
    pub branches: Vec<Option<usize>>,
    /// Prescribed motions.
    pub motions: Vec<PrescribedMotion>,
}

/// Reduced model without prescribed coordinates, with its rigid motions.
pub struct PartitionedModel {
    /// Reduced model, with coordinates s.
    pub model: DynamicModel,
    /// Rigid motions of the reduced model.
    pub rigid: Vec<Vec<f64>>,
    /// Reduction that recovers the full state.
    pub prescribed: PrescribedReduction,
}

/// Eliminates coordinates with known motion from a model; `rigid` are its rigid motions.
///
/// # Errors
/// No free coordinate; a discontinuous speed of a coordinate with inertial coupling to others.
pub fn eliminate(
    full: DynamicModel,
    rigid: &[Vec<f64>],
    known: Vec<(String, usize, Signal)>,
) -> Result<PartitionedModel, Error> {
    let (influences, basis) = influence_vectors(full.coordinate_count(), rigid, &known);
    let motions = known
        .into_iter()
        .zip(influences)
        .map(|((name, coordinate, signal), influence)| PrescribedMotion {
            name,
            coordinate,
            signal,
            influence,
        })
        .collect();
    let (model, prescribed) = eliminate_motions(full, motions)?;
    let free = &prescribed.retained;
    let rigid = basis.iter().map(|r| free.iter().map(|&i| r[i]).collect());
    Ok(PartitionedModel {
        rigid: rigid.collect(),
        model,
        prescribed,
    })
}

/// Eliminates the coordinates of prescribed motions; returns the reduced model and the reduction.
///
/// # Errors
/// Those of [`eliminate`].
pub fn eliminate_motions(
    mut full: DynamicModel,
    motions: Vec<PrescribedMotion>,
) -> Result<(DynamicModel, PrescribedReduction), Error> {
    let is_known = |j: &usize| motions.iter().any(|m| m.coordinate == *j);
    let free: Vec<usize> = (0..full.coordinate_count())
        .filter(|j| !is_known(j))
        .collect();
    if free.is_empty() {
        let message = "every motion is prescribed: there is nothing to compute";
        return Err(Error::new(Code::Conflict, message)
            .with_hint("give a joint between the prescribed body and the others its k"));
    }
    for motion in motions.iter().filter(|m| m.signal.has_kinks()) {
        let momentum = full.momentum(&motion.influence);
        if free.iter().any(|&i| momentum[i] != 0.0) {
            let message = format!(
                "the prescribed speed of `{}` jumps, and its body is coupled to others by inertia",
                motion.name
            );
            return Err(Error::new(Code::Conflict, message)
                .with_hint("replace the jump by a ramp over a short time"));
        }
    }
    let mut branches = Vec::new();
    let numbers = full.elements.iter_mut().map(|branch| {
        let reduced = restrict_element(branch, &free, &motions);
        // Stepped stiffness acts on its angle by impulses alone; their work is counted at the jumps in time.
        if let Some(wave) = &reduced.stiffness_wave
            && wave.waveform.is_piecewise_constant()
            && wave.phase.angle().is_none()
        {
            branch.stiffness_wave.clone_from(&reduced.stiffness_wave);
        }
        (!reduced.direction.terms.is_empty() || reduced.internal_count() > 0).then(|| {
            branches.push(reduced);
            branches.len() - 1
        })
    });
    let numbers: Vec<Option<usize>> = numbers.collect();
    for branch in &mut branches {
        if let ForceLaw::LoadFriction(pressed) = &mut branch.law {
            let moved = pressed.with_coordinates(
                |d| restrict(d, &free),
                |phase| restrict_phase(phase, &free, &motions),
                &numbers,
            );
            **pressed = moved.map_err(|cause| missing_normal_force(&full, &branch.name, cause))?;
        }
    }
    let drives = full.forces.iter().map(|drive| AppliedForce {
        direction: restrict(&drive.direction, &free),
        ..drive.clone()
    });
    let mut drives: Vec<AppliedForce> = drives.filter(|d| !d.direction.terms.is_empty()).collect();
    for motion in &motions {
        drives.extend(induced_forces(&full, motion, &free));
    }
    let model = DynamicModel {
        coordinates: free.iter().map(|&i| full.coordinates[i].clone()).collect(),
        mass: restrict_mass(&full.mass, &free)?,
        elements: branches,
        forces: drives,
        mass_damping: full.mass_damping,
        global_matrices: full.global_matrices.as_ref().map(|(k, c)| {
            let select =
                |a: &Matrix| Matrix::from_fn(free.len(), free.len(), |i, j| a[(free[i], free[j])]);
            (select(k), select(c))
        }),
    };
    let prescribed = PrescribedReduction {
        full_model: full,
        retained: free,
        branches: numbers,
        motions,
    };
    Ok((model, prescribed))
}

impl PrescribedReduction {
    /// State of the full model from the reduced state.
    pub fn state(&self, t: f64, y: &[f64]) -> Vec<f64> {
        let (n, m) = (self.full_model.coordinate_count(), self.retained.len());
        let mut all = vec![0.0; 2 * n];
        for motion in &self.motions {
            let piece = motion.signal.piece(t);
            let (x, rate) = (motion.signal.value(t, piece), motion.signal.slope(t, piece));
            for (i, r) in motion.influence.iter().enumerate() {
                all[i] += r * x;
                all[n + i] += r * rate;
            }
        }
        for (j, &i) in self.retained.iter().enumerate() {
            all[i] += y[j];
            all[n + i] += y[m + j];
        }
        all.extend_from_slice(&y[2 * m..]);
        all
    }

    /// Regime of the full model at its state, from the regime of the reduced model.
    pub fn regime(&self, reduced: &Regime, t: f64, state: &[f64]) -> Regime {
        let full = self.full_model.regime(t, state);
        let sources = self.branches.iter().zip(&full.states);
        Regime {
            states: sources
                .map(|(index, full)| index.map_or(*full, |index| reduced.states[index]))
                .collect(),
            ..full
        }
    }

    /// Coordinates of the full model as combinations of retained coordinates and imposed motions.
    pub fn recovery(&self) -> Vec<Option<LinearCombination>> {
        let dof = |i: usize| {
            let mut dof = match self.retained.binary_search(&i) {
                Ok(j) => LinearCombination::coordinate(j),
                Err(_) => LinearCombination::default(),
            };
            for motion in self.motions.iter().filter(|m| m.influence[i] != 0.0) {
                dof = dof.with_imposed(&motion.signal.scaled(motion.influence[i]));
            }
            Some(dof)
        };
        (0..self.full_model.coordinate_count()).map(dof).collect()
    }

    /// Driving torques of the prescribed motions, positive along them:
    /// `T = [M q̈ + α M q̇ + K₀q + C₀q̇ + Σ u F − f]` of their coordinates, N·m or N.
    pub fn torques(&self, reduced: &DynamicModel, regime: &Regime, t: f64, y: &[f64]) -> Vec<f64> {
        let (n, m) = (self.full_model.coordinate_count(), self.retained.len());
        let mut slope = vec![0.0; y.len()];
        reduced.derivative_in(Some(regime), t, y, &mut slope);
        let state = self.state(t, y);
        let all = self.regime(regime, t, &state);
        let mut forces = self.full_model.applied_forces(Some(&all), t, &state);
        let stick_forces = reduced.stick_forces(
            regime,
            t,
            &reduced.applied_forces(Some(regime), t, y),
            &y[m..2 * m],
        );
        for (&pair, force) in regime.sticking_pairs().iter().zip(stick_forces) {
            let branch = self.branches.iter().position(|b| *b == Some(pair));
            let direction = branch.map(|b| &self.full_model.elements[b].direction);
            direction
                .into_iter()
                .flat_map(Direction::entries)
                .for_each(|(i, a)| forces[i] -= a * force);
        }
        let mut accel: Vec<f64> = (0..n)
            .map(|i| self.full_model.mass_damping * state[n + i])
            .collect();
        for (j, &i) in self.retained.iter().enumerate() {
            accel[i] += slope[m + j];
        }
        for motion in &self.motions {
            let curvature = motion.signal.curvature(t, motion.signal.piece(t));
            let pairs = accel.iter_mut().zip(&motion.influence);
            pairs.for_each(|(a, r)| *a += r * curvature);
        }
        let momentum = self.full_model.momentum(&accel);
        let torque =
            |motion: &PrescribedMotion| momentum[motion.coordinate] - forces[motion.coordinate];
        self.motions.iter().map(torque).collect()
    }

    /// Input power of the prescribed motions at an instant, W.
    pub fn power(&self, reduced: &DynamicModel, regime: &Regime, t: f64, y: &[f64]) -> f64 {
        let torques = self.torques(reduced, regime, t, y);
        let rate = |m: &PrescribedMotion| m.signal.slope(t, m.signal.piece(t));
        self.motions
            .iter()
            .zip(torques)
            .map(|(m, torque)| torque * rate(m))
            .sum()
    }

    /// Impulse work at jumps of prescribed speeds after `from` and until `to`, J.
    pub fn impulse_work(&self, from: f64, to: f64) -> f64 {
        let work = |motion: &PrescribedMotion| {
            let inertia = self.full_model.momentum(&motion.influence)[motion.coordinate];
            let knots = motion.signal.knots.iter().enumerate().skip(1);
            let within = knots.filter(|(_, knot)| knot.time > from && knot.time <= to);
            let jump = |(piece, knot): (usize, &super::signal::Knot)| {
                let before = motion.signal.slope(knot.time, piece);
                let after = motion.signal.slope(knot.time, piece + 1);
                0.5 * inertia * (after - before) * (after + before)
            };
            within.map(jump).sum::<f64>()
        };
        let jumps = self.motions.iter().filter(|m| m.signal.has_kinks());
        jumps.map(work).sum()
    }
}

/// Influence vectors of all motions, and the rigid motions with all prescribed coordinates at rest.
fn influence_vectors(
    n: usize,
    rigid: &[Vec<f64>],
    known: &[(String, usize, Signal)],
) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let mut basis = rigid.to_vec();
    let mut carried: Vec<Option<Vec<f64>>> = vec![None; known.len()];
    for (index, &(_, j, _)) in known.iter().enumerate() {
        let Some(best) = (0..basis.len())
            .filter(|&k| basis[k][j] != 0.0)
            .max_by(|&a, &b| basis[a][j].abs().total_cmp(&basis[b][j].abs()))
        else {
            continue;
        };
        let mut pivot = basis.swap_remove(best);
        let entry = pivot[j];
        pivot.iter_mut().for_each(|x| *x /= entry);
        for other in basis.iter_mut().chain(carried.iter_mut().flatten()) {
            let factor = other[j];
            let largest = other.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            for (x, p) in other.iter_mut().zip(&pivot) {
                let size = x.abs().max((factor * p).abs());
                *x -= factor * p;
                if x.abs() <= ROUNDING * size.max(ROUNDING * largest) {
                    *x = 0.0;
                }
            }
        }
        carried[index] = Some(pivot);
    }
    let decoupled = |index: usize, r: &[f64]| {
        let zero = |(k, &(_, j, _)): (usize, &(String, usize, Signal))| k == index || r[j] == 0.0;
        known.iter().enumerate().all(zero)
    };
    let influence = |(index, &(_, j, ref signal)): (usize, &(String, usize, Signal))| {
        let rigid = carried[index].take();
        // A jump of the speed would be an impulse on all coordinates in r.
        let rigid = rigid.filter(|r| decoupled(index, r) && !signal.has_kinks());
        rigid.unwrap_or_else(|| {
            let mut alone = vec![0.0; n];
            alone[j] = 1.0;
            alone
        })
    };
    let influences = known.iter().enumerate().map(influence).collect();
    (influences, basis)
}

/// Forces induced by a motion on the remaining coordinates: `−M r (ẍ + α ẋ) − K₀ r x − C₀ r ẋ`.
fn induced_forces(
    full: &DynamicModel,
    motion: &PrescribedMotion,
    free: &[usize],
) -> Vec<AppliedForce> {
    let n = full.coordinate_count();
    let momentum = full.momentum(&motion.influence);
    let times = |a: &Matrix| -> Vec<f64> {
        (0..n)
            .map(|i| (0..n).map(|j| a[(i, j)] * motion.influence[j]).sum())
            .collect()
    };
    let rate = motion.signal.rate();
    let mut terms = vec![(momentum.clone(), rate.rate())];
    terms.push((
        momentum.iter().map(|p| full.mass_damping * p).collect(),
        rate.clone(),
    ));
    if let Some((k, c)) = &full.global_matrices {
        terms.push((times(k), motion.signal.clone()));
        terms.push((times(c), rate));
    }
    let drive = |(force, signal): (Vec<f64>, Signal)| AppliedForce {
        name: motion.name.clone(),
        direction: Direction::new(-1.0, free.iter().enumerate().map(|(j, &i)| (j, force[i]))),
        signal,
    };
    let is_acting = |d: &AppliedForce| !d.direction.terms.is_empty() && !d.signal.is_zero();
    terms.into_iter().map(drive).filter(is_acting).collect()
}

fn restrict_element(
    branch: &ForceElement,
    free: &[usize],
    motions: &[PrescribedMotion],
) -> ForceElement {
    let mut reduced = branch.clone();
    reduced.direction = restrict(&branch.direction, free);
    reduced.force_direction = branch.force_direction.as_ref().map(|u| restrict(u, free));
    for motion in motions {
        let component = project(&branch.direction, &motion.influence);
        if component != 0.0 {
            let known = motion.signal.scaled(-component);
            reduced.imposed_displacement = Some(match &reduced.imposed_displacement {
                None => known,
                Some(e) => e.plus(&known),
            });
        }
    }
    reduced.stiffness_wave = branch
        .stiffness_wave
        .as_ref()
        .map(|wave| restrict_wave(wave, free, motions));
    reduced.angle_waves.clear();
    for wave in &branch.angle_waves {
        let wave = restrict_wave(wave, free, motions);
        let WavePhase::Imposed { omega, start } = wave.phase else {
            reduced.angle_waves.push(wave);
            continue;
        };
        let e = wave.waveform.to_signal(omega, start);
        reduced.imposed_displacement = Some(match &reduced.imposed_displacement {
            None => e,
            Some(imposed) => imposed.plus(&e),
        });
    }
    reduced
}

/// Periodic function with prescribed coordinates eliminated from its angle.
fn restrict_wave(
    wave: &PeriodicFunction,
    free: &[usize],
    motions: &[PrescribedMotion],
) -> PeriodicFunction {
    let wave = wave.clone();
    match (restrict_phase(&wave.phase, free, motions), &wave.phase) {
        (WavePhase::Imposed { omega, start }, WavePhase::FollowsAngle { .. }) => {
            wave.imposed(omega, start)
        }
        (phase, _) => PeriodicFunction { phase, ..wave },
    }
}

/// Phase with prescribed coordinates eliminated from its angle.
fn restrict_phase(phase: &WavePhase, free: &[usize], motions: &[PrescribedMotion]) -> WavePhase {
    let WavePhase::FollowsAngle {
        angle,
        start,
        known,
    } = phase
    else {
        return phase.clone();
    };
    let mut known = known.clone();
    for motion in motions {
        let component = project(angle, &motion.influence);
        if component != 0.0 {
            let rotation = motion.signal.scaled(component);
            known = Some(known.map_or(rotation.clone(), |x| x.plus(&rotation)));
        }
    }
    let angle = restrict(angle, free);
    let is_uniform =
        |x: &Signal| x.knots.len() == 1 && x.is_piecewise_linear() && x.harmonics.is_empty();
    match &known {
        Some(x) if angle.terms.is_empty() && is_uniform(x) => {
            let knot = x.knots[0];
            WavePhase::Imposed {
                omega: knot.slope,
                start: start + knot.value_at(0.0),
            }
        }
        _ => WavePhase::FollowsAngle {
            angle,
            start: *start,
            known,
        },
    }
}

/// Inner product `wᵀr`, zero if its terms cancel.
fn project(w: &Direction, r: &[f64]) -> f64 {
    let (sum, size) = w
        .entries()
        .fold((0.0, 0.0), |(sum, size): (f64, f64), (i, a)| {
            (sum + a * r[i], size + (a * r[i]).abs())
        });
    match sum.abs() <= ROUNDING * size {
        true => 0.0,
        false => sum,
    }
}

fn restrict(direction: &Direction, free: &[usize]) -> Direction {
    let index = |i: usize| free.binary_search(&i).ok();
    let terms = direction.terms.iter();
    Direction {
        scale: direction.scale,
        terms: terms
            .filter_map(|&(i, a)| index(i).map(|j| (j, a)))
            .collect(),
    }
}

fn restrict_mass(mass: &MassMatrix, free: &[usize]) -> Result<MassMatrix, Error> {
    Ok(match mass {
        MassMatrix::Diagonal(mass) => MassMatrix::Diagonal(free.iter().map(|&i| mass[i]).collect()),
        MassMatrix::Full { matrix, .. } => {
            let m = free.len();
            MassMatrix::full(Matrix::from_fn(m, m, |i, j| matrix[(free[i], free[j])]))?
        }
    })
}
