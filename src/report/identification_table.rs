//! Terminal tables of identified modes with the evidence for and against them.

use super::mode_tracking;
use super::number_format::{INTERVAL_FOOTNOTE, four_digits, percent, significant, with_deviation};
use super::table::{Table, or_dash};
use crate::base::text::wrap_lines;
use crate::identify::compare;
use crate::identify::modal::stabilisation::PoleStability;
use crate::numeric::Complex;
use crate::numeric::statistics::Z_95;
use crate::plan::logs::diagnostics::{coherence_at, window_damping_ratio};
use crate::plan::logs::identification_result::{
    Evidence, IdentificationResult, IdentifiedMode, OrderSelection, PickedPeak,
};
use crate::plan::logs::method::structure_text;
use crate::plan::logs::weak;

/// Terminal text of an identification: modes, harmonics, evidence and notes.
pub fn text(result: &IdentificationResult) -> String {
    let rule = wrap_lines(&format!(
        "{}: {}",
        result.method.name(),
        result.selection_rule
    ));
    let mut text = format!("{}\n{rule}\n\n", wrap_lines(&result.method_text));
    if let Some(tracking) = result.tracking().filter(|c| !c.tracks.is_empty()) {
        return text + &mode_tracking::table(tracking) + &mode_tracking::trials_table(tracking);
    }
    if result.modes.is_empty() && result.weak.is_empty() {
        text += "no mode is significant in the band\n";
        return text + &harmonics(result) + &evidence(result);
    }
    let responses = result.responses.as_ref();
    let coherent = responses.is_some_and(|r| r.responses.iter().any(|f| f.coherence.is_some()));
    let mut table =
        Table::new("mode|frequency [Hz]|damping [%]").columns_if(coherent, "coherence [at peak]");
    if let Some(point) = &result.driving_point {
        table = table.column("modal mass", point.unit);
    }
    let mut table = table.columns("note");
    for (k, mode) in result.modes.iter().enumerate() {
        table.row(mode_row(result, (k + 1).to_string(), mode, coherent));
    }
    for mode in &result.weak {
        table.row(mode_row(result, "weak".to_string(), mode, coherent));
    }
    text += &table.text();
    if (result.modes.iter().chain(&result.weak)).any(|m| m.mode.pole_covariance.is_some()) {
        text += INTERVAL_FOOTNOTE;
    }
    if !result.weak.is_empty() {
        text += &(wrap_lines(weak::rule(result.method)) + "\n");
    }
    if let Some(point) = &result.driving_point {
        text += &format!(
            "modal masses where the largest component of the shape is 1, by the driving point {} over {}\n",
            point.output, point.input
        );
    }
    if let Some(error) = worst_error(result) {
        text += &format!("fit error {} %\n", percent(error));
    }
    for pair in &result.reciprocity {
        let explained = pair
            .explained
            .map_or(String::new(), |e| format!(", {} % by noise", percent(e)));
        text += &format!(
            "reciprocity: {} over {} and {} over {} differ by {} %{explained}\n",
            pair.first.0,
            pair.first.1,
            pair.second.0,
            pair.second.1,
            percent(pair.difference)
        );
    }
    text += &delays(result);
    text += &similar_modes_text(result);
    text += &harmonics(result);
    text += &evidence(result);
    let decay = result.window_decay();
    if decay > 0.0
        && let (Some(first), Some(last)) = (result.modes.first(), result.modes.last())
    {
        let shift = |m: &IdentifiedMode| {
            format!(
                "{} % at {} Hz",
                percent(window_damping_ratio(decay, m.frequency_hz())),
                four_digits(m.frequency_hz())
            )
        };
        text += &format!(
            "exponential window: damping corrected by {} … {}\n",
            shift(first),
            shift(last)
        );
    }
    text
}

/// Removed delays with their 95 % intervals and their phase at the upper band edge.
fn delays(result: &IdentificationResult) -> String {
    let Some(fit) = result.fit().filter(|f| f.delay_s.iter().any(|d| *d != 0.0)) else {
        return String::new();
    };
    let item = |(delay, std): (&f64, &Option<f64>)| {
        let interval = std.map_or(String::new(), |s| {
            format!(" ± {}", four_digits(1e3 * Z_95 * s))
        });
        let degrees = 360.0 * delay * result.band_hz.1;
        format!("{}{interval} ms ({degrees:.1}°)", four_digits(1e3 * delay))
    };
    let list: Vec<String> = fit.delay_s.iter().zip(&fit.delay_std_s).map(item).collect();
    let text = format!(
        "delay removed, in brackets its phase at {} Hz: {}",
        four_digits(result.band_hz.1),
        list.join(", ")
    );
    wrap_lines(&text) + "\n"
}

/// Row of the table of modes.
fn mode_row(
    result: &IdentificationResult,
    name: String,
    mode: &IdentifiedMode,
    coherent: bool,
) -> Vec<String> {
    let half = |x: Option<f64>| Z_95 * x.unwrap_or(0.0);
    let frequency = with_deviation(mode.frequency_hz(), half(mode.mode.frequency_std_hz()));
    let damping = or_dash(mode.damping_ratio(), |d| {
        with_deviation(100.0 * d, 100.0 * half(mode.mode.damping_std()))
    });
    let mut row = vec![name, frequency, damping];
    if coherent {
        let responses = result.responses.as_ref();
        let coherence = responses.and_then(|r| coherence_at(r, mode.frequency_hz()));
        row.push(or_dash(coherence, |c| format!("{c:.3}")));
    }
    if result.driving_point.is_some() {
        let signed_mass = |m: Complex| significant(m.re.signum() * m.norm());
        row.push(or_dash(mode.modal_mass, signed_mass));
    }
    row.push(note_of(mode));
    row
}

/// Lists pairs of modes with nearly equal shapes at the outputs.
fn similar_modes_text(result: &IdentificationResult) -> String {
    /// MAC above which two shapes are reported as indistinguishable.
    const SIMILAR_MAC: f64 = 0.9;
    let mac = auto_mac(result);
    let mut pairs = Vec::new();
    for (i, row) in mac.iter().enumerate() {
        for (j, value) in row.iter().enumerate().skip(i + 1) {
            if *value > SIMILAR_MAC {
                pairs.push(format!("{} and {} (MAC {value:.3})", i + 1, j + 1));
            }
        }
    }
    match pairs.is_empty() {
        true => String::new(),
        false => {
            wrap_lines(&format!(
                "the modes {} are nearly indistinguishable at these outputs",
                pairs.join(", ")
            )) + "\n"
        }
    }
}

/// Table of harmonics that are no modes.
fn harmonics(result: &IdentificationResult) -> String {
    /// Largest number of rows; further harmonics are only counted.
    const MAX_ROWS: usize = 20;
    if result.harmonics.is_empty() {
        return String::new();
    }
    let mut table = Table::new("rejected [Hz]|amplitude [0 to peak]||note");
    for harmonic in result.harmonics.iter().take(MAX_ROWS) {
        let strongest = (harmonic.amplitude.iter().zip(&result.outputs))
            .max_by(|a, b| a.0.total_cmp(b.0))
            .map_or((String::new(), String::new()), |(a, output)| {
                (
                    four_digits(*a),
                    format!("{} in {}", output.unit, output.name),
                )
            });
        let note = match harmonic.order {
            Some(order) => format!("order {order} of the running speed"),
            None => harmonic.reason.to_string(),
        };
        let frequency = significant(harmonic.frequency_hz);
        table.row([frequency, strongest.0, strongest.1, note]);
    }
    let mut text = format!("\n{}", table.text());
    if result.harmonics.len() > MAX_ROWS {
        text += &format!("{} more\n", result.harmonics.len() - MAX_ROWS);
    }
    text + "\n"
}

/// Summary of the evidence for the modes.
fn evidence(result: &IdentificationResult) -> String {
    match &result.evidence {
        Evidence::Rational(fit) => {
            let last = fit.evidence.iter().rev().find(|s| !s.accepted);
            let last = last.map_or(String::new(), |step| format!("{}\n", step.description()));
            last + &rejected_text(result)
        }
        Evidence::Diagram(diagram) => {
            let stable = diagram
                .poles
                .iter()
                .filter(|p| p.stability == PoleStability::Stable)
                .count();
            let summary = format!(
                "{stable} of {} poles of all orders are stable with respect to the previous order\n",
                diagram.poles.len()
            );
            summary + &rejected_text(result)
        }
        Evidence::Peaks(peaks) => peaks.peaks.iter().filter_map(peak).collect(),
        Evidence::Orders(orders) => order_table(orders) + &rejected_text(result),
        Evidence::Tracking(tracking) => mode_tracking::trials_table(tracking),
    }
}

/// Rejected poles grouped by reason, corrected for an exponential window.
fn rejected_text(result: &IdentificationResult) -> String {
    let decay = result.window_decay();
    let poles = result.rejected_poles();
    let mut reasons: Vec<&str> = poles.iter().map(|o| o.1).collect();
    reasons.sort_unstable();
    reasons.dedup();
    let line = |reason: &str| {
        let matching = poles.iter().filter(|o| o.1 == reason);
        let lines: Vec<String> = matching
            .map(|o| four_digits((o.0 + decay).norm() / std::f64::consts::TAU))
            .collect();
        wrap_lines(&format!("no mode at {} Hz: {reason}", lines.join(", "))) + "\n"
    };
    reasons.into_iter().map(line).collect()
}

/// Half-power result of a peak, or the reason of its rejection as a mode.
fn peak(peak: &PickedPeak) -> Option<String> {
    let hz = four_digits(peak.frequency_hz);
    match peak.half_power {
        _ if !peak.reason.is_empty() => {
            Some(format!("peak at {hz} Hz rejected: {}\n", peak.reason))
        }
        Some((f, d)) => Some(format!(
            "peak at {hz} Hz by half power: {} Hz, {} %\n",
            significant(f),
            percent(d)
        )),
        None => None,
    }
}

/// Table of the model orders near the chosen one, with the residual tests.
fn order_table(orders: &OrderSelection) -> String {
    let mut table = Table::new("model|BIC|AIC|MDL|note");
    let chosen = orders
        .candidates
        .iter()
        .position(|c| c.family == orders.chosen)
        .unwrap_or(0);
    let listed =
        chosen.saturating_sub(NEIGHBOURS)..(chosen + NEIGHBOURS + 1).min(orders.candidates.len());
    for candidate in &orders.candidates[listed] {
        let note = if candidate.family == orders.chosen {
            "taken"
        } else {
            ""
        };
        table.row([
            structure_text(candidate.family),
            format!("{:.1}", candidate.bic),
            format!("{:.1}", candidate.aic),
            format!("{:.1}", candidate.mdl),
            note.to_string(),
        ]);
    }
    let mut text = String::new();
    if !orders.candidates.is_empty() {
        text = table.text();
    }
    for (name, test) in &orders.tests {
        text += &format!(
            "residuals {name}: {}\n",
            format_probability(test.probability)
        );
    }
    text
}

/// Formats a probability.
fn format_probability(p: f64) -> String {
    match p < 0.001 {
        true => "p below 0.001".to_string(),
        false => format!("p = {p:.3}"),
    }
}

/// Number of orders listed on either side of the chosen one.
const NEIGHBOURS: usize = 3;

/// Note on a mode: misfit, scatter, presence, coincidence with orders or mains.
fn note_of(mode: &IdentifiedMode) -> String {
    let mut notes = Vec::new();
    if let Some(departure) = &mode.departure {
        if departure.model_error > 0.0 {
            let share = percent(departure.model_error);
            notes.push(format!("departs by {share} %"));
        }
        if departure.frequency_spread_hz > 0.0 {
            let subject = if departure.by_hit {
                "hits"
            } else {
                "responses"
            };
            let spread = four_digits(departure.frequency_spread_hz);
            notes.push(format!("{subject} differ by {spread} Hz"));
        }
    }
    notes.extend(mode.weak.map(String::from));
    if let Some(presence) = mode.presence {
        notes.push(format!("in {:.0} % of the orders", 100.0 * presence));
    }
    if let Some(order) = mode.on_order {
        notes.push(format!("on order {order} of the running speed"));
    }
    if let Some((mains, multiple)) = mode.on_mains {
        notes.push(format!("on {multiple} × {mains} Hz of the mains"));
    }
    notes.join("; ")
}

/// Auto-MAC matrix of the mode shapes by rows; empty with fewer than two outputs.
pub fn auto_mac(result: &IdentificationResult) -> Vec<Vec<f64>> {
    let shapes: Vec<Vec<Complex>> = result.modes.iter().map(|m| m.mode.shape.clone()).collect();
    if shapes.iter().any(|s| s.len() < 2) {
        return Vec::new();
    }
    let mac = compare::auto_mac(&shapes);
    let row = |i: usize| (0..shapes.len()).map(|j| mac[(i, j)]).collect();
    (0..shapes.len()).map(row).collect()
}

/// Largest relative fit error over the responses; `None` without fitted responses.
fn worst_error(result: &IdentificationResult) -> Option<f64> {
    result.fit_error.iter().copied().reduce(f64::max)
}
