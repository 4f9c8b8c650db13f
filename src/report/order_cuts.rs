//! Order cuts: document, tables, amplitude and phase over speed.

use std::f64::consts::TAU;

use serde_json::{Value, json};

use super::bode::{self, BodePlot};
use super::figure::{Figure, PlotColumn};
use super::number_format::{four_digits, significant};
use super::presentation::{LogReport, Presentation, Provenance};
use super::table::{Table, exact};
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::sorting::ascending_order;
use crate::plan::logs::order_cuts::{OrderCut, OrderCuts, rpm};

impl Presentation for LogReport<OrderCuts> {
    fn provenance(&self) -> Provenance<'_> {
        Provenance::of_log(&self.result.trace, &self.repairs, &self.result.diagnostics)
    }

    fn body(&self) -> Result<Value, Error> {
        let found = &self.result;
        let cut = |cut: &OrderCut| {
            let largest = cut.largest().map(|at| {
            json!({ "amplitude": cut.value[at].norm(), "phase_rad": cut.value[at].arg(), "speed_rpm": rpm(found.speed[at]),
                "frequency_hz": cut.order * found.speed[at] / TAU })
        });
            json!({
                "channel": cut.channel,
                "unit": cut.unit,
                "order": cut.order,
                "amplitude": cut.value.iter().map(|z| z.norm()).collect::<Vec<_>>(),
                "phase_rad": cut.value.iter().map(|z| z.arg()).collect::<Vec<_>>(),
                "largest": largest,
            })
        };
        Ok(json!({
            "kind": "order-cut",
            "method_text": found.method_text,
            "turns": found.turns,
            "time_s": found.time_s,
            "speed_rpm": found.speed.iter().map(|&s| rpm(s)).collect::<Vec<_>>(),
            "cuts": found.cuts.iter().map(cut).collect::<Vec<_>>(),
        }))
    }

    fn text(&self) -> String {
        let found = &self.result;
        let text = format!("{}\n\n", found.method_text);
        let mut table = Table::new("order|largest|at [rpm]|frequency [Hz]|phase [deg]|");
        for cut in &found.cuts {
            let Some(at) = cut.largest() else { continue };
            let speed = found.speed[at];
            table.row([
                four_digits(cut.order),
                four_digits(cut.value[at].norm()),
                significant(rpm(speed)),
                significant(cut.order * speed / TAU),
                format!("{:.0}", cut.value[at].arg().to_degrees()),
                format!("{} {}", cut.channel, cut.unit),
            ]);
        }
        text + &table.text()
    }

    fn table(&self) -> Table<'_> {
        let found = &self.result;
        let speeds: Vec<f64> = found.speed.iter().map(|&s| rpm(s)).collect();
        let blocks = Table::default()
            .numbers("time_s", "", &found.time_s, exact)
            .numbers("speed_rpm", "", speeds, exact);
        found.cuts.iter().fold(blocks, |table, cut| {
            let name = |part| format!("{} order {} {part}", cut.channel, cut.order);
            let all = |part: fn(&Complex) -> f64| cut.value.iter().map(part).collect::<Vec<_>>();
            table
                .numbers(&name("amplitude"), &cut.unit, all(|z| z.norm()), exact)
                .numbers(&name("phase"), "deg", all(|z| z.arg().to_degrees()), exact)
        })
    }

    fn figures(&self) -> Result<Vec<Figure>, Error> {
        Ok(vec![Figure::first(plots(&self.result, &self.title))])
    }
}

/// Amplitude and phase over speed, by rising speed.
fn plots(found: &OrderCuts, title: &str) -> PlotColumn {
    let rising = ascending_order(found.speed.iter().copied());
    bode::bode(&BodePlot {
        title: format!("{title}: order cuts"),
        abscissa_label: "speed, rpm",
        frequency_hz: rising.iter().map(|&at| rpm(found.speed[at])).collect(),
        curves: (found.cuts.iter())
            .map(|cut| bode::BodeCurve {
                label: format!("{} order {}", cut.channel, cut.order),
                unit: cut.unit.clone(),
                measured: rising.iter().map(|&at| cut.value[at]).collect(),
                is_computed: true,
                ..bode::BodeCurve::default()
            })
            .collect(),
        modes_hz: Vec::new(),
    })
}
