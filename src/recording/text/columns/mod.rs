//! What becomes of each column: a channel, time stamps, a counter, nothing.

use self::clock::Clock;
use self::shown::{Columns, called, over_frequency, position};
use self::unit_of_time::{epoch, seconds_of, unit_word};
use super::cells::Marks;
use super::dialect::Kind;
use super::header::Header;
use super::stamps::{self, Form};
use crate::base::code::Code;
use crate::base::error::{Error, Warning};
use crate::recording::settings::{RateSource, Settings};

/// Units of time stamps.
mod unit_of_time;

/// Tables of responses without names.
mod causal;

/// What the head shows.
mod shown;

/// Which columns tell the time.
mod clock;

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
    let mut columns = Columns::new(header, kinds, rows, marks);
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
    if settings.time_column.is_none()
        && settings.rate.is_none()
        && columns.name_responses(rows, marks)
    {
        plan.warnings.push(Warning {
            code: "frequency-guessed",
            message: "no column has a name; by their numbers the first holds frequencies, taken in Hz, and the others are frequency responses".into(),
            hint: Some(
                "name the columns, such as frequency_Hz, H1_re, H1_im; or say which is the time: --time \"column 1\""
                    .into(),
            ),
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
