//! Bevel flanks from machine settings: published machines, starts without hints, undercut.

use geardyn::internals::gear::bevel::blank::Blank;
use geardyn::internals::gear::bevel::cutter::{Blade, Cutter};
use geardyn::internals::gear::bevel::flank::BevelFlank;
use geardyn::internals::gear::bevel::flank_grid::FlankGrid;
use geardyn::internals::gear::bevel::flank_lines::{ContactLines, FlankLimits};
use geardyn::internals::gear::bevel::frames::CutterFrame;
use geardyn::internals::gear::bevel::settings::{MachineSettings, Roll};
use geardyn::internals::gear::bevel::structure_elements::StructureElements;
use geardyn::internals::gear::bevel::tooth_section::ToothSection;
use geardyn::internals::gear::cut::setting::FlankSetup;
use geardyn::internals::gear::hand::Hand;
use geardyn::internals::gear::kernel::envelope::Envelope;
use geardyn::internals::gear::kernel::jet::Surface;
use geardyn::internals::gear::kernel::pose::Point;
use geardyn::internals::gear::kernel::vector::Vector;
use serde_json::Value;

use crate::cases::{case, number, vector};
use crate::verification::within;

/// A flank of c12, in inches.
pub fn nasa_flank(case: &Value, name: &str) -> BevelFlank {
    let (setup, hand, section) = nasa_cut(case, name);
    setup.flank(hand, section)
}

/// Cutter, machine, hand and section of a flank of c12, in inches.
pub fn nasa_cut(case: &Value, name: &str) -> (FlankSetup, Hand, ToothSection) {
    let settings = &case["flanks"][name];
    let get = |name: &str| number(&settings[name]);
    let angle = |name: &str| get(name).to_radians();
    let common = |name: &str| number(&case["common_gear"][name]);
    let outside = get("psi") > 90.0;
    let cutter = Cutter::straight(
        if outside {
            Blade::Outside
        } else {
            Blade::Inside
        },
        get("r"),
        if outside {
            (180.0 - get("psi")).to_radians()
        } else {
            angle("psi")
        },
    );
    let root = angle("mu") - angle("deden");
    // L_m is the sum of X_D and X_B along the root line.
    let machine = MachineSettings {
        radial_distance: get("s"),
        cradle_angle: angle("q"),
        blank_offset: get("em"),
        sliding_base: get("lm") * root.tan(),
        helical_motion: 0.0,
        centre_to_back: -get("lm") / root.cos(),
        machine_root_angle: root,
        tilt: 0.0,
        swivel: 0.0,
        roll: Some(Roll::constant(1.0 / get("mcw"))),
    };
    let hand = if get("h") > 0.0 {
        Hand::Left
    } else {
        Hand::Right
    };
    let corner = |face: f64, height: f64| {
        let (cl, width) = (get("cl"), common("face_width"));
        let dedendum = angle("deden");
        let along = (common("rl_mean_cone") - 0.5 * width) * dedendum.cos() + face * width;
        let z = along * root.cos() - cl * root.sin();
        let r = z * root.tan() + cl / root.cos();
        let depth = z * (angle("addan") + dedendum).tan() / root.cos() - cl;
        [
            z - height * depth * root.sin(),
            r + height * depth * root.cos(),
        ]
    };
    let section = ToothSection {
        corners: [0.0, 1.0].map(|face| [0.0, 1.0].map(|height| corner(face, height))),
    };
    (FlankSetup { cutter, machine }, hand, section)
}

/// A spiral bevel pair cut with fixed settings, its grids found without hints.
/// Source: NASA CR-191009 (Bibel, Reddy and Kumar 1994); grids computed by two routes, data/reference/gear/c12_nasa_cr191009_flanks.json.
#[test]
fn ref_nasa_grids() {
    let case = case("c12_nasa_cr191009_flanks");
    for name in ["pinion_concave", "gear_convex"] {
        let flank = nasa_flank(&case, name);
        let grid = FlankGrid::of(&flank, 5, 5).unwrap();
        let (mut places, mut normals) = (0f64, 0f64);
        for node in case["grid_computed_here"][name].as_array().unwrap() {
            let index = |key: &str| (number(&node[key]) * 4.0).round() as usize;
            let point = grid.node(index("height"), index("face")).unwrap().point;
            places = places.max((point.point.coordinates - vector(&node["xyz"])).norm());
            normals = normals.max(point.normal.components.cross(vector(&node["n"])).norm());
        }
        within(&format!("{name}: points, in"), places, 1e-13);
        within(&format!("{name}: normals"), normals, 1e-13);
    }
}

/// Cutter, machine and section of the right-hand gear of c16, in mm.
pub fn gear_38_51(case: &Value) -> (FlankSetup, ToothSection) {
    let get = |name: &str| number(&case["inputs"][name]);
    let cutter = Cutter::straight(
        Blade::Inside,
        get("rc_inner_side"),
        get("alpha_inner").to_radians(),
    );
    let machine = MachineSettings {
        radial_distance: get("Sr"),
        cradle_angle: -get("q2_deg").to_radians(),
        blank_offset: get("Em"),
        sliding_base: get("XB"),
        helical_motion: 0.0,
        centre_to_back: get("XD"),
        machine_root_angle: f64::atan2(51.0, 38.0) - get("dedendum_angle").to_radians(),
        tilt: 0.0,
        swivel: 0.0,
        roll: Some(Roll::constant(1.0 / get("mr_cradle_over_work"))),
    };
    let nodes = case["points"].as_array().unwrap();
    let place = |i: usize, j: usize| {
        let node = nodes.iter().find(|n| n["i"] == i && n["j"] == j).unwrap();
        let xyz = vector(&node["xyz"]);
        [xyz.x, f64::hypot(xyz.y, xyz.z)]
    };
    let (rows, columns) = (nodes.len() / 10, 10);
    let section = ToothSection {
        corners: [0, columns - 1].map(|j| [place(rows - 1, j), place(0, j)]),
    };
    (FlankSetup { cutter, machine }, section)
}

/// A gear of 51 teeth cut by an inside blade, right hand, its grid found without hints; the case lists (z, y, −x).
/// Source: settings of haomjc/SpyGO 417ac9a, points by its closed form, data/reference/gear/c16_gear_38_51_flank.json.
#[test]
fn ref_gear_38_51_grid() {
    let case = case("c16_gear_38_51_flank");
    let (setup, section) = gear_38_51(&case);
    let flank = setup.flank(Hand::Right, section);
    let nodes = case["points"].as_array().unwrap();
    let middle = flank.middle().unwrap();
    let (mut places, mut normals, mut blades) = (0f64, 0f64, 0f64);
    for node in nodes {
        let (xyz, n) = (vector(&node["xyz"]), vector(&node["n"]));
        let at = flank
            .envelope
            .intersect_circle([xyz.x, f64::hypot(xyz.y, xyz.z)], middle)
            .unwrap();
        let point = flank.envelope.point(at).unwrap();
        let listed = |v: Vector| Vector::new(v.z, v.y, -v.x);
        places = places.max((listed(point.point.coordinates) - xyz).norm());
        normals = normals.max(listed(point.normal.components).cross(n).norm());
        blades = blades.max((at[0] - number(&node["s"])).abs());
    }
    within("points, mm", places, 1e-12);
    within("normals", normals, 1e-14);
    within("blade coordinate, mm", blades, 1e-12);
}

/// Rough settings for a spiral angle: the cutter's centre across the tooth at the mean point, roll 1/sin of the root angle.
fn rough(spiral: f64, distance: f64, radius: f64, root: f64) -> (Cutter, MachineSettings) {
    let (x, y) = (distance - radius * spiral.sin(), radius * spiral.cos());
    let cutter = Cutter::straight(Blade::Inside, radius, 0.35);
    let machine = MachineSettings {
        radial_distance: x.hypot(y),
        cradle_angle: y.atan2(x),
        blank_offset: 0.0,
        sliding_base: 0.0,
        helical_motion: 0.0,
        centre_to_back: 0.0,
        machine_root_angle: root,
        tilt: 0.0,
        swivel: 0.0,
        roll: Some(Roll::constant(1.0 / root.sin())),
    };
    (cutter, machine)
}

/// Random generators of pitch angles 11° to 74° and spiral angles to 52°, tilted and offset: the start without hints finds the flank of the
/// spiral angle the settings were made for.
#[test]
fn law_starts_of_random_machines() {
    fastrand::seed(61);
    let mut right = 0;
    for _ in 0..300 {
        let around = |middle: f64, by: f64| middle + by * (2.0 * fastrand::f64() - 1.0);
        let (pitch, spiral) = (around(0.75, 0.55), around(0.45, 0.45));
        let (distance, radius) = (0.1, around(0.1, 0.03));
        let (addendum, dedendum) = (around(0.05, 0.02), around(0.05, 0.02));
        let (cutter, mut machine) = rough(spiral, distance, radius, pitch - dedendum);
        machine.blank_offset = around(0.0, 0.003);
        machine.sliding_base = around(0.0, 0.0005);
        (machine.tilt, machine.swivel) = (around(0.0, 0.015), around(0.0, 3.0));
        let cones = [pitch, pitch + addendum, pitch - dedendum];
        let section = Blank::of_one_apex(cones, distance, 0.03).section().unwrap();
        let hand = if fastrand::bool() {
            Hand::Right
        } else {
            Hand::Left
        };
        let flank = BevelFlank::new(&cutter, &machine, hand, section);
        let Some(middle) = flank.middle() else {
            continue;
        };
        let point = flank.envelope.point(middle).unwrap();
        // Seen from the apex the outer half of a right-hand tooth bends clockwise: its azimuth about z grows. The tooth line is
        // perpendicular to the normal and to the outward normal of the cone through the point.
        let r = point.point.coordinates;
        let along = Vector::new(r.x, r.y, r.z).unit().unwrap();
        let around_axis = Vector::Z.cross(r).unit().unwrap();
        let tooth = point
            .normal
            .components
            .cross(along.cross(around_axis))
            .unit()
            .unwrap();
        let tooth = if tooth.dot(along) > 0.0 {
            tooth
        } else {
            -tooth
        };
        let found = f64::atan2(hand.sign() * tooth.dot(around_axis), tooth.dot(along));
        if (found - spiral).abs() < 0.3 {
            right += 1;
        } else {
            println!("{found} for {spiral}, pitch angle {pitch}, {hand:?}");
        }
    }
    assert_eq!(right, 300);
}

/// A blade that reaches deeper into the pinion of c12 undercuts it: the limit crosses the section from end to end, at each of its points the
/// flank has an edge, where both its tangents are parallel, and the contact lines end there.
#[test]
fn law_undercut_of_a_pinion() {
    let case = case("c12_nasa_cr191009_flanks");
    let mut flank = nasa_flank(&case, "pinion_concave");
    let lines = |flank: &BevelFlank| {
        let grid = FlankGrid::of(flank, 9, 15).unwrap();
        (FlankLimits::of(flank, &grid, |_| true), grid)
    };
    assert_eq!(lines(&flank).0, FlankLimits::default());
    flank.envelope.surface.curve.range[0] = -0.2;
    for end in &mut flank.section.corners {
        let [root, tip] = *end;
        end[0] = [0, 1].map(|k| root[k] - 0.6 * (tip[k] - root[k]));
    }
    let area = |[_, theta, x]: [f64; 3]| {
        let [along, across] = flank.envelope.jet([x, theta]).unwrap().dr;
        along.cross(across).norm()
    };
    let middle = flank.middle().unwrap();
    let (limits, grid) = lines(&flank);
    let [undercut, second] = limits.curves;
    assert_eq!((undercut.len(), second.len()), (1, 0));
    let [from, to] = [undercut[0][0], undercut[0][undercut[0].len() - 1]];
    let ends = [from[0].min(to[0]), from[0].max(to[0])];
    within(
        "ends of the limit at toe and heel",
        ends[0].max(1.0 - ends[1]),
        1e-12,
    );
    for face in [0.0, 0.13, 0.5, 0.88, 1.0] {
        let point = flank.undercut_limit(face, middle).unwrap();
        assert!(area(point.at) < 1e-12 * area(middle), "{point:?}");
    }
    // Contact lines end at the limit: no point of theirs lies below it.
    let limit_height = |face: f64| {
        let pairs = undercut[0].windows(2);
        let mut at = pairs.filter_map(|p| {
            let share = (face - p[0][0]) / (p[1][0] - p[0][0]);
            (-1e-9..=1.0 + 1e-9)
                .contains(&share)
                .then(|| p[0][1] + share * (p[1][1] - p[0][1]))
        });
        at.next().unwrap()
    };
    let contact = ContactLines::of(&flank, &grid).unwrap();
    let points: Vec<[f64; 2]> = contact.lines.concat();
    assert!(points.len() > 200, "{}", points.len());
    for [face, height] in points {
        assert!(height > limit_height(face) - 2e-3, "{face} {height}");
    }
}

/// A cutter of each blade with an edge radius, in m.
fn cutters() -> [Cutter; 2] {
    [Blade::Inside, Blade::Outside].map(|blade| Cutter {
        edge_radius: 0.0008,
        ..Cutter::straight(blade, 0.0753, 0.32)
    })
}

/// The torus of the edge touches the tip plane at one end and goes over into the cone at the other, normals into the blade.
#[test]
fn exact_edge_of_a_cutter() {
    let (mut places, mut normals) = (0f64, 0f64);
    for cutter in cutters() {
        let surfaces = cutter.surfaces(0.01);
        let (blade, edge) = (surfaces.blade, surfaces.edge.unwrap());
        let [tip, end] = edge.range();
        let at_tip = edge.jet([tip, 0.7]).unwrap();
        places = places.max(at_tip.r.z.abs());
        normals = normals.max((at_tip.n + Vector::Z).norm());
        let joined = edge.jet([end, 0.7]).unwrap();
        let straight = blade.jet([blade.range()[0], 0.7]).unwrap();
        places = places.max((joined.r - straight.r).norm());
        normals = normals.max((joined.n - straight.n).norm());
    }
    within("places, m", places, 1e-16);
    within("normals", normals, 1e-15);
    let sharp = Cutter {
        edge_radius: 0.0,
        ..cutters()[0]
    };
    assert!(sharp.surfaces(0.01).edge.is_none());
}

/// Every setting of a generator, none of them zero; lengths in m.
fn machine() -> MachineSettings {
    MachineSettings {
        radial_distance: 0.0749,
        cradle_angle: 1.11,
        blank_offset: 0.0039,
        sliding_base: 0.0003,
        helical_motion: 0.002,
        centre_to_back: -0.0005,
        machine_root_angle: 0.2944,
        tilt: 0.03,
        swivel: 0.6,
        roll: Some(Roll::from_sheet(3.24, [0.02, 0.05, 0.3, 1.0])),
    }
}

/// Left-hand work is the mirror image of right-hand work: points and functions of meshing with θ turned round.
#[test]
fn law_hands_mirror() {
    let section = Blank::of_one_apex([0.32, 0.39, 0.29], 0.081, 0.025);
    let section = section.section().unwrap();
    for cutter in cutters() {
        let [right, left] = [Hand::Right, Hand::Left]
            .map(|hand| BevelFlank::new(&cutter, &machine(), hand, section));
        for [s, theta, x] in [[0.003, 1.2, 0.1], [0.006, -0.4, -0.3]] {
            let a = right.envelope.meeting([s, theta, x]).unwrap();
            let b = left.envelope.meeting([s, -theta, x]).unwrap();
            let mirrored = Vector::new(b.jet.r.x, -b.jet.r.y, b.jet.r.z);
            assert!((a.jet.r - mirrored).norm() < 1e-16, "{a:?} {b:?}");
            assert!((a.f - b.f).abs() < 1e-15, "{a:?} {b:?}");
        }
    }
}

/// Helical motion is a sliding base that grows with the cradle; the modified roll of a sheet turns the work by its polynomial.
#[test]
fn exact_helical_motion_and_modified_roll() {
    let (x, all) = (0.2f64, machine());
    let place = Point::<CutterFrame>::new(Vector::new(0.07, 0.01, -0.003));
    let ratio = 3.24;
    let turned = ratio
        * (x - 0.01 * x.powi(2)
            - 0.05 / 6.0 * x.powi(3)
            - 0.3 / 24.0 * x.powi(4)
            - x.powi(5) / 120.0);
    let still = MachineSettings {
        helical_motion: 0.0,
        sliding_base: all.sliding_base + all.helical_motion * x,
        roll: Some(Roll::constant(turned / x)),
        ..all
    };
    let [a, b] = [all, still].map(|m| (m.motion(Hand::Right).pose(x) * place).coordinates);
    within("place, m", (a - b).norm(), 1e-16);
}

/// First derivative by fourth-order central differences.
fn difference(h: f64, f: impl Fn(f64) -> f64) -> f64 {
    (8.0 * (f(h) - f(-h)) - f(2.0 * h) + f(-2.0 * h)) / (12.0 * h)
}

/// Diagonal coefficient and both curvatures of the flanks of c12 from n and W, against differences of angles along the tooth line and the
/// profile: `χ = cos β dβ/dL + sin β/L` in the developed cone, `ζ = (cos ψ dψ/dδ + sin ψ cot δ)/L` on the sphere.
#[test]
fn exact_structure_elements() {
    let case = case("c12_nasa_cr191009_flanks");
    let (mut diagonals, mut lengthwise, mut profiles) = (0f64, 0f64, 0f64);
    for name in ["pinion_concave", "gear_convex"] {
        let flank = nasa_flank(&case, name);
        let middle = flank.middle().unwrap();
        for place in [[0.5, 0.5], [0.8, 0.7]] {
            let point = flank.point(place, middle).unwrap();
            let elements = StructureElements::of(&point, 0.0).unwrap();
            let (distance, delta) = (elements.cone_distance, elements.cone_angle);
            let at = |distance: f64, delta: f64| {
                let circle = [distance * delta.cos(), distance * delta.sin()];
                let at = flank.envelope.intersect_circle(circle, point.at).unwrap();
                flank.envelope.point(at).unwrap()
            };
            let along =
                |step: f64| StructureElements::of(&at(distance + step, delta), 0.0).unwrap();
            let h = 1e-3 * distance;
            let d_alpha = difference(h, |step| along(step).pressure_angle);
            let d_beta = difference(h, |step| along(step).spiral_angle);
            let beta = elements.spiral_angle;
            diagonals = diagonals.max((elements.diagonal / d_alpha - 1.0).abs());
            let chi = beta.cos() * d_beta + beta.sin() / distance;
            lengthwise = lengthwise.max((elements.lengthwise_curvature / chi - 1.0).abs());
            // Angle of the profile from the meridian of the sphere.
            let psi = |step: f64| {
                let p = at(distance, delta + step);
                let (r, n) = (p.point.coordinates, p.normal.components);
                let e3 = r.unit().unwrap();
                let e2 = Vector::Z.cross(r).unit().unwrap();
                let t = n.cross(e3).unit().unwrap();
                let up = t.dot(e2.cross(e3));
                f64::atan2(t.dot(e2) * up.signum(), up.abs())
            };
            let (p, d_psi) = (psi(0.0), difference(2e-4, psi));
            let zeta = (p.cos() * d_psi + p.sin() / delta.tan()) / distance;
            profiles = profiles.max((elements.profile_curvature / zeta - 1.0).abs());
        }
    }
    within("diagonal coefficient, relative", diagonals, 1e-8);
    within("lengthwise curvature, relative", lengthwise, 1e-8);
    within("profile curvature, relative", profiles, 1e-8);
}

/// The limit of the second kind that crosses a flank of a machine with a blank offset: a point of the cutter on one side of the curve touches
/// twice, before and after the curve's own turn of the cradle, a point on the other side never; the flank is whole on both sides.
#[test]
fn law_second_limit_parts_the_cutter() {
    let blank = Blank::of_one_apex([1.1441508, 1.2407025, 1.045147], 80.0, 15.4426);
    let cutter = Cutter::straight(Blade::Outside, 52.391, 0.2353354);
    let settings = MachineSettings {
        radial_distance: 77.4505,
        cradle_angle: 0.823852,
        blank_offset: -14.9355,
        sliding_base: -0.64881,
        helical_motion: 0.0,
        centre_to_back: -1.90209,
        machine_root_angle: 0.931477,
        tilt: 0.0482197,
        swivel: -1.05318,
        roll: Some(Roll::constant(1.1681106)),
    };
    let flank = BevelFlank::new(&cutter, &settings, Hand::Left, blank.section().unwrap());
    let grid = FlankGrid::of(&flank, 7, 9).unwrap();
    let limits = FlankLimits::of(&flank, &grid, |_| true);
    let [curve] = &limits.curves[1][..] else {
        panic!("{} curves", limits.curves[1].len());
    };
    // It runs from side to side of the flank without a gap.
    let on_side = |at: &[f64; 2]| at.iter().any(|x| *x == 0.0 || *x == 1.0);
    let (first, last) = (&curve[0], &curve[curve.len() - 1]);
    assert!(on_side(first) && on_side(last), "{first:?} to {last:?}");
    let gap = |p: &[[f64; 2]]| f64::hypot(p[1][0] - p[0][0], p[1][1] - p[0][1]);
    assert!(curve.windows(2).map(gap).fold(0.0, f64::max) < 0.03);
    let middle = flank.middle().unwrap();
    for at in curve {
        let p = flank.point(*at, middle).unwrap();
        assert!(p.second_order.undercut < 0.0);
        assert!(p.second_order.second_limit.abs() < 1e-12 * p.second_order.undercut.abs());
        let [u, theta, x] = p.at;
        let near = Envelope {
            range: [x - 0.2, x + 0.2],
            ..flank.envelope.clone()
        };
        // f is linear in u on a cone: the point of the blade at θ that touches at x + 0.03.
        let later = near.meeting([u, theta, x + 0.03]).unwrap();
        let step = later.f / later.gradient[0];
        let touching = near.motion_parameters([u - step, theta]);
        assert_eq!(touching.len(), 2, "{touching:?} about {x}");
        assert!(touching[0] < x && (touching[1] - x - 0.03).abs() < 1e-9);
        assert!(near.motion_parameters([u + step, theta]).is_empty());
    }
}
