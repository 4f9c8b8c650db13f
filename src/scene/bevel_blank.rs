//! `blank` of a bevel gear file: cones, or the inputs of ISO 23509; refusals of blanks without cones or teeth.

use std::f64::consts::{FRAC_PI_2, PI};

use super::assembly::SHIFT;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::error_collector::ValueRange;
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::SourceSpan;
use crate::base::table_reader::TableReader;
use crate::gear::bevel::blank::{Blank, EndCone};
use crate::gear::bevel::blank_fault::{BlankFault, End, ToothFault};
use crate::gear::bevel::face_hob::ConeRule;
use crate::gear::bevel::iso23509::{BlankDesign, PitchCones};
use crate::gear::contact::pair::Assembly;
use crate::gear::cylindrical::member::MEMBERS;

/// Most teeth of a bevel gear.
pub(super) const MAX_BEVEL_TEETH: u32 = 1000;
/// Design pressure angle by default, rad.
pub(super) const DESIGN_PRESSURE_ANGLE: f64 = PI / 9.0;
pub(super) const PRESSURE_ANGLE: ValueRange =
    ValueRange::Open(0.0, PI / 4.0, "above 0° and below 45°");
const CONE_ANGLE: ValueRange = ValueRange::Open(0.0, PI, "above 0° and below 180°");
const LENGTH: ValueRange = ValueRange::Open(1e-6, 1e3, "above 1 µm and below 1 km");

/// `blank` as written.
pub(super) enum BlankTable {
    /// Cones of the blank.
    Cones(Blank),
    /// Inputs of ISO 23509.
    Standard(StandardTable),
}

/// The table `blank`.
pub(super) fn blank(f: &mut TableReader) -> Option<BlankTable> {
    match f.has("standard") {
        true => standard(f).map(BlankTable::Standard),
        false => cones(f).map(BlankTable::Cones),
    }
}

/// Inputs of ISO 23509 that the blank of the gear states.
pub(super) struct StandardTable {
    method: u32,
    spiral_angle: Option<f64>,
    pinion_spiral_angle: Option<f64>,
    /// Blade groups of a cutter that hobs.
    blade_groups: Option<u32>,
    /// With offset and shaft angle of the pair and its tooth numbers left open.
    rest: BlankDesign,
}

impl StandardTable {
    /// The design with tooth numbers and axes of the pair.
    pub(super) fn design(&self, teeth: [u32; 2], nominal: &Assembly) -> Result<BlankDesign, Error> {
        let conflict =
            |message: &str, hint: &str| Err(Error::new(Code::Conflict, message).with_hint(hint));
        let method = match (self.method, self.spiral_angle, self.pinion_spiral_angle) {
            (0, Some(spiral_angle), None) if nominal.offset == 0.0 => {
                PitchCones::Bevel { spiral_angle }
            }
            (0, Some(_), None) => {
                return conflict("method 0 is for pairs without offset", "take method = 1");
            }
            (1, None, Some(pinion_spiral_angle)) if nominal.offset != 0.0 => PitchCones::Hypoid {
                offset: nominal.offset,
                pinion_spiral_angle,
            },
            (1, None, Some(_)) => {
                return conflict(
                    "method 1 needs an offset",
                    "give `offset` of the pair, or use method = 0",
                );
            }
            (0, ..) => {
                return conflict(
                    "method 0 needs `spiral_angle`",
                    "give the mean spiral angle of both gears in `blank`",
                );
            }
            (1, ..) => {
                return conflict(
                    "method 1 needs `pinion_spiral_angle`",
                    "give the target spiral angle of the pinion in `blank`",
                );
            }
            (method, Some(wheel_spiral_angle), None) if nominal.offset != 0.0 => {
                let Some(blade_groups) = self.blade_groups else {
                    return conflict(
                        "methods 2 and 3 are for face hobbing with blade groups",
                        "give `blade_groups`",
                    );
                };
                PitchCones::FaceHobbed {
                    offset: nominal.offset,
                    wheel_spiral_angle,
                    blade_groups,
                    rule: match method {
                        2 => ConeRule::ApexLine,
                        _ => ConeRule::CrownGears,
                    },
                }
            }
            _ => {
                return conflict(
                    "methods 2 and 3 need `spiral_angle` of the gear and an offset",
                    "give both, or use method = 0 for a pair without offset",
                );
            }
        };
        if self.blade_groups.is_some() && self.method < 2 {
            return conflict(
                "`blade_groups` applies to methods 2 and 3 only",
                "omit it: methods 0 and 1 are for face-milled pairs",
            );
        }
        Ok(BlankDesign {
            method,
            teeth,
            shaft_angle: nominal.shaft_angle,
            ..self.rest
        })
    }
}

fn standard(f: &mut TableReader) -> Option<StandardTable> {
    const SPIRAL: ValueRange = ValueRange::HalfOpen(0.0, 1.3, "at least 0° and below 74°");
    const DEPTH_ANGLE: ValueRange = ValueRange::HalfOpen(0.0, 0.5, "at least 0° and below 28°");
    const FACTOR: ValueRange = ValueRange::HalfOpen(0.0, 10.0, "at least 0 and below 10");
    f.choice("standard", &[("ISO 23509", ())]);
    let method = f.optional_count("method", 0, 3);
    f.require("method");
    let length = |f: &mut TableReader, key| {
        let value = f.optional_quantity(key, QuantityKind::Length, LENGTH);
        f.require(key);
        value
    };
    let outer_pitch_diameter = length(f, "outer_pitch_diameter");
    let face_width = length(f, "face_width");
    let cutter_radius = length(f, "cutter_radius");
    let angle =
        |f: &mut TableReader, key, range| f.optional_quantity(key, QuantityKind::Angle, range);
    let spiral_angle = angle(f, "spiral_angle", SPIRAL);
    let pinion_spiral_angle = angle(f, "pinion_spiral_angle", SPIRAL);
    let blade_groups = f.optional_count("blade_groups", 1, MAX_BEVEL_TEETH);
    let pressure = f.optional_pair("pressure_angle", QuantityKind::Angle, PRESSURE_ANGLE);
    let depth = |f: &mut TableReader, key| {
        let value = angle(f, key, DEPTH_ANGLE);
        f.require(key);
        value
    };
    let depth_angles = [depth(f, "addendum_angle"), depth(f, "dedendum_angle")];
    let factor = |f: &mut TableReader, key| f.optional_number(key, FACTOR);
    let addendum_factor = factor(f, "addendum_factor");
    f.require("addendum_factor");
    let [
        limit_influence,
        depth_factor,
        clearance_factor,
        thickness_factor,
    ] = [
        "limit_influence",
        "depth_factor",
        "clearance_factor",
        "thickness_factor",
    ]
    .map(|key| factor(f, key));
    let backlash = f.optional_quantity("backlash", QuantityKind::Length, ValueRange::NotNegative);
    Some(StandardTable {
        method: method?,
        spiral_angle,
        pinion_spiral_angle,
        blade_groups,
        rest: BlankDesign {
            method: PitchCones::Bevel { spiral_angle: 0.0 },
            teeth: [2, 2],
            shaft_angle: FRAC_PI_2,
            outer_pitch_diameter: outer_pitch_diameter?,
            face_width: face_width?,
            cutter_radius: cutter_radius?,
            pressure_angles: pressure.unwrap_or([DESIGN_PRESSURE_ANGLE; 2]),
            limit_influence: limit_influence.unwrap_or(0.0),
            addendum_factor: addendum_factor?,
            depth_factor: depth_factor.unwrap_or(2.0),
            clearance_factor: clearance_factor.unwrap_or(0.125),
            thickness_factor: thickness_factor.unwrap_or(0.0),
            backlash: backlash.unwrap_or(0.0),
            depth_angles: [depth_angles[0]?, depth_angles[1]?],
        },
    })
}

fn cones(f: &mut TableReader) -> Option<Blank> {
    let angle = |f: &mut TableReader, key| {
        let value = f.optional_quantity(key, QuantityKind::Angle, CONE_ANGLE);
        f.require(key);
        value
    };
    let pitch_angle = angle(f, "pitch_angle");
    let face_angle = angle(f, "face_angle");
    let root_angle = angle(f, "root_angle");
    let length = |f: &mut TableReader, key| {
        let value = f.optional_quantity(key, QuantityKind::Length, LENGTH);
        f.require(key);
        value
    };
    let mean_cone_distance = length(f, "mean_cone_distance");
    let face_width = length(f, "face_width");
    let mut apex = |key| {
        f.optional_quantity(key, QuantityKind::Length, SHIFT)
            .unwrap_or(0.0)
    };
    let [pitch_apex, face_apex, root_apex] =
        ["pitch_apex", "face_apex", "root_apex"].map(&mut apex);
    let ends = f.choice(
        "ends",
        &[("pitch", EndCone::Pitch), ("root", EndCone::Root)],
    );
    Some(Blank {
        pitch_angle: pitch_angle?,
        face_angle: face_angle?,
        root_angle: root_angle?,
        mean_cone_distance: mean_cone_distance?,
        face_width: face_width?,
        outer_share: 0.5,
        pitch_apex,
        face_apex,
        root_apex,
        ends: ends.unwrap_or_default(),
    })
}

/// Cones that a file states and between which no tooth lies.
pub(super) fn no_tooth(fault: &ToothFault, span: &SourceSpan, member: usize) -> Error {
    let hint = match fault {
        ToothFault::BeyondApex { .. } => "take a larger mean_cone_distance or a smaller face_width",
        ToothFault::NoDepth { .. } => "check face_angle > root_angle, face_apex and root_apex",
        ToothFault::AtAxis { .. } => {
            "check root_angle, face_angle, their apexes, mean_cone_distance and face_width"
        }
    };
    Error::new(Code::OutOfRange, tooth_message(fault, MEMBERS[member]))
        .with_span(span)
        .with_hint(hint)
}

fn tooth_message(fault: &ToothFault, name: &str) -> String {
    let at = |end: &End| match end {
        End::Toe => "toe",
        End::Heel => "heel",
    };
    match fault {
        ToothFault::BeyondApex {
            inner_cone_distance,
        } => format!(
            "the face of the {name} reaches its pitch apex: the inner cone distance is {:.3} mm",
            1e3 * inner_cone_distance
        ),
        ToothFault::NoDepth { end, depth } => format!(
            "the teeth of the {name} have no depth at the {}: the face cone lies {:.3} mm below the root cone",
            at(end),
            -1e3 * depth
        ),
        ToothFault::AtAxis { end } => {
            format!("the teeth of the {name} reach its axis at the {}", at(end))
        }
    }
}

/// Data of ISO 23509 that give no blanks.
pub(super) fn no_blanks(design: &BlankDesign, fault: &BlankFault) -> Error {
    let radius = 1e3 * design.cutter_radius;
    let (message, hint) = match fault {
        BlankFault::NoPitchCones if design.method.is_face_hobbed() => (
            "no pitch cones fit the offset, the spiral angle and the cutter".into(),
            "take a smaller offset, another spiral_angle, cutter_radius or blade_groups",
        ),
        BlankFault::NoPitchCones => (
            "no pitch cones touch at this offset and spiral angle".into(),
            "take a smaller offset or a larger outer_pitch_diameter",
        ),
        BlankFault::LimitCurvature {
            reached: [least, most],
        } => {
            let (reached, hint) = match (design.cutter_radius * most < 1.0, *most > 0.0) {
                (true, true) => (
                    format!("the least is {:.3} mm", 1e3 / most),
                    "take a larger cutter_radius, another pinion_spiral_angle or another offset",
                ),
                (true, false) => (
                    "no limit radius is above zero".into(),
                    "take another pinion_spiral_angle or another offset",
                ),
                (false, _) => (
                    format!("the greatest is {:.3} mm", 1e3 / least),
                    "take a smaller cutter_radius, another pinion_spiral_angle or another offset",
                ),
            };
            let message = format!(
                "no pitch cones have a limit radius of curvature of {radius:.3} mm, the cutter radius: at this spiral angle and offset {reached}"
            );
            (message, hint)
        }
        BlankFault::NoFace { member } => (
            format!(
                "at this offset the face of the {} does not overlap that of its mate",
                MEMBERS[*member]
            ),
            "take a smaller offset or a smaller face_width",
        ),
        BlankFault::Tooth { member, fault } => (
            tooth_message(fault, MEMBERS[*member]),
            match fault {
                ToothFault::BeyondApex { .. } => {
                    "take a larger outer_pitch_diameter or a smaller face_width"
                }
                ToothFault::NoDepth { .. } => {
                    "take smaller addendum_angle, dedendum_angle and face_width, or a larger depth_factor"
                }
                ToothFault::AtAxis { .. } => {
                    "take a smaller addendum_angle, face_width or depth_factor, or more teeth of the pinion"
                }
            },
        ),
        BlankFault::ToothLine => (
            format!(
                "the tooth line of a cutter of {radius:.3} mm does not reach an end of the face"
            ),
            "take a larger cutter_radius, a smaller face_width or another spiral angle",
        ),
        BlankFault::NoThickness { member, thickness } => (
            format!(
                "the teeth of the {} have no thickness at the mean point: it is {:.3} mm",
                MEMBERS[*member],
                1e3 * thickness
            ),
            "take a thickness_factor nearer 0, an addendum_factor nearer 0.5 or a smaller backlash",
        ),
    };
    Error::new(Code::OutOfRange, message).with_hint(hint)
}
