//! One flank as discrete blades cut it: scallops, a map for each cause, the blades that finish, a profile.

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

/// Places of a profile for each scallop on it.
const PLACES_A_SCALLOP: f64 = 16.0;
/// Least and greatest number of places of a profile.
const PROFILE_PLACES: [usize; 2] = [200, 3000];

/// A flank as it is cut.
#[derive(Debug, Clone)]
pub struct CutFlankResult {
    /// 0 for the pinion, 1 for the gear.
    pub member: usize,
    /// 0 for the concave flank, 1 for the convex one.
    pub side: usize,
    /// Feed of the roll.
    pub feed: BladeFeed,
    /// Nodes of the ideal flank.
    pub grid: FlankGrid,
    /// Scallop heights by the law, m.
    pub law: DeviationMap,
    /// Highest scallops on rays over all phases of the passes, m.
    pub scallops: DeviationMap,
    /// Largest relative difference between law and rays; none without scallops.
    pub law_error: Option<f64>,
    /// Least number of nodes across a scallop, along the height and along the face; none without scallops.
    pub nodes_a_scallop: Option<f64>,
    /// The flank for each cause; the last is that of all causes.
    pub causes: Vec<CauseResult>,
    /// Profile at the middle of the face.
    pub profile: CutProfile,
}

/// The flank that one cause leaves.
#[derive(Debug, Clone)]
pub struct CauseResult {
    /// Name of the cause.
    pub name: String,
    /// The cut at each node.
    pub cuts: Vec<Option<CutPoint>>,
    /// Deviations along the normals, m.
    pub map: DeviationMap,
    /// Share of the nodes that each blade finishes.
    pub blade_shares: Vec<f64>,
    /// The passes.
    pub passes: BladePasses,
}

/// Deviations over a flank.
#[derive(Debug, Clone, PartialEq)]
pub struct DeviationMap {
    /// By node, m; none in the fillet and where no flank is left.
    pub deviations: Vec<Option<f64>>,
    /// Statistics; none where no node is cut.
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
    /// Shares of face and height of the highest.
    pub at: [f64; 2],
}

/// Deviations along a profile from root to tip.
#[derive(Debug, Clone, PartialEq)]
pub struct CutProfile {
    /// Distances from the root, m.
    pub places: Vec<f64>,
    /// Deviations with regular blades and with all causes, m.
    pub curves: [Vec<Option<f64>>; 2],
}

/// Cuts a flank.
///
/// # Errors
/// A cutter that does not reach the blank; a history that ends before the roll.
pub fn flank(
    file: &CutFile,
    [member, side]: [usize; 2],
    cut: &FlankCut,
) -> Result<CutFlankResult, Error> {
    let of = &file.bevel.members[member];
    let hand = file.bevel.hand_of(member);
    let ideal = BevelFlank::new(&cut.cutter, &cut.settings, hand, of.section);
    let [rows, columns] = file.study.grid;
    let (Some(grid), Some(middle)) = (FlankGrid::of(&ideal, rows, columns), ideal.middle()) else {
        return Err(bevel_member::unreached(of, member, side));
    };
    let feed = file.study.feed(of.process == Process::Generated);
    let causes = cut_causes::of_flank(file, &cut.settings, feed, &grid)?;
    let machine = (&cut.cutter, &cut.settings, hand);
    let depth = of.section.depth();
    let passes: Vec<(CutCause, BladePasses)> = (causes.into_iter())
        .map(|cause| {
            let passes = BladePasses::new(machine, depth, middle[1], &cause.conditions);
            (cause, passes)
        })
        .collect();
    let on_flank = |f: &dyn Fn(&FlankPoint<WorkFrame>) -> Option<f64>| {
        let nodes = grid.nodes.iter().map(|node| f(flank_node(node)?));
        DeviationMap::new(nodes.collect(), &grid)
    };
    let law = on_flank(&|p| Some(scallop_height(&p.second_order, feed.step())));
    let regular = passes.first().map(|(_, passes)| passes);
    let scallops = on_flank(&|p| regular?.scallop(p));
    let is_of_blade = |node: usize| {
        let point = flank_node(&grid.nodes[node]);
        regular
            .zip(point)
            .is_some_and(|(passes, point)| passes.is_of_blade(point))
    };
    Ok(CutFlankResult {
        law_error: law_error(&law, &scallops, is_of_blade),
        nodes_a_scallop: nodes_a_scallop(&grid, feed.step()),
        profile: profile(&ideal, middle, feed, &passes),
        causes: passes.iter().map(|(c, p)| cause(c, p, &grid)).collect(),
        member,
        side,
        feed,
        law,
        scallops,
        grid,
    })
}

/// The point of a node on the flank; none in the fillet.
pub fn flank_node(node: &Option<ToothPoint>) -> Option<&FlankPoint<WorkFrame>> {
    let node = node.as_ref().filter(|n| !n.in_fillet)?;
    Some(&node.point)
}

fn cause(cause: &CutCause, passes: &BladePasses, grid: &FlankGrid) -> CauseResult {
    let cuts: Vec<Option<CutPoint>> = (grid.nodes.iter())
        .map(|node| passes.cut(flank_node(node)?, 0.0))
        .collect();
    let blades = cause.conditions.feed.blades as usize;
    let mut counts = vec![0.0; blades];
    cuts.iter()
        .flatten()
        .for_each(|cut| counts[cut.blade] += 1.0);
    let all = cuts.iter().flatten().count().max(1) as f64;
    CauseResult {
        name: cause.name.clone(),
        map: DeviationMap::new(cuts.iter().map(|c| Some((*c)?.deviation)).collect(), grid),
        blade_shares: counts.into_iter().map(|count| count / all).collect(),
        cuts,
        passes: passes.clone(),
    }
}

impl DeviationMap {
    fn new(deviations: Vec<Option<f64>>, grid: &FlankGrid) -> DeviationMap {
        let share = |i: usize, n: usize| i as f64 / (n.max(2) - 1) as f64;
        let found = deviations.iter().enumerate();
        let found: Vec<(usize, f64)> = found.filter_map(|(i, d)| Some((i, (*d)?))).collect();
        let count = found.len() as f64;
        let mean = found.iter().map(|f| f.1).sum::<f64>() / count;
        let squares: f64 = found.iter().map(|f| (f.1 - mean) * (f.1 - mean)).sum();
        let highest = found.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        let statistics = highest.map(|(i, highest)| DeviationStatistics {
            lowest: found.iter().fold(*highest, |low, f| low.min(f.1)),
            highest: *highest,
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

/// Largest relative difference of the law from the scallops on rays, at nodes that the law counts for.
fn law_error(
    law: &DeviationMap,
    scallops: &DeviationMap,
    counts: impl Fn(usize) -> bool,
) -> Option<f64> {
    let pairs = law.deviations.iter().zip(&scallops.deviations).enumerate();
    let pairs = pairs.filter(|(node, _)| counts(*node));
    let errors = pairs.filter_map(|(_, (law, ray))| Some(((*law)? / (*ray)? - 1.0).abs()));
    errors.filter(|e| e.is_finite()).reduce(f64::max)
}

/// Step of the cradle from blade to blade over the largest from node to node.
fn nodes_a_scallop(grid: &FlankGrid, step: f64) -> Option<f64> {
    let turn = |row: usize, column: usize| {
        let node = grid.node(row, column).filter(|n| !n.in_fillet)?;
        Some(node.point.at[2])
    };
    let mut largest = 0f64;
    for row in 0..grid.rows {
        for column in 0..grid.columns {
            let next = [turn(row + 1, column), turn(row, column + 1)];
            let apart = next.into_iter().enumerate().filter_map(|(k, next)| {
                let is_inside = k == 0 || column + 1 < grid.columns;
                Some((next.filter(|_| is_inside)? - turn(row, column)?).abs())
            });
            largest = apart.fold(largest, f64::max);
        }
    }
    (step > 0.0 && largest > 0.0).then(|| step / largest)
}

/// The profile at the middle of the face, dense enough to show its scallops.
fn profile(
    ideal: &BevelFlank,
    middle: [f64; 3],
    feed: BladeFeed,
    passes: &[(CutCause, BladePasses)],
) -> CutProfile {
    let at = |height: f64| {
        let found = ideal.tooth_point(ideal.section.at(0.5, height), middle)?;
        (!found.in_fillet).then_some(found.point)
    };
    let ends = [at(0.0).or_else(|| at(0.2)), at(1.0)].map(|p| p.map_or(middle[2], |p| p.at[2]));
    let scallops = match feed.step() {
        0.0 => 0.0,
        step => (ends[1] - ends[0]).abs() / step,
    };
    let [least, most] = PROFILE_PLACES;
    let count = ((PLACES_A_SCALLOP * scallops) as usize).clamp(least, most);
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
        places: (0..count).map(|i| length * height(i)).collect(),
        curves: [curve(passes.first()), curve(passes.last())],
    }
}
