//! Logs as tables for a terminal.

use super::mode_course_table;
use super::number::{INTERVAL, brief, significant, with_deviation};
use super::recording::note;
use super::table::{finish, plain};
use crate::base::words::{counted, wrapped};
use crate::identify::modal::stabilisation::Stability;
use crate::numeric::statistics::HALF_INTERVAL;
use crate::plan::logs::doubts::{coherence_at, window_damping};
use crate::plan::logs::found::{Evidence, FoundMode, Identification, Orders, Peak};
use crate::plan::logs::method::family;
use crate::plan::logs::weak;
use crate::recording::responses::{FrequencyResponses, Spectrum};
use crate::recording::signals::Recording;
use crate::recording::survey::Survey;

/// What was understood of a log.
pub fn survey(recording: &Recording, surveys: &[Survey]) -> String {
    let mut text = format!("{}   {}\n", recording.path, recording.dialect);
    text += &format!(
        "  time base   {} Hz, {}\n",
        rate(recording.rate_hz),
        recording.rate_source
    );
    text += &format!(
        "              {}, {} s",
        counted(recording.samples, "sample"),
        brief(recording.duration_s())
    );
    text += &match recording.stretches.len() {
        1 => "\n".to_string(),
        n => format!(" in {n} stretches\n"),
    };
    if let Some(start) = &recording.start {
        text += &format!("  first sample   {start}\n");
    }
    let facts = || recording.facts.iter().take(FACTS);
    let width = facts().map(|(key, _)| key.chars().count()).max();
    for (key, value) in facts() {
        text += &format!("  {key:width$}   {value}\n", width = width.unwrap_or(0));
    }
    let mut table = plain();
    table.add_row(vec!["  channel", "unit", "range", "noise ≤", "note"]);
    for (channel, survey) in recording.channels.iter().zip(surveys) {
        let (range, noise) = match survey.empty {
            true => ("–".to_string(), "–".to_string()),
            false => (
                format!("{} … {}", brief(survey.range.0), brief(survey.range.1)),
                match survey.noise.is_finite() {
                    true => brief(survey.noise),
                    false => "–".to_string(),
                },
            ),
        };
        let unit = if channel.unit.is_empty() {
            "?"
        } else {
            &channel.unit
        };
        table.add_row(vec![
            format!("  {}", channel.name),
            unit.to_string(),
            range,
            noise,
            note(survey),
        ]);
    }
    text + &finish(&table)
}

/// What a file holds over frequency: responses and spectra; empty where nothing.
pub fn over_frequency(found: Option<&FrequencyResponses>, held: &[Spectrum]) -> String {
    let mut text = found.map_or(String::new(), responses);
    if !held.is_empty() {
        text += &spectra(held);
    }
    text
}

/// `1601 lines, 0 … 800 Hz`.
fn lines(frequency_hz: &[f64]) -> String {
    let end = |f: Option<&f64>| f.map_or("–".to_string(), |&f| brief(f));
    format!(
        "{}, {} … {} Hz",
        counted(frequency_hz.len(), "line"),
        end(frequency_hz.first()),
        end(frequency_hz.last())
    )
}

/// A text from a file, or that it has none.
fn or_unknown(text: &str) -> String {
    match text {
        "" => "?".to_string(),
        text => text.to_string(),
    }
}

fn responses(found: &FrequencyResponses) -> String {
    let mut text = format!(
        "  {} over {}\n",
        counted(found.functions.len(), "frequency response"),
        lines(&found.frequency_hz)
    );
    let mut table = plain();
    table.add_row(vec!["  response", "unit", "input", "unit", "coherence"]);
    for f in &found.functions {
        let input = f.input.clone().unwrap_or_default();
        let coherence = if f.coherence.is_some() { "yes" } else { "–" };
        table.add_row(vec![
            format!("  {}", or_unknown(&f.output.name)),
            or_unknown(&f.output.unit),
            or_unknown(&input.name),
            or_unknown(&input.unit),
            coherence.to_string(),
        ]);
    }
    text += &finish(&table);
    text
}

fn spectra(held: &[Spectrum]) -> String {
    let mut table = plain();
    table.add_row(vec!["  spectrum", "unit", "kind", "over"]);
    for s in held {
        let unit = match s.is_decibel {
            true => format!("dB of {}", or_unknown(&s.unit)),
            false => or_unknown(&s.unit),
        };
        table.add_row(vec![
            format!("  {}", or_unknown(&s.name)),
            unit,
            s.kind.to_string(),
            lines(&s.frequency_hz),
        ]);
    }
    finish(&table)
}

/// Identified modes.
pub fn identified(found: &Identification) -> String {
    let rule = wrapped(&format!("{}: {}", found.method.word(), found.rule));
    let mut text = format!("{}\n{rule}\n\n", wrapped(&found.how));
    if let Some(course) = found.course().filter(|c| !c.tracks.is_empty()) {
        return text + &mode_course_table::table(course) + &mode_course_table::tried(course);
    }
    if found.modes.is_empty() && found.weak.is_empty() {
        text += "no mode is significant in the band\n";
        return text + &harmonics(found) + &evidence(found);
    }
    let responses = found.responses.as_ref();
    let coherent = responses.is_some_and(|r| r.functions.iter().any(|f| f.coherence.is_some()));
    let mut table = plain();
    let mut heads = vec!["mode", "frequency", "damping"];
    let mut units = vec!["", "Hz", "%"];
    if coherent {
        heads.push("coherence");
        units.push("at peak");
    }
    if let Some(point) = &found.driving_point {
        heads.push("modal mass");
        units.push(point.unit);
    }
    heads.push("note");
    units.push("");
    table.add_row(heads);
    table.add_row(units);
    for (k, mode) in found.modes.iter().enumerate() {
        table.add_row(mode_row(found, (k + 1).to_string(), mode, coherent));
    }
    for mode in &found.weak {
        table.add_row(mode_row(found, "weak".to_string(), mode, coherent));
    }
    super::table::right_but_last(&mut table);
    text += &finish(&table);
    if (found.modes.iter().chain(&found.weak)).any(|m| m.mode.pole_covariance.is_some()) {
        text += INTERVAL;
    }
    if !found.weak.is_empty() {
        text += &(wrapped(weak::RULE) + "\n");
    }
    if let Some(point) = &found.driving_point {
        text += &format!(
            "modal masses where the largest component of the shape is 1, by the driving point {} over {}\n",
            point.output, point.input
        );
    }
    if let Some(error) = super::identified::worst_error(found) {
        text += &format!("fit error {} %\n", super::number::percent(error));
    }
    for pair in &found.reciprocity {
        let explained = pair.explained.map_or(String::new(), |e| {
            format!(", {} % by noise", super::number::percent(e))
        });
        text += &format!(
            "reciprocity: {} over {} and {} over {} differ by {} %{explained}\n",
            pair.first.0,
            pair.first.1,
            pair.second.0,
            pair.second.1,
            super::number::percent(pair.difference)
        );
    }
    text += &delays(found);
    text += &alike(found);
    text += &harmonics(found);
    text += &evidence(found);
    let decay = found.window_decay();
    if decay > 0.0
        && let (Some(first), Some(last)) = (found.modes.first(), found.modes.last())
    {
        let shift = |m: &FoundMode| {
            format!(
                "{} % at {} Hz",
                super::number::percent(window_damping(decay, m.frequency_hz())),
                brief(m.frequency_hz())
            )
        };
        text += &format!(
            "exponential window: taken off the damping, {} … {}\n",
            shift(first),
            shift(last)
        );
    }
    text
}

/// Delays that were taken off, with their intervals and what they turn the highest line by.
fn delays(found: &Identification) -> String {
    let Some(fit) = found.fit().filter(|f| f.delay_s.iter().any(|d| *d != 0.0)) else {
        return String::new();
    };
    let one = |(delay, std): (&f64, &Option<f64>)| {
        let interval = std.map_or(String::new(), |s| {
            format!(" ± {}", brief(1e3 * HALF_INTERVAL * s))
        });
        let degrees = 360.0 * delay * found.band_hz.1;
        format!("{}{interval} ms ({degrees:.1}°)", brief(1e3 * delay))
    };
    let all: Vec<String> = fit.delay_s.iter().zip(&fit.delay_std_s).map(one).collect();
    let text = format!(
        "delay taken off, in brackets its phase at {} Hz: {}",
        brief(found.band_hz.1),
        all.join(", ")
    );
    wrapped(&text) + "\n"
}

/// A row of the table of modes.
fn mode_row(found: &Identification, name: String, mode: &FoundMode, coherent: bool) -> Vec<String> {
    let half = |x: Option<f64>| HALF_INTERVAL * x.unwrap_or(0.0);
    let frequency = with_deviation(mode.frequency_hz(), half(mode.mode.frequency_std_hz()));
    let damping = mode.damping_ratio().map_or("–".to_string(), |d| {
        with_deviation(100.0 * d, 100.0 * half(mode.mode.damping_std()))
    });
    let mut row = vec![name, frequency, damping];
    if coherent {
        let responses = found.responses.as_ref();
        let coherence = responses.and_then(|r| coherence_at(r, mode.frequency_hz()));
        row.push(coherence.map_or("–".to_string(), |c| format!("{c:.3}")));
    }
    if found.driving_point.is_some() {
        let mass = mode.modal_mass;
        row.push(mass.map_or("–".to_string(), |m| significant(m.re.signum() * m.norm())));
    }
    row.push(note_of(found, mode));
    row
}

/// Modes whose shapes the outputs hardly tell apart.
fn alike(found: &Identification) -> String {
    /// MAC above which two shapes pass for one.
    const ALIKE: f64 = 0.9;
    let mac = super::identified::auto_mac(found);
    let mut pairs = Vec::new();
    for (i, row) in mac.iter().enumerate() {
        for (j, value) in row.iter().enumerate().skip(i + 1) {
            if *value > ALIKE {
                pairs.push(format!("{} and {} (MAC {value:.3})", i + 1, j + 1));
            }
        }
    }
    match pairs.is_empty() {
        true => String::new(),
        false => {
            wrapped(&format!(
                "the outputs hardly tell the shapes of modes {} apart",
                pairs.join(", ")
            )) + "\n"
        }
    }
}

/// Lines of running speed, apart from the modes.
fn harmonics(found: &Identification) -> String {
    /// More are counted only.
    const ROWS: usize = 20;
    if found.harmonics.is_empty() {
        return String::new();
    }
    let mut table = plain();
    table.add_row(vec!["no mode", "amplitude", "", "note"]);
    table.add_row(vec!["Hz", "0 to peak", "", ""]);
    for harmonic in found.harmonics.iter().take(ROWS) {
        let strongest = (harmonic.amplitude.iter().zip(&found.outputs))
            .max_by(|a, b| a.0.total_cmp(b.0))
            .map_or((String::new(), String::new()), |(a, output)| {
                (brief(*a), format!("{} in {}", output.unit, output.name))
            });
        let what = match harmonic.envelope_kurtosis {
            Some(kurtosis) => format!("envelope kurtosis {kurtosis:.2}: 1 of a sine, 2 of a mode"),
            None => "a sine".to_string(),
        };
        let note = match harmonic.order {
            Some(order) => format!("order {order} of the running speed"),
            None => what,
        };
        let at = significant(harmonic.frequency_hz);
        table.add_row(vec![at, strongest.0, strongest.1, note]);
    }
    super::table::right_but_last(&mut table);
    let mut text = format!("\n{}", finish(&table));
    if found.harmonics.len() > ROWS {
        text += &format!("{} more\n", found.harmonics.len() - ROWS);
    }
    text + "\n"
}

/// What decided, in a few lines.
fn evidence(found: &Identification) -> String {
    match &found.evidence {
        Evidence::Rational(fit) => {
            let last = fit.evidence.iter().rev().find(|s| !s.accepted);
            let last = last.map_or(String::new(), |step| format!("{}\n", step.words()));
            last + &left_out(found)
        }
        Evidence::Diagram(diagram) => {
            let stable = diagram
                .poles
                .iter()
                .filter(|p| p.stability == Stability::Stable)
                .count();
            let repeat = format!(
                "{stable} of {} poles of all orders repeat the order before\n",
                diagram.poles.len()
            );
            repeat + &left_out(found)
        }
        Evidence::Peaks(peaks) => peaks.peaks.iter().filter_map(peak).collect(),
        Evidence::Orders(orders) => order_table(orders) + &left_out(found),
        Evidence::Course(course) => mode_course_table::tried(course),
    }
}

/// Poles that are no modes, those of one reason together, an exponential window taken off.
fn left_out(found: &Identification) -> String {
    let decay = found.window_decay();
    let all = found.omitted();
    let mut reasons: Vec<&str> = all.iter().map(|o| o.1).collect();
    reasons.sort_unstable();
    reasons.dedup();
    let of = |reason: &str| {
        let same = all.iter().filter(|o| o.1 == reason);
        let places: Vec<String> = same
            .map(|o| brief((o.0 + decay).norm() / std::f64::consts::TAU))
            .collect();
        wrapped(&format!("no mode at {} Hz: {reason}", places.join(", "))) + "\n"
    };
    reasons.into_iter().map(of).collect()
}

/// What half power makes of a peak, or why it is no mode.
fn peak(peak: &Peak) -> Option<String> {
    let at = brief(peak.frequency_hz);
    match peak.half_power {
        _ if !peak.reason.is_empty() => {
            Some(format!("peak at {at} Hz left out: {}\n", peak.reason))
        }
        Some((f, d)) => Some(format!(
            "peak at {at} Hz by half power: {} Hz, {} %\n",
            significant(f),
            super::number::percent(d)
        )),
        None => None,
    }
}

/// Orders near the chosen one, and what the residuals tell.
fn order_table(orders: &Orders) -> String {
    let mut table = plain();
    table.add_row(vec!["model", "BIC", "AIC", "MDL", "note"]);
    let chosen = orders
        .candidates
        .iter()
        .position(|c| c.family == orders.chosen)
        .unwrap_or(0);
    let shown =
        chosen.saturating_sub(NEIGHBOURS)..(chosen + NEIGHBOURS + 1).min(orders.candidates.len());
    for candidate in &orders.candidates[shown] {
        let note = if candidate.family == orders.chosen {
            "taken"
        } else {
            ""
        };
        table.add_row(vec![
            family(candidate.family),
            format!("{:.1}", candidate.bic),
            format!("{:.1}", candidate.aic),
            format!("{:.1}", candidate.mdl),
            note.to_string(),
        ]);
    }
    let mut text = String::new();
    if !orders.candidates.is_empty() {
        super::table::right_but_last(&mut table);
        text = finish(&table);
    }
    for (what, test) in &orders.tests {
        text += &format!("residuals {what}: {}\n", chance(test.probability));
    }
    text
}

/// A probability in words.
fn chance(p: f64) -> String {
    match p < 0.001 {
        true => "p below 0.001".to_string(),
        false => format!("p = {p:.3}"),
    }
}

/// Orders shown on either side of the chosen one.
const NEIGHBOURS: usize = 3;

/// What is remarkable about a mode.
fn note_of(found: &Identification, mode: &FoundMode) -> String {
    let mut notes = Vec::new();
    if let Some(departure) = &mode.departure {
        if departure.model_error > 0.0 {
            let share = super::number::percent(departure.model_error);
            notes.push(format!("departs by {share} %"));
        }
        if departure.frequency_spread_hz > 0.0 {
            let (what, spread) = (groups(found), brief(departure.frequency_spread_hz));
            notes.push(format!("{what} differ by {spread} Hz"));
        }
    }
    notes.extend(mode.weak.map(String::from));
    if let Some(presence) = mode.presence {
        notes.push(format!("in {:.0} % of the orders", 100.0 * presence));
    }
    if let Some(order) = mode.on_order {
        notes.push(format!("on order {order} of the running speed"));
    }
    notes.join("; ")
}

/// What a mode was found from, each for itself.
fn groups(found: &Identification) -> &'static str {
    match found.hits.is_empty() {
        true => "responses",
        false => "hits",
    }
}

/// Facts of a header shown at once.
const FACTS: usize = 6;

/// A rate with the digits a time base can have.
pub fn rate(rate_hz: f64) -> String {
    if !(1.0..1e9).contains(&rate_hz) {
        return brief(rate_hz);
    }
    let text = format!("{rate_hz:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}
