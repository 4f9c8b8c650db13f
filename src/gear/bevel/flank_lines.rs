//! Lines on a bevel flank over the shares of its face and height: contact lines with the cutter, and the limits that cross the flank.

use super::flank::{BevelFlank, is_cut_away};
use super::flank_grid::FlankGrid;
use super::frames::WorkFrame;
use crate::gear::kernel::envelope::FlankPoint;
use crate::gear::kernel::limits::Limit;

/// Contact lines of a flank.
const LINES: usize = 12;
/// Steps along a contact line, over the domain of the flank's limits.
const STEPS: usize = 180;

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

/// Curves of the limits of both kinds on the flank, `[first, second]`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FlankLimits(pub [Vec<SharesLine>; 2]);

impl FlankLimits {
    /// The curves that cross a flank, of points that a tool reaches; they are traced only where the nodes show that one crosses.
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
        let is_crossed = [
            !is_whole,
            !is_whole || signs.any(|sign| Some(sign) != first_sign),
        ];
        let curves = |(limit, crossed): (Limit, bool)| match crossed {
            true => (flank.limits(limit, domain).iter())
                .flat_map(|curve| in_section(flank, curve.iter().filter(|p| is_cut(p))))
                .collect(),
            false => Vec::new(),
        };
        let kinds = [Limit::Undercut, Limit::Second];
        FlankLimits([0, 1].map(|k| curves((kinds[k], is_crossed[k]))))
    }

    /// Shares of the place of a kind of limit nearest the tip.
    pub fn highest(&self, kind: usize) -> Option<[f64; 2]> {
        let places = self.0[kind].iter().flatten().copied();
        places.max_by(|a, b| a[1].total_cmp(&b[1]))
    }
}

/// The runs of a curve within the section of a flank.
fn in_section<'a>(
    flank: &BevelFlank,
    curve: impl Iterator<Item = &'a FlankPoint<WorkFrame>>,
) -> Vec<SharesLine> {
    flank.section.runs(curve.map(|p| {
        let r = p.point.coordinates;
        [r.z, f64::hypot(r.x, r.y)]
    }))
}
