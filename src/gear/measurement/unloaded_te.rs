//! Unloaded transmission error of spur gears from flank deviations, `e = max_j (δ1_j + δ2_j)`, and its inverse.
//!
//! The contact of a tooth pair is at one roll length at a time, because the contact lines of spur gears are parallel to the axis.

use super::estimate::Estimate;
use crate::base::code::Code;
use crate::base::error::Error;

/// Deviations of the flanks of one side as excess material along the line of action, m.
#[derive(Debug, Clone, Copy)]
pub struct FlankDeviations<'a> {
    /// Excess of every tooth by its pitch position, in the order in which teeth come into mesh, m.
    pub pitch_surplus: &'a [f64],
    /// Roll lengths of the profile in ascending order, m.
    pub roll: &'a [f64],
    /// Excess over the roll lengths, m: one trace for all teeth, or one for each tooth.
    pub profiles: &'a [Vec<f64>],
}

impl FlankDeviations<'_> {
    /// Excess of tooth `j` at roll length `s` within the profile, m.
    fn surplus(&self, j: usize, s: f64) -> f64 {
        let profile = &self.profiles[j % self.profiles.len()];
        let last = self.roll.len() - 1;
        let i = self.roll.partition_point(|&x| x <= s).clamp(1, last);
        let (a, b) = (self.roll[i - 1], self.roll[i]);
        let share = ((s - a) / (b - a)).clamp(0.0, 1.0);
        self.pitch_surplus[j % self.pitch_surplus.len()]
            + profile[i - 1]
            + share * (profile[i] - profile[i - 1])
    }

    fn check(&self) -> Result<(), Error> {
        let traces = self.profiles.len();
        let fits = !self.pitch_surplus.is_empty()
            && self.roll.len() >= 2
            && (traces == 1 || traces == self.pitch_surplus.len())
            && self.profiles.iter().all(|p| p.len() == self.roll.len());
        match fits {
            true => Ok(()),
            false => Err(Error::new(
                Code::OutOfRange,
                format!("{traces} profiles for {} teeth", self.pitch_surplus.len()),
            )
            .with_hint("give one profile for all teeth, or one per tooth")),
        }
    }

    fn profile_length(&self) -> f64 {
        self.roll[self.roll.len() - 1] - self.roll[0]
    }
}

/// Transmission error of a gear with an error-free master over one revolution from first contact of tooth 0; lengths in m.
///
/// # Errors
/// `OutOfRange`: the number of profiles does not match the teeth, or profiles shorter than a base pitch interrupt the contact.
pub fn te_against_master(
    gear: &FlankDeviations,
    base_pitch: f64,
    samples_per_pitch: usize,
) -> Result<Vec<f64>, Error> {
    gear.check()?;
    let overlap = profile_overlap(gear, base_pitch)?;
    let teeth = gear.pitch_surplus.len();
    let sample = |i: usize| {
        let phase = i as f64 / samples_per_pitch as f64;
        pairs_in_contact(phase, overlap)
            .map(|j| {
                let s = gear.roll[0] + (phase - j as f64) * base_pitch;
                gear.surplus(j.rem_euclid(teeth as i64) as usize, s)
            })
            .fold(f64::NEG_INFINITY, f64::max)
    };
    Ok((0..teeth * samples_per_pitch).map(sample).collect())
}

/// Transmission error of two gears over their full hunting cycle from first contact of tooth 0 of both; lengths in m. `centre` is the
/// length T₁T₂ of the line of action between the base circles: roll length s of one gear meets `centre − s` of the other.
///
/// # Errors
/// As [`te_against_master`]; `OutOfRange` where the profiles have no common contact range.
pub fn te_of_pair(
    driver: &FlankDeviations,
    driven: &FlankDeviations,
    base_pitch: f64,
    centre: f64,
    samples_per_pitch: usize,
) -> Result<Vec<f64>, Error> {
    driver.check()?;
    driven.check()?;
    let range = |f: &FlankDeviations| (f.roll[0], f.roll[f.roll.len() - 1]);
    let ((a1, e1), (a2, e2)) = (range(driver), range(driven));
    let (from, to) = (a1.max(centre - e2), e1.min(centre - a2));
    let overlap = (to - from) / base_pitch;
    check_overlap(overlap)?;
    let (z1, z2) = (driver.pitch_surplus.len(), driven.pitch_surplus.len());
    let pitches = z1 * crate::te_record::single_flank::SingleFlankRecord::hunting_turns(z1, z2);
    let sample = |i: usize| {
        let phase = i as f64 / samples_per_pitch as f64;
        pairs_in_contact(phase, overlap)
            .map(|j| {
                let s = from + (phase - j as f64) * base_pitch;
                let tooth = |z: usize| j.rem_euclid(z as i64) as usize;
                driver.surplus(tooth(z1), s) + driven.surplus(tooth(z2), centre - s)
            })
            .fold(f64::NEG_INFINITY, f64::max)
    };
    Ok((0..pitches * samples_per_pitch).map(sample).collect())
}

/// Tolerance at the ends of contact for rounding, pitches.
const EDGE_TOLERANCE: f64 = 1e-9;

/// Tooth pairs in contact at `phase` pitches after first contact of tooth 0; each pair is in contact for `overlap` pitches.
fn pairs_in_contact(phase: f64, overlap: f64) -> std::ops::RangeInclusive<i64> {
    (phase - overlap - EDGE_TOLERANCE).ceil() as i64..=(phase + EDGE_TOLERANCE).floor() as i64
}

fn profile_overlap(gear: &FlankDeviations, base_pitch: f64) -> Result<f64, Error> {
    let overlap = gear.profile_length() / base_pitch;
    check_overlap(overlap)?;
    Ok(overlap)
}

fn check_overlap(overlap: f64) -> Result<(), Error> {
    if overlap >= 1.0 {
        return Ok(());
    }
    let message =
        format!("profiles cover {overlap:.3} base pitches, so that at some angles no teeth touch");
    Err(Error::new(Code::OutOfRange, message)
        .with_hint("measure them over the whole active length, at least one base pitch"))
}

/// Pitch and profile deviations separated from a transmission-error record with a master gear.
#[derive(Debug, Clone, PartialEq)]
pub struct SeparatedDeviations {
    /// Excess of every tooth by its pitch position, mean zero, m.
    pub pitch_surplus: Vec<Estimate>,
    /// Roll, in base pitches after first contact, of the samples with single-pair contact.
    pub roll: Vec<f64>,
    /// Mean profile at these samples, mean zero, m.
    pub profile: Vec<Estimate>,
    /// Largest residual of any tooth after pitch and mean profile, m: individual form deviations, or noise.
    pub max_residual: f64,
}

/// Separates the record of a gear with a master, one revolution from first contact of tooth 0, into pitch positions and mean profile by
/// least squares: `e_j(s) = F_j + p(s)` in single-pair contact (`overlap − 1` to 1 base pitches of roll). `std` is that of one sample, m.
///
/// Not determined: the profile in double-pair contact, where only the higher tooth is observed; an excess common to all teeth; the share of
/// the master in either.
///
/// # Errors
/// `IllPosed`: an overlap of 2 or more, without single-pair contact. `OutOfRange`: the samples per pitch are not a whole number, or none is
/// in single-pair contact.
pub fn separate_pitch_and_profile(
    record: &[f64],
    teeth: usize,
    overlap: f64,
    std: Option<f64>,
) -> Result<SeparatedDeviations, Error> {
    if overlap >= 2.0 {
        let message = format!("with {overlap:.3} pairs in contact there is no single contact");
        return Err(Error::new(Code::IllPosed, message)
            .with_hint("measure pitch and profile of such a gear directly"));
    }
    if teeth == 0 || !record.len().is_multiple_of(teeth) || record.is_empty() {
        let message = format!("{} samples over {teeth} teeth", record.len());
        return Err(Error::new(Code::OutOfRange, message)
            .with_hint("resample to a whole number of samples a pitch"));
    }
    let per_pitch = record.len() / teeth;
    let phase = |i: usize| i as f64 / per_pitch as f64;
    let single: Vec<usize> = (0..per_pitch)
        .filter(|&i| phase(i) > overlap - 1.0 + EDGE_TOLERANCE && phase(i) < 1.0 - EDGE_TOLERANCE)
        .collect();
    if single.is_empty() {
        let message = format!("none of {per_pitch} samples per pitch lies in single contact");
        return Err(
            Error::new(Code::OutOfRange, message).with_hint("increase the number of samples")
        );
    }
    // The table of teeth and rolls is complete, so the least-squares solution is given by its row and column means.
    let (rows, columns) = (teeth as f64, single.len() as f64);
    let value = |j: usize, i: usize| record[j * per_pitch + i];
    let row_mean = |j: usize| single.iter().map(|&i| value(j, i)).sum::<f64>() / columns;
    let means: Vec<f64> = (0..teeth).map(row_mean).collect();
    let mean = means.iter().sum::<f64>() / rows;
    let column_mean = |i: usize| (0..teeth).map(|j| value(j, i)).sum::<f64>() / rows;
    let profile: Vec<f64> = single.iter().map(|&i| column_mean(i) - mean).collect();
    let max_residual = (0..teeth)
        .flat_map(|j| {
            let (means, profile) = (&means, &profile);
            let value = &value;
            single
                .iter()
                .zip(profile)
                .map(move |(&i, p)| (value(j, i) - means[j] - p).abs())
        })
        .fold(0.0, f64::max);
    let place_gain = ((1.0 - 1.0 / rows) / columns).sqrt();
    let profile_gain = ((1.0 - 1.0 / columns) / rows).sqrt();
    Ok(SeparatedDeviations {
        pitch_surplus: means
            .iter()
            .map(|m| Estimate::new(m - mean, place_gain, std))
            .collect(),
        roll: single.iter().map(|&i| phase(i)).collect(),
        profile: profile
            .into_iter()
            .map(|p| Estimate::new(p, profile_gain, std))
            .collect(),
        max_residual,
    })
}
