//! Columns of the files charts stand in, as lengths in m.

use std::path::Path;

use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::kind::Kind;
use crate::base::units;
use crate::recording::open;
use crate::recording::raw::{Raw, RawChannel};
use crate::recording::settings::Settings;
use crate::recording::settle::no_channel;
use crate::scene::measured::Chart;

/// No reading of a gear is longer, m.
const LONGEST: f64 = 1000.0;

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
pub struct Files(Vec<(std::path::PathBuf, Raw)>);

/// How columns of angles become lengths.
pub struct Lever {
    /// Metres a radian; `None` where angles have no place.
    pub radius: Option<f64>,
}

/// A column: its name, its values in m, and whether they were angles.
pub struct Column {
    /// As the file has it.
    pub name: String,
    /// Lengths, or angles times the lever.
    pub values: Vec<f64>,
    /// The file states angles.
    pub is_angle: bool,
}

impl Files {
    /// The columns of a chart named for one side (0 neither, 1 left, 2 right).
    ///
    /// # Errors
    /// The file cannot be read; a column is not there; a unit is missing or measures something else.
    pub fn side(
        &mut self,
        chart: &Chart,
        side: usize,
        lever: &Lever,
    ) -> Result<Vec<Column>, Errors> {
        let names = &chart.columns[side];
        names
            .iter()
            .map(|name| self.column(chart, name, chart.unit.as_deref(), lever))
            .collect()
    }

    /// One column of the file of a chart; `unit` where its name does not say it.
    ///
    /// # Errors
    /// As for [`Files::side`].
    pub fn column(
        &mut self,
        chart: &Chart,
        name: &str,
        unit: Option<&str>,
        lever: &Lever,
    ) -> Result<Column, Errors> {
        let raw = self.open(&chart.file).map_err(|e| said_in(e, chart))?;
        let channels: Vec<&RawChannel> = raw.groups.iter().flat_map(|g| &g.channels).collect();
        let known: Vec<String> = channels.iter().map(|c| c.name.clone()).collect();
        let file = chart.file.display();
        let Some(at) = crate::recording::names::find(name, &known) else {
            let error = no_channel(name, &known);
            let message = format!("{file} has no column \"{}\"", units::shortened(name));
            return Err(Error { message, ..error }.at(&chart.place).into());
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
            why.at(&chart.place)
                .label(format!("column \"{}\" of {file}", channel.name))
        })?;
        values.iter_mut().for_each(|x| *x *= factor);
        if let Some(at) = values
            .iter()
            .position(|x| x.is_finite() && x.abs() > LONGEST)
        {
            let message = format!(
                "reading {} of column \"{}\" is {:.1e} m",
                at + 1,
                channel.name,
                values[at]
            );
            return Err(Error::new(Code::OutOfRange, message)
                .at(&chart.place)
                .hint("no gear is that large: look at the column's unit, and whether it is the right one")
                .into());
        }
        Ok(Column {
            name: channel.name.clone(),
            values,
            is_angle,
        })
    }

    /// The column that numbers the teeth of a chart's rows, where its file has one.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn tooth_numbers(&mut self, chart: &Chart) -> Result<Option<Vec<f64>>, Errors> {
        let raw = self.open(&chart.file).map_err(|e| said_in(e, chart))?;
        let is_number = |c: &&RawChannel| {
            let signs = |c: char| !c.is_alphanumeric();
            let words: Vec<&str> = c.name.split(signs).filter(|w| !w.is_empty()).collect();
            TOOTH_NUMBERS.contains(&words.join(" ").to_lowercase().as_str())
        };
        let Some(channel) = raw.groups.iter().flat_map(|g| &g.channels).find(is_number) else {
            return Ok(None);
        };
        let mut numbers = vec![0.0; channel.samples.len()];
        channel.samples.read(0, &mut numbers)?;
        Ok(Some(numbers))
    }

    fn open(&mut self, path: &Path) -> Result<&Raw, Errors> {
        let at = match self.0.iter().position(|(known, _)| known == path) {
            Some(at) => at,
            None => {
                // A column of tooth numbers or places rises evenly as a clock does, and is none.
                let settings = Settings {
                    time_column: Some("none".to_string()),
                    ..Settings::default()
                };
                let raw = open::open(&path.display().to_string(), &settings)?;
                self.0.push((path.to_path_buf(), raw));
                self.0.len() - 1
            }
        };
        Ok(&self.0[at].1)
    }
}

/// Errors of a file, which have no place there, pointing at the chart that names it.
fn said_in(errors: Errors, chart: &Chart) -> Errors {
    let placed = errors.list().iter().map(|error| match error.place {
        Some(ref place) if !place.is_whole_file() => error.clone(),
        _ => error.clone().at(&chart.place),
    });
    Errors::or(placed.collect(), || ()).err().unwrap_or(errors)
}

fn factor(unit: &str, lever: &Lever) -> Result<(f64, bool), Error> {
    const HINT: &str =
        "write it behind the column's name, such as left [µm], or in the chart: unit = \"µm\"";
    if unit.is_empty() {
        return Err(Error::new(Code::MissingUnit, "a column has no unit").hint(HINT));
    }
    let wrong = |why: &str| {
        Error::new(
            Code::WrongUnit,
            format!("\"{}\" {why}", units::shortened(unit)),
        )
    };
    let (factor, dimension) =
        units::of_unit(unit).ok_or_else(|| wrong("is not a unit known here").hint(HINT))?;
    match lever.radius {
        _ if dimension == Kind::Length.dimension() => Ok((factor, false)),
        Some(radius) if dimension == Kind::Angle.dimension() => Ok((factor * radius, true)),
        Some(_) => Err(wrong("measures neither a length nor an angle")),
        None => Err(wrong("does not measure a length")
            .hint("readings of this kind are lengths, such as in µm or mm")),
    }
}
