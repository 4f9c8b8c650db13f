//! Profile and helix traces: mean line, slope and form deviations.

use super::{ChartEvaluation, ChartPlot};
use crate::base::error::{Error, Errors};
use crate::gear::measurement::deviation::GearDeviation;
use crate::gear::measurement::estimate::Estimate;
use crate::gear::measurement::trace::{self, MeanLine};
use crate::numeric::statistics::extremes;
use crate::plan::measure::chart_columns::AngleScale;
use crate::plan::measure::grading::GradedFlanks;
use crate::scene::measured_gear::{MeasuredChart, TraceFilter, TraceSettings};

impl ChartEvaluation<'_> {
    pub(super) fn traces(
        &mut self,
        chart: &MeasuredChart,
        how: &TraceSettings,
    ) -> Result<(), Errors> {
        let lever = AngleScale {
            radius: how
                .is_profile
                .then_some(0.5 * self.gear.gear.base_diameter()),
        };
        let along = self
            .chart_files
            .column(chart, &how.along, how.along_unit.as_deref(), &lever)?
            .values;
        for side in GradedFlanks::ALL {
            let columns = self.chart_files.columns_of_side(
                chart,
                side as usize,
                &AngleScale { radius: None },
            )?;
            if columns.is_empty() {
                continue;
            }
            let ends = match (along.first(), along.last()) {
                (Some(&first), Some(&last)) => [first, last],
                _ => [0.0, 0.0],
            };
            let [from, to] = how.evaluation.unwrap_or(ends);
            let reach = how.active.map_or(to - from, |[low, high]| high - low);
            let taken = |x: f64| how.design.iter().map(|d| d.deviation_at(x)).sum::<f64>();
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
                    e.with_span(&chart.span)
                        .with_label(format!("column \"{}\"", column.name))
                };
                let plain = match cutoff(how.filter, (from, to)) {
                    Some(cutoff) => {
                        trace::gaussian_filter(&along, &plain, cutoff).map_err(in_column)?
                    }
                    None => plain,
                };
                let mut line = trace::fit_mean_line(&along, &plain, (from, to), reach, chart.std)
                    .map_err(in_column)?;
                let inward = how.is_profile && self.gear.gear.internal;
                if inward {
                    // The slope rises toward the tip, and that is where the roll is shortest.
                    line.slope = line.slope.scaled_by(-1.0);
                }
                if let Some(begins) = how.relief_from {
                    let straight = match inward {
                        false => (from.max(ends[0]), begins),
                        true => (begins, to.min(ends[1])),
                    };
                    let relief =
                        trace::tip_relief(&along, &column.values, straight, inward, chart.std)
                            .map_err(|e| e.with_span(&chart.span))?;
                    reliefs.push(relief);
                }
                traces.push((column.name, column.values, line));
            }
            if let Some(cutoff) = cutoff(how.filter, (from, to)) {
                self.results.notes.push(format!(
                    "{} {}: Gaussian filter, cut-off {:.4} mm",
                    if how.is_profile { "profile" } else { "helix" },
                    side.name(),
                    1e3 * cutoff
                ));
            }
            self.push_worst_deviations(side, how.is_profile, &traces);
            self.tip_relief(side, &reliefs);
            self.results.plots.push(ChartPlot::Traces {
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
    fn push_worst_deviations(
        &mut self,
        side: GradedFlanks,
        is_profile: bool,
        traces: &[(String, Vec<f64>, MeanLine)],
    ) {
        use GearDeviation::*;
        type TraceReading = fn(&MeanLine) -> Estimate;
        let [total, form, slope] = match is_profile {
            true => [ProfileTotal, ProfileForm, ProfileSlope],
            false => [HelixTotal, HelixForm, HelixSlope],
        };
        let of: [(GearDeviation, TraceReading); 3] = [
            (total, |line| line.total),
            (form, |line| line.form),
            (slope, |line| line.slope),
        ];
        for (quantity, value) in of {
            let size = |t: &&(String, Vec<f64>, MeanLine)| value(&t.2).value.abs();
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
            self.results.notes.push(format!(
                "{} {}: mean of {} is {:.2} µm",
                slope.symbol(),
                side.name(),
                traces.len(),
                1e6 * mean
            ));
        }
    }

    /// The mean of what the tips of a side lack.
    fn tip_relief(&mut self, side: GradedFlanks, reliefs: &[Estimate]) {
        let n = reliefs.len() as f64;
        let values = || reliefs.iter().map(|r| 1e6 * r.value);
        let (low, high) = extremes(values());
        if let Some(one) = reliefs.first() {
            let mean = Estimate {
                value: 1e-6 * values().sum::<f64>() / n,
                std: one.std.map(|u| u / n.sqrt()),
            };
            let found = format!("mean of {n}, {low:.2} to {high:.2}");
            self.add(GearDeviation::TipRelief, side, found, mean);
        }
    }
}

/// The cut-off of a trace's filter, m: by ISO 1328-1:2013 a thirtieth of the evaluation range, 25 µm at least.
fn cutoff(filter: Option<TraceFilter>, (from, to): (f64, f64)) -> Option<f64> {
    const MIN_CUTOFF: f64 = 25e-6;
    filter.map(|filter| match filter {
        TraceFilter::Cutoff(cutoff) => cutoff,
        TraceFilter::OfRange => ((to - from) / 30.0).max(MIN_CUTOFF),
    })
}
