//! Tip relief of least peak-to-peak transmission error over a range of torques: the least of `max over T of max_φ e − min_φ e`.
//!
//! Both tips get the same amount over the same share of the path on which the most pairs touch. With a constant pair stiffness k, one
//! to two pairs and the whole of that path relieved, the relief is Δ = (W₁ + W₂)/(2 k) of Harris' V (Proc. IMechE 172, 1958).

use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::cylindrical::modification::Relief;
use crate::gear::cylindrical::pair::Pair;

use super::contact_path::ContactPath;
use super::mesh::{LoadedMesh, MeshOptions};

/// Torques of the range at which the peak-to-peak is computed.
const TORQUES: usize = 5;
/// Shares of the path of most pairs that are tried.
const SHARES: [f64; 7] = [1.0, 0.875, 0.75, 0.625, 0.5, 0.375, 0.25];
/// By how much a shorter relief has to be better than a longer one, which needs less material removed.
const WORTH: f64 = 0.999;
/// Amounts per share that are scanned before the best is refined.
const SCAN: usize = 12;
/// Greatest amount as a multiple of the greatest deflection without relief.
const GREATEST_AMOUNT: f64 = 2.0;
/// Golden sections: the amount is known to 3e-5 of the greatest one.
const SECTIONS: usize = 18;

/// Tip reliefs with the peak-to-peak they leave.
#[derive(Debug, Clone, PartialEq)]
pub struct LeastRelief {
    /// Relief of both gears.
    pub reliefs: [Relief; 2],
    /// Share of the path of most pairs over which the teeth are relieved.
    pub share: f64,
    /// Torques of the pinion, N·m.
    pub torques: Vec<f64>,
    /// Peak-to-peak with the reliefs, by torque, m.
    pub peak_to_peak: Vec<f64>,
    /// Peak-to-peak without tip relief, by torque, m.
    pub without: Vec<f64>,
}

/// The relief of least peak-to-peak over a range of torques of the pinion, N·m; other modifications of `options` stay.
///
/// # Errors
/// `OutOfRange`: torques that are not positive and ascending, a contact ratio that is a whole number or below 1; as `LoadedMesh`.
pub fn least_peak_to_peak(
    pair: &Pair,
    options: &MeshOptions,
    [low, high]: [f64; 2],
) -> Result<LeastRelief, Error> {
    if !(low > 0.0 && high >= low && high.is_finite()) {
        let message =
            format!("torques from {low} to {high} N·m are not a range above 0, ascending");
        return Err(Error::new(Code::OutOfRange, message));
    }
    let path = ContactPath::new(pair);
    let pitches = (path.ends[1] - path.ends[0]) / path.base_pitch;
    let most_pairs = pitches.fract() * path.base_pitch;
    if !(pitches > 1.0 && most_pairs > 0.0) {
        let message = format!(
            "transverse contact ratio of {pitches:.4} leaves no part of the path to relieve"
        );
        return Err(Error::new(Code::OutOfRange, message)
            .with_hint("give tip diameters at which it is above 1"));
    }
    let torques: Vec<f64> = (0..TORQUES)
        .map(|i| low + (high - low) * i as f64 / (TORQUES - 1) as f64)
        .collect();
    let reliefs = |share: f64, amount: f64| {
        let from = |i: usize| {
            let [root, tip] = path.flank_ends[i];
            tip - share * most_pairs * (tip - root).signum()
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
    let worst = |share: f64, amount: f64| -> Result<f64, Error> {
        let values = by_torque(Some(reliefs(share, amount)))?;
        Ok(values.into_iter().fold(0.0, f64::max))
    };
    let errors = cycles(None)?.into_iter().flat_map(|c| c.te);
    let greatest = GREATEST_AMOUNT * errors.fold(0.0, |most: f64, e| most.max(e.abs()));
    let mut best = (0.0, 1.0, f64::INFINITY);
    for share in SHARES {
        let step = greatest / SCAN as f64;
        let mut place = (0.0, f64::INFINITY);
        for i in 0..=SCAN {
            let value = worst(share, step * i as f64)?;
            if value < place.1 {
                place = (step * i as f64, value);
            }
        }
        let range = [(place.0 - step).max(0.0), place.0 + step];
        let (amount, value) = golden_section(range, |amount| worst(share, amount))?;
        if value < WORTH * best.2 {
            best = (amount, share, value);
        }
    }
    let (amount, share, _) = best;
    let reliefs = reliefs(share, amount);
    Ok(LeastRelief {
        reliefs,
        share,
        peak_to_peak: by_torque(Some(reliefs))?,
        without: by_torque(None)?,
        torques,
    })
}

/// Least value of a function with one minimum on a range: place and value.
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
