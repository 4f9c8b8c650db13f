//! One flank cut by discrete blades: scallop heights, a deviation map per cause, the finishing blade of each node, a profile.

use super::bevel_member;
use super::cut_causes::{self, CutCause};
use crate::base::error::Error;
use crate::gear::bevel::flank::{BevelFlank, ToothPoint};
use crate::gear::bevel::flank_grid::FlankGrid;
use crate::gear::bevel::frames::WorkFrame;
use crate::gear::cut::blade_passes::{BladePasses, CutPoint, scallop_height};
use crate::gear::cut::cutter_head::BladeFeed;
use crate::gear::kernel::envelope::FlankPoint;
use crate::scene::cut_file::CutFile;
use crate::scene::machine_settings::{FlankCut, Process};

/// Points of a profile per scallop.
const POINTS_PER_SCALLOP: f64 = 16.0;
/// Minimum and maximum number of points of a profile.
const PROFILE_POINTS_RANGE: [usize; 2] = [200, 3000];

/// Flank cut by discrete blades, with its deviations from the ideal flank.
#[derive(Debug, Clone)]
pub struct CutFlankResult {
    /// 0 for the pinion, 1 for the gear.
    pub member: usize,
    /// 0 for the concave flank, 1 for the convex one.
    pub side: usize,
    /// Cradle feed and number of blades.
    pub feed: BladeFeed,
    /// Nodes of the ideal flank.
    pub grid: FlankGrid,
    /// Scallop heights by `|D| Δx²/8`, m.
    pub law: DeviationMap,
    /// Largest scallop heights along the normals over all phases of the passes, m.
    pub scallops: DeviationMap,
    /// Largest relative difference between `law` and `scallops`; `None` without scallops.
    pub law_error: Option<f64>,
    /// Minimum number of nodes per scallop, along the height and along the face; `None` without scallops.
    pub nodes_per_scallop: Option<f64>,
    /// Flank for each cause of deviation; the last one combines all causes.
    pub causes: Vec<CauseResult>,
    /// Profile at the middle of the face.
    pub profile: CutProfile,
}

/// Flank that results from one cause of deviation.
#[derive(Debug, Clone)]
pub struct CauseResult {
    /// Name of the cause.
    pub name: String,
    /// Finishing pass and deviation at each node.
    pub cuts: Vec<Option<CutPoint>>,
    /// Deviations along the normals, m; positive: excess metal.
    pub map: DeviationMap,
    /// Share of the nodes that each blade finishes, 0–1.
    pub blade_shares: Vec<f64>,
    /// Passes of the blades.
    pub passes: BladePasses,
}

/// Deviations over a flank.
#[derive(Debug, Clone, PartialEq)]
pub struct DeviationMap {
    /// Deviation of each node, m; `None` in the fillet and where no pass finishes the node.
    pub deviations: Vec<Option<f64>>,
    /// Statistics of the deviations; `None` if no node is cut.
    pub statistics: Option<DeviationStatistics>,
}

/// Statistics of deviations over a flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeviationStatistics {
    /// Lowest, m.
    pub lowest: f64,
    /// Highest, m.
    pub highest: f64,
    /// Standard deviation over the nodes, m.
    pub std: f64,
    /// Position of the highest deviation: fractions of the face width and of the tooth height, 0–1.
    pub at: [f64; 2],
}

/// Deviations along a profile from root to tip.
#[derive(Debug, Clone, PartialEq)]
pub struct CutProfile {
    /// Distances from the root, m.
    pub distances: Vec<f64>,
    /// Deviations with regular blades and with all causes, m.
    pub curves: [Vec<Option<f64>>; 2],
}

/// Computes the flank `side` of `member` cut by the blades, with a deviation map for each cause.
///
/// # Errors
/// The cutter does not reach the blank; an error history ends before the roll.
pub fn flank(
    file: &CutFile,
    [member, side]: [usize; 2],
    cut: &FlankCut,
) -> Result<CutFlankResult, Error> {
    let gear = &file.bevel.members[member];
    let hand = file.bevel.hand_of(member);
    let ideal = BevelFlank::new(&cut.cutter, &cut.settings, hand, gear.section);
    let [rows, columns] = file.study.grid;
    let (Some(grid), Some(middle)) = (FlankGrid::of(&ideal, rows, columns), ideal.middle()) else {
        return Err(bevel_member::unreached(gear, member, side));
    };
    let feed = file.study.feed(gear.process == Process::Generated);
    let causes = cut_causes::of_flank(file, &cut.settings, feed, &grid)?;
    let machine = (&cut.cutter, &cut.settings, hand);
    let depth = gear.section.depth();
    let passes: Vec<(CutCause, BladePasses)> = (causes.into_iter())
        .map(|cause| {
            let passes = BladePasses::new(machine, depth, middle[1], &cause.conditions);
            (cause, passes)
        })
        .collect();
    let map_over_nodes = |value: &dyn Fn(&FlankPoint<WorkFrame>) -> Option<f64>| {
        let nodes = grid.nodes.iter().map(|node| value(flank_node(node)?));
        DeviationMap::new(nodes.collect(), &grid)
    };
    let law = map_over_nodes(&|p| Some(scallop_height(&p.second_order, feed.step())));
    let regular = passes.first().map(|(_, passes)| passes);
    let scallops = map_over_nodes(&|p| regular?.scallop(p));
    let is_blade_node = |node: usize| {
        let point = flank_node(&grid.nodes[node]);
        regular
            .zip(point)
            .is_some_and(|(passes, point)| passes.is_on_blade_facet(point))
    };
    Ok(CutFlankResult {
        law_error: law_error(&law, &scallops, is_blade_node),
        nodes_per_scallop: nodes_per_scallop(&grid, feed.step()),
        profile: profile(&ideal, middle, feed, &passes),
        causes: passes.iter().map(|(c, p)| by_cause(c, p, &grid)).collect(),
        member,
        side,
        feed,
        law,
        scallops,
        grid,
    })
}

/// Flank point of a node; `None` in the fillet.
pub fn flank_node(node: &Option<ToothPoint>) -> Option<&FlankPoint<WorkFrame>> {
    let node = node.as_ref().filter(|n| !n.in_fillet)?;
    Some(&node.point)
}

fn by_cause(cause: &CutCause, passes: &BladePasses, grid: &FlankGrid) -> CauseResult {
    let cuts: Vec<Option<CutPoint>> = (grid.nodes.iter())
        .map(|node| passes.cut(flank_node(node)?, 0.0))
        .collect();
    let blades = cause.conditions.feed.blades as usize;
    let mut counts = vec![0.0; blades];
    cuts.iter()
        .flatten()
        .for_each(|cut| counts[cut.blade] += 1.0);
    let n_cut = cuts.iter().flatten().count().max(1) as f64;
    CauseResult {
        name: cause.name.clone(),
        map: DeviationMap::new(cuts.iter().map(|c| Some((*c)?.deviation)).collect(), grid),
        blade_shares: counts.into_iter().map(|count| count / n_cut).collect(),
        cuts,
        passes: passes.clone(),
    }
}

impl DeviationMap {
    fn new(deviations: Vec<Option<f64>>, grid: &FlankGrid) -> DeviationMap {
        let share = |i: usize, n: usize| i as f64 / (n.max(2) - 1) as f64;
        let values = deviations.iter().enumerate();
        let values: Vec<(usize, f64)> = values.filter_map(|(i, d)| Some((i, (*d)?))).collect();
        let count = values.len() as f64;
        let mean = values.iter().map(|v| v.1).sum::<f64>() / count;
        let squares: f64 = values.iter().map(|v| (v.1 - mean) * (v.1 - mean)).sum();
        let largest = values.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        let statistics = largest.map(|(i, largest)| DeviationStatistics {
            lowest: values.iter().fold(*largest, |low, v| low.min(v.1)),
            highest: *largest,
            std: (squares / count).sqrt(),
            at: [
                share(i % grid.columns, grid.columns),
                share(i / grid.columns, grid.rows),
            ],
        });
        DeviationMap {
            deviations,
            statistics,
        }
    }
}

/// Largest relative difference between the scallop formula and the scallops along the normals, over the blade nodes.
fn law_error(
    law: &DeviationMap,
    scallops: &DeviationMap,
    is_blade_node: impl Fn(usize) -> bool,
) -> Option<f64> {
    let pairs = law.deviations.iter().zip(&scallops.deviations).enumerate();
    let pairs = pairs.filter(|(node, _)| is_blade_node(*node));
    let errors = pairs.filter_map(|(_, (law, scallop))| Some(((*law)? / (*scallop)? - 1.0).abs()));
    errors.filter(|e| e.is_finite()).reduce(f64::max)
}

/// Cradle step per blade over the largest cradle-angle difference between neighbouring nodes.
fn nodes_per_scallop(grid: &FlankGrid, step: f64) -> Option<f64> {
    let cradle_angle = |row: usize, column: usize| {
        let node = grid.node(row, column).filter(|n| !n.in_fillet)?;
        Some(node.point.at[2])
    };
    let mut largest = 0f64;
    for row in 0..grid.rows {
        for column in 0..grid.columns {
            let next = [cradle_angle(row + 1, column), cradle_angle(row, column + 1)];
            let differences = next.into_iter().enumerate().filter_map(|(k, next)| {
                let is_inside = k == 0 || column + 1 < grid.columns;
                Some((next.filter(|_| is_inside)? - cradle_angle(row, column)?).abs())
            });
            largest = differences.fold(largest, f64::max);
        }
    }
    (step > 0.0 && largest > 0.0).then(|| step / largest)
}

/// Profile at the middle of the face, sampled densely enough to resolve its scallops.
fn profile(
    ideal: &BevelFlank,
    middle: [f64; 3],
    feed: BladeFeed,
    passes: &[(CutCause, BladePasses)],
) -> CutProfile {
    let at = |height: f64| {
        let tooth_point = ideal.tooth_point(ideal.section.at(0.5, height), middle)?;
        (!tooth_point.in_fillet).then_some(tooth_point.point)
    };
    let ends = [at(0.0).or_else(|| at(0.2)), at(1.0)].map(|p| p.map_or(middle[2], |p| p.at[2]));
    let scallops = match feed.step() {
        0.0 => 0.0,
        step => (ends[1] - ends[0]).abs() / step,
    };
    let [min_points, max_points] = PROFILE_POINTS_RANGE;
    let count = ((POINTS_PER_SCALLOP * scallops) as usize).clamp(min_points, max_points);
    let [root, tip] = [0.0, 1.0].map(|height| ideal.section.at(0.5, height));
    let length = f64::hypot(tip[0] - root[0], tip[1] - root[1]);
    let height = |i: usize| i as f64 / (count - 1) as f64;
    let points: Vec<Option<FlankPoint<WorkFrame>>> = (0..count).map(|i| at(height(i))).collect();
    let curve = |passes: Option<&(CutCause, BladePasses)>| {
        let cut =
            |p: &Option<FlankPoint<WorkFrame>>| Some(passes?.1.cut(p.as_ref()?, 0.0)?.deviation);
        points.iter().map(cut).collect()
    };
    CutProfile {
        distances: (0..count).map(|i| length * height(i)).collect(),
        curves: [curve(passes.first()), curve(passes.last())],
    }
}
