//! Plots of a transmission error: amplitudes over orders with their sources, error budget by element, order lines over speed.

use std::sync::Arc;

use super::figure::{Axis, Curve, Figure, Ink, Mark, Plot, PlotColumn, PointLabel};
use super::gear_cut_plot::{FlankMap, draw_maps};
use super::heatmap::{colour_step, draw_colour_bar, ink};
use super::number_format::{four_digits, percent};
use super::svg::{
    Anchor, BLACK, BLUE, GREY, LABEL_SIZE, ORANGE, Panel, WIDTH, lighten, render_svg, ticks,
    truncate_label, widest,
};
use super::te_lines::TeUnit;
use super::work::work_flank_name;
use crate::machine::components::Machine;
use crate::numeric::sorting::sort_descending;
use crate::numeric::statistics::extremes;
use crate::plan::meshes::work::WorkResult;
use crate::plan::transmission::result::{OrderLineResult, TransmissionResult};
use crate::transmission::speed_map::SpeedMap;

const MARGIN_LEFT: f64 = 70.0;

/// Largest number of labelled orders.
const MAX_LABELS: usize = 28;

/// Smallest drawn amplitude relative to the largest.
const MIN_DRAWN: f64 = 1e-5;

/// Smallest amplitude, relative to the worst case, that is compared over speed.
const MIN_LINE_SHARE: f64 = 1e-9;

/// Figures of a transmission result: orders, budget and, if computed, speed map and cut flanks.
pub fn draw_all(title: &str, machine: &Machine, result: &TransmissionResult) -> Vec<Figure> {
    let title = &plot_title(title, machine, result);
    let unit = TeUnit::for_output(machine, result);
    let mut figures = vec![
        Figure::first(lines(title, machine, result)),
        Figure::new("budget", budget(title, result, unit)),
    ];
    if let Some(map) = &result.map {
        figures.push(Figure::new("speeds", speeds(title, machine, result, map)));
    }
    if !result.workpieces.is_empty() {
        figures.push(Figure::new("flank", flanks(title, &result.workpieces)));
    }
    figures
}

/// Draws the surplus maps of the cut flanks.
fn flanks(title: &str, works: &[Arc<WorkResult>]) -> String {
    let maps = works.iter().map(|work| FlankMap {
        name: format!("surplus of {} over the ideal flank", work_flank_name(work)),
        size: work.pair.grid,
        deviations: &work.pair.surplus,
    });
    draw_maps(title, &maps.collect::<Vec<_>>())
}

/// Title with the output and input of the error: `Y2250: work_spindle driven by motor`.
fn plot_title(title: &str, machine: &Machine, result: &TransmissionResult) -> String {
    const MAX_NAME_LEN: usize = 120;
    let name = |dof: usize| machine.nodes[machine.dofs[dof].node].name.as_str();
    let ends = &result.chain.ends;
    let reference = ends
        .relative_to
        .map_or(String::new(), |a| format!(", against {}", name(a)));
    let subject = format!(
        "{} driven by {}{reference}",
        name(ends.output),
        name(ends.driver)
    );
    let length = MAX_NAME_LEN
        .saturating_sub(subject.chars().count() + 2)
        .max(20);
    format!("{}: {subject}", truncate_label(title, length))
}

/// Lines with a nonzero amplitude, by falling amplitude.
fn sorted_lines(result: &TransmissionResult) -> Vec<usize> {
    let size = |k: usize| result.quasi_static(&result.lines[k]).norm();
    let mut order: Vec<usize> = (0..result.lines.len()).filter(|&k| size(k) > 0.0).collect();
    sort_descending(&mut order, |&a| size(a));
    order
}

/// Lines grouped by order, the largest first within a group; the groups with the largest amplitudes, by rising order.
fn orders(result: &TransmissionResult, size: impl Fn(usize) -> f64) -> Vec<Vec<usize>> {
    let nonzero: Vec<usize> = (0..result.lines.len()).filter(|&k| size(k) > 0.0).collect();
    let mut groups: Vec<Vec<usize>> = nonzero
        .chunk_by(|&a, &b| result.lines[a].line.order == result.lines[b].line.order)
        .map(|group| {
            let mut group = group.to_vec();
            sort_descending(&mut group, |&a| size(a));
            group
        })
        .collect();
    sort_descending(&mut groups, |a| size(a[0]));
    groups.truncate(MAX_LABELS);
    groups.sort_by_key(|group| group[0]);
    groups
}

/// Plot of the amplitudes over orders, the largest labelled with their sources.
fn lines(title: &str, machine: &Machine, result: &TransmissionResult) -> PlotColumn {
    let unit = TeUnit::for_output(machine, result);
    let sorted = sorted_lines(result);
    let size = |k: usize| result.quasi_static(&result.lines[k]).norm() * unit.times;
    let least = sorted.first().map_or(0.0, |&k| MIN_DRAWN * size(k));
    let amplitude = |k: usize| if size(k) < least { 0.0 } else { size(k) };
    let drawn: Vec<usize> = sorted.into_iter().filter(|&k| amplitude(k) > 0.0).collect();
    let order = |k: usize| result.lines[k].line.order.to_f64();
    // Lines of one order share the label of the largest.
    let label = |group: Vec<usize>| PointLabel {
        x: order(group[0]),
        y: group.iter().map(|&k| amplitude(k)).fold(0.0, f64::max),
        text: order_label(machine, result, &group),
    };
    let range = extremes(drawn.iter().map(|&k| order(k)));
    let node = machine.dofs[result.chain.order_reference].node;
    let abscissa = format!("order, cycles per turn of {}", machine.nodes[node].name);
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
            Axis::log(abscissa).over(0.7 * range.0, 1.4 * range.1),
            Axis::log(format!("amplitude at the output, {}", unit.name)),
        )
    };
    PlotColumn::one(title, plot)
}

/// Label of an order with its largest source.
fn order_label(machine: &Machine, result: &TransmissionResult, group: &[usize]) -> String {
    let more = match group.len() {
        1 => String::new(),
        n => format!(" and {} more", n - 1),
    };
    truncate_label(&(line_label(machine, &result.lines[group[0]]) + &more), 90)
}

/// Label of a line: order, source and cause.
fn line_label(machine: &Machine, row: &OrderLineResult) -> String {
    format!(
        "{}: {}, {}",
        four_digits(row.line.order.to_f64()),
        row.source(machine),
        row.cause(machine)
    )
}

/// Draws the error budget: share of the sum of squares by element.
fn budget(title: &str, result: &TransmissionResult, unit: TeUnit) -> String {
    const ROW_HEIGHT: f64 = 20.0;
    const MARGIN_TOP: f64 = 64.0;
    const MAX_COUNT: usize = 20;
    let terms = &result.budget.elements;
    let mut order: Vec<usize> = (0..terms.len()).filter(|&e| terms[e].share > 0.0).collect();
    sort_descending(&mut order, |&a| terms[a].share);
    let hidden: f64 = order.iter().skip(MAX_COUNT).map(|&e| terms[e].share).sum();
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
        let full = order.first().map_or(1.0, |&e| terms[e].share);
        for (row, (&e, name)) in order.iter().zip(&names).enumerate() {
            let middle = MARGIN_TOP + ROW_HEIGHT * (row as f64 + 0.5);
            canvas.label(name, (left - 8.0, middle), Anchor::End);
            let end = left + (right - left) * terms[e].share / full;
            canvas.fill_rect(
                (left, middle - 7.0),
                (end, middle + 7.0),
                if row == 0 { ORANGE } else { lighten(BLUE) },
            );
            let finer = terms[e].one_grade_finer.map_or(String::new(), |finer| {
                format!("−{} % if one grade finer, ", percent(finer))
            });
            let text = format!(
                "{} %; rss {finer}−{} % without it",
                percent(terms[e].share),
                percent(terms[e].rss_reduction)
            );
            canvas.label(&text, (end + 6.0, middle), Anchor::Start);
        }
        if hidden > 0.0 {
            let text = format!("{} % in smaller ones", percent(hidden));
            canvas.note(&text, (left, height - 20.0), Anchor::Start);
        }
    })
}

/// Name of the reference node of the speed.
fn reference_node(machine: &Machine) -> &str {
    let stated = machine.speeds.first().map(|s| machine.dofs[s.0].node);
    stated.map_or("the driver", |node| machine.nodes[node].name.as_str())
}

/// Draws the dynamic amplification of the largest line of each order over speed, dB relative to quasi-static, labelled with its
/// quasi-static and largest amplitude.
fn speeds(title: &str, machine: &Machine, result: &TransmissionResult, map: &SpeedMap) -> String {
    const ROW_HEIGHT: f64 = 17.0;
    const MARGIN_TOP: f64 = 52.0;
    const MARGIN_RIGHT: f64 = WIDTH - 96.0;
    let peak = |k: usize| map.amplitudes[k].iter().fold(0.0f64, |m, a| m.max(*a));
    let is_compared =
        |k: usize| result.lines[k].loaded.norm() > MIN_LINE_SHARE * result.budget.worst_case;
    let groups = orders(result, |k| if is_compared(k) { peak(k) } else { 0.0 });
    let lines: Vec<usize> = groups.iter().map(|group| group[0]).collect();
    let height = MARGIN_TOP + ROW_HEIGHT * lines.len() as f64;
    let unit = TeUnit::for_output(machine, result);
    let sizes = |k: usize| {
        let (quasi_static, peak) = (result.lines[k].loaded.norm(), map.largest[k].1);
        let [quasi_static, peak] = [quasi_static, peak].map(|x| four_digits(x * unit.times));
        format!("{quasi_static} quasi-static, {peak} at most")
    };
    let level = |k: usize, s: usize| {
        20.0 * (map.amplitudes[k][s] / result.lines[k].loaded.norm().max(f64::MIN_POSITIVE)).log10()
    };
    render_svg(WIDTH, height + 54.0, |canvas| {
        canvas.title(title, MARGIN_LEFT);
        let levels = lines
            .iter()
            .flat_map(|&k| (0..map.speeds.len()).map(move |s| (k, s)));
        let peak = levels
            .map(|(k, s)| level(k, s))
            .filter(|x| x.is_finite())
            .fold(6.0f64, |m, x| m.max(x.abs()));
        let scale = (-peak.min(40.0), peak.min(40.0));
        let names: Vec<String> = lines
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
        let half_step = 0.5 * (rpm[1] - rpm[0]);
        let panel = Panel::new(
            (left, MARGIN_RIGHT),
            (MARGIN_TOP, height),
            (rpm[0] - half_step, rpm[rpm.len() - 1] + half_step),
            (0.0, 1.0),
        );
        for (row, (&k, name)) in lines.iter().zip(&names).enumerate() {
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
                    panel.canvas_x(speed - half_step),
                    (panel.canvas_x(speed + half_step) + 1.0).min(MARGIN_RIGHT),
                );
                canvas.fill_rect(
                    (across.0, down - 1.0),
                    (across.1, up),
                    ink(colour_step(level(k, s), scale)),
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
