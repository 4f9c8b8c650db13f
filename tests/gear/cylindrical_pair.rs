//! Cylindrical pairs: published geometry.

use serde_json::Value;

use crate::cases::{case, number_at};
use crate::verification::{printed, within};
use geardyn::internals::gear::cylindrical::basic_rack::BasicRack;
use geardyn::internals::gear::cylindrical::involute::{InvoluteGear, inv};
use geardyn::internals::gear::cylindrical::member::Member;
use geardyn::internals::gear::cylindrical::pair::{Pair, profile_shift_sum};
use geardyn::internals::gear::cylindrical::warnings::{NearestValue, WarningKind};

const MM: f64 = 1e-3;

/// Half a unit of the last of so many decimals, and a thousandth of it for rounding.
fn half_digit(decimals: i32) -> f64 {
    0.5005 * 10f64.powi(-decimals)
}

struct Design {
    z: [u32; 2],
    m: f64,
    alpha: f64,
    beta: f64,
    x: [f64; 2],
    internal: bool,
}

impl Design {
    fn members(&self, rack: BasicRack, width: f64) -> [Member; 2] {
        [0, 1].map(|i| {
            let gear = InvoluteGear {
                teeth: self.z[i],
                module: self.m * MM,
                pressure_angle: self.alpha.to_radians(),
                helix: self.beta.to_radians(),
                profile_shift: self.x[i],
                internal: self.internal && i == 1,
            };
            Member::new(gear, rack, width * MM)
        })
    }
}

fn with_tips(mut members: [Member; 2], tips: [f64; 2]) -> [Member; 2] {
    for (member, tip) in members.iter_mut().zip(tips) {
        member.tip_diameter = Some(tip * MM);
    }
    members
}

/// The helical pair 24/95, module 14, of a wind turbine's third stage: every geometry row of its report.
/// Source: KISSsoft 03/2017A report in gfsReboucas/Drivetrain, @NREL_5MW/stage_03.rtf.
#[test]
fn ref_kisssoft_helical_pair() {
    let case = case("nrel_5mw_stage_3");
    let input = |path: &str| number_at(&case["inputs"], path);
    let expected = |path: &str| number_at(&case["expected"], path);
    let mut design = Design {
        z: [24, 95],
        m: input("/mn"),
        alpha: input("/alpha_n_deg"),
        beta: input("/beta_deg"),
        x: [input("/x1"), 0.0],
        internal: false,
    };
    let a = input("/a") * MM;
    let sum = profile_shift_sum(&design.members(BasicRack::PROFILE_A, 360.0), a);
    printed("Σx", "", expected("/sum_x"), sum, half_digit(4));
    design.x[1] = sum - design.x[0];
    printed("x₂", "", expected("/x2"), design.x[1], half_digit(4));
    let plain = design.members(BasicRack::PROFILE_A, 360.0);
    let own_tips = Pair::new(plain, Some(a)).unwrap();
    let tips = own_tips.members.map(|m| m.tip_diameter() / MM);
    for i in 0..2 {
        let reference = input(&format!("/tip_diameter/{i}"));
        // The report rounds k m_n first.
        printed(&format!("d_a{}", i + 1), "mm", reference, tips[i], 1.5e-3);
    }
    let k = own_tips.members[0].tip_alteration() * design.m;
    printed("k m_n", "mm", input("/k_mn"), k, half_digit(3));
    let tips = [0, 1].map(|i| input(&format!("/tip_diameter/{i}")));
    let pair = Pair::new(with_tips(plain, tips), Some(a)).unwrap();
    let gears = pair.members.map(|m| m.gear);
    let deg = |name: &str, value: f64| {
        printed(
            name,
            "deg",
            expected(&format!("/{name}")),
            value.to_degrees(),
            half_digit(3),
        )
    };
    deg("alpha_t", gears[0].transverse_pressure_angle());
    deg("alpha_wt", pair.working_pressure_angle);
    deg("beta_b", gears[0].base_helix_angle());
    let one = |name: &str, value: f64, tolerance: f64| {
        printed(
            name,
            "mm",
            expected(&format!("/{name}")),
            value / MM,
            tolerance,
        )
    };
    let digit = half_digit(3);
    one("a_d", pair.reference_centre_distance(), digit);
    one("pet", pair.base_pitch(), digit);
    // The rounded tip diameters move the ends of the path by 1e-3 mm.
    one("g_alpha", pair.path_length(), 1.5e-3);
    let points = pair.path_points();
    for (name, point) in [
        ("T1A", points.a),
        ("T1B", points.b),
        ("T1C", points.c),
        ("T1D", points.d),
        ("T1E", points.e),
    ] {
        one(
            name,
            point.roll[0],
            if name == "T1B" || name == "T1E" {
                1.5e-3
            } else {
                digit
            },
        );
    }
    let both = |name: &str, values: [f64; 2], tolerance: f64| {
        for (i, value) in values.into_iter().enumerate() {
            let reference = expected(&format!("/{name}/{i}"));
            printed(
                &format!("{name} {}", i + 1),
                "",
                reference,
                value,
                tolerance,
            );
        }
    };
    let mm = |values: [f64; 2]| values.map(|v| v / MM);
    both("d", mm(gears.map(|g| g.reference_diameter())), digit);
    both("db", mm(gears.map(|g| g.base_diameter())), digit);
    both("dw", mm(pair.working_diameters()), digit);
    both(
        "df",
        mm(pair.members.map(|m| m.root_diameter(m.gear.profile_shift))),
        digit,
    );
    both("dNf", mm(pair.active_root_diameters()), 1.5e-3);
    both("dFf", mm(pair.outlines.map(|o| 2.0 * o.form_radius)), digit);
    let ratios = pair.contact_ratios();
    printed("ε_α", "", expected("/eps_alpha"), ratios.transverse, digit);
    printed("ε_β", "", expected("/eps_beta"), ratios.overlap, digit);
    printed("ε_γ", "", expected("/eps_gamma"), ratios.total, digit);
    let [tip1, root2] = points.e.specific_sliding;
    let [root1, tip2] = points.a.specific_sliding;
    both("spec_sliding_tip", [tip1, tip2], digit);
    both("spec_sliding_root", [root1, root2], digit);
    both(
        "Kga",
        [points.e.sliding_factor, points.a.sliding_factor],
        digit,
    );
    let spans = [0, 1].map(|i| {
        gears[i].span(
            input(&format!("/span_teeth/{i}")) as u32,
            gears[i].nominal_thickness(),
        )
    });
    let usual = gears.map(|g| f64::from(g.default_span_teeth()));
    assert_eq!(usual, [input("/span_teeth/0"), input("/span_teeth/1")]);
    both("Wk", mm(spans), digit);
    let over = [0, 1].map(|i| {
        gears[i].dimension_over_balls(
            input(&format!("/ball_DM/{i}")) * MM,
            gears[i].nominal_thickness(),
        )
    });
    both("MdK", mm(over), digit);
    let over = [0, 1].map(|i| {
        let ball = input(&format!("/ball_DM/{i}")) * MM;
        gears[i].radial_dimension_over_ball(ball, gears[i].nominal_thickness())
    });
    both("MrK", mm(over), digit);
    both("s_arc", mm(gears.map(|g| g.nominal_thickness())), digit);
    let chords = [0, 1].map(|i| {
        gears[i]
            .chordal_thickness(tips[i] * MM, gears[i].nominal_thickness())
            .0
    });
    both("s_chord", mm(chords), digit);
}

/// Sun and planet 18/36, module 21, of a wind turbine's second stage.
/// Source: KISSsoft 03/2017A report in gfsReboucas/Drivetrain, @NREL_5MW/stage_02.rtf.
#[test]
fn ref_kisssoft_sun_and_planet() {
    let case = case("nrel_5mw_stage_2");
    let input = |path: &str| number_at(&case["inputs"], path);
    let expected = |path: &str| number_at(&case["expected"], path);
    let mut design = Design {
        z: [18, 36],
        m: input("/mn"),
        alpha: 20.0,
        beta: 0.0,
        x: [input("/x1"), 0.0],
        internal: false,
    };
    let a = input("/a") * MM;
    let sum = profile_shift_sum(&design.members(BasicRack::PROFILE_A, 550.0), a);
    printed("Σx", "", expected("/sum_x"), sum, half_digit(4));
    design.x[1] = sum - design.x[0];
    printed("x₂", "", expected("/x/1"), design.x[1], half_digit(4));
    let tips = [0, 1].map(|i| input(&format!("/tip_diameter/{i}")));
    let plain = with_tips(design.members(BasicRack::PROFILE_A, 550.0), tips);
    let pair = Pair::new(plain, Some(a)).unwrap();
    let gears = pair.members.map(|m| m.gear);
    let digit = half_digit(3);
    printed(
        "α_wt",
        "deg",
        expected("/alpha_wt"),
        pair.working_pressure_angle.to_degrees(),
        digit,
    );
    let both = |name: &str, values: [f64; 2], tolerance: f64| {
        for (i, value) in values.into_iter().enumerate() {
            let reference = expected(&format!("/{name}/{i}"));
            printed(
                &format!("{name} {}", i + 1),
                "",
                reference,
                value,
                tolerance,
            );
        }
    };
    let mm = |values: [f64; 2]| values.map(|v| v / MM);
    both("db", mm(gears.map(|g| g.base_diameter())), digit);
    printed(
        "d_w1",
        "mm",
        expected("/dw_sun"),
        pair.working_diameters()[0] / MM,
        digit,
    );
    both(
        "df",
        mm(pair.members.map(|m| m.root_diameter(m.gear.profile_shift))),
        digit,
    );
    both("dNf", mm(pair.active_root_diameters()), 1.5e-3);
    both("dFf", mm(pair.outlines.map(|o| 2.0 * o.form_radius)), digit);
    printed(
        "g_α",
        "mm",
        expected("/g_alpha"),
        pair.path_length() / MM,
        1.5e-3,
    );
    printed(
        "ε_α",
        "",
        expected("/eps_alpha"),
        pair.contact_ratios().transverse,
        digit,
    );
    // The report lists the points as the planet drives.
    let points = pair.path_points_driven_by_second();
    for (i, point) in [points.a, points.b, points.c, points.d, points.e]
        .into_iter()
        .enumerate()
    {
        let reference = expected(&format!("/T_points_sun/{i}"));
        printed(
            &format!("point {}", i + 1),
            "mm",
            reference,
            point.roll[0] / MM,
            1.5e-3,
        );
    }
    let [root1, tip2] = points.e.specific_sliding;
    let [tip1, root2] = points.a.specific_sliding;
    both("spec_sliding_tip", [tip1, tip2], digit);
    both("spec_sliding_root", [root1, root2], digit);
    let spans = [0, 1].map(|i| {
        gears[i].span(
            input(&format!("/span/{i}")) as u32,
            gears[i].nominal_thickness(),
        )
    });
    both("Wk", mm(spans), digit);
    let over = [0, 1].map(|i| {
        gears[i].dimension_over_balls(
            input(&format!("/ball_DM/{i}")) * MM,
            gears[i].nominal_thickness(),
        )
    });
    both("MdK", mm(over), digit);
}

/// Shifted spur and helical pairs: centre distance and diameters.
/// Source: "Elements of metric gear technology", worked examples.
#[test]
fn ref_metric_gear_examples() {
    let cases = case("metric_gear_examples");
    let example = |id: &str| {
        let all = cases["cases"].as_array().unwrap();
        all.iter().find(|c| c["id"] == id).unwrap().clone()
    };
    let spur = example("a");
    let design = Design {
        z: [12, 24],
        m: 3.0,
        alpha: 20.0,
        beta: 0.0,
        x: [0.6, 0.36],
        internal: false,
    };
    let pair = Pair::new(design.members(BasicRack::PROFILE_A, 20.0), None).unwrap();
    working("spur", ["α_w", "aw"], &spur, &pair, 4);
    diameters("spur", &spur, &pair, [4, 3, 2, 2]);
    let helical = example("b");
    let design = Design {
        z: [12, 60],
        m: 3.0,
        alpha: 20.0,
        beta: 30.0,
        x: [0.09809, 0.0],
        internal: false,
    };
    let pair = Pair::new(design.members(BasicRack::PROFILE_A, 20.0), None).unwrap();
    working("helical", ["α_wt", "awt"], &helical, &pair, 3);
    // The source adds rounded heights to get d_a and d_f.
    diameters("helical", &helical, &pair, [3, 3, 2, 2]);
    let span = example("e");
    let gear = InvoluteGear {
        teeth: 24,
        module: 3.0 * MM,
        pressure_angle: 20f64.to_radians(),
        helix: 0.0,
        profile_shift: 0.4,
        internal: false,
    };
    assert_eq!(f64::from(gear.default_span_teeth()), number_at(&span, "/k"));
    printed(
        "span",
        "mm",
        number_at(&span, "/W"),
        gear.span(4, gear.nominal_thickness()) / MM,
        half_digit(4),
    );
    let chord = example("f");
    let gear = InvoluteGear {
        teeth: 12,
        module: 10.0 * MM,
        profile_shift: 0.3,
        ..gear
    };
    let tip = Member::new(gear, BasicRack::PROFILE_A, 0.02).tip_diameter();
    let (length, height) = gear.chordal_thickness(tip, gear.nominal_thickness());
    printed(
        "s_n",
        "mm",
        number_at(&chord, "/s"),
        gear.nominal_thickness() / MM,
        half_digit(4),
    );
    printed(
        "chord",
        "mm",
        number_at(&chord, "/s_chord"),
        length / MM,
        half_digit(4),
    );
    printed(
        "chordal height",
        "mm",
        number_at(&chord, "/ha_chord"),
        height / MM,
        half_digit(4),
    );
}

/// Working pressure angle, with its symbol and its key, and centre distance to so many decimals.
fn working(what: &str, [symbol, key]: [&str; 2], example: &Value, pair: &Pair, decimals: i32) {
    let angle = pair.working_pressure_angle;
    let degrees = angle.to_degrees();
    let row = |name: &str, unit: &str, key: &str, value: f64, decimals: i32| {
        let reference = number_at(example, key);
        printed(
            &format!("{what} {name}"),
            unit,
            reference,
            value,
            half_digit(decimals),
        );
    };
    row(
        &format!("inv {symbol}"),
        "",
        &format!("/inv_{key}"),
        inv(angle),
        6,
    );
    row(symbol, "deg", &format!("/alpha_{}", &key[1..]), degrees, 4);
    row("a", "mm", "/a", pair.centre_distance / MM, decimals);
}

/// Base, pitch, tip and root diameters of an example against a pair, to so many digits each.
fn diameters(what: &str, example: &Value, pair: &Pair, digits: [i32; 4]) {
    let rows = [
        ("db", pair.members.map(|m| m.gear.base_diameter())),
        ("dw", pair.working_diameters()),
        ("da", pair.members.map(|m| m.tip_diameter())),
        ("df", pair.outlines.map(|o| 2.0 * o.root_radius)),
    ];
    for ((name, values), digits) in rows.into_iter().zip(digits) {
        for i in 0..2 {
            let reference = number_at(example, &format!("/{name}/{i}"));
            printed(
                &format!("{what} {name} {}", i + 1),
                "mm",
                reference,
                values[i] / MM,
                half_digit(digits),
            );
        }
    }
}

/// The FZG test pair 16/24, module 4.5 at a = 91.5 mm, as type C and as type A.
/// Source: gear data of ISO 14635-1 (FZG types A and C); contact ratios, active diameters and sliding recomputed.
#[test]
fn ref_fzg_pairs() {
    let design = |x| Design {
        z: [16, 24],
        m: 4.5,
        alpha: 20.0,
        beta: 0.0,
        x,
        internal: false,
    };
    let pair = |x, tips| {
        let members = with_tips(design(x).members(BasicRack::PROFILE_A, 20.0), tips);
        Pair::new(members, Some(91.5 * MM)).unwrap()
    };
    let c = pair([0.1817, 0.1715], [82.46, 118.36]);
    printed(
        "α_wt",
        "deg",
        22.438791,
        c.working_pressure_angle.to_degrees(),
        half_digit(6),
    );
    let sum = profile_shift_sum(&c.members, c.centre_distance);
    printed("Σx", "", 0.3531805, sum, half_digit(7));
    printed(
        "type C ε_α",
        "",
        1.43754,
        c.contact_ratios().transverse,
        half_digit(5),
    );
    let points = c.path_points();
    printed(
        "ζ_A1",
        "",
        -3.539,
        points.a.specific_sliding[0],
        half_digit(3),
    );
    printed(
        "ζ_E2",
        "",
        -2.113,
        points.e.specific_sliding[1],
        half_digit(3),
    );
    printed(
        "ζ_E1",
        "",
        0.6788,
        points.e.specific_sliding[0],
        half_digit(4),
    );
    printed(
        "ζ_A2",
        "",
        0.7797,
        points.a.specific_sliding[1],
        half_digit(4),
    );
    let [n1, n2] = c.active_root_diameters();
    printed("d_Nf1", "mm", 68.2466, n1 / MM, half_digit(4));
    printed("d_Nf2", "mm", 103.9971, n2 / MM, half_digit(4));
    let a = pair([0.8635, -0.5103], [88.77, 112.5]);
    printed(
        "type A ε_α",
        "",
        1.36108,
        a.contact_ratios().transverse,
        half_digit(5),
    );
}

/// The internal pair 16/24, module 3: a ring shift of 0.5 counted outward thins its teeth, x₂ = −0.5.
/// Source: "Elements of metric gear technology", worked example of an internal pair, recomputed to more digits.
#[test]
fn ref_internal_pair() {
    let design = Design {
        z: [16, 24],
        m: 3.0,
        alpha: 20.0,
        beta: 0.0,
        x: [0.0, -0.5],
        internal: true,
    };
    let pair = Pair::new(design.members(BasicRack::PROFILE_A, 20.0), None).unwrap();
    printed(
        "α_w",
        "deg",
        31.093621,
        pair.working_pressure_angle.to_degrees(),
        half_digit(6),
    );
    printed(
        "a",
        "mm",
        13.1682677,
        pair.centre_distance / MM,
        half_digit(7),
    );
    let [w1, w2] = pair.working_diameters();
    printed("d_w1", "mm", 52.673071, w1 / MM, half_digit(6));
    printed("d_w2", "mm", 79.009606, w2 / MM, half_digit(6));
    let [tip, root] = [
        pair.members[1].tip_diameter(),
        2.0 * pair.outlines[1].root_radius,
    ];
    within(
        "ring's tip diameter 69 mm, absolute",
        (tip / MM - 69.0).abs(),
        1e-12,
    );
    within(
        "ring's root diameter 82.5 mm, absolute",
        (root / MM - 82.5).abs(),
        1e-12,
    );
    // Contact would begin 0.03 mm before the tangent point of the pinion's base circle; nothing else touches as the pinion turns.
    let warnings = pair.warnings();
    let kinds: Vec<_> = warnings.iter().map(|w| (w.kind, w.member)).collect();
    let expected = [
        (WarningKind::Undercut, Some(0)),
        (WarningKind::InvoluteInterference, Some(0)),
    ];
    assert_eq!(kinds, expected);
    let Some(NearestValue::TipDiameter { member: 1, value }) = warnings[1].nearest else {
        panic!("{:?}", warnings[1]);
    };
    printed(
        "interference",
        "mm",
        0.03,
        warnings[1].by / MM,
        half_digit(2),
    );
    // Rounded up, so that the printed diameter avoids it.
    let printed_tip = value.scaled(1.0 / MM).text(3).parse().unwrap();
    printed(
        "nearest tip diameter of the ring",
        "mm",
        69.012,
        printed_tip,
        1e-9,
    );
    let freed = with_tips(
        pair.members,
        [pair.members[0].tip_diameter() / MM, value.value() / MM],
    );
    let freed = Pair::new(freed, Some(pair.centre_distance)).unwrap();
    assert!(
        freed
            .warnings()
            .iter()
            .all(|w| w.kind != WarningKind::InvoluteInterference)
    );
}
