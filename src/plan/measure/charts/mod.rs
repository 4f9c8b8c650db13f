//! What each chart says: rows of values, and what its picture shows.

use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::gear::measurement::estimate::Estimate;
use crate::gear::measurement::pitch::Pitches;
use crate::gear::measurement::quantity::Quantity;
use crate::gear::measurement::runout::Runout;
use crate::gear::measurement::sizes::Way;
use crate::gear::measurement::trace::Line;
use crate::plan::measure::columns::{Column, Files, Lever};
use crate::plan::measure::grading::{Grader, Row, Side};
use crate::scene::measured::{Chart, ChartKind, MeasuredGear};

/// Readings in the order of their teeth.
mod teeth;

/// Pitch, run-out, base pitch.
mod pitch;

/// Profiles and helices.
mod traces;

/// Tooth thickness.
mod thickness;

/// Composite records.
mod composite;

/// What a picture of a chart shows. Lengths in m.
#[derive(Debug, Clone)]
pub enum Drawn {
    /// Pitches of one side.
    Pitch {
        /// Which.
        side: Side,
        /// Them.
        pitches: Pitches,
    },
    /// Profiles or helices of one side.
    Traces {
        /// Which.
        side: Side,
        /// Profiles, else helices.
        is_profile: bool,
        /// Places, one list for all.
        along: Vec<f64>,
        /// Evaluation range.
        range: (f64, f64),
        /// The range that rolls with a mate; all where it is not stated.
        active: (f64, f64),
        /// What the design takes off, at the places.
        design: Vec<f64>,
        /// Each trace, with its column's name and its mean line about the design.
        traces: Vec<(String, Vec<f64>, Line)>,
    },
    /// Run-out.
    Runout {
        /// How it was found.
        found: &'static str,
        /// It.
        runout: Runout,
    },
    /// A composite record.
    Record {
        /// Which flanks.
        side: Side,
        /// Double-flank, else single-flank.
        is_double: bool,
        /// Computed from pitch and profile, not measured.
        predicted: bool,
        /// Turns.
        turns: usize,
        /// The record.
        values: Vec<f64>,
        /// Its long wave.
        long: Vec<f64>,
    },
}

/// What is gathered from all charts.
#[derive(Default)]
pub struct Gathered {
    /// Values.
    pub rows: Vec<Row>,
    /// What the tables have no row for.
    pub notes: Vec<String>,
    /// Pictures.
    pub drawn: Vec<Drawn>,
}

/// The evaluation of all charts of a gear.
pub struct Evaluation<'g> {
    /// The gear.
    pub gear: &'g MeasuredGear,
    /// What rows are held against.
    pub grader: &'g Grader,
    /// Files read.
    pub files: Files,
    /// What came out.
    pub out: Gathered,
}

impl Evaluation<'_> {
    /// Evaluates one chart.
    ///
    /// # Errors
    /// Whatever is wrong with its file, its columns or its readings.
    pub fn chart(&mut self, chart: &Chart) -> Result<(), Errors> {
        match &chart.kind {
            ChartKind::Pitch { method, k } => self.pitch(chart, *method, *k),
            ChartKind::Trace(how) => self.traces(chart, how),
            ChartKind::Runout => self.runout(chart),
            ChartKind::BasePitch => self.base_pitch(chart),
            ChartKind::Span { k } => {
                let k = k.unwrap_or_else(|| self.gear.gear.teeth_to_span());
                let over = if self.gear.gear.internal {
                    "spaces"
                } else {
                    "teeth"
                };
                self.thickness(chart, Way::Span(k), &format!("span over {k} {over}"))
            }
            ChartKind::Balls { diameter } => {
                let where_ = if self.gear.gear.internal {
                    "between"
                } else {
                    "over"
                };
                let what = format!("{where_} balls of {:.3} mm", 1e3 * diameter);
                self.thickness(chart, Way::Balls(*diameter), &what)
            }
            ChartKind::Chord => {
                let tip = self.tip(chart)?;
                self.thickness(chart, Way::Chord(tip), "chord")
            }
            ChartKind::ConstantChord => {
                let tip = self.tip(chart)?;
                self.thickness(chart, Way::ConstantChord(tip), "constant chord")
            }
            ChartKind::DoubleFlank => self.double_flank(chart),
            ChartKind::SingleFlank {
                turns,
                along_action,
                ..
            } => self.single_flank(chart, *turns as usize, *along_action),
        }
    }

    fn add(&mut self, quantity: Quantity, side: Side, found: String, estimate: Estimate) {
        let row = self.grader.row(quantity, side, found, estimate);
        self.out.rows.push(row);
    }

    /// The one column a side has, where it has any.
    fn one(&mut self, chart: &Chart, side: Side, lever: &Lever) -> Result<Option<Column>, Errors> {
        let mut columns = self.files.side(chart, side as usize, lever)?;
        if columns.len() > 1 {
            let message = format!("{} columns where one is meant", columns.len());
            return Err(Error::new(Code::Conflict, message)
                .at(&chart.place)
                .hint("write a [[chart]] for each")
                .into());
        }
        Ok(columns.pop())
    }

    /// The column of a chart that belongs to no side.
    fn only(&mut self, chart: &Chart, lever: &Lever) -> Result<Vec<f64>, Errors> {
        Ok(self.column_of_both(chart, lever)?.values)
    }

    fn column_of_both(&mut self, chart: &Chart, lever: &Lever) -> Result<Column, Errors> {
        let found = self.one(chart, Side::Both, lever)?;
        let found = found.filter(|column| !column.values.is_empty());
        let of_sides = chart.columns[1..].iter().any(|names| !names.is_empty());
        let message = match of_sides {
            true => "this chart belongs to neither side of the teeth, and names `left` or `right`",
            false => "the `column` of this chart holds no reading",
        };
        found.filter(|_| !of_sides).ok_or_else(|| {
            Error::new(Code::Conflict, message)
                .at(&chart.place)
                .hint("name the column of its readings in `column`")
                .into()
        })
    }
}

/// Refuses a column with a reading that is missing.
fn finite(column: &Column, chart: &Chart) -> Result<(), Error> {
    match column.values.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(i) => Err(Error::new(
            Code::NotANumber,
            format!("reading {} of column \"{}\" is missing", i + 1, column.name),
        )
        .at(&chart.place)
        .hint("measure it again, or take its row out of the file")),
    }
}
