//! Contact lines with the cutter and limit curves of both kinds on a bevel flank, in shares of face and height.

use super::flank::{BevelFlank, is_cut_away};
use super::flank_grid::FlankGrid;
use super::frames::WorkFrame;
use super::zero_curves::{SharesLine, zero_curves};
use crate::gear::kernel::envelope::FlankPoint;
use crate::gear::kernel::jet::Surface;
use crate::gear::kernel::root::{greatest, sign_change};

/// Number of contact lines of a flank.
const LINES: usize = 12;
/// Steps along a contact line over the range of θ.
const STEPS: usize = 180;

/// Intervals of the face at whose ends the undercut limit is computed.
const STATIONS: usize = 48;

/// Contact lines of cutter and work at equal steps of the cradle angle.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactLines {
    /// Step of the cradle angle between neighbouring lines, rad.
    pub step: f64,
    /// Lines by ascending cradle angle; a line that leaves the flank and returns counts as two.
    pub lines: Vec<SharesLine>,
}

impl ContactLines {
    /// Contact lines on a flank with its nodes, up to the undercut limit; `None` for fixed work, where the flank is the cutter surface.
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
            let segments = points.split(Option::is_none);
            let segments = segments.flat_map(|segment| in_section(flank, segment.iter().flatten()));
            segments.collect::<Vec<_>>()
        };
        Some(ContactLines {
            step,
            lines: (0..LINES).flat_map(line).collect(),
        })
    }
}

/// Limits of the first and second kind on a flank, in this order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FlankLimits {
    /// Limit curves in shares of face and height.
    pub curves: [Vec<SharesLine>; 2],
    /// Shares of the highest point above the root: for the undercut limit to rounding, for the second kind among the points of its curves.
    pub highest: [Option<[f64; 2]>; 2],
}

impl FlankLimits {
    /// Limits that cross a flank, restricted to points for which `is_cut` holds: those that the tool reaches.
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

/// Curves `Φ = 0` of the limit of the second kind, traced from sign changes between neighbouring nodes.
fn second_limit(
    flank: &BevelFlank,
    grid: &FlankGrid,
    is_cut: impl Fn(&FlankPoint<WorkFrame>) -> bool,
) -> Vec<SharesLine> {
    let share = |i: usize, n: usize| i as f64 / (n.max(2) - 1) as f64;
    let shares = |row: usize, column: usize| [share(column, grid.columns), share(row, grid.rows)];
    let node = |row: usize, column: usize| {
        let node = (row < grid.rows && column < grid.columns).then(|| grid.node(row, column))??;
        (!node.in_fillet).then_some(node.point)
    };
    let indices = (0..grid.rows).flat_map(|row| (0..grid.columns).map(move |column| [row, column]));
    let nodes: Vec<_> = (indices.clone())
        .filter_map(|[row, column]| Some((shares(row, column), node(row, column)?.at)))
        .collect();
    let [end, top] = flank.envelope.surface.range();
    let value = |shares: [f64; 2]| {
        let distance = |p: [f64; 2]| f64::hypot(p[0] - shares[0], p[1] - shares[1]);
        let nearest = nodes
            .iter()
            .min_by(|a, b| distance(a.0).total_cmp(&distance(b.0)))?;
        let point = flank.point(shares, nearest.1)?;
        let is_on_blade = (end..=top).contains(&point.at[0]);
        (is_on_blade && is_cut(&point)).then_some(point.second_order.second_limit)
    };
    let edges = indices.flat_map(|[row, column]| {
        let neighbours = [[row + 1, column], [row, column + 1]];
        neighbours.map(|neighbour| [[row, column], neighbour])
    });
    let seeds = edges.filter_map(|[a, b]| {
        let [from, to] = [node(a[0], a[1])?, node(b[0], b[1])?];
        let limits = [from, to].map(|p| p.second_order.second_limit);
        if (limits[0] < 0.0) == (limits[1] < 0.0) {
            return None;
        }
        let (from, to) = (shares(a[0], a[1]), shares(b[0], b[1]));
        let between = |t: f64| [0, 1].map(|k| from[k] + t * (to[k] - from[k]));
        Some(between(sign_change([0.0, 1.0], |t| value(between(t)))?))
    });
    zero_curves(value, seeds.collect::<Vec<_>>())
}

/// Undercut limit along the face, and the shares of its highest point above the root.
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
    let segments = points.split(Option::is_none);
    let curves = segments.flat_map(|segment| in_section(flank, segment.iter().flatten()));
    let shares = |face: f64| {
        let [_, height] = flank.section.shares(axial_position(&limit(face)?))?;
        (0.0..=1.0).contains(&height).then_some([face, height])
    };
    let above_root = |face: f64| {
        let [_, height] = shares(face)?;
        let [z, radius] = flank.section.up(face);
        Some(height * f64::hypot(z, radius))
    };
    let highest = greatest([0.0, 1.0], STATIONS as u32, above_root);
    (curves.collect(), highest.and_then(|[face, _]| shares(face)))
}

/// Segments of a curve within the axial section of a flank.
fn in_section<'a>(
    flank: &BevelFlank,
    curve: impl Iterator<Item = &'a FlankPoint<WorkFrame>>,
) -> Vec<SharesLine> {
    flank.section.runs(curve.map(axial_position))
}

/// Coordinates `[z, radius]` of a flank point, m.
fn axial_position(point: &FlankPoint<WorkFrame>) -> [f64; 2] {
    let r = point.point.coordinates;
    [r.z, f64::hypot(r.x, r.y)]
}
