//! Plots of a transmission error: lines by order with their sources, the budget by element, lines over speed.

use std::sync::Arc;

use super::figure::{Axis, Curve, Figure, Ink, Mark, Plot, PlotColumn, PointLabel};
use super::gear_cut_plot::{FlankMap, draw_maps};
use super::heatmap::{draw_colour_bar, ink, step_of};
use super::number_format::{four_digits, percent};
use super::svg::{
    Anchor, BLACK, BLUE, GREY, LABEL_SIZE, ORANGE, Panel, WIDTH, lighten, render_svg, ticks,
    truncate_label, widest,
};
use super::te_lines::TeUnit;
use super::work::work_flank_name;
use crate::machine::components::Machine;
use crate::numeric::sorting::sort_falling;
use crate::numeric::statistics::extremes;
use crate::plan::meshes::work::WorkResult;
use crate::plan::transmission::result::{OrderLineResult, TransmissionResult};
use crate::transmission::speed_map::SpeedMap;

const MARGIN_LEFT: f64 = 70.0;

/// Orders with a name.
const MAX_LABELS: usize = 28;

/// Smallest drawn line, as a share of the largest.
const DRAWN: f64 = 1e-5;

/// Smallest line, as a share of the worst case, with a size of its own for comparison over speed.
const MIN_LINE_SHARE: f64 = 1e-9;

/// Every plot.
pub fn draw_all(title: &str, machine: &Machine, result: &TransmissionResult) -> Vec<Figure> {
    let title = &titled(title, machine, result);
    let unit = TeUnit::for_output(machine, result);
    let mut all = vec![
        Figure::first(lines(title, machine, result)),
        Figure::new("budget", budget(title, result, unit)),
    ];
    if let Some(map) = &result.map {
        all.push(Figure::new("speeds", speeds(title, machine, result, map)));
    }
    if !result.works.is_empty() {
        all.push(Figure::new("flank", flanks(title, &result.works)));
    }
    all
}

/// Draws the surplus of every flank that is cut.
fn flanks(title: &str, works: &[Arc<WorkResult>]) -> String {
    let maps = works.iter().map(|work| FlankMap {
        name: format!("surplus of {} over the ideal flank", work_flank_name(work)),
        size: work.pair.grid,
        deviations: &work.pair.surplus,
    });
    draw_maps(title, &maps.collect::<Vec<_>>())
}

/// The model and whose error is shown: `Y2250: work_spindle driven by motor`.
fn titled(title: &str, machine: &Machine, result: &TransmissionResult) -> String {
    const MAX_NAME_LEN: usize = 120;
    let name = |dof: usize| machine.nodes[machine.dofs[dof].node].name.as_str();
    let ends = &result.chain.ends;
    let against = ends
        .relative_to
        .map_or(String::new(), |a| format!(", against {}", name(a)));
    let whose = format!(
        "{} driven by {}{against}",
        name(ends.output),
        name(ends.driver)
    );
    let room = MAX_NAME_LEN
        .saturating_sub(whose.chars().count() + 2)
        .max(20);
    format!("{}: {whose}", truncate_label(title, room))
}

/// Rows by falling amplitude, those without one left out.
fn largest(result: &TransmissionResult) -> Vec<usize> {
    let size = |k: usize| result.quasi_static(&result.lines[k]).norm();
    let mut order: Vec<usize> = (0..result.lines.len()).filter(|&k| size(k) > 0.0).collect();
    sort_falling(&mut order, |&a| size(a));
    order
}

/// The largest line of each order, with the others behind it; the orders with the largest, ascending.
fn orders(result: &TransmissionResult, size: impl Fn(usize) -> f64) -> Vec<Vec<usize>> {
    let all: Vec<usize> = (0..result.lines.len()).filter(|&k| size(k) > 0.0).collect();
    let mut groups: Vec<Vec<usize>> = all
        .chunk_by(|&a, &b| result.lines[a].line.order == result.lines[b].line.order)
        .map(|group| {
            let mut group = group.to_vec();
            sort_falling(&mut group, |&a| size(a));
            group
        })
        .collect();
    sort_falling(&mut groups, |a| size(a[0]));
    groups.truncate(MAX_LABELS);
    groups.sort_by_key(|group| group[0]);
    groups
}

/// Amplitudes over orders, the largest with their sources.
fn lines(title: &str, machine: &Machine, result: &TransmissionResult) -> PlotColumn {
    let unit = TeUnit::for_output(machine, result);
    let all = largest(result);
    let size = |k: usize| result.quasi_static(&result.lines[k]).norm() * unit.times;
    let least = all.first().map_or(0.0, |&k| DRAWN * size(k));
    let amplitude = |k: usize| if size(k) < least { 0.0 } else { size(k) };
    let drawn: Vec<usize> = all.into_iter().filter(|&k| amplitude(k) > 0.0).collect();
    let order = |k: usize| result.lines[k].line.order.to_f64();
    // Lines of one order share the name of the largest.
    let label = |group: Vec<usize>| PointLabel {
        x: order(group[0]),
        y: group.iter().map(|&k| amplitude(k)).fold(0.0, f64::max),
        text: order_label(machine, result, &group),
    };
    let ends = extremes(drawn.iter().map(|&k| order(k)));
    let per = machine.dofs[result.chain.order_reference].node;
    let across = format!("order, cycles per turn of {}", machine.nodes[per].name);
    let stems = Curve::new(
        "",
        Ink::Series(0),
        Mark::Stems,
        drawn.iter().map(|&k| order(k)).collect(),
        drawn.iter().map(|&k| amplitude(k)).collect(),
    );
    let plot = Plot {
        height: 340.0,
        curves: vec![stems],
        labels: orders(result, amplitude).into_iter().map(label).collect(),
        upright_labels: true,
        empty: "no line",
        ..Plot::new(
            Axis::log(across).over(0.7 * ends.0, 1.4 * ends.1),
            Axis::log(format!("amplitude at the output, {}", unit.name)),
        )
    };
    PlotColumn::one(title, plot)
}

/// An order with the largest of its sources.
fn order_label(machine: &Machine, result: &TransmissionResult, group: &[usize]) -> String {
    let more = match group.len() {
        1 => String::new(),
        n => format!(" and {} more", n - 1),
    };
    truncate_label(&(line_label(machine, &result.lines[group[0]]) + &more), 90)
}

/// An order, its source and its cause.
fn line_label(machine: &Machine, row: &OrderLineResult) -> String {
    format!(
        "{}: {}, {}",
        four_digits(row.line.order.to_f64()),
        row.source(machine),
        row.cause(machine)
    )
}

/// Shares of the sum of squares by element.
fn budget(title: &str, result: &TransmissionResult, unit: TeUnit) -> String {
    const ROW_HEIGHT: f64 = 20.0;
    const MARGIN_TOP: f64 = 64.0;
    const MAX_COUNT: usize = 20;
    let found = &result.budget.elements;
    let mut order: Vec<usize> = (0..found.len()).filter(|&e| found[e].share > 0.0).collect();
    sort_falling(&mut order, |&a| found[a].share);
    let hidden: f64 = order.iter().skip(MAX_COUNT).map(|&e| found[e].share).sum();
    order.truncate(MAX_COUNT);
    let height = MARGIN_TOP + ROW_HEIGHT * order.len() as f64 + 40.0;
    render_svg(WIDTH, height, |canvas| {
        canvas.title(title, MARGIN_LEFT);
        let sums = format!(
            "share of the sum of squares; root {} {unit}, worst case {} {unit}",
            four_digits(result.budget.rss * unit.times),
            four_digits(result.budget.worst_case * unit.times),
            unit = unit.name
        );
        canvas.label(&sums, (MARGIN_LEFT, 38.0), Anchor::Start);
        let names: Vec<String> = order
            .iter()
            .map(|&e| truncate_label(&result.elements[e], 28))
            .collect();
        let left = 24.0 + widest(&names, LABEL_SIZE, 60.0);
        let right = WIDTH - 350.0;
        let full = order.first().map_or(1.0, |&e| found[e].share);
        for (row, (&e, name)) in order.iter().zip(&names).enumerate() {
            let middle = MARGIN_TOP + ROW_HEIGHT * (row as f64 + 0.5);
            canvas.label(name, (left - 8.0, middle), Anchor::End);
            let end = left + (right - left) * found[e].share / full;
            canvas.fill_rect(
                (left, middle - 7.0),
                (end, middle + 7.0),
                if row == 0 { ORANGE } else { lighten(BLUE) },
            );
            let finer = found[e].one_grade_finer.map_or(String::new(), |finer| {
                format!("−{} % if one grade finer, ", percent(finer))
            });
            let text = format!(
                "{} %; rss {finer}−{} % without it",
                percent(found[e].share),
                percent(found[e].rss_without)
            );
            canvas.label(&text, (end + 6.0, middle), Anchor::Start);
        }
        if hidden > 0.0 {
            let text = format!("{} % in smaller ones", percent(hidden));
            canvas.note(&text, (left, height - 20.0), Anchor::Start);
        }
    })
}

/// The node whose speed counts.
fn reference_node(machine: &Machine) -> &str {
    let stated = machine.speeds.first().map(|s| machine.dofs[s.0].node);
    stated.map_or("the driver", |node| machine.nodes[node].name.as_str())
}

/// Dynamic amplification of the largest line of each order, in dB relative to quasi-static; next to the names its quasi-static and largest
/// amplitude.
fn speeds(title: &str, machine: &Machine, result: &TransmissionResult, map: &SpeedMap) -> String {
    const ROW_HEIGHT: f64 = 17.0;
    const MARGIN_TOP: f64 = 52.0;
    const MARGIN_RIGHT: f64 = WIDTH - 96.0;
    let most = |k: usize| map.amplitudes[k].iter().fold(0.0f64, |m, a| m.max(*a));
    let still =
        |k: usize| result.lines[k].loaded.norm() > MIN_LINE_SHARE * result.budget.worst_case;
    let groups = orders(result, |k| if still(k) { most(k) } else { 0.0 });
    let shown: Vec<usize> = groups.iter().map(|group| group[0]).collect();
    let height = MARGIN_TOP + ROW_HEIGHT * shown.len() as f64;
    let unit = TeUnit::for_output(machine, result);
    let sizes = |k: usize| {
        let (slow, most) = (result.lines[k].loaded.norm(), map.largest[k].1);
        let [slow, most] = [slow, most].map(|x| four_digits(x * unit.times));
        format!("{slow} quasi-static, {most} at most")
    };
    let level = |k: usize, s: usize| {
        20.0 * (map.amplitudes[k][s] / result.lines[k].loaded.norm().max(f64::MIN_POSITIVE)).log10()
    };
    render_svg(WIDTH, height + 54.0, |canvas| {
        canvas.title(title, MARGIN_LEFT);
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
                    truncate_label(&line_label(machine, &result.lines[k]), 40),
                    sizes(k)
                )
            })
            .collect();
        let head = format!("order: source, cause, {} at the output", unit.name);
        let left = 16.0 + widest(&names, 9.0, 60.0);
        canvas.text(
            &head,
            (left - 6.0, MARGIN_TOP - 9.0),
            9.0,
            GREY,
            Anchor::End,
        );
        let rpm: Vec<f64> = map
            .speeds
            .iter()
            .map(|s| s * 30.0 / std::f64::consts::PI)
            .collect();
        let half = 0.5 * (rpm[1] - rpm[0]);
        let panel = Panel::new(
            (left, MARGIN_RIGHT),
            (MARGIN_TOP, height),
            (rpm[0] - half, rpm[rpm.len() - 1] + half),
            (0.0, 1.0),
        );
        for (row, (&k, name)) in shown.iter().zip(&names).enumerate() {
            let (up, down) = (
                MARGIN_TOP + ROW_HEIGHT * row as f64,
                MARGIN_TOP + ROW_HEIGHT * (row as f64 + 1.0),
            );
            canvas.text(
                name,
                (left - 6.0, 0.5 * (up + down)),
                9.0,
                BLACK,
                Anchor::End,
            );
            for (s, speed) in rpm.iter().enumerate() {
                let across = (
                    panel.canvas_x(speed - half),
                    (panel.canvas_x(speed + half) + 1.0).min(MARGIN_RIGHT),
                );
                canvas.fill_rect(
                    (across.0, down - 1.0),
                    (across.1, up),
                    ink(step_of(level(k, s), scale)),
                );
            }
        }
        for tick in ticks(panel.x, 8) {
            let right = panel.canvas_x(tick);
            canvas.label(&four_digits(tick), (right, height + 12.0), Anchor::Middle);
        }
        let middle = 0.5 * (left + MARGIN_RIGHT);
        canvas.label(
            &format!("speed of {}, rpm", reference_node(machine)),
            (middle, height + 34.0),
            Anchor::Middle,
        );
        draw_colour_bar(
            canvas,
            (MARGIN_RIGHT, (MARGIN_TOP, height)),
            scale,
            "dynamic over quasi-static, dB",
        );
    })
}
