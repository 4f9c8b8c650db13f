//! Coordinates whose motion is known in time, taken out of the equations: `q = Σ r x(t) + s`, `rᵀeₓ = 1`, s the rest.
//!
//! Where a rigid motion carries the prescribed coordinate, r is that motion: no branch then sees x, the rest feels `−M r ẍ` and
//! what is damped against ground, and a linear machine stays linear with known forces. Else r is the coordinate alone and
//! its motion is imposed on the branches that join it.

use super::combination::Combination;
use super::pressing::unpressed;
use super::signal::Signal;
use super::train::{Branch, Drive, Law, Mass, Regime, Train};
use super::wave::{Phase, Wave};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::direction::Direction;
use crate::numeric::Matrix;

/// What an exact cancellation leaves of the terms it is summed from.
const ROUNDING: f64 = 1e-14;

/// A coordinate and its motion.
#[derive(Debug, Clone)]
pub struct Motion {
    /// What prescribes it.
    pub name: String,
    /// The coordinate, among those of the whole machine.
    pub coordinate: usize,
    /// x.
    pub course: Signal,
    /// r, over the coordinates of the whole machine.
    pub share: Vec<f64>,
}

/// What was taken out of a machine, and the way back.
#[derive(Debug, Clone)]
pub struct Prescribed {
    /// The machine with every coordinate.
    pub whole: Train,
    /// The coordinates that stay.
    pub kept: Vec<usize>,
    /// Of every branch of the whole machine its number among those that stay; none where it joins prescribed motions alone.
    pub branches: Vec<Option<usize>>,
    /// What is prescribed.
    pub motions: Vec<Motion>,
}

/// A machine without its prescribed coordinates.
pub struct Rest {
    /// Its equations in s.
    pub train: Train,
    /// Rigid motions left in it.
    pub rigid: Vec<Vec<f64>>,
    /// What was taken out.
    pub prescribed: Prescribed,
}

/// Takes coordinates with known motion out of a machine; `rigid` are its rigid motions.
///
/// # Errors
/// Nothing left to move; a speed that jumps where inertia couples the coordinate to others.
pub fn take_out(
    whole: Train,
    rigid: &[Vec<f64>],
    known: Vec<(String, usize, Signal)>,
) -> Result<Rest, Error> {
    let (shares, left) = shares(whole.n(), rigid, &known);
    let motions = known
        .into_iter()
        .zip(shares)
        .map(|((name, coordinate, course), share)| Motion {
            name,
            coordinate,
            course,
            share,
        })
        .collect();
    let (train, prescribed) = without(whole, motions)?;
    let kept = &prescribed.kept;
    let rigid = left.iter().map(|r| kept.iter().map(|&i| r[i]).collect());
    Ok(Rest {
        rigid: rigid.collect(),
        train,
        prescribed,
    })
}

/// A machine without the coordinates that motions prescribe, and the way back.
///
/// # Errors
/// Those of [`take_out`].
pub fn without(mut whole: Train, motions: Vec<Motion>) -> Result<(Train, Prescribed), Error> {
    let is_known = |j: &usize| motions.iter().any(|m| m.coordinate == *j);
    let kept: Vec<usize> = (0..whole.n()).filter(|j| !is_known(j)).collect();
    if kept.is_empty() {
        let message = "every body moves as prescribed: nothing is left to compute";
        return Err(Error::new(Code::Conflict, message)
            .hint("give a joint between the prescribed body and the others its k"));
    }
    for motion in motions.iter().filter(|m| m.course.has_kinks()) {
        let momentum = whole.momentum(&motion.share);
        if kept.iter().any(|&i| momentum[i] != 0.0) {
            let message = format!(
                "the speed that `{}` prescribes jumps, and inertia ties its body to others",
                motion.name
            );
            return Err(Error::new(Code::Conflict, message)
                .hint("let the speed rise over a short time in place of the jump"));
        }
    }
    let mut branches = Vec::new();
    let numbers = whole.branches.iter_mut().map(|branch| {
        let rest = of_branch(branch, &kept, &motions);
        // The torque on the angle of a stiffness in steps is no more than jolts; they are booked where it jumps in time.
        if let Some(wave) = &rest.variation
            && wave.shape.is_steps()
            && wave.phase.angle().is_none()
        {
            branch.variation.clone_from(&rest.variation);
        }
        (!rest.direction.terms.is_empty() || rest.inner() > 0).then(|| {
            branches.push(rest);
            branches.len() - 1
        })
    });
    let numbers: Vec<Option<usize>> = numbers.collect();
    for branch in &mut branches {
        if let Law::Pressed(pressed) = &mut branch.law {
            let moved = pressed.moved(
                |d| restricted(d, &kept),
                |phase| of_phase(phase, &kept, &motions),
                &numbers,
            );
            **pressed = moved.map_err(|by| unpressed(&whole, &branch.name, by))?;
        }
    }
    let drives = whole.drives.iter().map(|drive| Drive {
        direction: restricted(&drive.direction, &kept),
        ..drive.clone()
    });
    let mut drives: Vec<Drive> = drives.filter(|d| !d.direction.terms.is_empty()).collect();
    for motion in &motions {
        drives.extend(felt(&whole, motion, &kept));
    }
    let train = Train {
        coordinates: kept.iter().map(|&i| whole.coordinates[i].clone()).collect(),
        mass: of_mass(&whole.mass, &kept)?,
        branches,
        drives,
        drag: whole.drag,
        general: whole.general.as_ref().map(|(k, c)| {
            let of =
                |a: &Matrix| Matrix::from_fn(kept.len(), kept.len(), |i, j| a[(kept[i], kept[j])]);
            (of(k), of(c))
        }),
    };
    let prescribed = Prescribed {
        whole,
        kept,
        branches: numbers,
        motions,
    };
    Ok((train, prescribed))
}

impl Prescribed {
    /// The state of the whole machine.
    pub fn state(&self, t: f64, y: &[f64]) -> Vec<f64> {
        let (n, m) = (self.whole.n(), self.kept.len());
        let mut all = vec![0.0; 2 * n];
        for motion in &self.motions {
            let piece = motion.course.piece(t);
            let (x, rate) = (motion.course.value(t, piece), motion.course.slope(t, piece));
            for (i, r) in motion.share.iter().enumerate() {
                all[i] += r * x;
                all[n + i] += r * rate;
            }
        }
        for (j, &i) in self.kept.iter().enumerate() {
            all[i] += y[j];
            all[n + i] += y[m + j];
        }
        all.extend_from_slice(&y[2 * m..]);
        all
    }

    /// How the whole machine stands at its state where the rest stands in `rest`.
    pub fn regime(&self, rest: &Regime, t: f64, state: &[f64]) -> Regime {
        let own = self.whole.regime(t, state);
        let stands = self.branches.iter().zip(&own.stands);
        Regime {
            stands: stands
                .map(|(at, own)| at.map_or(*own, |at| rest.stands[at]))
                .collect(),
            pieces: own.pieces,
        }
    }

    /// Every coordinate of the whole machine in those that stay.
    pub fn places(&self) -> Vec<Option<Combination>> {
        let place = |i: usize| {
            let mut place = match self.kept.binary_search(&i) {
                Ok(j) => Combination::of(j),
                Err(_) => Combination::default(),
            };
            for motion in self.motions.iter().filter(|m| m.share[i] != 0.0) {
                place = place.plus(&motion.course.times(motion.share[i]));
            }
            Some(place)
        };
        (0..self.whole.n()).map(place).collect()
    }

    /// The torques with which the motions are kept up, positive along them:
    /// `T = [M q̈ + α M q̇ + K₀q + C₀q̇ + Σ u F − f]` of their coordinates, N·m or N.
    pub fn torques(&self, rest: &Train, regime: &Regime, t: f64, y: &[f64]) -> Vec<f64> {
        let (n, m) = (self.whole.n(), self.kept.len());
        let mut slope = vec![0.0; y.len()];
        rest.slope_in(Some(regime), t, y, &mut slope);
        let state = self.state(t, y);
        let all = self.regime(regime, t, &state);
        let mut pushed = self.whole.pushed(Some(&all), t, &state);
        let holding = rest.holding(regime, t, &rest.pushed(Some(regime), t, y), &y[m..2 * m]);
        for (&at, held) in regime.sticking().iter().zip(holding) {
            let whole = self.branches.iter().position(|b| *b == Some(at));
            let direction = whole.map(|b| &self.whole.branches[b].direction);
            direction
                .into_iter()
                .flat_map(Direction::scaled)
                .for_each(|(i, a)| pushed[i] -= a * held);
        }
        let mut braked: Vec<f64> = (0..n).map(|i| self.whole.drag * state[n + i]).collect();
        for (j, &i) in self.kept.iter().enumerate() {
            braked[i] += slope[m + j];
        }
        for motion in &self.motions {
            let bend = motion.course.curvature(t, motion.course.piece(t));
            let share = braked.iter_mut().zip(&motion.share);
            share.for_each(|(a, r)| *a += r * bend);
        }
        let momentum = self.whole.momentum(&braked);
        let torque = |motion: &Motion| momentum[motion.coordinate] - pushed[motion.coordinate];
        self.motions.iter().map(torque).collect()
    }

    /// What the prescribed motions put in at an instant, W.
    pub fn power(&self, rest: &Train, regime: &Regime, t: f64, y: &[f64]) -> f64 {
        let torques = self.torques(rest, regime, t, y);
        let rate = |m: &Motion| m.course.slope(t, m.course.piece(t));
        self.motions
            .iter()
            .zip(torques)
            .map(|(m, torque)| torque * rate(m))
            .sum()
    }

    /// The work of the jolts where prescribed speeds jump, after `from` and until `to`, J.
    pub fn jolts(&self, from: f64, to: f64) -> f64 {
        let of_motion = |motion: &Motion| {
            let inertia = self.whole.momentum(&motion.share)[motion.coordinate];
            let knots = motion.course.knots.iter().enumerate().skip(1);
            let within = knots.filter(|(_, knot)| knot.time > from && knot.time <= to);
            let jump = |(at, knot): (usize, &super::signal::Knot)| {
                let before = motion.course.slope(knot.time, at);
                let after = motion.course.slope(knot.time, at + 1);
                0.5 * inertia * (after - before) * (after + before)
            };
            within.map(jump).sum::<f64>()
        };
        let jumps = self.motions.iter().filter(|m| m.course.has_kinks());
        jumps.map(of_motion).sum()
    }
}

/// r of every motion, and the rigid motions in which all prescribed coordinates stand still.
fn shares(
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

/// What the rest feels of a motion: `−M r (ẍ + α ẋ) − K₀ r x − C₀ r ẋ`.
fn felt(whole: &Train, motion: &Motion, kept: &[usize]) -> Vec<Drive> {
    let n = whole.n();
    let momentum = whole.momentum(&motion.share);
    let times = |a: &Matrix| -> Vec<f64> {
        (0..n)
            .map(|i| (0..n).map(|j| a[(i, j)] * motion.share[j]).sum())
            .collect()
    };
    let rate = motion.course.rate();
    let mut parts = vec![(momentum.clone(), rate.rate())];
    parts.push((
        momentum.iter().map(|p| whole.drag * p).collect(),
        rate.clone(),
    ));
    if let Some((k, c)) = &whole.general {
        parts.push((times(k), motion.course.clone()));
        parts.push((times(c), rate));
    }
    let drive = |(force, signal): (Vec<f64>, Signal)| Drive {
        name: motion.name.clone(),
        direction: Direction::new(-1.0, kept.iter().enumerate().map(|(j, &i)| (j, force[i]))),
        signal,
    };
    let acts = |d: &Drive| !d.direction.terms.is_empty() && !d.signal.is_zero();
    parts.into_iter().map(drive).filter(acts).collect()
}

fn of_branch(branch: &Branch, kept: &[usize], motions: &[Motion]) -> Branch {
    let mut rest = branch.clone();
    rest.direction = restricted(&branch.direction, kept);
    rest.force = branch.force.as_ref().map(|u| restricted(u, kept));
    for motion in motions {
        let seen = seen(&branch.direction, &motion.share);
        if seen != 0.0 {
            let known = motion.course.times(-seen);
            rest.imposed = Some(match &rest.imposed {
                None => known,
                Some(e) => e.plus(&known),
            });
        }
    }
    rest.variation = branch
        .variation
        .as_ref()
        .map(|wave| of_wave(wave, kept, motions));
    rest.followed.clear();
    for wave in &branch.followed {
        let wave = of_wave(wave, kept, motions);
        let Phase::Imposed { omega, start } = wave.phase else {
            rest.followed.push(wave);
            continue;
        };
        let e = wave.shape.over_time(omega, start);
        rest.imposed = Some(match &rest.imposed {
            None => e,
            Some(imposed) => imposed.plus(&e),
        });
    }
    rest
}

/// A wave whose angle is in part, or wholly, known.
fn of_wave(wave: &Wave, kept: &[usize], motions: &[Motion]) -> Wave {
    match (of_phase(&wave.phase, kept, motions), &wave.phase) {
        (Phase::Imposed { omega, start }, Phase::Followed { .. }) => {
            Wave::imposed(wave.shape.clone(), omega, start)
        }
        (phase, _) => Wave {
            shape: wave.shape.clone(),
            phase,
        },
    }
}

/// A phase that is in part, or wholly, known.
fn of_phase(phase: &Phase, kept: &[usize], motions: &[Motion]) -> Phase {
    let Phase::Followed {
        angle,
        start,
        known,
    } = phase
    else {
        return phase.clone();
    };
    let mut known = known.clone();
    for motion in motions {
        let seen = seen(angle, &motion.share);
        if seen != 0.0 {
            let turn = motion.course.times(seen);
            known = Some(known.map_or(turn.clone(), |x| x.plus(&turn)));
        }
    }
    let angle = restricted(angle, kept);
    let steady = |x: &Signal| x.knots.len() == 1 && x.is_straight() && x.harmonics.is_empty();
    match &known {
        Some(x) if angle.terms.is_empty() && steady(x) => {
            let knot = x.knots[0];
            Phase::Imposed {
                omega: knot.slope,
                start: start + knot.line(0.0),
            }
        }
        _ => Phase::Followed {
            angle,
            start: *start,
            known,
        },
    }
}

/// `wᵀr`, zero where it cancels.
fn seen(w: &Direction, r: &[f64]) -> f64 {
    let (sum, size) = w
        .scaled()
        .fold((0.0, 0.0), |(sum, size): (f64, f64), (i, a)| {
            (sum + a * r[i], size + (a * r[i]).abs())
        });
    match sum.abs() <= ROUNDING * size {
        true => 0.0,
        false => sum,
    }
}

fn restricted(direction: &Direction, kept: &[usize]) -> Direction {
    let place = |i: usize| kept.binary_search(&i).ok();
    let terms = direction.terms.iter();
    Direction {
        scale: direction.scale,
        terms: terms
            .filter_map(|&(i, a)| place(i).map(|j| (j, a)))
            .collect(),
    }
}

fn of_mass(mass: &Mass, kept: &[usize]) -> Result<Mass, Error> {
    Ok(match mass {
        Mass::Diagonal(mass) => Mass::Diagonal(kept.iter().map(|&i| mass[i]).collect()),
        Mass::Full { matrix, .. } => {
            let m = kept.len();
            Mass::full(Matrix::from_fn(m, m, |i, j| matrix[(kept[i], kept[j])]))?
        }
    })
}
