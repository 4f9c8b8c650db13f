//! Quantities of a bevel pair: blanks, slots, virtual gears, teeth, theory, axodes.

use super::bevel_member::MemberResult;
use super::geometry::{GearQuantity, Quantities, QuantityUnit};
use super::{axodes, hypoid_theory};
use crate::gear::bevel::iso23509::BlankPair;
use crate::gear::bevel::slots::Slots;
use crate::gear::bevel::virtual_gears::VirtualGears;
use crate::scene::bevel_file::{BevelFile, BevelMember};

/// Share of the face width that carries, by which the overlap ratio is counted: ISO 10300-1:2023, 6.4.
const EFFECTIVE_FACE: f64 = 0.85;

/// The quantities that the file determines, with the backlash of the design.
pub(super) fn quantities(
    file: &BevelFile,
    members: &[MemberResult; 2],
    backlash: Option<f64>,
) -> Vec<GearQuantity> {
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
    let [addenda, dedenda] = match &file.design {
        Some(design) => [design.addenda, design.dedenda],
        None => [0, 1].map(|i| of(&|m| m.blank.mean_depths()[i])),
    };
    all.each("mean addendum", "h_am", Millimetre, addenda);
    all.each("mean dedendum", "h_fm", Millimetre, dedenda);
    let whole = [0, 1].map(|k| addenda[k] + dedenda[k]);
    all.each("mean whole depth", "h_m", Millimetre, whole);
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
        all.pair("clearance", "c", Millimetre, design.clearance);
        all.each(
            "design mean normal thickness",
            "s_mn",
            Millimetre,
            design.thicknesses,
        );
        ends(design, &mut all);
        let teeth = file.members.each_ref().map(|m| m.teeth);
        contact_ratios(design, teeth, &mut all);
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
    if let Some(backlash) = backlash {
        all.pair("mean normal backlash", "j_mn", Millimetre, backlash);
    }
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

/// Spiral angles, slots and top lands at toe and heel; slots of face-milled pairs.
fn ends(design: &BlankPair, all: &mut Quantities) {
    use QuantityUnit::{Degree, Millimetre};
    let at = |end: usize| design.end_spiral_angles.map(|angles| angles[end]);
    all.each("outer spiral angle", "β_e", Degree, at(0));
    all.each("inner spiral angle", "β_i", Degree, at(1));
    if design.method.is_face_hobbed() {
        return;
    }
    let slots = Slots::of(design);
    let three = |of: &[[f64; 3]; 2], k: usize| [of[0][k], of[1][k]];
    let mut along = |names: [&'static str; 3], symbols: [&'static str; 3], of: &[[f64; 3]; 2]| {
        for k in 0..3 {
            all.each(names[k], symbols[k], Millimetre, three(of, k));
        }
    };
    along(
        ["slot width, toe", "slot width, mean", "slot width, heel"],
        ["W_i", "W_m", "W_e"],
        &slots.widths,
    );
    along(
        ["top land, toe", "top land, mean", "top land, heel"],
        ["s_ai", "s_am", "s_ae"],
        &slots.top_lands,
    );
    all.each("blade point", "W_B", Millimetre, slots.blade_points);
    let radii = &slots.edge_radii;
    for (name, symbol, values) in [
        (
            "edge radius without interference",
            "r_a01",
            radii.without_interference.unwrap_or([f64::NAN; 2]),
        ),
        ("edge radius on the blade point", "r_a02", radii.carried),
        (
            "edge radius without mutilation",
            "r_a03",
            radii.without_mutilation,
        ),
        (
            "largest edge radius",
            "r_a0",
            radii.largest().unwrap_or([f64::NAN; 2]),
        ),
    ] {
        all.each(name, symbol, Millimetre, values);
    }
}

/// Contact ratios of the virtual cylindrical gears; of pairs without offset.
fn contact_ratios(design: &BlankPair, teeth: [u32; 2], all: &mut Quantities) {
    use QuantityUnit::One;
    let width = EFFECTIVE_FACE * design.blanks[1].face_width;
    if let Some(gears) = VirtualGears::of(design, teeth, width) {
        all.each("virtual number of teeth", "z_v", One, gears.teeth);
        let ratio = gears.transverse_contact_ratio;
        all.pair("transverse contact ratio", "ε_vα", One, ratio);
        all.pair("overlap ratio", "ε_vβ", One, gears.overlap_ratio);
    }
}
