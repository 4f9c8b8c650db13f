//! Flanks, tooth and top land of a bevel gear on its blank.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::bevel::flank::BevelFlank;
use crate::gear::bevel::flank_grid::FlankGrid;
use crate::gear::bevel::flank_lines::FlankLimits;
use crate::gear::bevel::frames::WorkFrame;
use crate::gear::bevel::structure_elements::StructureElements;
use crate::gear::bevel::tooth::{BevelTooth, SIDES, TopLand};
use crate::gear::kernel::envelope::FlankPoint;
use crate::plan::gear_limits::MEMBERS;
use crate::scene::bevel_file::{BevelFile, BevelMember};

/// Rows along the height and columns along the face of a flank grid.
pub const GRID: [usize; 2] = [9, 15];

/// Flanks and tooth of a member.
#[derive(Debug, Clone)]
pub struct MemberResult {
    /// Concave and convex flank; absent if the file does not describe them.
    pub flanks: [Option<FlankResult>; 2],
    /// Tooth; absent without both flanks and their thickness.
    pub tooth: Option<BevelTooth>,
    /// Thinnest top land of the tooth.
    pub top_land: Option<TopLand>,
}

/// Flank on its blank with its limits and its properties at the mean point.
#[derive(Debug, Clone)]
pub struct FlankResult {
    /// Surface of the flank.
    pub flank: BevelFlank,
    /// Grid of nodes over the blank.
    pub grid: FlankGrid,
    /// Limit lines on the flank.
    pub limits: FlankLimits,
    /// Structure elements at the mean point.
    pub elements: Option<StructureElements>,
    /// Principal curvatures at the mean point, 1/m.
    pub curvatures: Option<[f64; 2]>,
}

/// Computes the flanks and the tooth of a member.
///
/// # Errors
/// A cutter that does not reach the middle of the tooth.
pub(super) fn member(file: &BevelFile, k: usize) -> Result<MemberResult, Error> {
    let m = &file.members[k];
    let flank = |side: usize| -> Result<Option<FlankResult>, Error> {
        let Some(flank) = file.flank(k, side) else {
            return Ok(None);
        };
        let [rows, columns] = GRID;
        let Some(grid) = FlankGrid::of(&flank, rows, columns) else {
            return Err(unreached(m, k, side));
        };
        let mean = flank
            .middle()
            .and_then(|estimate| flank.tooth_point(m.blank.mean_point(), estimate))
            .map(|p| p.point);
        let curvatures = mean.and_then(|p| p.second_order.envelope());
        let root_angle = m.blank.root_angle;
        let is_cut = |p: &FlankPoint<WorkFrame>| {
            (m.straight).is_none_or(|s| s.is_cut_above_root(p, root_angle))
        };
        Ok(Some(FlankResult {
            limits: FlankLimits::of(&flank, &grid, is_cut),
            elements: (mean.as_ref()).and_then(|p| StructureElements::of(p, m.blank.pitch_apex)),
            curvatures: curvatures.map(|w| w.principal().map(|(k, _)| k)),
            grid,
            flank,
        }))
    };
    let flanks = [flank(0)?, flank(1)?];
    let tooth = tooth(file, k);
    Ok(MemberResult {
        top_land: tooth.as_ref().and_then(BevelTooth::top_land),
        tooth,
        flanks,
    })
}

/// Tooth of a member; `None` if its flanks do not form one.
pub fn tooth(file: &BevelFile, k: usize) -> Option<BevelTooth> {
    let gear = &file.members[k];
    if gear.missing_tooth_reason().is_some() {
        return None;
    }
    let flanks = [file.flank(k, 0)?, file.flank(k, 1)?];
    BevelTooth::new(flanks, gear.teeth, &gear.blank, gear.thickness)
}

/// Flanks of pinion and gear on the given sides; `None` if one is not described or is completely removed by undercut.
pub(super) fn flanks_of_sides(
    members: &[MemberResult; 2],
    sides: [usize; 2],
) -> Option<[BevelFlank; 2]> {
    let flank = |k: usize| {
        let flank = members[k].flanks[sides[k]].as_ref();
        let flank = flank.filter(|f| f.grid.nodes.iter().any(Option::is_some))?;
        Some(flank.flank.clone())
    };
    Some([flank(0)?, flank(1)?])
}

/// Error about a tool that does not reach the middle of the tooth.
pub fn unreached(gear: &BevelMember, member: usize, side: usize) -> Error {
    let message = format!(
        "the tool of the {} flank of the {} does not reach the middle of its tooth",
        SIDES[side], MEMBERS[member]
    );
    let hint = match gear.straight {
        Some(_) => {
            "check the cones of the blank: a spherical involute ends at its base cone, sin δ_b = sin δ cos α"
        }
        None => {
            "check radial_distance, cradle_angle, machine_root_angle and the hand: the mirror image of the other hand has the same settings"
        }
    };
    Error::new(Code::OutOfRange, message)
        .with_span(&gear.span)
        .with_hint(hint)
}
