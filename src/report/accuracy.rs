//! Error against run time as JSON, CSV and a picture.

use std::sync::Arc;

use serde_json::{Value, json};

use super::axes::{decades, rule_decades};
use super::csv::quoted;
use super::json::header;
use super::motion::effort;
use super::style::{
    Anchor, BLACK, BLUE, Canvas, FAINT, GREY, Ink, ORANGE, Panel, SMALL, Spot, Stroke, TITLE,
    WIDTH, paler, picture,
};
use crate::base::place::Source;
use crate::motion::problem::Wanted;
use crate::study::accuracy::{Accuracy, Run};

/// The document.
pub fn json(
    sources: &[Arc<Source>],
    outputs: &[String],
    accuracy: &Accuracy,
    wanted: f64,
) -> Value {
    let reference = &accuracy.reference;
    let run = |run: &Run| {
        let mut row = effort(&run.effort, run.seconds);
        let (tolerance, step) = match run.wanted {
            Some(Wanted::Tolerance(x)) => (Some(x), None),
            Some(Wanted::Step(h)) => (None, Some(h)),
            None => (None, None),
        };
        if let Some(row) = row.as_object_mut() {
            row.insert("method".into(), json!(run.method));
            row.insert("tolerance".into(), json!(tolerance));
            row.insert("step_s".into(), json!(step));
            row.insert("error".into(), json!(run.error));
            row.insert(
                "status".into(),
                json!(run.failed.as_deref().unwrap_or("ok")),
            );
        }
        row
    };
    let best = accuracy.cheapest(wanted);
    let finite = |x: f64| x.is_finite().then_some(x);
    json!({
        "geardyn": header(sources, &["equations", "start", "reference", "ladder"]),
        "norm": "largest difference over all samples, by the largest size of the reference, worst output",
        "outputs": outputs,
        "reference": {
            "method": reference.method, "beside": reference.beside, "error": finite(reference.agreement),
            "amplification": finite(reference.amplification),
        },
        "runs": accuracy.runs.iter().map(run).collect::<Vec<_>>(),
        "recommendation": { "error": wanted, "method": best.map(|r| r.method), "run_time_s": best.map(|r| r.seconds) },
        "warnings": [],
    })
}

/// One row a run.
pub fn csv(accuracy: &Accuracy) -> String {
    let mut text = String::from(
        "method,tolerance,step_s,error,run_time_s,steps,rejected,rhs_evaluations,events,status\n",
    );
    for run in &accuracy.runs {
        let (tolerance, step) = match run.wanted {
            Some(Wanted::Tolerance(x)) => (format!("{x:e}"), String::new()),
            Some(Wanted::Step(h)) => (String::new(), format!("{h:e}")),
            None => Default::default(),
        };
        let error = run.error.map_or(String::new(), |e| format!("{e:e}"));
        let e = &run.effort;
        let status = quoted(run.failed.as_deref().unwrap_or("ok"));
        text += &format!(
            "{},{tolerance},{step},{error},{},{},{},{},{},{status}\n",
            run.method, run.seconds, e.steps, e.rejected, e.evaluations, e.events
        );
    }
    text
}

const LEFT: f64 = 70.0;
const RIGHT: f64 = 190.0;
const TOP: f64 = 40.0;
const HIGH: f64 = 420.0;

/// Errors below this are rounding of the reference.
const FLOOR: f64 = 1e-17;

/// Error over run time, both logarithmic, a line for each method.
pub fn draw(title: &str, accuracy: &Accuracy) -> String {
    let ended: Vec<(&Run, f64)> = accuracy
        .runs
        .iter()
        .filter_map(|r| Some((r, r.error?.max(FLOOR))))
        .collect();
    picture(WIDTH, TOP + HIGH + 52.0, |canvas| {
        canvas.text(title, (LEFT, 16.0), TITLE, BLACK, Anchor::Start);
        let x = decades(ended.iter().map(|r| r.0.seconds));
        let low = ended
            .iter()
            .map(|r| r.1.log10())
            .fold(f64::INFINITY, f64::min);
        let high = ended
            .iter()
            .map(|r| r.1.log10())
            .fold(f64::NEG_INFINITY, f64::max);
        let Some(x) = x else {
            canvas.text(
                "no run came to its end",
                (WIDTH / 2.0, TOP + HIGH / 2.0),
                TITLE,
                GREY,
                Anchor::Middle,
            );
            return;
        };
        let panel = Panel {
            across: (LEFT, WIDTH - RIGHT),
            down: (TOP, TOP + HIGH),
            x,
            y: (low - 0.5, high.min(3.0) + 0.5),
        };
        rule_decades(&panel, canvas);
        rule_times(&panel, canvas);
        canvas.frame(
            (panel.across.0, panel.down.0),
            (panel.across.1, panel.down.1),
            GREY,
            0.6,
        );
        canvas.upright(
            "error",
            (14.0, TOP + HIGH / 2.0),
            SMALL,
            BLACK,
            Anchor::Middle,
        );
        canvas.text(
            "run time, s",
            (0.5 * (LEFT + WIDTH - RIGHT), TOP + HIGH + 30.0),
            SMALL,
            BLACK,
            Anchor::Middle,
        );
        let agreement = accuracy.reference.agreement;
        if agreement > 0.0 && agreement.is_finite() && agreement.log10() > panel.y.0 {
            let height = panel.height_of(agreement.log10());
            canvas.path(
                &[(panel.across.0, height), (panel.across.1, height)],
                GREY,
                0.8,
                Stroke::Dotted,
            );
            canvas.text(
                "agreement of references",
                (panel.across.1 - 4.0, height - 7.0),
                9.0,
                GREY,
                Anchor::End,
            );
        }
        let mut methods: Vec<&str> = ended.iter().map(|r| r.0.method).collect();
        methods.dedup();
        let ends: Vec<Spot> = methods.iter().map(|m| end_of(&panel, &ended, m)).collect();
        let heights = super::style::push_apart(
            &ends.iter().map(|e| e.1).collect::<Vec<_>>(),
            14.0,
            panel.down,
        );
        for (at, (method, (end, height))) in
            methods.iter().zip(ends.iter().zip(heights)).enumerate()
        {
            let (ink, stroke) = look(at);
            let spots: Vec<Spot> = ended
                .iter()
                .filter(|r| r.0.method == *method && r.1.log10() <= panel.y.1)
                .map(|r| panel.at(r.0.seconds.log10(), r.1.log10()))
                .collect();
            canvas.path(&spots, ink, 1.4, stroke);
            spots.iter().for_each(|&s| canvas.disc(s, 3.0, ink));
            let label = (panel.across.1 + 14.0, height);
            canvas.line(*end, (label.0 - 3.0, label.1), FAINT, 0.7);
            canvas.text(method, label, SMALL, ink, Anchor::Start);
        }
    })
}

/// Where the line of a method is to be labelled: at its slowest point.
fn end_of(panel: &Panel, ended: &[(&Run, f64)], method: &str) -> Spot {
    let own = ended.iter().filter(|r| r.0.method == method);
    let slowest = own.max_by(|a, b| a.0.seconds.total_cmp(&b.0.seconds));
    slowest.map_or((panel.across.1, panel.down.0), |r| {
        panel.at(r.0.seconds.log10(), r.1.log10().min(panel.y.1))
    })
}

fn look(at: usize) -> (Ink, Stroke) {
    let inks = [BLUE, ORANGE, BLACK, GREY, paler(BLUE), paler(ORANGE)];
    let strokes = [Stroke::Solid, Stroke::Dashed, Stroke::Dotted];
    (
        inks[at % inks.len()],
        strokes[(at / inks.len()) % strokes.len()],
    )
}

fn rule_times(panel: &Panel, canvas: &mut Canvas) {
    let (first, last) = (panel.x.0.ceil() as i32, panel.x.1.floor() as i32);
    for decade in first..=last {
        let right = panel.right_of(f64::from(decade));
        canvas.line((right, panel.down.0), (right, panel.down.1), FAINT, 0.5);
        let text = match decade {
            -6..=-4 => format!("{} µs", 10i64.pow((decade + 6) as u32)),
            -3..=-1 => format!("{} ms", 10i64.pow((decade + 3) as u32)),
            0..=3 => format!("{} s", 10i64.pow(decade as u32)),
            _ => format!("1e{decade} s"),
        };
        canvas.text(
            &text,
            (right, panel.down.1 + 11.0),
            SMALL,
            BLACK,
            Anchor::Middle,
        );
    }
}
