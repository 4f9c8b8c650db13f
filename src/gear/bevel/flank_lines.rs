//! Lines on a bevel flank over the shares of its face and height: contact lines with the cutter, and the limits that cross the flank.

use super::flank::{BevelFlank, is_cut_away};
use super::flank_grid::FlankGrid;
use super::frames::WorkFrame;
use super::zero_curves::{SharesLine, zero_curves};
use crate::gear::kernel::envelope::FlankPoint;
use crate::gear::kernel::jet::Surface;
use crate::gear::kernel::root::{greatest, sign_change};

/// Contact lines of a flank.
const LINES: usize = 12;
/// Steps along a contact line, over the domain of the flank's limits.
const STEPS: usize = 180;

/// Parts of the face at whose ends the limit of undercut is found.
const STATIONS: usize = 48;

/// Contact lines at equal steps of the cradle.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactLines {
    /// Step of the cradle from line to line, rad.
    pub step: f64,
    /// The lines, by growing cradle angle; a line that leaves the flank and returns is two.
    pub lines: Vec<SharesLine>,
}

impl ContactLines {
    /// The lines on a flank with its nodes, up to the limit of undercut; none of a flank that is the cutter's own surface.
    pub fn of(flank: &BevelFlank, grid: &FlankGrid) -> Option<ContactLines> {
        if flank.envelope.motion.is_fixed() {
            return None;
        }
        let [[first, last], _] = grid.ranges()?;
        let [_, theta] = grid.domain()?;
        let step = (last - first) / LINES as f64;
        let angle = |i: usize| theta[0] + (theta[1] - theta[0]) * i as f64 / STEPS as f64;
        let line = |k: usize| {
            let x = first + (k as f64 + 0.5) * step;
            let points: Vec<_> = (0..=STEPS)
                .map(|i| flank.envelope.flank([x, angle(i)]))
                .map(|p| p.filter(|p| !is_cut_away(p)))
                .collect();
            let runs = points.split(Option::is_none);
            let runs = runs.flat_map(|run| in_section(flank, run.iter().flatten()));
            runs.collect::<Vec<_>>()
        };
        Some(ContactLines {
            step,
            lines: (0..LINES).flat_map(line).collect(),
        })
    }
}

/// Limits of both kinds on the flank, `[first, second]`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FlankLimits {
    /// Curves.
    pub curves: [Vec<SharesLine>; 2],
    /// Shares of the place farthest above the root; of the limit of undercut found to rounding, of the other on its curves.
    pub highest: [Option<[f64; 2]>; 2],
}

impl FlankLimits {
    /// The limits that cross a flank, of points that a tool reaches.
    pub fn of(
        flank: &BevelFlank,
        grid: &FlankGrid,
        is_cut: impl Fn(&FlankPoint<WorkFrame>) -> bool,
    ) -> FlankLimits {
        if flank.envelope.motion.is_fixed() {
            return FlankLimits::default();
        }
        let second = second_limit(flank, grid, &is_cut);
        let places = second.iter().flatten().copied();
        let highest_second = places.max_by(|a: &[f64; 2], b| a[1].total_cmp(&b[1]));
        let (undercut, highest) = undercut(flank, grid, is_cut);
        FlankLimits {
            curves: [undercut, second],
            highest: [highest, highest_second],
        }
    }
}

/// Curves `Φ = 0` of the limit of the second kind, from neighbouring nodes that they part.
fn second_limit(
    flank: &BevelFlank,
    grid: &FlankGrid,
    is_cut: impl Fn(&FlankPoint<WorkFrame>) -> bool,
) -> Vec<SharesLine> {
    let share = |i: usize, n: usize| i as f64 / (n.max(2) - 1) as f64;
    let place = |row: usize, column: usize| [share(column, grid.columns), share(row, grid.rows)];
    let node = |row: usize, column: usize| {
        let node = (row < grid.rows && column < grid.columns).then(|| grid.node(row, column))??;
        (!node.in_fillet).then_some(node.point)
    };
    let all = (0..grid.rows).flat_map(|row| (0..grid.columns).map(move |column| [row, column]));
    let known: Vec<_> = (all.clone())
        .filter_map(|[row, column]| Some((place(row, column), node(row, column)?.at)))
        .collect();
    let [end, top] = flank.envelope.surface.range();
    let value = |at: [f64; 2]| {
        let away = |p: [f64; 2]| f64::hypot(p[0] - at[0], p[1] - at[1]);
        let nearest = known
            .iter()
            .min_by(|a, b| away(a.0).total_cmp(&away(b.0)))?;
        let point = flank.point(at, nearest.1)?;
        let is_on_blade = (end..=top).contains(&point.at[0]);
        (is_on_blade && is_cut(&point)).then_some(point.second_order.second_limit)
    };
    let sides = all.flat_map(|[row, column]| {
        let others = [[row + 1, column], [row, column + 1]];
        others.map(|other| [[row, column], other])
    });
    let seeds = sides.filter_map(|[a, b]| {
        let [from, to] = [node(a[0], a[1])?, node(b[0], b[1])?];
        let limits = [from, to].map(|p| p.second_order.second_limit);
        if (limits[0] < 0.0) == (limits[1] < 0.0) {
            return None;
        }
        let (from, to) = (place(a[0], a[1]), place(b[0], b[1]));
        let between = |t: f64| [0, 1].map(|k| from[k] + t * (to[k] - from[k]));
        Some(between(sign_change([0.0, 1.0], |t| value(between(t)))?))
    });
    zero_curves(value, seeds.collect::<Vec<_>>())
}

/// The limit of undercut along the face, and the shares of its place farthest above the root.
fn undercut(
    flank: &BevelFlank,
    grid: &FlankGrid,
    is_cut: impl Fn(&FlankPoint<WorkFrame>) -> bool,
) -> (Vec<SharesLine>, Option<[f64; 2]>) {
    let share = |k: usize, parts: usize| k as f64 / parts as f64;
    let is_crossed = (0..grid.columns).any(|column| {
        let face = share(column, grid.columns - 1);
        let ends = grid.ends_of_column(face);
        ends.is_some_and(|[lowest, _]| flank.is_undercut(face, lowest))
    });
    if !is_crossed {
        return Default::default();
    }
    let limit = |face: f64| {
        let [_, highest] = grid.ends_of_column(face)?;
        flank.undercut_limit(face, highest).filter(&is_cut)
    };
    let points: Vec<_> = (0..=STATIONS).map(|k| limit(share(k, STATIONS))).collect();
    let runs = points.split(Option::is_none);
    let curves = runs.flat_map(|run| in_section(flank, run.iter().flatten()));
    let place = |face: f64| {
        let [_, height] = flank.section.shares(axial_place(&limit(face)?))?;
        (0.0..=1.0).contains(&height).then_some([face, height])
    };
    let above_root = |face: f64| {
        let [_, height] = place(face)?;
        let [z, radius] = flank.section.up(face);
        Some(height * f64::hypot(z, radius))
    };
    let highest = greatest([0.0, 1.0], STATIONS as u32, above_root);
    (curves.collect(), highest.and_then(|[face, _]| place(face)))
}

/// The runs of a curve within the section of a flank.
fn in_section<'a>(
    flank: &BevelFlank,
    curve: impl Iterator<Item = &'a FlankPoint<WorkFrame>>,
) -> Vec<SharesLine> {
    flank.section.runs(curve.map(axial_place))
}

/// `[z, radius]` of a point.
fn axial_place(point: &FlankPoint<WorkFrame>) -> [f64; 2] {
    let r = point.point.coordinates;
    [r.z, f64::hypot(r.x, r.y)]
}
