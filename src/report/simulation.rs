//! Motion in time: document, table over time, plot; its tables for a terminal are in `simulation_table`.

use serde_json::{Map, Value, json};

use super::figure::{Axis, Curve, EventMarks, Figure, Guide, Ink, Plot, PlotColumn, PointLabel};
use super::online;
use super::output_key::{effort, key};
use super::plan::{step_lines, steps};
use super::presentation::{Presentation, Provenance};
use super::sensitivity;
use super::simulation_table::{cost, energy_balance, statistics_table, step_responses};
use super::table::{Table, decimal};
use crate::base::error::Error;
use crate::base::quantity::format_time;
use crate::motion::energy_balance::EnergyBalance;
use crate::motion::event_log::EventRecord;
use crate::motion::output_statistics::OutputStatistics;
use crate::motion::outputs::MotionOutput;
use crate::plan::motion::run::MotionResult;
use crate::plan::motion::simulation_setup::SimulationSetup;
use crate::plan::simulate::SimulationResult;
use crate::scene::Scene;

/// A motion of the machine of a scene.
pub struct SimulationReport<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The motion.
    pub result: SimulationResult,
}

impl Presentation for SimulationReport<'_> {
    fn provenance(&self) -> Provenance<'_> {
        Provenance {
            title: &self.scene.model.title,
            sources: &self.scene.sources,
            trace: vec!["equations", "start", self.result.choice.method.name],
            effort: effort(&self.result.history.stats, self.result.history.seconds),
            warnings: &self.result.diagnostics,
            ..Provenance::default()
        }
    }

    fn body(&self) -> Result<Value, Error> {
        let result = &self.result;
        let mut body = body(result);
        sensitivity::extend(&mut body, &result.setup, result.sensitivity.as_ref());
        online::extend(&mut body, &result.setup, &result.online);
        Ok(body)
    }

    fn text(&self) -> String {
        let SimulationResult {
            setup,
            history,
            sensitivity,
            ..
        } = &self.result;
        let mut text = statistics_table(setup, history, sensitivity.as_ref());
        if let Some(sensitivity) = sensitivity {
            text += &sensitivity::text(setup, sensitivity);
        }
        text += &online::text(setup, &self.result.online);
        text + &step_responses(setup, &self.result.step_responses)
    }

    fn table(&self) -> Table<'_> {
        let history = &self.result.history;
        let time = Table::default().numbers("time", "s", &history.time, decimal);
        let outputs = self.result.setup.outputs.list.iter();
        outputs
            .zip(&history.values)
            .fold(time, |table, (output, values)| {
                table.numbers(&output.name, output.unit, values, decimal)
            })
    }

    fn figures(&self) -> Result<Vec<Figure>, Error> {
        if self.result.history.time.is_empty() {
            return Ok(Vec::new());
        }
        let title = &self.scene.model.title;
        let mut plots = histories(title, &self.result.setup, &self.result.history);
        if let Some(at) = self.result.step_time_s {
            plots.note = "dotted: step of the load".into();
            for plot in &mut plots.plots {
                plot.guides.push(Guide::vertical(at));
            }
        }
        Ok(vec![Figure::first(plots)])
    }

    fn notes(&self) -> String {
        let mut notes = step_lines(steps(&self.result.plan));
        if self.result.history.time.is_empty() {
            notes += "left out plots over time: the study has no history\n";
        }
        notes += &cost(&self.result.history);
        if let Some(sensitivity) = &self.result.sensitivity {
            notes += &sensitivity::cost(sensitivity);
        }
        if let Some(balance) = &self.result.history.balance {
            notes += &energy_balance(balance);
        }
        notes
    }

    fn interruption(&self) -> Option<String> {
        let end = format_time(self.result.history.end_time);
        let text = format!("interrupted at t = {end}: results end there\n");
        self.result.history.interrupted.then_some(text)
    }
}

/// The document of a motion.
fn body(result: &SimulationResult) -> Value {
    let SimulationResult {
        setup,
        choice,
        history,
        step_responses,
        ..
    } = result;
    let mut outputs = Map::new();
    let mut readings = Map::new();
    let kept = !history.time.is_empty();
    let lists = setup.outputs.list.iter().zip(&history.values);
    for (at, ((output, values), reading)) in lists.zip(&history.statistics).enumerate() {
        outputs.insert(key(output), json!(values));
        let answer = step_responses.get(at).copied().flatten().map(|a| {
            json!({
                "before": a.initial_value, "after": a.final_value, "overshoot": a.overshoot.0, "overshoot_after_s": a.overshoot.1,
                "rise_s": a.rise_s, "settling_s": a.settling_s, "oscillations": a.oscillations,
            })
        });
        let reading = reading.map(|r| {
            json!({
                "end": r.end, "least": r.min.0, "least_at_s": r.min.1, "greatest": r.max.0, "greatest_at_s": r.max.1,
                "mean": r.mean, "rms_about_mean": r.standard_deviation, "step": answer,
            })
        });
        readings.insert(key(output), json!(reading));
    }
    json!({
        "method": choice.method.name,
        "reason": choice.reason,
        "interrupted": history.interrupted,
        "time_s": kept.then_some(&history.time),
        "outputs": kept.then_some(outputs),
        "readings": readings,
        "events": history.events.as_ref().map(|events| events_json(setup, events)),
        "energy_balance": history.balance.as_ref().map(energy_balance_json),
    })
}

fn energy_balance_json(balance: &EnergyBalance) -> Value {
    let told = |x: f64| balance.stopped_at.is_none().then_some(x);
    json!({
        "stored_before_j": balance.before, "stored_after_j": told(balance.after), "put_in_j": told(balance.work_in),
        "lost_j": told(balance.dissipated), "gap": told(balance.relative_error()), "gap_uncertainty": balance.error_bound(), "readings": balance.evaluations,
    })
}

/// Events by kind with the element that switched at each instant.
fn events_json(setup: &SimulationSetup, events: &[EventRecord]) -> Vec<Value> {
    let elements = &setup.model.model.elements;
    let name = |(_, at): &(f64, usize)| &elements[*at].name;
    let of = |e: &EventRecord| {
        json!({
            "kind": e.kind.name(), "count": e.count, "every": e.stride,
            "time_s": e.events.iter().map(|e| e.0).collect::<Vec<_>>(),
            "element": e.events.iter().map(name).collect::<Vec<_>>(),
        })
    };
    events.iter().map(of).collect()
}

/// The same as marks of a figure, with counts in the key.
fn event_marks(setup: &SimulationSetup, events: &[EventRecord]) -> Vec<EventMarks> {
    let elements = &setup.model.model.elements;
    let marks = |e: &EventRecord| {
        let thinned = match e.stride {
            1 => String::new(),
            stride => format!(", 1 of {stride} marked"),
        };
        EventMarks {
            kind: e.kind.name().into(),
            name: format!("{}: {}{thinned}", e.kind.name(), e.count),
            ink: e.kind as usize + 1,
            x: e.events.iter().map(|e| e.0).collect(),
            sources: elements.iter().map(|e| e.name.clone()).collect(),
            source: e.events.iter().map(|e| e.1).collect(),
        }
    };
    events.iter().map(marks).collect()
}

const HEIGHT: f64 = 150.0;

/// Every output over time.
fn histories(title: &str, setup: &SimulationSetup, history: &MotionResult) -> PlotColumn {
    let end = history.time.last().copied().filter(|end| *end > 0.0);
    let extremes = |reading: &Option<OutputStatistics>| -> Vec<PointLabel> {
        let ends = reading
            .iter()
            .flat_map(|r| [(r.max, "greatest"), (r.min, "least")]);
        ends.map(|((value, at), name)| PointLabel {
            x: at,
            y: value,
            text: name.into(),
        })
        .collect()
    };
    let all = setup.outputs.list.iter().zip(&history.values);
    let plot =
        |((output, values), reading): ((&MotionOutput, &Vec<f64>), &Option<OutputStatistics>)| {
            Plot {
                height: HEIGHT,
                heading: output.name.clone(),
                labels: extremes(reading),
                curves: vec![Curve::line(
                    "",
                    Ink::Series(0),
                    history.time.clone(),
                    values.clone(),
                )],
                ..Plot::new(
                    Axis::linear("time, s").over(0.0, end.unwrap_or(1.0)),
                    Axis::linear(output.unit),
                )
            }
        };
    PlotColumn {
        title: title.to_string(),
        linked: true,
        events: event_marks(setup, history.events.as_deref().unwrap_or_default()),
        plots: all.zip(&history.statistics).map(plot).collect(),
        ..PlotColumn::default()
    }
}
