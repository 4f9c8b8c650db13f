//! Mode-shape plots: rotations along the drive train, and lateral displacements.

use super::node_layout::{LayoutNode, LinkKind, layout_nodes};
use super::svg::{
    Anchor, BLACK, BLUE, Canvas, Colour, GREY, LABEL_SIZE, LIGHT_GREY, LineStyle, Panel,
    TITLE_LEFT, TITLE_SIZE, WIDTH, hertz, render_svg, significant, text_width, ticks, title_height,
    truncate_label, widest,
};
use super::train::ratios;
use crate::machine::components::Machine;
use crate::modes::energy::{EnergyShares, dominant_element};
use crate::modes::mode::{Mode, modulus};
use crate::numeric::Complex;
use crate::plan::modes_run::ModesResult;
use crate::plan::prepared_machine::PreparedMachine;
use crate::scene::model::Axis;

/// Maximum number of panels.
const MAX_COUNT: usize = 8;

/// Largest number of nodes for two panels in one row.
const NARROW: usize = 24;

/// Maximum number of nodes with stems.
const STEMS: usize = 45;

/// Maximum length of a name on an axis, characters.
const MAX_NAME_LEN: usize = 20;

/// Maximum width of a displacement bar, points.
const MAX_BAR: f64 = 24.0;

/// Rounding limit: ratio of rotations to displacements, at a lever of 1 m, below which a motion is not drawn.
const ROUNDING: f64 = 1e-9;

/// Draws the shapes of the first `count` modes, at most eight.
///
/// Rotations are divided by the ratio of each node to the first if one rigid-body motion rotates all nodes: the rigid mode is then
/// a flat line, and any slope is wind-up. The phase of a shape makes its largest rotation real and positive.
pub fn draw_mode_shapes(
    title: &str,
    prepared_machine: &PreparedMachine,
    result: &ModesResult,
    count: usize,
) -> String {
    let machine = &prepared_machine.machine;
    let modes = &result.modes[..result.modes.len().min(count).min(MAX_COUNT)];
    let train = layout_nodes(machine);
    let ratios: Option<Vec<f64>> =
        ratios(prepared_machine).map(|by_node| train.iter().map(|s| by_node[s.node]).collect());
    let lateral = lateral_dofs(machine);
    let figure = ModeShapeFigure {
        machine,
        complex: result.complex,
        scaled: ratios.is_some(),
        ratios: ratios.unwrap_or_else(|| vec![1.0; train.len()]),
        train,
        lateral,
    };
    figure.draw(title, modes, &result.energies)
}

/// Lateral degrees of freedom: displacements, then tilts.
fn lateral_dofs(machine: &Machine) -> Vec<usize> {
    let dofs = |tilts: bool| {
        machine
            .dofs
            .iter()
            .enumerate()
            .filter(move |(_, f)| f.axis != Axis::Theta && f.axis.is_rotation() == tilts)
            .map(|(i, _)| i)
    };
    dofs(false).chain(dofs(true)).collect()
}

/// Real or imaginary part.
type ComplexComponent = fn(&Complex) -> f64;

/// Data common to all panels.
struct ModeShapeFigure<'a> {
    machine: &'a Machine,
    complex: bool,
    scaled: bool,
    ratios: Vec<f64>,
    train: Vec<LayoutNode>,
    lateral: Vec<usize>,
}

/// Positions of the panels, points.
struct ShapeLayout {
    columns: usize,
    rows: usize,
    panel: (f64, f64),
    top: f64,
    names: f64,
    height: f64,
}

const MARGIN_LEFT: f64 = 70.0;
const MARGIN_RIGHT: f64 = 14.0;
const SPACING: f64 = 50.0;
const HEADING: f64 = 30.0;

impl ModeShapeFigure<'_> {
    fn has_lateral(&self) -> bool {
        !self.lateral.is_empty()
    }

    fn layout(&self, title: &str, n_modes: usize) -> ShapeLayout {
        let is_paired = !self.has_lateral() && self.train.len() <= NARROW && n_modes > 1;
        let columns = if is_paired { 2 } else { 1 };
        let rows = n_modes.div_ceil(columns).max(1);
        let n_across = if columns == 2 || self.has_lateral() {
            2.0
        } else {
            1.0
        };
        let width = (WIDTH - MARGIN_LEFT - MARGIN_RIGHT - (n_across - 1.0) * SPACING) / n_across;
        let panel = (width, 92.0);
        let names = self.node_names().into_iter().chain(self.lateral_names());
        let names = widest(names, LABEL_SIZE, 0.0) + 8.0;
        let top = title_height(title) + if self.complex { 34.0 } else { 12.0 };
        let height = top + rows as f64 * (panel.1 + HEADING) + names + 26.0;
        ShapeLayout {
            columns,
            rows,
            panel,
            top,
            names,
            height,
        }
    }

    fn node_names(&self) -> Vec<String> {
        let name =
            |node: &LayoutNode| truncate_label(&self.machine.nodes[node.node].name, MAX_NAME_LEN);
        self.train.iter().map(name).collect()
    }

    fn lateral_names(&self) -> Vec<String> {
        let name = |&i: &usize| {
            let dof = self.machine.dofs[i];
            let node = truncate_label(&self.machine.nodes[dof.node].name, MAX_NAME_LEN - 3);
            format!("{node}.{}", dof.axis.name())
        };
        self.lateral.iter().map(name).collect()
    }

    fn draw(&self, title: &str, modes: &[Mode], energies: &[EnergyShares]) -> String {
        let layout = self.layout(title, modes.len());
        render_svg(WIDTH, layout.height, |canvas| {
            canvas.title(title, TITLE_LEFT);
            if modes.is_empty() {
                let middle = (WIDTH / 2.0, layout.height / 2.0);
                canvas.placeholder("no modes", middle);
                return;
            }
            if self.complex {
                draw_legend(canvas, title_height(title));
            }
            for (i, mode) in modes.iter().enumerate() {
                let (row, column) = (i / layout.columns, i % layout.columns);
                let left = MARGIN_LEFT + column as f64 * (layout.panel.0 + SPACING);
                let top = layout.top + HEADING + row as f64 * (layout.panel.1 + HEADING);
                let heading = self.heading(i, mode, energies.get(i));
                let lowest = i + layout.columns >= modes.len();
                self.row(canvas, (left, top), &layout, mode, &heading, lowest);
            }
            self.label_axes(canvas, &layout);
        })
    }

    fn heading(&self, i: usize, mode: &Mode, energies: Option<&EnergyShares>) -> String {
        let label = format!("mode {} · {}", i + 1, hertz(mode.frequency_hz()));
        if mode.rigid {
            return format!("{label} · rigid body");
        }
        let behaviour = if mode.is_oscillatory() {
            ""
        } else {
            " · not oscillatory"
        };
        let shares = energies.and_then(|e| e.strain.as_deref());
        match shares.and_then(dominant_element) {
            Some((element, share)) => {
                let name = truncate_label(&self.machine.elements[element].name, MAX_NAME_LEN + 4);
                format!("{label}{behaviour} · {name} {:.0} %", 100.0 * share)
            }
            None => format!("{label}{behaviour}"),
        }
    }

    /// Draws the panels of a mode: rotations, and displacements if any.
    fn row(
        &self,
        canvas: &mut Canvas,
        corner: (f64, f64),
        layout: &ShapeLayout,
        mode: &Mode,
        title: &str,
        is_lowest: bool,
    ) {
        let panel = |left: f64, x: (f64, f64)| {
            Panel::new(
                (left, left + layout.panel.0),
                (corner.1, corner.1 + layout.panel.1),
                x,
                (-1.12, 1.12),
            )
        };
        let (theta, motion) = self.values(mode);
        let x_last = self.train.last().map_or(0.0, |node| node.x);
        let left = panel(corner.0, (-0.5, x_last + 0.5));
        let head = (corner.0, corner.1 - 10.0);
        canvas.text(title, head, TITLE_SIZE, BLACK, Anchor::Start);
        draw_axes(canvas, &left);
        match largest(&theta) {
            0.0 => draw_empty(canvas, &left, "no rotation"),
            size => self.trace(canvas, &left, &scaled_to_unit(&theta, size)),
        }
        let x_nodes: Vec<f64> = self.train.iter().map(|node| node.x).collect();
        if is_lowest {
            draw_names(canvas, &left, &x_nodes, &self.node_names());
        }
        if !self.has_lateral() {
            return;
        }
        let n = self.lateral.len() as f64;
        let right = panel(corner.0 + layout.panel.0 + SPACING, (-0.7, n - 0.3));
        draw_axes(canvas, &right);
        let note = self.displacement_note(&theta, &motion);
        let end = (right.across.1, corner.1 - 10.0);
        canvas.label(&note, end, Anchor::End);
        self.bars(canvas, &right, &motion);
        if is_lowest {
            let x_nodes: Vec<f64> = (0..self.lateral.len()).map(|i| i as f64).collect();
            draw_names(canvas, &right, &x_nodes, &self.lateral_names());
        }
    }

    /// Rotations by node and lateral motions of a mode, rounding set to zero.
    fn values(&self, mode: &Mode) -> (Vec<Complex>, Vec<Complex>) {
        let angle = |(node, ratio): (&LayoutNode, &f64)| mode.shape[node.dof] / *ratio;
        let mut theta: Vec<Complex> = self.train.iter().zip(&self.ratios).map(angle).collect();
        let mut motion: Vec<Complex> = self.lateral.iter().map(|&i| mode.shape[i]).collect();
        let size = largest(&theta).max(largest(&motion));
        for kind in [&mut theta, &mut motion] {
            if largest(kind) <= ROUNDING * size {
                kind.iter_mut().for_each(|z| *z = Complex::new(0.0, 0.0));
            }
        }
        // A common phase keeps the signs of both kinds comparable.
        let phase = phase_of_largest(&theta).or(phase_of_largest(&motion));
        if let Some(phase) = phase {
            let remove_phase = |z: &mut Complex| *z /= phase;
            theta.iter_mut().chain(&mut motion).for_each(remove_phase);
        }
        (theta, motion)
    }

    fn n_displacements(&self) -> usize {
        let is_displacement = |&&i: &&usize| !self.machine.dofs[i].axis.is_rotation();
        self.lateral.iter().filter(is_displacement).count()
    }

    /// Note on the scale of displacements relative to rotations.
    fn displacement_note(&self, theta: &[Complex], motion: &[Complex]) -> String {
        let (angle, displacement) = (largest(theta), largest(&motion[..self.n_displacements()]));
        if displacement == 0.0 || angle == 0.0 {
            return String::new();
        }
        let um_per_mrad = displacement / angle * 1e3; // m/rad = 10³ µm/mrad
        format!(
            "1 here: {} µm if 1 at left: 1 mrad",
            significant(um_per_mrad, 3)
        )
    }

    /// Draws stems and a line through them, black along shafts and grey across other joints.
    fn trace(&self, canvas: &mut Canvas, panel: &Panel, values: &[Complex]) {
        let point =
            |i: usize, part: ComplexComponent| panel.to_canvas(self.train[i].x, part(&values[i]));
        let (real, imaginary): (ComplexComponent, ComplexComponent) = (|z| z.re, |z| z.im);
        let stems = self.train.len() <= STEMS;
        if stems {
            for i in 0..values.len() {
                let (x, y) = point(i, real);
                canvas.line((x, panel.canvas_y(0.0)), (x, y), GREY, 0.8);
            }
        }
        for (i, node) in self.train.iter().enumerate() {
            match node.from {
                Some((previous, _)) if !node.follows_parent => {
                    let link = [point(previous, real), point(i, real)];
                    canvas.polyline(&link, GREY, 0.7, LineStyle::Dotted);
                }
                Some((previous, LinkKind::Mesh)) => {
                    canvas.line(point(previous, real), point(i, real), GREY, 1.0);
                }
                _ => {}
            }
        }
        for run in
            self.runs(|node| node.follows_parent && matches!(node.from, Some((_, LinkKind::Shaft))))
        {
            let points: Vec<_> = run.clone().map(|i| point(i, real)).collect();
            canvas.polyline(&decimated(&points), BLACK, 1.6, LineStyle::Solid);
        }
        if self.complex {
            for run in self.runs(|node| node.follows_parent) {
                let points: Vec<_> = run.map(|i| point(i, imaginary)).collect();
                canvas.polyline(&decimated(&points), BLUE, 1.3, LineStyle::Dashed);
            }
        }
        if stems {
            (0..values.len()).for_each(|i| canvas.fill_circle(point(i, real), 2.4, BLACK));
        }
    }

    /// Index ranges of consecutive nodes that continue the previous one.
    fn runs(&self, continues: impl Fn(&LayoutNode) -> bool) -> Vec<std::ops::Range<usize>> {
        let mut starts: Vec<usize> = (0..self.train.len())
            .filter(|&i| !continues(&self.train[i]))
            .collect();
        starts.push(self.train.len());
        starts.windows(2).map(|w| w[0]..w[1]).collect()
    }

    /// Draws a bar for each displacement and tilt, each kind relative to its largest.
    fn bars(&self, canvas: &mut Canvas, panel: &Panel, motion: &[Complex]) {
        let widest = 0.5 * MAX_BAR * (panel.x.1 - panel.x.0) / (panel.across.1 - panel.across.0);
        let n = self.n_displacements();
        let (displacements, tilts) = motion.split_at(n);
        for (values, start, ink) in [(displacements, 0, BLACK), (tilts, n, GREY)] {
            let size = largest(values);
            if size == 0.0 {
                continue;
            }
            for (i, value) in scaled_to_unit(values, size).iter().enumerate() {
                let x = (start + i) as f64;
                let (w, shift) = if self.complex {
                    (0.18, 0.2)
                } else {
                    (0.25, 0.0)
                };
                let half = widest.min(w);
                bar(canvas, panel, (x - shift, half), value.re, ink);
                if self.complex {
                    bar(canvas, panel, (x + shift, half), value.im, BLUE);
                }
            }
        }
        if largest(motion) == 0.0 {
            draw_empty(canvas, panel, "no displacement");
        }
    }

    fn label_axes(&self, canvas: &mut Canvas, layout: &ShapeLayout) {
        let below = layout.top + layout.rows as f64 * (layout.panel.1 + HEADING);
        let middle = (layout.top + below) / 2.0;
        let label = if self.scaled {
            let first = self.train.first().map_or(0, |node| node.node);
            let name = truncate_label(&self.machine.nodes[first].name, MAX_NAME_LEN);
            format!("θ ÷ ratio to {name}, largest = 1 (–)")
        } else {
            "θ, largest = 1 (–)".to_string()
        };
        // A single row of panels is lower than the full text.
        let fits = text_width(&label, LABEL_SIZE) < below - layout.top;
        let label = if fits {
            label
        } else {
            label.replace(", largest = 1 (–)", "")
        };
        canvas.upright(&label, (18.0, middle));
        let foot = below + layout.names + 14.0;
        let tilts = self.lateral.len() > self.n_displacements();
        if self.has_lateral() {
            let (w, label) = (layout.panel.0, "node, in the order of the train");
            canvas.label(label, (MARGIN_LEFT + w / 2.0, foot), Anchor::Middle);
            let label = if tilts {
                "degree of freedom; displacements in text colour, tilts grey"
            } else {
                "displacement"
            };
            let x = MARGIN_LEFT + w * 1.5 + SPACING;
            canvas.label(label, (x, foot), Anchor::Middle);
            let label = if tilts {
                "each kind: largest = 1 (–)"
            } else {
                "largest = 1 (–)"
            };
            let x = MARGIN_LEFT + w + 14.0;
            canvas.upright(label, (x, middle));
        } else {
            let x = (MARGIN_LEFT + WIDTH - MARGIN_RIGHT) / 2.0;
            let label = "node, in the order of the train; in text colour: shafts, grey: other joints, dotted: to a branch";
            canvas.label(label, (x, foot), Anchor::Middle);
        }
    }
}

/// Draws the key of real and imaginary parts.
fn draw_legend(canvas: &mut Canvas, top: f64) {
    let y = top + 14.0;
    canvas.line((MARGIN_LEFT, y), (MARGIN_LEFT + 26.0, y), BLACK, 1.6);
    let x = MARGIN_LEFT + 32.0;
    canvas.label("real part", (x, y), Anchor::Start);
    canvas.polyline(
        &[(x + 66.0, y), (x + 92.0, y)],
        BLUE,
        1.3,
        LineStyle::Dashed,
    );
    let text = "imaginary part, a quarter period apart; the largest rotation is real";
    canvas.label(text, (x + 98.0, y), Anchor::Start);
}

fn largest(values: &[Complex]) -> f64 {
    values.iter().map(|&z| modulus(z)).fold(0.0, f64::max)
}

/// Phase factor of the largest component; `None` for a zero shape.
fn phase_of_largest(values: &[Complex]) -> Option<Complex> {
    let size = largest(values);
    let lead = values
        .iter()
        .find(|&&z| modulus(z) >= size * (1.0 - 1e-9))?;
    (size > 0.0).then(|| *lead / modulus(*lead))
}

fn scaled_to_unit(values: &[Complex], size: f64) -> Vec<Complex> {
    values.iter().map(|&z| z / size).collect()
}

fn draw_axes(canvas: &mut Canvas, panel: &Panel) {
    panel.draw_y_grid(canvas, &ticks((-1.0, 1.0), 2));
    let zero = panel.canvas_y(0.0);
    panel.draw_horizontal(canvas, zero, GREY, 0.8);
}

fn draw_empty(canvas: &mut Canvas, panel: &Panel, text: &str) {
    let middle = (panel.across.0 + panel.across.1) / 2.0;
    let above = panel.canvas_y(0.0) - 10.0;
    canvas.note(text, (middle, above), Anchor::Middle);
}

fn bar(canvas: &mut Canvas, panel: &Panel, (x, half): (f64, f64), value: f64, ink: Colour) {
    canvas.fill_rect(
        panel.to_canvas(x - half, 0.0),
        panel.to_canvas(x + half, value),
        ink,
    );
}

/// Draws names below a panel, as many as fit.
fn draw_names(canvas: &mut Canvas, panel: &Panel, positions: &[f64], names: &[String]) {
    let mut next_free = f64::NEG_INFINITY;
    for (&x, name) in positions.iter().zip(names) {
        let (right, below) = (panel.canvas_x(x), panel.down.1);
        if right < next_free {
            continue;
        }
        next_free = right + if positions.len() > STEMS { 2.5 } else { 1.2 } * LABEL_SIZE;
        canvas.line((right, below), (right, below + 3.0), LIGHT_GREY, 0.8);
        canvas.vertical_text(name, (right, below + 6.0), LABEL_SIZE, BLACK, Anchor::End);
    }
}

/// Decimates a line of many points to the lowest and highest in each point of width.
fn decimated(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    const MANY_NODES: usize = 2000;
    if points.len() <= MANY_NODES {
        return points.to_vec();
    }
    let mut curve: Vec<(f64, f64)> = Vec::new();
    for group in points.chunk_by(|a, b| a.0.floor() == b.0.floor()) {
        let ends = [group.first(), group.last()];
        let lowest = group.iter().min_by(|a, b| a.1.total_cmp(&b.1));
        let highest = group.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        curve.extend([ends[0], lowest, highest, ends[1]].into_iter().flatten());
    }
    curve
}
