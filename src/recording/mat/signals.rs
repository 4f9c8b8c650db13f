//! Channel extraction of a MATLAB file, grouped by time vector.

use super::roles;
use super::variables::{Variable, parent};
use crate::base::error::{Diagnostic, Error};
use crate::base::quantity;
use crate::base::quantity_kind::QuantityKind;
use crate::recording::raw::{ChannelGroup, RawChannel, RawLog, RawTiming, TimeStamps};
use crate::recording::read_options::ReadOptions;
use crate::recording::resolution::Resolution;
use crate::recording::sample_column::SampleColumn;
use crate::recording::stated_rates::{StatedRate, agreed_rate};

/// Minimum length of a signal, samples; shorter vectors are parameters.
const MIN_SIGNAL_LEN: usize = 8;

/// Moves time vectors, rates and channels from `numbers` to `log`.
pub(super) fn take_channels(
    numbers: &mut Vec<Variable>,
    options: &ReadOptions,
    log: &mut RawLog,
) -> Result<(), Error> {
    let rates = take_rates(numbers);
    let times = take_times(numbers, options, !rates.is_empty());
    if times.is_empty() {
        let length = numbers.iter().filter(|v| v.im.is_none());
        let length = length.map(Variable::length).max().unwrap_or(0);
        if length >= MIN_SIGNAL_LEN {
            push_group(numbers, length, None, RawTiming::default(), log)?;
            for group in &mut log.groups {
                let mut parents: Vec<&str> =
                    group.channels.iter().map(|c| parent(&c.name)).collect();
                parents.dedup();
                group.timing.stated_rates = match parents[..] {
                    [parent] => structure_rates(&rates, parent),
                    _ => rates.clone(),
                };
            }
        }
        return Ok(());
    }
    for time in times {
        let stated_rates = structure_rates(&rates, time.parent_path());
        let rate = agreed_rate(&stated_rates, false).ok().flatten();
        let deviation = rate.and_then(|rate| mean_step_deviation(&time, rate.hertz));
        if let (Some(deviation), Some(rate)) = (deviation, rate) {
            log.diagnostics.push(Diagnostic {
                code: "time-rounded",
                message: format!(
                    "`{}` is rounded to single precision, its steps are off by {deviation:.1e}: `{}` is taken, {} Hz",
                    time.name, rate.key, rate.hertz
                ),
                hint: None,
            });
        }
        let stamps = match deviation {
            Some(_) => None,
            None => Some(time_stamps(&time, options)?),
        };
        let timing = RawTiming {
            stated_rates,
            stamps,
            ..RawTiming::default()
        };
        // Vectors of the structure of the time vector take precedence, which separates runs of equal length.
        let parent = Some(time.parent_path()).filter(|parent| !parent.is_empty());
        push_group(numbers, time.re.len(), parent, timing, log)?;
    }
    Ok(())
}

/// Removes the scalars that state a sample rate and returns the rates.
fn take_rates(numbers: &mut Vec<Variable>) -> Vec<StatedRate> {
    let rates = numbers.iter().filter_map(roles::stated_rate_hz).collect();
    numbers.retain(|v| roles::stated_rate_hz(v).is_none());
    rates
}

/// Rates stated within a structure; all rates if it states none.
fn structure_rates(rates: &[StatedRate], structure: &str) -> Vec<StatedRate> {
    let is_member = |r: &&StatedRate| parent(&r.key) == structure;
    let stated: Vec<StatedRate> = rates.iter().filter(is_member).cloned().collect();
    match stated.is_empty() {
        true => rates.to_vec(),
        false => stated,
    }
}

/// Removes and returns the time vectors: the requested one, else those with a name of time, else the only uniform vector.
fn take_times(numbers: &mut Vec<Variable>, options: &ReadOptions, has_rate: bool) -> Vec<Variable> {
    let indices: Vec<usize> = match options.time_column.as_deref() {
        Some("none") => Vec::new(),
        Some(name) => positions(numbers, |v| {
            v.name == name && v.im.is_none() && v.is_vector()
        }),
        None => {
            let named = positions(numbers, roles::is_time);
            let uniform = positions(numbers, |v| {
                v.length() >= MIN_SIGNAL_LEN && roles::is_uniform(v)
            });
            match (named.is_empty(), has_rate, uniform.as_slice()) {
                (false, ..) => named,
                (true, false, &[index]) => vec![index],
                _ => Vec::new(),
            }
        }
    };
    let mut times: Vec<Variable> = indices.iter().rev().map(|&at| numbers.remove(at)).collect();
    times.reverse();
    times
}

fn positions(numbers: &[Variable], test: impl Fn(&Variable) -> bool) -> Vec<usize> {
    (0..numbers.len()).filter(|&i| test(&numbers[i])).collect()
}

/// Mean relative deviation of the time steps from the stated rate if single-precision rounding explains the largest one.
fn mean_step_deviation(time: &Variable, rate_hz: f64) -> Option<f64> {
    let largest = time.re.iter().fold(0.0_f64, |most, t| most.max(t.abs()));
    // Unit in the last place at the end of the record.
    let unit = f64::from(f32::EPSILON) * largest * rate_hz;
    let deviation = |pair: &[f64]| ((pair[1] - pair[0]) * rate_hz - 1.0).abs();
    let max_deviation = time.re.windows(2).map(deviation).fold(0.0, f64::max);
    let is_single = time.epsilon == f64::from(f32::EPSILON);
    let steps = (time.re.len() - 1) as f64;
    let mean = ((time.re[time.re.len() - 1] - time.re[0]) * rate_hz / steps - 1.0).abs();
    (is_single && max_deviation <= 2.0 * unit && unit < 0.1).then_some(mean)
}

/// Time stamps, s since the first stamp.
fn time_stamps(time: &Variable, options: &ReadOptions) -> Result<TimeStamps, Error> {
    let unit = options.time_unit.as_deref().unwrap_or_default();
    let scale = match unit {
        "" => 1.0,
        unit => quantity::parse(&format!("1 {unit}"), QuantityKind::Time, "the unit of time")?,
    };
    let start = time.re[0];
    let seconds: Vec<f64> = time.re.iter().map(|t| (t - start) * scale).collect();
    let largest = time.re.iter().fold(0.0_f64, |most, t| most.max(t.abs()));
    Ok(TimeStamps {
        name: time.name.clone(),
        unit: unit.to_string(),
        first: String::new(),
        first_s: start * scale,
        seconds: SampleColumn::from_slice(&seconds),
        resolution: Resolution::constant(match time.epsilon {
            1.0 => scale, // integers
            epsilon => epsilon * largest * scale,
        }),
    })
}

/// Moves the real variables with a side of `length` to a group of `log`; only those of `parent` if it has such variables.
fn push_group(
    numbers: &mut Vec<Variable>,
    length: usize,
    parent: Option<&str>,
    timing: RawTiming,
    log: &mut RawLog,
) -> Result<(), Error> {
    let fits = |v: &Variable| v.im.is_none() && !v.series(length).is_empty();
    let is_sibling =
        |v: &Variable| fits(v) && parent.is_some_and(|parent| v.parent_path() == parent);
    let has_siblings = numbers.iter().any(is_sibling);
    let is_selected = |v: &Variable| if has_siblings { is_sibling(v) } else { fits(v) };
    let (selected, remaining) = numbers.drain(..).partition::<Vec<_>, _>(is_selected);
    *numbers = remaining;
    let mut group = ChannelGroup {
        timing,
        channels: Vec::new(),
    };
    for variable in selected {
        let series = variable.series(length);
        for (at, &(start, step)) in series.iter().enumerate() {
            let mut samples = SampleColumn::default();
            let values = variable.re[start..].iter().step_by(step).take(length);
            samples.push(&values.copied().collect::<Vec<f64>>())?;
            group.channels.push(RawChannel {
                name: variable.series_name(at, series.len()),
                samples,
                ..RawChannel::default()
            });
        }
    }
    if !group.channels.is_empty() {
        log.groups.push(group);
    }
    Ok(())
}
