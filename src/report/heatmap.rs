//! Maps of levels over two axes: time or speed, and frequency.

use super::figure::LevelMap;
use super::svg::{Anchor, Canvas, Colour, GREY, Panel, WIDTH, colour_from_rgb, ticks};

/// Viridis of matplotlib (van der Walt & Smith 2015) at nine even steps: lightness rises evenly, in grey print too.
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

/// Colours distinguished.
const STEPS: usize = 48;

/// Cells across and down at most: what is finer no eye could distinguish, and no viewer would like to draw.
const PRINTED: (usize, usize) = (250, 140);

/// Cells of a map of narrow lines in an SVG file, across and down at most.
const PRINTED_SPARSE: (usize, usize) = (480, 400);

/// Levels shown below the largest at most, dB.
const DYNAMIC_RANGE_DB: f64 = 80.0;

/// The share of cells below the scale: the quietest of a noise floor are its accidents.
const BELOW: f64 = 0.02;

/// Blocks reach under those drawn after them, so that no paper shines through between two.
const OVERLAP: f64 = 1.0;

/// Ranges of both axes of a map; absent where it has no level.
pub(super) fn map_ranges(map: &LevelMap) -> Option<((f64, f64), (f64, f64))> {
    let cells = MapCells::from_map(map, printed(map));
    cells.scale()?;
    let (first, last) = (cells.columns.first()?, cells.columns.last()?);
    let top = cells.low + first.levels.len() as f64 * cells.step;
    Some(((first.from, last.to), (cells.low, top)))
}

/// Cells of a map in an SVG file.
fn printed(map: &LevelMap) -> (usize, usize) {
    match map.sparse {
        true => PRINTED_SPARSE,
        false => PRINTED,
    }
}

/// Draws a map inside a panel, with its scale of colours on the right.
pub(super) fn draw_map(canvas: &mut Canvas, panel: &Panel, map: &LevelMap) {
    let cells = MapCells::from_map(map, printed(map));
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
        let at = panel.canvas_y(cells.low + k as f64 * cells.step);
        at.clamp(panel.down.0, panel.down.1)
    };
    // The lowest colour is the ground of columns without a gap between them.
    let joined = |a: &MapColumn, b: &MapColumn| b.from - a.to < 0.5 * (a.to - a.from);
    for run in cells.columns.chunk_by(joined) {
        let (left, right) = across(run[0].from, run[run.len() - 1].to);
        let top = height(run[0].levels.len());
        canvas.fill_rect((left, height(0)), (right, top), ink(0));
    }
    for column in &cells.columns {
        let across = across(column.from, column.to);
        let step = |level: &f64| step_of(*level, scale);
        let mut at = 0;
        // Cells of one colour are one block.
        for run in column.levels.chunk_by(|a, b| step(a) == step(b)) {
            let (from, colour) = (at, step(&run[0]));
            at += run.len();
            if colour > 0 {
                let top = (height(at) - OVERLAP).max(panel.down.0);
                canvas.fill_rect((across.0, height(from)), (across.1, top), ink(colour));
            }
        }
    }
    draw_colour_bar(canvas, (panel.across.1, panel.down), scale, &map.label);
}

/// The scale of colours right of a map that ends at `left`.
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
        // Multiples of a round step, to rounding.
        let text = format!("{}", (1e6 * level).round() / 1e6).replace('-', "−");
        let spot = (bar.across.1 + 5.0, bar.canvas_y(level));
        canvas.label(&text, spot, Anchor::Start);
    }
    let middle = 0.5 * (down.0 + down.1);
    canvas.upright(name, (WIDTH - 12.0, middle));
}

/// The map in cells that an eye can distinguish, the largest level of those that fall together.
pub(super) struct MapCells {
    /// Columns by rising abscissa; a gap of the record stays one.
    pub(super) columns: Vec<MapColumn>,
    /// Lower edge of the lowest cell.
    pub(super) low: f64,
    /// Height of a cell.
    pub(super) step: f64,
}

/// A column of cells.
pub(super) struct MapColumn {
    /// Left edge.
    pub(super) from: f64,
    /// Right edge.
    pub(super) to: f64,
    /// Levels in dB, by rising ordinate.
    pub(super) levels: Vec<f64>,
}

impl MapCells {
    /// Merges the levels of a map into at most so many cells across and down.
    pub(super) fn from_map(map: &LevelMap, cells: (usize, usize)) -> MapCells {
        let gap = |all: &[f64]| {
            let steps = all.windows(2).map(|w| w[1] - w[0]);
            steps.reduce(f64::min).unwrap_or(1.0)
        };
        let (pace, spacing) = (gap(&map.x), gap(&map.y));
        let merged = (
            map.x.len().div_ceil(cells.0).max(1),
            map.y.len().div_ceil(cells.1).max(1),
        );
        // Columns that belong together follow each other: a gap of the record stays one.
        const MAP_SPACING: f64 = 1.5;
        let all: Vec<(f64, &Vec<f64>)> = map.x.iter().copied().zip(&map.columns).collect();
        let together = all.chunk_by(|a, b| b.0 - a.0 < MAP_SPACING * pace);
        let column = |all: &[(f64, &Vec<f64>)]| {
            let largest = |rows: std::ops::Range<usize>| {
                let levels = all.iter().filter_map(|c| c.1.get(rows.clone())).flatten();
                levels.copied().fold(f64::NEG_INFINITY, f64::max)
            };
            let count = map.y.len();
            let starts = (0..count).step_by(merged.1);
            MapColumn {
                from: all[0].0 - 0.5 * pace,
                to: all[all.len() - 1].0 + 0.5 * pace,
                levels: starts
                    .map(|k| largest(k..(k + merged.1).min(count)))
                    .collect(),
            }
        };
        MapCells {
            columns: together
                .flat_map(|run| run.chunks(merged.0).map(column))
                .collect(),
            low: map.y.first().map_or(0.0, |f| f - 0.5 * spacing),
            step: merged.1 as f64 * spacing,
        }
    }

    /// Levels at the ends of the colours, dB; absent where nothing is above zero.
    pub(super) fn scale(&self) -> Option<(f64, f64)> {
        let levels = self.columns.iter().flat_map(|c| &c.levels);
        let mut all: Vec<f64> = levels.copied().filter(|l| l.is_finite()).collect();
        all.sort_by(f64::total_cmp);
        let high = *all.last()?;
        let low = all[(BELOW * all.len() as f64) as usize].max(high - DYNAMIC_RANGE_DB);
        Some((low.min(high - 1.0), high))
    }
}

/// Which colour a level has.
pub(super) fn step_of(level: f64, (low, high): (f64, f64)) -> usize {
    let share = (level - low) / (high - low);
    ((share * STEPS as f64).max(0.0) as usize).min(STEPS - 1)
}

/// A colour of the scale.
pub(super) fn ink(step: usize) -> Colour {
    let place = step as f64 / (STEPS - 1) as f64 * (SCALE.len() - 1) as f64;
    let below = (place as usize).min(SCALE.len() - 2);
    let (one, other, share) = (SCALE[below], SCALE[below + 1], place - below as f64);
    let mixed = |a: f64, b: f64| (a + share * (b - a)).round() as u8;
    colour_from_rgb(
        mixed(one.0, other.0),
        mixed(one.1, other.1),
        mixed(one.2, other.2),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::svg::render_svg;

    /// A line across 480 × 400 cells: stairs no higher than a cell where it is sparse, one ground and one block a column.
    #[test]
    fn exact_lines_have_no_stairs() {
        let (across, down) = (480, 400);
        let column = |i: usize| -> Vec<f64> {
            let line = i * down / across;
            let level = |k| if k == line { 0.0 } else { f64::NEG_INFINITY };
            (0..down).map(level).collect()
        };
        let even = |n: usize| (0..n).map(|k| k as f64).collect::<Vec<_>>();
        let map = LevelMap {
            label: "dB".into(),
            x: even(across),
            y: even(down),
            columns: (0..across).map(column).collect(),
            sparse: true,
        };
        let cells = MapCells::from_map(&map, printed(&map));
        assert_eq!(
            (cells.columns.len(), cells.columns[0].levels.len()),
            (across, down)
        );
        let ranges = map_ranges(&map).unwrap();
        let panel = Panel::new((0.0, 480.0), (0.0, 400.0), ranges.0, ranges.1);
        let svg = render_svg(WIDTH, 440.0, |canvas| draw_map(canvas, &panel, &map));
        // Paper, ground, a block a column, the scale of colours.
        assert_eq!(svg.matches("<rect").count(), 2 + across + STEPS);
        let merged = LevelMap {
            sparse: false,
            ..map
        };
        assert!(MapCells::from_map(&merged, printed(&merged)).columns.len() <= PRINTED.0);
    }
}
