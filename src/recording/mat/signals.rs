//! Channels of a MATLAB file, grouped by their time vectors.

use super::roles;
use super::variables::{Variable, parent};
use crate::base::error::{Error, Warning};
use crate::base::kind::Kind;
use crate::base::units;
use crate::recording::column::Column;
use crate::recording::raw::{Clock, Group, Raw, RawChannel, Stamps};
use crate::recording::resolution::Resolution;
use crate::recording::settings::Settings;
use crate::recording::stated_rates::{StatedRate, agreed};

/// Fewer numbers in a row are parameters, not signals.
const SHORTEST: usize = 8;

/// Takes time vectors, rates and channels out of `numbers` and puts them into `raw`.
pub(super) fn take(
    numbers: &mut Vec<Variable>,
    settings: &Settings,
    raw: &mut Raw,
) -> Result<(), Error> {
    let rates = take_rates(numbers);
    let times = take_times(numbers, settings, !rates.is_empty());
    if times.is_empty() {
        let length = numbers.iter().filter(|v| v.im.is_none());
        let length = length.map(Variable::length).max().unwrap_or(0);
        if length >= SHORTEST {
            push_group(numbers, length, None, Clock::default(), raw)?;
            for group in &mut raw.groups {
                let mut parents: Vec<&str> =
                    group.channels.iter().map(|c| parent(&c.name)).collect();
                parents.dedup();
                group.clock.stated_rates = match parents[..] {
                    [own] => of_structure(&rates, own),
                    _ => rates.clone(),
                };
            }
        }
        return Ok(());
    }
    for time in times {
        let stated_rates = of_structure(&rates, time.parent());
        let rate = agreed(&stated_rates, false).ok().flatten();
        let creep = rate.and_then(|rate| creep(&time, rate.hertz));
        if let (Some(creep), Some(rate)) = (creep, rate) {
            raw.warnings.push(Warning {
                code: "time-rounded",
                message: format!(
                    "`{}` is in single precision and creeps by {creep:.1e} of a step: `{}` is taken, {} Hz",
                    time.name, rate.key, rate.hertz
                ),
                hint: None,
            });
        }
        let stamps = match creep {
            Some(_) => None,
            None => Some(stamps(&time, settings)?),
        };
        let clock = Clock {
            stated_rates,
            stamps,
            ..Clock::default()
        };
        // Vectors of the same structure as the time first, so that equally long runs stay apart.
        let parent = Some(time.parent()).filter(|parent| !parent.is_empty());
        push_group(numbers, time.re.len(), parent, clock, raw)?;
    }
    Ok(())
}

/// The scalars that state a sample rate.
fn take_rates(numbers: &mut Vec<Variable>) -> Vec<StatedRate> {
    let rates = numbers.iter().filter_map(roles::rate).collect();
    numbers.retain(|v| roles::rate(v).is_none());
    rates
}

/// The rates stated within a structure; all of them where it states none.
fn of_structure(rates: &[StatedRate], structure: &str) -> Vec<StatedRate> {
    let own = |r: &&StatedRate| parent(&r.key) == structure;
    let found: Vec<StatedRate> = rates.iter().filter(own).cloned().collect();
    match found.is_empty() {
        true => rates.to_vec(),
        false => found,
    }
}

/// The time vectors: the one that was asked for, else those named so, else the single one that rises by equal steps.
fn take_times(numbers: &mut Vec<Variable>, settings: &Settings, has_rate: bool) -> Vec<Variable> {
    let wanted: Vec<usize> = match settings.time_column.as_deref() {
        Some("none") => Vec::new(),
        Some(name) => indices(numbers, |v| {
            v.name == name && v.im.is_none() && v.is_vector()
        }),
        None => {
            let named = indices(numbers, roles::is_time);
            let uniform = indices(numbers, |v| v.length() >= SHORTEST && roles::is_uniform(v));
            match (named.is_empty(), has_rate, uniform.as_slice()) {
                (false, ..) => named,
                (true, false, &[one]) => vec![one],
                _ => Vec::new(),
            }
        }
    };
    let mut times: Vec<Variable> = wanted.iter().rev().map(|&at| numbers.remove(at)).collect();
    times.reverse();
    times
}

fn indices(numbers: &[Variable], is: impl Fn(&Variable) -> bool) -> Vec<usize> {
    (0..numbers.len()).filter(|&at| is(&numbers[at])).collect()
}

/// How far the steps of a time in single precision differ from those of the rate stated, in steps, where rounding at every step
/// explains it.
fn creep(time: &Variable, rate_hz: f64) -> Option<f64> {
    let largest = time.re.iter().fold(0.0_f64, |most, t| most.max(t.abs()));
    // One unit of the last digit at the end of the record.
    let unit = f64::from(f32::EPSILON) * largest * rate_hz;
    let off = |pair: &[f64]| ((pair[1] - pair[0]) * rate_hz - 1.0).abs();
    let most = time.re.windows(2).map(off).fold(0.0, f64::max);
    let is_single = time.epsilon == f64::from(f32::EPSILON);
    let steps = (time.re.len() - 1) as f64;
    let mean = ((time.re[time.re.len() - 1] - time.re[0]) * rate_hz / steps - 1.0).abs();
    (is_single && most <= 2.0 * unit && unit < 0.1).then_some(mean)
}

/// Seconds since the first stamp.
fn stamps(time: &Variable, settings: &Settings) -> Result<Stamps, Error> {
    let unit = settings.time_unit.as_deref().unwrap_or_default();
    let scale = match unit {
        "" => 1.0,
        unit => units::parse(&format!("1 {unit}"), Kind::Time, "the unit of time")?,
    };
    let start = time.re[0];
    let seconds: Vec<f64> = time.re.iter().map(|t| (t - start) * scale).collect();
    let largest = time.re.iter().fold(0.0_f64, |most, t| most.max(t.abs()));
    Ok(Stamps {
        name: time.name.clone(),
        unit: unit.to_string(),
        first: String::new(),
        seconds: Column::from_slice(&seconds),
        resolution: Resolution::fixed(match time.epsilon {
            1.0 => scale, // integers
            epsilon => epsilon * largest * scale,
        }),
    })
}

/// Takes everything real with a side of `length`; where `parent` is given and has such variables, those alone.
fn push_group(
    numbers: &mut Vec<Variable>,
    length: usize,
    parent: Option<&str>,
    clock: Clock,
    raw: &mut Raw,
) -> Result<(), Error> {
    let fits = |v: &Variable| v.im.is_none() && !v.series(length).is_empty();
    let is_kin = |v: &Variable| fits(v) && parent.is_some_and(|parent| v.parent() == parent);
    let has_kin = numbers.iter().any(is_kin);
    let is_taken = |v: &Variable| if has_kin { is_kin(v) } else { fits(v) };
    let (taken, left) = numbers.drain(..).partition::<Vec<_>, _>(is_taken);
    *numbers = left;
    let mut group = Group {
        clock,
        channels: Vec::new(),
    };
    for variable in taken {
        let series = variable.series(length);
        for (at, &(start, step)) in series.iter().enumerate() {
            let mut samples = Column::default();
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
        raw.groups.push(group);
    }
    Ok(())
}
