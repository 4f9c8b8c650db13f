//! Colour maps of levels in dB over time or speed (abscissa) and frequency (ordinate).

use super::figure::LevelMap;
use super::svg::{Anchor, Canvas, Colour, GREY, Panel, WIDTH, colour_from_rgb, ticks};

/// Viridis colour map of matplotlib (van der Walt & Smith 2015) at nine even steps; lightness rises evenly, also in grey print.
const SCALE: [(f64, f64, f64); 9] = [
    (68.0, 1.0, 84.0),
    (71.0, 45.0, 123.0),
    (59.0, 82.0, 139.0),
    (44.0, 114.0, 142.0),
    (33.0, 145.0, 140.0),
    (40.0, 174.0, 128.0),
    (94.0, 201.0, 98.0),
    (173.0, 220.0, 48.0),
    (253.0, 231.0, 37.0),
];

/// Number of colours.
const STEPS: usize = 48;

/// Largest number of cells across and down; finer cells are not visible and slow the viewer.
const CELLS: (usize, usize) = (250, 140);

/// Largest number of cells across and down of a map of narrow lines.
const CELLS_SPARSE: (usize, usize) = (480, 400);

/// Largest range of levels below the maximum, dB.
const DYNAMIC_RANGE_DB: f64 = 80.0;

/// Share of cells below the colour scale: the lowest levels of a noise floor are random.
const CLIPPED: f64 = 0.02;

/// Overlap of adjacent blocks, points; it closes the gaps of anti-aliasing.
const OVERLAP: f64 = 1.0;

/// Ranges of both axes of a map; `None` without finite levels.
pub(super) fn map_ranges(map: &LevelMap) -> Option<((f64, f64), (f64, f64))> {
    let cells = MapCells::from_map(map, limits(map));
    cells.scale()?;
    let (first, last) = (cells.columns.first()?, cells.columns.last()?);
    let top = cells.low + first.levels.len() as f64 * cells.step;
    Some(((first.from, last.to), (cells.low, top)))
}

/// Largest number of cells of a map in an SVG file, across and down.
fn limits(map: &LevelMap) -> (usize, usize) {
    match map.sparse {
        true => CELLS_SPARSE,
        false => CELLS,
    }
}

/// Draws a map inside a panel with the colour bar on its right.
pub(super) fn draw_map(canvas: &mut Canvas, panel: &Panel, map: &LevelMap) {
    let cells = MapCells::from_map(map, limits(map));
    let Some(scale) = cells.scale() else {
        return;
    };
    let across = |from: f64, to: f64| {
        (
            panel.canvas_x(from).max(panel.across.0),
            (panel.canvas_x(to) + OVERLAP).min(panel.across.1),
        )
    };
    let height = |k: usize| {
        let y = panel.canvas_y(cells.low + k as f64 * cells.step);
        y.clamp(panel.down.0, panel.down.1)
    };
    // Adjoining columns share one background of the lowest colour.
    let adjoin = |a: &MapColumn, b: &MapColumn| b.from - a.to < 0.5 * (a.to - a.from);
    for run in cells.columns.chunk_by(adjoin) {
        let (left, right) = across(run[0].from, run[run.len() - 1].to);
        let top = height(run[0].levels.len());
        canvas.fill_rect((left, height(0)), (right, top), ink(0));
    }
    for column in &cells.columns {
        let across = across(column.from, column.to);
        let step = |level: &f64| colour_step(*level, scale);
        let mut row = 0;
        // Adjacent cells of equal colour are drawn as one block.
        for run in column.levels.chunk_by(|a, b| step(a) == step(b)) {
            let (from, colour) = (row, step(&run[0]));
            row += run.len();
            if colour > 0 {
                let top = (height(row) - OVERLAP).max(panel.down.0);
                canvas.fill_rect((across.0, height(from)), (across.1, top), ink(colour));
            }
        }
    }
    draw_colour_bar(canvas, (panel.across.1, panel.down), scale, &map.label);
}

/// Draws the colour bar to the right of a map whose right edge is `left`.
pub(super) fn draw_colour_bar(
    canvas: &mut Canvas,
    (left, down): (f64, (f64, f64)),
    scale: (f64, f64),
    name: &str,
) {
    let bar = Panel::new((left + 16.0, left + 30.0), down, (0.0, 1.0), scale);
    for k in 0..STEPS {
        let level = |k: usize| scale.0 + (scale.1 - scale.0) * k as f64 / STEPS as f64;
        let (from, to) = (bar.canvas_y(level(k)), bar.canvas_y(level(k + 1)));
        canvas.fill_rect(
            (bar.across.0, from),
            (bar.across.1, (to - OVERLAP).max(down.0)),
            ink(k),
        );
    }
    canvas.stroke_rect((bar.across.0, down.0), (bar.across.1, down.1), GREY, 0.6);
    for level in ticks(scale, 6) {
        // Ticks are multiples of a round step up to rounding.
        let text = format!("{}", (1e6 * level).round() / 1e6).replace('-', "−");
        let spot = (bar.across.1 + 5.0, bar.canvas_y(level));
        canvas.label(&text, spot, Anchor::Start);
    }
    let middle = 0.5 * (down.0 + down.1);
    canvas.upright(name, (WIDTH - 12.0, middle));
}

/// Map reduced to visible cells; a merged cell has the largest of its levels.
pub(super) struct MapCells {
    /// Columns by rising abscissa; gaps of the record are preserved.
    pub(super) columns: Vec<MapColumn>,
    /// Lower edge of the lowest cell.
    pub(super) low: f64,
    /// Height of a cell.
    pub(super) step: f64,
}

/// Column of a reduced map.
pub(super) struct MapColumn {
    /// Left edge.
    pub(super) from: f64,
    /// Right edge.
    pub(super) to: f64,
    /// Levels in dB, by rising ordinate.
    pub(super) levels: Vec<f64>,
}

impl MapCells {
    /// Merges the levels of a map into at most `cells` cells across and down.
    pub(super) fn from_map(map: &LevelMap, cells: (usize, usize)) -> MapCells {
        let least_step = |values: &[f64]| {
            let steps = values.windows(2).map(|w| w[1] - w[0]);
            steps.reduce(f64::min).unwrap_or(1.0)
        };
        let (interval, spacing) = (least_step(&map.x), least_step(&map.y));
        let merged = (
            map.x.len().div_ceil(cells.0).max(1),
            map.y.len().div_ceil(cells.1).max(1),
        );
        // Columns are merged only within a run without gaps.
        const MAP_SPACING: f64 = 1.5;
        let columns: Vec<(f64, &Vec<f64>)> = map.x.iter().copied().zip(&map.columns).collect();
        let runs = columns.chunk_by(|a, b| b.0 - a.0 < MAP_SPACING * interval);
        let column = |group: &[(f64, &Vec<f64>)]| {
            let largest = |rows: std::ops::Range<usize>| {
                let levels = group.iter().filter_map(|c| c.1.get(rows.clone())).flatten();
                levels.copied().fold(f64::NEG_INFINITY, f64::max)
            };
            let count = map.y.len();
            let starts = (0..count).step_by(merged.1);
            MapColumn {
                from: group[0].0 - 0.5 * interval,
                to: group[group.len() - 1].0 + 0.5 * interval,
                levels: starts
                    .map(|k| largest(k..(k + merged.1).min(count)))
                    .collect(),
            }
        };
        MapCells {
            columns: runs
                .flat_map(|run| run.chunks(merged.0).map(column))
                .collect(),
            low: map.y.first().map_or(0.0, |f| f - 0.5 * spacing),
            step: merged.1 as f64 * spacing,
        }
    }

    /// Lower and upper end of the colour scale, dB; `None` without finite levels.
    pub(super) fn scale(&self) -> Option<(f64, f64)> {
        let levels = self.columns.iter().flat_map(|c| &c.levels);
        let mut sorted: Vec<f64> = levels.copied().filter(|l| l.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let high = *sorted.last()?;
        let low = sorted[(CLIPPED * sorted.len() as f64) as usize].max(high - DYNAMIC_RANGE_DB);
        Some((low.min(high - 1.0), high))
    }
}

/// Colour number of a level, 0 to `STEPS` − 1.
pub(super) fn colour_step(level: f64, (low, high): (f64, f64)) -> usize {
    let share = (level - low) / (high - low);
    ((share * STEPS as f64).max(0.0) as usize).min(STEPS - 1)
}

/// Colour of the viridis scale by its number, 0 to `STEPS` − 1.
pub(super) fn ink(step: usize) -> Colour {
    let position = step as f64 / (STEPS - 1) as f64 * (SCALE.len() - 1) as f64;
    let lower = (position as usize).min(SCALE.len() - 2);
    let (start, end, weight) = (SCALE[lower], SCALE[lower + 1], position - lower as f64);
    let blend = |a: f64, b: f64| (a + weight * (b - a)).round() as u8;
    colour_from_rgb(
        blend(start.0, end.0),
        blend(start.1, end.1),
        blend(start.2, end.2),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::svg::render_svg;

    /// A diagonal line on a sparse map of 480 × 400 cells has steps of one cell: one background and one block per column.
    #[test]
    fn exact_lines_have_no_stairs() {
        let (across, down) = (480, 400);
        let column = |i: usize| -> Vec<f64> {
            let line = i * down / across;
            let level = |k| if k == line { 0.0 } else { f64::NEG_INFINITY };
            (0..down).map(level).collect()
        };
        let indices = |n: usize| (0..n).map(|k| k as f64).collect::<Vec<_>>();
        let map = LevelMap {
            label: "dB".into(),
            x: indices(across),
            y: indices(down),
            columns: (0..across).map(column).collect(),
            sparse: true,
        };
        let cells = MapCells::from_map(&map, limits(&map));
        assert_eq!(
            (cells.columns.len(), cells.columns[0].levels.len()),
            (across, down)
        );
        let ranges = map_ranges(&map).unwrap();
        let panel = Panel::new((0.0, 480.0), (0.0, 400.0), ranges.0, ranges.1);
        let svg = render_svg(WIDTH, 440.0, |canvas| draw_map(canvas, &panel, &map));
        // Paper, background, one block per column, colour bar.
        assert_eq!(svg.matches("<rect").count(), 2 + across + STEPS);
        let merged = LevelMap {
            sparse: false,
            ..map
        };
        assert!(MapCells::from_map(&merged, limits(&merged)).columns.len() <= CELLS.0);
    }
}
