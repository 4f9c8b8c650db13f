//! Figures as data: plots with axes, curves, maps and labels, from which SVG files and pages are drawn.

use super::axes::linear_range;
use super::number_format::scaled_label;
use super::svg::LineStyle;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::statistics::extremes;

/// One of the figures of a result.
#[derive(Debug, Clone)]
pub struct Figure {
    /// The end of its file's name, behind a hyphen; empty for the first.
    pub suffix: &'static str,
    /// Plots or a drawing.
    pub content: FigureContent,
}

/// Content of a figure.
#[derive(Debug, Clone)]
pub enum FigureContent {
    /// Plots one below the other.
    Plots(PlotColumn),
    /// A drawing without axes of its own, as SVG: schematics, polar charts, teeth.
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
    /// The first figure.
    pub fn first(content: impl Into<FigureContent>) -> Figure {
        Figure::new("", content)
    }

    /// A further figure.
    pub fn new(suffix: &'static str, content: impl Into<FigureContent>) -> Figure {
        let content = content.into();
        Figure { suffix, content }
    }
}

/// Axis of the first figure that a user wants logarithmic.
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
/// `conflict` where the figure has no axes or a map, or the axis holds a value that is not above zero.
pub fn with_log_axis(mut figures: Vec<Figure>, axis: LogAxis) -> Result<Vec<Figure>, Error> {
    let refuse =
        |message: String, hint: &str| Err(Error::new(Code::Conflict, message).with_hint(hint));
    let first = figures.first_mut().map(|figure| &mut figure.content);
    let Some(FigureContent::Plots(column)) = first else {
        return refuse("the figure has no axes for --log".into(), "leave --log out");
    };
    let count = match axis {
        LogAxis::X => column.plots.len(),
        LogAxis::Y => 1,
    };
    for plot in column.plots.iter_mut().take(count) {
        if plot.map.is_some() || plot.equal_scales {
            let message = "a map and a plot of equal scales keep linear axes";
            return refuse(message.into(), "leave --log out");
        }
        let of_axis = |curve: &Curve| -> Vec<f64> {
            match axis {
                LogAxis::X => curve.x.clone(),
                LogAxis::Y => {
                    let ends = curve.interval.iter().flat_map(|i| [i.0, i.1]);
                    curve.y.iter().copied().chain(ends).collect()
                }
            }
        };
        let least = plot
            .curves
            .iter()
            .flat_map(of_axis)
            .filter(|v| v.is_finite());
        let least = least.fold(f64::INFINITY, f64::min);
        let scale = match axis {
            LogAxis::X => &mut plot.x,
            LogAxis::Y => &mut plot.y,
        };
        if least <= 0.0 {
            let message = format!(
                "--log: the axis \"{}\" holds {least}, which has no logarithm",
                scale.label
            );
            return refuse(
                message,
                "leave --log out, or request a range above zero where the command takes one",
            );
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
    /// Note on marks, or on curves not shown; empty for none.
    pub note: String,
    /// The plots share their abscissa: its numbers are shown below the last, and all zoom together.
    pub linked: bool,
    /// Events on the common abscissa, marked at the foot of every plot; one row a kind.
    pub events: Vec<EventMarks>,
    /// The plots from top to bottom.
    pub plots: Vec<Plot>,
}

/// Events of one kind.
#[derive(Debug, Clone, Default)]
pub struct EventMarks {
    /// Kind.
    pub kind: String,
    /// Name in the key: the kind with its number.
    pub name: String,
    /// Colour.
    pub ink: usize,
    /// Abscissae, rising.
    pub x: Vec<f64>,
    /// Names of what an event can belong to.
    pub sources: Vec<String>,
    /// Index of the source of each event.
    pub source: Vec<usize>,
}

impl PlotColumn {
    /// A figure of one plot.
    pub fn one(title: impl Into<String>, plot: Plot) -> PlotColumn {
        PlotColumn {
            title: title.into(),
            plots: vec![plot],
            ..PlotColumn::default()
        }
    }
}

impl PlotColumn {
    /// One plot of lines in the order of colours, named in the key: name, abscissae, ordinates.
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

/// A line over a period of equal steps from its first value to the same at the end.
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

/// One pair of axes and what it holds.
#[derive(Debug, Clone)]
pub struct Plot {
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Height in points.
    pub height: f64,
    /// A unit has the same length on both axes.
    pub equal_scales: bool,
    /// Heading of this plot; empty for none.
    pub heading: String,
    /// Ranges of the abscissa that are shaded.
    pub bands: Vec<Band>,
    /// Levels by colour, behind the curves.
    pub map: Option<LevelMap>,
    /// Dotted lines at values of one axis.
    pub guides: Vec<Guide>,
    /// Curves, the first drawn first.
    pub curves: Vec<Curve>,
    /// Place of the names of curves.
    pub names: NamePlacement,
    /// Named points, the most important first; the SVG file names as many as have room.
    pub labels: Vec<PointLabel>,
    /// Names of points are written upright.
    pub upright_labels: bool,
    /// Text in place of a plot without a finite value.
    pub empty: &'static str,
}

impl Plot {
    /// A plot without curves, of the height of a single one.
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

    /// Label of each axis in the unit of its largest value, with the factor of the values; on equal scales the factors are one.
    pub fn shown_units(&self) -> [(f64, String); 2] {
        let largest = |axis: &Axis, of: fn(&Curve) -> &[f64]| {
            let values = self.curves.iter().flat_map(of).copied();
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

/// Ratio of the greatest to the least magnitude above which a linear axis would hide the small ones: three decades.
const LOG_SPAN: f64 = 1e3;

/// An axis of a plot.
#[derive(Debug, Clone, Default)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// Values are shown by their logarithm.
    pub logarithmic: bool,
    /// Least and greatest value shown; by default those of the curves.
    pub range: Option<(f64, f64)>,
    /// Values with a line of the grid; empty: round ones.
    pub ticks: Vec<f64>,
    /// Unit whose prefix follows the size of a value (`10 µs`), where the label has none.
    pub prefixed_unit: Option<&'static str>,
}

impl Axis {
    /// A linear axis.
    pub fn linear(label: impl Into<String>) -> Axis {
        Axis {
            label: label.into(),
            ..Axis::default()
        }
    }

    /// A logarithmic axis.
    pub fn log(label: impl Into<String>) -> Axis {
        Axis {
            logarithmic: true,
            ..Axis::linear(label)
        }
    }

    /// An axis of magnitudes: logarithmic where all are above zero and span more than [`LOG_SPAN`], else linear from zero.
    pub fn of_magnitudes(
        label: impl Into<String>,
        values: impl Iterator<Item = f64> + Clone,
    ) -> Axis {
        let (least, greatest) = extremes(values.clone().filter(|v| v.is_finite()));
        match least > 0.0 && greatest > LOG_SPAN * least {
            true => Axis::log(label),
            false => Axis::linear(label).from_zero(values),
        }
    }

    /// The axis between two values.
    pub fn over(self, low: f64, high: f64) -> Axis {
        Axis {
            range: Some((low, high)),
            ..self
        }
    }

    /// The axis over values and zero.
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

/// Colours of curves.
pub const COLOURS: usize = 6;

/// Colour of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ink {
    /// One of the colours of curves in their order: blue, orange, black, grey, green, purple.
    Series(usize),
    /// The same, half way to the paper.
    Pale(usize),
    /// The colour of grids.
    Faint,
}

/// Ink of what is secondary.
pub const GREY_INK: Ink = Ink::Series(3);

/// Ink of what has no colour of its own.
pub const BLACK_INK: Ink = Ink::Series(2);

/// Kind of drawing of a curve; sizes in points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mark {
    /// Joined by a line of this width.
    Line(f64, LineStyle),
    /// Discs of this radius.
    Discs(f64),
    /// Circles of this radius.
    Rings(f64),
    /// Diagonal crosses of this radius.
    Crosses(f64),
    /// Lines from the lower edge with a disc at the end.
    Stems,
}

/// A curve or a set of points.
#[derive(Debug, Clone)]
pub struct Curve {
    /// Name in the key; empty for none.
    pub name: String,
    /// Colour.
    pub ink: Ink,
    /// Kind of drawing.
    pub mark: Mark,
    /// Abscissae.
    pub x: Vec<f64>,
    /// Ordinates; a value that is not finite interrupts a line.
    pub y: Vec<f64>,
    /// Interval about each ordinate; empty for none.
    pub interval: Vec<(f64, f64)>,
    /// Radius of each point in place of the common one; empty for none.
    pub radii: Vec<f64>,
    /// A further value at each point, with its quantity and unit, that a page shows next to the point.
    pub along: Option<(&'static str, Vec<f64>)>,
}

impl Curve {
    /// A curve with a name.
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

    /// The mark as drawn: solid lines of a colour that comes again are dashed, then dotted.
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

    /// A solid line of usual width.
    pub fn line(name: impl Into<String>, ink: Ink, x: Vec<f64>, y: Vec<f64>) -> Curve {
        Curve::new(name, ink, Mark::Line(1.0, LineStyle::Solid), x, y)
    }
}

/// Place of the names of curves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NamePlacement {
    /// In a key above the figure.
    Key,
    /// At the end of each curve.
    AtEnd,
}

/// A line at a value of one axis.
#[derive(Debug, Clone)]
pub struct Guide {
    /// The value is one of the horizontal axis, and the line vertical.
    pub vertical: bool,
    /// Value of the axis.
    pub at: f64,
    /// Dotted, else solid.
    pub dotted: bool,
    /// Name, below the right end of the axis; empty for none.
    pub name: String,
}

impl Guide {
    /// A dotted vertical line.
    pub fn vertical(at: f64) -> Guide {
        Guide {
            vertical: true,
            at,
            dotted: true,
            name: String::new(),
        }
    }

    /// A dotted horizontal line.
    pub fn horizontal(at: f64) -> Guide {
        Guide {
            vertical: false,
            ..Guide::vertical(at)
        }
    }
}

/// A shaded range of the abscissa.
#[derive(Debug, Clone)]
pub struct Band {
    /// Lower end.
    pub from: f64,
    /// Upper end.
    pub to: f64,
    /// Name at its foot.
    pub name: String,
}

/// A named point.
#[derive(Debug, Clone)]
pub struct PointLabel {
    /// Abscissa.
    pub x: f64,
    /// Ordinate.
    pub y: f64,
    /// Name.
    pub text: String,
}

/// Levels over two axes, by colour.
#[derive(Debug, Clone, Default)]
pub struct LevelMap {
    /// Quantity of the levels.
    pub label: String,
    /// Middles of the columns, rising.
    pub x: Vec<f64>,
    /// Middles of the rows, evenly rising.
    pub y: Vec<f64>,
    /// A level in dB for each row of each column; minus infinity where there is none.
    pub columns: Vec<Vec<f64>>,
    /// Levels follow lines, most cells have none: an SVG file keeps more cells, so that the lines have no stairs.
    pub sparse: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three decades of positive values are shown by their logarithm; less, or a zero, from zero.
    #[test]
    fn exact_range_decides_the_scale() {
        let axis = |values: &[f64]| Axis::of_magnitudes("force, N", values.iter().copied());
        assert!(axis(&[1e-3, f64::NAN, 2.0]).logarithmic);
        for values in [&[1e-3, 0.9][..], &[0.0, 1e-3, 2.0], &[-1.0, 1e4], &[]] {
            let found = axis(values);
            assert!(!found.logarithmic, "{values:?}");
            assert!(found.range.is_none_or(|(low, _)| low <= 0.0), "{values:?}");
        }
    }
}
