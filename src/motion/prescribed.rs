//! Elimination of prescribed coordinates, `q = Σ r x(t) + s`.
//!
//! Where a rigid motion carries the prescribed coordinate, r is that motion: no branch then sees x, the rest feels `−M r ẍ` and
//! what is damped against ground, and a linear machine stays linear with known forces. Else r is the coordinate alone and
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

/// Rounding left by an exact cancellation, relative to the terms it is summed from.
const ROUNDING: f64 = 1e-14;

/// A coordinate and its motion.
#[derive(Debug, Clone)]
pub struct PrescribedMotion {
    /// Name of the prescribing input.
    pub name: String,
    /// The coordinate, among those of the whole machine.
    pub coordinate: usize,
    /// x.
    pub signal: Signal,
    /// r, over the coordinates of the whole machine.
    pub influence: Vec<f64>,
}

/// Prescribed coordinates removed from a machine, and the map back.
#[derive(Debug, Clone)]
pub struct PrescribedReduction {
    /// The machine with every coordinate.
    pub whole: DynamicModel,
    /// The independent coordinates.
    pub retained: Vec<usize>,
    /// Retained number of every branch of the whole machine; `None` where it joins prescribed motions alone.
    pub branches: Vec<Option<usize>>,
    /// Prescribed motions.
    pub motions: Vec<PrescribedMotion>,
}

/// A machine without its prescribed coordinates.
pub struct PartitionedModel {
    /// Equations of the machine in s.
    pub model: DynamicModel,
    /// Rigid motions left in it.
    pub rigid: Vec<Vec<f64>>,
    /// Prescribed coordinates that were removed.
    pub prescribed: PrescribedReduction,
}

/// Takes coordinates with known motion out of a machine; `rigid` are its rigid motions.
///
/// # Errors
/// Nothing left to move; a speed that jumps where inertia couples the coordinate to others.
pub fn eliminate(
    whole: DynamicModel,
    rigid: &[Vec<f64>],
    known: Vec<(String, usize, Signal)>,
) -> Result<PartitionedModel, Error> {
    let (shares, left) = influence_vectors(whole.coordinate_count(), rigid, &known);
    let motions = known
        .into_iter()
        .zip(shares)
        .map(|((name, coordinate, course), share)| PrescribedMotion {
            name,
            coordinate,
            signal: course,
            influence: share,
        })
        .collect();
    let (model, prescribed) = eliminate_motions(whole, motions)?;
    let kept = &prescribed.retained;
    let rigid = left.iter().map(|r| kept.iter().map(|&i| r[i]).collect());
    Ok(PartitionedModel {
        rigid: rigid.collect(),
        model,
        prescribed,
    })
}

/// A machine without the coordinates that motions prescribe, and the way back.
///
/// # Errors
/// Those of [`eliminate`].
pub fn eliminate_motions(
    mut whole: DynamicModel,
    motions: Vec<PrescribedMotion>,
) -> Result<(DynamicModel, PrescribedReduction), Error> {
    let is_known = |j: &usize| motions.iter().any(|m| m.coordinate == *j);
    let kept: Vec<usize> = (0..whole.coordinate_count())
        .filter(|j| !is_known(j))
        .collect();
    if kept.is_empty() {
        let message = "every body moves as prescribed: nothing is left to compute";
        return Err(Error::new(Code::Conflict, message)
            .with_hint("give a joint between the prescribed body and the others its k"));
    }
    for motion in motions.iter().filter(|m| m.signal.has_kinks()) {
        let momentum = whole.momentum(&motion.influence);
        if kept.iter().any(|&i| momentum[i] != 0.0) {
            let message = format!(
                "the speed that `{}` prescribes jumps, and inertia ties its body to others",
                motion.name
            );
            return Err(Error::new(Code::Conflict, message)
                .with_hint("let the speed rise over a short time in place of the jump"));
        }
    }
    let mut branches = Vec::new();
    let numbers = whole.elements.iter_mut().map(|branch| {
        let rest = restrict_element(branch, &kept, &motions);
        // The torque on the angle of a stiffness in steps is no more than jolts; they are booked where it jumps in time.
        if let Some(wave) = &rest.stiffness_wave
            && wave.waveform.is_piecewise_constant()
            && wave.phase.angle().is_none()
        {
            branch.stiffness_wave.clone_from(&rest.stiffness_wave);
        }
        (!rest.direction.terms.is_empty() || rest.internal_count() > 0).then(|| {
            branches.push(rest);
            branches.len() - 1
        })
    });
    let numbers: Vec<Option<usize>> = numbers.collect();
    for branch in &mut branches {
        if let ForceLaw::LoadFriction(pressed) = &mut branch.law {
            let moved = pressed.with_coordinates(
                |d| restrict(d, &kept),
                |phase| restrict_phase(phase, &kept, &motions),
                &numbers,
            );
            **pressed = moved.map_err(|by| missing_normal_force(&whole, &branch.name, by))?;
        }
    }
    let drives = whole.forces.iter().map(|drive| AppliedForce {
        direction: restrict(&drive.direction, &kept),
        ..drive.clone()
    });
    let mut drives: Vec<AppliedForce> = drives.filter(|d| !d.direction.terms.is_empty()).collect();
    for motion in &motions {
        drives.extend(induced_forces(&whole, motion, &kept));
    }
    let model = DynamicModel {
        coordinates: kept.iter().map(|&i| whole.coordinates[i].clone()).collect(),
        mass: restrict_mass(&whole.mass, &kept)?,
        elements: branches,
        forces: drives,
        mass_damping: whole.mass_damping,
        unattached: whole.unattached.as_ref().map(|(k, c)| {
            let of =
                |a: &Matrix| Matrix::from_fn(kept.len(), kept.len(), |i, j| a[(kept[i], kept[j])]);
            (of(k), of(c))
        }),
    };
    let prescribed = PrescribedReduction {
        whole,
        retained: kept,
        branches: numbers,
        motions,
    };
    Ok((model, prescribed))
}

impl PrescribedReduction {
    /// The state of the whole machine.
    pub fn state(&self, t: f64, y: &[f64]) -> Vec<f64> {
        let (n, m) = (self.whole.coordinate_count(), self.retained.len());
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

    /// Regime of the whole machine at its state, from the regime `rest` of the remaining part.
    pub fn regime(&self, rest: &Regime, t: f64, state: &[f64]) -> Regime {
        let own = self.whole.regime(t, state);
        let sources = self.branches.iter().zip(&own.states);
        Regime {
            states: sources
                .map(|(at, own)| at.map_or(*own, |at| rest.states[at]))
                .collect(),
            ..own
        }
    }

    /// Every coordinate of the whole machine in those that stay.
    pub fn recovery(&self) -> Vec<Option<LinearCombination>> {
        let place = |i: usize| {
            let mut place = match self.retained.binary_search(&i) {
                Ok(j) => LinearCombination::coordinate(j),
                Err(_) => LinearCombination::default(),
            };
            for motion in self.motions.iter().filter(|m| m.influence[i] != 0.0) {
                place = place.with_imposed(&motion.signal.scaled(motion.influence[i]));
            }
            Some(place)
        };
        (0..self.whole.coordinate_count()).map(place).collect()
    }

    /// The torques with which the motions are kept up, positive along them:
    /// `T = [M q̈ + α M q̇ + K₀q + C₀q̇ + Σ u F − f]` of their coordinates, N·m or N.
    pub fn torques(&self, rest: &DynamicModel, regime: &Regime, t: f64, y: &[f64]) -> Vec<f64> {
        let (n, m) = (self.whole.coordinate_count(), self.retained.len());
        let mut slope = vec![0.0; y.len()];
        rest.derivative_in(Some(regime), t, y, &mut slope);
        let state = self.state(t, y);
        let all = self.regime(regime, t, &state);
        let mut pushed = self.whole.applied_forces(Some(&all), t, &state);
        let holding = rest.stick_forces(
            regime,
            t,
            &rest.applied_forces(Some(regime), t, y),
            &y[m..2 * m],
        );
        for (&at, held) in regime.sticking_pairs().iter().zip(holding) {
            let whole = self.branches.iter().position(|b| *b == Some(at));
            let direction = whole.map(|b| &self.whole.elements[b].direction);
            direction
                .into_iter()
                .flat_map(Direction::entries)
                .for_each(|(i, a)| pushed[i] -= a * held);
        }
        let mut braked: Vec<f64> = (0..n)
            .map(|i| self.whole.mass_damping * state[n + i])
            .collect();
        for (j, &i) in self.retained.iter().enumerate() {
            braked[i] += slope[m + j];
        }
        for motion in &self.motions {
            let bend = motion.signal.curvature(t, motion.signal.piece(t));
            let share = braked.iter_mut().zip(&motion.influence);
            share.for_each(|(a, r)| *a += r * bend);
        }
        let momentum = self.whole.momentum(&braked);
        let torque =
            |motion: &PrescribedMotion| momentum[motion.coordinate] - pushed[motion.coordinate];
        self.motions.iter().map(torque).collect()
    }

    /// Power put in by the prescribed motions at an instant, W.
    pub fn power(&self, rest: &DynamicModel, regime: &Regime, t: f64, y: &[f64]) -> f64 {
        let torques = self.torques(rest, regime, t, y);
        let rate = |m: &PrescribedMotion| m.signal.slope(t, m.signal.piece(t));
        self.motions
            .iter()
            .zip(torques)
            .map(|(m, torque)| torque * rate(m))
            .sum()
    }

    /// The work of the jolts where prescribed speeds jump, after `from` and until `to`, J.
    pub fn impulse_work(&self, from: f64, to: f64) -> f64 {
        let of_motion = |motion: &PrescribedMotion| {
            let inertia = self.whole.momentum(&motion.influence)[motion.coordinate];
            let knots = motion.signal.knots.iter().enumerate().skip(1);
            let within = knots.filter(|(_, knot)| knot.time > from && knot.time <= to);
            let jump = |(at, knot): (usize, &super::signal::Knot)| {
                let before = motion.signal.slope(knot.time, at);
                let after = motion.signal.slope(knot.time, at + 1);
                0.5 * inertia * (after - before) * (after + before)
            };
            within.map(jump).sum::<f64>()
        };
        let jumps = self.motions.iter().filter(|m| m.signal.has_kinks());
        jumps.map(of_motion).sum()
    }
}

/// r of every motion, and the rigid motions in which all prescribed coordinates are at rest.
fn influence_vectors(
    n: usize,
    rigid: &[Vec<f64>],
    known: &[(String, usize, Signal)],
) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let mut left = rigid.to_vec();
    let mut carried: Vec<Option<Vec<f64>>> = vec![None; known.len()];
    for (at, &(_, j, _)) in known.iter().enumerate() {
        let Some(best) = (0..left.len())
            .filter(|&k| left[k][j] != 0.0)
            .max_by(|&a, &b| left[a][j].abs().total_cmp(&left[b][j].abs()))
        else {
            continue;
        };
        let mut pivot = left.swap_remove(best);
        let own = pivot[j];
        pivot.iter_mut().for_each(|x| *x /= own);
        for other in left.iter_mut().chain(carried.iter_mut().flatten()) {
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
        carried[at] = Some(pivot);
    }
    let others = |at: usize, r: &[f64]| {
        let still = |(k, &(_, j, _)): (usize, &(String, usize, Signal))| k == at || r[j] == 0.0;
        known.iter().enumerate().all(still)
    };
    let share = |(at, &(_, j, ref course)): (usize, &(String, usize, Signal))| {
        let rigid = carried[at].take();
        // A jump of the speed would jolt all that r carries along.
        let rigid = rigid.filter(|r| others(at, r) && !course.has_kinks());
        rigid.unwrap_or_else(|| {
            let mut alone = vec![0.0; n];
            alone[j] = 1.0;
            alone
        })
    };
    let shares = known.iter().enumerate().map(share).collect();
    (shares, left)
}

/// Forces induced by a motion on the remaining coordinates: `−M r (ẍ + α ẋ) − K₀ r x − C₀ r ẋ`.
fn induced_forces(
    whole: &DynamicModel,
    motion: &PrescribedMotion,
    kept: &[usize],
) -> Vec<AppliedForce> {
    let n = whole.coordinate_count();
    let momentum = whole.momentum(&motion.influence);
    let times = |a: &Matrix| -> Vec<f64> {
        (0..n)
            .map(|i| (0..n).map(|j| a[(i, j)] * motion.influence[j]).sum())
            .collect()
    };
    let rate = motion.signal.rate();
    let mut parts = vec![(momentum.clone(), rate.rate())];
    parts.push((
        momentum.iter().map(|p| whole.mass_damping * p).collect(),
        rate.clone(),
    ));
    if let Some((k, c)) = &whole.unattached {
        parts.push((times(k), motion.signal.clone()));
        parts.push((times(c), rate));
    }
    let drive = |(force, signal): (Vec<f64>, Signal)| AppliedForce {
        name: motion.name.clone(),
        direction: Direction::new(-1.0, kept.iter().enumerate().map(|(j, &i)| (j, force[i]))),
        signal,
    };
    let acts = |d: &AppliedForce| !d.direction.terms.is_empty() && !d.signal.is_zero();
    parts.into_iter().map(drive).filter(acts).collect()
}

fn restrict_element(
    branch: &ForceElement,
    kept: &[usize],
    motions: &[PrescribedMotion],
) -> ForceElement {
    let mut rest = branch.clone();
    rest.direction = restrict(&branch.direction, kept);
    rest.force_direction = branch.force_direction.as_ref().map(|u| restrict(u, kept));
    for motion in motions {
        let seen = project(&branch.direction, &motion.influence);
        if seen != 0.0 {
            let known = motion.signal.scaled(-seen);
            rest.imposed_displacement = Some(match &rest.imposed_displacement {
                None => known,
                Some(e) => e.plus(&known),
            });
        }
    }
    rest.stiffness_wave = branch
        .stiffness_wave
        .as_ref()
        .map(|wave| restrict_wave(wave, kept, motions));
    rest.angle_waves.clear();
    for wave in &branch.angle_waves {
        let wave = restrict_wave(wave, kept, motions);
        let WavePhase::Imposed { omega, start } = wave.phase else {
            rest.angle_waves.push(wave);
            continue;
        };
        let e = wave.waveform.to_signal(omega, start);
        rest.imposed_displacement = Some(match &rest.imposed_displacement {
            None => e,
            Some(imposed) => imposed.plus(&e),
        });
    }
    rest
}

/// A wave whose angle is in part, or wholly, known.
fn restrict_wave(
    wave: &PeriodicFunction,
    kept: &[usize],
    motions: &[PrescribedMotion],
) -> PeriodicFunction {
    let wave = wave.clone();
    match (restrict_phase(&wave.phase, kept, motions), &wave.phase) {
        (WavePhase::Imposed { omega, start }, WavePhase::FollowsAngle { .. }) => {
            wave.imposed(omega, start)
        }
        (phase, _) => PeriodicFunction { phase, ..wave },
    }
}

/// A phase that is in part, or wholly, known.
fn restrict_phase(phase: &WavePhase, kept: &[usize], motions: &[PrescribedMotion]) -> WavePhase {
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
        let seen = project(angle, &motion.influence);
        if seen != 0.0 {
            let turn = motion.signal.scaled(seen);
            known = Some(known.map_or(turn.clone(), |x| x.plus(&turn)));
        }
    }
    let angle = restrict(angle, kept);
    let steady =
        |x: &Signal| x.knots.len() == 1 && x.is_piecewise_linear() && x.harmonics.is_empty();
    match &known {
        Some(x) if angle.terms.is_empty() && steady(x) => {
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

/// `wᵀr`, zero where it cancels.
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

fn restrict(direction: &Direction, kept: &[usize]) -> Direction {
    let place = |i: usize| kept.binary_search(&i).ok();
    let terms = direction.terms.iter();
    Direction {
        scale: direction.scale,
        terms: terms
            .filter_map(|&(i, a)| place(i).map(|j| (j, a)))
            .collect(),
    }
}

fn restrict_mass(mass: &MassMatrix, kept: &[usize]) -> Result<MassMatrix, Error> {
    Ok(match mass {
        MassMatrix::Diagonal(mass) => MassMatrix::Diagonal(kept.iter().map(|&i| mass[i]).collect()),
        MassMatrix::Full { matrix, .. } => {
            let m = kept.len();
            MassMatrix::full(Matrix::from_fn(m, m, |i, j| matrix[(kept[i], kept[j])]))?
        }
    })
}
