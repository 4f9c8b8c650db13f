//! A bevel pair by machine settings: flanks on their blanks, limits, tooth, contact, stages.

use super::bevel_contact::{BevelContact, contact};
use super::bevel_mesh::{self, BevelMeshResult};
use super::geometry::{GearQuantity, Quantities, QuantityUnit};
use super::{axodes, bevel_stability, hypoid_theory};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::quantity::format_number;
use crate::gear::bevel::flank::{BevelFlank, ToothPoint};
use crate::gear::bevel::flank_grid::FlankGrid;
use crate::gear::bevel::settings::Hand;
use crate::gear::bevel::straight::StraightProfile;
use crate::gear::bevel::structure_elements::StructureElements;
use crate::gear::bevel::tooth::{BevelTooth, SIDES, TopLand};
use crate::gear::kernel::limits::Limit;
use crate::plan::decision::StageDecision;
use crate::plan::gear_limits::MEMBERS;
use crate::scene::bevel_file::{BevelFile, BevelMember};
use crate::scene::machine_settings::Process;

/// Rows along the height and columns along the face of a flank.
pub const GRID: [usize; 2] = [9, 15];

/// Results of a bevel file.
#[derive(Debug, Clone)]
pub struct BevelResult {
    /// Blanks and teeth.
    pub quantities: Vec<GearQuantity>,
    /// Pinion and gear.
    pub members: [MemberResult; 2],
    /// Limits that the flanks meet.
    pub limits: Vec<BevelLimit>,
    /// Contact of the requested flanks.
    pub contact: Option<BevelContact>,
    /// The pair under load, where the file has a torque.
    pub mesh: Option<BevelMeshResult>,
    /// Stages with what they do.
    pub plan: Vec<(&'static str, StageDecision)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Flanks of a member.
#[derive(Debug, Clone)]
pub struct MemberResult {
    /// Concave and convex flank, where the file describes them.
    pub flanks: [Option<FlankResult>; 2],
    /// The tooth, where both flanks and their thickness are known.
    pub tooth: Option<BevelTooth>,
    /// Thinnest top land of the tooth.
    pub top_land: Option<TopLand>,
}

/// A flank on its blank.
#[derive(Debug, Clone)]
pub struct FlankResult {
    /// The flank.
    pub flank: BevelFlank,
    /// Nodes over the blank.
    pub grid: FlankGrid,
    /// Structure elements at the mean point.
    pub elements: Option<StructureElements>,
    /// Principal curvatures at the mean point, 1/m.
    pub curvatures: Option<[f64; 2]>,
}

/// A limit that a flank meets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BevelLimit {
    /// `undercut`, `second` or `pointed`.
    pub kind: &'static str,
    /// 0 for the pinion, 1 for the gear.
    pub member: usize,
    /// Index of the flank in [`SIDES`]; none for the tooth.
    pub side: Option<usize>,
    /// Shares of face and height of the place nearest the tip (of pointed teeth nearest the root).
    pub at: [f64; 2],
    /// Depth of the teeth beyond the limit there, m.
    pub depth: f64,
}

/// Computes what the file determines.
///
/// # Errors
/// Cutters that do not reach their blanks.
pub fn run(file: &BevelFile) -> Result<BevelResult, Error> {
    let mut limits = Vec::new();
    let mut members = Vec::with_capacity(2);
    for k in 0..2 {
        let member = member(file, k)?;
        for side in 0..2 {
            let found = member.flanks[side].as_ref();
            limits.extend(
                found
                    .into_iter()
                    .flat_map(|f| flank_limits(&file.members[k], f, k, side)),
            );
        }
        limits.extend(
            member
                .top_land
                .and_then(|land| pointed(&file.members[k], land, k)),
        );
        members.push(member);
    }
    let members: [MemberResult; 2] = members
        .try_into()
        .map_err(|_| Error::new(Code::MissingKey, "the gears are not described"))?;
    let mut diagnostics: Vec<Diagnostic> = limits.iter().map(|l| warning(file, l)).collect();
    let sides = file.contact.side.flanks();
    let touching = [0, 1].map(|k| {
        members[k].flanks[sides[k]]
            .as_ref()
            .map(|f| f.flank.clone())
    });
    let contact = match touching {
        [Some(pinion), Some(gear)] if !file.is_conjugate() => {
            contact(file, [pinion, gear], &mut diagnostics)
        }
        _ => None,
    };
    let mesh = match &contact {
        Some(contact) => {
            let teeth = members.each_ref().map(|m| m.tooth.as_ref());
            bevel_mesh::mesh(file, teeth, contact, &mut diagnostics)?
        }
        None => None,
    };
    Ok(BevelResult {
        mesh,
        quantities: quantities(file, &members),
        plan: plan(file),
        members,
        limits,
        contact,
        diagnostics,
    })
}

/// The flanks and the tooth of a member.
fn member(file: &BevelFile, k: usize) -> Result<MemberResult, Error> {
    let of = &file.members[k];
    let flank = |side: usize| -> Result<Option<FlankResult>, Error> {
        let Some(flank) = file.flank(k, side) else {
            return Ok(None);
        };
        let [rows, columns] = GRID;
        let Some(grid) = FlankGrid::of(&flank, rows, columns) else {
            return Err(unreached(of, k, side));
        };
        let mean = flank
            .middle()
            .and_then(|near| flank.tooth_point(of.blank.mean_point(), near))
            .map(|found| found.point);
        let curvatures = mean.and_then(|p| p.second_order.envelope());
        Ok(Some(FlankResult {
            elements: mean.as_ref().and_then(StructureElements::of),
            curvatures: curvatures.map(|w| w.principal().map(|(k, _)| k)),
            grid,
            flank,
        }))
    };
    let flanks = [flank(0)?, flank(1)?];
    let tooth = match (&flanks, of.lacks_tooth()) {
        ([Some(a), Some(b)], None) => BevelTooth::new(
            [a.flank.clone(), b.flank.clone()],
            of.teeth,
            of.blank.mean_point(),
            of.thickness,
        ),
        _ => None,
    };
    Ok(MemberResult {
        top_land: tooth.as_ref().and_then(BevelTooth::top_land),
        tooth,
        flanks,
    })
}

/// The error of a tool that misses the tooth.
pub fn unreached(of: &BevelMember, member: usize, side: usize) -> Error {
    let message = format!(
        "the tool of the {} flank of the {} does not reach the middle of its tooth",
        SIDES[side], MEMBERS[member]
    );
    let hint = match of.straight {
        Some(_) => {
            "check the cones of the blank: a spherical involute ends at its base cone, sin δ_b = sin δ cos α"
        }
        None => {
            "check radial_distance, cradle_angle, machine_root_angle and the hand: the mirror image of the other hand has the same settings"
        }
    };
    Error::new(Code::OutOfRange, message)
        .with_span(&of.span)
        .with_hint(hint)
}

/// Limits of both kinds on a flank.
fn flank_limits(on: &BevelMember, of: &FlankResult, member: usize, side: usize) -> Vec<BevelLimit> {
    let Some(domain) = of.grid.domain() else {
        return Vec::new();
    };
    if of.flank.envelope.motion.is_fixed() {
        return Vec::new();
    }
    let section = &of.flank.section;
    let highest = |limit: Limit| {
        let curves = of.flank.limits(limit, domain);
        let cut = curves.iter().flatten().filter(|p| {
            let root_angle = on.blank.root_angle;
            on.straight
                .is_none_or(|s| s.is_cut_above_root(p, root_angle))
        });
        let places = cut.filter_map(|p| {
            let r = p.point.coordinates;
            section.shares([r.z, f64::hypot(r.x, r.y)])
        });
        places.max_by(|a, b| a[1].total_cmp(&b[1]))
    };
    // Curves are traced only where the nodes show that one crosses the flank.
    let nodes: Vec<&ToothPoint> = of.grid.nodes.iter().flatten().collect();
    let is_whole = nodes.len() == of.grid.nodes.len();
    let on_flank = nodes.iter().filter(|n| !n.in_fillet);
    let signs = on_flank.map(|n| n.point.second_order.second_limit < 0.0);
    let first_sign = signs.clone().next();
    let is_crossed = [
        !is_whole,
        !is_whole || signs.clone().any(|s| Some(s) != first_sign),
    ];
    let kinds = [("undercut", Limit::Undercut), ("second", Limit::Second)];
    (kinds.into_iter().zip(is_crossed))
        .filter(|(_, crossed)| *crossed)
        .filter_map(|((kind, limit), _)| {
            let at = highest(limit)?;
            let [root, here] = [section.at(at[0], 0.0), section.at(at[0], at[1])];
            Some(BevelLimit {
                kind,
                member,
                side: Some(side),
                at,
                depth: f64::hypot(here[0] - root[0], here[1] - root[1]),
            })
        })
        .collect()
}

/// Teeth whose flanks cross below the tip.
fn pointed(of: &BevelMember, land: TopLand, member: usize) -> Option<BevelLimit> {
    let height = land.pointed_at?;
    let [tip, here] = [
        of.section.at(land.face, 1.0),
        of.section.at(land.face, height),
    ];
    Some(BevelLimit {
        kind: "pointed",
        member,
        side: None,
        at: [land.face, height],
        depth: f64::hypot(here[0] - tip[0], here[1] - tip[1]),
    })
}

/// A limit as a warning.
fn warning(file: &BevelFile, limit: &BevelLimit) -> Diagnostic {
    let name = MEMBERS[limit.member];
    let flank = limit.side.map_or(String::new(), |side| {
        format!("{} flank of the ", SIDES[side])
    });
    let at = format!("{:.0} % of the face from the toe", 100.0 * limit.at[0]);
    let depth = 1e3 * limit.depth;
    let (message, hint) = match limit.kind {
        "undercut" => (
            format!("the {flank}{name} is undercut up to {depth:.3} mm above the root at {at}"),
            "take a smaller dedendum, a larger blade angle or another ratio of roll",
        ),
        "second" => (
            format!(
                "the cutter ends to touch the {flank}{name} {depth:.3} mm above the root at {at}"
            ),
            "contact lines have an envelope on the cutter there: take another cradle angle or ratio of roll",
        ),
        _ => (
            format!("the teeth of the {name} are pointed {depth:.3} mm below the tip at {at}"),
            match file.members[limit.member].thickness {
                Some(_) => "take a smaller face angle or a larger mean_normal_thickness",
                None => "take a smaller face angle or a smaller point width of the cutter",
            },
        ),
    };
    Diagnostic {
        code: match limit.kind {
            "second" => "contact-ends",
            kind => kind,
        },
        message,
        hint: Some(hint.into()),
    }
}

fn quantities(file: &BevelFile, members: &[MemberResult; 2]) -> Vec<GearQuantity> {
    use QuantityUnit::{Degree, Millimetre, One};
    let mut all = Quantities::default();
    let of =
        |value: &dyn Fn(&BevelMember) -> f64| [value(&file.members[0]), value(&file.members[1])];
    all.each("number of teeth", "z", One, of(&|m| f64::from(m.teeth)));
    all.each(
        "hand (1 right, −1 left)",
        "h",
        One,
        [0, 1].map(|k| file.hand_of(k).sign()),
    );
    all.each("pitch angle", "δ", Degree, of(&|m| m.blank.pitch_angle));
    all.each("face angle", "δ_a", Degree, of(&|m| m.blank.face_angle));
    all.each("root angle", "δ_f", Degree, of(&|m| m.blank.root_angle));
    all.each(
        "mean cone distance",
        "R_m",
        Millimetre,
        of(&|m| m.blank.mean_cone_distance),
    );
    all.each(
        "outer cone distance",
        "R_e",
        Millimetre,
        of(&|m| m.blank.cone_distances()[1]),
    );
    all.each("face width", "b", Millimetre, of(&|m| m.blank.face_width));
    all.each(
        "mean pitch diameter",
        "d_m",
        Millimetre,
        of(&|m| 2.0 * m.blank.mean_point()[1]),
    );
    all.each(
        "outer tip diameter",
        "d_ae",
        Millimetre,
        of(&|m| 2.0 * m.section.at(1.0, 1.0)[1]),
    );
    all.each(
        "crown to crossing point",
        "t_xo",
        Millimetre,
        of(&|m| m.section.at(1.0, 1.0)[0]),
    );
    all.each(
        "pitch apex beyond crossing point",
        "t_z",
        Millimetre,
        of(&|m| m.blank.pitch_apex),
    );
    all.each(
        "face apex beyond crossing point",
        "t_zF",
        Millimetre,
        of(&|m| m.blank.face_apex),
    );
    all.each(
        "root apex beyond crossing point",
        "t_zR",
        Millimetre,
        of(&|m| m.blank.root_apex),
    );
    let depth = |m: &BevelMember| {
        let [root, tip] = [m.section.at(0.5, 0.0), m.section.at(0.5, 1.0)];
        f64::hypot(tip[0] - root[0], tip[1] - root[1])
    };
    all.each("mean whole depth", "h_m", Millimetre, of(&depth));
    if let Some(design) = &file.design {
        all.pair(
            "mean normal module",
            "m_mn",
            Millimetre,
            design.normal_module,
        );
        all.each("mean spiral angle", "β_m", Degree, design.spiral_angles);
        all.pair(
            "generated pressure angle, drive",
            "α_nD",
            Degree,
            design.pressure_angles[0],
        );
        all.pair(
            "generated pressure angle, coast",
            "α_nC",
            Degree,
            design.pressure_angles[1],
        );
        all.each("mean addendum", "h_am", Millimetre, design.addenda);
        all.each("mean dedendum", "h_fm", Millimetre, design.dedenda);
        all.pair("clearance", "c", Millimetre, design.clearance);
        all.each(
            "design mean normal thickness",
            "s_mn",
            Millimetre,
            design.thicknesses,
        );
    }
    let tooth = |value: &dyn Fn(&MemberResult) -> Option<f64>| {
        [0, 1].map(|k| value(&members[k]).unwrap_or(f64::NAN))
    };
    let thickness = |m: &MemberResult| Some(m.tooth.as_ref()?.mean_normal_thickness());
    all.each(
        "mean normal thickness",
        "s_mn",
        Millimetre,
        tooth(&thickness),
    );
    all.each(
        "least top land",
        "s_an",
        Millimetre,
        tooth(&|m| Some(m.top_land?.width)),
    );
    all.pair("shaft angle", "Σ", Degree, file.nominal.shaft_angle);
    all.pair("offset", "a", Millimetre, file.nominal.offset);
    all.pair("gear ratio", "u", One, {
        let [z1, z2] = file.members.each_ref().map(|m| f64::from(m.teeth));
        z2 / z1
    });
    let elements = members.each_ref().map(|m| {
        let flanks = m.flanks.each_ref();
        flanks.map(|flank| flank.as_ref()?.elements)
    });
    if let Some(theory) = hypoid_theory::theory(file, &elements) {
        hypoid_theory::quantities(&theory, &mut all);
    }
    axodes::quantities(&hypoid_theory::axes(file), &mut all);
    all.0
}

/// The stages that run, and those left out with the reason.
pub fn plan(file: &BevelFile) -> Vec<(&'static str, StageDecision)> {
    use StageDecision::{LeftOut, Runs};
    let process = |k: usize| match file.members[k].process {
        Process::Generated => "generated",
        Process::Formate => "formate",
        Process::Straight(StraightProfile::Octoid) => "octoids of a plane crown tool",
        Process::Straight(StraightProfile::SphericalInvolute) => "spherical involutes",
    };
    let sides = |k: usize| {
        let described = (0..2).filter(|side| file.members[k].describes(*side));
        let given: Vec<&str> = described.map(|side| SIDES[side]).collect();
        format!("{} {} ({})", MEMBERS[k], given.join(" and "), process(k))
    };
    let blanks = match &file.design {
        Some(design) if design.offset_angles[0] == 0.0 => "blanks by ISO 23509:2016, method 0",
        Some(_) => "blanks by ISO 23509:2016, method 1",
        None => "blanks by their cones",
    };
    let mut plan = vec![("geometry", Runs(blanks.into()))];
    if !file.defaults.is_empty() {
        plan.push(("defaults", Runs(file.defaults.join("; "))));
    }
    let is_bare = file
        .members
        .iter()
        .all(|m| (0..2).all(|side| !m.describes(side)));
    let on_flanks = |what: String| match is_bare {
        true => LeftOut("no settings of a flank are given: the blanks alone".into()),
        false => Runs(what),
    };
    plan.push(("flanks", on_flanks(format!("{}, {}", sides(0), sides(1)))));
    plan.push((
        "limits",
        on_flanks("undercut and end of contact of the cutter on each flank".into()),
    ));
    let missing: Vec<String> = [0, 1]
        .iter()
        .filter_map(|k| {
            Some(format!(
                "{}: {}",
                MEMBERS[*k],
                file.members[*k].lacks_tooth()?
            ))
        })
        .collect();
    plan.push((
        "teeth",
        match missing.len() {
            0 => Runs("thickness and top lands of both gears".into()),
            1 => Runs(format!(
                "thickness and top lands; not of the {}",
                missing[0]
            )),
            _ => LeftOut(missing.join("; ")),
        },
    ));
    let study = &file.contact;
    plan.push((
        "contact",
        match file.missing_flank() {
            None if file.is_conjugate() => LeftOut(
                "straight flanks are conjugate: lines of contact, no transmission error".into(),
            ),
            None => Runs(format!(
                "unloaded, {} flanks, {} positions in a pitch over {} pitches each way, coating {} µm",
                study.side.name(),
                study.positions,
                study.pitches,
                format_number(1e6 * study.coating)
            )),
            Some([member, side]) => LeftOut(format!(
                "the {} flank of the {} is not described",
                SIDES[side], MEMBERS[member]
            )),
        },
    ));
    plan.push((
        "V–H check",
        match study.vh {
            true => Runs("offset and pinion position that move the pattern to toe and heel".into()),
            false => LeftOut("not requested: --vh".into()),
        },
    ));
    plan.push(("mesh", bevel_mesh::plan(file)));
    plan.extend(bevel_stability::plan(file).map(|decision| ("stability", decision)));
    plan
}

/// The word of a hand.
pub fn hand_name(hand: Hand) -> &'static str {
    match hand {
        Hand::Right => "right",
        Hand::Left => "left",
    }
}
