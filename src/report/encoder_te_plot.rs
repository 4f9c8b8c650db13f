//! An encoder record as a plot: the error over the angle of the output with its long wave, and its orders with their sources.

use super::axes::{draw_curve, draw_frame, linear_range};
use super::number_format::four_digits;
use super::svg::{
    Anchor, BLACK, BLUE, Canvas, Colour, GREY, LIGHT_GREY, ORANGE, Panel, Point2, WIDTH, lighten,
    render_svg, spread_labels, ticks, truncate_label, widest,
};
use super::te_lines::{arcsec, direction_name};
use crate::plan::logs::encoder_analysis::EncoderResult;
use crate::spectrum::rotation::angular_resampling::AngularSignal;
use crate::transmission::encoder::flank::FlankEvaluation;

const MARGIN_LEFT: f64 = 70.0;
const MARGIN_RIGHT: f64 = WIDTH - 24.0;
const RECORD: (f64, f64) = (64.0, 304.0);

/// Height below a panel for the numbers and the title of an axis.
const BELOW: f64 = 46.0;

/// Heights of the panels of play and of orders.
const HEIGHTS: (f64, f64) = (110.0, 200.0);

/// Offset of the second direction's lines to the right of the first's.
const DIRECTION_OFFSET: f64 = 6.0;

/// Lines that get a name.
const MAX_LABELS: usize = 14;

/// Names are cut at so many characters.
const MAX_NAME_LEN: usize = 60;

/// Size of names.
const NAME: f64 = 9.0;

/// Draws a record.
pub fn draw_record(found: &EncoderResult, title: &str) -> String {
    let play = found.measured.backlash.as_ref();
    let play = play.and_then(|p| p.variation.as_ref()).map(|c| &c.signal);
    let below = match play {
        Some(_) => RECORD.1 + BELOW + 20.0 + HEIGHTS.0 + BELOW,
        None => RECORD.1 + BELOW,
    };
    // As much room as the longest name takes upright.
    let named = (found.measured.flanks.iter().take(1)).flat_map(|f| stems(f, BLUE));
    let named: Vec<OrderStem> = strongest(named.collect());
    let names = named.iter().map(|s| truncate_label(&s.name, MAX_NAME_LEN));
    let longest = widest(names, NAME, 20.0);
    let top = below + longest + 12.0;
    let down = (top, top + HEIGHTS.1);
    render_svg(WIDTH, down.1 + BELOW + 4.0, |canvas| {
        canvas.title(title, MARGIN_LEFT);
        let flanks = &found.measured.flanks;
        let mut right = MARGIN_LEFT;
        for (flank, ink) in flanks.iter().zip([BLUE, ORANGE]) {
            for (label, ink, width) in [
                (direction_name(flank).to_string(), lighten(ink), 1.0),
                ("long wave".into(), ink, 2.0),
            ] {
                right = canvas.key_entry((right, 38.0), &label, ink, width) + 16.0;
            }
        }
        let x = turns(flanks);
        draw_te(canvas, flanks, x);
        if let Some(play) = play {
            let bottom = below - BELOW;
            draw_backlash(canvas, play, (bottom - HEIGHTS.0, bottom), x);
        }
        orders(canvas, flanks, &named, down);
    })
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

/// Play over the turns of the output.
fn draw_backlash(canvas: &mut Canvas, play: &AngularSignal, down: (f64, f64), x: (f64, f64)) {
    let Some(y) = linear_range(play.values.iter().map(|p| arcsec(*p))) else {
        return;
    };
    let panel = Panel::new((MARGIN_LEFT, MARGIN_RIGHT), down, x, y);
    panel.draw_y_grid(canvas, &ticks(y, 4));
    draw_frame(&panel, canvas, "play, arcsec", Some("turns of the output"));
    draw_curve(canvas, &panel, points(play, &play.values), BLUE, 1.4);
}

/// Turns and arc seconds of values in the cells of a signal.
fn points(cells: &AngularSignal, values: &[f64]) -> impl Iterator<Item = Point2> {
    let (first, n) = (cells.first, cells.samples_per_rev as f64);
    let each = values.iter().enumerate();
    each.map(move |(i, e)| ((first + i as i64) as f64 / n, arcsec(*e)))
}

fn draw_te(canvas: &mut Canvas, flanks: &[FlankEvaluation], x: (f64, f64)) {
    let values = flanks
        .iter()
        .flat_map(|f| f.signal.values.iter().map(|e| arcsec(*e)));
    let Some(y) = linear_range(values) else {
        return;
    };
    let panel = Panel::new((MARGIN_LEFT, MARGIN_RIGHT), RECORD, x, y);
    panel.draw_y_grid(canvas, &ticks(y, 6));
    draw_frame(
        &panel,
        canvas,
        "transmission error, arcsec",
        Some("turns of the output"),
    );
    let draw =
        |canvas: &mut Canvas, flank: &FlankEvaluation, values: &[f64], ink: Colour, width: f64| {
            draw_curve(canvas, &panel, points(&flank.signal, values), ink, width);
        };
    for (flank, ink) in flanks.iter().zip([BLUE, ORANGE]) {
        draw(canvas, flank, &flank.signal.values, lighten(ink), 0.6);
    }
    for (flank, ink) in flanks.iter().zip([BLUE, ORANGE]) {
        draw(canvas, flank, &flank.composite.long_wave, ink, 1.6);
    }
}

/// Drawn order line: place, amplitude, its uncertainty, its name, and whether it has an attributed source.
struct OrderStem {
    order: f64,
    size: f64,
    interval: Option<(f64, f64)>,
    name: String,
    ink: Colour,
}

/// Significant lines of a flank.
fn stems(flank: &FlankEvaluation, ink: Colour) -> impl Iterator<Item = OrderStem> {
    let lines = flank
        .lines
        .iter()
        .filter(|l| l.significant)
        .map(move |l| OrderStem {
            order: l.order.value,
            size: arcsec(l.amplitude),
            interval: l.interval.map(|(a, b)| (arcsec(a), arcsec(b))),
            name: format!("{} {}", l.order.fraction, with_others(&l.order.names)),
            ink,
        });
    let others = flank.unexplained.iter().map(|u| OrderStem {
        order: u.order,
        size: arcsec(u.amplitude),
        interval: None,
        name: format!("{} unexplained", four_digits(u.order)),
        ink: GREY,
    });
    lines.chain(others)
}

/// Both directions; of the one with more turns the strongest have names.
fn orders(
    canvas: &mut Canvas,
    flanks: &[FlankEvaluation],
    strongest: &[OrderStem],
    down: (f64, f64),
) {
    let named: Vec<OrderStem> = (flanks.iter().take(1))
        .flat_map(|f| stems(f, BLUE))
        .collect();
    let other: Vec<OrderStem> = (flanks.iter().skip(1))
        .flat_map(|f| stems(f, ORANGE))
        .collect();
    let all = || named.iter().chain(&other);
    let Some((_, top)) = linear_range(
        all()
            .map(|s| s.interval.map_or(s.size, |i| i.1))
            .chain([0.0]),
    ) else {
        return;
    };
    let last = all().map(|s| s.order).fold(1.0, f64::max);
    // Orders from 1 to hundreds share the axis by their logarithm.
    let first = all().map(|s| s.order).fold(1.0, f64::min);
    let place = |order: f64| order.log10();
    let panel = Panel::new(
        (MARGIN_LEFT, MARGIN_RIGHT),
        down,
        (place(first) - 0.08, place(last) + 0.08),
        (0.0, top),
    );
    panel.draw_y_grid(canvas, &ticks(panel.y, 5));
    rule_orders(canvas, &panel);
    panel.draw_outline(canvas);
    panel.draw_y_name(canvas, "amplitude, arcsec");
    panel.draw_x_name(canvas, "order per turn of the output", 30.0);
    let beside =
        (named.iter().map(|s| (s, 0.0))).chain(other.iter().map(|s| (s, DIRECTION_OFFSET)));
    for (stem, right) in beside {
        let at = |size: f64| {
            let spot = panel.to_canvas(place(stem.order), size);
            (spot.0 + right, spot.1)
        };
        canvas.line(at(0.0), at(stem.size), stem.ink, 1.4);
        canvas.fill_circle(at(stem.size), 2.2, stem.ink);
        if let Some((low, high)) = stem.interval {
            let spots: [Point2; 2] = [low, high].map(at);
            canvas.line(
                (spots[0].0 + 3.0, spots[0].1),
                (spots[1].0 + 3.0, spots[1].1),
                BLACK,
                0.8,
            );
        }
    }
    names(canvas, &panel, strongest, place);
}

/// The first of the sources that share an order, and how many more.
fn with_others(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [first, others @ ..] => format!("{first} and {} more", others.len()),
    }
}

/// Those that get a name.
fn strongest(mut stems: Vec<OrderStem>) -> Vec<OrderStem> {
    stems.sort_by(|a, b| b.size.total_cmp(&a.size));
    stems.truncate(MAX_LABELS);
    stems
}

/// Names, upright above the panel.
fn names(canvas: &mut Canvas, panel: &Panel, strongest: &[OrderStem], place: impl Fn(f64) -> f64) {
    const SPACING: f64 = 12.0;
    let wanted: Vec<f64> = strongest
        .iter()
        .map(|s| panel.canvas_x(place(s.order)))
        .collect();
    for (stem, right) in strongest
        .iter()
        .zip(spread_labels(&wanted, SPACING, panel.across))
    {
        let head = panel.to_canvas(place(stem.order), stem.size);
        let ink = if stem.ink == GREY { GREY } else { BLACK };
        canvas.line(
            (right, panel.down.0 - 4.0),
            (head.0, head.1 - 3.0),
            LIGHT_GREY,
            0.7,
        );
        canvas.vertical_text(
            &truncate_label(&stem.name, MAX_NAME_LEN),
            (right, panel.down.0 - 7.0),
            NAME,
            ink,
            Anchor::Start,
        );
    }
}

/// Grid and numbers 1, 2, 5, 10, … of the orders.
fn rule_orders(canvas: &mut Canvas, panel: &Panel) {
    let decades = panel.x.0.floor() as i32..=panel.x.1.ceil() as i32;
    for order in decades.flat_map(|d| [1.0, 2.0, 5.0].map(|m| m * 10f64.powi(d))) {
        let at = order.log10();
        if (panel.x.0..=panel.x.1).contains(&at) {
            panel.draw_x_mark(canvas, at, &four_digits(order));
        }
    }
}
