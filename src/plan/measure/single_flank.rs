//! Single-flank record predicted from pitch and profile charts, and pitch deviations from a measured single-flank record.

use super::charts::{ChartEvaluation, ChartPlot};
use super::grading::GradedFlanks;
use crate::base::error::Error;
use crate::gear::measurement::deviation::GearDeviation;
use crate::gear::measurement::estimate::Estimate;
use crate::gear::measurement::pitch::{PitchDeviations, PitchMethod};
use crate::gear::measurement::unloaded_te::{self, FlankDeviations};
use crate::scene::measured_gear::{ChartKind, MeasuredChart};
use crate::te_record::single_flank::SingleFlankRecord;

/// Samples per pitch of a predicted record.
const SAMPLES_PER_PITCH: usize = 100;

/// Adds the single-flank records predicted from the pitch and profile charts of each side.
///
/// # Errors
/// Reason why no record is predicted.
pub fn predict_single_flank(evaluation: &mut ChartEvaluation) -> Result<(), String> {
    let gear = &evaluation.gear.gear;
    if gear.helix != 0.0 {
        return Err(
            "a helical gear has inclined contact lines, which one profile does not determine"
                .into(),
        );
    }
    let (base_pitch, cosine) = (gear.base_pitch(), gear.transverse_pressure_angle().cos());
    let mut records = Vec::new();
    let mut reason = None;
    for side in [GradedFlanks::Left, GradedFlanks::Right] {
        let Some((pitches, profile)) = pitch_and_profile(&evaluation.results.plots, side) else {
            continue;
        };
        match single_flank_record(side, gear.internal, pitches, &profile, base_pitch, cosine) {
            Ok(record) => records.push((side, record)),
            Err(error) => reason = Some(error.message),
        }
    }
    if records.is_empty() {
        return Err(reason.unwrap_or("needs pitch and profile charts of one side".into()));
    }
    let teeth = gear.teeth as usize;
    for (side, values) in records {
        let Ok(record) = SingleFlankRecord::new(&values, 1, teeth, true) else {
            continue;
        };
        let split = record.split_by_order();
        for (quantity, value) in [
            (GearDeviation::SingleFlankTotal, record.total_deviation()),
            (
                GearDeviation::SingleFlankTooth,
                record.ranges_per_pitch().sliding,
            ),
            (GearDeviation::SingleFlankShort, split.short_ranges.sliding),
        ] {
            let estimate = Estimate { value, std: None };
            let location = "expected from pitch and profile";
            let row = evaluation
                .grader
                .grade_predicted(quantity, side, location, estimate);
            evaluation.results.rows.push(row);
        }
        evaluation.results.plots.push(ChartPlot::Record {
            side,
            is_double: false,
            predicted: true,
            turns: 1,
            long: split.long,
            values,
        });
    }
    Ok(())
}

/// Profile traces of one side over the active length of roll.
struct ProfileTraces {
    along: Vec<f64>,
    traces: Vec<Vec<f64>>,
}

fn pitch_and_profile(
    plots: &[ChartPlot],
    flanks: GradedFlanks,
) -> Option<(&PitchDeviations, ProfileTraces)> {
    let pitches = plots.iter().find_map(|plot| match plot {
        ChartPlot::Pitch { side, pitches } if *side == flanks => Some(pitches),
        _ => None,
    })?;
    let profiles = plots.iter().find_map(|plot| match plot {
        ChartPlot::Traces {
            side,
            is_profile: true,
            along,
            active: (from, to),
            traces,
            ..
        } if *side == flanks => {
            // A limit on a point may deviate from it by rounding.
            let slack = 1e-9 * (to - from);
            let first = along.partition_point(|&x| x < from - slack);
            let end = along.partition_point(|&x| x <= to + slack);
            let crop = |values: &[f64]| values[first..end].to_vec();
            Some(ProfileTraces {
                along: crop(along),
                traces: traces.iter().map(|t| crop(&t.1)).collect(),
            })
        }
        _ => None,
    })?;
    Some((pitches, profiles))
}

/// Single-flank record along the reference circle, m. Right flanks mesh in descending order of their teeth. A flank that is ahead of its
/// position has excess metal on a right flank and lacks metal on a left one; the signs are reversed for an internal gear.
fn single_flank_record(
    side: GradedFlanks,
    internal: bool,
    pitches: &PitchDeviations,
    profile: &ProfileTraces,
    base_pitch: f64,
    cosine: f64,
) -> Result<Vec<f64>, Error> {
    let teeth = pitches.teeth();
    let ProfileTraces { along, traces } = profile;
    let mut profiles = match traces.len() == teeth {
        true => traces.clone(),
        // The mean profile of the measured teeth replaces those of all teeth.
        false => {
            let mean = |i: usize| traces.iter().map(|t| t[i]).sum::<f64>() / traces.len() as f64;
            vec![(0..along.len()).map(mean).collect()]
        }
    };
    let mut positions: Vec<f64> = pitches.flank_positions();
    let is_right = side == GradedFlanks::Right;
    if is_right {
        positions.reverse();
        profiles.reverse();
    }
    if is_right == internal {
        positions.iter_mut().for_each(|x| *x = -*x);
    }
    positions.iter_mut().for_each(|x| *x *= cosine);
    let flanks = FlankDeviations {
        pitch_surplus: &positions,
        roll: along,
        profiles: &profiles,
    };
    let record = unloaded_te::te_against_master(&flanks, base_pitch, SAMPLES_PER_PITCH)?;
    Ok(record.into_iter().map(|e| e / cosine).collect())
}

/// Pitch deviations from measured single-flank records that state when tooth 1 comes into contact.
///
/// # Errors
/// Reason why no pitch deviations are determined.
pub fn pitch_from_single_flank(
    evaluation: &mut ChartEvaluation,
    charts: &[MeasuredChart],
) -> Result<(), String> {
    let first_contact = |chart: &MeasuredChart| match chart.kind {
        ChartKind::SingleFlank {
            turns: 1,
            first_contact: Some(angle),
            ..
        } => Some((angle, chart.std)),
        _ => None,
    };
    let Some((angle, std)) = charts.iter().find_map(first_contact) else {
        return Err("needs a single-flank chart of one turn with `first_contact`".into());
    };
    let Some(contact_ratio) = evaluation.gear.contact_ratio else {
        return Err("needs `contact_ratio`, to know where one pair alone touches".into());
    };
    let gear = &evaluation.gear.gear;
    if gear.helix != 0.0 {
        return Err("a helical gear has inclined contact lines".into());
    }
    let teeth = gear.teeth as usize;
    let mut deviations = Vec::new();
    for plots in &evaluation.results.plots {
        if let ChartPlot::Record {
            side,
            is_double: false,
            predicted: false,
            values,
            ..
        } = plots
        {
            let record = align_to_contact(values, angle, teeth);
            let parts = unloaded_te::separate_pitch_and_profile(&record, teeth, contact_ratio, std)
                .map_err(|e| e.message)?;
            let positions: Vec<f64> = parts.pitch_surplus.iter().map(|p| p.value).collect();
            let std_of_first = parts.pitch_surplus.first().and_then(|p| p.std);
            let pitches = PitchDeviations::new(&positions, PitchMethod::Index, teeth, std_of_first)
                .map_err(|e| e.message)?;
            deviations.push((*side, pitches, parts.max_residual));
        }
    }
    for (side, pitches, rest) in deviations {
        let how = "from the single-flank record";
        for (quantity, value) in [
            (GearDeviation::SinglePitch, pitches.single_pitch().estimate),
            (
                GearDeviation::CumulativePitch,
                pitches.cumulative_total().estimate,
            ),
        ] {
            let size = Estimate {
                value: value.value.abs(),
                ..value
            };
            let row = evaluation.grader.grade_predicted(quantity, side, how, size);
            evaluation.results.rows.push(row);
        }
        evaluation.results.notes.push(format!(
            "pitch {how}: where one pair alone touches; single teeth differ from place and mean profile by up to {:.2} µm. Not \
             determined: the profile where two pairs could touch, a height common to all teeth, what belongs to the master",
            1e6 * rest
        ));
    }
    Ok(())
}

/// Record over one revolution, resampled linearly from an angle on, rad, with the same integer number of samples in every pitch.
fn align_to_contact(values: &[f64], angle: f64, teeth: usize) -> Vec<f64> {
    let n = values.len();
    let per_pitch = (n / teeth).max(2);
    let first = angle.rem_euclid(std::f64::consts::TAU) / std::f64::consts::TAU * n as f64;
    let sample = |i: usize| {
        let at = first + i as f64 * n as f64 / (per_pitch * teeth) as f64;
        let (index, fraction) = (at.floor() as usize, at - at.floor());
        let (a, b) = (values[index % n], values[(index + 1) % n]);
        a + fraction * (b - a)
    };
    (0..per_pitch * teeth).map(sample).collect()
}
