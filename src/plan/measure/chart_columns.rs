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

/// Largest plausible reading, m.
const MAX_READING_M: f64 = 1000.0;

/// Names of a column of tooth numbers.
const TOOTH_NUMBER_NAMES: &[&str] = &[
    "tooth",
    "tooth no",
    "tooth nr",
    "tooth number",
    "zahn",
    "齿号",
];

/// Cache of the chart files read, by path.
#[derive(Default)]
pub struct ChartFiles(Vec<(std::path::PathBuf, RawLog)>);

/// Conversion of columns of angles to lengths.
pub struct AngleScale {
    /// Radius, m, that multiplies an angle in rad; `None` if angles are not accepted.
    pub radius: Option<f64>,
}

/// Column of a chart file, converted to lengths.
pub struct ChartColumn {
    /// Name in the file.
    pub name: String,
    /// Lengths, m, or angles times the radius, m.
    pub values: Vec<f64>,
    /// True if the file states angles.
    pub is_angle: bool,
}

impl ChartFiles {
    /// Columns of a chart for one side (0 both, 1 left, 2 right).
    ///
    /// # Errors
    /// The file cannot be read; a column or its unit is missing; a unit has another dimension.
    pub fn columns_of_side(
        &mut self,
        chart: &MeasuredChart,
        side: usize,
        scale: &AngleScale,
    ) -> Result<Vec<ChartColumn>, Errors> {
        let names = &chart.columns[side];
        names
            .iter()
            .map(|name| self.column(chart, name, chart.unit.as_deref(), scale))
            .collect()
    }

    /// One column of the file of a chart; `unit` is its default unit.
    ///
    /// # Errors
    /// As for [`ChartFiles::columns_of_side`].
    pub fn column(
        &mut self,
        chart: &MeasuredChart,
        name: &str,
        unit: Option<&str>,
        scale: &AngleScale,
    ) -> Result<ChartColumn, Errors> {
        let log = self
            .open(&chart.file)
            .map_err(|e| relocate_errors(e, chart))?;
        let channels: Vec<&RawChannel> = log.groups.iter().flat_map(|g| &g.channels).collect();
        let known: Vec<String> = channels.iter().map(|c| c.name.clone()).collect();
        let file = chart.file.display();
        let Some(index) = crate::recording::channel_names::find_channel(name, &known) else {
            let error = unknown_channel(name, &known);
            let message = format!("{file} has no column \"{}\"", quantity::truncate(name));
            return Err(Error { message, ..error }.with_span(&chart.span).into());
        };
        let channel = channels[index];
        let mut values = vec![0.0; channel.samples.len()];
        channel.samples.read(0, &mut values)?;
        // A column shorter than the others ends in blank cells.
        let end = values
            .iter()
            .rposition(|x| !x.is_nan())
            .map_or(0, |i| i + 1);
        values.truncate(end);
        let unit_text = match channel.unit.as_str() {
            "" => unit.unwrap_or(""),
            unit_text => unit_text,
        };
        let (factor, is_angle) = unit_factor(unit_text, scale).map_err(|e| {
            e.with_span(&chart.span)
                .with_label(format!("column \"{}\" of {file}", channel.name))
        })?;
        values.iter_mut().for_each(|x| *x *= factor);
        if let Some(index) = values
            .iter()
            .position(|x| x.is_finite() && x.abs() > MAX_READING_M)
        {
            let message = format!(
                "reading {} of column \"{}\" is {:.1e} m",
                index + 1,
                channel.name,
                values[index]
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

    /// Tooth numbers of the rows of a chart; `None` if its file has no column of them.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn tooth_numbers(&mut self, chart: &MeasuredChart) -> Result<Option<Vec<f64>>, Errors> {
        let log = self
            .open(&chart.file)
            .map_err(|e| relocate_errors(e, chart))?;
        let is_named = |c: &&RawChannel| {
            let non_word = |c: char| !c.is_alphanumeric();
            let words: Vec<&str> = c.name.split(non_word).filter(|w| !w.is_empty()).collect();
            TOOTH_NUMBER_NAMES.contains(&words.join(" ").to_lowercase().as_str())
        };
        let Some(channel) = log.groups.iter().flat_map(|g| &g.channels).find(is_named) else {
            return Ok(None);
        };
        let mut numbers = vec![0.0; channel.samples.len()];
        channel.samples.read(0, &mut numbers)?;
        Ok(Some(numbers))
    }

    fn open(&mut self, path: &Path) -> Result<&RawLog, Errors> {
        let index = match self.0.iter().position(|(known, _)| known == path) {
            Some(index) => index,
            None => {
                // A column of tooth numbers or positions rises uniformly but is not a time column.
                let options = ReadOptions {
                    time_column: Some("none".to_string()),
                    ..ReadOptions::default()
                };
                let log = open::open(&path.display().to_string(), &options)?;
                self.0.push((path.to_path_buf(), log));
                self.0.len() - 1
            }
        };
        Ok(&self.0[index].1)
    }
}

/// Errors of a file without a line, relocated to the chart that names the file.
fn relocate_errors(errors: Errors, chart: &MeasuredChart) -> Errors {
    let relocated = errors.as_slice().iter().map(|error| match error.span {
        Some(ref span) if !span.is_whole_file() => error.clone(),
        _ => error.clone().with_span(&chart.span),
    });
    Errors::into_result(relocated.collect(), || ())
        .err()
        .unwrap_or(errors)
}

fn unit_factor(unit: &str, scale: &AngleScale) -> Result<(f64, bool), Error> {
    const HINT: &str =
        "write it after the column's name, such as left [µm], or in the chart: unit = \"µm\"";
    if unit.is_empty() {
        return Err(Error::new(Code::MissingUnit, "a column has no unit").with_hint(HINT));
    }
    let wrong_unit = |why: &str| {
        Error::new(
            Code::WrongUnit,
            format!("\"{}\" {why}", quantity::truncate(unit)),
        )
    };
    let (factor, dimension) = quantity::parse_unit(unit)
        .ok_or_else(|| wrong_unit("is not a known unit").with_hint(HINT))?;
    match scale.radius {
        _ if dimension == QuantityKind::Length.dimension() => Ok((factor, false)),
        Some(radius) if dimension == QuantityKind::Angle.dimension() => Ok((factor * radius, true)),
        Some(_) => Err(wrong_unit("measures neither a length nor an angle")),
        None => Err(wrong_unit("does not measure a length")
            .with_hint("readings of this kind are lengths, such as in µm or mm")),
    }
}
