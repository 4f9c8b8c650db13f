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
use crate::numeric::sorting::{sort_falling, sort_rising};
use crate::numeric::statistics::{Z_95, peak_to_peak};
use crate::plan::logs::attribution::Attribution;
use crate::plan::logs::encoder_analysis::EncoderResult;

/// Lines shown of a flank, the largest.
const MAX_ROWS: usize = 24;

/// Everything about a record.
pub fn record(found: &EncoderResult, all: bool) -> String {
    let measured = &found.measured;
    let mut text = found
        .method_text
        .iter()
        .map(|l| format!("{l}\n"))
        .collect::<String>();
    text += &format!(
        "ratio {} by teeth, {:.9} by the encoders\n{} rows a tooth; orders up to {} within {:.0e}; steps of the encoders {} arcsec rms a row\n",
        measured.tooth_ratio,
        measured.ratio.value,
        four_digits(measured.rows_per_tooth),
        four_digits(measured.band),
        measured.order_error,
        four_digits(arcsec(measured.quantisation)),
    );
    if let Some(speed) = &measured.speed {
        let (mean, least, most) = speed.range();
        let rpm = |w: f64| four_digits(w * 30.0 / PI);
        text += &format!(
            "output at {} rpm, tooth by tooth {} … {}\n",
            rpm(mean),
            rpm(least),
            rpm(most)
        );
    }
    for index in measured.index.iter().flatten() {
        text += &index_mark_text(index);
    }
    for flank in &measured.flanks {
        text += &flank_table(flank, found, all);
    }
    for (flank, all) in measured.flanks.iter().zip(&found.attribution) {
        if found.attribution.len() > 1 {
            text += &format!("\n{}:\n", direction_name(flank));
        }
        text += &attribution(all);
    }
    if let Some(play) = &measured.backlash {
        text += &format!(
            "\nplay between the flanks: {} arcsec{}\n",
            four_digits(arcsec(play.mean)),
            play.variation.as_ref().map_or(String::new(), |course| {
                let varies = match course.range.1 > course.range.0 {
                    true => format!(
                        "{} … {} over the angle by the significant orders",
                        four_digits(arcsec(course.range.0)),
                        four_digits(arcsec(course.range.1))
                    ),
                    false => "no order of it is significant".to_string(),
                };
                let at_each = four_digits(arcsec(Z_95 * course.deviation));
                format!(", {varies}, ± {at_each} at each angle")
            })
        );
    }
    if !found.separated.is_empty() {
        let mut table = Table::named("eccentricity on|encoder [arcsec]|gear [arcsec]|± [arcsec]");
        for p in &found.separated {
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
    for limit in &found.limits {
        text += &format!("\n{limit}\n");
    }
    with_minus_signs(&text)
}

/// Description of an index evaluation.
fn index_mark_text(index: &IndexEvaluation) -> String {
    let place = |turns: f64| format!("{:.3}", 360.0 * turns);
    let apart = index.counts_apart.map_or(String::new(), |counts| {
        format!(", {} counts apart", significant(counts))
    });
    format!(
        "index of the {}: passed {}{apart}, {} deg from where its readings are zero; each passage ± {} deg of it\n",
        index.shaft,
        pluralise(index.passages, "time"),
        place(index.mark_angle),
        four_digits(360.0 * Z_95 * index.scatter)
    )
}

fn flank_table(flank: &FlankEvaluation, found: &EncoderResult, all: bool) -> String {
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
    let with_um = found.radius.is_some();
    let mut table = Table::new("|arcsec")
        .columns_if(with_um, "µm")
        .columns("")
        .words(&[0]);
    let mut row = |name: &str, angle: f64, note: String| {
        let mut cells = vec![name.to_string(), four_digits(arcsec(angle))];
        if let Some(um) = micrometres(found, angle) {
            cells.push(four_digits(um));
        }
        cells.push(note);
        table.row(cells);
    };
    row(
        "F_i′, whole record",
        composite.total,
        "of the readings, with steps and noise".into(),
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
    let beside = |bound: f64| {
        format!(
            "± {}: what the fitted orders make, without steps of the encoders and noise",
            four_digits(arcsec(Z_95 * orders.deviation + bound))
        )
    };
    row("F_i′ of the orders", orders.total, beside(orders.bound));
    row(
        "f_i′ of the orders",
        orders.per_pitch,
        beside(orders.bound_by_pitch),
    );
    row(
        "long wave",
        composite.long_wave_component.0,
        format!(
            "by pitch means {}",
            four_digits(arcsec(composite.long_wave_component.1))
        ),
    );
    row(
        "short wave",
        composite.short_wave_component.0.sliding,
        format!(
            "by pitch means {}",
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
    text += &lines(flank, with_um, found, all);
    text += &largest(flank);
    for u in &flank.unexplained {
        let near = u.nearest.as_ref().map_or(String::new(), |what| {
            format!("; {what} lies there, --all fits multiples of the shafts")
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

/// Which line makes most of the error.
fn largest(flank: &FlankEvaluation) -> String {
    let known = || flank.lines.iter().filter(|l| l.significant);
    let Some(first) = known().max_by(|a, b| a.amplitude.total_cmp(&b.amplitude)) else {
        return "no order is significant\n".to_string();
    };
    let others = flank.unexplained.iter().map(|u| u.amplitude);
    let sum: f64 = known()
        .map(|l| l.amplitude)
        .chain(others)
        .map(|a| a * a)
        .sum();
    format!(
        "most of it: order {}, {}, {} % of the sum of squares of the significant orders\n",
        first.order.fraction,
        first.order.names.join(" = "),
        percent(first.amplitude.powi(2) / sum)
    )
}

/// Declared errors next to what the record makes of them.
fn attribution(all: &Attribution) -> String {
    if all.sources == 0 {
        return "\nthe model declares no error between the encoders\n".to_string();
    }
    let mut table = Table::new(
        "order|declared||arrives [arcsec]|measured [arcsec]|evenly [arcsec]|so it is|95 %|of",
    );
    for row in &all.rows {
        for source in &row.sources {
            let shown = |x: f64| four_digits(source.to_display_unit(x));
            table.row([
                row.order.to_string(),
                shown(source.declared),
                source.display_unit().to_string(),
                four_digits(arcsec(source.output_amplitude)),
                four_digits(arcsec(row.amplitude)),
                four_digits(arcsec(row.amplitude_uniform_input)),
                or_dash(source.identified, |f| shown(f.0)),
                or_dash(source.identified, |(_, (low, high))| {
                    interval(source.to_display_unit(low), source.to_display_unit(high))
                }),
                source.name.clone(),
            ]);
        }
    }
    let mut text = format!(
        "\n{}\nevenly: as measured if the input turned evenly, which is how errors are transmitted\nthe record determines {} values of {} declared errors; sources that share an order are not separated\n",
        table.text(),
        all.rank,
        all.sources
    );
    if !all.unresolved.is_empty() {
        text += &format!(
            "beyond the highest order of the record: {}\n",
            all.unresolved.join(", ")
        );
    }
    text
}

/// Significant lines, or the largest of them, by order.
fn lines(flank: &FlankEvaluation, with_um: bool, found: &EncoderResult, all: bool) -> String {
    let mut shown: Vec<&OrderEstimate> = flank
        .lines
        .iter()
        .filter(|l| all || l.significant)
        .collect();
    if !all {
        sort_falling(&mut shown, |a| a.amplitude);
        shown.truncate(MAX_ROWS);
        sort_rising(&mut shown, |a| a.order.value);
    }
    let mut text = String::from("\n");
    if !shown.is_empty() {
        let marked = found.measured.index.iter().any(Option::is_some);
        let mut table = Table::new("order||amplitude [arcsec]|95 % [arcsec]")
            .columns_if(with_um, "amplitude [µm]")
            .columns("phase [deg]")
            .columns_if(marked, "from mark of")
            .columns("from");
        for line in shown.iter() {
            let exact = line.order.fraction.to_string();
            let mut row = vec![
                exact.clone(),
                if exact.contains('/') {
                    four_digits(line.order.value)
                } else {
                    String::new()
                },
                four_digits(arcsec(line.amplitude)),
                or_dash(line.interval, |(low, high)| {
                    interval(arcsec(low), arcsec(high))
                }),
            ];
            if let Some(um) = micrometres(found, line.amplitude) {
                row.push(four_digits(um));
            }
            let phase = line.mark_phase.map_or(line.phase, |m| m.0);
            row.push(format!("{:.1}", degrees(phase)));
            if marked {
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
                "not clear of the noise"
            } else {
                "smaller or not clear of the noise"
            }
        );
    }
    text
}

/// Sources of a line, and those indistinguishable from them.
fn source_text(line: &OrderEstimate) -> String {
    let mut text = line.order.names.join(" = ");
    for near in line.unresolved() {
        text += &format!(
            "; separable from {} only after {} turns",
            near.name,
            four_digits(near.turns.ceil())
        );
    }
    text
}
