//! Role of each text column: channel, time stamps, counter or skipped.

use self::preview::{ColumnPreview, column_name, column_position, over_frequency};
use self::time_columns::TimeColumns;
use self::time_unit::{epoch_unit_s, unit_name, unit_seconds};
use super::cells::Separators;
use super::dialect::CellType;
use super::header::TableHeader;
use super::time_stamps::{self, StampFormat};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::recording::read_options::{RateSource, ReadOptions};

mod time_unit;

mod causal;

mod preview;

mod time_columns;

/// Role of the cells of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnRole {
    /// Cells are ignored.
    Skip,
    /// Cells are the samples of the sink with this index.
    Value(usize),
    /// Real and imaginary parts are the samples of this sink and the next.
    Complex(usize),
    /// Cells are the time stamps of a group: index of the sink and of the stamp parser.
    Time(usize, usize),
}

/// Destination of samples.
#[derive(Debug, Clone)]
pub struct ColumnSink {
    /// Channel name.
    pub name: String,
    /// Unit as written.
    pub unit: String,
    /// Index of the clock that times the samples.
    pub group: usize,
    /// Index of the stamp parser, if the sink holds time stamps.
    pub reader: Option<usize>,
}

/// Roles and destinations of the columns.
#[derive(Debug, Clone, Default)]
pub struct ColumnPlan {
    /// Role of each column.
    pub roles: Vec<ColumnRole>,
    /// Destinations of the samples.
    pub sinks: Vec<ColumnSink>,
    /// Parsers of the time stamps.
    pub stamp_parsers: Vec<time_stamps::StampParser>,
    /// Number of clocks.
    pub groups: usize,
    /// Minimum number of cells in a row; the maximum is the length of `roles`.
    pub required: usize,
    /// Whether the first column holds frequencies.
    pub over_frequency: bool,
    /// Ignored columns, with the reason.
    pub left_out: Vec<(String, &'static str)>,
    /// Warnings about guessed names, roles and units.
    pub diagnostics: Vec<Diagnostic>,
}

/// Assigns roles to the columns: `rows` are the lines of numbers in the head, `rate` the rate stated in the preamble, Hz.
///
/// # Errors
/// An unknown unit of time; a column or channel named in the options that does not exist.
pub fn plan(
    header: &TableHeader,
    kinds: &[CellType],
    marks: Separators,
    rows: &[&str],
    rate: Option<f64>,
    options: &ReadOptions,
) -> Result<ColumnPlan, Error> {
    let stated = options.time_unit.as_deref();
    if let Some(unit) = stated.filter(|unit| unit_seconds(unit).is_none()) {
        let message = format!("`{unit}` is no unit of time");
        return Err(Error::new(Code::WrongUnit, message).with_hint("use s, ms, µs, ns, min or h"));
    }
    let mut columns = ColumnPreview::new(header, kinds, rows, marks);
    // A trailing delimiter adds empty unnamed columns at the end.
    let is_used = |at: &usize| kinds[*at] != CellType::Empty;
    let required = (0..kinds.len()).rev().find(is_used).map_or(0, |at| at + 1);
    let has_name = |at: &usize| !header.raw_names[*at].is_empty();
    let width = (0..kinds.len())
        .rev()
        .find(has_name)
        .map_or(0, |at| at + 1)
        .max(required);
    let mut plan = ColumnPlan {
        required,
        groups: 1,
        ..ColumnPlan::default()
    };
    let is_renamed = |c: &usize| columns.names[*c] != column_name(header, *c);
    if let Some(at) = (0..width).find(is_renamed) {
        let (name, own) = (column_name(header, at), &columns.names[at]);
        plan.diagnostics.push(Diagnostic {
            code: "name-twice",
            message: format!(
                "two columns are named `{name}`: the first keeps the name, the second is called `{own}`"
            ),
            hint: Some("give every column a name of its own".into()),
        });
    }
    if options.time_column.is_none()
        && options.rate.is_none()
        && columns.name_responses(rows, marks)?
    {
        plan.diagnostics.push(Diagnostic {
            code: "frequency-guessed",
            message: "no column has a name; by their numbers the first holds frequencies, taken in Hz, and the others are frequency responses".into(),
            hint: Some(
                "name the columns, such as frequency_Hz, H1_re, H1_im; or state which is the time: --time \"column 1\""
                    .into(),
            ),
        });
    }
    let timing = TimeColumns::find_time_columns(&columns, width, options, &mut plan)?;
    plan.over_frequency = timing.times.is_empty() && over_frequency(&columns, width);
    plan.groups = timing.times.len().max(1);
    let rate = match options.rate {
        Some(RateSource::Hertz(hertz)) => Some(hertz),
        _ => rate,
    };
    let request = ChannelFilter::new(&columns, width, &timing, options, plan.over_frequency)?;
    for column in 0..width {
        let group = timing.times.iter().rposition(|t| *t <= column).unwrap_or(0);
        let role = plan.role(
            column, group, &columns, &timing, &request, rate, marks, options,
        );
        plan.roles.push(role);
    }
    Ok(plan)
}

/// Columns of the requested channels; `None` for all.
struct ChannelFilter(Option<Vec<usize>>);

impl ChannelFilter {
    fn new(
        columns: &ColumnPreview<'_>,
        width: usize,
        timing: &TimeColumns,
        options: &ReadOptions,
        over_frequency: bool,
    ) -> Result<ChannelFilter, Error> {
        if options.keep_channels.is_empty() || over_frequency {
            return Ok(ChannelFilter(None));
        }
        let original_name = |word: &str| {
            let channel = options
                .channels
                .iter()
                .find(|c| c.rename.as_deref() == Some(word));
            channel.map_or(word.to_string(), |c| c.name.clone())
        };
        let requested: Result<Vec<usize>, Error> = options
            .channels_to_read()
            .iter()
            .map(|word| column_position(columns, width, &original_name(word)))
            .collect();
        let requested = requested?;
        match requested.iter().find(|c| timing.times.contains(c)) {
            Some(c) => Err(Error::new(
                Code::NoChannel,
                format!(
                    "`{}` contains the time stamps, not a channel",
                    columns.names[*c]
                ),
            )
            .with_hint("name a channel, or state which column is the time: --time COLUMN")),
            None => Ok(ChannelFilter(Some(requested))),
        }
    }

    fn contains(&self, column: usize) -> bool {
        self.0.as_ref().is_none_or(|c| c.contains(&column))
    }
}

impl ColumnPlan {
    #[allow(clippy::too_many_arguments)] // a step of `plan`, which owns the arguments
    fn role(
        &mut self,
        column: usize,
        group: usize,
        columns: &ColumnPreview<'_>,
        timing: &TimeColumns,
        request: &ChannelFilter,
        rate: Option<f64>,
        marks: Separators,
        options: &ReadOptions,
    ) -> ColumnRole {
        let name = columns.names[column].clone();
        let written_unit = columns.header.units[column].clone();
        if timing.times.contains(&column) {
            let (form, unit) = match columns.kinds[column] {
                CellType::Stamp(form) => (form, "date-time".to_string()),
                _ => (
                    StampFormat::Decimal,
                    options.time_unit.clone().unwrap_or(written_unit),
                ),
            };
            let unit_s = match (form, unit_seconds(&unit)) {
                (StampFormat::Decimal, Some(unit_s)) => unit_s,
                (StampFormat::Decimal, None) => {
                    let unit_s = epoch_unit_s(&columns.sample[column]);
                    self.report_time_unit(&name, &unit, unit_s, columns.is_integer(column));
                    unit_s
                }
                _ => 1.0,
            };
            let unit = if unit.is_empty() {
                unit_name(unit_s)
            } else {
                unit
            };
            return self.add_time_sink(
                name,
                unit,
                group,
                time_stamps::StampParser::new(
                    form,
                    unit_s,
                    marks.decimal,
                    options.dialect.day_first,
                ),
            );
        }
        if timing.counter == Some(column)
            && !request.0.as_ref().is_some_and(|w| w.contains(&column))
        {
            if let (Some(hertz), true) = (rate, timing.times.is_empty()) {
                let reader = time_stamps::StampParser::new(
                    StampFormat::Decimal,
                    1.0 / hertz,
                    marks.decimal,
                    None,
                );
                return self.add_time_sink(name, "samples".into(), group, reader);
            }
            self.skip_column(name, "counts the rows");
            return ColumnRole::Skip;
        }
        if !request.contains(column) {
            return ColumnRole::Skip;
        }
        match columns.kinds[column] {
            CellType::Text => {
                self.skip_column(name, "contains text");
                ColumnRole::Skip
            }
            CellType::Stamp(_) => {
                self.skip_column(name, "contains dates or times in addition to the stamps");
                ColumnRole::Skip
            }
            CellType::Complex => {
                let sink = self.add_sink(format!("{name} re"), &written_unit, group);
                self.add_sink(format!("{name} im"), &written_unit, group);
                ColumnRole::Complex(sink)
            }
            CellType::Number | CellType::Empty => {
                ColumnRole::Value(self.add_sink(name, &written_unit, group))
            }
        }
    }

    /// Warns about the unit assumed for time stamps that state none or an unknown one.
    fn report_time_unit(&mut self, name: &str, unit: &str, unit_s: f64, is_integer: bool) {
        let word = unit_name(unit_s);
        let message = match unit {
            "" if is_integer && unit_s == 1.0 => {
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
        self.diagnostics.push(Diagnostic {
            code: "time-guessed",
            message,
            hint: Some(hint.into()),
        });
    }

    fn add_time_sink(
        &mut self,
        name: String,
        unit: String,
        group: usize,
        reader: time_stamps::StampParser,
    ) -> ColumnRole {
        self.stamp_parsers.push(reader);
        let reader = self.stamp_parsers.len() - 1;
        self.sinks.push(ColumnSink {
            name,
            unit,
            group,
            reader: Some(reader),
        });
        ColumnRole::Time(self.sinks.len() - 1, reader)
    }

    fn add_sink(&mut self, name: String, unit: &str, group: usize) -> usize {
        self.sinks.push(ColumnSink {
            name,
            unit: unit.to_string(),
            group,
            reader: None,
        });
        self.sinks.len() - 1
    }

    fn skip_column(&mut self, name: String, why: &'static str) {
        self.left_out.push((name, why));
    }
}
