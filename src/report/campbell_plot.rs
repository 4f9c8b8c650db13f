//! Campbell plot: frequencies over speed, order lines `f = order · n / 60`, crossings as circles.

use super::svg::{
    Anchor, BLACK, BLUE, Canvas, Colour, GREY, LABEL_SIZE, LineStyle, ORANGE, Panel, Point2, WIDTH,
    render_svg, significant, spread_labels, text_width, ticks, truncate_label, widest,
};

/// Whirl of a mode as plotted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlottedWhirl {
    /// It runs round with the shaft.
    Forward,
    /// It runs round against the shaft.
    Backward,
    /// It does not run round: torsion, or motion in a plane.
    None,
}

/// One mode followed over speed.
#[derive(Debug, Clone)]
pub struct PlottedBranch {
    /// Label at the end of the curve.
    pub label: String,
    /// Whirl, which selects the line style.
    pub whirl: PlottedWhirl,
    /// Natural frequency at each speed, Hz; `None` where it was not followed.
    pub frequencies_hz: Vec<Option<f64>>,
}

/// One order of excitation.
#[derive(Debug, Clone)]
pub struct PlottedOrder {
    /// Label of the excitation.
    pub label: String,
    /// Excitations per turn of the shaft whose speed is on the axis.
    pub order: f64,
}

/// Crossing of an order and a mode.
#[derive(Debug, Clone, Copy)]
pub struct PlottedCrossing {
    /// Speed, rpm.
    pub speed_rpm: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Participation of the excited part in the mode, 0 to 1.
    pub participation: f64,
}

/// Everything a Campbell diagram shows.
#[derive(Debug, Clone, Default)]
pub struct CampbellPlot {
    /// Whose speed is on the axis.
    pub shaft: String,
    /// Speeds, rpm, rising.
    pub speeds_rpm: Vec<f64>,
    /// Modes.
    pub branches: Vec<PlottedBranch>,
    /// Orders.
    pub orders: Vec<PlottedOrder>,
    /// Crossings.
    pub crossings: Vec<PlottedCrossing>,
}

const MARGIN_LEFT: f64 = 64.0;
const HEIGHT: f64 = 440.0;
const MAX_NAME_LEN: usize = 30;

/// Draws a Campbell diagram.
pub fn draw_campbell(diagram: &CampbellPlot) -> String {
    let at_right = widest(diagram.right_texts(), LABEL_SIZE, 20.0);
    let top = 20.0 + widest(diagram.top_texts(), LABEL_SIZE, 0.0);
    let panel = Panel::new(
        (MARGIN_LEFT, WIDTH - at_right - 34.0),
        (top, top + HEIGHT),
        diagram.speed_range(),
        (0.0, diagram.highest()),
    );
    render_svg(WIDTH, top + HEIGHT + 66.0, |canvas| {
        if diagram.speeds_rpm.is_empty() || diagram.branches.is_empty() {
            let middle = (WIDTH / 2.0, top + HEIGHT / 2.0);
            canvas.placeholder("no modes", middle);
            return;
        }
        diagram.axes(canvas, &panel);
        let mut ends = diagram.draw_orders(canvas, &panel);
        ends.extend(diagram.draw_branches(canvas, &panel));
        label_right(canvas, &panel, &ends);
        diagram.draw_crossings(canvas, &panel);
        diagram.key(canvas, &panel);
    })
}

/// A label at the right edge, and the end of the line it names.
struct EdgeLabel {
    spot: Point2,
    text: String,
    ink: Colour,
}

impl PlottedOrder {
    fn text(&self) -> String {
        let order = significant(self.order, 5);
        let order = match order.contains('.') {
            true => order.trim_end_matches('0').trim_end_matches('.'),
            false => &order,
        };
        format!(
            "{order}×  {}",
            truncate_label(&self.label, MAX_NAME_LEN - 4)
        )
    }

    fn frequency_at(&self, speed_rpm: f64) -> f64 {
        self.order * speed_rpm / 60.0
    }
}

impl CampbellPlot {
    fn speed_range(&self) -> (f64, f64) {
        let first = self.speeds_rpm.first().copied().unwrap_or(0.0);
        (first, self.speeds_rpm.last().copied().unwrap_or(1.0))
    }

    /// The upper end of the frequency axis.
    fn highest(&self) -> f64 {
        let all = self.branches.iter().flat_map(|b| &b.frequencies_hz);
        let largest = all
            .flatten()
            .copied()
            .filter(|f| f.is_finite())
            .fold(0.0, f64::max);
        if largest > 0.0 { 1.06 * largest } else { 1.0 }
    }

    /// Orders that show: those that start below the upper edge.
    fn rays(&self) -> impl Iterator<Item = &PlottedOrder> {
        let (first, highest) = (self.speed_range().0, self.highest());
        self.orders
            .iter()
            .filter(move |o| o.order > 0.0 && o.frequency_at(first) < highest)
    }

    /// Names of the orders that leave at the upper edge.
    fn top_texts(&self) -> Vec<String> {
        let (last, highest) = (self.speed_range().1, self.highest());
        self.rays()
            .filter(|o| o.frequency_at(last) > highest)
            .map(PlottedOrder::text)
            .collect()
    }

    fn right_texts(&self) -> Vec<String> {
        let branches = self
            .branches
            .iter()
            .map(|b| truncate_label(&b.label, MAX_NAME_LEN));
        let (_, last) = self.speed_range();
        let orders = self
            .rays()
            .filter(|o| o.frequency_at(last) <= self.highest());
        branches.chain(orders.map(PlottedOrder::text)).collect()
    }

    fn axes(&self, canvas: &mut Canvas, panel: &Panel) {
        panel.draw_x_grid(canvas, &ticks(panel.x, 8));
        panel.draw_y_grid(canvas, &ticks(panel.y, 8));
        let (low, high) = (
            (panel.across.0, panel.down.0),
            (panel.across.1, panel.down.1),
        );
        canvas.stroke_rect(low, high, GREY, 0.8);
        let middle = (panel.down.0 + panel.down.1) / 2.0;
        canvas.upright("frequency, Hz", (16.0, middle));
        let label = match self.shaft.as_str() {
            "" => "speed, rpm".to_string(),
            shaft => format!("speed of {}, rpm", truncate_label(shaft, MAX_NAME_LEN)),
        };
        let centre = (panel.across.0 + panel.across.1) / 2.0;
        let below = panel.down.1 + 30.0;
        canvas.label(&label, (centre, below), Anchor::Middle);
    }

    /// Draws the order lines; labels of those that leave at the top are placed there, the rest are returned.
    fn draw_orders(&self, canvas: &mut Canvas, panel: &Panel) -> Vec<EdgeLabel> {
        let ((first, last), highest) = (panel.x, panel.y.1);
        let mut ends = Vec::new();
        let mut at_top: Vec<(f64, String)> = Vec::new();
        for order in self.rays() {
            let leaves = order.frequency_at(last) > highest;
            let end = if leaves {
                60.0 * highest / order.order
            } else {
                last
            };
            let from = panel.to_canvas(first, order.frequency_at(first));
            let to = panel.to_canvas(end, order.frequency_at(end));
            canvas.line(from, to, GREY, 0.7);
            match leaves {
                true => at_top.push((to.0, order.text())),
                false => ends.push(EdgeLabel {
                    spot: to,
                    text: order.text(),
                    ink: GREY,
                }),
            }
        }
        let wanted: Vec<f64> = at_top.iter().map(|a| a.0).collect();
        let places = spread_labels(&wanted, LABEL_SIZE + 2.0, panel.across);
        for ((x, text), &place) in at_top.iter().zip(&places) {
            let foot = (place, panel.down.0 - 10.0);
            canvas.line((*x, panel.down.0), foot, GREY, 0.5);
            let start = (place, foot.1 - 2.0);
            canvas.vertical_text(text, start, LABEL_SIZE, GREY, Anchor::Start);
        }
        ends
    }

    fn draw_branches(&self, canvas: &mut Canvas, panel: &Panel) -> Vec<EdgeLabel> {
        let mut ends = Vec::new();
        for branch in &self.branches {
            let (ink, kind) = match branch.whirl {
                PlottedWhirl::Forward => (BLUE, LineStyle::Solid),
                PlottedWhirl::Backward => (BLUE, LineStyle::Dashed),
                PlottedWhirl::None => (BLACK, LineStyle::Solid),
            };
            let pieces = self.pieces(branch, panel);
            for piece in &pieces {
                canvas.polyline(piece, ink, 1.6, kind);
            }
            if let Some(&spot) = pieces.last().and_then(|piece| piece.last()) {
                ends.push(EdgeLabel {
                    spot,
                    text: truncate_label(&branch.label, MAX_NAME_LEN),
                    ink,
                });
            }
        }
        ends
    }

    /// The segments of a branch that were followed.
    fn pieces(&self, branch: &PlottedBranch, panel: &Panel) -> Vec<Vec<Point2>> {
        let mut pieces: Vec<Vec<Point2>> = vec![Vec::new()];
        for (&speed, frequency) in self.speeds_rpm.iter().zip(&branch.frequencies_hz) {
            match (frequency.filter(|f| f.is_finite()), pieces.last_mut()) {
                (Some(f), Some(piece)) => piece.push(panel.to_canvas(speed, f)),
                (None, Some(piece)) if !piece.is_empty() => pieces.push(Vec::new()),
                _ => {}
            }
        }
        pieces.retain(|piece| !piece.is_empty());
        pieces
    }

    fn draw_crossings(&self, canvas: &mut Canvas, panel: &Panel) {
        for crossing in &self.crossings {
            let PlottedCrossing {
                speed_rpm: x,
                frequency_hz: y,
                participation,
            } = *crossing;
            let inside =
                (panel.x.0..=panel.x.1).contains(&x) && (panel.y.0..=panel.y.1).contains(&y);
            if inside {
                canvas.stroke_circle(panel.to_canvas(x, y), ring_size(participation), ORANGE, 1.5);
            }
        }
    }

    /// Draws the legend of line styles and rings, where there are any.
    fn key(&self, canvas: &mut Canvas, panel: &Panel) {
        let y = panel.down.1 + 52.0;
        let mut x = panel.across.0;
        let has = |whirl| self.branches.iter().any(|b| b.whirl == whirl);
        let whirls = has(PlottedWhirl::Forward) || has(PlottedWhirl::Backward);
        let say = |canvas: &mut Canvas, x: &mut f64, text: &str| {
            canvas.label(text, (*x, y), Anchor::Start);
            *x += text_width(text, LABEL_SIZE) + 14.0;
        };
        let kinds = [
            (
                PlottedWhirl::Forward,
                BLUE,
                LineStyle::Solid,
                "forward whirl",
            ),
            (
                PlottedWhirl::Backward,
                BLUE,
                LineStyle::Dashed,
                "backward whirl",
            ),
            (PlottedWhirl::None, BLACK, LineStyle::Solid, "no whirl"),
        ];
        for (whirl, ink, stroke, text) in kinds {
            if whirls && has(whirl) {
                canvas.polyline(&[(x, y), (x + 26.0, y)], ink, 1.6, stroke);
                x += 32.0;
                say(canvas, &mut x, text);
            }
        }
        if !self.crossings.is_empty() {
            for (participation, text) in [(0.05, "5 %"), (0.5, "50 %"), (1.0, "100 %")] {
                let r = ring_size(participation);
                canvas.stroke_circle((x + r, y), r, ORANGE, 1.5);
                x += 2.0 * r + 5.0;
                say(canvas, &mut x, text);
            }
            say(canvas, &mut x, "participation where an order meets a mode");
        }
    }
}

/// Radius of a crossing's ring: its area follows the participation.
fn ring_size(participation: f64) -> f64 {
    const MIN_COUNT: f64 = 1.8;
    const MAX_COUNT: f64 = 8.0;
    let part = if participation.is_finite() {
        participation.clamp(0.0, 1.0)
    } else {
        0.0
    };
    MIN_COUNT + (MAX_COUNT - MIN_COUNT) * part.sqrt()
}

/// Labels of lines that end at the right edge, none over another, each led to its line.
fn label_right(canvas: &mut Canvas, panel: &Panel, ends: &[EdgeLabel]) {
    let wanted: Vec<f64> = ends.iter().map(|end| end.spot.1).collect();
    let places = spread_labels(&wanted, LABEL_SIZE + 2.5, (panel.down.0, panel.down.1));
    for (EdgeLabel { spot, text, ink }, &place) in ends.iter().zip(&places) {
        let side = panel.across.1 + 16.0;
        canvas.line(*spot, (side, place), *ink, 0.5);
        canvas.text(text, (side + 4.0, place), LABEL_SIZE, *ink, Anchor::Start);
    }
}
