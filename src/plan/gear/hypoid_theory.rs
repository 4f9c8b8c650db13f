//! Theory of a bevel or hypoid pair at its pitch point: pitch plane, limits, screw axis, contact of the flanks, surface of action.

use super::geometry::{Quantities, QuantityUnit};
use crate::gear::bevel::cone_gap::pitch_cone_gap;
use crate::gear::bevel::flank_theory::{ContactSide, FlankTheory, KnownFlank};
use crate::gear::bevel::pitch_point::PitchPoint;
use crate::gear::bevel::structure_elements::StructureElements;
use crate::gear::kernel::crossed_axes::CrossedAxes;
use crate::gear::kernel::vector::Vector;
use crate::scene::bevel_file::BevelFile;

/// Both radii of the mean point agree with one point of space, and the pitch cones touch, within this share: blanks are given to a few digits.
const SAME_POINT: f64 = 0.01;

/// Structure elements at the mean point by member and flank, where the file describes the flank.
pub type FlankElements = [[Option<StructureElements>; 2]; 2];

/// Theory of a pair.
#[derive(Debug, Clone, Copy)]
pub struct PairTheory {
    /// The pitch point in the middle of the face.
    pub pitch_point: PitchPoint,
    /// Drive and coast flank, where they are described.
    pub flanks: [Option<FlankTheory>; 2],
}

/// The axes of a pair with its ratio.
pub fn axes(file: &BevelFile) -> CrossedAxes {
    let [z1, z2] = file.members.each_ref().map(|m| f64::from(m.teeth));
    CrossedAxes {
        offset: file.nominal.offset,
        shaft_angle: file.nominal.shaft_angle,
        ratio: -z1 / z2,
    }
}

/// The theory; none where the pitch cones do not touch, or the mean points of both blanks are not one point of space.
pub fn theory(file: &BevelFile, elements: &FlankElements) -> Option<PairTheory> {
    let pitch_point = pitch_point(file, elements)?;
    let flank = |side| known_flank(file, elements, side)?.contact(&pitch_point);
    Some(PairTheory {
        pitch_point,
        flanks: [ContactSide::Drive, ContactSide::Coast].map(flank),
    })
}

/// The gap between the pitch cones at the mean point of the pinion, m, below zero where they overlap; none where they touch.
pub(super) fn gap_of_pitch_cones(file: &BevelFile) -> Option<f64> {
    let [pinion, gear] = file.members.each_ref().map(|m| &m.blank);
    let gap = pitch_cone_gap(&axes(file), [pinion, gear]);
    let [_, radius] = pinion.mean_point();
    (gap.abs() > SAME_POINT * radius).then_some(gap)
}

fn pitch_point(file: &BevelFile, elements: &FlankElements) -> Option<PitchPoint> {
    let axes = axes(file);
    let [first, second] = file.members.each_ref().map(|m| m.blank);
    if gap_of_pitch_cones(file).is_some() {
        return None;
    }
    if axes.offset == 0.0 {
        let of_design = file.design.map(|design| design.spiral_angles[0]);
        let of_flank = || {
            let mut flanks = elements[0].iter().flatten();
            flanks.next().map(|e| e.spiral_angle.abs())
        };
        let spiral_angle = of_design.or_else(of_flank)?;
        return PitchPoint::of_bevel(&axes, first.mean_cone_distance, spiral_angle);
    }
    let ([z1, r1], [z2, r2]) = (first.mean_point(), second.mean_point());
    let (sin, cos) = axes.shaft_angle.sin_cos();
    let y = (z2 - z1 * cos) / sin;
    let across = (r2 * r2 - (y * cos - z1 * sin).powi(2)).sqrt();
    let x = axes.offset - across.copysign(axes.offset);
    let is_one_point = (f64::hypot(x, y) / r1 - 1.0).abs() < SAME_POINT;
    is_one_point.then(|| PitchPoint::at(&axes, Vector::new(x, y, z1)))?
}

/// The gear's flank: by the cutter of the design, or as its settings cut it at the mean point.
fn known_flank(
    file: &BevelFile,
    elements: &FlankElements,
    side: ContactSide,
) -> Option<KnownFlank> {
    let [pinion, gear] = side.flanks();
    match (elements[1][gear], &file.design) {
        (Some(elements), _) => Some(KnownFlank {
            flank: side,
            pressure_angle: elements.pressure_angle.abs(),
            curvature: elements.normal_curvature,
            // The pitch point is that of a right-hand pinion.
            torsion: file.hand.sign() * elements.torsion,
        }),
        (None, Some(design)) if !design.method.is_face_hobbed() => {
            let pressure_angle = design.pressure_angles[pinion];
            Some(KnownFlank::of_cutter(
                side,
                pressure_angle,
                design.cutter_radius,
            ))
        }
        _ => None,
    }
}

/// Lists the theory.
pub(super) fn quantities(theory: &PairTheory, all: &mut Quantities) {
    use QuantityUnit::{Degree, Millimetre, PerMillimetre};
    let at = &theory.pitch_point;
    all.each(
        "spiral angle at the pitch point",
        "β",
        Degree,
        at.spiral_angles,
    );
    all.pair(
        "offset angle in the pitch plane",
        "ζ_mp",
        Degree,
        at.offset_angle(),
    );
    if let Some(limit) = at.limit() {
        all.pair(
            "limit pressure angle",
            "α_lim",
            Degree,
            limit.pressure_angle,
        );
        all.pair(
            "limit curvature of the tooth line",
            "1/ρ_lim",
            PerMillimetre,
            limit.curvature,
        );
    }
    all.pair(
        "sliding at the pitch point (mm a radian of the pinion)",
        "v",
        Millimetre,
        at.sliding,
    );
    if let Some(screw) = at.screw_axis() {
        all.pair("screw axis to pitch plane", "ε", Degree, screw.angle);
        let [along, across] = screw.pierces;
        all.pair(
            "screw axis pierces the pitch plane, along the tooth",
            "s_τ",
            Millimetre,
            along,
        );
        all.pair(
            "screw axis pierces the pitch plane, across the tooth",
            "s_n",
            Millimetre,
            across,
        );
    }
    for (names, flank) in FLANK_NAMES.iter().zip(theory.flanks) {
        let Some(flank) = flank else { continue };
        let values = [
            flank.contact_line,
            flank.action_angles[0],
            flank.action_angles[1],
            flank.induced_curvature(0.0),
            flank.induced_curvature(std::f64::consts::FRAC_PI_2),
            flank.induced_torsion(0.0),
        ];
        for (k, (name, value)) in names.iter().zip(values).enumerate() {
            let unit = if k < 3 { Degree } else { PerMillimetre };
            all.pair(name, FLANK_SYMBOLS[k], unit, value);
        }
    }
}

const FLANK_SYMBOLS: [&str; 6] = ["ν", "λ_p", "λ_n", "Δκ_τ", "Δκ_n", "Δτ_g"];

/// Names of what the theory gives for the drive and the coast flank.
const FLANK_NAMES: [[&str; 6]; 2] = [
    [
        "contact line to tooth line, drive",
        "surface of action in the pitch plane to tooth line, drive",
        "surface of action in the normal section to pitch plane, drive",
        "induced curvature along the tooth, drive",
        "induced curvature in the normal section, drive",
        "induced geodesic torsion, drive",
    ],
    [
        "contact line to tooth line, coast",
        "surface of action in the pitch plane to tooth line, coast",
        "surface of action in the normal section to pitch plane, coast",
        "induced curvature along the tooth, coast",
        "induced curvature in the normal section, coast",
        "induced geodesic torsion, coast",
    ],
];
