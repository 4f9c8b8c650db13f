//! An encoder record as a picture: the error over the angle of the output with its long wave, and its orders with their sources.

use super::axes::{frame, runs, span};
use super::encoders::{arcsec, way};
use super::number::brief;
use super::style::{
    Anchor, BLACK, BLUE, Canvas, FAINT, GREY, Ink, ORANGE, Panel, SMALL, Spot, Stroke, TITLE,
    WIDTH, paler, picture, push_apart, shortened, ticks, width_of,
};
use crate::plan::logs::encoders::EncoderRecord;
use crate::spectrum::rotation::angular::AngularSignal;
use crate::transmission::measured::flank::Flank;

const LEFT: f64 = 70.0;
const RIGHT: f64 = WIDTH - 24.0;
const RECORD: (f64, f64) = (64.0, 304.0);

/// What the numbers and the title of an axis take below a panel.
const BELOW: f64 = 46.0;

/// Heights of the panels of play and of orders.
const HEIGHTS: (f64, f64) = (110.0, 200.0);

/// The second direction's lines stand so far to the right of the first's.
const BESIDE: f64 = 6.0;

/// Lines that get a name.
const NAMED: usize = 14;

/// Names are cut at so many characters.
const LONGEST: usize = 60;

/// Size of names.
const NAME: f64 = 9.0;

/// Draws a record.
pub fn record(found: &EncoderRecord, title: &str) -> String {
    let play = found.measured.play.as_ref();
    let play = play.and_then(|p| p.course.as_ref()).map(|c| &c.signal);
    let below = match play {
        Some(_) => RECORD.1 + BELOW + 20.0 + HEIGHTS.0 + BELOW,
        None => RECORD.1 + BELOW,
    };
    // As much room as the longest name takes upright.
    let named = (found.measured.flanks.iter().take(1)).flat_map(|f| stems(f, BLUE));
    let named: Vec<Stem> = strongest(named.collect());
    let longest = named
        .iter()
        .map(|s| width_of(&shortened(&s.name, LONGEST), NAME))
        .fold(20.0, f64::max);
    let top = below + longest + 12.0;
    let down = (top, top + HEIGHTS.1);
    picture(WIDTH, down.1 + BELOW + 4.0, |canvas| {
        canvas.text(title, (LEFT, 16.0), TITLE, BLACK, Anchor::Start);
        let flanks = &found.measured.flanks;
        let mut right = LEFT;
        for (flank, ink) in flanks.iter().zip([BLUE, ORANGE]) {
            for (label, ink, width) in [
                (way(flank).to_string(), paler(ink), 1.0),
                ("long wave".into(), ink, 2.0),
            ] {
                canvas.line((right, 38.0), (right + 18.0, 38.0), ink, width);
                canvas.text(&label, (right + 23.0, 38.0), SMALL, BLACK, Anchor::Start);
                right += 39.0 + width_of(&label, SMALL);
            }
        }
        let x = turns(flanks);
        over_angle(canvas, flanks, x);
        if let Some(play) = play {
            let bottom = below - BELOW;
            over_turns(canvas, play, (bottom - HEIGHTS.0, bottom), x);
        }
        orders(canvas, flanks, &named, down);
    })
}

/// The turns that the record covers, from and to.
fn turns(flanks: &[Flank]) -> (f64, f64) {
    let ends = |flank: &Flank| {
        let n = flank.signal.per_turn as f64;
        let first = flank.signal.first as f64 / n;
        (first, first + flank.signal.values.len() as f64 / n)
    };
    let all = flanks.iter().map(ends);
    all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), e| {
        (l.min(e.0), h.max(e.1))
    })
}

/// Play over the turns of the output.
fn over_turns(canvas: &mut Canvas, play: &AngularSignal, down: (f64, f64), x: (f64, f64)) {
    let Some(y) = span(play.values.iter().map(|p| arcsec(*p))) else {
        return;
    };
    let panel = Panel {
        across: (LEFT, RIGHT),
        down,
        x,
        y,
    };
    panel.rule_y(canvas, &ticks(y, 4));
    frame(&panel, canvas, "play, arcsec", Some("turns of the output"));
    for run in runs(&panel, points(play, &play.values)) {
        canvas.path(&run, BLUE, 1.4, Stroke::Solid);
    }
}

/// Turns and arc seconds of values in the cells of a signal.
fn points(cells: &AngularSignal, values: &[f64]) -> impl Iterator<Item = Spot> {
    let (first, n) = (cells.first, cells.per_turn as f64);
    let each = values.iter().enumerate();
    each.map(move |(i, e)| ((first + i as i64) as f64 / n, arcsec(*e)))
}

fn over_angle(canvas: &mut Canvas, flanks: &[Flank], x: (f64, f64)) {
    let values = flanks
        .iter()
        .flat_map(|f| f.signal.values.iter().map(|e| arcsec(*e)));
    let Some(y) = span(values) else { return };
    let panel = Panel {
        across: (LEFT, RIGHT),
        down: RECORD,
        x,
        y,
    };
    panel.rule_y(canvas, &ticks(y, 6));
    frame(
        &panel,
        canvas,
        "transmission error, arcsec",
        Some("turns of the output"),
    );
    let draw = |canvas: &mut Canvas, flank: &Flank, values: &[f64], ink: Ink, width: f64| {
        for run in runs(&panel, points(&flank.signal, values)) {
            canvas.path(&run, ink, width, Stroke::Solid);
        }
    };
    for (flank, ink) in flanks.iter().zip([BLUE, ORANGE]) {
        draw(canvas, flank, &flank.signal.values, paler(ink), 0.6);
    }
    for (flank, ink) in flanks.iter().zip([BLUE, ORANGE]) {
        draw(canvas, flank, &flank.composite.long_wave, ink, 1.6);
    }
}

/// What is drawn of an order: place, amplitude, how far it may be off, its name, and whether anything explains it.
struct Stem {
    order: f64,
    size: f64,
    interval: Option<(f64, f64)>,
    name: String,
    ink: Ink,
}

/// The lines of a flank that stand out.
fn stems(flank: &Flank, ink: Ink) -> impl Iterator<Item = Stem> {
    let lines = flank
        .lines
        .iter()
        .filter(|l| l.significant)
        .map(move |l| Stem {
            order: l.order.value,
            size: arcsec(l.amplitude),
            interval: l.interval.map(|(a, b)| (arcsec(a), arcsec(b))),
            name: format!("{} {}", l.order.exact, with_others(&l.order.names)),
            ink,
        });
    let others = flank.unexplained.iter().map(|u| Stem {
        order: u.order,
        size: arcsec(u.amplitude),
        interval: None,
        name: format!("{} unexplained", brief(u.order)),
        ink: GREY,
    });
    lines.chain(others)
}

/// Both directions; of the one with more turns the strongest have names.
fn orders(canvas: &mut Canvas, flanks: &[Flank], strongest: &[Stem], down: (f64, f64)) {
    let named: Vec<Stem> = (flanks.iter().take(1))
        .flat_map(|f| stems(f, BLUE))
        .collect();
    let other: Vec<Stem> = (flanks.iter().skip(1))
        .flat_map(|f| stems(f, ORANGE))
        .collect();
    let all = || named.iter().chain(&other);
    let Some((_, top)) = span(
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
    let panel = Panel {
        across: (LEFT, RIGHT),
        down,
        x: (place(first) - 0.08, place(last) + 0.08),
        y: (0.0, top),
    };
    panel.rule_y(canvas, &ticks(panel.y, 5));
    rule_orders(canvas, &panel);
    canvas.frame((LEFT, down.0), (RIGHT, down.1), GREY, 0.6);
    let middle = 0.5 * (down.0 + down.1);
    canvas.upright(
        "amplitude, arcsec",
        (14.0, middle),
        SMALL,
        BLACK,
        Anchor::Middle,
    );
    let below = (0.5 * (LEFT + RIGHT), down.1 + 30.0);
    canvas.text(
        "order per turn of the output",
        below,
        SMALL,
        BLACK,
        Anchor::Middle,
    );
    let beside = (named.iter().map(|s| (s, 0.0))).chain(other.iter().map(|s| (s, BESIDE)));
    for (stem, right) in beside {
        let at = |size: f64| {
            let spot = panel.at(place(stem.order), size);
            (spot.0 + right, spot.1)
        };
        canvas.line(at(0.0), at(stem.size), stem.ink, 1.4);
        canvas.disc(at(stem.size), 2.2, stem.ink);
        if let Some((low, high)) = stem.interval {
            let spots: [Spot; 2] = [low, high].map(at);
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
fn strongest(mut stems: Vec<Stem>) -> Vec<Stem> {
    stems.sort_by(|a, b| b.size.total_cmp(&a.size));
    stems.truncate(NAMED);
    stems
}

/// Names, upright above the panel.
fn names(canvas: &mut Canvas, panel: &Panel, strongest: &[Stem], place: impl Fn(f64) -> f64) {
    const APART: f64 = 12.0;
    let wanted: Vec<f64> = strongest
        .iter()
        .map(|s| panel.right_of(place(s.order)))
        .collect();
    for (stem, right) in strongest
        .iter()
        .zip(push_apart(&wanted, APART, panel.across))
    {
        let head = panel.at(place(stem.order), stem.size);
        let ink = if stem.ink == GREY { GREY } else { BLACK };
        canvas.line(
            (right, panel.down.0 - 4.0),
            (head.0, head.1 - 3.0),
            FAINT,
            0.7,
        );
        canvas.upright(
            &shortened(&stem.name, LONGEST),
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
        if at < panel.x.0 || at > panel.x.1 {
            continue;
        }
        let right = panel.right_of(at);
        canvas.line((right, panel.down.0), (right, panel.down.1), FAINT, 0.5);
        canvas.text(
            &brief(order),
            (right, panel.down.1 + 11.0),
            SMALL,
            BLACK,
            Anchor::Middle,
        );
    }
}
