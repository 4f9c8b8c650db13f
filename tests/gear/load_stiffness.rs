//! Tooth stiffness: ISO 6336-1 against a report, the energy method against closed forms and an independent script, Hertz contact.

use std::f64::consts::{PI, TAU};

use geardyn::internals::gear::cylindrical::basic_rack::BasicRack;
use geardyn::internals::gear::cylindrical::involute::InvoluteGear;
use geardyn::internals::gear::cylindrical::member::Member;
use geardyn::internals::gear::cylindrical::pair::Pair;
use geardyn::internals::gear::load::body::{Body, FootLoad};
use geardyn::internals::gear::load::hertz::{self, ContactModel, FlankContact};
use geardyn::internals::gear::load::iso6336::{IsoStiffness, Web};
use geardyn::internals::gear::load::material::Material;
use geardyn::internals::gear::load::tooth::ToothSection;
use serde_json::Value;

use crate::cases::{case, number};
use crate::verification::{printed, within};

/// A pair of a report, lengths there in mm.
fn reported_pair(inputs: &Value) -> Pair {
    let member = |i: usize| {
        let gear = InvoluteGear {
            teeth: inputs["z"][i].as_u64().unwrap() as u32,
            module: 1e-3 * number(&inputs["mn"]),
            pressure_angle: number(&inputs["alpha_n_deg"]).to_radians(),
            helix: number(&inputs["beta_deg"]).to_radians(),
            profile_shift: number(&inputs[["x1", "x2"][i]]),
            internal: false,
        };
        let rack = BasicRack {
            addendum: number(&inputs["haP"]),
            dedendum: number(&inputs["hfP"]),
            tip_radius: number(&inputs["rhofP"]),
            protuberance: 0.0,
        };
        let mut member = Member::new(gear, rack, 1e-3 * number(&inputs["b"]));
        member.tip_diameter = Some(1e-3 * number(&inputs["tip_diameter"][i]));
        member
    };
    Pair::new([member(0), member(1)], Some(1e-3 * number(&inputs["a"]))).unwrap()
}

/// c′, c_γα and c_γβ of two pairs of a 5 MW gearbox with webs.
/// Source: KISSsoft 03/2017A reports (ISO 6336:2006 method B) of the NREL 5 MW gearbox in gfsReboucas/Drivetrain, commit 4a88df3.
#[test]
fn ref_iso6336_stiffness() {
    for case in case("tooth_stiffness")["iso6336"].as_array().unwrap() {
        let (inputs, expected) = (&case["inputs"], &case["expected"]);
        let web = Web {
            thickness_ratio: number(&inputs["bs_over_b"]),
            rim_modules: number(&inputs["sr_over_mn"]),
        };
        let pair = reported_pair(inputs);
        let iso = IsoStiffness::new(&pair, &[Material::default(); 2], [Some(web); 2]);
        let name = case["name"].as_str().unwrap();
        let gpa = |pa: f64| 1e-9 * pa;
        let line = |what: &str, key: &str, value: f64| {
            let places = expected[key].to_string().split_once('.').unwrap().1.len();
            let half = 0.5 * 10f64.powi(-(places as i32));
            let reference = number(&expected[key]);
            printed(
                &format!("{what} of {name}"),
                "N/(mm µm)",
                reference,
                gpa(value),
                half,
            );
        };
        line("c′", "c_single", iso.single);
        line("c_γα", "c_gamma_alpha", iso.mesh);
        line("c_γβ", "c_gamma_beta", iso.along_face);
        if let Some(blank) = expected.get("CR") {
            printed(
                &format!("C_R of {name}"),
                "",
                number(blank),
                iso.blank_factor,
                5e-4,
            );
        }
    }
}

/// c′ does not depend on which gear is named first: the approximation takes the smaller tooth number as its first gear.
#[test]
fn law_iso6336_order_of_gears() {
    let inputs = &case("tooth_stiffness")["iso6336"][0]["inputs"];
    let pair = reported_pair(inputs);
    let [first, second] = pair.members;
    let swapped = Pair::new([second, first], Some(pair.centre_distance)).unwrap();
    let iso = |pair: &Pair| IsoStiffness::new(pair, &[Material::default(); 2], [None; 2]);
    let (one, other) = (iso(&pair), iso(&swapped));
    assert!((one.single / other.single - 1.0).abs() < 1e-14);
    assert!((one.mesh / other.mesh - 1.0).abs() < 1e-12);
    assert_eq!(one.outside_range.len(), 1, "{:?}", one.outside_range);
}

/// Spur gear of standard proportions.
fn spur(teeth: u32, module: f64, rack: BasicRack) -> Member {
    let gear = InvoluteGear {
        teeth,
        module,
        pressure_angle: 20f64.to_radians(),
        helix: 0.0,
        profile_shift: 0.0,
        internal: false,
    };
    Member::new(gear, rack, 0.02)
}

/// Deflection of a unit-width trapezium of half thickness `x0 − h tan α` from h = 0, loaded square to its flank at the height `l`.
fn wedge(x0: f64, alpha: f64, l: f64, material: &Material) -> [f64; 3] {
    let (s, c) = alpha.sin_cos();
    let t = alpha.tan();
    let x1 = x0 - l * t;
    // With x as variable, dh = −dx/t and c (l − h) − x₁ s = c (x − x₁)/t − x₁ s = p x + q.
    let (p, q) = (c / t, -c * x1 / t - x1 * s);
    let inverse_cubes = |x: f64| p * p * x.ln() - 2.0 * p * q / x - 0.5 * q * q / (x * x);
    let bending = 1.5 / material.young / t * (inverse_cubes(x0) - inverse_cubes(x1));
    let thin = (x0 / x1).ln() / t;
    [
        bending,
        0.6 * c * c / material.shear_modulus() * thin,
        0.5 * s * s / material.young * thin,
    ]
}

/// The tooth of a gear of 20 million teeth cut by a sharp tool, external or internal, is a trapezium: bending, shear and compression in closed form.
#[test]
fn exact_trapezium() {
    let rack = BasicRack {
        addendum: 1.0,
        dedendum: 1.25,
        tip_radius: 0.0,
        protuberance: 0.0,
    };
    let mate = spur(40, 1e-3, rack);
    let material = Material::default();
    let mut worst = [0.0f64; 3];
    let alpha = 20f64.to_radians();
    let foot = 1e-3 * (PI / 4.0 + 1.25 * alpha.tan());
    for internal in [false, true] {
        let mut large = spur(20_000_000, 1e-3, rack);
        large.gear.internal = internal;
        let pair = Pair::new([mate, large], None).unwrap();
        let outline = &pair.outlines[1];
        let section = ToothSection::new(outline, material).unwrap();
        for share in [0.3, 0.5, 0.8, 1.0] {
            let [radius, angle] = outline.involute_point(share);
            let height = (radius * angle.cos() - outline.root_radius).abs();
            let computed = section.compliance(outline.roll_length(radius));
            let exact = wedge(foot, alpha, height, &material);
            let parts = [computed.bending, computed.shear, computed.axial];
            for (k, value) in parts.into_iter().enumerate() {
                worst[k] = worst[k].max((value / exact[k] - 1.0).abs());
            }
        }
    }
    // What is left is the curvature of the involute, in proportion to 1/z.
    within("bending", worst[0], 3e-6);
    within("shear", worst[1], 3e-6);
    within("compression", worst[2], 3e-6);
}

/// Half angle of the foot as the source of the case writes it; the generated fillet ends at 0.04859.
fn foot_half_angle(teeth: f64, alpha: f64, addendum: f64, tip_radius: f64) -> f64 {
    let chamfer = 2.0 * tip_radius * (1.0 / alpha.cos() - alpha.tan());
    (PI / 2.0 + 2.0 * addendum * alpha.tan() + chamfer) / teeth
}

/// Mesh stiffness of a 62/62 pair by potential energy, two pairs on independent feet: at the start of contact, at the pitch point, its mean and its range.
/// Source: computed by an independent script for the pair of ross/tests/test_gear_element.py in petrobras/ross, commit 631a249a.
#[test]
fn ref_energy_method() {
    let case = &case("tooth_stiffness")["energy"];
    let (inputs, expected) = (&case["inputs"], &case["expected"]);
    let material = Material {
        young: number(&inputs["E"]),
        poisson: number(&inputs["nu"]),
    };
    let (alpha, width) = (number(&inputs["alpha"]).to_radians(), number(&inputs["b"]));
    let clearance = number(&inputs["c"]);
    let rack = BasicRack {
        addendum: 1.0,
        dedendum: 1.0 + clearance,
        tip_radius: clearance / (1.0 - alpha.sin()),
        protuberance: 0.0,
    };
    let gear = spur(62, number(&inputs["m"]), rack);
    let pair = Pair::new([gear, gear], None).unwrap();
    let section = ToothSection::new(&pair.outlines[0], material).unwrap();
    let body = Body::Ring {
        bore_radius: 0.5 * number(&inputs["bore_diameter"]),
    };
    let half_angle = foot_half_angle(62.0, alpha, 1.0, rack.tip_radius);
    let flanks = FlankContact {
        radius: 1.0,
        depths: [1.0; 2],
    };
    let contact = ContactModel::Constant.compliance(&flanks, &[material; 2]);
    printed(
        "Hertz stiffness",
        "N/m",
        number(&case["hertz"]),
        width / contact,
        1.0,
    );
    let points = pair.path_points();
    let length = points.a.roll[0] + points.a.roll[1];
    let one = |roll: f64| {
        let foot = FootLoad {
            root_half_angle: half_angle,
            ..section.foot_load(roll)
        };
        section.compliance(roll).total() + body.compliance(&foot, &material)
    };
    let single = |roll: f64| width / (one(roll) + one(length - roll) + contact);
    let mesh = |share: f64| {
        let pitch = pair.base_pitch();
        let rolls = (0..2).map(|j| points.a.roll[0] + (share + f64::from(j)) * pitch);
        rolls
            .filter(|s| *s <= points.e.roll[0])
            .map(single)
            .sum::<f64>()
    };
    let relative = |value: f64, key: &str| (value / number(&expected[key]) - 1.0).abs();
    within("at the start of contact", relative(mesh(0.0), "k0"), 1e-9);
    let at_pitch = single(points.c.roll[0]);
    within(
        "single pair at the pitch point",
        relative(at_pitch, "single_pair_at_pitch"),
        1e-9,
    );
    // The script samples a hundred positions from the start of contact; the integral over the pitch is 382.842e6.
    let curve: Vec<f64> = (0..100).map(|i| mesh(f64::from(i) / 100.0)).collect();
    let mean = curve.iter().sum::<f64>() / 100.0;
    printed("mean", "N/m", 382.9e6, mean, 0.05e6);
    within("mean", relative(mean, "mean"), 1e-9);
    let (low, high) = curve
        .iter()
        .fold((f64::INFINITY, 0.0f64), |(l, h), k| (l.min(*k), h.max(*k)));
    within("least", relative(low, "min"), 1e-9);
    within("greatest", relative(high, "max"), 1e-9);
}

/// Weber's foot, 5.2 (u/S)² + u/S + 1.4 (1 + 0.294 tan²β) for ν = 0.3, and the half plane differ by 8 % at most.
#[test]
fn law_half_plane_near_weber() {
    let material = Material::default();
    for (ratio, angle) in [(0.0, 0.1f64), (0.3, 0.2), (1.0, 0.4), (1.5, 0.5)] {
        let load = FootLoad {
            height: ratio,
            angle,
            root_radius: 1.0,
            root_half_angle: 0.5,
        };
        let (c, t) = (angle.cos(), angle.tan());
        let weber =
            c * c / material.young * (5.2 * ratio * ratio + ratio + 1.4 * (1.0 + 0.294 * t * t));
        let apart = Body::HalfPlane.compliance(&load, &material) / weber - 1.0;
        assert!(apart.abs() < 0.08, "{apart}");
    }
}

/// p_H = 0.418 √(w E/ρ) of equal steel flanks (ν = 0.3), and the load is π/2 times half width times pressure.
#[test]
fn exact_line_contact() {
    let steel = [Material::default(); 2];
    let (load, radius) = (300e3f64, 8e-3);
    let pressure = hertz::line_pressure(load, radius, &steel);
    let factor = (1.0 / (TAU * (1.0 - 0.09))).sqrt();
    let handbook = factor * (load * 206e9 / radius).sqrt();
    within(
        "greatest pressure",
        (pressure / handbook - 1.0).abs(),
        1e-14,
    );
    let half_width = 4.0 * pressure * radius * (1.0 - 0.09) / 206e9;
    within(
        "load",
        (0.5 * PI * half_width * pressure / load - 1.0).abs(),
        1e-14,
    );
}
