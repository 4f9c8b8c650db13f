//! Evaluation of gear inspection charts: graded values and the data of their plots.

use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::gear::measurement::deviation::GearDeviation;
use crate::gear::measurement::estimate::Estimate;
use crate::gear::measurement::pitch::PitchDeviations;
use crate::gear::measurement::runout::Runout;
use crate::gear::measurement::tooth_thickness::ThicknessMethod;
use crate::gear::measurement::trace::MeanLine;
use crate::plan::measure::chart_columns::{AngleScale, ChartColumn, ChartFiles};
use crate::plan::measure::grading::{GradedFlanks, GradedValue, Grader};
use crate::scene::measured_gear::{ChartKind, MeasuredChart, MeasuredGear};

mod teeth;

mod pitch;

mod traces;

mod thickness;

mod composite;

/// Plot of a chart. Lengths in m.
#[derive(Debug, Clone)]
pub enum ChartPlot {
    /// Pitches of one side.
    Pitch {
        /// Which.
        side: GradedFlanks,
        /// Them.
        pitches: PitchDeviations,
    },
    /// Profiles or helices of one side.
    Traces {
        /// Which.
        side: GradedFlanks,
        /// Profiles, else helices.
        is_profile: bool,
        /// Places, one list for all.
        along: Vec<f64>,
        /// Evaluation range.
        range: (f64, f64),
        /// The range that rolls with a mate; all where it is not stated.
        active: (f64, f64),
        /// Design modification, at the places.
        design: Vec<f64>,
        /// Each trace, with its column's name and its mean line about the design.
        traces: Vec<(String, Vec<f64>, MeanLine)>,
    },
    /// Run-out.
    Runout {
        /// Method of the evaluation.
        method_text: &'static str,
        /// It.
        runout: Runout,
    },
    /// A composite record.
    Record {
        /// Which flanks.
        side: GradedFlanks,
        /// Double-flank, else single-flank.
        is_double: bool,
        /// Computed from pitch and profile, not measured.
        predicted: bool,
        /// Turns.
        turns: usize,
        /// The record.
        values: Vec<f64>,
        /// Long-wave component.
        long: Vec<f64>,
    },
}

/// Results gathered from all charts.
#[derive(Default)]
pub struct ChartResults {
    /// Values.
    pub rows: Vec<GradedValue>,
    /// Notes for results without a row in the tables.
    pub notes: Vec<String>,
    /// Plots.
    pub plots: Vec<ChartPlot>,
}

/// The evaluation of all charts of a gear.
pub struct ChartEvaluation<'g> {
    /// The gear.
    pub gear: &'g MeasuredGear,
    /// Grader of the rows.
    pub grader: &'g Grader,
    /// Files read.
    pub chart_files: ChartFiles,
    /// Collected results.
    pub results: ChartResults,
}

impl ChartEvaluation<'_> {
    /// Evaluates one chart.
    ///
    /// # Errors
    /// Whatever is wrong with its file, its columns or its readings.
    pub fn chart(&mut self, chart: &MeasuredChart) -> Result<(), Errors> {
        match &chart.kind {
            ChartKind::Pitch { method, k } => self.pitch(chart, *method, *k),
            ChartKind::Trace(how) => self.traces(chart, how),
            ChartKind::Runout => self.runout(chart),
            ChartKind::BasePitch => self.base_pitch(chart),
            ChartKind::Span { k } => {
                let k = k.unwrap_or_else(|| self.gear.gear.default_span_teeth());
                let over = if self.gear.gear.internal {
                    "spaces"
                } else {
                    "teeth"
                };
                self.thickness(
                    chart,
                    ThicknessMethod::Span(k),
                    &format!("span over {k} {over}"),
                )
            }
            ChartKind::Balls { diameter } => {
                let where_ = if self.gear.gear.internal {
                    "between"
                } else {
                    "over"
                };
                let what = format!("{where_} balls of {:.3} mm", 1e3 * diameter);
                self.thickness(chart, ThicknessMethod::Balls(*diameter), &what)
            }
            ChartKind::Chord => {
                let tip = self.tip_radius(chart)?;
                self.thickness(chart, ThicknessMethod::Chord(tip), "chord")
            }
            ChartKind::ConstantChord => {
                let tip = self.tip_radius(chart)?;
                self.thickness(chart, ThicknessMethod::ConstantChord(tip), "constant chord")
            }
            ChartKind::DoubleFlank => self.double_flank(chart),
            ChartKind::SingleFlank {
                turns,
                along_action,
                ..
            } => self.single_flank(chart, *turns as usize, *along_action),
        }
    }

    fn add(
        &mut self,
        quantity: GearDeviation,
        side: GradedFlanks,
        found: String,
        estimate: Estimate,
    ) {
        let row = self.grader.grade(quantity, side, found, estimate);
        self.results.rows.push(row);
    }

    /// The one column a side has, where it has any.
    fn optional_column(
        &mut self,
        chart: &MeasuredChart,
        side: GradedFlanks,
        lever: &AngleScale,
    ) -> Result<Option<ChartColumn>, Errors> {
        let mut columns = self
            .chart_files
            .columns_of_side(chart, side as usize, lever)?;
        if columns.len() > 1 {
            let message = format!("{} columns instead of one", columns.len());
            return Err(Error::new(Code::Conflict, message)
                .with_span(&chart.span)
                .with_hint("write a [[chart]] for each")
                .into());
        }
        Ok(columns.pop())
    }

    /// The column of a chart that belongs to no side.
    fn single_column(
        &mut self,
        chart: &MeasuredChart,
        lever: &AngleScale,
    ) -> Result<Vec<f64>, Errors> {
        Ok(self.column_without_side(chart, lever)?.values)
    }

    fn column_without_side(
        &mut self,
        chart: &MeasuredChart,
        lever: &AngleScale,
    ) -> Result<ChartColumn, Errors> {
        let found = self.optional_column(chart, GradedFlanks::Both, lever)?;
        let found = found.filter(|column| !column.values.is_empty());
        let of_sides = chart.columns[1..].iter().any(|names| !names.is_empty());
        let message = match of_sides {
            true => "this chart applies to neither side of the teeth, but names `left` or `right`",
            false => "the `column` of this chart contains no readings",
        };
        found.filter(|_| !of_sides).ok_or_else(|| {
            Error::new(Code::Conflict, message)
                .with_span(&chart.span)
                .with_hint("name the column of its readings in `column`")
                .into()
        })
    }
}

/// Refuses a column with a reading that is missing.
fn check_finite(column: &ChartColumn, chart: &MeasuredChart) -> Result<(), Error> {
    match column.values.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(i) => Err(Error::new(
            Code::NotANumber,
            format!("reading {} of column \"{}\" is missing", i + 1, column.name),
        )
        .with_span(&chart.span)
        .with_hint("measure it again, or remove its row from the file")),
    }
}
