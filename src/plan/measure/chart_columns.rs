//! Columns of inspection chart files, converted to lengths in m.

use std::path::Path;

use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::quantity;
use crate::base::quantity_kind::QuantityKind;
use crate::recording::open;
use crate::recording::preprocess::unknown_channel;
use crate::recording::raw::{RawChannel, RawLog};
use crate::recording::read_options::ReadOptions;
use crate::scene::measured_gear::MeasuredChart;

/// No reading of a gear is longer, m.
const MAX_READING_M: f64 = 1000.0;

/// Names of a column that numbers the teeth.
const TOOTH_NUMBERS: &[&str] = &[
    "tooth",
    "tooth no",
    "tooth nr",
    "tooth number",
    "zahn",
    "齿号",
];

/// Files already read, by path.
#[derive(Default)]
pub struct ChartFiles(Vec<(std::path::PathBuf, RawLog)>);

/// Scale from columns of angles to lengths.
pub struct AngleScale {
    /// Metres a radian; `None` where angles have no place.
    pub radius: Option<f64>,
}

/// A column: its name, its values in m, and whether they were angles.
pub struct ChartColumn {
    /// As the file has it.
    pub name: String,
    /// Lengths, or angles times the lever.
    pub values: Vec<f64>,
    /// The file states angles.
    pub is_angle: bool,
}

impl ChartFiles {
    /// The columns of a chart named for one side (0 neither, 1 left, 2 right).
    ///
    /// # Errors
    /// The file cannot be read; a column is not there; a unit is missing or measures something else.
    pub fn columns_of_side(
        &mut self,
        chart: &MeasuredChart,
        side: usize,
        lever: &AngleScale,
    ) -> Result<Vec<ChartColumn>, Errors> {
        let names = &chart.columns[side];
        names
            .iter()
            .map(|name| self.column(chart, name, chart.unit.as_deref(), lever))
            .collect()
    }

    /// One column of the file of a chart; `unit` where its name does not say it.
    ///
    /// # Errors
    /// As for [`ChartFiles::columns_of_side`].
    pub fn column(
        &mut self,
        chart: &MeasuredChart,
        name: &str,
        unit: Option<&str>,
        lever: &AngleScale,
    ) -> Result<ChartColumn, Errors> {
        let log = self
            .open(&chart.file)
            .map_err(|e| relocate_errors(e, chart))?;
        let channels: Vec<&RawChannel> = log.groups.iter().flat_map(|g| &g.channels).collect();
        let known: Vec<String> = channels.iter().map(|c| c.name.clone()).collect();
        let file = chart.file.display();
        let Some(at) = crate::recording::channel_names::find_channel(name, &known) else {
            let error = unknown_channel(name, &known);
            let message = format!("{file} has no column \"{}\"", quantity::truncate(name));
            return Err(Error { message, ..error }.with_span(&chart.span).into());
        };
        let channel = channels[at];
        let mut values = vec![0.0; channel.samples.len()];
        channel.samples.read(0, &mut values)?;
        // A column shorter than its neighbours ends in blanks.
        let end = values
            .iter()
            .rposition(|x| !x.is_nan())
            .map_or(0, |i| i + 1);
        values.truncate(end);
        let written = match channel.unit.as_str() {
            "" => unit.unwrap_or(""),
            written => written,
        };
        let (factor, is_angle) = factor(written, lever).map_err(|why| {
            why.with_span(&chart.span)
                .with_label(format!("column \"{}\" of {file}", channel.name))
        })?;
        values.iter_mut().for_each(|x| *x *= factor);
        if let Some(at) = values
            .iter()
            .position(|x| x.is_finite() && x.abs() > MAX_READING_M)
        {
            let message = format!(
                "reading {} of column \"{}\" is {:.1e} m",
                at + 1,
                channel.name,
                values[at]
            );
            return Err(Error::new(Code::OutOfRange, message)
                .with_span(&chart.span)
                .with_hint("no gear is that large: check the column and its unit")
                .into());
        }
        Ok(ChartColumn {
            name: channel.name.clone(),
            values,
            is_angle,
        })
    }

    /// The column that numbers the teeth of a chart's rows, where its file has one.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn tooth_numbers(&mut self, chart: &MeasuredChart) -> Result<Option<Vec<f64>>, Errors> {
        let log = self
            .open(&chart.file)
            .map_err(|e| relocate_errors(e, chart))?;
        let is_number = |c: &&RawChannel| {
            let signs = |c: char| !c.is_alphanumeric();
            let words: Vec<&str> = c.name.split(signs).filter(|w| !w.is_empty()).collect();
            TOOTH_NUMBERS.contains(&words.join(" ").to_lowercase().as_str())
        };
        let Some(channel) = log.groups.iter().flat_map(|g| &g.channels).find(is_number) else {
            return Ok(None);
        };
        let mut numbers = vec![0.0; channel.samples.len()];
        channel.samples.read(0, &mut numbers)?;
        Ok(Some(numbers))
    }

    fn open(&mut self, path: &Path) -> Result<&RawLog, Errors> {
        let at = match self.0.iter().position(|(known, _)| known == path) {
            Some(at) => at,
            None => {
                // A column of tooth numbers or places rises evenly as a clock does, and is none.
                let options = ReadOptions {
                    time_column: Some("none".to_string()),
                    ..ReadOptions::default()
                };
                let log = open::open(&path.display().to_string(), &options)?;
                self.0.push((path.to_path_buf(), log));
                self.0.len() - 1
            }
        };
        Ok(&self.0[at].1)
    }
}

/// Errors of a file, which have no place there, pointing at the chart that names it.
fn relocate_errors(errors: Errors, chart: &MeasuredChart) -> Errors {
    let placed = errors.as_slice().iter().map(|error| match error.span {
        Some(ref place) if !place.is_whole_file() => error.clone(),
        _ => error.clone().with_span(&chart.span),
    });
    Errors::into_result(placed.collect(), || ())
        .err()
        .unwrap_or(errors)
}

fn factor(unit: &str, lever: &AngleScale) -> Result<(f64, bool), Error> {
    const HINT: &str =
        "write it behind the column's name, such as left [µm], or in the chart: unit = \"µm\"";
    if unit.is_empty() {
        return Err(Error::new(Code::MissingUnit, "a column has no unit").with_hint(HINT));
    }
    let wrong = |why: &str| {
        Error::new(
            Code::WrongUnit,
            format!("\"{}\" {why}", quantity::truncate(unit)),
        )
    };
    let (factor, dimension) = quantity::parse_unit(unit)
        .ok_or_else(|| wrong("is not a unit known here").with_hint(HINT))?;
    match lever.radius {
        _ if dimension == QuantityKind::Length.dimension() => Ok((factor, false)),
        Some(radius) if dimension == QuantityKind::Angle.dimension() => Ok((factor * radius, true)),
        Some(_) => Err(wrong("measures neither a length nor an angle")),
        None => Err(wrong("does not measure a length")
            .with_hint("readings of this kind are lengths, such as in µm or mm")),
    }
}
