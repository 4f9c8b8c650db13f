//! Subspace identification from responses alone, from covariances or from data.
//!
//! From covariances: the Hankel matrix of `R_{i+j+1}` is observability times controllability (Peeters & De Roeck, Mech. Syst. Signal
//! Process. 13 (1999)). From data: the projection of the future of all responses on the past of the references, from the triangle of
//! both (Van Overschee & De Moor, Subspace Identification for Linear Systems (1996), §3.3, with unit weights). Both cut orders 2, 4, …
//! from one singular value decomposition.

use super::channels::{Channels, check_references};
use super::covariances::{Covariances, Gathering};
use super::realisation::{Observability, OrderModes, continuous};
use super::uncertainty::Scatter;
use crate::base::code::Code;
use crate::base::error::{Error, Warning};
use crate::identify::mode::IdentifiedMode;
use crate::numeric::Matrix;
use crate::numeric::factors::{Triangle, svd};

/// What may be said instead of left to the defaults.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Settings {
    /// Block rows i; `rate/2i` is about the lowest frequency that is resolved well. `None`: from `lowest_hz`, or as many as keep
    /// the matrices small.
    pub block_rows: Option<usize>,
    /// The lowest frequency of interest, Hz.
    pub lowest_hz: Option<f64>,
    /// The highest order, twice the number of modes above which nothing is looked for.
    pub highest_order: Option<usize>,
    /// Reference channels; empty: all.
    pub references: Vec<usize>,
}

/// Poles of all orders.
#[derive(Debug, Clone)]
pub struct Subspace {
    /// Orders 2, 4, … with their modes.
    pub orders: Vec<OrderModes>,
    /// Singular values, largest first.
    pub singular_values: Vec<f64>,
    /// Block rows used.
    pub block_rows: usize,
    /// Distance of the lines the record's length could resolve, Hz.
    pub spacing_hz: f64,
    /// Doubts.
    pub warnings: Vec<Warning>,
}

/// Rows of the Hankel matrix that defaults do not exceed: its decomposition then takes a fraction of a second.
const ROWS: usize = 240;

/// Columns of the data triangle that defaults do not exceed: each sample costs twice its square.
const COLUMNS: usize = 200;

/// Bounds of the default number of block rows.
const BLOCK_ROWS: (usize, usize) = (10, 100);

/// Half periods of the lowest frequency that the block rows should span.
const HALF_PERIODS: f64 = 1.0;

/// Highest order unless stated: 30 modes.
const ORDER: usize = 60;

/// Above this damping ratio a pole models noise; its uncertainty is not worked out.
const NO_MODE: f64 = 0.3;

/// From covariances, with the uncertainty of every pole that could be a mode.
///
/// # Errors
/// `NoChannel` for references that are not among the responses; `OutOfRange`; `TooShort`; those of the decompositions.
pub fn from_covariances(channels: &Channels, settings: &Settings) -> Result<Subspace, Error> {
    let responses = channels.samples().len();
    let references = references(settings, responses)?;
    let block_rows = block_rows(channels, settings, ROWS / responses)?;
    let mut gathering = Gathering::new(responses, &references, 2 * block_rows - 1)?;
    gathering.push(channels.samples())?;
    let mut found = of_covariances(&gathering.finish()?, channels.rate_hz(), settings)?;
    found
        .warnings
        .extend(too_few_rows(channels.rate_hz(), settings, block_rows));
    Ok(found)
}

/// From covariances gathered elsewhere, over an odd number `2i − 1` of lags; [`Settings::block_rows`] and `lowest_hz` are not read.
///
/// # Errors
/// As [`from_covariances`].
pub fn of_covariances(
    covariances: &Covariances,
    rate_hz: f64,
    settings: &Settings,
) -> Result<Subspace, Error> {
    let (nc, nr) = (covariances.channels, covariances.references.len());
    let block_rows = covariances.lags.div_ceil(2);
    let scale = deviations(covariances)?;
    let scales = (&scale, &covariances.references);
    let hankel = |r: &[f64]| {
        Matrix::from_fn(block_rows * nc, block_rows * nr, |i, j| {
            let (lag, c, k) = (i / nc + j / nr + 1, i % nc, j % nr);
            r[(lag * nr + k) * nc + c] / (scales.0[c] * scales.0[scales.1[k]])
        })
    };
    let found = svd(&hankel(&covariances.mean))?;
    let highest = highest_order(settings, block_rows, nc, nr)?;
    let basis = Observability::new(&found, nc, highest);
    let scatter = Scatter::new(covariances, &found, highest, hankel);
    let mut orders = Vec::new();
    for order in (2..=highest).step_by(2) {
        let mut modes = Vec::new();
        for pair in basis.eigenpairs(order)? {
            let mut mode = IdentifiedMode {
                pole: continuous(pair.value, rate_hz),
                pole_covariance: None,
                shape: basis.shape(&pair, &scale),
            };
            if mode.damping_ratio() > 0.0 && mode.damping_ratio() < NO_MODE {
                mode.pole_covariance = scatter.pole_covariance(&basis, &pair, rate_hz);
            }
            modes.push(mode);
        }
        orders.push(in_order(order, modes));
    }
    Ok(Subspace {
        orders,
        singular_values: found.values,
        block_rows,
        spacing_hz: rate_hz / covariances.samples as f64,
        warnings: Vec::new(),
    })
}

/// From data. Often a little sharper on short records; without uncertainty.
///
/// # Errors
/// As [`from_covariances`].
pub fn from_data(channels: &Channels, settings: &Settings) -> Result<Subspace, Error> {
    let responses = channels.samples().len();
    let references = references(settings, responses)?;
    let (nc, nr) = (responses, references.len());
    let block_rows = block_rows(channels, settings, COLUMNS / (nc + nr))?;
    let highest = highest_order(settings, block_rows, nc, nr)?;
    let mean: Vec<f64> = (channels.samples().iter())
        .map(|s| s.iter().sum::<f64>() / s.len() as f64)
        .collect();
    let scale: Vec<f64> = (channels.samples().iter().zip(&mean))
        .map(|(s, m)| (s.iter().map(|x| (x - m).powi(2)).sum::<f64>() / s.len() as f64).sqrt())
        .collect();
    let (past, columns) = (block_rows * nr, block_rows * (nr + nc));
    let mut triangle = Triangle::new(columns);
    let mut row = vec![0.0; columns];
    let value = |c: usize, t: usize| (channels.samples()[c][t] - mean[c]) / scale[c];
    for t in block_rows..=channels.length() - block_rows {
        for (at, x) in row[..past].iter_mut().enumerate() {
            *x = value(references[at % nr], t - 1 - at / nr);
        }
        for (at, x) in row[past..].iter_mut().enumerate() {
            *x = value(at % nc, t + at / nc);
        }
        triangle.push(&row);
    }
    let r = triangle.finish();
    let projection = r
        .submatrix(0, past, past, columns - past)
        .transpose()
        .to_owned();
    let found = svd(&projection)?;
    let basis = Observability::new(&found, nc, highest);
    let mut orders = Vec::new();
    for order in (2..=highest).step_by(2) {
        let modes = (basis.eigenpairs(order)?.iter())
            .map(|pair| IdentifiedMode {
                pole: continuous(pair.value, channels.rate_hz()),
                pole_covariance: None,
                shape: basis.shape(pair, &scale),
            })
            .collect();
        orders.push(in_order(order, modes));
    }
    Ok(Subspace {
        orders,
        singular_values: found.values,
        block_rows,
        spacing_hz: channels.rate_hz() / channels.length() as f64,
        warnings: too_few_rows(channels.rate_hz(), settings, block_rows)
            .into_iter()
            .collect(),
    })
}

fn in_order(order: usize, mut modes: Vec<IdentifiedMode>) -> OrderModes {
    modes.sort_by(|a, b| a.pole.norm().total_cmp(&b.pole.norm()));
    OrderModes { order, modes }
}

fn references(settings: &Settings, channels: usize) -> Result<Vec<usize>, Error> {
    if settings.references.is_empty() {
        return Ok((0..channels).collect());
    }
    check_references(&settings.references, channels)?;
    Ok(settings.references.clone())
}

/// Standard deviations of the responses: each counts alike, whatever its unit.
fn deviations(covariances: &Covariances) -> Result<Vec<f64>, Error> {
    // Only references have their own variance among the covariances; of the others the largest covariance stands for the size.
    let size = |c: usize| match covariances.references.iter().position(|&r| r == c) {
        Some(r) => covariances.at(0, c, r).sqrt(),
        None => (0..covariances.references.len())
            .map(|k| {
                let r = covariances.references[k];
                covariances.at(0, c, k).abs() / covariances.at(0, r, k).sqrt()
            })
            .fold(0.0, f64::max),
    };
    let found: Vec<f64> = (0..covariances.channels).map(size).collect();
    match found.iter().position(|s| !(*s > 0.0 && s.is_finite())) {
        None => Ok(found),
        Some(c) => Err(Error::new(
            Code::NoSignal,
            format!("response {c} has a standard deviation of {}", found[c]),
        )
        .hint("leave the channel out")),
    }
}

fn wanted_rows(rate_hz: f64, lowest_hz: f64) -> f64 {
    (HALF_PERIODS * rate_hz / (2.0 * lowest_hz)).ceil() + 1.0
}

fn block_rows(channels: &Channels, settings: &Settings, bound: usize) -> Result<usize, Error> {
    let (least, most) = BLOCK_ROWS;
    let bound = bound.clamp(least, most);
    let rate = channels.rate_hz();
    let rows = match (settings.block_rows, settings.lowest_hz) {
        (Some(rows), _) if rows < 2 => {
            return Err(Error::new(
                Code::OutOfRange,
                format!("{rows} block rows hold no dynamics"),
            )
            .hint("take at least rate/(2 × lowest frequency)"));
        }
        (Some(rows), _) => rows,
        (None, Some(lowest)) => {
            if !(lowest > 0.0 && lowest < rate / 2.0) {
                return Err(Error::new(
                    Code::OutOfRange,
                    format!("the lowest frequency {lowest} Hz of samples at {rate} Hz"),
                )
                .hint(format!(
                    "give a frequency above 0 and below {} Hz",
                    rate / 2.0
                )));
            }
            (wanted_rows(rate, lowest) as usize).clamp(least.min(bound), bound)
        }
        (None, None) => bound,
    };
    // Each row of the Hankel matrix should be an average over many more samples than it has lags.
    let needed = 4 * rows;
    if channels.length() < needed {
        return Err(Error::new(
            Code::TooShort,
            format!("{} samples for {rows} block rows", channels.length()),
        )
        .hint(format!("take a longer record: at least {needed} samples")));
    }
    Ok(rows)
}

fn too_few_rows(rate_hz: f64, settings: &Settings, rows: usize) -> Option<Warning> {
    let lowest = settings.lowest_hz?;
    let resolved = rate_hz / (2.0 * rows as f64);
    // Half a period more or less is nothing to speak of.
    const SHORT: f64 = 0.8;
    (settings.block_rows.is_none() && lowest < SHORT * resolved).then(|| Warning {
        code: "few-block-rows",
        message: format!(
            "{rows} block rows at {rate_hz} Hz resolve modes above {resolved:.4} Hz well, not down to {lowest} Hz"
        ),
        hint: Some("look at the lowest modes by themselves: a --band that ends lower decimates the record".to_string()),
    })
}

fn highest_order(settings: &Settings, rows: usize, nc: usize, nr: usize) -> Result<usize, Error> {
    let possible = ((rows - 1) * nc).min(rows * nr);
    let highest = settings.highest_order.unwrap_or(ORDER).min(possible) / 2 * 2;
    if highest < 2 {
        return Err(Error::new(
            Code::OutOfRange,
            format!("the highest order is {highest}; {rows} block rows allow {possible}"),
        )
        .hint(
            "a mode needs an order of 2: raise the order, or take more channels or a longer record",
        ));
    }
    Ok(highest)
}
