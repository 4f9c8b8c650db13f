//! Energy-share plot: elements by modes, symbol areas in proportion to the share.

use super::svg::{
    Anchor, BLACK, Canvas, GREY, LABEL_SIZE, LIGHT_GREY, ORANGE, Point2, TITLE_LEFT, TITLE_SIZE,
    WIDTH, render_svg, significant, text_width, title_height, truncate_label, widest,
};
use crate::modes::energy::EnergyShares;
use crate::numeric::sorting::sort_descending;
use crate::plan::modes_run::ModesResult;
use crate::plan::prepared_machine::PreparedMachine;

/// Maximum number of modes shown.
const MAX_MODES: usize = 20;

/// Maximum number of elements shown.
const MAX_ELEMENTS: usize = 60;

/// Minimum share, in one of the modes shown, of an element that is shown.
const MIN_SHARE: f64 = 0.03;

/// Radius of the disc for a share of 1, points.
const FULL_RADIUS: f64 = 8.6;

const ROW_HEIGHT: f64 = 21.0;

/// Draws the strain and kinetic energy shares of the first `count` modes (at most 20) by element.
pub fn draw_energy_matrix(
    title: &str,
    machine: &PreparedMachine,
    result: &ModesResult,
    count: usize,
) -> String {
    let n_modes = result.modes.len().min(result.energies.len());
    let energies = &result.energies[..n_modes.min(count).min(MAX_MODES)];
    let (elements, left_out) = significant_elements(energies);
    let name = |&e: &usize| truncate_label(&machine.machine.elements[e].name, 24);
    let matrix = EnergyMatrix {
        title,
        names: elements.iter().map(name).collect(),
        elements,
        left_out,
        frequencies: result
            .modes
            .iter()
            .map(|mode| mode.frequency_hz())
            .collect(),
        energies,
    };
    matrix.draw()
}

/// Elements with a share of at least 3 % in file order, and the number of elements omitted.
fn significant_elements(energies: &[EnergyShares]) -> (Vec<usize>, usize) {
    let mut largest: Vec<(usize, f64)> = Vec::new();
    let strains = energies.iter().filter_map(|e| e.strain.as_ref());
    let shares = energies.iter().map(|e| &e.kinetic).chain(strains).flatten();
    let mut sorted: Vec<(usize, f64)> = shares.map(|&(e, share)| (e, share.abs())).collect();
    sorted.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
    for (element, share) in sorted {
        if largest.last().is_none_or(|last| last.0 != element) {
            largest.push((element, share));
        }
    }
    let total = largest.len();
    largest.retain(|&(_, share)| share >= MIN_SHARE);
    sort_descending(&mut largest, |a| a.1);
    largest.truncate(MAX_ELEMENTS);
    largest.sort_by_key(|&(element, _)| element);
    let n = largest.len();
    (largest.into_iter().map(|(e, _)| e).collect(), total - n)
}

struct EnergyMatrix<'a> {
    title: &'a str,
    names: Vec<String>,
    elements: Vec<usize>,
    left_out: usize,
    frequencies: Vec<f64>,
    energies: &'a [EnergyShares],
}

impl EnergyMatrix<'_> {
    fn draw(&self) -> String {
        let (n, m) = (self.energies.len(), self.elements.len());
        let top = title_height(self.title) + 60.0;
        let height = top + m as f64 * ROW_HEIGHT + 46.0;
        render_svg(WIDTH, height, |canvas| {
            canvas.title(self.title, TITLE_LEFT);
            if n == 0 {
                let middle = (WIDTH / 2.0, height / 2.0);
                canvas.placeholder("no modes", middle);
                return;
            }
            let left = 34.0 + widest(&self.names, LABEL_SIZE, 70.0);
            let column = ((WIDTH - left - 12.0) / n as f64).min(72.0);
            let grid = EnergyGrid {
                left,
                top,
                column,
                columns: n,
                rows: m,
            };
            grid.draw(canvas);
            self.draw_headings(canvas, &grid);
            self.draw_cells(canvas, &grid);
            self.draw_key(canvas, &grid);
        })
    }

    fn draw_headings(&self, canvas: &mut Canvas, grid: &EnergyGrid) {
        let end = grid.left - 8.0;
        let [modes, frequencies] = [grid.top - 36.0, grid.top - 18.0];
        canvas.label("mode", (end, modes), Anchor::End);
        canvas.label("frequency, Hz", (end, frequencies), Anchor::End);
        for k in 0..grid.columns {
            let (x, _) = grid.centre(k, 0);
            let mode = format!("{}", k + 1);
            canvas.text(&mode, (x, modes), TITLE_SIZE, BLACK, Anchor::Middle);
            let digits = if grid.column < 44.0 { 3 } else { 4 };
            let frequency = match self.frequencies[k] {
                0.0 => "0".to_string(),
                f if text_width(&significant(f, digits), LABEL_SIZE) < grid.column - 4.0 => {
                    significant(f, digits)
                }
                f => format!("{f:.1e}"),
            };
            canvas.label(&frequency, (x, frequencies), Anchor::Middle);
        }
        for (row, name) in self.names.iter().enumerate() {
            let (_, y) = grid.centre(0, row);
            canvas.label(name, (end, y), Anchor::End);
        }
        let middle = grid.top + grid.rows as f64 * ROW_HEIGHT / 2.0;
        canvas.upright("element", (14.0, middle));
    }

    fn draw_cells(&self, canvas: &mut Canvas, grid: &EnergyGrid) {
        let quarter = grid.column / 4.0;
        for (k, energies) in self.energies.iter().enumerate() {
            for (row, &element) in self.elements.iter().enumerate() {
                let (x, y) = grid.centre(k, row);
                if let Some(share) = energies
                    .strain
                    .as_deref()
                    .and_then(|s| share_of(s, element))
                {
                    draw_strain(canvas, (x - quarter, y), share);
                }
                if let Some(share) = share_of(&energies.kinetic, element) {
                    draw_kinetic(canvas, (x + quarter, y), share);
                }
            }
        }
    }

    fn draw_key(&self, canvas: &mut Canvas, grid: &EnergyGrid) {
        let y = grid.top + grid.rows as f64 * ROW_HEIGHT + 24.0;
        let mut x = 24.0;
        let draw_label = |canvas: &mut Canvas, x: &mut f64, text: &str| {
            canvas.label(text, (*x, y), Anchor::Start);
            *x += text_width(text, LABEL_SIZE) + 12.0;
        };
        draw_strain(canvas, (x, y), 1.0);
        x += 15.0;
        draw_label(canvas, &mut x, "strain");
        draw_kinetic(canvas, (x, y), 1.0);
        x += 15.0;
        draw_label(
            canvas,
            &mut x,
            "kinetic energy, share of the mode's by area:",
        );
        for (share, text) in [(0.03, "3 %"), (0.25, "25 %"), (1.0, "100 %")] {
            draw_strain(canvas, (x, y), share);
            draw_kinetic(canvas, (x + 20.0, y), share);
            x += 33.0;
            draw_label(canvas, &mut x, text);
            x += 8.0;
        }
        if self.has_negative() {
            canvas.stroke_circle((x, y), FULL_RADIUS, ORANGE, 1.4);
            x += 15.0;
            draw_label(canvas, &mut x, "negative");
        }
        if self.left_out > 0 {
            let text = format!("{} elements below 3 % are left out", self.left_out);
            canvas.note(&text, (WIDTH - 12.0, y), Anchor::End);
        }
    }

    fn has_negative(&self) -> bool {
        let strains = self.energies.iter().filter_map(|e| e.strain.as_ref());
        strains.flatten().any(|&(_, share)| share < 0.0)
    }
}

/// Share of an element.
fn share_of(shares: &[(usize, f64)], element: usize) -> Option<f64> {
    shares.iter().find(|s| s.0 == element).map(|s| s.1)
}

/// Radius of the disc for a share, points; `None` below a share of 0.2 %.
fn radius(share: f64) -> Option<f64> {
    const MAX_SHARE: f64 = 1.3; // shares above 1 occur together with negative ones
    const SMALLEST: f64 = 0.002;
    let size = share.abs().min(MAX_SHARE);
    (size >= SMALLEST).then(|| FULL_RADIUS * size.sqrt())
}

/// Draws a disc; a ring if the stiffness is negative.
fn draw_strain(canvas: &mut Canvas, spot: Point2, share: f64) {
    match radius(share) {
        Some(r) if share < 0.0 => canvas.stroke_circle(spot, r, ORANGE, 1.4),
        Some(r) => canvas.fill_circle(spot, r, BLACK),
        None => {}
    }
}

/// Draws an open square with the area of the disc of the same share.
fn draw_kinetic(canvas: &mut Canvas, (x, y): Point2, share: f64) {
    let Some(r) = radius(share) else { return };
    let half = r * std::f64::consts::PI.sqrt() / 2.0;
    canvas.stroke_rect((x - half, y - half), (x + half, y + half), GREY, 1.3);
}

/// Columns of modes and rows of elements.
struct EnergyGrid {
    left: f64,
    top: f64,
    column: f64,
    columns: usize,
    rows: usize,
}

impl EnergyGrid {
    fn centre(&self, column: usize, row: usize) -> Point2 {
        let x = self.left + (column as f64 + 0.5) * self.column;
        (x, self.top + (row as f64 + 0.5) * ROW_HEIGHT)
    }

    fn draw(&self, canvas: &mut Canvas) {
        let right = self.left + self.columns as f64 * self.column;
        let foot = self.top + self.rows as f64 * ROW_HEIGHT;
        for row in 0..=self.rows {
            let y = self.top + row as f64 * ROW_HEIGHT;
            canvas.line((self.left, y), (right, y), LIGHT_GREY, 0.5);
        }
        for column in 0..=self.columns {
            let x = self.left + column as f64 * self.column;
            canvas.line((x, self.top), (x, foot), LIGHT_GREY, 0.5);
        }
    }
}
