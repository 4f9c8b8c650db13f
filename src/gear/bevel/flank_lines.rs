//! Lines on a bevel flank over the shares of its face and height: contact lines with the cutter, and the limits that cross the flank.

use super::flank::{BevelFlank, is_cut_away};
use super::flank_grid::FlankGrid;
use super::frames::WorkFrame;
use crate::gear::kernel::envelope::FlankPoint;
use crate::gear::kernel::root::greatest;

/// Contact lines of a flank.
const LINES: usize = 12;
/// Steps along a contact line, over the domain of the flank's limits.
const STEPS: usize = 180;

/// Parts of the face at whose ends the limit of undercut is found.
const STATIONS: usize = 48;

/// A line as shares of face and height.
pub type SharesLine = Vec<[f64; 2]>;

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
        let Some(domain) = grid.domain().filter(|_| !flank.envelope.motion.is_fixed()) else {
            return FlankLimits::default();
        };
        let nodes = || grid.nodes.iter().flatten().filter(|n| !n.in_fillet);
        let is_whole = grid.nodes.iter().all(Option::is_some);
        let mut signs = nodes().map(|n| n.point.second_order.second_limit < 0.0);
        let first_sign = signs.next();
        let second = match is_whole && !signs.any(|sign| Some(sign) != first_sign) {
            true => Vec::new(),
            false => (flank.second_limits(domain).iter())
                .flat_map(|curve| in_section(flank, curve.iter().filter(|p| is_cut(p))))
                .collect(),
        };
        let places = second.iter().flatten().copied();
        let highest_second = places.max_by(|a: &[f64; 2], b| a[1].total_cmp(&b[1]));
        let (undercut, highest) = undercut(flank, grid, is_cut);
        FlankLimits {
            curves: [undercut, second],
            highest: [highest, highest_second],
        }
    }
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
