//! SVG canvas: colours, line styles, text sizes, panels with axes.
//!
//! Lengths are in points of the finished plot.

use plotters::prelude::{DrawingBackend, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontTransform, IntoFont, RGBColor, ShapeStyle, TextStyle};

use crate::numeric::sorting::ascending_order;

/// Colour of a line, fill or text.
pub type Colour = RGBColor;

/// Colour of the first curve.
pub const BLACK: Colour = RGBColor(0x1a, 0x1a, 0x1a);

/// Colour of the second curve.
pub const GREY: Colour = RGBColor(0x80, 0x80, 0x80);

/// Colour of grids and faint fills.
pub const LIGHT_GREY: Colour = RGBColor(0xd8, 0xd8, 0xd8);

/// Blue of curves; in grey print darker than `GREY`.
pub const BLUE: Colour = RGBColor(0x00, 0x5a, 0xa0);

/// Orange of curves; in grey print lighter than `BLUE`.
pub const ORANGE: Colour = RGBColor(0xd0, 0x6a, 0x00);

/// Background colour.
const WHITE: Colour = RGBColor(0xff, 0xff, 0xff);

/// Width of a plot, points.
pub const WIDTH: f64 = 900.0;

/// Text size of axes and labels, points.
pub const LABEL_SIZE: f64 = 11.0;

/// Text size of titles, points.
pub const TITLE_SIZE: f64 = 12.5;

/// Dash and gap of a dashed line, points.
const DASH: (f64, f64) = (6.0, 4.0);

/// Dash and gap of a dotted line, points.
const DOT: (f64, f64) = (1.6, 3.4);

/// Integer units of the backend per point.
const UNITS_PER_POINT: f64 = 8.0;

/// Lightens a colour halfway to white.
pub fn lighten(ink: Colour) -> Colour {
    let half = |x: u8| x + (255 - x) / 2;
    RGBColor(half(ink.0), half(ink.1), half(ink.2))
}

/// Colour from red, green and blue, 0 to 255.
pub fn colour_from_rgb(red: u8, green: u8, blue: u8) -> Colour {
    RGBColor(red, green, blue)
}

/// Style of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineStyle {
    /// Continuous line.
    Solid,
    /// Dashed line.
    Dashed,
    /// Dotted line.
    Dotted,
}

/// Anchor of a text at its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// Text starts at the point.
    Start,
    /// Text centred on the point.
    Middle,
    /// Text ends at the point.
    End,
}

/// Position on the plot, points: to the right, downwards.
pub type Point2 = (f64, f64);

/// Canvas of a plot.
pub struct Canvas<'a> {
    backend: SVGBackend<'a>,
}

/// Left edge of the title of a drawing without axes, points.
pub const TITLE_LEFT: f64 = 14.0;

/// Height of the title of a drawing, points.
pub fn title_height(title: &str) -> f64 {
    if title.is_empty() { 0.0 } else { 20.0 }
}

/// Draws one plot and returns it as SVG.
pub fn render_svg(width: f64, height: f64, draw: impl FnOnce(&mut Canvas)) -> String {
    let (w, h) = (to_units(width), to_units(height));
    let mut svg = String::new();
    let mut canvas = Canvas {
        backend: SVGBackend::with_string(&mut svg, (w as u32, h as u32)),
    };
    canvas.fill_rect((0.0, 0.0), (width, height), WHITE);
    draw(&mut canvas);
    drop(canvas);
    let counted = format!("width=\"{w}\" height=\"{h}\"");
    svg.replacen(
        &counted,
        &format!("width=\"{width:.0}\" height=\"{height:.0}\""),
        1,
    )
}

fn to_units(length: f64) -> i32 {
    const FAR: f64 = 1e5; // outside any plot, and within i32
    (length.clamp(-FAR, FAR) * UNITS_PER_POINT).round() as i32
}

fn to_backend(point: Point2) -> (i32, i32) {
    (to_units(point.0), to_units(point.1))
}

// Writing into a string cannot fail: the results of the backend are ignored.
impl Canvas<'_> {
    /// Draws a straight line.
    pub fn line(&mut self, from: Point2, to: Point2, ink: Colour, width: f64) {
        let _ = self
            .backend
            .draw_line(to_backend(from), to_backend(to), &stroke(ink, width));
    }

    /// Draws a line through all points, a solid one as a single `polyline`.
    pub fn polyline(&mut self, points: &[Point2], ink: Colour, width: f64, kind: LineStyle) {
        let pieces = match kind {
            LineStyle::Solid => vec![points.to_vec()],
            LineStyle::Dashed => dashes(points, DASH),
            LineStyle::Dotted => dashes(points, DOT),
        };
        for piece in pieces.iter().filter(|piece| piece.len() > 1) {
            let spots = piece.iter().map(|&point| to_backend(point));
            let _ = self.backend.draw_path(spots, &stroke(ink, width));
        }
    }

    /// Draws a filled circle.
    pub fn fill_circle(&mut self, centre: Point2, radius: f64, ink: Colour) {
        let style = ShapeStyle::from(&ink).filled();
        let _ = self
            .backend
            .draw_circle(to_backend(centre), to_units(radius) as u32, &style, true);
    }

    /// Draws the outline of a circle.
    pub fn stroke_circle(&mut self, centre: Point2, radius: f64, ink: Colour, width: f64) {
        let style = stroke(ink, width);
        let _ =
            self.backend
                .draw_circle(to_backend(centre), to_units(radius) as u32, &style, false);
    }

    /// Draws a filled rectangle between two opposite corners.
    pub fn fill_rect(&mut self, corner: Point2, opposite: Point2, ink: Colour) {
        let low = (corner.0.min(opposite.0), corner.1.min(opposite.1));
        let high = (corner.0.max(opposite.0), corner.1.max(opposite.1));
        let style = ShapeStyle::from(&ink).filled();
        let _ = self
            .backend
            .draw_rect(to_backend(low), to_backend(high), &style, true);
    }

    /// Draws the outline of a rectangle.
    pub fn stroke_rect(&mut self, low: Point2, high: Point2, ink: Colour, width: f64) {
        let corners = [low, (high.0, low.1), high, (low.0, high.1)];
        for (i, &corner) in corners.iter().enumerate() {
            self.line(corner, corners[(i + 1) % 4], ink, width);
        }
    }

    /// Writes a text, vertically centred on its point.
    pub fn text(&mut self, text: &str, point: Point2, size: f64, ink: Colour, anchor: Anchor) {
        self.write(text, point, size, ink, anchor, FontTransform::None);
    }

    /// Writes the title of a figure above its left edge.
    pub fn title(&mut self, text: &str, left: f64) {
        if text.is_empty() {
            return;
        }
        self.text(text, (left, 16.0), TITLE_SIZE, BLACK, Anchor::Start);
    }

    /// Writes a label.
    pub fn label(&mut self, text: &str, point: Point2, anchor: Anchor) {
        self.text(text, point, LABEL_SIZE, BLACK, anchor);
    }

    /// Writes a label in grey.
    pub fn note(&mut self, text: &str, point: Point2, anchor: Anchor) {
        self.text(text, point, LABEL_SIZE, GREY, anchor);
    }

    /// Draws a key entry, line and name; returns the right end of its text, points.
    pub fn key_entry(
        &mut self,
        (left, height): Point2,
        text: &str,
        ink: Colour,
        width: f64,
    ) -> f64 {
        self.line((left, height), (left + 18.0, height), ink, width);
        self.label(text, (left + 23.0, height), Anchor::Start);
        left + 23.0 + text_width(text, LABEL_SIZE)
    }

    /// Draws a scale bar of a round length up to `longest`, m, with its right end at a point.
    pub fn length_bar(&mut self, points_per_metre: f64, longest: f64, (right, y): Point2) {
        let longest = 1e3 * longest;
        let decade = 10f64.powf(longest.log10().floor());
        let steps = [1.0, 2.0, 5.0].into_iter().map(|step| step * decade);
        let length = steps.filter(|step| *step <= longest).fold(decade, f64::max);
        let left = right - 1e-3 * length * points_per_metre;
        self.line((left, y), (right, y), BLACK, 1.6);
        let text = format!("{length} mm");
        self.text(&text, (left - 6.0, y), LABEL_SIZE - 1.0, BLACK, Anchor::End);
    }

    /// Writes a text in place of a missing curve, centred.
    pub fn placeholder(&mut self, text: &str, middle: Point2) {
        self.text(text, middle, TITLE_SIZE, GREY, Anchor::Middle);
    }

    /// Writes a vertical label, centred.
    pub fn upright(&mut self, text: &str, middle: Point2) {
        self.vertical_text(text, middle, LABEL_SIZE, BLACK, Anchor::Middle);
    }

    /// Writes a vertical text, horizontally centred on its point.
    pub fn vertical_text(
        &mut self,
        text: &str,
        point: Point2,
        size: f64,
        ink: Colour,
        anchor: Anchor,
    ) {
        self.write(text, point, size, ink, anchor, FontTransform::Rotate270);
    }

    fn write(
        &mut self,
        text: &str,
        point: Point2,
        size: f64,
        ink: Colour,
        anchor: Anchor,
        rotation: FontTransform,
    ) {
        if text.is_empty() {
            return;
        }
        const BACKEND_SHRINKS: f64 = 1.24; // plotters-svg 0.3 divides every size by this
        let horizontal = match anchor {
            Anchor::Start => HPos::Left,
            Anchor::Middle => HPos::Center,
            Anchor::End => HPos::Right,
        };
        let style =
            TextStyle::from(("sans-serif", size * UNITS_PER_POINT * BACKEND_SHRINKS).into_font())
                .color(&ink)
                .pos(Pos::new(horizontal, VPos::Center))
                .transform(rotation);
        let _ = self.backend.draw_text(text, &style, to_backend(point));
    }
}

fn stroke(ink: Colour, width: f64) -> ShapeStyle {
    ShapeStyle::from(&ink).stroke_width((width * UNITS_PER_POINT).round().max(1.0) as u32)
}

/// Dashes of a polyline, by arc length.
fn dashes(points: &[Point2], (dash, gap): (f64, f64)) -> Vec<Vec<Point2>> {
    let mut pieces = Vec::new();
    let mut piece: Vec<Point2> = points.first().copied().into_iter().collect();
    let (mut is_dash, mut remaining) = (true, dash);
    for pair in points.windows(2) {
        let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
        let length = (x1 - x0).hypot(y1 - y0);
        if !length.is_finite() {
            continue;
        }
        let mut travelled = 0.0;
        while length - travelled > remaining {
            travelled += remaining;
            let point = (
                x0 + (x1 - x0) * travelled / length,
                y0 + (y1 - y0) * travelled / length,
            );
            if is_dash {
                piece.push(point);
                pieces.push(std::mem::take(&mut piece));
            } else {
                piece.push(point);
            }
            is_dash = !is_dash;
            remaining = if is_dash { dash } else { gap };
        }
        remaining -= length - travelled;
        if is_dash {
            piece.push((x1, y1));
        }
    }
    pieces.push(piece);
    pieces
}

/// Panel of a plot: rectangle with a scale on each axis.
#[derive(Debug, Clone, Copy)]
pub struct Panel {
    /// Left and right edges, points.
    pub across: (f64, f64),
    /// Upper and lower edges, points.
    pub down: (f64, f64),
    /// Values at the left and right edges.
    pub x: (f64, f64),
    /// Values at the lower and upper edges.
    pub y: (f64, f64),
}

impl Panel {
    /// Panel with its edges, left and right, upper and lower, and the values at them.
    pub fn new(across: (f64, f64), down: (f64, f64), x: (f64, f64), y: (f64, f64)) -> Panel {
        Panel { across, down, x, y }
    }

    /// Draws the outline.
    pub fn draw_outline(&self, canvas: &mut Canvas) {
        let (left, right) = self.across;
        canvas.stroke_rect((left, self.down.0), (right, self.down.1), GREY, 0.6);
    }

    /// Draws a line from the upper to the lower edge.
    pub fn draw_vertical(&self, canvas: &mut Canvas, right: f64, ink: Colour, width: f64) {
        canvas.line((right, self.down.0), (right, self.down.1), ink, width);
    }

    /// Draws a line from the left to the right edge.
    pub fn draw_horizontal(&self, canvas: &mut Canvas, height: f64, ink: Colour, width: f64) {
        canvas.line((self.across.0, height), (self.across.1, height), ink, width);
    }

    /// Canvas position of a point of the diagram.
    pub fn to_canvas(&self, x: f64, y: f64) -> Point2 {
        (self.canvas_x(x), self.canvas_y(y))
    }

    /// Canvas position of a value of the horizontal axis.
    pub fn canvas_x(&self, x: f64) -> f64 {
        self.across.0 + (self.across.1 - self.across.0) * fraction(x, self.x)
    }

    /// Canvas position of a value of the vertical axis.
    pub fn canvas_y(&self, y: f64) -> f64 {
        self.down.1 - (self.down.1 - self.down.0) * fraction(y, self.y)
    }

    /// Draws grid and numbers of the vertical axis.
    pub fn draw_y_grid(&self, canvas: &mut Canvas, values: &[f64]) {
        for (&value, text) in values.iter().zip(numbers(values)) {
            let height = self.canvas_y(value);
            self.draw_horizontal(canvas, height, LIGHT_GREY, 0.5);
            canvas.label(&text, (self.across.0 - 5.0, height), Anchor::End);
        }
    }

    /// Draws grid and numbers of the horizontal axis.
    pub fn draw_x_grid(&self, canvas: &mut Canvas, values: &[f64]) {
        for (&value, text) in values.iter().zip(numbers(values)) {
            self.draw_x_mark(canvas, value, &text);
        }
    }

    /// Draws a grid line at a value of the horizontal axis, with its text below.
    pub fn draw_x_mark(&self, canvas: &mut Canvas, value: f64, text: &str) {
        let right = self.canvas_x(value);
        self.draw_vertical(canvas, right, LIGHT_GREY, 0.5);
        canvas.label(text, (right, self.down.1 + 11.0), Anchor::Middle);
    }

    /// Writes the name of the horizontal axis at a distance below it, points.
    pub fn draw_x_name(&self, canvas: &mut Canvas, name: &str, below: f64) {
        let middle = 0.5 * (self.across.0 + self.across.1);
        canvas.label(name, (middle, self.down.1 + below), Anchor::Middle);
    }

    /// Writes the name of the vertical axis at the edge of the figure.
    pub fn draw_y_name(&self, canvas: &mut Canvas, name: &str) {
        canvas.upright(name, (14.0, 0.5 * (self.down.0 + self.down.1)));
    }
}

/// Fraction of a range below a value; 0.5 for an empty range.
fn fraction(value: f64, (low, high): (f64, f64)) -> f64 {
    let span = high - low;
    if span > 0.0 {
        (value - low) / span
    } else {
        0.5
    }
}

/// Ticks: round numbers within a range, about `count`.
pub fn ticks((low, high): (f64, f64), count: usize) -> Vec<f64> {
    let raw_step = (high - low) / count.max(1) as f64;
    if !(raw_step > 0.0 && raw_step.is_finite()) {
        return vec![low];
    }
    let decade = 10f64.powf(raw_step.log10().floor());
    let steps = [0.5, 1.0, 2.0, 5.0, 10.0].map(|s| s * decade);
    let index = steps.iter().position(|&s| s >= raw_step).unwrap_or(0);
    // An axis with one number has no scale: at least two steps.
    let is_short = index > 0 && high - low < 2.0 * steps[index];
    let step = steps[if is_short { index - 1 } else { index }];
    let slack = 1e-9 * step; // includes a round number at the end of the range
    let first = ((low - slack) / step).ceil();
    (0..=2 * count)
        .map(|i| (first + i as f64) * step)
        .take_while(|&value| value <= high + slack)
        .collect()
}

/// Formats equally spaced values of an axis with the decimals that distinguish them, and a common power of ten for many
/// digits.
fn numbers(values: &[f64]) -> Vec<String> {
    const MANY_NODES: f64 = 4.0;
    let largest = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let pairs = values.windows(2).map(|w| (w[1] - w[0]).abs());
    let step = pairs.fold(f64::INFINITY, f64::min);
    let decade = |x: f64| match x > 0.0 && x.is_finite() {
        true => (x * 1.000_001).log10().floor(),
        false => 0.0,
    };
    let (top, last) = (decade(largest), decade(step));
    let decimals = |power: f64| (power - last).clamp(0.0, 9.0) as usize;
    if last >= -MANY_NODES && top <= MANY_NODES + 2.0 {
        return values.iter().map(|v| number(*v, decimals(0.0))).collect();
    }
    let text = |v: &f64| match v.abs() < 1e-9 * largest {
        true => "0".to_string(),
        false => format!("{}e{top}", number(v / 10f64.powf(top), decimals(top))),
    };
    values.iter().map(text).collect()
}

fn number(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.to_string(),
        Some(rest) => format!("−{rest}"),
        None => text,
    }
}

/// Formats a number with `digits` significant digits.
pub fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return number(value, 0);
    }
    let decade = value.abs().log10().floor() as i32;
    if !(-4..7).contains(&decade) {
        return format!("{value:.*e}", (digits - 1).max(0) as usize);
    }
    let decimals = (digits - 1 - decade).max(0) as usize;
    number(value, decimals)
}

/// Formats a frequency for a title.
pub fn hertz(frequency_hz: f64) -> String {
    match frequency_hz {
        0.0 => "0 Hz".to_string(),
        f => format!("{} Hz", significant(f, 4)),
    }
}

/// Truncates a name to `max_length` characters.
pub fn truncate_label(name: &str, max_length: usize) -> String {
    if name.chars().count() <= max_length {
        return name.to_string();
    }
    let start: String = name.chars().take(max_length.saturating_sub(1)).collect();
    format!("{start}…")
}

/// Estimated width of a text, points.
pub fn text_width(text: &str, size: f64) -> f64 {
    const WIDE: f64 = 0.57; // of the size, per character: wide sans-serif faces; narrow ones leave some room
    text.chars().count() as f64 * size * WIDE
}

/// Estimated width of the widest text, points, at least `min_width`.
pub fn widest<T: AsRef<str>>(texts: impl IntoIterator<Item = T>, size: f64, min_width: f64) -> f64 {
    let widths = texts
        .into_iter()
        .map(|text| text_width(text.as_ref(), size));
    widths.fold(min_width, f64::max)
}

/// Spreads positions to a minimum spacing, in order and within a range if possible.
///
/// Positions may be unsorted; the first pass shifts them upwards in value, the second back from the end.
pub fn spread_labels(positions: &[f64], spacing: f64, (low, high): (f64, f64)) -> Vec<f64> {
    let order = ascending_order(positions.iter().copied());
    let room = (high - low) / positions.len().saturating_sub(1).max(1) as f64;
    let spacing = spacing.min(room.max(0.0));
    let mut spread = positions.to_vec();
    let mut lower = low;
    for &i in &order {
        spread[i] = spread[i].max(lower);
        lower = spread[i] + spacing;
    }
    let mut upper = high;
    for &i in order.iter().rev() {
        spread[i] = spread[i].min(upper);
        upper = spread[i] - spacing;
    }
    spread
}

#[cfg(test)]
mod tests {
    use super::{numbers, ticks};

    /// Every axis has at least two numbers and not many more than requested.
    #[test]
    fn law_ticks() {
        let mut rng = fastrand::Rng::with_seed(5);
        for _ in 0..2000 {
            let low = 20.0 * rng.f64() - 10.0;
            let high = low + 10f64.powf(6.0 * rng.f64() - 3.0);
            for count in [4, 5, 8] {
                let values = ticks((low, high), count);
                assert!(
                    (2..=2 * count).contains(&values.len()),
                    "{low} {high} {count}: {values:?}"
                );
            }
        }
        assert_eq!(ticks((-4.8, 4.8), 4), [-4.0, -2.0, 0.0, 2.0, 4.0]);
    }

    #[test]
    fn keeps_numbers_of_an_axis_short_and_apart() {
        for (values, texts) in [
            (&[-0.5, 0.0, 0.5][..], &["−0.5", "0.0", "0.5"][..]),
            (&[0.0, 2e-5, 1.2e-4], &["0", "0.2e-4", "1.2e-4"]),
            (&[0.0, 5e6, 1e7], &["0", "0.5e7", "1.0e7"]),
            (&[1000.0, 1500.0], &["1000", "1500"]),
            (&[-3e-300, -1e-300], &["−3e-300", "−1e-300"]),
            (&[0.0], &["0"]),
        ] {
            assert_eq!(numbers(values), texts);
        }
    }
}
