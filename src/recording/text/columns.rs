//! What becomes of each column: a channel, time stamps, a counter, nothing.

use std::collections::HashSet;

use super::cells::{self, Cell, Cells, Marks};
use super::dialect::Kind;
use super::header::Header;
use super::stamps::{self, Form};
use super::table;
use crate::base::code::Code;
use crate::base::error::{Error, Warning};
use crate::base::words;
use crate::recording::names;
use crate::recording::settings::{RateSource, Settings};

/// What is done with the cells of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// They are passed over.
    Skip,
    /// They are the samples of a sink.
    Value(usize),
    /// Real and imaginary parts go to a sink and the next.
    Complex(usize),
    /// They are the stamps of a group: its sink, and its reader.
    Time(usize, usize),
}

/// Where samples go.
#[derive(Debug, Clone)]
pub struct Sink {
    /// Its name.
    pub name: String,
    /// Its unit as written.
    pub unit: String,
    /// The clock it belongs to.
    pub group: usize,
    /// Its reader, where it holds stamps.
    pub reader: Option<usize>,
}

/// What becomes of the columns.
#[derive(Debug, Default)]
pub struct Plan {
    /// By column.
    pub roles: Vec<Role>,
    /// Where samples go.
    pub sinks: Vec<Sink>,
    /// Readers of stamps.
    pub readers: Vec<stamps::Reader>,
    /// Clocks.
    pub groups: usize,
    /// Cells a row must have; more, up to `roles`, may be there.
    pub required: usize,
    /// The first column holds frequencies.
    pub over_frequency: bool,
    /// Columns passed over, and why.
    pub left_out: Vec<(String, &'static str)>,
    /// Guesses.
    pub warnings: Vec<Warning>,
}

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

/// Names of a column of frequencies, folded.
const FREQUENCIES: &[&str] = &[
    "frequency",
    "freq",
    "f",
    "frequenz",
    "frequency hz",
    "freq hz",
    "f hz",
    "频率",
    "fréquence",
    "frecuencia",
    "hz",
];

/// Rows of the head that are looked at for rising numbers.
const LOOKED_AT: usize = 200;

/// A name in lower case, without signs between words.
fn folded(name: &str) -> String {
    let spaced: String = name
        .chars()
        .map(|c| if matches!(c, '_' | '-' | '.') { ' ' } else { c })
        .collect();
    spaced
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
        .to_lowercase()
}

/// The columns with what the head shows of them.
struct Columns<'a> {
    header: &'a Header,
    kinds: &'a [Kind],
    /// What each column is called: names that repeat are numbered.
    called: Vec<String>,
    /// Numbers of the first rows, by column; NaN for anything else.
    sample: Vec<Vec<f64>>,
}

impl Columns<'_> {
    fn is_named(&self, column: usize, table: &[&str]) -> bool {
        let name = folded(&self.header.names[column]);
        // `time1`, `Time 2`, `Time_acc` of logs with a clock per channel.
        let bare = name
            .trim_end_matches(|c: char| c.is_ascii_digit())
            .trim_end();
        let own = !self.header.written[column].is_empty();
        own && (table.contains(&name.as_str()) || (!bare.is_empty() && table.contains(&bare)))
    }

    /// Numbers that never fall and rise somewhere, or a single row.
    fn is_rising(&self, column: usize) -> bool {
        let numbers: Vec<f64> = self.sample[column]
            .iter()
            .copied()
            .filter(|x| x.is_finite())
            .collect();
        let last = numbers.len().saturating_sub(1);
        numbers.windows(2).all(|w| w[1] >= w[0]) && (last == 0 || numbers[last] > numbers[0])
    }

    /// Whole numbers that rise by one.
    fn is_counting(&self, column: usize) -> bool {
        let numbers = &self.sample[column];
        numbers.len() > 1
            && numbers.windows(2).all(|w| w[1] == w[0] + 1.0)
            && numbers[0].fract() == 0.0
    }

    /// Steps alike to half of the largest: a clock, where there is no name to tell.
    fn is_even(&self, column: usize) -> bool {
        const ENOUGH: usize = 8;
        let steps: Vec<f64> = self.sample[column]
            .windows(2)
            .map(|w| w[1] - w[0])
            .collect();
        let (least, most) = steps
            .iter()
            .fold((f64::INFINITY, 0.0_f64), |(a, b), s| (a.min(*s), b.max(*s)));
        steps.len() + 1 >= ENOUGH && least > 0.5 * most && steps.iter().all(|s| s.is_finite())
    }

    /// Whole numbers.
    fn is_whole(&self, column: usize) -> bool {
        let numbers = &self.sample[column];
        numbers.len() > 1 && numbers.iter().all(|x| x.fract() == 0.0)
    }

    fn unit_s(&self, column: usize) -> Option<f64> {
        seconds_of(&self.header.units[column])
    }

    fn is_number(&self, column: usize) -> bool {
        self.kinds[column] == Kind::Number
    }
}

/// Seconds of a unit of time.
fn seconds_of(unit: &str) -> Option<f64> {
    Some(match unit.trim().to_lowercase().as_str() {
        "s" | "sec" | "secs" | "second" | "seconds" | "sekunden" | "秒" => 1.0,
        "ms" | "msec" | "milliseconds" | "毫秒" => 1e-3,
        "us" | "µs" | "μs" | "usec" | "microseconds" | "微秒" => 1e-6,
        "ns" | "nanoseconds" => 1e-9,
        "min" | "minutes" => 60.0,
        "h" | "hours" => 3600.0,
        _ => return None,
    })
}

/// Numbers of the first rows by column.
fn sample(rows: &[&str], marks: Marks, width: usize) -> Vec<Vec<f64>> {
    let mut sample = vec![Vec::new(); width];
    for row in rows.iter().filter(|r| !r.trim().is_empty()).take(LOOKED_AT) {
        let mut cells = Cells::new(row.as_bytes(), marks.delimiter);
        for column in &mut sample {
            let value = match cells
                .next()
                .map(|(_, cell)| cells::read(cell, marks.decimal))
            {
                Some(Cell::Number(value) | Cell::Grouped { value, .. }) => value,
                _ => f64::NAN,
            };
            column.push(value);
        }
    }
    sample
}

/// What becomes of the columns: `rows` are the lines of numbers in the head, `rate` what the preamble states, Hz.
///
/// # Errors
/// A column or channel that the settings name is not there.
pub fn plan(
    header: &Header,
    kinds: &[Kind],
    marks: Marks,
    rows: &[&str],
    rate: Option<f64>,
    settings: &Settings,
) -> Result<Plan, Error> {
    let stated = settings.time_unit.as_deref();
    if let Some(unit) = stated.filter(|unit| seconds_of(unit).is_none()) {
        let message = format!("`{unit}` is no unit of time");
        return Err(Error::new(Code::WrongUnit, message).hint("it takes s, ms, µs, ns, min or h"));
    }
    let columns = Columns {
        header,
        kinds,
        called: apart(header, kinds.len()),
        sample: sample(rows, marks, kinds.len()),
    };
    // Empty columns without a name at the end are what a trailing delimiter leaves.
    let filled = |at: &usize| kinds[*at] != Kind::Empty;
    let required = (0..kinds.len()).rev().find(filled).map_or(0, |at| at + 1);
    let named = |at: &usize| !header.written[*at].is_empty();
    let width = (0..kinds.len())
        .rev()
        .find(named)
        .map_or(0, |at| at + 1)
        .max(required);
    let mut plan = Plan {
        required,
        groups: 1,
        ..Plan::default()
    };
    let repeated = |c: &usize| columns.called[*c] != called(header, *c);
    if let Some(at) = (0..width).find(repeated) {
        let (name, own) = (called(header, at), &columns.called[at]);
        plan.warnings.push(Warning {
            code: "name-twice",
            message: format!(
                "two columns are named `{name}`: the first keeps the name, the second is called `{own}`"
            ),
            hint: Some("give every column a name of its own".into()),
        });
    }
    let clock = Clock::find(&columns, width, settings, &mut plan)?;
    plan.over_frequency = clock.times.is_empty() && over_frequency(&columns, width);
    plan.groups = clock.times.len().max(1);
    let rate = match settings.rate {
        Some(RateSource::Hertz(hertz)) => Some(hertz),
        _ => rate,
    };
    let wanted = Wanted::new(&columns, width, &clock, settings, plan.over_frequency)?;
    for column in 0..width {
        let group = clock.times.iter().rposition(|t| *t <= column).unwrap_or(0);
        let role = plan.role(
            column, group, &columns, &clock, &wanted, rate, marks, settings,
        );
        plan.roles.push(role);
    }
    Ok(plan)
}

/// Whether the first column holds frequencies.
fn over_frequency(columns: &Columns<'_>, width: usize) -> bool {
    let hertz = || columns.header.units[0].trim().eq_ignore_ascii_case("hz");
    let named = columns.is_named(0, FREQUENCIES);
    let complex = columns.kinds[1..width.max(1)].contains(&Kind::Complex);
    let unnamed = columns.header.written[0].is_empty();
    let pairs = || (1..width).all(|c| table::is_part(&columns.header.names[c]));
    let sure = named && width > 2 && pairs();
    let told = named || (unnamed && (hertz() || complex));
    width > 1 && columns.is_number(0) && (sure || (told && columns.is_rising(0)))
}

/// Which columns tell the time.
struct Clock {
    times: Vec<usize>,
    counter: Option<usize>,
}

impl Clock {
    fn find(
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

/// The column of a name.
fn position(columns: &Columns<'_>, width: usize, name: &str) -> Result<usize, Error> {
    let header = columns.header;
    let by_place = |c: usize| format!("column {}", c + 1) == name;
    let is_own = |c: &usize| columns.called[*c] == name;
    (0..width)
        .find(is_own)
        .or_else(|| (0..width).find(|c| header.written[*c] == name || by_place(*c)))
        .or_else(|| {
            (0..width)
                .find(|c| !header.names[*c].is_empty() && names::means(name, &header.names[*c]))
        })
        .or_else(|| names::find(name, &header.names[..width.min(header.names.len())]))
        .ok_or_else(|| missing(name, &columns.called[..width]))
}

/// What each column is called: names that repeat are numbered.
fn apart(header: &Header, width: usize) -> Vec<String> {
    let mut taken = HashSet::new();
    let own = |column: usize| {
        let name = called(header, column);
        let numbered = (2..).map(|n| format!("{name} {n}"));
        let mut all = std::iter::once(name.clone()).chain(numbered);
        let own = all.find(|n| !taken.contains(n)).unwrap_or(name);
        taken.insert(own.clone());
        own
    };
    (0..width).map(own).collect()
}

/// The name a column goes by.
fn called(header: &Header, column: usize) -> String {
    match header.names[column].as_str() {
        "" => format!("column {}", column + 1),
        name => name.to_string(),
    }
}

fn missing(name: &str, known: &[String]) -> Error {
    let all = || known.iter().map(String::as_str);
    let hint = match words::suggestion(name, all()) {
        Some(near) => format!(
            "did you mean `{near}`? the columns are {}",
            words::listed(all())
        ),
        None => format!("the columns are {}", words::listed(all())),
    };
    Error::new(Code::NoChannel, format!("the log has no column `{name}`")).hint(hint)
}

/// Which channels are kept.
struct Wanted(Option<Vec<usize>>);

impl Wanted {
    fn new(
        columns: &Columns<'_>,
        width: usize,
        clock: &Clock,
        settings: &Settings,
        all: bool,
    ) -> Result<Wanted, Error> {
        if settings.only.is_empty() || all {
            return Ok(Wanted(None));
        }
        let renamed = |word: &str| {
            let by = settings
                .channels
                .iter()
                .find(|c| c.rename.as_deref() == Some(word));
            by.map_or(word.to_string(), |c| c.name.clone())
        };
        let found: Result<Vec<usize>, Error> = settings
            .read()
            .iter()
            .map(|word| position(columns, width, &renamed(word)))
            .collect();
        let found = found?;
        match found.iter().find(|c| clock.times.contains(c)) {
            Some(c) => Err(Error::new(
                Code::NoChannel,
                format!(
                    "`{}` holds the time stamps, not a channel",
                    columns.called[*c]
                ),
            )
            .hint("name a channel, or say which column is the time: --time COLUMN")),
            None => Ok(Wanted(Some(found))),
        }
    }

    fn contains(&self, column: usize) -> bool {
        self.0.as_ref().is_none_or(|kept| kept.contains(&column))
    }
}

impl Plan {
    #[allow(clippy::too_many_arguments)] // one step of `plan`, which holds them all
    fn role(
        &mut self,
        column: usize,
        group: usize,
        columns: &Columns<'_>,
        clock: &Clock,
        wanted: &Wanted,
        rate: Option<f64>,
        marks: Marks,
        settings: &Settings,
    ) -> Role {
        let name = columns.called[column].clone();
        let written_unit = columns.header.units[column].clone();
        if clock.times.contains(&column) {
            let (form, unit) = match columns.kinds[column] {
                Kind::Stamp(form) => (form, "date-time".to_string()),
                _ => (
                    Form::Decimal,
                    settings.time_unit.clone().unwrap_or(written_unit),
                ),
            };
            let unit_s = match (form, seconds_of(&unit)) {
                (Form::Decimal, Some(unit_s)) => unit_s,
                (Form::Decimal, None) => {
                    let unit_s = epoch(&columns.sample[column]);
                    self.say_unit(&name, &unit, unit_s, columns.is_whole(column));
                    unit_s
                }
                _ => 1.0,
            };
            let unit = if unit.is_empty() {
                unit_word(unit_s)
            } else {
                unit
            };
            return self.time(
                name,
                unit,
                group,
                stamps::Reader::new(form, unit_s, marks.decimal, settings.dialect.day_first),
            );
        }
        if clock.counter == Some(column) && !wanted.0.as_ref().is_some_and(|w| w.contains(&column))
        {
            if let (Some(hertz), true) = (rate, clock.times.is_empty()) {
                let reader = stamps::Reader::new(Form::Decimal, 1.0 / hertz, marks.decimal, None);
                return self.time(name, "samples".into(), group, reader);
            }
            self.leave_out(name, "counts the rows");
            return Role::Skip;
        }
        if !wanted.contains(column) {
            return Role::Skip;
        }
        match columns.kinds[column] {
            Kind::Text => {
                self.leave_out(name, "holds words");
                Role::Skip
            }
            Kind::Stamp(_) => {
                self.leave_out(name, "holds dates or times beside the stamps");
                Role::Skip
            }
            Kind::Complex => {
                let sink = self.sink(format!("{name} re"), &written_unit, group);
                self.sink(format!("{name} im"), &written_unit, group);
                Role::Complex(sink)
            }
            Kind::Number | Kind::Empty => Role::Value(self.sink(name, &written_unit, group)),
        }
    }

    /// Says what stamps without a unit of time are taken in, where another one could be meant.
    fn say_unit(&mut self, name: &str, unit: &str, unit_s: f64, is_whole: bool) {
        let word = unit_word(unit_s);
        let message = match unit {
            "" if is_whole && unit_s == 1.0 => {
                format!(
                    "`{name}` counts in whole numbers and states no unit: it is taken in {word}"
                )
            }
            "" if unit_s != 1.0 => {
                format!("`{name}` states no unit: by its size it is taken in {word} since 1970")
            }
            "" => return,
            unit => format!("`{unit}` of `{name}` is no unit of time: it is taken in {word}"),
        };
        let hint = "state it: --time-unit ms, or that it counts samples: --time none --rate HZ";
        self.warnings.push(Warning {
            code: "time-guessed",
            message,
            hint: Some(hint.into()),
        });
    }

    fn time(&mut self, name: String, unit: String, group: usize, reader: stamps::Reader) -> Role {
        self.readers.push(reader);
        let reader = self.readers.len() - 1;
        self.sinks.push(Sink {
            name,
            unit,
            group,
            reader: Some(reader),
        });
        Role::Time(self.sinks.len() - 1, reader)
    }

    fn sink(&mut self, name: String, unit: &str, group: usize) -> usize {
        self.sinks.push(Sink {
            name,
            unit: unit.to_string(),
            group,
            reader: None,
        });
        self.sinks.len() - 1
    }

    fn leave_out(&mut self, name: String, why: &'static str) {
        self.left_out.push((name, why));
    }
}

/// Seconds of one unit of time stamps without a unit: those since 1970 tell theirs by their size.
fn epoch(sample: &[f64]) -> f64 {
    match sample
        .iter()
        .copied()
        .find(|x| x.is_finite())
        .unwrap_or(0.0)
    {
        t if t > 1e17 => 1e-9,
        t if t > 1e14 => 1e-6,
        t if t > 1e11 => 1e-3,
        _ => 1.0,
    }
}

fn unit_word(unit_s: f64) -> String {
    let known = [(1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns")];
    let word = known.iter().find(|(seconds, _)| *seconds == unit_s);
    word.map_or("s", |(_, word)| word).to_string()
}
