//! SVG canvas: colours, line styles, text sizes, panels with axes.
//!
//! Lengths are in points of the finished plot.

use plotters::prelude::{DrawingBackend, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontTransform, IntoFont, RGBColor, ShapeStyle, TextStyle};

use crate::numeric::sorting::rising_order;

/// An ink.
pub type Colour = RGBColor;

/// Colour of the first curve.
pub const BLACK: Colour = RGBColor(0x1a, 0x1a, 0x1a);

/// Colour of the second curve.
pub const GREY: Colour = RGBColor(0x80, 0x80, 0x80);

/// Grids and fills that must not draw the eye.
pub const LIGHT_GREY: Colour = RGBColor(0xd8, 0xd8, 0xd8);

/// The first colour; in grey print darker than `GREY`.
pub const BLUE: Colour = RGBColor(0x00, 0x5a, 0xa0);

/// The second colour; in grey print lighter than `BLUE`.
pub const ORANGE: Colour = RGBColor(0xd0, 0x6a, 0x00);

/// The paper.
const WHITE: Colour = RGBColor(0xff, 0xff, 0xff);

/// Width of every plot.
pub const WIDTH: f64 = 900.0;

/// Text of axes and labels.
pub const LABEL_SIZE: f64 = 11.0;

/// Text of titles.
pub const TITLE_SIZE: f64 = 12.5;

/// Dash and gap of a dashed line.
const DASH: (f64, f64) = (6.0, 4.0);

/// Dash and gap of a dotted line.
const DOT: (f64, f64) = (1.6, 3.4);

/// The backend counts in whole units; so many make a point.
const UNITS_PER_POINT: f64 = 8.0;

/// Halfway to the paper.
pub fn lighten(ink: Colour) -> Colour {
    let half = |x: u8| x + (255 - x) / 2;
    RGBColor(half(ink.0), half(ink.1), half(ink.2))
}

/// The ink of three parts, 0 to 255.
pub fn colour_from_rgb(red: u8, green: u8, blue: u8) -> Colour {
    RGBColor(red, green, blue)
}

/// Style of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineStyle {
    /// Without a break.
    Solid,
    /// In dashes.
    Dashed,
    /// In dots.
    Dotted,
}

/// Anchor of a text at its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// It begins there.
    Start,
    /// Centred on the point.
    Middle,
    /// It ends there.
    End,
}

/// A place on the plot: to the right, downwards.
pub type Point2 = (f64, f64);

/// A plot being drawn.
pub struct Canvas<'a> {
    backend: SVGBackend<'a>,
}

/// Left edge of the title of a drawing without axes, points.
pub const TITLE_LEFT: f64 = 14.0;

/// Height that the title of a drawing takes, points.
pub fn title_height(title: &str) -> f64 {
    if title.is_empty() { 0.0 } else { 20.0 }
}

/// Draws one plot and returns it as SVG.
pub fn render_svg(width: f64, height: f64, draw: impl FnOnce(&mut Canvas)) -> String {
    let (w, h) = (fine(width), fine(height));
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

fn fine(length: f64) -> i32 {
    const FAR: f64 = 1e5; // well off any picture, and far from the end of i32
    (length.clamp(-FAR, FAR) * UNITS_PER_POINT).round() as i32
}

fn place(spot: Point2) -> (i32, i32) {
    (fine(spot.0), fine(spot.1))
}

// A backend that writes into a string has nothing to fail at: its results are left alone.
impl Canvas<'_> {
    /// A straight line.
    pub fn line(&mut self, from: Point2, to: Point2, ink: Colour, width: f64) {
        let _ = self
            .backend
            .draw_line(place(from), place(to), &stroke(ink, width));
    }

    /// A line through all points, as one `polyline` where solid.
    pub fn polyline(&mut self, points: &[Point2], ink: Colour, width: f64, kind: LineStyle) {
        let pieces = match kind {
            LineStyle::Solid => vec![points.to_vec()],
            LineStyle::Dashed => dashes(points, DASH),
            LineStyle::Dotted => dashes(points, DOT),
        };
        for piece in pieces.iter().filter(|piece| piece.len() > 1) {
            let spots = piece.iter().map(|&spot| place(spot));
            let _ = self.backend.draw_path(spots, &stroke(ink, width));
        }
    }

    /// A disc.
    pub fn fill_circle(&mut self, centre: Point2, radius: f64, ink: Colour) {
        let style = ShapeStyle::from(&ink).filled();
        let _ = self
            .backend
            .draw_circle(place(centre), fine(radius) as u32, &style, true);
    }

    /// A circle.
    pub fn stroke_circle(&mut self, centre: Point2, radius: f64, ink: Colour, width: f64) {
        let style = stroke(ink, width);
        let _ = self
            .backend
            .draw_circle(place(centre), fine(radius) as u32, &style, false);
    }

    /// A filled rectangle between two opposite corners.
    pub fn fill_rect(&mut self, one: Point2, other: Point2, ink: Colour) {
        let low = (one.0.min(other.0), one.1.min(other.1));
        let high = (one.0.max(other.0), one.1.max(other.1));
        let style = ShapeStyle::from(&ink).filled();
        let _ = self
            .backend
            .draw_rect(place(low), place(high), &style, true);
    }

    /// The outline of a rectangle.
    pub fn stroke_rect(&mut self, low: Point2, high: Point2, ink: Colour, width: f64) {
        let corners = [low, (high.0, low.1), high, (low.0, high.1)];
        for (i, &corner) in corners.iter().enumerate() {
            self.line(corner, corners[(i + 1) % 4], ink, width);
        }
    }

    /// A text, centred on the height of its point.
    pub fn text(&mut self, text: &str, spot: Point2, size: f64, ink: Colour, anchor: Anchor) {
        self.write(text, spot, size, ink, anchor, FontTransform::None);
    }

    /// The title of a figure, above its left edge; none where it is empty.
    pub fn title(&mut self, text: &str, left: f64) {
        if text.is_empty() {
            return;
        }
        self.text(text, (left, 16.0), TITLE_SIZE, BLACK, Anchor::Start);
    }

    /// A label.
    pub fn label(&mut self, text: &str, spot: Point2, anchor: Anchor) {
        self.text(text, spot, LABEL_SIZE, BLACK, anchor);
    }

    /// A label that must not draw the eye.
    pub fn note(&mut self, text: &str, spot: Point2, anchor: Anchor) {
        self.text(text, spot, LABEL_SIZE, GREY, anchor);
    }

    /// A line with its name, for a key above a figure; where its text ends.
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

    /// A bar of a round length up to `longest`, m, that ends at a point, and its length; of a drawing of so many points a metre.
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

    /// A text in place of a missing curve, about its middle.
    pub fn placeholder(&mut self, text: &str, middle: Point2) {
        self.text(text, middle, TITLE_SIZE, GREY, Anchor::Middle);
    }

    /// A label that reads upwards, about its middle.
    pub fn upright(&mut self, text: &str, middle: Point2) {
        self.vertical_text(text, middle, LABEL_SIZE, BLACK, Anchor::Middle);
    }

    /// A text that reads upwards, centred on the width of its point.
    pub fn vertical_text(
        &mut self,
        text: &str,
        spot: Point2,
        size: f64,
        ink: Colour,
        anchor: Anchor,
    ) {
        self.write(text, spot, size, ink, anchor, FontTransform::Rotate270);
    }

    fn write(
        &mut self,
        text: &str,
        spot: Point2,
        size: f64,
        ink: Colour,
        anchor: Anchor,
        turn: FontTransform,
    ) {
        if text.is_empty() {
            return;
        }
        const BACKEND_SHRINKS: f64 = 1.24; // plotters-svg 0.3 divides every size by this
        let across = match anchor {
            Anchor::Start => HPos::Left,
            Anchor::Middle => HPos::Center,
            Anchor::End => HPos::Right,
        };
        let style =
            TextStyle::from(("sans-serif", size * UNITS_PER_POINT * BACKEND_SHRINKS).into_font())
                .color(&ink)
                .pos(Pos::new(across, VPos::Center))
                .transform(turn);
        let _ = self.backend.draw_text(text, &style, place(spot));
    }
}

fn stroke(ink: Colour, width: f64) -> ShapeStyle {
    ShapeStyle::from(&ink).stroke_width((width * UNITS_PER_POINT).round().max(1.0) as u32)
}

/// The pieces of a line that are drawn, by length along it.
fn dashes(points: &[Point2], (dash, gap): (f64, f64)) -> Vec<Vec<Point2>> {
    let mut pieces = Vec::new();
    let mut piece: Vec<Point2> = points.first().copied().into_iter().collect();
    let (mut drawn, mut left) = (true, dash);
    for pair in points.windows(2) {
        let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
        let length = (x1 - x0).hypot(y1 - y0);
        if !length.is_finite() {
            continue;
        }
        let mut gone = 0.0;
        while length - gone > left {
            gone += left;
            let spot = (
                x0 + (x1 - x0) * gone / length,
                y0 + (y1 - y0) * gone / length,
            );
            if drawn {
                piece.push(spot);
                pieces.push(std::mem::take(&mut piece));
            } else {
                piece.push(spot);
            }
            drawn = !drawn;
            left = if drawn { dash } else { gap };
        }
        left -= length - gone;
        if drawn {
            piece.push((x1, y1));
        }
    }
    pieces.push(piece);
    pieces
}

/// A rectangle of the plot with a scale on each side.
#[derive(Debug, Clone, Copy)]
pub struct Panel {
    /// Left and right edges.
    pub across: (f64, f64),
    /// Upper and lower edges.
    pub down: (f64, f64),
    /// Values at the left and right edges.
    pub x: (f64, f64),
    /// Values at the lower and upper edges.
    pub y: (f64, f64),
}

impl Panel {
    /// A panel between edges, left and right, upper and lower, with the values there.
    pub fn new(across: (f64, f64), down: (f64, f64), x: (f64, f64), y: (f64, f64)) -> Panel {
        Panel { across, down, x, y }
    }

    /// The outline.
    pub fn draw_outline(&self, canvas: &mut Canvas) {
        let (left, right) = self.across;
        canvas.stroke_rect((left, self.down.0), (right, self.down.1), GREY, 0.6);
    }

    /// A line from the upper to the lower edge.
    pub fn draw_vertical(&self, canvas: &mut Canvas, right: f64, ink: Colour, width: f64) {
        canvas.line((right, self.down.0), (right, self.down.1), ink, width);
    }

    /// A line from the left to the right edge.
    pub fn draw_horizontal(&self, canvas: &mut Canvas, height: f64, ink: Colour, width: f64) {
        canvas.line((self.across.0, height), (self.across.1, height), ink, width);
    }

    /// Canvas position of a point of the diagram.
    pub fn to_canvas(&self, x: f64, y: f64) -> Point2 {
        (self.canvas_x(x), self.canvas_y(y))
    }

    /// Canvas position of a value of the horizontal axis.
    pub fn canvas_x(&self, x: f64) -> f64 {
        self.across.0 + (self.across.1 - self.across.0) * part(x, self.x)
    }

    /// Canvas position of a value of the vertical axis.
    pub fn canvas_y(&self, y: f64) -> f64 {
        self.down.1 - (self.down.1 - self.down.0) * part(y, self.y)
    }

    /// Grid and numbers of the vertical axis.
    pub fn draw_y_grid(&self, canvas: &mut Canvas, values: &[f64]) {
        for (&value, text) in values.iter().zip(numbers(values)) {
            let height = self.canvas_y(value);
            self.draw_horizontal(canvas, height, LIGHT_GREY, 0.5);
            canvas.label(&text, (self.across.0 - 5.0, height), Anchor::End);
        }
    }

    /// Grid and numbers of the horizontal axis.
    pub fn draw_x_grid(&self, canvas: &mut Canvas, values: &[f64]) {
        for (&value, text) in values.iter().zip(numbers(values)) {
            self.draw_x_mark(canvas, value, &text);
        }
    }

    /// A line of the grid at a value of the horizontal axis, with its text below.
    pub fn draw_x_mark(&self, canvas: &mut Canvas, value: f64, text: &str) {
        let right = self.canvas_x(value);
        self.draw_vertical(canvas, right, LIGHT_GREY, 0.5);
        canvas.label(text, (right, self.down.1 + 11.0), Anchor::Middle);
    }

    /// The name of the horizontal axis, so far below it.
    pub fn draw_x_name(&self, canvas: &mut Canvas, name: &str, below: f64) {
        let middle = 0.5 * (self.across.0 + self.across.1);
        canvas.label(name, (middle, self.down.1 + below), Anchor::Middle);
    }

    /// The name of the vertical axis, at the edge of the figure.
    pub fn draw_y_name(&self, canvas: &mut Canvas, name: &str) {
        canvas.upright(name, (14.0, 0.5 * (self.down.0 + self.down.1)));
    }
}

/// Which part of a range lies below a value; the middle of an empty range.
fn part(value: f64, (low, high): (f64, f64)) -> f64 {
    let span = high - low;
    if span > 0.0 {
        (value - low) / span
    } else {
        0.5
    }
}

/// Round numbers within a range, about so many.
pub fn ticks((low, high): (f64, f64), about: usize) -> Vec<f64> {
    let rough = (high - low) / about.max(1) as f64;
    if !(rough > 0.0 && rough.is_finite()) {
        return vec![low];
    }
    let decade = 10f64.powf(rough.log10().floor());
    let steps = [0.5, 1.0, 2.0, 5.0, 10.0].map(|s| s * decade);
    let at = steps.iter().position(|&s| s >= rough).unwrap_or(0);
    // An axis with one number has no scale: at least two steps.
    let is_short = at > 0 && high - low < 2.0 * steps[at];
    let step = steps[if is_short { at - 1 } else { at }];
    let slack = 1e-9 * step; // so that an end that is a round number itself is kept
    let first = ((low - slack) / step).ceil();
    (0..=2 * about)
        .map(|i| (first + i as f64) * step)
        .take_while(|&value| value <= high + slack)
        .collect()
}

/// Equally spaced values as an axis shows them: with the decimals that distinguish them, and one power of ten where these or
/// the digits before them would be many.
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

/// A positive number with so many significant digits.
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

/// A frequency as titles have it.
pub fn hertz(frequency_hz: f64) -> String {
    match frequency_hz {
        0.0 => "0 Hz".to_string(),
        f => format!("{} Hz", significant(f, 4)),
    }
}

/// A name short enough for a label.
pub fn truncate_label(name: &str, longest: usize) -> String {
    if name.chars().count() <= longest {
        return name.to_string();
    }
    let kept: String = name.chars().take(longest.saturating_sub(1)).collect();
    format!("{kept}…")
}

/// About how wide a text is.
pub fn text_width(text: &str, size: f64) -> f64 {
    const WIDE: f64 = 0.57; // of the size, per character: wide sans-serif faces; narrow ones leave some room
    text.chars().count() as f64 * size * WIDE
}

/// About how wide the widest of texts is, `least` at least.
pub fn widest<T: AsRef<str>>(texts: impl IntoIterator<Item = T>, size: f64, least: f64) -> f64 {
    let widths = texts
        .into_iter()
        .map(|text| text_width(text.as_ref(), size));
    widths.fold(least, f64::max)
}

/// Moves places apart until neighbours keep a distance, staying in order and within a range where it has room.
///
/// Places come in any order and keep theirs; the first pass pushes down, the second back up from the end.
pub fn spread_labels(wanted: &[f64], distance: f64, (low, high): (f64, f64)) -> Vec<f64> {
    let order = rising_order(wanted.iter().copied());
    let room = (high - low) / wanted.len().saturating_sub(1).max(1) as f64;
    let distance = distance.min(room.max(0.0));
    let mut places = wanted.to_vec();
    let mut least = low;
    for &i in &order {
        places[i] = places[i].max(least);
        least = places[i] + distance;
    }
    let mut most = high;
    for &i in order.iter().rev() {
        places[i] = places[i].min(most);
        most = places[i] - distance;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::{numbers, ticks};

    /// Every axis has two numbers at least, and not many more than requested.
    #[test]
    fn law_ticks() {
        let mut rng = fastrand::Rng::with_seed(5);
        for _ in 0..2000 {
            let low = 20.0 * rng.f64() - 10.0;
            let high = low + 10f64.powf(6.0 * rng.f64() - 3.0);
            for about in [4, 5, 8] {
                let found = ticks((low, high), about);
                assert!(
                    (2..=2 * about).contains(&found.len()),
                    "{low} {high} {about}: {found:?}"
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
