//! What each chart says: rows of values, and what its picture shows.

use super::columns::{Column, Files, Lever};
use super::grading::{Grader, Row, Side};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::gear::measurement::composite::Record;
use crate::gear::measurement::estimate::Estimate;
use crate::gear::measurement::pitch::{Found, Method, Pitches, usual_reach};
use crate::gear::measurement::quantity::Quantity;
use crate::gear::measurement::runout::{self, Runout};
use crate::gear::measurement::sizes::Way;
use crate::gear::measurement::trace::{self, Line};
use crate::scene::measured::{Chart, ChartKind, MeasuredGear, TraceChart, TraceFilter};

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

/// Samples recommended in a pitch for f_i′ to be told.
const DENSE: f64 = 10.0;

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

    fn pitch(&mut self, chart: &Chart, method: Method, k: Option<u32>) -> Result<(), Errors> {
        let teeth = self.gear.gear.teeth as usize;
        let lever = Lever {
            radius: Some(0.5 * self.gear.gear.diameter()),
        };
        let k = k.map_or(usual_reach(teeth), |k| k as usize);
        if k >= teeth {
            let message = format!("`k` is {k} on a gear of {teeth} teeth");
            return Err(Error::new(Code::OutOfRange, message)
                .at(&chart.place)
                .hint("F_pk is taken over z/8 pitches where `k` is left out")
                .into());
        }
        let mut sides = Vec::new();
        for side in Side::ALL {
            let Some(column) = self.one(chart, side, &lever)? else {
                continue;
            };
            let pitches = Pitches::new(&column.values, method, teeth, chart.std)
                .map_err(|e| e.at(&chart.place))?;
            let span = |found: &Found| match found.end - found.first {
                0 => "all alike".to_string(),
                1 => format!("pitch {}", found.first + 1),
                _ => format!(
                    "pitches {} to {}",
                    found.first + 1,
                    (found.end - 1) % teeth + 1
                ),
            };
            for (quantity, found) in [
                (Quantity::SinglePitch, pitches.single()),
                (Quantity::CumulativePitch, pitches.total()),
                (Quantity::OverPitches(k as u32), pitches.over(k)),
                (Quantity::AdjacentPitch, pitches.adjacent()),
            ] {
                self.add(quantity, side, span(&found), found.estimate);
            }
            if pitches.drift != 0.0 {
                let note = format!(
                    "{} the first flank had drifted by {:.2} µm when it was read again; taken off evenly",
                    side.word(),
                    1e6 * pitches.drift
                );
                self.out.notes.push(note.trim_start().to_string());
            }
            self.out.drawn.push(Drawn::Pitch {
                side,
                pitches: pitches.clone(),
            });
            sides.push((side, pitches));
        }
        let of = |wanted: Side| sides.iter().find(|(side, _)| *side == wanted).map(|s| &s.1);
        if let (Some(left), Some(right)) = (of(Side::Left), of(Side::Right)) {
            let angle = self.gear.gear.transverse_angle();
            let found = runout::from_pitches(left, right, angle).map_err(|e| e.at(&chart.place))?;
            self.run_out(found, "from both sides' pitch");
        }
        Ok(())
    }

    fn run_out(&mut self, runout: Runout, found: &'static str) {
        self.add(
            Quantity::Runout,
            Side::Both,
            found.to_string(),
            runout.range,
        );
        let place = runout.phase.to_degrees().rem_euclid(360.0);
        let found_at = format!("{found}, highest at {place:.1} deg");
        self.add(
            Quantity::Eccentricity,
            Side::Both,
            found_at,
            runout.eccentricity,
        );
        self.out.notes.push(format!(
            "run-out {found}: {:.2} µm are left without the eccentricity",
            1e6 * runout.remainder
        ));
        self.out.drawn.push(Drawn::Runout { found, runout });
    }

    fn runout(&mut self, chart: &Chart) -> Result<(), Errors> {
        let readings = self.only(chart, &Lever { radius: None })?;
        let found = runout::from_ball(&readings, self.gear.gear.teeth as usize, chart.std)
            .map_err(|e| e.at(&chart.place))?;
        self.run_out(found, "by ball");
        Ok(())
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

    fn traces(&mut self, chart: &Chart, how: &TraceChart) -> Result<(), Errors> {
        let lever = Lever {
            radius: how
                .is_profile
                .then_some(0.5 * self.gear.gear.base_diameter()),
        };
        let along = self
            .files
            .column(chart, &how.along, how.along_unit.as_deref(), &lever)?
            .values;
        for side in Side::ALL {
            let columns = self
                .files
                .side(chart, side as usize, &Lever { radius: None })?;
            if columns.is_empty() {
                continue;
            }
            let ends = match (along.first(), along.last()) {
                (Some(&first), Some(&last)) => [first, last],
                _ => [0.0, 0.0],
            };
            let [from, to] = how.evaluation.unwrap_or(ends);
            let reach = how.active.map_or(to - from, |[low, high]| high - low);
            let taken = |x: f64| how.design.iter().map(|d| d.at(x)).sum::<f64>();
            let design: Vec<f64> = along.iter().map(|&x| taken(x)).collect();
            let (mut traces, mut reliefs) = (Vec::new(), Vec::new());
            for column in columns {
                let plain: Vec<f64> = column
                    .values
                    .iter()
                    .zip(&design)
                    .map(|(y, d)| y - d)
                    .collect();
                let in_column = |e: Error| {
                    e.at(&chart.place)
                        .label(format!("column \"{}\"", column.name))
                };
                let plain = match cutoff(how.filter, (from, to)) {
                    Some(cutoff) => trace::filtered(&along, &plain, cutoff).map_err(in_column)?,
                    None => plain,
                };
                let mut line =
                    trace::line(&along, &plain, (from, to), reach, chart.std).map_err(in_column)?;
                let inward = how.is_profile && self.gear.gear.internal;
                if inward {
                    // The slope rises toward the tip, and that is where the roll is shortest.
                    line.slope = line.slope.times(-1.0);
                }
                if let Some(begins) = how.relief_from {
                    let straight = match inward {
                        false => (from.max(ends[0]), begins),
                        true => (begins, to.min(ends[1])),
                    };
                    let relief =
                        trace::tip_relief(&along, &column.values, straight, inward, chart.std)
                            .map_err(|e| e.at(&chart.place))?;
                    reliefs.push(relief);
                }
                traces.push((column.name, column.values, line));
            }
            if let Some(cutoff) = cutoff(how.filter, (from, to)) {
                self.out.notes.push(format!(
                    "{} {}: Gaussian filter, cut-off {:.4} mm",
                    if how.is_profile { "profile" } else { "helix" },
                    side.word(),
                    1e3 * cutoff
                ));
            }
            self.worst_lines(side, how.is_profile, &traces);
            self.tip_relief(side, &reliefs);
            self.out.drawn.push(Drawn::Traces {
                side,
                is_profile: how.is_profile,
                along: along.clone(),
                range: (from, to),
                active: how.active.map_or((ends[0], ends[1]), |[a, b]| (a, b)),
                design,
                traces,
            });
        }
        Ok(())
    }

    /// The worst of the traces of a side, and the mean slope, in which the mounting shows.
    fn worst_lines(&mut self, side: Side, is_profile: bool, traces: &[(String, Vec<f64>, Line)]) {
        use Quantity::*;
        type Reading = fn(&Line) -> Estimate;
        let [total, form, slope] = match is_profile {
            true => [ProfileTotal, ProfileForm, ProfileSlope],
            false => [HelixTotal, HelixForm, HelixSlope],
        };
        let of: [(Quantity, Reading); 3] = [
            (total, |line| line.total),
            (form, |line| line.form),
            (slope, |line| line.slope),
        ];
        for (quantity, value) in of {
            let size = |t: &&(String, Vec<f64>, Line)| value(&t.2).value.abs();
            let worst = traces.iter().max_by(|a, b| size(a).total_cmp(&size(b)));
            if let Some((name, _, line)) = worst {
                let found = match traces.len() {
                    1 => name.clone(),
                    n => format!("{name}, worst of {n}"),
                };
                self.add(quantity, side, found, value(line));
            }
        }
        if traces.len() > 1 {
            let mean = traces.iter().map(|t| t.2.slope.value).sum::<f64>() / traces.len() as f64;
            self.out.notes.push(format!(
                "{} {}: mean of {} is {:.2} µm",
                slope.symbol(),
                side.word(),
                traces.len(),
                1e6 * mean
            ));
        }
    }

    /// The mean of what the tips of a side lack.
    fn tip_relief(&mut self, side: Side, reliefs: &[Estimate]) {
        let n = reliefs.len() as f64;
        let values = || reliefs.iter().map(|r| 1e6 * r.value);
        let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
            (l.min(x), h.max(x))
        });
        if let Some(one) = reliefs.first() {
            let mean = Estimate {
                value: 1e-6 * values().sum::<f64>() / n,
                std: one.std.map(|u| u / n.sqrt()),
            };
            let found = format!("mean of {n}, {low:.2} to {high:.2}");
            self.add(Quantity::TipRelief, side, found, mean);
        }
    }

    fn base_pitch(&mut self, chart: &Chart) -> Result<(), Errors> {
        for side in Side::ALL {
            for column in self
                .files
                .side(chart, side as usize, &Lever { radius: None })?
            {
                finite(&column, chart)?;
                let size = |i: &usize| column.values[*i].abs();
                let worst = (0..column.values.len()).max_by(|a, b| size(a).total_cmp(&size(b)));
                if let Some(i) = worst {
                    let estimate = Estimate::new(column.values[i], 1.0, chart.std);
                    self.add(
                        Quantity::BasePitch,
                        side,
                        format!("reading {}", i + 1),
                        estimate,
                    );
                }
            }
        }
        Ok(())
    }

    fn tip(&self, chart: &Chart) -> Result<f64, Error> {
        self.gear.tip_diameter.ok_or_else(|| {
            Error::new(
                Code::MissingKey,
                "a chord is set from the tip, and [measured_gear] has no `tip_diameter`",
            )
            .at(&chart.place)
            .hint("write tip_diameter = \"78 mm\", as measured")
        })
    }

    fn thickness(&mut self, chart: &Chart, way: Way, what: &str) -> Result<(), Errors> {
        let column = self.column_of_both(chart, &Lever { radius: None })?;
        finite(&column, chart)?;
        let gear = &self.gear.gear;
        let nominal = way.nominal(gear).map_err(|e| e.at(&chart.place))?;
        let told: Vec<Estimate> = column
            .values
            .iter()
            .map(|&reading| way.thickness(gear, reading, chart.std))
            .collect::<Result<_, Error>>()
            .map_err(|e| e.at(&chart.place))?;
        let by = |a: &usize, b: &usize| told[*a].value.total_cmp(&told[*b].value);
        let (thin, thick) = ((0..told.len()).min_by(by), (0..told.len()).max_by(by));
        if let (Some(thin), Some(thick)) = (thin, thick) {
            for (word, i) in [("thinnest", thin), ("thickest", thick)] {
                let found = format!("{what}, {word}, reading {}", i + 1);
                self.add(Quantity::Thickness, Side::Both, found, told[i]);
            }
            if matches!(way, Way::Span(_)) {
                let range = column.values[thick] - column.values[thin];
                let estimate = Estimate::new(range, 2f64.sqrt(), chart.std);
                self.add(
                    Quantity::SpanVariation,
                    Side::Both,
                    what.to_string(),
                    estimate,
                );
            }
        }
        let height = nominal.height.map_or(String::new(), |height| {
            format!(", set {:.4} mm below the tip", 1e3 * height)
        });
        self.out.notes.push(format!(
            "{what}: {:.4} mm without backlash{height}",
            1e3 * nominal.size
        ));
        Ok(())
    }

    fn double_flank(&mut self, chart: &Chart) -> Result<(), Errors> {
        let values = self.only(chart, &Lever { radius: None })?;
        let teeth = self.gear.gear.teeth as usize;
        let record = Record::new(&values, 1, teeth, true).map_err(|e| e.at(&chart.place))?;
        let split = record.split_by_order();
        let add = |value| Estimate::new(value, 2f64.sqrt(), chart.std);
        let (total, tooth) = (record.total(), record.by_pitch());
        self.add(
            Quantity::DoubleFlankTotal,
            Side::Both,
            "over a turn".into(),
            add(total),
        );
        self.add(
            Quantity::DoubleFlankTooth,
            Side::Both,
            "window slid".into(),
            add(tooth.sliding),
        );
        self.out.notes.push(format!(
            "double-flank: run-out (orders below z/2) {:.2} µm; in windows fixed to teeth f_i″ {:.2} µm",
            1e6 * split.long_range,
            1e6 * tooth.fixed
        ));
        self.sparse(&values, teeth);
        self.out.drawn.push(Drawn::Record {
            side: Side::Both,
            is_double: true,
            predicted: false,
            turns: 1,
            long: split.long,
            values,
        });
        Ok(())
    }

    fn sparse(&mut self, values: &[f64], pitches: usize) {
        let per_pitch = values.len() as f64 / pitches as f64;
        if per_pitch < DENSE {
            self.out.notes.push(format!(
                "{per_pitch:.1} samples a pitch: the values inside a pitch may be too small; {DENSE} or more tell them"
            ));
        }
    }

    fn single_flank(
        &mut self,
        chart: &Chart,
        turns: usize,
        along_action: Option<bool>,
    ) -> Result<(), Errors> {
        let gear = &self.gear.gear;
        let lever = Lever {
            radius: Some(0.5 * gear.diameter()),
        };
        let (teeth, cosine) = (gear.teeth as usize, gear.transverse_angle().cos());
        for side in Side::ALL {
            let Some(mut column) = self.one(chart, side, &lever)? else {
                continue;
            };
            let scale = match (column.is_angle, along_action) {
                (true, _) | (false, Some(false)) => 1.0,
                (false, Some(true)) => 1.0 / cosine,
                (false, None) => {
                    let message = "it is not said along what this record's lengths lie";
                    return Err(Error::new(Code::MissingKey, message)
                        .at(&chart.place)
                        .hint("write on = \"line_of_action\" or on = \"reference_circle\"")
                        .into());
                }
            };
            column.values.iter_mut().for_each(|x| *x *= scale);
            self.single(
                side,
                column.values,
                turns,
                teeth,
                chart.std.map(|u| u * scale),
            )
            .map_err(|e| e.at(&chart.place))?;
        }
        Ok(())
    }

    fn single(
        &mut self,
        side: Side,
        values: Vec<f64>,
        turns: usize,
        teeth: usize,
        std: Option<f64>,
    ) -> Result<(), Error> {
        let record = Record::new(&values, turns, teeth, turns == 1)?;
        let (by_turn, tooth) = (record.by_turn(), record.by_pitch());
        let (split, averaged) = (record.split_by_order(), record.split_by_pitch_average());
        let add = |value| Estimate::new(value, 2f64.sqrt(), std);
        let over = match turns {
            1 => "over the turn".to_string(),
            n => format!("over a turn, worst of {n}"),
        };
        self.add(Quantity::SingleFlankTotal, side, over, add(by_turn.sliding));
        self.add(
            Quantity::SingleFlankTooth,
            side,
            "raw, window slid".into(),
            add(tooth.sliding),
        );
        let short = add(split.short_ranges.sliding);
        self.add(
            Quantity::SingleFlankShort,
            side,
            "orders from z/2, window slid".into(),
            short,
        );
        self.out.notes.push(
            format!(
                "single-flank {}: f_i′ {:.2} µm in windows fixed to teeth; long wave f_l′ {:.2} µm; by the mean over a pitch f_l′ {:.2} µm, f_k′ {:.2} µm",
                side.word(),
                1e6 * tooth.fixed,
                1e6 * split.long_range,
                1e6 * averaged.long_range,
                1e6 * averaged.short_ranges.sliding
            )
            .replace(" :", ":"),
        );
        self.sparse(&values, turns * teeth);
        self.out.drawn.push(Drawn::Record {
            side,
            is_double: false,
            predicted: false,
            turns,
            long: split.long,
            values,
        });
        Ok(())
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

/// The cut-off of a trace's filter, m: by ISO 1328-1:2013 a thirtieth of the evaluation range, 25 µm at least.
fn cutoff(filter: Option<TraceFilter>, (from, to): (f64, f64)) -> Option<f64> {
    const LEAST: f64 = 25e-6;
    filter.map(|filter| match filter {
        TraceFilter::Cutoff(cutoff) => cutoff,
        TraceFilter::OfRange => ((to - from) / 30.0).max(LEAST),
    })
}
