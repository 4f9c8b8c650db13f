//! Transmission error of an encoder record as tables for a terminal.

use std::f64::consts::PI;

use super::number_format::{
    INTERVAL_FOOTNOTE, four_digits, interval, percent, significant, with_minus_signs,
};
use super::table::{Table, or_dash};
use super::te_lines::{arcsec, degrees, direction_name, micrometres};
use crate::base::text::pluralise;
use crate::encoder::flank::{FlankEvaluation, OrderEstimate};
use crate::encoder::index_pulses::IndexEvaluation;
use crate::numeric::sorting::{sort_ascending, sort_descending};
use crate::numeric::statistics::{Z_95, peak_to_peak};
use crate::plan::logs::attribution::Attribution;
use crate::plan::logs::encoder_analysis::EncoderResult;

/// Maximum number of orders shown for a flank.
const MAX_ROWS: usize = 24;

/// Evaluation of an encoder record: method, errors by flank, declared errors, backlash, eccentricities.
pub fn record(result: &EncoderResult, show_all: bool) -> String {
    let measured = &result.measured;
    let mut text = result
        .method_text
        .iter()
        .map(|l| format!("{l}\n"))
        .collect::<String>();
    text += &format!(
        "ratio {} from the teeth, {:.9} from the encoders\n{} rows per tooth; orders up to {} within {:.0e}; quantisation of the encoders {} arcsec rms per row\n",
        measured.tooth_ratio,
        measured.ratio.value,
        four_digits(measured.rows_per_tooth),
        four_digits(measured.band),
        measured.order_error,
        four_digits(arcsec(measured.quantisation)),
    );
    if let Some(speed) = &measured.speed {
        let (mean, min, max) = speed.range();
        let rpm = |w: f64| four_digits(w * 30.0 / PI);
        text += &format!(
            "output at {} rpm, tooth by tooth {} … {}\n",
            rpm(mean),
            rpm(min),
            rpm(max)
        );
    }
    for index in measured.index.iter().flatten() {
        text += &index_mark_text(index);
    }
    for flank in &measured.flanks {
        text += &flank_table(flank, result, show_all);
    }
    for (flank, declared) in measured.flanks.iter().zip(&result.attribution) {
        if result.attribution.len() > 1 {
            text += &format!("\n{}:\n", direction_name(flank));
        }
        text += &attribution(declared);
    }
    if let Some(play) = &measured.backlash {
        text += &format!(
            "\nplay between the flanks: {} arcsec{}\n",
            four_digits(arcsec(play.mean)),
            play.variation.as_ref().map_or(String::new(), |variation| {
                let varies = match variation.range.1 > variation.range.0 {
                    true => format!(
                        "{} … {} over the angle from the significant orders",
                        four_digits(arcsec(variation.range.0)),
                        four_digits(arcsec(variation.range.1))
                    ),
                    false => "no order of it is significant".to_string(),
                };
                let at_each = four_digits(arcsec(Z_95 * variation.deviation));
                format!(", {varies}, ± {at_each} at each angle")
            })
        );
    }
    if !result.separated.is_empty() {
        let mut table = Table::named("eccentricity on|encoder [arcsec]|gear [arcsec]|± [arcsec]");
        for p in &result.separated {
            table.row([
                p.shaft.to_string(),
                four_digits(arcsec(p.encoder)),
                four_digits(arcsec(p.gear)),
                four_digits(arcsec(Z_95 * p.deviation)),
            ]);
        }
        text += &format!("\n{}", table.text());
    }
    text += &format!("\n{INTERVAL_FOOTNOTE}");
    for limit in &result.limits {
        text += &format!("\n{limit}\n");
    }
    with_minus_signs(&text)
}

/// Description of an index evaluation.
fn index_mark_text(index: &IndexEvaluation) -> String {
    let in_degrees = |turns: f64| format!("{:.3}", 360.0 * turns);
    let apart = index
        .counts_between_passages
        .map_or(String::new(), |counts| {
            format!(", {} counts apart", significant(counts))
        });
    format!(
        "index of the {}: passed {}{apart}, {} deg from where its readings are zero; each passage ± {} deg of it\n",
        index.shaft,
        pluralise(index.passages, "time"),
        in_degrees(index.mark_angle),
        four_digits(360.0 * Z_95 * index.scatter)
    )
}

fn flank_table(flank: &FlankEvaluation, result: &EncoderResult, show_all: bool) -> String {
    let composite = &flank.composite;
    let mut text = format!(
        "\n{}: {:.3} turns of the output, ranges over {}{}\n\n",
        direction_name(flank),
        flank.turns,
        pluralise(composite.turns, "turn"),
        if composite.closed {
            ", whole hunting cycles"
        } else {
            ""
        }
    );
    let with_um = result.radius.is_some();
    let mut table = Table::new("|arcsec")
        .columns_if(with_um, "µm")
        .columns("")
        .words(&[0]);
    let mut row = |name: &str, angle: f64, note: String| {
        let mut cells = vec![name.to_string(), four_digits(arcsec(angle))];
        if let Some(um) = micrometres(result, angle) {
            cells.push(four_digits(um));
        }
        cells.push(note);
        table.row(cells);
    };
    row(
        "F_i′, whole record",
        composite.total,
        "of the readings, with quantisation and noise".into(),
    );
    row("F_i′, one turn", composite.per_rev.sliding, String::new());
    row(
        "f_i′, one pitch",
        composite.per_pitch.sliding,
        format!(
            "end to end {}",
            four_digits(arcsec(composite.per_pitch.fixed))
        ),
    );
    let orders = &flank.fitted;
    let note = |bound: f64| {
        format!(
            "± {}: from the fitted orders, without quantisation and noise",
            four_digits(arcsec(Z_95 * orders.deviation + bound))
        )
    };
    row("F_i′ of the orders", orders.total, note(orders.bound));
    row(
        "f_i′ of the orders",
        orders.per_pitch,
        note(orders.bound_by_pitch),
    );
    row(
        "long wave",
        composite.long_wave_component.0,
        format!(
            "from pitch means {}",
            four_digits(arcsec(composite.long_wave_component.1))
        ),
    );
    row(
        "short wave",
        composite.short_wave_component.0.sliding,
        format!(
            "from pitch means {}",
            four_digits(arcsec(composite.short_wave_component.1.sliding))
        ),
    );
    for mean in &flank.shaft_averages {
        row(
            &format!("mean turn of {}", mean.shaft),
            peak_to_peak(&mean.values),
            format!(
                "± {} at each angle, over {}",
                four_digits(arcsec(Z_95 * mean.standard_error)),
                pluralise(mean.revolutions, "turn")
            ),
        );
    }
    row("residual (not in the orders)", flank.noise, "rms".into());
    text += &table.text();
    text += &lines(flank, with_um, result, show_all);
    text += &dominant_order(flank);
    for u in &flank.unexplained {
        let near = u.nearest.as_ref().map_or(String::new(), |what| {
            format!("; {what} at this order, --all fits multiples of the shafts")
        });
        text += &format!(
            "unexplained: order {} ± {}, {} arcsec{near}\n",
            significant(u.order),
            four_digits(u.order_uncertainty),
            four_digits(arcsec(u.amplitude))
        );
    }
    text
}

/// Order with the largest amplitude and its share of the sum of squares.
fn dominant_order(flank: &FlankEvaluation) -> String {
    let significant = || flank.lines.iter().filter(|l| l.significant);
    let Some(dominant) = significant().max_by(|a, b| a.amplitude.total_cmp(&b.amplitude)) else {
        return "no order is significant\n".to_string();
    };
    let unexplained = flank.unexplained.iter().map(|u| u.amplitude);
    let sum: f64 = significant()
        .map(|l| l.amplitude)
        .chain(unexplained)
        .map(|a| a * a)
        .sum();
    format!(
        "dominant: order {}, {}, {} % of the sum of squares of the significant orders\n",
        dominant.order.fraction,
        dominant.order.names.join(" = "),
        percent(dominant.amplitude.powi(2) / sum)
    )
}

/// Declared errors with the measured amplitudes at their orders.
fn attribution(attribution: &Attribution) -> String {
    if attribution.sources == 0 {
        return "\nthe model declares no error between the encoders\n".to_string();
    }
    let mut table = Table::new(
        "order|declared||predicted [arcsec]|measured [arcsec]|uniform input [arcsec]|identified|95 %|of",
    );
    for row in &attribution.rows {
        for source in &row.sources {
            let in_unit = |x: f64| four_digits(source.to_display_unit(x));
            table.row([
                row.order.to_string(),
                in_unit(source.declared),
                source.display_unit().to_string(),
                four_digits(arcsec(source.output_amplitude)),
                four_digits(arcsec(row.amplitude)),
                four_digits(arcsec(row.amplitude_uniform_input)),
                or_dash(source.identified, |f| in_unit(f.0)),
                or_dash(source.identified, |(_, (low, high))| {
                    interval(source.to_display_unit(low), source.to_display_unit(high))
                }),
                source.name.clone(),
            ]);
        }
    }
    let mut text = format!(
        "\n{}\nuniform input: as measured if the input turned uniformly, as errors are transmitted\nthe record determines {} values of {} declared errors; sources that share an order are not separated\n",
        table.text(),
        attribution.rank,
        attribution.sources
    );
    if !attribution.unresolved.is_empty() {
        text += &format!(
            "above the highest order of the record: {}\n",
            attribution.unresolved.join(", ")
        );
    }
    text
}

/// Table of the significant orders, or the largest of them, by rising order.
fn lines(flank: &FlankEvaluation, with_um: bool, result: &EncoderResult, show_all: bool) -> String {
    let mut shown: Vec<&OrderEstimate> = flank
        .lines
        .iter()
        .filter(|l| show_all || l.significant)
        .collect();
    if !show_all {
        sort_descending(&mut shown, |a| a.amplitude);
        shown.truncate(MAX_ROWS);
        sort_ascending(&mut shown, |a| a.order.value);
    }
    let mut text = String::from("\n");
    if !shown.is_empty() {
        let has_mark = result.measured.index.iter().any(Option::is_some);
        let mut table = Table::new("order||amplitude [arcsec]|95 % [arcsec]")
            .columns_if(with_um, "amplitude [µm]")
            .columns("phase [deg]")
            .columns_if(has_mark, "from mark of")
            .columns("from");
        for line in shown.iter() {
            let fraction = line.order.fraction.to_string();
            let mut row = vec![
                fraction.clone(),
                if fraction.contains('/') {
                    four_digits(line.order.value)
                } else {
                    String::new()
                },
                four_digits(arcsec(line.amplitude)),
                or_dash(line.interval, |(low, high)| {
                    interval(arcsec(low), arcsec(high))
                }),
            ];
            if let Some(um) = micrometres(result, line.amplitude) {
                row.push(four_digits(um));
            }
            let phase = line.mark_phase.map_or(line.phase, |m| m.0);
            row.push(format!("{:.1}", degrees(phase)));
            if has_mark {
                row.push(line.mark_phase.map_or("–", |m| m.1).to_string());
            }
            row.push(source_text(line));
            table.row(row);
        }
        text += &table.text();
    }
    let more = flank.lines.len() - shown.len();
    if more > 0 {
        text += &format!(
            "{} more {}; --all shows them\n",
            pluralise(more, "order"),
            if shown.len() < MAX_ROWS {
                "not significant"
            } else {
                "smaller or not significant"
            }
        );
    }
    text
}

/// Sources of an order, and the sources not separable from them.
fn source_text(line: &OrderEstimate) -> String {
    let mut text = line.order.names.join(" = ");
    for source in line.unresolved() {
        text += &format!(
            "; separable from {} only after {} turns",
            source.name,
            four_digits(source.turns.ceil())
        );
    }
    text
}
