//! Comparison of solution methods (error and run time): document, tables, recommendation.

use serde_json::{Value, json};

use super::presentation::{ENDED_EARLY, Figure, Presentation, Provenance};
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
            sources: &self.scene.sources,
            trace: vec!["dofs", "reference", "runs"],
            ..Provenance::default()
        }
    }

    fn body(&self) -> Result<Value, Error> {
        let (found, wanted) = (&self.result, self.target_error);
        let run = |compared_method: &ComparedMethod| {
            let [coordinates, modes, lengths] = sizes(compared_method);
            json!({
                "method": compared_method.method, "coordinates": coordinates, "modes": modes, "lengths": lengths, "error": compared_method.error,
                "run_time_s": compared_method.seconds, "status": compared_method.failure.as_deref().unwrap_or("ok"),
            })
        };
        let best = found.cheapest(wanted).or(found.most_accurate());
        let reached = found.cheapest(wanted).is_some();
        let [coordinates, modes, lengths] = best.map_or([None; 3], sizes);
        Ok(json!({
            "interrupted": found.interrupted,
            "compared": found.quantity,
            "norm": found.norm,
            "dofs": found.dofs,
            "reference": { "method": found.reference, "error": found.reference_error },
            "runs": found.methods.iter().map(run).collect::<Vec<_>>(),
            "recommendation": {
                "error": wanted, "reached": reached, "method": best.map(|w| w.method), "coordinates": coordinates, "modes": modes,
                "lengths": lengths, "run_time_s": best.map(|w| w.seconds), "error_reached": best.and_then(|w| w.error),
                "text": recommendation_text(found, wanted),
            },
        }))
    }

    fn text(&self) -> String {
        let (found, wanted) = (&self.result, self.target_error);
        let mut text = format!(
            "error in {} ({}) against run time; {}\nreference: {}, good to {}\n\n",
            found.quantity,
            found.norm,
            format_args!("{} degrees of freedom", found.dofs),
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

    fn table(&self) -> Table<'_> {
        let found = &self.result;
        let mut table = Table::new("method|coordinates|modes|lengths|error|run_time_s|status");
        for method in &found.methods {
            let [coordinates, modes, lengths] =
                sizes(method).map(|n| or_blank(n, |n| n.to_string()));
            let status = method.failure.as_deref().unwrap_or("ok").to_string();
            let (error, seconds) = (or_blank(method.error, power), decimal(method.seconds));
            let name = method.method.to_string();
            table.row([name, coordinates, modes, lengths, error, seconds, status]);
        }
        table
    }

    fn figures(&self) -> Result<Vec<Figure>, Error> {
        let point = |method: &ComparedMethod| {
            Some(WorkPrecisionPoint {
                method: method.method,
                seconds: method.seconds,
                error: method.error?,
            })
        };
        let points: Vec<_> = self.result.methods.iter().filter_map(point).collect();
        let floor = (self.result.reference_error, "error of the reference");
        let title = &self.scene.model.title;
        Ok(vec![Figure::first(work_precision_plot::draw(
            title, &points, floor,
        ))])
    }

    fn interruption(&self) -> Option<String> {
        self.result.interrupted.then(|| ENDED_EARLY.to_string())
    }
}

/// Coordinates, modes, lengths: the one that was chosen.
fn sizes(method: &ComparedMethod) -> [Option<usize>; 3] {
    match method.size {
        Some(ModelSize::Coordinates(n)) => [Some(n), None, None],
        Some(ModelSize::Modes(n)) => [None, Some(n), None],
        Some(ModelSize::ShaftElements(n)) => [None, None, Some(n)],
        None => [None; 3],
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
                "no way reaches {wanted:e}; nearest is {} with {}",
                of(method),
                method.error.map_or(String::new(), format_error)
            );
            if found.reference_error > wanted {
                text += &format!(
                    ", and the reference itself is known to {} only",
                    format_error(found.reference_error)
                );
            }
            text
        }
        (None, None) => "no way came to its end, so that none can be recommended".to_string(),
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
        None => "–".to_string(),
    }
}
