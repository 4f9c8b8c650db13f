//! Unloaded transmission error from flank deviations, `e = max_j (δ1_j + δ2_j)`, and its inverse.
//!
//! And back: what one such record says of the teeth.
//!
//! Spur gears: contact lies on one roll length at a time.

use super::estimate::Estimate;
use crate::base::code::Code;
use crate::base::error::Error;

/// One side of the teeth of a gear, as surplus of material along the line of action.
#[derive(Debug, Clone, Copy)]
pub struct FlankDeviations<'a> {
    /// Surplus of every tooth by its place (pitch), in the order teeth come into mesh.
    pub pitch_surplus: &'a [f64],
    /// Roll lengths of the profile, rising.
    pub along: &'a [f64],
    /// Surplus along the profile: one trace for all teeth, or one for each.
    pub profiles: &'a [Vec<f64>],
}

impl FlankDeviations<'_> {
    /// Surplus of tooth `j` at roll length `s` within the profile.
    fn surplus(&self, j: usize, s: f64) -> f64 {
        let profile = &self.profiles[j % self.profiles.len()];
        let last = self.along.len() - 1;
        let i = self.along.partition_point(|&x| x <= s).clamp(1, last);
        let (a, b) = (self.along[i - 1], self.along[i]);
        let share = ((s - a) / (b - a)).clamp(0.0, 1.0);
        self.pitch_surplus[j % self.pitch_surplus.len()]
            + profile[i - 1]
            + share * (profile[i] - profile[i - 1])
    }

    fn check(&self) -> Result<(), Error> {
        let traces = self.profiles.len();
        let fits = !self.pitch_surplus.is_empty()
            && self.along.len() >= 2
            && (traces == 1 || traces == self.pitch_surplus.len())
            && self.profiles.iter().all(|p| p.len() == self.along.len());
        match fits {
            true => Ok(()),
            false => Err(Error::new(
                Code::OutOfRange,
                format!("{traces} profiles for {} teeth", self.pitch_surplus.len()),
            )
            .with_hint("give the profile of one tooth for all, or of every tooth")),
        }
    }

    fn profile_length(&self) -> f64 {
        self.along[self.along.len() - 1] - self.along[0]
    }
}

/// The record of a gear that rolls with a master without errors, over one turn from the first contact of tooth 0.
///
/// # Errors
/// `OutOfRange`: profiles that do not belong to the teeth, or reach over less than a base pitch, so that no pair would touch at times.
pub fn te_against_master(
    gear: &FlankDeviations,
    base_pitch: f64,
    samples_per_pitch: usize,
) -> Result<Vec<f64>, Error> {
    gear.check()?;
    let overlap = checked_overlap(gear, base_pitch)?;
    let teeth = gear.pitch_surplus.len();
    let sample = |i: usize| {
        let turned = i as f64 / samples_per_pitch as f64;
        pairs_in_contact(turned, overlap)
            .map(|j| {
                let s = gear.along[0] + (turned - j as f64) * base_pitch;
                gear.surplus(j.rem_euclid(teeth as i64) as usize, s)
            })
            .fold(f64::NEG_INFINITY, f64::max)
    };
    Ok((0..teeth * samples_per_pitch).map(sample).collect())
}

/// The record of two gears over their full hunting cycle, from the first contact of tooth 0 of both. `centre` is the length T₁T₂
/// between the points where the line of action touches the base circles: roll length s of one gear meets `centre − s` of the other.
///
/// # Errors
/// As [`te_against_master`]; `OutOfRange` where the profiles never meet.
pub fn te_of_pair(
    driver: &FlankDeviations,
    driven: &FlankDeviations,
    base_pitch: f64,
    centre: f64,
    samples_per_pitch: usize,
) -> Result<Vec<f64>, Error> {
    driver.check()?;
    driven.check()?;
    let ends = |f: &FlankDeviations| (f.along[0], f.along[f.along.len() - 1]);
    let ((a1, e1), (a2, e2)) = (ends(driver), ends(driven));
    let (from, to) = (a1.max(centre - e2), e1.min(centre - a2));
    let overlap = (to - from) / base_pitch;
    too_short(overlap)?;
    let (z1, z2) = (driver.pitch_surplus.len(), driven.pitch_surplus.len());
    let pitches = z1 * crate::te_record::single_flank::SingleFlankRecord::hunting_turns(z1, z2);
    let sample = |i: usize| {
        let turned = i as f64 / samples_per_pitch as f64;
        pairs_in_contact(turned, overlap)
            .map(|j| {
                let s = from + (turned - j as f64) * base_pitch;
                let tooth = |z: usize| j.rem_euclid(z as i64) as usize;
                driver.surplus(tooth(z1), s) + driven.surplus(tooth(z2), centre - s)
            })
            .fold(f64::NEG_INFINITY, f64::max)
    };
    Ok((0..pitches * samples_per_pitch).map(sample).collect())
}

/// Tolerance of an end of contact, pitches: an end hit by rounding belongs to the contact.
const EDGE_TOLERANCE: f64 = 1e-9;

/// Teeth in contact when `turned` pitches have passed since tooth 0 came in; teeth stay for `overlap` pitches.
fn pairs_in_contact(turned: f64, overlap: f64) -> std::ops::RangeInclusive<i64> {
    (turned - overlap - EDGE_TOLERANCE).ceil() as i64..=(turned + EDGE_TOLERANCE).floor() as i64
}

fn checked_overlap(gear: &FlankDeviations, base_pitch: f64) -> Result<f64, Error> {
    let overlap = gear.profile_length() / base_pitch;
    too_short(overlap)?;
    Ok(overlap)
}

fn too_short(overlap: f64) -> Result<(), Error> {
    if overlap >= 1.0 {
        return Ok(());
    }
    let message =
        format!("profiles reach over {overlap:.3} base pitches, so at times no teeth touch");
    Err(Error::new(Code::OutOfRange, message)
        .with_hint("measure them over the whole active length, one base pitch at least"))
}

/// Tooth deviations separated from a record against a master.
#[derive(Debug, Clone, PartialEq)]
pub struct SeparatedDeviations {
    /// Surplus of every tooth by its place, their mean zero.
    pub places: Vec<Estimate>,
    /// Roll, in base pitches after first contact, of each sample where one pair alone touches.
    pub roll: Vec<f64>,
    /// The mean profile there, its mean zero.
    pub profile: Vec<Estimate>,
    /// The largest difference of any tooth from place and mean profile: the teeth's own form, or noise.
    pub rest: f64,
}

/// Splits the record of a gear against a master, one turn from the first contact of tooth 0, into places of the teeth and their mean
/// profile, by least squares: `e_j(s) = F_j + p(s)` where one pair alone touches (`overlap − 1` to 1 base pitches of roll).
///
/// Not determined, and so not given: the profile where two pairs could touch (only the higher is seen there); a height common to all
/// teeth; how much of either belongs to the master.
///
/// # Errors
/// `IllPosed`: an overlap of two pairs or more, where none is ever alone. `OutOfRange`: samples that are no whole number a pitch, or
/// none where one pair touches.
pub fn separate_pitch_and_profile(
    record: &[f64],
    teeth: usize,
    overlap: f64,
    std: Option<f64>,
) -> Result<SeparatedDeviations, Error> {
    if overlap >= 2.0 {
        let message = format!("with {overlap:.3} pairs in contact none touches alone");
        return Err(Error::new(Code::IllPosed, message).with_hint(
            "pitch and profile of such a gear are measured, not taken from its single-flank record",
        ));
    }
    if teeth == 0 || !record.len().is_multiple_of(teeth) || record.is_empty() {
        let message = format!("{} samples over {teeth} teeth", record.len());
        return Err(Error::new(Code::OutOfRange, message)
            .with_hint("resample to a whole number of samples a pitch"));
    }
    let per_pitch = record.len() / teeth;
    let turned = |i: usize| i as f64 / per_pitch as f64;
    let alone: Vec<usize> = (0..per_pitch)
        .filter(|&i| turned(i) > overlap - 1.0 + EDGE_TOLERANCE && turned(i) < 1.0 - EDGE_TOLERANCE)
        .collect();
    if alone.is_empty() {
        let message =
            format!("none of {per_pitch} samples a pitch lies where one pair touches alone");
        return Err(Error::new(Code::OutOfRange, message).with_hint("sample more densely"));
    }
    // A table of teeth and rolls, complete, so that least squares are the means of its rows and columns.
    let (rows, columns) = (teeth as f64, alone.len() as f64);
    let at = |j: usize, i: usize| record[j * per_pitch + i];
    let row = |j: usize| alone.iter().map(|&i| at(j, i)).sum::<f64>() / columns;
    let means: Vec<f64> = (0..teeth).map(row).collect();
    let all = means.iter().sum::<f64>() / rows;
    let column = |i: usize| (0..teeth).map(|j| at(j, i)).sum::<f64>() / rows;
    let profile: Vec<f64> = alone.iter().map(|&i| column(i) - all).collect();
    let rest = (0..teeth)
        .flat_map(|j| {
            let (means, profile) = (&means, &profile);
            let at = &at;
            alone
                .iter()
                .zip(profile)
                .map(move |(&i, p)| (at(j, i) - means[j] - p).abs())
        })
        .fold(0.0, f64::max);
    let place_gain = ((1.0 - 1.0 / rows) / columns).sqrt();
    let profile_gain = ((1.0 - 1.0 / columns) / rows).sqrt();
    Ok(SeparatedDeviations {
        places: means
            .iter()
            .map(|m| Estimate::new(m - all, place_gain, std))
            .collect(),
        roll: alone.iter().map(|&i| turned(i)).collect(),
        profile: profile
            .into_iter()
            .map(|p| Estimate::new(p, profile_gain, std))
            .collect(),
        rest,
    })
}
