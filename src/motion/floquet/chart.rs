//! Speeds at which a machine cannot run: where its varying stiffness feeds a motion, near `(ω_i + ω_j)/n`.

use super::{NEUTRAL, monodromy};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::stop::Stop;
use crate::motion::methods::periodic::grid::frequencies;
use crate::motion::train::{Branch, Law, Train};
use crate::motion::wave::Phase;
use crate::numeric::{Matrix, definite};

/// An interval of unstable speeds, by the frequency the whole machine repeats with, rad/s.
#[derive(Debug, Clone, PartialEq)]
pub struct Tongue {
    /// Its lower edge, rad/s.
    pub from: f64,
    /// Its upper edge, rad/s.
    pub to: f64,
    /// Where growth is largest, rad/s.
    pub worst: f64,
    /// The largest multiplier there: growth in a period.
    pub growth: f64,
    /// The resonance of the lowest order within it, else the nearest, such as `2 ω1`, `(ω1 + ω2)/3`; modes are counted from one,
    /// free turning left out.
    pub name: String,
}

/// Edges are found to this, relative.
const EDGE: f64 = 1e-6;

/// Highest order of a resonance that gets a name.
const HIGHEST_ORDER: u32 = 8;

/// Unstable speeds between two factors on all speeds of a machine, all contacts closed. Looked at in `points` equal steps: tongues
/// narrower than a step can be missed.
///
/// # Errors
/// What the periodic method refuses; `Interrupted` where it was ended.
pub fn tongues(
    train: &Train,
    [from, to]: [f64; 2],
    points: usize,
    stop: &Stop,
) -> Result<Vec<Tongue>, Error> {
    let base = base_frequency(train)?;
    let growth = |factor: f64| -> Result<f64, Error> {
        if stop.is_due() {
            return Err(Error::new(Code::Interrupted, "the chart was not finished"));
        }
        let multipliers = monodromy(&at_speed(train, factor), None)?.multipliers()?;
        Ok(multipliers.largest)
    };
    let factor = |at: usize| from + (to - from) * at as f64 / points.max(1) as f64;
    let seen: Result<Vec<f64>, Error> = (0..=points).map(|at| growth(factor(at))).collect();
    let seen = seen?;
    let unstable = |at: usize| seen[at] > 1.0 + NEUTRAL;
    let mut tongues = Vec::new();
    let mut at = 0;
    while at <= points {
        if !unstable(at) {
            at += 1;
            continue;
        }
        let first = at;
        while at < points && unstable(at + 1) {
            at += 1;
        }
        let last = at;
        let low = match first {
            0 => factor(0),
            _ => edge(&growth, factor(first), factor(first - 1))?,
        };
        let high = match last == points {
            true => factor(points),
            false => edge(&growth, factor(last), factor(last + 1))?,
        };
        let top = (first..=last).fold(first, |a, b| if seen[b] > seen[a] { b } else { a });
        let near = [
            factor(top.saturating_sub(1)).max(low),
            factor((top + 1).min(points)).min(high),
        ];
        let (worst, growth) = highest(&growth, near)?;
        tongues.push(Tongue {
            from: low * base,
            to: high * base,
            worst: worst * base,
            growth,
            name: name(train, base, [low * base, worst * base, high * base])?,
        });
        at += 1;
    }
    Ok(tongues)
}

/// The machine with every wave and harmonic load faster by a factor.
pub fn at_speed(train: &Train, factor: f64) -> Train {
    let mut train = train.clone();
    for b in &mut train.branches {
        for wave in b.variation.iter_mut().chain(&mut b.followed) {
            if let Phase::Imposed { omega, .. } = &mut wave.phase {
                *omega *= factor;
            }
        }
        let harmonics = b.imposed.iter_mut().flat_map(|e| &mut e.harmonics);
        harmonics.for_each(|h| h.omega *= factor);
    }
    let harmonics = train
        .drives
        .iter_mut()
        .flat_map(|d| &mut d.signal.harmonics);
    harmonics.for_each(|h| h.omega *= factor);
    train
}

/// 2π over the common period, rad/s.
fn base_frequency(train: &Train) -> Result<f64, Error> {
    Ok(std::f64::consts::TAU / monodromy(train, None)?.period)
}

/// The edge between an unstable factor and a stable one, by bisection.
fn edge(
    growth: &impl Fn(f64) -> Result<f64, Error>,
    mut unstable: f64,
    mut stable: f64,
) -> Result<f64, Error> {
    while (unstable - stable).abs() > EDGE * stable.abs().max(unstable.abs()) {
        let middle = 0.5 * (unstable + stable);
        match growth(middle)? > 1.0 + NEUTRAL {
            true => unstable = middle,
            false => stable = middle,
        }
    }
    Ok(unstable)
}

/// Where growth is largest between two factors, by golden section.
fn highest(
    growth: &impl Fn(f64) -> Result<f64, Error>,
    [mut a, mut d]: [f64; 2],
) -> Result<(f64, f64), Error> {
    let share = 0.5 * (5f64.sqrt() - 1.0);
    let (mut b, mut c) = (d - share * (d - a), a + share * (d - a));
    let (mut at_b, mut at_c) = (growth(b)?, growth(c)?);
    while d - a > 1e-4 * d.abs() {
        if at_b > at_c {
            (d, c, at_c) = (c, b, at_b);
            b = d - share * (d - a);
            at_b = growth(b)?;
        } else {
            (a, b, at_b) = (b, c, at_c);
            c = a + share * (d - a);
            at_c = growth(c)?;
        }
    }
    Ok(if at_b > at_c { (b, at_b) } else { (c, at_c) })
}

/// The `(ω_i + ω_j)/n` of the mean machine, by the frequency of one of its waves, that a tongue from `low` to `high` is named by.
/// High orders lie everywhere, so that of the lowest order within the tongue goes before one that lies nearer to its top.
fn name(train: &Train, base: f64, [low, worst, high]: [f64; 3]) -> Result<String, Error> {
    let natural = mean_frequencies(train)?;
    let mut best = ((u32::MAX, f64::INFINITY), String::new());
    for wave in frequencies(train) {
        let times = (wave / base).round();
        for i in 0..natural.len() {
            for j in i..natural.len() {
                for n in 1..=HIGHEST_ORDER {
                    let at = (natural[i] + natural[j]) / f64::from(n) / times;
                    let within = (low..=high).contains(&at);
                    let order = if within { n } else { HIGHEST_ORDER + 1 };
                    let rank = (order, (at / worst).ln().abs());
                    if rank.0 < best.0.0 || (rank.0 == best.0.0 && rank.1 < best.0.1 * (1.0 - EDGE))
                    {
                        best = (rank, resonance(i + 1, j + 1, n));
                    }
                }
            }
        }
    }
    Ok(best.1)
}

fn resonance(i: usize, j: usize, n: u32) -> String {
    match (i == j, n) {
        (true, 1) => format!("2 ω{i}"),
        (true, 2) => format!("ω{i}"),
        (true, _) => format!("2 ω{i}/{n}"),
        (false, 1) => format!("ω{i} + ω{j}"),
        (false, _) => format!("(ω{i} + ω{j})/{n}"),
    }
}

/// Natural frequencies of the machine with its mean stiffness, free turning left out, rad/s.
fn mean_frequencies(train: &Train) -> Result<Vec<f64>, Error> {
    let n = train.n();
    let stiffness = |b: &Branch| match &b.law {
        Law::Linear { stiffness, .. } => *stiffness,
        Law::Contact(contact) => {
            contact.stiffness * b.variation.as_ref().map_or(1.0, |w| w.shape.mean())
        }
        _ => 0.0,
    };
    let mut k = Matrix::zeros(n, n);
    for b in &train.branches {
        let stiffness = stiffness(b);
        for (i, u) in b.direction.scaled() {
            for (j, w) in b.direction.scaled() {
                k[(i, j)] += stiffness * u * w;
            }
        }
    }
    let unit = |j: usize| {
        let v: Vec<f64> = (0..n).map(|i| f64::from(i == j)).collect();
        train.momentum(&v)
    };
    let columns: Vec<Vec<f64>> = (0..n).map(unit).collect();
    let m = Matrix::from_fn(n, n, |i, j| columns[j][i]);
    let squares = definite::pencil(&k, &m)?.values;
    let largest = squares.iter().copied().fold(0.0, f64::max);
    let elastic = squares.into_iter().filter(|&x| x > 1e-9 * largest);
    Ok(elastic.map(f64::sqrt).collect())
}
