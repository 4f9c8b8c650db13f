//! Which columns tell the time.

use super::Plan;
use super::shown::{Columns, folded, over_frequency, position};
use crate::base::error::{Error, Warning};
use crate::recording::settings::Settings;
use crate::recording::text::dialect::Kind;
use crate::recording::text::stamps::Form;

/// Names of a time column, folded.
const TIMES: &[&str] = &[
    "time",
    "t",
    "zeit",
    "时间",
    "时刻",
    "temps",
    "tiempo",
    "tempo",
    "время",
    "timestamp",
    "time stamp",
    "date",
    "datetime",
    "date time",
    "date/time",
    "datum",
    "uhrzeit",
    "zeitstempel",
    "elapsed",
    "elapsed time",
    "elapsed seconds",
    "seconds",
    "sec",
    "secs",
    "time s",
    "time sec",
    "time seconds",
    "time ms",
    "time us",
    "t s",
    "t ms",
    "zeit s",
    "x value",
    "clock",
    "relative time",
    "abs time",
    "absolute time",
    "rel time",
    "time axis",
    "timestamp s",
    "timestamp ms",
    "timestamp us",
    "timestamp ns",
    "epoch",
    "unix time",
    "messzeit",
    "采样时间",
    "日期",
    "日期时间",
];

/// Names of a column that counts rows, folded.
const COUNTERS: &[&str] = &[
    "sample",
    "samples",
    "sample number",
    "sample no",
    "sample index",
    "index",
    "idx",
    "no",
    "nr",
    "n",
    "#",
    "count",
    "counter",
    "scan",
    "scan number",
    "point",
    "row",
    "序号",
    "lfd nr",
    "packet",
    "",
];

/// Which columns tell the time.
pub(super) struct Clock {
    pub(super) times: Vec<usize>,
    pub(super) counter: Option<usize>,
}

impl Clock {
    /// The columns that settings name, else by name, form and unit, else the first where it rises evenly and nothing is named.
    pub(super) fn find(
        columns: &Columns<'_>,
        width: usize,
        settings: &Settings,
        plan: &mut Plan,
    ) -> Result<Clock, Error> {
        let none = |counter| Clock {
            times: Vec::new(),
            counter,
        };
        match settings.time_column.as_deref() {
            Some("none") => return Ok(none(None)),
            Some(name) => {
                let at = position(columns, width, name)?;
                return Ok(Clock {
                    times: vec![at],
                    counter: None,
                });
            }
            None => {}
        }
        let numeric = |c: &usize| columns.is_number(*c);
        let mut times: Vec<usize> = (0..width)
            .filter(numeric)
            .filter(|c| columns.is_named(*c, TIMES))
            .filter(|c| {
                columns.is_rising(*c)
                    || width > 1 && columns.unit_s(*c).is_some()
                    || folded(&columns.header.names[*c]) == "time"
            })
            .collect();
        if times.len() > 1 && !is_clock_per_channel(&times, width) {
            times.truncate(1);
        }
        if times.is_empty() {
            let by_form = |form| (0..width).find(|c| columns.kinds[*c] == Kind::Stamp(form));
            let stamped = by_form(Form::DateTime)
                .or_else(|| by_form(Form::Clock))
                .or_else(|| by_form(Form::Date));
            times.extend(stamped);
        }
        if times.is_empty() {
            let ends = [0, width.saturating_sub(1)];
            let by_unit = |c: &usize| {
                width > 1
                    && columns.is_number(*c)
                    && columns.unit_s(*c).is_some()
                    && columns.is_rising(*c)
            };
            times.extend(ends.into_iter().find(by_unit));
        }
        let counter = (0..width.min(2)).find(|c| {
            let named = columns.header.written.iter().any(|w| !w.is_empty());
            let name = folded(&columns.header.names[*c]);
            width > 1
                && columns.is_counting(*c)
                && !times.contains(c)
                && named
                && COUNTERS.contains(&name.as_str())
        });
        let unnamed = columns.header.written.iter().all(String::is_empty);
        if times.is_empty()
            && counter.is_none()
            && unnamed
            && width > 1
            && columns.is_number(0)
            && columns.is_even(0)
            && !over_frequency(columns, width)
        {
            if columns.is_counting(0) {
                return Ok(none(Some(0)));
            }
            plan.warnings.push(Warning {
                code: "time-guessed",
                message:
                    "column 1 has no name and rises evenly: it is taken for the time in seconds"
                        .into(),
                hint: Some(
                    "say which column is the time, or that none is: --time COLUMN, --time none"
                        .into(),
                ),
            });
            times.push(0);
        }
        Ok(Clock { times, counter })
    }
}

/// Time columns that each go before channels of their own.
fn is_clock_per_channel(times: &[usize], width: usize) -> bool {
    times[0] == 0
        && times.windows(2).all(|w| w[1] > w[0] + 1)
        && times.last().is_some_and(|t| t + 1 < width)
}
