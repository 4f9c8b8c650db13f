//! Heatmaps: level over time or speed, and frequency.

use super::axes::draw_frame;
use super::svg::{
    Anchor, BLACK, Canvas, Colour, GREY, Panel, TITLE_SIZE, WIDTH, colour_from_rgb, render_svg,
    ticks,
};

/// Levels of one channel.
#[derive(Debug, Clone, Default)]
pub struct Heatmap {
    /// Above it.
    pub title: String,
    /// Quantity of the levels, with the unit of 0 dB.
    pub level: String,
    /// Name of the horizontal axis.
    pub across: String,
    /// Middles of the rows along that axis, rising.
    pub times: Vec<f64>,
    /// Lines, Hz, evenly rising.
    pub places: Vec<f64>,
    /// A density for each line of each row.
    pub rows: Vec<Vec<f64>>,
}

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
const CELLS: (usize, usize) = (250, 140);

/// Levels shown below the largest at most, dB.
const DYNAMIC_RANGE_DB: f64 = 80.0;

/// The share of cells below the scale: the quietest of a noise floor are its accidents.
const BELOW: f64 = 0.02;

/// Blocks reach under those drawn after them, so that no paper shines through between two.
const OVERLAP: f64 = 1.0;

const MARGIN_LEFT: f64 = 70.0;
const MARGIN_RIGHT: f64 = WIDTH - 96.0;

/// Draws one map below the other.
pub fn draw_heatmaps(shown: &[Heatmap]) -> String {
    const MARGIN_TOP: f64 = 44.0;
    const SPACING: f64 = 74.0;
    let high = if shown.len() == 1 { 420.0 } else { 240.0 };
    let pitch = high + SPACING;
    render_svg(WIDTH, MARGIN_TOP + shown.len() as f64 * pitch, |canvas| {
        for (at, map) in shown.iter().enumerate() {
            let top = MARGIN_TOP + at as f64 * pitch;
            canvas.text(
                &map.title,
                (MARGIN_LEFT, top - 14.0),
                TITLE_SIZE,
                BLACK,
                Anchor::Start,
            );
            draw(map, canvas, (top, top + high));
        }
    })
}

fn draw(map: &Heatmap, canvas: &mut Canvas, down: (f64, f64)) {
    let middle = (0.5 * (MARGIN_LEFT + MARGIN_RIGHT), 0.5 * (down.0 + down.1));
    let cells = HeatmapCells::from_heatmap(map);
    let Some((panel, scale)) = cells.panel(down).zip(cells.scale()) else {
        canvas.placeholder("nothing to show", middle);
        return;
    };
    panel.draw_y_grid(canvas, &ticks(panel.y, 6));
    draw_frame(&panel, canvas, "frequency, Hz", Some(&map.across));
    for column in &cells.columns {
        let across = (
            panel.canvas_x(column.from),
            (panel.canvas_x(column.to) + OVERLAP).min(MARGIN_RIGHT),
        );
        let step = |level: &f64| step_of(*level, scale);
        let mut at = 0;
        // Cells of one colour are one block.
        for run in column.levels.chunk_by(|a, b| step(a) == step(b)) {
            let ends = (at as f64, (at + run.len()) as f64);
            at += run.len();
            let height = |k: f64| panel.canvas_y(cells.low + k * cells.step);
            let upper = (height(ends.1) - OVERLAP).max(down.0);
            canvas.fill_rect(
                (across.0, height(ends.0)),
                (across.1, upper),
                ink(step(&run[0])),
            );
        }
    }
    draw_colour_bar(canvas, down, scale, &map.level);
}

/// The scale of colours next to the map.
pub(super) fn draw_colour_bar(
    canvas: &mut Canvas,
    down: (f64, f64),
    scale: (f64, f64),
    name: &str,
) {
    let bar = Panel::new(
        (MARGIN_RIGHT + 16.0, MARGIN_RIGHT + 30.0),
        down,
        (0.0, 1.0),
        scale,
    );
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
        let text = format!("{level:.0}").replace('-', "−");
        let spot = (bar.across.1 + 5.0, bar.canvas_y(level));
        canvas.label(&text, spot, Anchor::Start);
    }
    let middle = 0.5 * (down.0 + down.1);
    canvas.upright(name, (WIDTH - 12.0, middle));
}

/// The map in cells that an eye can distinguish, the largest level of those that fall together.
struct HeatmapCells {
    columns: Vec<MapColumn>,
    /// Lower edge of the lowest cell, and height of a cell, Hz.
    low: f64,
    step: f64,
}

struct MapColumn {
    /// Edges of the cell.
    from: f64,
    to: f64,
    /// dB, by rising frequency.
    levels: Vec<f64>,
}

impl HeatmapCells {
    fn from_heatmap(map: &Heatmap) -> HeatmapCells {
        let gap = |all: &[f64]| {
            let steps = all.windows(2).map(|w| w[1] - w[0]);
            steps.reduce(f64::min).unwrap_or(1.0)
        };
        let (pace, spacing) = (gap(&map.times), gap(&map.places));
        let merged = (
            map.times.len().div_ceil(CELLS.0).max(1),
            map.places.len().div_ceil(CELLS.1).max(1),
        );
        // Rows that belong together follow each other: a gap of the record stays one.
        const MAP_SPACING: f64 = 1.5;
        let rows: Vec<(f64, &Vec<f64>)> = map.times.iter().copied().zip(&map.rows).collect();
        let together = rows.chunk_by(|a, b| b.0 - a.0 < MAP_SPACING * pace);
        let column = |rows: &[(f64, &Vec<f64>)]| {
            let largest = |lines: std::ops::Range<usize>| {
                let all = rows.iter().filter_map(|r| r.1.get(lines.clone())).flatten();
                10.0 * all.copied().fold(0.0, f64::max).log10()
            };
            let count = map.places.len();
            let starts = (0..count).step_by(merged.1);
            MapColumn {
                from: rows[0].0 - 0.5 * pace,
                to: rows[rows.len() - 1].0 + 0.5 * pace,
                levels: starts
                    .map(|k| largest(k..(k + merged.1).min(count)))
                    .collect(),
            }
        };
        HeatmapCells {
            columns: together
                .flat_map(|run| run.chunks(merged.0).map(column))
                .collect(),
            low: map.places.first().map_or(0.0, |f| f - 0.5 * spacing),
            step: merged.1 as f64 * spacing,
        }
    }

    fn panel(&self, down: (f64, f64)) -> Option<Panel> {
        let (first, last) = (self.columns.first()?, self.columns.last()?);
        let lines = first.levels.len();
        (lines > 0).then_some(Panel::new(
            (MARGIN_LEFT, MARGIN_RIGHT),
            down,
            (first.from, last.to),
            (self.low, self.low + lines as f64 * self.step),
        ))
    }

    /// Levels at the ends of the colours, dB; absent where nothing is above zero.
    fn scale(&self) -> Option<(f64, f64)> {
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
