//! The branch nearest to trouble: the one that most likely made a step fail, that switched most, that swings fastest.

use std::f64::consts::TAU;

use super::train::{Branch, Law, Train};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::units::{figure, instant};
use crate::base::words::counted;

/// The error, with the branch nearest to a switch named in its hint.
#[must_use]
pub fn beside(mut error: Error, train: &Train, t: f64, y: &[f64]) -> Error {
    if let Some(name) = nearest(train, t, y) {
        let hint = error.hint.unwrap_or_default();
        error.hint = Some(format!(
            "{hint}; at the last sample, t = {}, branch {name} is nearest to switching",
            instant(t)
        ));
    }
    error
}

/// The branch nearest to a switch: a contact by its distance from the edge over its play, a friction pair by its rate over
/// its creep speed.
pub fn nearest<'t>(train: &'t Train, t: f64, y: &[f64]) -> Option<&'t str> {
    let n = train.n();
    let (q, v) = (&y[..n], &y[n..2 * n]);
    let distance = |b: &Branch| {
        let piece = b.imposed.as_ref().map_or(0, |e| e.piece(t) as u32);
        let (delta, rate) = b.deflection(t, q, v, piece);
        match &b.law {
            Law::Contact(contact) if contact.opens() => {
                Some((delta.abs() - contact.half).abs() / contact.half.max(f64::MIN_POSITIVE))
            }
            Law::Friction(friction) | Law::Clutch { friction, .. } => {
                Some(rate.abs() / friction.creep)
            }
            Law::Pressed(pressed) => Some(rate.abs() / pressed.friction.creep),
            _ => None,
        }
    };
    train
        .branches
        .iter()
        .filter_map(|b| distance(b).map(|d| (d, b.name.as_str())))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}

/// A refusal as hopeless, with the branch that switched most: `switches` of each.
#[must_use]
pub fn busiest(mut error: Error, train: &Train, switches: &[u64]) -> Error {
    let most = (0..switches.len()).max_by_key(|&at| switches[at]);
    if let Some(at) = most.filter(|&at| switches[at] > 0 && error.code == Code::Hopeless) {
        let times = counted(switches[at] as usize, "time");
        error.message += &format!("; `{}` switched most, {times}", train.branches[at].name);
    }
    error
}

/// A refusal as hopeless, with the fastest free motion: where steps follow it, it is what costs.
#[must_use]
pub fn swiftest(mut error: Error, train: &Train) -> Error {
    if let Some(found) = fastest(train).filter(|_| error.code == Code::Hopeless) {
        let hint = error.hint.unwrap_or_default();
        error.hint = Some(format!("{hint}; {}", found.told()));
    }
    error
}

/// The fastest free motion of a machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fastest<'t> {
    /// At least so fast, rad/s.
    pub rate: f64,
    /// The branch that holds the largest share of its strain energy.
    pub branch: &'t str,
    /// That share.
    pub share: f64,
}

impl Fastest<'_> {
    /// In words.
    pub fn told(&self) -> String {
        let Fastest {
            rate,
            branch,
            share,
        } = self;
        let told = match rate / TAU {
            f if f >= 1e12 => format!("{} Hz", figure(f)),
            f if f >= 1e6 => format!("{:.1} MHz", 1e-6 * f),
            f if f >= 1e3 => format!("{:.1} kHz", 1e-3 * f),
            f => format!("{f:.1} Hz"),
        };
        format!(
            "the fastest free motion, {told}, is that of `{branch}` ({:.0} % of its energy)",
            100.0 * share
        )
    }
}

/// Rounds of the power method; the value never falls, and has settled to a few per cent long before.
const ROUNDS: usize = 40;

/// The fastest free motion over the springs that always act. Absent where none does.
pub fn fastest(train: &Train) -> Option<Fastest<'_>> {
    fastest_of(train, train.branches.iter().filter_map(spring).collect())
}

/// The fastest free motion while every contact carries and every stiffness wave is at its crest. Absent where there is no spring.
pub fn fastest_closed(train: &Train) -> Option<Fastest<'_>> {
    fastest_of(train, train.branches.iter().filter_map(closed).collect())
}

/// By the power method on M⁻¹K from the branch that would be fastest by itself; Rayleigh's quotient is no larger than the largest ω²
/// (Courant and Fischer).
fn fastest_of<'t>(train: &'t Train, springs: Vec<(&'t Branch, f64)>) -> Option<Fastest<'t>> {
    let along = |b: &Branch| {
        let mut x = vec![0.0; train.n()];
        b.direction.scaled().for_each(|(i, a)| x[i] += a);
        train.accelerate(&mut x);
        x
    };
    let alone = |(b, k): &(&Branch, f64)| k * b.direction.dot(&along(b));
    let first = springs
        .iter()
        .max_by(|a, b| alone(a).total_cmp(&alone(b)))?;
    let mut x = along(first.0);
    let (mut square, mut energies) = (0.0, Vec::new());
    for _ in 0..ROUNDS {
        let inertia: f64 = train.momentum(&x).iter().zip(&x).map(|(p, v)| p * v).sum();
        let size = inertia.sqrt();
        if !(size > 0.0 && size.is_finite()) {
            return None;
        }
        x.iter_mut().for_each(|x| *x /= size);
        let mut force = vec![0.0; train.n()];
        energies.clear();
        for (b, k) in &springs {
            let delta = b.direction.dot(&x);
            energies.push(k * delta * delta);
            b.direction
                .scaled()
                .for_each(|(i, a)| force[i] += a * k * delta);
        }
        square = energies.iter().sum();
        train.accelerate(&mut force);
        x = force;
    }
    let at = (0..springs.len()).max_by(|&a, &b| energies[a].total_cmp(&energies[b]))?;
    (square > 0.0 && square.is_finite()).then(|| Fastest {
        rate: square.sqrt(),
        branch: &springs[at].0.name,
        share: energies[at] / square,
    })
}

/// The least stiffness of a branch that always acts.
fn spring(branch: &Branch) -> Option<(&Branch, f64)> {
    let k = match &branch.law {
        Law::Linear { stiffness, .. } => *stiffness,
        Law::Contact(contact) if !contact.opens() => contact.stiffness,
        _ => return None,
    };
    let least = branch.variation.as_ref().map_or(1.0, |w| w.shape.least());
    let same = branch.force.is_none();
    (same && k * least > 0.0).then_some((branch, k * least))
}

/// The greatest stiffness of a branch.
fn closed(branch: &Branch) -> Option<(&Branch, f64)> {
    let k = match &branch.law {
        Law::Linear { stiffness, .. } => *stiffness,
        Law::Contact(contact) => contact.stiffness,
        _ => return None,
    };
    let greatest = k * branch.greatest_factor();
    (branch.force.is_none() && greatest > 0.0).then_some((branch, greatest))
}
