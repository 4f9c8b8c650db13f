//! Causes of the deviations of a cut flank, each with its cutting conditions.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::bevel::flank_grid::FlankGrid;
use crate::gear::bevel::settings::MachineSettings;
use crate::gear::cut::angle_errors::{AngleError, AngleErrors};
use crate::gear::cut::blade_passes::CutConditions;
use crate::gear::cut::cutter_head::BladeFeed;
use crate::scene::cut_file::CutFile;
use crate::scene::cut_study::{ChainError, CutTarget, SpindleHistory};

/// Name of the cut by blades without errors.
pub const REGULAR: &str = "regular blades";
/// Name of the cut by blades with run-out.
pub const RUN_OUT: &str = "run-out";
/// Name of the cut with all causes.
pub const ALL: &str = "all causes";

/// Cause of deviations with its cutting conditions.
pub struct CutCause {
    /// Heading in the report.
    pub name: String,
    /// Cutting conditions.
    pub conditions: CutConditions,
}

/// Causes of the deviations of a flank: regular blades, each further cause alone, and all causes combined if there are several.
///
/// # Errors
/// A history shorter than the roll over the flank, or at a different speed.
pub fn of_flank(
    file: &CutFile,
    settings: &MachineSettings,
    feed: BladeFeed,
    grid: &FlankGrid,
) -> Result<Vec<CutCause>, Error> {
    let study = &file.study;
    let mut causes = vec![CutCause {
        name: REGULAR.into(),
        conditions: CutConditions::regular(feed),
    }];
    let mut combined = CutConditions::regular(feed);
    if !study.offsets.is_empty() {
        combined.offsets = study.offsets.clone();
        causes.push(CutCause {
            name: RUN_OUT.into(),
            conditions: combined.clone(),
        });
    }
    if let Some(roll) = &settings.roll {
        let mut errors = Vec::new();
        for (k, error) in study.errors.iter().enumerate() {
            let name = format!(
                "error {}: {}, {} a revolution",
                k + 1,
                error.target.name(),
                error.cycles
            );
            let law = harmonic(error, roll.work_over_cradle, feed);
            errors.push((name, error.target, law));
        }
        if let (Some(readings), Some(history)) = (&file.history, &study.history) {
            let turns = revolutions_per_cradle(history.target, roll.work_over_cradle, feed);
            let law = history_error(file, history, readings, turns, grid)?;
            errors.push((
                format!("history of the {}", history.target.name()),
                history.target,
                law,
            ));
        }
        for (name, target, error) in errors {
            add(&mut combined.errors, target, error.clone());
            let mut conditions = CutConditions::regular(feed);
            add(&mut conditions.errors, target, error);
            causes.push(CutCause { name, conditions });
        }
    }
    if causes.len() > 2 {
        causes.push(CutCause {
            name: ALL.into(),
            conditions: combined,
        });
    }
    Ok(causes)
}

/// Harmonic angle errors of cradle, work and cutter.
pub fn chain_errors(file: &CutFile, settings: &MachineSettings, feed: BladeFeed) -> AngleErrors {
    let mut errors = AngleErrors::default();
    if let Some(roll) = &settings.roll {
        for error in &file.study.errors {
            let law = harmonic(error, roll.work_over_cradle, feed);
            add(&mut errors, error.target, law);
        }
    }
    errors
}

/// Harmonic error over the cradle angle.
fn harmonic(error: &ChainError, work_over_cradle: f64, feed: BladeFeed) -> AngleError {
    AngleError::harmonic(
        error.amplitude,
        cradle_order(error, work_over_cradle, feed),
        error.phase,
    )
}

/// Cycles of an error per revolution of the cradle.
pub fn cradle_order(error: &ChainError, work_over_cradle: f64, feed: BladeFeed) -> f64 {
    error.cycles * revolutions_per_cradle(error.target, work_over_cradle, feed)
}

/// Revolutions of a part per revolution of the cradle: ratio of roll for the work, speed ratio for the cutter.
fn revolutions_per_cradle(target: CutTarget, work_over_cradle: f64, feed: BladeFeed) -> f64 {
    match target {
        CutTarget::Cradle => 1.0,
        CutTarget::Work => work_over_cradle,
        CutTarget::Cutter => TAU / feed.cradle_per_turn,
    }
}

fn add(errors: &mut AngleErrors, target: CutTarget, error: AngleError) {
    match target {
        CutTarget::Cradle => errors.cradle.push(error),
        CutTarget::Work => errors.work.push(error),
        CutTarget::Cutter => errors.cutter.push(error),
    }
}

/// Maximum relative difference between the mean speed of a history and that of the part in the cut; a history with a smaller mean speed
/// than this share contains the error only.
const SPEED_TOLERANCE: f64 = 0.05;

/// Angle error of a history over the cradle angle, with its middle at φ_c = 0 and positive in the direction of rotation; `turns` is the
/// number of revolutions of the part per revolution of the cradle.
fn history_error(
    file: &CutFile,
    history: &SpindleHistory,
    [times, angles]: &[Vec<f64>; 2],
    turns: f64,
    grid: &FlankGrid,
) -> Result<AngleError, Error> {
    let speed = file.study.cradle_speed.unwrap_or_default();
    let duration = times[times.len() - 1] - times[0];
    let middle = times[0] + 0.5 * duration;
    let angles_of_roll = grid.nodes.iter().flatten().map(|n| n.point.at[2].abs());
    let max_roll = angles_of_roll.fold(0.0, f64::max);
    let invalid = |message: String, hint: &str| {
        Err(Error::new(Code::OutOfRange, message)
            .with_span(&history.span)
            .with_hint(hint))
    };
    if 0.5 * duration * speed.abs() < max_roll {
        let message = format!(
            "the history lasts {duration:.3} s; the roll over the flank takes {:.3} s about its middle",
            2.0 * max_roll / speed.abs()
        );
        return invalid(message, "simulate for longer, or raise `cradle_speed`");
    }
    let line = straight_line(times, angles);
    let (slope, expected) = (line[1].abs(), (speed * turns).abs());
    if slope > SPEED_TOLERANCE * expected && (slope / expected - 1.0).abs() > SPEED_TOLERANCE {
        let [slope, expected] = [slope, expected].map(f64::to_degrees);
        let message = format!(
            "column `{}` turns at {slope:.4} deg/s, and the {} at {expected:.4} deg/s",
            history.column,
            history.target.name()
        );
        return invalid(message, "check `column`, `target` and `cradle_speed`");
    }
    // A history of the error only has no direction of rotation.
    let is_reversed = line[1] < 0.0 && slope > SPEED_TOLERANCE * expected;
    let sign = if is_reversed { -1.0 } else { 1.0 };
    let reading = |(t, a): (&f64, &f64)| {
        (
            speed * (t - middle),
            sign * (a - line[0] - line[1] * (t - middle)),
        )
    };
    let mut readings: Vec<(f64, f64)> = times.iter().zip(angles).map(reading).collect();
    if speed < 0.0 {
        readings.reverse();
    }
    let (cradle_angles, errors) = readings.into_iter().unzip();
    AngleError::readings(cradle_angles, errors)
        .ok_or_else(|| Error::new(Code::OutOfRange, "the history has fewer than two rows"))
}

/// Least-squares straight line: value at the middle of the times and slope.
fn straight_line(times: &[f64], angles: &[f64]) -> [f64; 2] {
    let count = times.len() as f64;
    let middle = 0.5 * (times[0] + times[times.len() - 1]);
    let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / count;
    let mean_time = mean(&mut times.iter().map(|t| t - middle));
    let mean_angle = mean(&mut angles.iter().copied());
    let pairs = || {
        times
            .iter()
            .zip(angles)
            .map(|(t, a)| (t - middle - mean_time, a - mean_angle))
    };
    let slope = pairs().map(|(t, a)| t * a).sum::<f64>() / pairs().map(|(t, _)| t * t).sum::<f64>();
    [mean_angle - slope * mean_time, slope]
}
