//! Comparison of solution methods (error and run time): document, tables, recommendation.

use serde_json::{Value, json};

use super::figure::Figure;
use super::presentation::{INTERRUPTED_TEXT, Presentation, Provenance};
use super::table::{Table, decimal, or_blank, power};
use super::work_precision_plot::{self, WorkPrecisionPoint};
use super::work_precision_text::{format_error, format_time_short};
use crate::base::error::Error;
use crate::base::text::pluralise;
use crate::scene::Scene;
use crate::study::comparison::{ComparedMethod, ComparisonResult, ModelSize};

/// Natural frequencies or responses by several methods against a reference: error over run time.
pub struct ComparisonReport<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The error for which a method is recommended.
    pub target_error: f64,
    /// The methods.
    pub result: ComparisonResult,
}

impl Presentation for ComparisonReport<'_> {
    fn provenance(&self) -> Provenance<'_> {
        Provenance {
            title: &self.scene.model.title,
            sources: &self.scene.sources,
            trace: vec!["dofs", "reference", "runs"],
            ..Provenance::default()
        }
    }

    fn body(&self) -> Result<Value, Error> {
        Ok(comparison_json(&self.result, self.target_error))
    }

    fn text(&self) -> String {
        comparison_text(&self.result, self.target_error)
    }

    fn table(&self) -> Table<'_> {
        run_table(self.result.methods.iter())
    }

    fn figures(&self) -> Result<Vec<Figure>, Error> {
        let points = comparison_points(&self.result);
        let floor = (self.result.reference_error, "error of the reference");
        let title = &self.scene.model.title;
        Ok(vec![Figure::first(work_precision_plot::figure(
            title, &points, floor,
        ))])
    }

    fn interruption(&self) -> Option<String> {
        self.result
            .interrupted
            .then(|| INTERRUPTED_TEXT.to_string())
    }
}

/// The keys of a comparison in a document.
pub(super) fn comparison_json(found: &ComparisonResult, wanted: f64) -> Value {
    let run = |compared_method: &ComparedMethod| {
        let mut run = json!({
            "method": compared_method.method, "error": compared_method.error,
            "run_time_s": compared_method.seconds, "status": compared_method.failure.as_deref().unwrap_or("ok"),
        });
        enter_sizes(&mut run, Some(compared_method));
        run
    };
    let best = found.cheapest(wanted).or(found.most_accurate());
    let reached = found.cheapest(wanted).is_some();
    let mut recommendation = json!({
        "error": wanted, "reached": reached, "method": best.map(|w| w.method), "run_time_s": best.map(|w| w.seconds),
        "error_reached": best.and_then(|w| w.error), "text": recommendation_text(found, wanted),
    });
    enter_sizes(&mut recommendation, best);
    json!({
        "interrupted": found.interrupted,
        "compared": found.quantity,
        "norm": found.norm,
        "dofs": found.dofs,
        "reference": { "method": found.reference, "error": found.reference_error },
        "runs": found.methods.iter().map(run).collect::<Vec<_>>(),
        "recommendation": recommendation,
    })
}

/// A comparison for a terminal.
pub(super) fn comparison_text(found: &ComparisonResult, wanted: f64) -> String {
    let dofs = found.dofs.map(|n| format!("; {n} degrees of freedom"));
    let mut text = format!(
        "error in {} ({}) against run time{}\nreference: {}, good to {}\n\n",
        found.quantity,
        found.norm,
        dofs.unwrap_or_default(),
        found.reference,
        format_error(found.reference_error),
    );
    let mut table = Table::named("way|at|error|time");
    for method in &found.methods {
        let Some(error) = method.error else { continue };
        let row = [
            method.method.to_string(),
            size_text(method),
            format_error(error),
            format_time_short(method.seconds),
        ];
        table.row(row);
    }
    text += &table.text();
    let failed: Vec<(&ComparedMethod, &String)> = found
        .methods
        .iter()
        .filter_map(|w| Some((w, w.failure.as_ref()?)))
        .collect();
    if !failed.is_empty() {
        let mut table = Table::texts("||");
        for (method, why) in failed {
            table.row([method.method.to_string(), size_text(method), why.clone()]);
        }
        text += &format!("\nleft out or failed\n{}", table.text());
    }
    text += &format!("\n{}\n", recommendation_text(found, wanted));
    text
}

/// The runs of comparisons, a row each.
pub(super) fn run_table<'a>(methods: impl Iterator<Item = &'a ComparedMethod>) -> Table<'static> {
    let methods: Vec<&ComparedMethod> = methods.collect();
    let names = size_names(methods.iter().find_map(|m| m.size));
    let mut table = Table::new("method")
        .columns(&names.join("|"))
        .columns("error|run_time_s|status");
    for method in methods {
        let status = method.failure.as_deref().unwrap_or("ok").to_string();
        let (error, seconds) = (or_blank(method.error, power), decimal(method.seconds));
        let sizes = names
            .iter()
            .map(|name| or_blank(size(method, name), |n| n.to_string()));
        let row = std::iter::once(method.method.to_string()).chain(sizes);
        table.row(row.chain([error, seconds, status]));
    }
    table
}

/// The points of a figure of error over run time.
pub(super) fn comparison_points(found: &ComparisonResult) -> Vec<WorkPrecisionPoint> {
    let point = |method: &ComparedMethod| {
        Some(WorkPrecisionPoint {
            method: method.method,
            seconds: method.seconds,
            error: method.error?,
        })
    };
    found.methods.iter().filter_map(point).collect()
}

/// Keys of the sizes of methods that have sizes of this kind.
fn size_names(size: Option<ModelSize>) -> &'static [&'static str] {
    match size {
        Some(ModelSize::MeshGrid { .. }) => &["positions", "slices"],
        Some(ModelSize::FlankGrid { .. } | ModelSize::Positions(_)) => &["positions", "stations"],
        _ => &["coordinates", "modes", "lengths"],
    }
}

/// The size of a method under a key, where it has one.
fn size(method: &ComparedMethod, key: &str) -> Option<usize> {
    match (method.size?, key) {
        (ModelSize::Coordinates(n), "coordinates")
        | (ModelSize::Modes(n), "modes")
        | (ModelSize::ShaftElements(n), "lengths")
        | (ModelSize::Positions(n), "positions") => Some(n),
        (ModelSize::MeshGrid { positions, .. }, "positions")
        | (ModelSize::FlankGrid { positions, .. }, "positions") => Some(positions),
        (ModelSize::FlankGrid { stations, .. }, "stations") => Some(stations),
        (ModelSize::MeshGrid { slices, .. }, "slices") => Some(slices),
        _ => None,
    }
}

/// Enters the sizes of a method into its object: those of a mesh, else those of a machine, null where not chosen.
fn enter_sizes(object: &mut Value, method: Option<&ComparedMethod>) {
    for name in size_names(method.and_then(|m| m.size)) {
        object[*name] = json!(method.and_then(|m| size(m, name)));
    }
}

/// Recommended method for the requested error.
fn recommendation_text(found: &ComparisonResult, wanted: f64) -> String {
    let of = |method: &ComparedMethod| {
        format!(
            "{} ({})",
            method_label(method),
            format_time_short(method.seconds)
        )
    };
    match (found.cheapest(wanted), found.most_accurate()) {
        (Some(method), _) => format!("for {wanted:e} the cheapest is {}", of(method)),
        (None, Some(method)) => {
            let mut text = format!(
                "no method reaches {wanted:e}; nearest is {} with {}",
                of(method),
                method.error.map_or(String::new(), format_error)
            );
            if found.reference_error > wanted {
                text += &format!(
                    ", and the reference has an error of {}",
                    format_error(found.reference_error)
                );
            }
            text
        }
        (None, None) => "no run completed, so that none can be recommended".to_string(),
    }
}

fn method_label(method: &ComparedMethod) -> String {
    match method.size {
        Some(_) => format!("{} at {}", method.method, size_text(method)),
        None => method.method.to_string(),
    }
}

/// Model size of a method, as text.
fn size_text(method: &ComparedMethod) -> String {
    match method.size {
        Some(ModelSize::Coordinates(n)) => pluralise(n, "coordinate"),
        Some(ModelSize::Modes(n)) => pluralise(n, "mode"),
        Some(ModelSize::ShaftElements(n)) => pluralise(n, "length"),
        Some(ModelSize::Positions(n)) => pluralise(n, "position"),
        Some(ModelSize::MeshGrid { positions, slices }) => {
            format!("{positions} positions × {slices} slices")
        }
        Some(ModelSize::FlankGrid {
            positions,
            stations,
        }) => {
            format!("{positions} positions × {stations} stations")
        }
        None => "–".to_string(),
    }
}
