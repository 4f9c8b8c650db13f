//! Stability chart: speeds with a Floquet multiplier |μ| > 1, near the parametric resonances `(ω_i + ω_j)/n`.

use std::f64::consts::TAU;

use super::multiplier_collision::{MultiplierCollision, OscillatoryModes};
use super::{MULTIPLIER_TOLERANCE, Monodromy, monodromy};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::time_budget::CancelToken;
use crate::motion::dynamic_model::{DynamicModel, ForceElement, ForceLaw};
use crate::motion::methods::periodic::fundamental::period_grid;
use crate::motion::methods::periodic::grid::frequencies;
use crate::motion::wave::WavePhase;
use crate::numeric::sorting::sort_ascending;
use crate::numeric::{Matrix, parallel, symmetric};

/// Interval of unstable speeds, expressed as the fundamental frequency 2π/T of the machine, rad/s.
#[derive(Debug, Clone, PartialEq)]
pub struct InstabilityTongue {
    /// Lower edge of the tongue, rad/s.
    pub from: f64,
    /// Upper edge of the tongue, rad/s.
    pub to: f64,
    /// Speed of largest growth, rad/s.
    pub most_unstable: f64,
    /// Largest |μ| at that speed: growth per period.
    pub growth: f64,
    /// Resonance of the lowest order within the tongue, else the nearest, such as `2 ω1`, `(ω1 + ω2)/3`; elastic modes are counted from
    /// one.
    pub name: String,
}

/// Relative accuracy of the edges of a tongue.
const EDGE_TOLERANCE: f64 = 1e-6;

/// Highest order n of a named resonance.
const MAX_ORDER: u32 = 8;

/// Growth above one that counts as a tongue at a multiplier collision: coincident multipliers are accurate to the square root of rounding.
const GROWTH_TOLERANCE: f64 = 1e-6;

/// Largest multiplier at one evaluated speed.
#[derive(Debug, Clone, Copy)]
struct GrowthSample {
    /// Factor on all speeds of the machine.
    factor: f64,
    /// Largest |μ|.
    growth: f64,
}

impl GrowthSample {
    fn is_unstable(self) -> bool {
        self.growth > 1.0 + MULTIPLIER_TOLERANCE
    }
}

/// Instability tongues between two factors on all speeds of a machine with all contacts closed, from `points` equal steps and the
/// multiplier collisions between them.
///
/// # Errors
/// Those of the periodic method; `Interrupted` after a cancellation.
pub fn instability_tongues(
    model: &DynamicModel,
    [from, to]: [f64; 2],
    points: usize,
    cancel: &CancelToken,
) -> Result<Vec<InstabilityTongue>, Error> {
    let base = TAU / period_grid(model, 0.0)?.1.period;
    let at = |factor: f64| -> Result<Monodromy, Error> {
        if cancel.should_stop() {
            return Err(Error::new(Code::Interrupted, "the chart was not finished"));
        }
        monodromy(&scale_speed(model, factor), None)
    };
    let growth = |factor: f64| Ok(at(factor)?.multipliers()?.largest);
    let sample = |factor: f64| {
        let growth = growth(factor)?;
        Ok::<_, Error>(GrowthSample { factor, growth })
    };
    let step = (to - from) / points.max(1) as f64;
    let factors: Vec<f64> = (0..=points).map(|at| from + step * at as f64).collect();
    let equidistant = parallel::try_map(&factors, |&factor| sample(factor))?;
    let mut samples = equidistant.clone();
    let modes = OscillatoryModes::new(model)?;
    for candidate in modes.candidates(model, base, [from, to], MAX_ORDER) {
        let after = equidistant.partition_point(|s| s.factor <= candidate.factor);
        let neighbours = &equidistant[after.saturating_sub(1)..(after + 1).min(equidistant.len())];
        if neighbours.iter().all(|s| s.is_unstable()) {
            continue;
        }
        if let Some(MultiplierCollision { factor, radius }) =
            modes.locate_collision(candidate, at)?
        {
            let bracket = [factor - radius, factor + radius].map(|x| x.clamp(from, to));
            let (factor, growth) = max_growth(&growth, bracket)?;
            samples.extend(
                (growth > 1.0 + GROWTH_TOLERANCE).then_some(GrowthSample { factor, growth }),
            );
        }
    }
    sort_by_speed(&mut samples);
    split_tongues(&mut samples, step, sample)?;
    let mut tongues = Vec::new();
    let mut at = 0;
    for group in samples.chunk_by(|a, b| a.is_unstable() == b.is_unstable()) {
        let (first, last) = (at, at + group.len() - 1);
        at += group.len();
        if group[0].is_unstable() {
            tongues.push(tongue(model, base, (&samples, first, last), &growth)?);
        }
    }
    Ok(tongues)
}

/// Adds a sample between unstable speeds less than a step apart, which may belong to two tongues.
fn split_tongues(
    samples: &mut Vec<GrowthSample>,
    step: f64,
    sample: impl Fn(f64) -> Result<GrowthSample, Error>,
) -> Result<(), Error> {
    let is_close = |pair: &&[GrowthSample]| {
        let unstable = pair.iter().all(|s| s.is_unstable());
        unstable && pair[1].factor - pair[0].factor < step * (1.0 - EDGE_TOLERANCE)
    };
    let middle = |pair: &[GrowthSample]| sample(0.5 * (pair[0].factor + pair[1].factor));
    let middles: Result<Vec<GrowthSample>, Error> =
        samples.windows(2).filter(is_close).map(middle).collect();
    samples.extend(middles?);
    sort_by_speed(samples);
    Ok(())
}

fn sort_by_speed(samples: &mut [GrowthSample]) {
    sort_ascending(samples, |a| a.factor);
}

/// Tongue around the unstable samples `first` to `last`.
fn tongue(
    model: &DynamicModel,
    base: f64,
    (rows, first, last): (&[GrowthSample], usize, usize),
    growth: &impl Fn(f64) -> Result<f64, Error>,
) -> Result<InstabilityTongue, Error> {
    let edge_between = |inside: usize, outside: Option<usize>| {
        let inside = rows[inside].factor;
        match outside.and_then(|at| rows.get(at)) {
            Some(outside) => edge(growth, inside, outside.factor),
            None => Ok(inside),
        }
    };
    let low = edge_between(first, first.checked_sub(1))?;
    let high = edge_between(last, Some(last + 1))?;
    let by_growth = |a: &usize, b: &usize| rows[*a].growth.total_cmp(&rows[*b].growth);
    let top = (first..=last).max_by(by_growth).unwrap_or(first);
    let factor = |at: Option<usize>| at.and_then(|at| rows.get(at)).unwrap_or(&rows[top]).factor;
    let bracket = [
        factor(top.checked_sub(1)).max(low),
        factor(Some(top + 1)).min(high),
    ];
    let (mut worst, mut most) = max_growth(growth, bracket)?;
    if rows[top].growth > most {
        (worst, most) = (rows[top].factor, rows[top].growth);
    }
    Ok(InstabilityTongue {
        from: low * base,
        to: high * base,
        most_unstable: worst * base,
        growth: most,
        name: resonance_name(model, base, [low, worst, high].map(|factor| factor * base))?,
    })
}

/// Model with the frequency of every wave and harmonic load multiplied by a factor.
pub fn scale_speed(model: &DynamicModel, factor: f64) -> DynamicModel {
    let mut model = model.clone();
    for b in &mut model.elements {
        for wave in b.stiffness_wave.iter_mut().chain(&mut b.angle_waves) {
            if let WavePhase::Imposed { omega, .. } = &mut wave.phase {
                *omega *= factor;
            }
        }
        let harmonics = b
            .imposed_displacement
            .iter_mut()
            .flat_map(|e| &mut e.harmonics);
        harmonics.for_each(|h| h.omega *= factor);
    }
    let harmonics = model
        .forces
        .iter_mut()
        .flat_map(|d| &mut d.signal.harmonics);
    harmonics.for_each(|h| h.omega *= factor);
    model
}

/// Edge of a tongue between an unstable and a stable factor, by bisection.
fn edge(
    growth: &impl Fn(f64) -> Result<f64, Error>,
    mut unstable: f64,
    mut stable: f64,
) -> Result<f64, Error> {
    while (unstable - stable).abs() > EDGE_TOLERANCE * stable.abs().max(unstable.abs()) {
        let middle = 0.5 * (unstable + stable);
        match growth(middle)? > 1.0 + MULTIPLIER_TOLERANCE {
            true => unstable = middle,
            false => stable = middle,
        }
    }
    Ok(unstable)
}

/// Factor and value of the maximum growth between two factors, by golden-section search.
fn max_growth(
    growth: &impl Fn(f64) -> Result<f64, Error>,
    [mut a, mut d]: [f64; 2],
) -> Result<(f64, f64), Error> {
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    let (mut b, mut c) = (d - ratio * (d - a), a + ratio * (d - a));
    let (mut at_b, mut at_c) = (growth(b)?, growth(c)?);
    let tolerance = 1e-3 * (d - a);
    while d - a > tolerance {
        if at_b > at_c {
            (d, c, at_c) = (c, b, at_b);
            b = d - ratio * (d - a);
            at_b = growth(b)?;
        } else {
            (a, b, at_b) = (b, c, at_c);
            c = a + ratio * (d - a);
            at_c = growth(c)?;
        }
    }
    Ok(if at_b > at_c { (b, at_b) } else { (c, at_c) })
}

/// Name of the resonance `(ω_i + ω_j)/n` of the mean model, by the frequency of one of its waves, for a tongue from `low` to `high`.
/// As resonances of high order are dense, the lowest order within the tongue takes precedence over the one nearest to the maximum.
fn resonance_name(
    model: &DynamicModel,
    base: f64,
    [low, worst, high]: [f64; 3],
) -> Result<String, Error> {
    let natural = mean_frequencies(model)?;
    let mut best = ((u32::MAX, f64::INFINITY), String::new());
    for wave in frequencies(model) {
        let harmonic = (wave / base).round();
        for i in 0..natural.len() {
            for j in i..natural.len() {
                for n in 1..=MAX_ORDER {
                    let speed = (natural[i] + natural[j]) / f64::from(n) / harmonic;
                    let within = (low..=high).contains(&speed);
                    let order = if within { n } else { MAX_ORDER + 1 };
                    let rank = (order, (speed / worst).ln().abs());
                    if rank.0 < best.0.0
                        || (rank.0 == best.0.0 && rank.1 < best.0.1 * (1.0 - EDGE_TOLERANCE))
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

/// Natural frequencies of the elastic modes with mean stiffness, rad/s, ascending.
fn mean_frequencies(model: &DynamicModel) -> Result<Vec<f64>, Error> {
    let n = model.coordinate_count();
    let stiffness = |b: &ForceElement| match &b.law {
        ForceLaw::Linear { stiffness, .. } => *stiffness,
        ForceLaw::Contact(contact) => contact.stiffness * b.mean_factor(),
        _ => 0.0,
    };
    let mut k = Matrix::zeros(n, n);
    for b in &model.elements {
        let stiffness = stiffness(b);
        for (i, u) in b.direction.entries() {
            for (j, w) in b.direction.entries() {
                k[(i, j)] += stiffness * u * w;
            }
        }
    }
    if let Some((unattached, _)) = &model.global_matrices {
        for j in 0..n {
            (0..n).for_each(|i| k[(i, j)] += 0.5 * (unattached[(i, j)] + unattached[(j, i)]));
        }
    }
    let unit = |j: usize| {
        let v: Vec<f64> = (0..n).map(|i| f64::from(i == j)).collect();
        model.momentum(&v)
    };
    let columns: Vec<Vec<f64>> = (0..n).map(unit).collect();
    let m = Matrix::from_fn(n, n, |i, j| columns[j][i]);
    let eigenvalues = symmetric::generalised_symmetric_eigen(&k, &m)?.values;
    let largest = eigenvalues.iter().copied().fold(0.0, f64::max);
    let elastic = eigenvalues.into_iter().filter(|&x| x > 1e-9 * largest);
    Ok(elastic.map(f64::sqrt).collect())
}
