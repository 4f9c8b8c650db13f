//! Unloaded contact of a bevel pair: document and tables of contact, ease-off and V–H check.

use serde_json::{Value, json};

use super::gear::ARCSEC;
use super::table::{Table, or_dash};
use crate::gear::contact::ease_off::EaseOffTerms;
use crate::plan::gear::bevel_backlash::LeastBacklash;
use crate::plan::gear::bevel_contact::{BevelContact, END_OF_PITCHES, VH_POSITIONS, edge_name};
use crate::plan::gear_limits::MEMBERS;

pub(super) fn contact_json(contact: &BevelContact, side: &str) -> Value {
    let points: Vec<Value> = (contact.points.iter())
        .map(|p| {
            let turn = contact.pair.pose(0, p.contact.pinion_angle).inverse();
            json!({
                "pinion_angle_rad": p.pinion_angle,
                "gear_angle_rad": p.gear_angle,
                "te_arcsec": ARCSEC * p.te,
                "contact_pinion_m": p.in_pinion.array(),
                "ellipse_semi_axes_m": p.ellipse.map(|e| e.semi_axes),
                "ellipse_direction": p.ellipse.map(|e| turn.rotate(e.direction).array()),
                "pair": p.pair,
                "edge": p.contact.edge.as_ref().map(edge_name),
            })
        })
        .collect();
    let reference = &contact.path.reference;
    let shares = |k: usize| {
        contact.reference_position[k]
            .map(|[face, height]| json!({ "face": face, "height": height }))
    };
    let pattern = |k: usize| {
        contact.pattern[k].map(|[face, height]| json!({ "face": face, "height": height }))
    };
    json!({
        "side": side,
        "points": points,
        "peak_to_peak_arcsec": contact.peak_to_peak.map(|te| ARCSEC * te),
        "contact_ratio": contact.contact_ratio,
        "stopped_by": contact.ends.iter().map(|(angle, why)| json!({ "pinion_angle_rad": angle, "by": why })).collect::<Vec<_>>(),
        "reference": {
            "pinion_angle_rad": reference.pinion_angle,
            "gear_angle_rad": reference.gear_angle(),
            "ratio": reference.ratio(),
            "pinion": shares(0),
            "gear": shares(1),
            "ellipse_semi_axes_m": contact.ellipse.map(|e| e.semi_axes),
            "relative_curvatures_per_m": contact.ellipse.map(|e| e.relative_curvatures),
            "ratio_change_per_rad": contact.local.map(|l| l.ratio_change),
            "path_direction_deg": contact.local.map(|l| l.path_direction.to_degrees()),
            "pinion_turn": contact.forces.pinion_turn,
            "force_n_per_nm": { "pinion": force(contact, 0), "gear": force(contact, 1) },
        },
        "pattern": { "pinion": pattern(0), "gear": pattern(1) },
    })
}

pub(super) fn backlash_json(backlash: &LeastBacklash) -> Value {
    json!({
        "gear_angle_arcsec": ARCSEC * backlash.angle,
        "normal_mm": 1e3 * backlash.normal,
    })
}

/// Tangential, radial and axial force on a member for 1 N·m at the pinion, N.
fn force(contact: &BevelContact, member: usize) -> [f64; 3] {
    let forces = &contact.forces;
    forces.directions[member].map(|x| x / forces.levers[0])
}

pub(super) fn ease_off_json(contact: &BevelContact) -> Value {
    let (grid, terms) = &contact.ease_off;
    let rows: Vec<Vec<Option<f64>>> = (grid.gaps.chunks(grid.columns.max(1)))
        .map(|row| row.iter().map(|gap| gap.map(|g| 1e6 * g)).collect())
        .collect();
    let terms = terms.as_ref().map(|terms| {
        let rows = ease_off_rows(terms);
        rows.into_iter()
            .map(|(_, key, value)| (format!("{key}_um"), json!(1e6 * value)))
            .collect::<serde_json::Map<String, Value>>()
    });
    json!({ "grid_um": rows, "terms": terms })
}

/// Terms of an ease-off: name, key, value.
fn ease_off_rows(terms: &EaseOffTerms) -> [(&'static str, &'static str, f64); 7] {
    [
        ("at the middle", "constant", terms.constant),
        ("spiral angle (F)", "spiral_angle", terms.spiral_angle),
        ("pressure angle (H)", "pressure_angle", terms.pressure_angle),
        (
            "lengthwise crowning (F²)",
            "lengthwise_crowning",
            terms.lengthwise_crowning,
        ),
        (
            "profile crowning (H²)",
            "profile_crowning",
            terms.profile_crowning,
        ),
        ("twist (F H)", "twist", terms.twist),
        ("rest, rms", "rest", terms.residual),
    ]
}

pub(super) fn ease_off_table(terms: &EaseOffTerms) -> Table<'static> {
    let mut table = Table::named("ease-off of the pinion|[µm]");
    for (name, _, value) in ease_off_rows(terms) {
        table.row([name.to_string(), format!("{:.3}", 1e6 * value)]);
    }
    table
}

pub(super) fn contact_table(
    contact: &BevelContact,
    backlash: Option<&LeastBacklash>,
    side: &str,
) -> Table<'static> {
    let mut table = Table::texts("unloaded contact|value|unit").words(&[]);
    let mut row = |name: &str, value: String, unit: &str| {
        table.row([name.to_string(), value, unit.to_string()]);
    };
    row("flanks", side.to_string(), "");
    let reference = &contact.path.reference;
    row(
        "transmission error, peak to peak",
        or_dash(contact.peak_to_peak, |te| format!("{:.3}", ARCSEC * te)),
        "arcsec",
    );
    let is_cut = contact.ends.iter().any(|(_, why)| why == END_OF_PITCHES);
    row(
        match is_cut {
            true => "contact ratio on the flanks, at least",
            false => "contact ratio on the flanks",
        },
        format!("{:.4}", contact.contact_ratio),
        "",
    );
    row(
        "reference: pinion angle",
        format!("{:.5}", reference.pinion_angle.to_degrees()),
        "deg",
    );
    row(
        "reference: gear angle",
        format!("{:.5}", reference.gear_angle().to_degrees()),
        "deg",
    );
    for (name, shares) in MEMBERS.iter().zip(contact.reference_position) {
        let place = or_dash(shares, |[face, height]| {
            format!("{:.1}, {:.1}", 100.0 * face, 100.0 * height)
        });
        row(
            &format!("reference: face, height of the {name}"),
            place,
            "%",
        );
    }
    let axes = or_dash(contact.ellipse, |e| {
        format!("{:.3} × {:.3}", 1e3 * e.semi_axes[0], 1e3 * e.semi_axes[1])
    });
    row("reference: semi-axes of the ellipse", axes, "mm");
    row(
        "direction of the path η on the gear",
        or_dash(contact.local, |l| {
            format!("{:.2}", l.path_direction.to_degrees())
        }),
        "deg",
    );
    row(
        "change of ratio m′",
        or_dash(contact.local, |l| format!("{:.6}", l.ratio_change)),
        "1/rad",
    );
    for (k, name) in MEMBERS.iter().enumerate() {
        let [tangential, radial, axial] = force(contact, k).map(|f| format!("{f:.3}"));
        let shown = format!("{tangential}, {radial}, {axial}");
        row(
            &format!("force on the {name}: tangential, radial, axial"),
            shown,
            "N for 1 N·m",
        );
    }
    for (name, pattern) in MEMBERS.iter().zip(contact.pattern) {
        let ends = or_dash(pattern, |[face, _]| {
            format!("{:.0} to {:.0}", 100.0 * face[0], 100.0 * face[1])
        });
        row(&format!("pattern on the {name}, of the face"), ends, "%");
    }
    if let Some(backlash) = backlash {
        row(
            "least backlash, at the gear",
            format!("{:.2}", ARCSEC * backlash.angle),
            "arcsec",
        );
        row(
            "least backlash normal to the flanks j_n",
            format!("{:.4}", 1e3 * backlash.normal),
            "mm",
        );
    }
    for ((angle, why), word) in contact.ends.iter().zip(["begins", "ends"]) {
        let angle = format!("{:.4}", angle.to_degrees());
        row(
            &format!("contact on the flanks {word} ({why})"),
            angle,
            "deg",
        );
    }
    table
}

pub(super) fn vh_json(contact: &BevelContact) -> Option<Value> {
    let shifts = contact.vh.as_ref()?.iter().map(|shift| {
        shift.map(|s| json!({
            "face": s.face, "offset_mm": 1e3 * s.offset, "pinion_axial_mm": 1e3 * s.pinion_axial,
        }))
    });
    Some(shifts.collect())
}

pub(super) fn vh_table(contact: &BevelContact) -> Table<'static> {
    let mut table = Table::named("V–H check: contact at|V (offset) [mm]|H (pinion axial) [mm]");
    for ((name, face), shift) in VH_POSITIONS.iter().zip(contact.vh.iter().flatten()) {
        let shown = |value: Option<f64>| or_dash(value, |x| format!("{:.4}", 1e3 * x));
        table.row([
            format!("{name}, {:.0} % of the gear's face", 100.0 * face),
            shown(shift.map(|s| s.offset)),
            shown(shift.map(|s| s.pinion_axial)),
        ]);
    }
    table
}
