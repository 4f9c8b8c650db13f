//! Pictures of a transmission error: lines by order with their sources, the budget by element, lines over speed.

use super::axes::{decades, frame, rule_decades};
use super::map_picture::{colours, ink, step_of};
use super::number::{brief, percent};
use super::style::{
    Anchor, BLACK, BLUE, FAINT, GREY, ORANGE, Panel, SMALL, TITLE, WIDTH, paler, picture,
    push_apart, shortened, ticks, width_of,
};
use super::transmission::{Unit, cause, source};
use crate::machine::parts::Machine;
use crate::plan::transmission::run::{Answer, Map, Row};

const LEFT: f64 = 70.0;

/// Orders with a name.
const NAMED: usize = 28;

/// Of the largest line: smaller ones are not drawn.
const DRAWN: f64 = 1e-5;

/// Of the worst case: lines below this have no size of their own to which speed could be compared.
const COUNTS: f64 = 1e-9;

/// Every picture with the word its file name ends in.
pub fn all(title: &str, machine: &Machine, answer: &Answer) -> Vec<(&'static str, String)> {
    let title = &titled(title, machine, answer);
    let mut all = vec![
        ("", lines(title, machine, answer)),
        ("budget", budget(title, answer, Unit::of(machine, answer))),
    ];
    if let Some(map) = &answer.map {
        all.push(("speeds", speeds(title, machine, answer, map)));
    }
    all
}

/// The model and whose error is shown: `Y2250: work_spindle driven by motor`.
fn titled(title: &str, machine: &Machine, answer: &Answer) -> String {
    const LONGEST: usize = 120;
    let name = |freedom: usize| machine.nodes[machine.freedoms[freedom].node].name.as_str();
    let ends = &answer.chain.ends;
    let against = ends
        .against
        .map_or(String::new(), |a| format!(", against {}", name(a)));
    let whose = format!(
        "{} driven by {}{against}",
        name(ends.output),
        name(ends.driver)
    );
    let room = LONGEST.saturating_sub(whose.chars().count() + 2).max(20);
    format!("{}: {whose}", shortened(title, room))
}

/// Rows by falling amplitude, those without one left out.
fn largest(answer: &Answer) -> Vec<usize> {
    let size = |k: usize| answer.slow(&answer.rows[k]).norm();
    let mut order: Vec<usize> = (0..answer.rows.len()).filter(|&k| size(k) > 0.0).collect();
    order.sort_by(|&a, &b| size(b).total_cmp(&size(a)));
    order
}

/// The largest line of each order, with the others behind it; the orders with the largest, ascending.
fn orders(answer: &Answer, size: impl Fn(usize) -> f64) -> Vec<Vec<usize>> {
    let all: Vec<usize> = (0..answer.rows.len()).filter(|&k| size(k) > 0.0).collect();
    let mut groups: Vec<Vec<usize>> = all
        .chunk_by(|&a, &b| answer.rows[a].line.order == answer.rows[b].line.order)
        .map(|group| {
            let mut group = group.to_vec();
            group.sort_by(|&a, &b| size(b).total_cmp(&size(a)));
            group
        })
        .collect();
    groups.sort_by(|a, b| size(b[0]).total_cmp(&size(a[0])));
    groups.truncate(NAMED);
    groups.sort_by_key(|group| group[0]);
    groups
}

/// Amplitudes over orders, the largest with their sources.
fn lines(title: &str, machine: &Machine, answer: &Answer) -> String {
    const HIGH: f64 = 340.0;
    /// Height of the letters of names.
    const NAME: f64 = 9.0;
    let unit = Unit::of(machine, answer);
    let order = largest(answer);
    let size = |k: usize| answer.slow(&answer.rows[k]).norm() * unit.times;
    let least = order.first().map_or(0.0, |&k| DRAWN * size(k));
    let amplitude = |k: usize| if size(k) < least { 0.0 } else { size(k) };
    let order: Vec<usize> = order.into_iter().filter(|&k| amplitude(k) > 0.0).collect();
    let place = |k: usize| answer.rows[k].line.order.value().log10();
    let groups = orders(answer, amplitude);
    let names: Vec<String> = groups
        .iter()
        .map(|group| named(machine, answer, group))
        .collect();
    let longest = names
        .iter()
        .map(|name| width_of(name, NAME))
        .fold(0.0, f64::max);
    let top = 44.0 + longest;
    picture(WIDTH, top + HIGH + 50.0, |canvas| {
        canvas.text(title, (LEFT, 16.0), TITLE, BLACK, Anchor::Start);
        let Some(y) = decades(order.iter().map(|&k| amplitude(k))) else {
            canvas.text("no line", (WIDTH / 2.0, top), TITLE, GREY, Anchor::Middle);
            return;
        };
        let ends = order
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &k| {
                (l.min(place(k)), h.max(place(k)))
            });
        let panel = Panel {
            across: (LEFT, WIDTH - 24.0),
            down: (top, top + HIGH),
            x: (ends.0 - 0.15, ends.1 + 0.15),
            y,
        };
        rule_decades(&panel, canvas);
        let beside = format!("amplitude at the output, {}", unit.name);
        frame(&panel, canvas, &beside, None);
        for decade in panel.x.0.ceil() as i32..=panel.x.1.floor() as i32 {
            let right = panel.right_of(f64::from(decade));
            canvas.line((right, top), (right, top + HIGH), FAINT, 0.5);
            canvas.text(
                &brief(10f64.powi(decade)),
                (right, top + HIGH + 12.0),
                SMALL,
                BLACK,
                Anchor::Middle,
            );
        }
        let per = machine.freedoms[answer.chain.per].node;
        let below = format!("order, cycles per turn of {}", machine.nodes[per].name);
        canvas.text(
            &below,
            (0.5 * (LEFT + WIDTH - 24.0), top + HIGH + 34.0),
            SMALL,
            BLACK,
            Anchor::Middle,
        );
        for &k in &order {
            let head = panel.at(place(k), amplitude(k).log10());
            canvas.line((head.0, top + HIGH), head, BLUE, 1.6);
            canvas.disc(head, 2.2, BLUE);
        }
        // Names by rising order; lines of one order share that of the largest.
        let wanted: Vec<f64> = groups.iter().map(|g| panel.right_of(place(g[0]))).collect();
        let spread = push_apart(&wanted, 15.0, (LEFT + 4.0, WIDTH - 28.0));
        for ((group, name), right) in groups.iter().zip(&names).zip(spread) {
            let first = group[0];
            let spot = panel.at(
                place(first),
                group
                    .iter()
                    .map(|&k| amplitude(k))
                    .fold(0.0, f64::max)
                    .log10(),
            );
            canvas.line((right, top - 6.0), (spot.0, spot.1 - 4.0), FAINT, 0.7);
            canvas.upright(name, (right, top - 9.0), NAME, BLACK, Anchor::Start);
        }
    })
}

/// An order with the largest of its sources.
fn named(machine: &Machine, answer: &Answer, group: &[usize]) -> String {
    let more = match group.len() {
        1 => String::new(),
        n => format!(" and {} more", n - 1),
    };
    shortened(&(of_row(machine, &answer.rows[group[0]]) + &more), 90)
}

/// An order, its source and its cause.
fn of_row(machine: &Machine, row: &Row) -> String {
    format!(
        "{}: {}, {}",
        brief(row.line.order.value()),
        source(machine, row),
        cause(machine, row)
    )
}

/// Shares of the sum of squares by element.
fn budget(title: &str, answer: &Answer, unit: Unit) -> String {
    const ROW: f64 = 20.0;
    const TOP: f64 = 64.0;
    const MOST: usize = 20;
    let found = &answer.budget.elements;
    let mut order: Vec<usize> = (0..found.len()).filter(|&e| found[e].share > 0.0).collect();
    order.sort_by(|&a, &b| found[b].share.total_cmp(&found[a].share));
    let hidden: f64 = order.iter().skip(MOST).map(|&e| found[e].share).sum();
    order.truncate(MOST);
    let height = TOP + ROW * order.len() as f64 + 40.0;
    picture(WIDTH, height, |canvas| {
        canvas.text(title, (LEFT, 16.0), TITLE, BLACK, Anchor::Start);
        let sums = format!(
            "share of the sum of squares; root {} {unit}, worst case {} {unit}",
            brief(answer.budget.rss * unit.times),
            brief(answer.budget.worst_case * unit.times),
            unit = unit.name
        );
        canvas.text(&sums, (LEFT, 38.0), SMALL, BLACK, Anchor::Start);
        let names: Vec<String> = order
            .iter()
            .map(|&e| shortened(&answer.elements[e], 28))
            .collect();
        let widest = names
            .iter()
            .map(|name| width_of(name, SMALL))
            .fold(60.0, f64::max);
        let (left, right) = (24.0 + widest, WIDTH - 350.0);
        let full = order.first().map_or(1.0, |&e| found[e].share);
        for (row, (&e, name)) in order.iter().zip(&names).enumerate() {
            let middle = TOP + ROW * (row as f64 + 0.5);
            canvas.text(name, (left - 8.0, middle), SMALL, BLACK, Anchor::End);
            let end = left + (right - left) * found[e].share / full;
            canvas.block(
                (left, middle - 7.0),
                (end, middle + 7.0),
                if row == 0 { ORANGE } else { paler(BLUE) },
            );
            let text = format!(
                "{} %: {}without it {} % off",
                percent(found[e].share),
                found[e].one_grade.map_or(String::new(), |better| {
                    format!("one grade better {} % off, ", percent(better))
                }),
                percent(found[e].without)
            );
            canvas.text(&text, (end + 6.0, middle), SMALL, BLACK, Anchor::Start);
        }
        if hidden > 0.0 {
            let text = format!("{} % in smaller ones", percent(hidden));
            canvas.text(&text, (left, height - 20.0), SMALL, GREY, Anchor::Start);
        }
    })
}

/// The node whose speed counts.
fn whose_speed(machine: &Machine) -> &str {
    let stated = machine.speeds.first().map(|s| machine.freedoms[s.0].node);
    stated.map_or("the driver", |node| machine.nodes[node].name.as_str())
}

/// What speed makes of the largest line of each order, in dB of what it is slowly; beside the names how large it is slowly and at most.
fn speeds(title: &str, machine: &Machine, answer: &Answer, map: &Map) -> String {
    const ROW: f64 = 17.0;
    const TOP: f64 = 52.0;
    const RIGHT: f64 = WIDTH - 96.0;
    let most = |k: usize| map.amplitudes[k].iter().fold(0.0f64, |m, a| m.max(*a));
    let still = |k: usize| answer.rows[k].loaded.norm() > COUNTS * answer.budget.worst_case;
    let groups = orders(answer, |k| if still(k) { most(k) } else { 0.0 });
    let shown: Vec<usize> = groups.iter().map(|group| group[0]).collect();
    let height = TOP + ROW * shown.len() as f64;
    let unit = Unit::of(machine, answer);
    let sizes = |k: usize| {
        let (slow, most) = (answer.rows[k].loaded.norm(), map.largest[k].1);
        let [slow, most] = [slow, most].map(|x| brief(x * unit.times));
        format!("{slow} slowly, {most} at most")
    };
    let level = |k: usize, s: usize| {
        20.0 * (map.amplitudes[k][s] / answer.rows[k].loaded.norm().max(f64::MIN_POSITIVE)).log10()
    };
    picture(WIDTH, height + 54.0, |canvas| {
        canvas.text(title, (LEFT, 16.0), TITLE, BLACK, Anchor::Start);
        let levels = shown
            .iter()
            .flat_map(|&k| (0..map.speeds.len()).map(move |s| (k, s)));
        let most = levels
            .map(|(k, s)| level(k, s))
            .filter(|x| x.is_finite())
            .fold(6.0f64, |m, x| m.max(x.abs()));
        let scale = (-most.min(40.0), most.min(40.0));
        let names: Vec<String> = shown
            .iter()
            .map(|&k| {
                format!(
                    "{}: {}",
                    shortened(&of_row(machine, &answer.rows[k]), 40),
                    sizes(k)
                )
            })
            .collect();
        let head = format!("order: source, cause, {} at the output", unit.name);
        let left = 16.0
            + names
                .iter()
                .map(|name| width_of(name, 9.0))
                .fold(60.0, f64::max);
        canvas.text(&head, (left - 6.0, TOP - 9.0), 9.0, GREY, Anchor::End);
        let rpm: Vec<f64> = map
            .speeds
            .iter()
            .map(|s| s * 30.0 / std::f64::consts::PI)
            .collect();
        let half = 0.5 * (rpm[1] - rpm[0]);
        let panel = Panel {
            across: (left, RIGHT),
            down: (TOP, height),
            x: (rpm[0] - half, rpm[rpm.len() - 1] + half),
            y: (0.0, 1.0),
        };
        for (row, (&k, name)) in shown.iter().zip(&names).enumerate() {
            let (up, down) = (TOP + ROW * row as f64, TOP + ROW * (row as f64 + 1.0));
            canvas.text(
                name,
                (left - 6.0, 0.5 * (up + down)),
                9.0,
                BLACK,
                Anchor::End,
            );
            for (s, speed) in rpm.iter().enumerate() {
                let across = (
                    panel.right_of(speed - half),
                    (panel.right_of(speed + half) + 1.0).min(RIGHT),
                );
                canvas.block(
                    (across.0, down - 1.0),
                    (across.1, up),
                    ink(step_of(level(k, s), scale)),
                );
            }
        }
        for tick in ticks(panel.x, 8) {
            let right = panel.right_of(tick);
            canvas.text(
                &brief(tick),
                (right, height + 12.0),
                SMALL,
                BLACK,
                Anchor::Middle,
            );
        }
        let middle = 0.5 * (left + RIGHT);
        canvas.text(
            &format!("speed of {}, rpm", whose_speed(machine)),
            (middle, height + 34.0),
            SMALL,
            BLACK,
            Anchor::Middle,
        );
        colours(canvas, (TOP, height), scale, "at speed over slowly, dB");
    })
}
