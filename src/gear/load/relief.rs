//! Optimal tip relief: minimises the maximum over a torque range of the peak-to-peak transmission error, `max_T (max_φ e − min_φ e)`.
//!
//! Both tips are relieved by the same amount over the same share of the path with the larger number of pairs in contact. For constant pair
//! stiffness k, one to two pairs and full relief of that path, Δ = (W₁ + W₂)/(2 k): part V of Harris (Proc. IMechE 172, 1958).

use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::cylindrical::modification::Relief;
use crate::gear::cylindrical::pair::Pair;

use super::contact_path::ContactPath;
use super::mesh::{LoadedMesh, MeshOptions};

/// Number of torques in the range.
const TORQUES: usize = 5;
/// Relieved shares of the path with the larger number of pairs, in the order of the search.
const SHARES: [f64; 7] = [1.0, 0.875, 0.75, 0.625, 0.5, 0.375, 0.25];
/// Maximum ratio of the peak-to-peak value of a shorter relief to that of a longer one at which the shorter one is preferred.
const IMPROVEMENT: f64 = 0.999;
/// Intervals of the scan over the amount, before refinement by golden section.
const SCAN: usize = 12;
/// Maximum amount relative to the maximum deflection without relief.
const MAX_AMOUNT: f64 = 2.0;
/// Golden-section steps: final interval 3e-5 of the maximum amount.
const SECTIONS: usize = 18;

/// Optimal tip relief with its peak-to-peak transmission error.
#[derive(Debug, Clone, PartialEq)]
pub struct OptimalRelief {
    /// Relief of both gears.
    pub reliefs: [Relief; 2],
    /// Relieved share of the path with the larger number of pairs.
    pub share: f64,
    /// Pinion torques, N·m.
    pub torques: Vec<f64>,
    /// Peak-to-peak transmission error with relief by torque, m.
    pub peak_to_peak: Vec<f64>,
    /// Peak-to-peak transmission error without tip relief by torque, m.
    pub without: Vec<f64>,
}

/// Optimal tip relief over a range of pinion torques, N·m, with the other modifications of `options` unchanged.
///
/// # Errors
/// `OutOfRange` for torques not positive and ascending, and for a contact ratio that is an integer or below 1; errors of `LoadedMesh`.
pub fn optimal_tip_relief(
    pair: &Pair,
    options: &MeshOptions,
    [low, high]: [f64; 2],
) -> Result<OptimalRelief, Error> {
    if !(low > 0.0 && high >= low && high.is_finite()) {
        let message =
            format!("torques from {low} to {high} N·m are not an increasing range above 0");
        return Err(Error::new(Code::OutOfRange, message));
    }
    let path = ContactPath::new(pair);
    let pitches = (path.ends[1] - path.ends[0]) / path.base_pitch;
    let multi_pair_length = pitches.fract() * path.base_pitch;
    if !(pitches > 1.0 && multi_pair_length > 0.0) {
        let message =
            format!("transverse contact ratio of {pitches:.4} has no part of the path to relieve");
        return Err(Error::new(Code::OutOfRange, message)
            .with_hint("give tip diameters at which it is above 1"));
    }
    let torques: Vec<f64> = (0..TORQUES)
        .map(|i| low + (high - low) * i as f64 / (TORQUES - 1) as f64)
        .collect();
    let reliefs = |share: f64, amount: f64| {
        let from = |i: usize| {
            let [root, tip] = path.flank_ends[i];
            tip - share * multi_pair_length * (tip - root).signum()
        };
        [0, 1].map(|i| Relief {
            amount,
            from: from(i),
        })
    };
    let cycles = |reliefs: Option<[Relief; 2]>| {
        let mut options = options.clone();
        for i in 0..2 {
            options.modifications[i].tip_relief = reliefs.map(|r| r[i]);
        }
        Ok(LoadedMesh::new(pair, options)?.map(&torques)?.cycles)
    };
    let by_torque = |reliefs: Option<[Relief; 2]>| -> Result<Vec<f64>, Error> {
        let cycles = cycles(reliefs)?;
        Ok(cycles.iter().map(|c| c.peak_to_peak()).collect())
    };
    let max_peak_to_peak = |share: f64, amount: f64| -> Result<f64, Error> {
        let values = by_torque(Some(reliefs(share, amount)))?;
        Ok(values.into_iter().fold(0.0, f64::max))
    };
    let errors = cycles(None)?.into_iter().flat_map(|c| c.te);
    let max_amount = MAX_AMOUNT * errors.fold(0.0, |max: f64, e| max.max(e.abs()));
    let mut best = (0.0, 1.0, f64::INFINITY);
    for share in SHARES {
        let step = max_amount / SCAN as f64;
        let mut scan_minimum = (0.0, f64::INFINITY);
        for i in 0..=SCAN {
            let value = max_peak_to_peak(share, step * i as f64)?;
            if value < scan_minimum.1 {
                scan_minimum = (step * i as f64, value);
            }
        }
        let range = [(scan_minimum.0 - step).max(0.0), scan_minimum.0 + step];
        let (amount, value) = golden_section(range, |amount| max_peak_to_peak(share, amount))?;
        if value < IMPROVEMENT * best.2 {
            best = (amount, share, value);
        }
    }
    let (amount, share, _) = best;
    let reliefs = reliefs(share, amount);
    Ok(OptimalRelief {
        reliefs,
        share,
        peak_to_peak: by_torque(Some(reliefs))?,
        without: by_torque(None)?,
        torques,
    })
}

/// Minimum of a unimodal function on a range: position and value.
fn golden_section(
    [mut low, mut high]: [f64; 2],
    f: impl Fn(f64) -> Result<f64, Error>,
) -> Result<(f64, f64), Error> {
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    let (mut left, mut right) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut at_left, mut at_right) = (f(left)?, f(right)?);
    for _ in 0..SECTIONS {
        if at_left <= at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - ratio * (high - low);
            at_left = f(left)?;
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + ratio * (high - low);
            at_right = f(right)?;
        }
    }
    match at_left <= at_right {
        true => Ok((left, at_left)),
        false => Ok((right, at_right)),
    }
}
