//! An encoder record as a figure: the error over the angle of the output with its long wave, the backlash, and its orders with their sources.

use super::axes::linear_range;
use super::figure::{Axis, Curve, GREY_INK, Ink, Mark, Plot, PlotColumn, PointLabel};
use super::number_format::four_digits;
use super::svg::{LineStyle, truncate_label};
use super::te_lines::{arcsec, direction_name};
use crate::encoder::flank::FlankEvaluation;
use crate::numeric::sorting::sort_descending;
use crate::plan::logs::encoder_analysis::EncoderResult;
use crate::spectrum::rotation::angular_resampling::AngularSignal;

/// Lines that get a name.
const MAX_LABELS: usize = 14;

/// Names are cut at so many characters.
const MAX_NAME_LEN: usize = 60;

/// The figure of a record.
pub fn record(found: &EncoderResult, title: &str) -> PlotColumn {
    let flanks = &found.measured.flanks;
    let turns = || Axis::linear("turns of the output").over(turns(flanks).0, turns(flanks).1);
    let backlash = found.measured.backlash.as_ref();
    let backlash = backlash.and_then(|b| b.variation.as_ref()).map(|v| Plot {
        height: 110.0,
        curves: vec![curve("", Ink::Series(0), 1.4, &v.signal, &v.signal.values)],
        ..Plot::new(turns(), Axis::linear("play, arcsec"))
    });
    let te = Plot {
        height: 240.0,
        curves: te_curves(flanks),
        ..Plot::new(turns(), Axis::linear("transmission error, arcsec"))
    };
    PlotColumn {
        title: title.to_string(),
        plots: [Some(te), backlash, Some(orders(flanks))]
            .into_iter()
            .flatten()
            .collect(),
        ..PlotColumn::default()
    }
}

/// The turns that the record covers, from and to.
fn turns(flanks: &[FlankEvaluation]) -> (f64, f64) {
    let ends = |flank: &FlankEvaluation| {
        let n = flank.signal.samples_per_rev as f64;
        let first = flank.signal.first as f64 / n;
        (first, first + flank.signal.values.len() as f64 / n)
    };
    let all = flanks.iter().map(ends);
    all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), e| {
        (l.min(e.0), h.max(e.1))
    })
}

/// Values in the cells of a signal over the turns of the output, arcsec.
fn curve(name: &str, ink: Ink, width: f64, cells: &AngularSignal, values: &[f64]) -> Curve {
    let (first, n) = (cells.first, cells.samples_per_rev as f64);
    let turns = (0..values.len())
        .map(|i| (first + i as i64) as f64 / n)
        .collect();
    let mark = Mark::Line(width, LineStyle::Solid);
    Curve::new(
        name,
        ink,
        mark,
        turns,
        values.iter().map(|e| arcsec(*e)).collect(),
    )
}

/// The error of each direction, and its long wave in front.
fn te_curves(flanks: &[FlankEvaluation]) -> Vec<Curve> {
    let all = || flanks.iter().take(2).enumerate();
    let records = all().map(|(k, f)| {
        curve(
            direction_name(f),
            Ink::Pale(k),
            0.6,
            &f.signal,
            &f.signal.values,
        )
    });
    let waves = all().map(|(k, f)| {
        let name = format!("{}, long wave", direction_name(f));
        curve(
            &name,
            Ink::Series(k),
            1.6,
            &f.signal,
            &f.composite.long_wave,
        )
    });
    records.chain(waves).collect()
}

/// Order line: place, amplitude, its interval, its name.
struct OrderStem {
    order: f64,
    size: f64,
    interval: Option<(f64, f64)>,
    name: String,
}

/// Significant lines of a flank, and the unexplained ones.
fn stems(flank: &FlankEvaluation) -> [Vec<OrderStem>; 2] {
    let lines = flank.lines.iter().filter(|l| l.significant);
    let lines = lines.map(|l| OrderStem {
        order: l.order.value,
        size: arcsec(l.amplitude),
        interval: l.interval.map(|(a, b)| (arcsec(a), arcsec(b))),
        name: format!("{} {}", l.order.fraction, with_others(&l.order.names)),
    });
    let others = flank.unexplained.iter().map(|u| OrderStem {
        order: u.order,
        size: arcsec(u.amplitude),
        interval: None,
        name: format!("{} unexplained", four_digits(u.order)),
    });
    [lines.collect(), others.collect()]
}

/// The orders of both directions; of the one with more turns the strongest have names.
fn orders(flanks: &[FlankEvaluation]) -> Plot {
    let all: Vec<[Vec<OrderStem>; 2]> = flanks.iter().take(2).map(stems).collect();
    let each = || all.iter().flatten().flatten();
    let largest = each().map(|s| s.interval.map_or(s.size, |i| i.1));
    // Orders from 1 to hundreds share the axis by their logarithm.
    let ends = each()
        .map(|s| s.order)
        .fold((1.0f64, 1.0f64), |(l, h), o| (l.min(o), h.max(o)));
    let stem_curve = |name: String, ink: Ink, stems: &[OrderStem]| Curve {
        interval: stems
            .iter()
            .map(|s| s.interval.unwrap_or((s.size, s.size)))
            .collect(),
        ..Curve::new(
            name,
            ink,
            Mark::Stems,
            stems.iter().map(|s| s.order).collect(),
            stems.iter().map(|s| s.size).collect(),
        )
    };
    let curves = flanks
        .iter()
        .zip(&all)
        .enumerate()
        .flat_map(|(k, (flank, [lines, others]))| {
            let known = stem_curve(
                format!("{}, orders", direction_name(flank)),
                Ink::Series(k),
                lines,
            );
            let unknown = stem_curve("unexplained".to_string(), GREY_INK, others);
            [known, unknown].into_iter().filter(|c| !c.x.is_empty())
        });
    let mut named: Vec<&OrderStem> = all.iter().take(1).flatten().flatten().collect();
    sort_descending(&mut named, |a| a.size);
    named.truncate(MAX_LABELS);
    let label = |s: &&OrderStem| PointLabel {
        x: s.order,
        y: s.size,
        text: truncate_label(&s.name, MAX_NAME_LEN),
    };
    let y = Axis {
        range: linear_range(largest.chain([0.0])).map(|(_, high)| (0.0, high)),
        ..Axis::linear("amplitude, arcsec")
    };
    Plot {
        height: 200.0,
        curves: curves.collect(),
        labels: named.iter().map(label).collect(),
        upright_labels: true,
        ..Plot::new(
            Axis::log("order per turn of the output").over(0.83 * ends.0, 1.2 * ends.1),
            y,
        )
    }
}

/// The first of the sources that share an order, and how many more.
fn with_others(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [first, others @ ..] => format!("{first} and {} more", others.len()),
    }
}
