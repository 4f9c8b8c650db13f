//! Figure data of SVG files and HTML pages: plots with axes, curves, maps and labels.

use super::axes::linear_range;
use super::number_format::scaled_label;
use super::svg::LineStyle;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::statistics::extremes;

/// Figure of a result.
#[derive(Debug, Clone)]
pub struct Figure {
    /// File-name suffix after a hyphen; empty for the first figure.
    pub suffix: &'static str,
    /// Plots, or a drawing as SVG.
    pub content: FigureContent,
}

/// Content of a figure.
#[derive(Debug, Clone)]
pub enum FigureContent {
    /// Plots one below the other.
    Plots(PlotColumn),
    /// Drawing without plot axes, as SVG: schematics, polar charts, teeth.
    Drawing(String),
}

impl From<PlotColumn> for FigureContent {
    fn from(plots: PlotColumn) -> FigureContent {
        FigureContent::Plots(plots)
    }
}

impl From<String> for FigureContent {
    fn from(svg: String) -> FigureContent {
        FigureContent::Drawing(svg)
    }
}

impl Figure {
    /// First figure of a result.
    pub fn first(content: impl Into<FigureContent>) -> Figure {
        Figure::new("", content)
    }

    /// Further figure with a file-name suffix.
    pub fn new(suffix: &'static str, content: impl Into<FigureContent>) -> Figure {
        let content = content.into();
        Figure { suffix, content }
    }
}

/// Axis that a user requests as logarithmic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LogAxis {
    /// Abscissa.
    X,
    /// Ordinate.
    Y,
}

/// Makes an axis of the first figure logarithmic: the abscissa of all its plots, or the ordinate of its first plot.
///
/// # Errors
/// `conflict` where the figure has no axes or a map, or a value of the axis is not positive.
pub fn with_log_axis(mut figures: Vec<Figure>, axis: LogAxis) -> Result<Vec<Figure>, Error> {
    let refuse =
        |message: String, hint: &str| Err(Error::new(Code::Conflict, message).with_hint(hint));
    let first = figures.first_mut().map(|figure| &mut figure.content);
    let Some(FigureContent::Plots(column)) = first else {
        return refuse("the figure has no axes for --log".into(), "omit --log");
    };
    let count = match axis {
        LogAxis::X => column.plots.len(),
        LogAxis::Y => 1,
    };
    for plot in column.plots.iter_mut().take(count) {
        if plot.map.is_some() || plot.equal_scales {
            let message = "a map and a plot of equal scales keep linear axes";
            return refuse(message.into(), "omit --log");
        }
        let axis_values = |curve: &Curve| -> Vec<f64> {
            match axis {
                LogAxis::X => curve.x.clone(),
                LogAxis::Y => {
                    let limits = curve.interval.iter().flat_map(|i| [i.0, i.1]);
                    curve.y.iter().copied().chain(limits).collect()
                }
            }
        };
        let lowest = plot
            .curves
            .iter()
            .flat_map(axis_values)
            .filter(|v| v.is_finite());
        let lowest = lowest.fold(f64::INFINITY, f64::min);
        let scale = match axis {
            LogAxis::X => &mut plot.x,
            LogAxis::Y => &mut plot.y,
        };
        if lowest <= 0.0 {
            let message = format!(
                "--log: the axis \"{}\" has the value {lowest}, which has no logarithm",
                scale.label
            );
            return refuse(message, "omit --log, or request a range above zero");
        }
        scale.logarithmic = true;
        scale.range = scale.range.filter(|range| range.0 > 0.0);
        scale.ticks = Vec::new();
    }
    Ok(figures)
}

/// Plots one below the other with a common title.
#[derive(Debug, Clone, Default)]
pub struct PlotColumn {
    /// Title of the figure.
    pub title: String,
    /// Note on marks or on omitted curves; empty for none.
    pub note: String,
    /// True for a common abscissa: numbers only below the last plot, joint zoom.
    pub linked: bool,
    /// Events on the common abscissa, marked at the foot of every plot, one row per kind.
    pub events: Vec<EventMarks>,
    /// Plots from top to bottom.
    pub plots: Vec<Plot>,
}

/// Events of one kind.
#[derive(Debug, Clone, Default)]
pub struct EventMarks {
    /// Kind of the events.
    pub kind: String,
    /// Key entry: kind and number of events.
    pub name: String,
    /// Index of the colour.
    pub ink: usize,
    /// Abscissae, ascending.
    pub x: Vec<f64>,
    /// Names of the event sources.
    pub sources: Vec<String>,
    /// Index of the source of each event.
    pub source: Vec<usize>,
}

impl PlotColumn {
    /// Figure of one plot.
    pub fn one(title: impl Into<String>, plot: Plot) -> PlotColumn {
        PlotColumn {
            title: title.into(),
            plots: vec![plot],
            ..PlotColumn::default()
        }
    }
}

impl PlotColumn {
    /// Figure of one plot with lines in the order of colours: name, abscissae, ordinates.
    pub fn of_lines(
        title: &str,
        (x, y): (Axis, Axis),
        lines: impl IntoIterator<Item = (String, Vec<f64>, Vec<f64>)>,
    ) -> PlotColumn {
        let lines = lines.into_iter().enumerate();
        let curves = lines.map(|(k, (name, x, y))| Curve::line(name, Ink::Series(k), x, y));
        let curves: Vec<Curve> = curves.collect();
        PlotColumn::one(
            title,
            Plot {
                curves,
                ..Plot::new(x, y)
            },
        )
    }
}

/// Closes a periodic line of equal steps: its first value is repeated at the end of the period.
pub fn closed(mut x: Vec<f64>, mut y: Vec<f64>) -> (Vec<f64>, Vec<f64>) {
    if let ([first, .., last], [value, ..]) = (&x[..], &y[..]) {
        let end = last + (last - first) / (x.len() - 1) as f64;
        y.push(*value);
        x.push(end);
    }
    (x, y)
}

/// Height of a single plot, points.
pub const PLOT_HEIGHT: f64 = 420.0;

/// Plot: a pair of axes with curves, guides, bands, labels and a level map.
#[derive(Debug, Clone)]
pub struct Plot {
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Height, points.
    pub height: f64,
    /// True for equal scales of both axes.
    pub equal_scales: bool,
    /// Heading of the plot; empty for none.
    pub heading: String,
    /// Shaded ranges of the abscissa.
    pub bands: Vec<Band>,
    /// Level map behind the curves.
    pub map: Option<LevelMap>,
    /// Guide lines at values of one axis.
    pub guides: Vec<Guide>,
    /// Curves in drawing order.
    pub curves: Vec<Curve>,
    /// Position of the curve names.
    pub names: NamePlacement,
    /// Point labels by priority; an SVG file shows those with sufficient room.
    pub labels: Vec<PointLabel>,
    /// True for vertical point labels.
    pub upright_labels: bool,
    /// Text of a plot without finite values.
    pub empty: &'static str,
}

impl Plot {
    /// Plot without curves, at the height of a single plot.
    pub fn new(x: Axis, y: Axis) -> Plot {
        Plot {
            x,
            y,
            height: PLOT_HEIGHT,
            equal_scales: false,
            heading: String::new(),
            bands: Vec::new(),
            map: None,
            guides: Vec::new(),
            curves: Vec::new(),
            names: NamePlacement::Key,
            labels: Vec::new(),
            upright_labels: false,
            empty: "nothing to show",
        }
    }

    /// Factor and label of each axis in a unit suited to its largest value; equal scales have a common factor.
    pub fn shown_units(&self) -> [(f64, String); 2] {
        let largest = |axis: &Axis, values_of: fn(&Curve) -> &[f64]| {
            let values = self.curves.iter().flat_map(values_of).copied();
            let all = values.chain(axis.range.iter().flat_map(|r| [r.0, r.1]));
            all.map(f64::abs)
                .filter(|v| v.is_finite())
                .fold(0.0, f64::max)
        };
        let mut sizes = [largest(&self.x, |c| &c.x), largest(&self.y, |c| &c.y)];
        if self.equal_scales {
            sizes = [sizes[0].max(sizes[1]); 2];
        }
        [
            scaled_label(&self.x.label, sizes[0]),
            scaled_label(&self.y.label, sizes[1]),
        ]
    }
}

/// Ratio of largest to smallest magnitude above which an axis is logarithmic: three decades.
const LOG_SPAN: f64 = 1e3;

/// Axis of a plot.
#[derive(Debug, Clone, Default)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// True for a logarithmic axis.
    pub logarithmic: bool,
    /// Lowest and highest value shown; by default those of the curves.
    pub range: Option<(f64, f64)>,
    /// Grid values; empty for round values.
    pub ticks: Vec<f64>,
    /// Unit with an SI prefix by value (`10 µs`), for a label without unit.
    pub prefixed_unit: Option<&'static str>,
}

impl Axis {
    /// Linear axis.
    pub fn linear(label: impl Into<String>) -> Axis {
        Axis {
            label: label.into(),
            ..Axis::default()
        }
    }

    /// Logarithmic axis.
    pub fn log(label: impl Into<String>) -> Axis {
        Axis {
            logarithmic: true,
            ..Axis::linear(label)
        }
    }

    /// Axis of magnitudes: logarithmic if all are positive with a ratio above [`LOG_SPAN`], else linear from zero.
    pub fn of_magnitudes(
        label: impl Into<String>,
        values: impl Iterator<Item = f64> + Clone,
    ) -> Axis {
        let (lowest, highest) = extremes(values.clone().filter(|v| v.is_finite()));
        match lowest > 0.0 && highest > LOG_SPAN * lowest {
            true => Axis::log(label),
            false => Axis::linear(label).from_zero(values),
        }
    }

    /// Axis with a fixed range.
    pub fn over(self, low: f64, high: f64) -> Axis {
        Axis {
            range: Some((low, high)),
            ..self
        }
    }

    /// Axis with a range over `values` and zero.
    pub fn from_zero(self, values: impl Iterator<Item = f64>) -> Axis {
        Axis {
            range: linear_range(values.chain([0.0])),
            ..self
        }
    }

    /// Position of a value along the axis: the value or its decimal logarithm.
    pub fn position(&self, value: f64) -> f64 {
        if self.logarithmic {
            value.log10()
        } else {
            value
        }
    }
}

/// Number of curve colours.
pub const COLOURS: usize = 6;

/// Colour of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ink {
    /// Curve colour by index: blue, orange, black, grey, green, purple.
    Series(usize),
    /// Curve colour lightened halfway to white.
    Pale(usize),
    /// Colour of grids.
    Faint,
}

/// Ink of secondary curves.
pub const GREY_INK: Ink = Ink::Series(3);

/// Ink of curves without a series colour.
pub const BLACK_INK: Ink = Ink::Series(2);

/// Line or marker of a curve, sizes in points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mark {
    /// Line of this width and style.
    Line(f64, LineStyle),
    /// Discs of this radius.
    Discs(f64),
    /// Circles of this radius.
    Rings(f64),
    /// Diagonal crosses of this radius.
    Crosses(f64),
    /// Stems from the lower edge with a disc at the end.
    Stems,
}

/// Curve or set of points.
#[derive(Debug, Clone)]
pub struct Curve {
    /// Name in the key; empty for none.
    pub name: String,
    /// Colour.
    pub ink: Ink,
    /// Line or marker.
    pub mark: Mark,
    /// Abscissae.
    pub x: Vec<f64>,
    /// Ordinates; a value that is not finite interrupts a line.
    pub y: Vec<f64>,
    /// Uncertainty interval of each ordinate; empty for none.
    pub interval: Vec<(f64, f64)>,
    /// Individual radius of each point, points; empty for the common radius.
    pub radii: Vec<f64>,
    /// Additional value at each point for the tooltip of a page, with quantity and unit.
    pub along: Option<(&'static str, Vec<f64>)>,
}

impl Curve {
    /// Curve with a name.
    pub fn new(name: impl Into<String>, ink: Ink, mark: Mark, x: Vec<f64>, y: Vec<f64>) -> Curve {
        Curve {
            name: name.into(),
            ink,
            mark,
            x,
            y,
            interval: Vec::new(),
            radii: Vec::new(),
            along: None,
        }
    }

    /// Mark as drawn: solid lines of a repeated colour are dashed, then dotted.
    pub fn shown_mark(&self) -> Mark {
        match (self.mark, self.ink) {
            (Mark::Line(width, LineStyle::Solid), Ink::Series(k)) if k >= COLOURS => {
                let style = if k < 2 * COLOURS {
                    LineStyle::Dashed
                } else {
                    LineStyle::Dotted
                };
                Mark::Line(width, style)
            }
            (mark, _) => mark,
        }
    }

    /// Solid line of standard width.
    pub fn line(name: impl Into<String>, ink: Ink, x: Vec<f64>, y: Vec<f64>) -> Curve {
        Curve::new(name, ink, Mark::Line(1.0, LineStyle::Solid), x, y)
    }
}

/// Position of the curve names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NamePlacement {
    /// In a key above the figure.
    Key,
    /// At the end of each curve.
    AtEnd,
}

/// Guide line at a value of one axis.
#[derive(Debug, Clone)]
pub struct Guide {
    /// True for a vertical line at an abscissa.
    pub vertical: bool,
    /// Value on the axis.
    pub at: f64,
    /// True for a dotted line, false for a solid one.
    pub dotted: bool,
    /// Name, below the right end of the axis; empty for none.
    pub name: String,
}

impl Guide {
    /// Dotted vertical line.
    pub fn vertical(at: f64) -> Guide {
        Guide {
            vertical: true,
            at,
            dotted: true,
            name: String::new(),
        }
    }

    /// Dotted horizontal line.
    pub fn horizontal(at: f64) -> Guide {
        Guide {
            vertical: false,
            ..Guide::vertical(at)
        }
    }
}

/// Shaded range of the abscissa.
#[derive(Debug, Clone)]
pub struct Band {
    /// Lower end.
    pub from: f64,
    /// Upper end.
    pub to: f64,
    /// Name at its foot.
    pub name: String,
}

/// Label of a point.
#[derive(Debug, Clone)]
pub struct PointLabel {
    /// Abscissa.
    pub x: f64,
    /// Ordinate.
    pub y: f64,
    /// Name.
    pub text: String,
}

/// Level map: levels over two axes, by colour.
#[derive(Debug, Clone, Default)]
pub struct LevelMap {
    /// Quantity of the levels.
    pub label: String,
    /// Centres of the columns, ascending.
    pub x: Vec<f64>,
    /// Centres of the rows, ascending at equal spacing.
    pub y: Vec<f64>,
    /// Level of each row of each column, dB; minus infinity without a level.
    pub columns: Vec<Vec<f64>>,
    /// True for sparse levels along lines: an SVG file has more cells, so that lines have no steps.
    pub sparse: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Positive values over three decades have a logarithmic axis; a smaller range or a zero, a linear axis from zero.
    #[test]
    fn exact_range_decides_the_scale() {
        let axis = |values: &[f64]| Axis::of_magnitudes("force, N", values.iter().copied());
        assert!(axis(&[1e-3, f64::NAN, 2.0]).logarithmic);
        for values in [&[1e-3, 0.9][..], &[0.0, 1e-3, 2.0], &[-1.0, 1e4], &[]] {
            let shown = axis(values);
            assert!(!shown.logarithmic, "{values:?}");
            assert!(shown.range.is_none_or(|(low, _)| low <= 0.0), "{values:?}");
        }
    }
}
