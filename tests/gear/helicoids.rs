//! Helicoids, their disk tools, worm pairs and crossed pairs by closed forms.

use std::f64::consts::{FRAC_PI_2, PI};

use geardyn::internals::gear::helicoid::axial_profile::{AxialProfile, Helicoid};
use geardyn::internals::gear::helicoid::crossed_pair::{CrossedGear, CrossedPair};
use geardyn::internals::gear::helicoid::grinding_wheel::{GrindingWheel, ToolAxis};
use geardyn::internals::gear::helicoid::worm_pair::WormPair;
use geardyn::internals::gear::helicoid::worm_thread::{FlankType, WormThread};
use serde_json::Value;

use crate::cases::{case, number, numbers};
use crate::verification::within;

const ZK: FlankType = FlankType::Zk {
    wheel_radius: 100.0,
};

fn thread(flank: FlankType, module: f64, starts: u32, quotient: f64) -> WormThread {
    WormThread {
        flank,
        starts,
        module,
        diameter_quotient: quotient,
        pressure_angle: 20f64.to_radians(),
    }
}

fn rows(value: &Value) -> Vec<Vec<f64>> {
    value.as_array().unwrap().iter().map(numbers).collect()
}

/// Largest difference of a row from its computed values.
fn apart(computed: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(computed.len(), expected.len());
    let pairs = computed.iter().zip(expected);
    pairs.fold(0.0, |worst, (a, b)| f64::max(worst, (a - b).abs()))
}

/// Axial, transverse and normal sections of the flank types ZA, ZI, ZN, ZK, ZC of one worm.
/// Source: closed forms against extrema of the wheel's distance, data/reference/gear/c40_helicoid_types.json.
#[test]
fn ref_helicoid_types() {
    let case = case("c40_helicoid_types");
    let types = [
        ("ZA", FlankType::Za),
        ("ZI", FlankType::Zi),
        ("ZN", FlankType::ZnSpace),
        ("ZK", ZK),
        (
            "ZC",
            FlankType::Zc {
                wheel_radius: 100.0,
                arc_radius: 40.0,
            },
        ),
    ];
    for (name, flank) in types {
        let thread = thread(flank, 4.0, 2, 10.0);
        let helicoid = thread.helicoid().unwrap();
        let mut worst = 0f64;
        for row in rows(&case["expected"]["types"][name]) {
            let at = helicoid.at(row[0]).unwrap();
            let azimuth = helicoid.transverse_azimuth(row[0]).unwrap();
            let [x, s] = helicoid
                .normal_section(thread.lead_angle(), row[0])
                .unwrap();
            let computed = [at.height, at.slope, azimuth.to_degrees(), x, s];
            worst = worst.max(apart(&computed, &row[1..]));
            let step = 1e-4;
            let slope = |radius: f64| helicoid.at(radius).unwrap().slope;
            let difference = (slope(row[0] + step) - slope(row[0] - step)) / (2.0 * step);
            assert!(
                (difference - at.curvature).abs() < 1e-7,
                "{name} {}",
                row[0]
            );
        }
        within(&format!("{name}: sections, mm and deg"), worst, 1e-9);
    }
}

/// Profiles of the disk tools of three flank types.
/// Source: closed forms against the least distance from the tool's axis, data/reference/gear/c42_disk_tool_from_helicoid.json.
#[test]
fn ref_disk_tools() {
    let case = case("c42_disk_tool_from_helicoid");
    for (name, flank) in [
        ("ZA", FlankType::Za),
        ("ZI", FlankType::Zi),
        ("ZN", FlankType::ZnSpace),
    ] {
        let thread = thread(flank, 4.0, 2, 10.0);
        let helicoid = thread.helicoid().unwrap();
        let axis = ToolAxis {
            distance: number(&case["expected"]["centre_distance_A"]),
            angle: number(&case["expected"]["axis_angle_deg"]).to_radians(),
        };
        let mut worst = 0f64;
        for row in rows(&case["expected"]["tools"][name]) {
            let at = axis.disk_point(&helicoid, row[0], 0.0).unwrap();
            let computed = [at.radius, at.height, at.azimuth.to_degrees(), at.slope];
            worst = worst.max(apart(&computed, &row[1..]));
        }
        within(&format!("{name}: tool profile, mm and deg"), worst, 1e-9);
        assert_eq!(axis.interference(&helicoid, [15.2, 24.0], 1e-6), None);
    }
}

/// A conical wheel grinds ZK, and the disk tool of ZK is that cone again.
#[test]
fn exact_tool_round_trip() {
    for (starts, quotient) in [(1, 8.0), (2, 10.0), (4, 12.0)] {
        let thread = thread(ZK, 4.0, starts, quotient);
        let helicoid = thread.helicoid().unwrap();
        let AxialProfile::Ground(wheel) = helicoid.profile else {
            panic!("ZK is ground");
        };
        let reference = thread.reference_radius();
        let mut worst = 0f64;
        for k in 0..9 {
            let radius = reference - 4.0 + f64::from(k);
            let at = wheel.axis.disk_point(&helicoid, radius, 0.0).unwrap();
            let cone = wheel.wheel_profile(at.radius).unwrap();
            worst = worst.max((at.height - cone.height - helicoid.shift).abs());
            worst = worst.max((at.slope - cone.slope).abs());
        }
        within(
            &format!("{starts} starts: cone of the wheel, mm"),
            worst,
            1e-11,
        );
    }
}

/// Flank of a ZK worm as its wheel wears, against the involute helicoid.
/// Source: closed forms against an extremum, data/reference/gear/c44_zk_wheel_wear.json.
#[test]
fn ref_wheel_wear() {
    let case = case("c44_zk_wheel_wear");
    let involute = thread(FlankType::Zi, 4.0, 2, 10.0);
    let normal = involute.lead_angle().cos() * involute.pressure_angle.cos();
    let involute = involute.helicoid().unwrap();
    let wheels = case["expected"]["wheel_radius_R0"].as_object().unwrap();
    let mut worst = [0f64; 2];
    for (radius, expected) in wheels {
        let wheel_radius = radius.parse().unwrap();
        let ground = thread(FlankType::Zk { wheel_radius }, 4.0, 2, 10.0);
        let ground = ground.helicoid().unwrap();
        for row in rows(&expected["rows"]) {
            let height = ground.at(row[0]).unwrap().height;
            let off = 1e3 * normal * (height - involute.at(row[0]).unwrap().height);
            worst[0] = worst[0].max((height - row[1]).abs());
            worst[1] = worst[1].max((off - row[2]).abs());
        }
    }
    within("axial height, mm", worst[0], 1e-9);
    within("deviation from the involute helicoid, µm", worst[1], 1e-6);
}

/// Transition surface of a wheel's edge, the axis angle without it, and the least radius that a wheel grinds.
/// Source: closed forms against extrema, data/reference/gear/c45_transition_and_first_limit.json.
#[test]
fn ref_transition_and_least_radius() {
    let case = case("c45_transition_and_first_limit");
    let expected = &case["expected"];
    let thread_2 = thread(ZK, 4.0, 2, 10.0);
    let AxialProfile::Ground(wheel) = thread_2.helicoid().unwrap().profile else {
        panic!("ZK is ground");
    };
    let (lead, radius) = (thread_2.lead(), number(&expected["edge_radius_Re"]));
    let edge = wheel.wheel_profile(radius).unwrap();
    let place = [radius, edge.height];
    let flank = wheel
        .axis
        .contact_angle(lead, place, [edge.slope, 1.0])
        .unwrap();
    let land = wheel.axis.contact_angle(lead, place, [1.0, 0.0]).unwrap();
    let mut worst = (edge.height - number(&expected["edge_height"])).abs();
    for (k, row) in rows(&expected["transition_axial_rho_z"]).iter().enumerate() {
        let beta = flank + (land - flank) * k as f64 / 4.0;
        worst = worst.max(apart(&wheel.axis.helix(lead, place, beta), row));
    }
    within("transition surface, mm", worst, 1e-9);
    let free = wheel.axis.angle_without_transition(lead, place).unwrap();
    let wanted = number(&expected["setting_without_transition_deg"]);
    within("axis angle, deg", (free.to_degrees() - wanted).abs(), 1e-9);
    let mut worst = 0f64;
    for row in expected["first_limit"].as_array().unwrap() {
        let steep = thread(ZK, 4.0, 6, 8.0);
        let radius = number(&row["R0"]);
        let axis = ToolAxis {
            distance: radius + steep.reference_radius(),
            angle: steep.lead_angle(),
        };
        let place = [radius, number(&row["half_width"])];
        let wheel = GrindingWheel::new(axis, place, steep.pressure_angle, None);
        let limit = wheel
            .least_distance(steep.lead(), [radius, radius + 10.0])
            .unwrap();
        let names = ["limit_tool_radius", "limit_worm_radius"];
        worst = worst.max(apart(&limit, &names.map(|name| number(&row[name]))));
    }
    within("least radius, mm", worst, 1e-9);
}

/// A tool whose profile turns back cuts into the flank; the depth is known to a micrometre.
/// Source: data/reference/gear/c45_transition_and_first_limit.json; depth 0.008 mm at the tip.
#[test]
fn ref_interference_of_a_tool() {
    let steep = thread(FlankType::Za, 4.0, 6, 8.0);
    let helicoid = steep.helicoid().unwrap();
    let at = |radius: f64| ToolAxis {
        distance: radius + steep.reference_radius(),
        angle: steep.lead_angle(),
    };
    let cut = at(100.0)
        .interference(&helicoid, [13.0, 20.0], 1e-5)
        .unwrap();
    within("depth, mm", (cut.depth - 0.008).abs(), 5e-4);
    assert_eq!(cut.distance, 20.0);
    assert_eq!(at(40.0).interference(&helicoid, [13.0, 20.0], 1e-5), None);
}

fn worm_pair(flank: FlankType, alpha: f64, ratio: f64, centre_distance: f64) -> WormPair {
    let thread = WormThread {
        pressure_angle: alpha.to_radians(),
        ..thread(flank, 5.0, 2, 10.0)
    };
    WormPair {
        worm: thread.helicoid().unwrap().through(25.0, 0.0).unwrap(),
        ratio,
        centre_distance,
    }
}

/// Contact points, curvature, angle to sliding, speeds, second limits and lines of contact of two worm pairs.
/// Source: closed forms against extrema of azimuth, data/reference/gear/c52_worm_pair_za.json and c53_worm_pair_zi.json.
#[test]
fn ref_worm_contact() {
    for (name, flank) in [
        ("c52_worm_pair_za", FlankType::Za),
        ("c53_worm_pair_zi", FlankType::Zi),
    ] {
        let case = case(name);
        let expected = &case["expected"];
        let pair = worm_pair(flank, 20.0, 0.05, number(&expected["a"]));
        let mut worst = 0f64;
        for row in rows(&expected["contact"]) {
            let c = pair.contact(row[0], row[1].to_radians()).unwrap();
            let in_wheel = c.in_wheel();
            let computed = [
                c.from_wheel.z,
                c.worm_turn.to_degrees(),
                in_wheel.x,
                in_wheel.y,
                in_wheel.z,
                c.second_limit,
                c.undercut,
                c.relative_curvature(),
                c.lubrication_angle().to_degrees(),
                c.sliding,
                c.line_speeds()[0],
                c.line_speeds()[1],
                c.sliding_across(),
            ];
            worst = worst.max(apart(&computed, &row[2..]));
        }
        within(&format!("{name}: contact, mm, deg, 1/mm"), worst, 1e-10);
        let mut worst = 0f64;
        for row in rows(&expected["limit2"]) {
            let azimuth = pair.second_limit(row[0]).unwrap();
            worst = worst.max((azimuth.to_degrees() - row[1]).abs());
        }
        within(&format!("{name}: second limit, deg"), worst, 1e-8);
        let mut worst = 0f64;
        for row in rows(&expected["lines"]) {
            let azimuths = pair.line(row[0].to_radians(), row[1]);
            let off = azimuths.iter().map(|a| (a.to_degrees() - row[2]).abs());
            worst = worst.max(off.fold(f64::INFINITY, f64::min));
        }
        within(&format!("{name}: lines of contact, deg"), worst, 1e-8);
    }
}

/// Limit of the first kind of a wheel with few teeth.
/// Source: area of the wheel's patch vanishes, data/reference/gear/c55_worm_first_limit.json.
#[test]
fn ref_worm_undercut() {
    let case = case("c55_worm_first_limit");
    for (name, flank) in [("ZA", FlankType::Za), ("ZI", FlankType::Zi)] {
        let pair = worm_pair(flank, 15.0, 0.1, 75.0);
        let mut worst = 0f64;
        for row in rows(&case["expected"][name]["rows"]) {
            let azimuth = row[0].to_radians();
            let radius = pair.undercut(azimuth, [26.0, 40.0]).unwrap();
            let contact = pair.contact(radius, azimuth).unwrap();
            let place = contact.from_wheel;
            let computed = [radius, place.z, contact.wheel_radius(), place.y];
            worst = worst.max(apart(&computed, &row[1..]));
        }
        within(&format!("{name}: limit curve, mm"), worst, 1e-9);
    }
}

fn crossed_gear(teeth: u32, helix_deg: f64, shift: f64) -> CrossedGear {
    let (helix, alpha) = (helix_deg.to_radians(), 20f64.to_radians());
    let radius = 1.5 * f64::from(teeth) / helix.cos();
    let transverse = (alpha.tan() / helix.cos()).atan();
    let thickness = 3.0 / helix.cos() * (FRAC_PI_2 + 2.0 * shift * alpha.tan());
    CrossedGear {
        teeth,
        helix,
        radius,
        base_radius: radius * transverse.cos(),
        tip_radius: radius + 3.0,
        base_half_angle: thickness / (2.0 * radius) + transverse.tan() - transverse,
    }
}

/// Path of contact, ellipse, contact ratio of crossed gears, also displaced.
/// Source: extremum of the azimuth, data/reference/gear/c49_crossed_helical.json.
#[test]
fn ref_crossed_path() {
    let case = case("c49_crossed_helical");
    let mut worst = [0f64; 3];
    for variant in case["expected"]["variants"].as_array().unwrap() {
        let pair = CrossedPair {
            gears: [crossed_gear(15, 50.0, 0.0), crossed_gear(30, 40.0, 0.0)],
            pressure_angle: 20f64.to_radians(),
            centre_distance: number(&variant["centre_distance"]),
            shaft_angle: number(&variant["axis_angle_deg"]).to_radians(),
        };
        let path = pair.path().unwrap();
        let contact = pair.contact(&path, pair.pitch_place(&path)).unwrap();
        let place = numbers(&variant["point_of_line_nearest_pitch_point"]);
        for (computed, expected) in [
            (path.tangent_points[0].array(), &variant["T1"]),
            (path.tangent_points[1].array(), &variant["T2"]),
        ] {
            worst[0] = worst[0].max(apart(&computed, &numbers(expected)));
        }
        worst[0] = worst[0].max(apart(&contact.point.array(), &place));
        let named = |name: &str| number(&variant[name]);
        let lengths = [
            (path.length, named("length_T1T2")),
            (contact.radii[0], named("R1")),
            (contact.radii[1], named("R2")),
            (path.advance, named("advance_mm_per_rad_of_gear1")),
            (path.ends[1] - path.ends[0], named("path_length")),
            (CrossedPair::contact_ratio(&path), named("contact_ratio")),
        ];
        let off = lengths.iter().map(|(a, b)| (a - b).abs());
        worst[1] = off.fold(worst[1], f64::max);
        let curvatures = numbers(&variant["relative_curvatures"]);
        worst[2] = worst[2].max(apart(&contact.curvatures, &curvatures));
        let ellipse = numbers(&variant["ellipse_semi_axes_mm_delta_6p35um"]);
        worst[2] = worst[2].max(apart(&contact.ellipse(6.35e-3), &ellipse));
    }
    within("points, mm", worst[0], 1e-9);
    within("path of contact, mm", worst[1], 1e-9);
    within("curvatures, 1/mm, and ellipses, mm", worst[2], 1e-10);
}

/// Normal backlash of crossed gears with profile shift, and the centre distance without it.
/// Source: extremum of the gap, data/reference/gear/c60_crossed_shifted_handbook.json.
#[test]
fn ref_crossed_backlash() {
    let case = case("c60_crossed_shifted_handbook");
    let pair = |row: &[f64]| CrossedPair {
        gears: [
            crossed_gear(15, 20.0, row[2]),
            crossed_gear(24, 30.0, row[3]),
        ],
        pressure_angle: 20f64.to_radians(),
        centre_distance: row[0],
        shaft_angle: row[1].to_radians(),
    };
    let mut worst = 0f64;
    for row in rows(&case["expected"]["backlash"]) {
        worst = worst.max((pair(&row).normal_backlash().unwrap() - row[4]).abs());
    }
    within("normal backlash, mm", worst, 1e-9);
    let mut worst = 0f64;
    for row in rows(&case["expected"]["exact_zero_backlash"]["rows"]) {
        let tight = pair(&[67.0, row[0], 0.4, 0.2])
            .tight_centre_distance()
            .unwrap();
        worst = worst.max((tight - row[1]).abs());
    }
    within("centre distance without backlash, mm", worst, 1e-9);
}

/// A path of contact exists between the stated shaft angles and nowhere else.
#[test]
fn law_crossed_pair_needs_a_common_normal() {
    let pair = |shaft_deg: f64| CrossedPair {
        gears: [crossed_gear(15, 20.0, 0.0), crossed_gear(24, 30.0, 0.0)],
        pressure_angle: 20f64.to_radians(),
        centre_distance: 66.0,
        shaft_angle: shaft_deg.to_radians(),
    };
    let [least, greatest] = pair(50.0).shaft_angles().map(f64::to_degrees);
    assert!(pair(least + 1e-6).path().is_some() && pair(least - 1e-6).path().is_none());
    assert!(pair(greatest - 1e-6).path().is_some() && pair(greatest + 1e-6).path().is_none());
}

/// Random ground threads: the disk tool of the thread is the cone that ground it.
#[test]
fn survives_random_threads() {
    let mut state = 7u64;
    let mut random = |low: f64, high: f64| {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        low + (high - low) * (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let (mut found, mut none) = (0, 0);
    for _ in 0..500 {
        let starts = random(1.0, 8.99) as u32;
        let quotient = random(6.0, 20.0);
        let wheel_radius = quotient * random(0.5, 6.0);
        let thread = WormThread {
            pressure_angle: random(12.0, 28.0).to_radians(),
            ..thread(FlankType::Zk { wheel_radius }, 1.0, starts, quotient)
        };
        let Some(helicoid) = thread.helicoid() else {
            none += 1;
            continue;
        };
        let AxialProfile::Ground(wheel) = helicoid.profile else {
            panic!("ZK is ground");
        };
        let radii: Vec<f64> = (0..24)
            .map(|k| thread.reference_radius() - 1.2 + 0.1 * f64::from(k))
            .filter(|radius| helicoid.at(*radius).is_some())
            .collect();
        let profile = wheel.axis.disk_profile(&helicoid, &radii);
        none += radii.len() - profile.len();
        found += profile.len();
        for at in profile {
            let cone = wheel.wheel_profile(at.radius).unwrap();
            let off = (at.height - cone.height - helicoid.shift).abs();
            assert!(off < 1e-9, "{thread:?} at {}: {off:.1e}", at.distance);
        }
    }
    assert!(
        none == 0 && found > 10_000,
        "{found} found, {none} not reached"
    );
}

/// A helicoid through a point keeps its slope; the involute ends at its base cylinder.
#[test]
fn law_flanks_end_at_the_base_cylinder() {
    let thread = thread(FlankType::Zi, 4.0, 2, 10.0);
    let helicoid: Helicoid = thread.helicoid().unwrap();
    assert!(helicoid.at(thread.base_radius() * (1.0 - 1e-12)).is_none());
    let moved = helicoid.through(20.0, 5.0).unwrap();
    assert_eq!(
        moved.at(22.0).unwrap().slope,
        helicoid.at(22.0).unwrap().slope
    );
    assert!((moved.at(20.0).unwrap().height - 5.0).abs() < 1e-15 * PI);
}
