//! Campbell plot: natural frequencies over speed, order lines `f = order · n / 60`, crossings as circles.

use super::figure::{
    Axis, BLACK_INK, Curve, GREY_INK, Guide, Ink, Mark, NamePlacement, Plot, PlotColumn,
};
use super::svg::{LineStyle, significant, truncate_label};

/// Sense of whirl of a plotted branch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlottedWhirl {
    /// Forward whirl: orbits in the sense of rotation of the shaft.
    Forward,
    /// Backward whirl: orbits against the sense of rotation.
    Backward,
    /// No single sense of whirl: torsional, planar or mixed motion.
    None,
}

/// Branch of a mode over speed.
#[derive(Debug, Clone)]
pub struct PlottedBranch {
    /// Label at the end of the curve.
    pub label: String,
    /// Sense of whirl, which selects the line style.
    pub whirl: PlottedWhirl,
    /// Natural frequency at each speed, Hz; `None` at speeds where the mode is not oscillatory.
    pub frequencies_hz: Vec<Option<f64>>,
}

/// Order line of an excitation.
#[derive(Debug, Clone)]
pub struct PlottedOrder {
    /// Label of the excitation.
    pub label: String,
    /// Cycles per revolution of the reference shaft.
    pub order: f64,
}

/// Crossing of an order line and a branch.
#[derive(Debug, Clone, Copy)]
pub struct PlottedCrossing {
    /// Reference speed, rpm.
    pub speed_rpm: f64,
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Participation of the mode in the order, 0 to 1.
    pub participation: f64,
}

/// Data of a Campbell plot.
#[derive(Debug, Clone, Default)]
pub struct CampbellPlot {
    /// Name of the reference shaft.
    pub shaft: String,
    /// Reference speeds, rpm, in increasing order.
    pub speeds_rpm: Vec<f64>,
    /// Branches of the modes.
    pub branches: Vec<PlottedBranch>,
    /// Order lines.
    pub orders: Vec<PlottedOrder>,
    /// Crossings of order lines with branches.
    pub crossings: Vec<PlottedCrossing>,
    /// Operating speed, rpm; `None` where the file gives none.
    pub operating_rpm: Option<f64>,
}

const MAX_NAME_LEN: usize = 30;

/// Figure of a Campbell plot on linear axes.
pub fn campbell_figure(diagram: &CampbellPlot) -> PlotColumn {
    let (first, last) = diagram.speed_range();
    let highest = diagram.highest();
    let speed_label = match diagram.shaft.as_str() {
        "" => "speed, rpm".to_string(),
        shaft => format!("speed of {}, rpm", truncate_label(shaft, MAX_NAME_LEN)),
    };
    let orders = diagram.orders.iter().filter(|o| o.order > 0.0);
    let orders = orders
        .filter(|o| o.frequency_at(first) < highest)
        .map(|order| {
            // An order line ends at the upper limit of the frequency axis.
            let end = last.min(60.0 * highest / order.order);
            let y = [first, end].map(|speed| order.frequency_at(speed).min(highest));
            let mark = Mark::Line(0.7, LineStyle::Solid);
            Curve::new(order.name(), GREY_INK, mark, vec![first, end], y.to_vec())
        });
    let branch = |branch: &PlottedBranch| {
        let (ink, style, _) = whirl_style(branch.whirl);
        let frequencies = branch.frequencies_hz.iter().map(|f| f.unwrap_or(f64::NAN));
        let name = truncate_label(&branch.label, MAX_NAME_LEN);
        let mark = Mark::Line(1.6, style);
        Curve::new(
            name,
            ink,
            mark,
            diagram.speeds_rpm.clone(),
            frequencies.collect(),
        )
    };
    let empty = diagram.speeds_rpm.is_empty() || diagram.branches.is_empty();
    let mut curves: Vec<Curve> = Vec::new();
    if !empty {
        curves = orders.chain(diagram.branches.iter().map(branch)).collect();
        curves.push(diagram.rings());
    }
    let has = |whirl| diagram.branches.iter().any(|b| b.whirl == whirl);
    let whirls = [
        PlottedWhirl::Forward,
        PlottedWhirl::Backward,
        PlottedWhirl::None,
    ];
    let styles = whirls
        .into_iter()
        .filter(|w| has(*w))
        .map(|w| whirl_style(w).2);
    let styles: Vec<&str> = styles.collect();
    let mut notes: Vec<String> = Vec::new();
    if styles.len() > 1 {
        notes.push(styles.join(", "));
    }
    if !diagram.crossings.is_empty() {
        notes.push("area of rings: participation of the excited part in the mode".to_string());
    }
    let operating = diagram.operating_rpm.filter(|s| (first..=last).contains(s));
    let operating = operating.map(|speed| Guide {
        name: format!(
            "dotted: operating speed {} rpm",
            (10.0 * speed).round() / 10.0
        ),
        ..Guide::vertical(speed)
    });
    let plot = Plot {
        height: 440.0,
        curves,
        guides: operating.into_iter().collect(),
        names: NamePlacement::AtEnd,
        empty: "no modes",
        ..Plot::new(
            Axis::linear(speed_label).over(first, if last > first { last } else { first + 1.0 }),
            Axis::linear("frequency, Hz").over(0.0, highest),
        )
    };
    PlotColumn {
        note: notes.join("; "),
        ..PlotColumn::one("", plot)
    }
}

/// Colour, line style and legend text of a sense of whirl.
fn whirl_style(whirl: PlottedWhirl) -> (Ink, LineStyle, &'static str) {
    match whirl {
        PlottedWhirl::Forward => (Ink::Series(0), LineStyle::Solid, "blue: forward whirl"),
        PlottedWhirl::Backward => (Ink::Series(0), LineStyle::Dashed, "dashed: backward whirl"),
        PlottedWhirl::None => (
            BLACK_INK,
            LineStyle::Solid,
            "in text colour: planar, mixed or no whirl",
        ),
    }
}

impl PlottedOrder {
    fn name(&self) -> String {
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

    /// Upper limit of the frequency axis, Hz.
    fn highest(&self) -> f64 {
        let all = self.branches.iter().flat_map(|b| &b.frequencies_hz);
        let largest = all
            .flatten()
            .copied()
            .filter(|f| f.is_finite())
            .fold(0.0, f64::max);
        if largest > 0.0 { 1.06 * largest } else { 1.0 }
    }

    /// Crossings on the frequency axis as rings.
    fn rings(&self) -> Curve {
        let highest = self.highest();
        let is_on_axis = |c: &&PlottedCrossing| (0.0..=highest).contains(&c.frequency_hz);
        let all: Vec<&PlottedCrossing> = self.crossings.iter().filter(is_on_axis).collect();
        Curve {
            radii: all.iter().map(|c| ring_size(c.participation)).collect(),
            along: Some((
                "participation, %",
                all.iter().map(|c| 100.0 * c.participation).collect(),
            )),
            ..Curve::new(
                "",
                Ink::Series(1),
                Mark::Rings(3.0),
                all.iter().map(|c| c.speed_rpm).collect(),
                all.iter().map(|c| c.frequency_hz).collect(),
            )
        }
    }
}

/// Radius of the ring of a crossing; the area increases with the participation.
fn ring_size(participation: f64) -> f64 {
    const MIN_RADIUS: f64 = 1.8;
    const MAX_RADIUS: f64 = 8.0;
    let share = if participation.is_finite() {
        participation.clamp(0.0, 1.0)
    } else {
        0.0
    };
    MIN_RADIUS + (MAX_RADIUS - MIN_RADIUS) * share.sqrt()
}
