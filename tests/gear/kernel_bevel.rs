//! The kernel of meshing on flanks cut by face mills: published machines, equations of meshing, curvature against differences.

use geardyn::internals::gear::kernel::envelope::Envelope;
use geardyn::internals::gear::kernel::jet::Surface;
use geardyn::internals::gear::kernel::law::Law;
use geardyn::internals::gear::kernel::motion::Motion;
use geardyn::internals::gear::kernel::pose::Pose;
use geardyn::internals::gear::kernel::tool::{Arc, Tool};
use geardyn::internals::gear::kernel::twist::Twist;
use geardyn::internals::gear::kernel::vector::Vector;
use serde_json::Value;

use crate::cases::{case, number, vector};
use crate::verification::within;

#[derive(Debug, Clone, Copy, PartialEq)]
struct Cutter;
#[derive(Debug, Clone, Copy, PartialEq)]
struct Machine;
#[derive(Debug, Clone, Copy, PartialEq)]
struct Work;

type Flank = Envelope<Tool<Arc, Cutter>, Work>;

/// The machine of NASA CR-191009 in the words of c12: cone about x, cradle about x, work axis z; a law is added to the turn of the work.
fn nasa_flank(settings: &Value, error: Option<Law>) -> Flank {
    let get = |name: &str| number(&settings[name]);
    let angle = |name: &str| get(name).to_radians();
    let (h, r, psi, s) = (get("h"), get("r"), angle("psi"), get("s"));
    let (em, lm, root, mu) = (get("em"), get("lm"), angle("deden"), angle("mu"));
    let (sin, cos) = (h * angle("q")).sin_cos();
    let blade = Arc::straight(
        Vector::new(r / psi.tan(), 0.0, 0.0),
        Vector::new(-psi.cos(), 0.0, psi.sin()),
        [7.0, 11.0],
    );
    let tool = Tool::new(blade, Twist::turn(-Vector::X, Vector::ZERO));
    let mut motion = Motion::fixed(Pose::<Cutter, Cutter>::turned(Vector::X, h * angle("q")))
        .then(Pose::<Machine, Cutter>::shifted(Vector::new(
            0.0,
            -s * sin,
            s * cos,
        )))
        .joint(Twist::turn(Vector::X, Vector::ZERO), Law::linear(-h))
        .then(Pose::<Machine, Machine>::turned(Vector::Y, -root))
        .then(Pose::<Machine, Machine>::shifted(Vector::new(
            -lm * root.sin(),
            h * em,
            lm * root.cos(),
        )))
        .then(Pose::<Work, Machine>::turned(Vector::Y, mu))
        .joint(
            Twist::turn(Vector::Z, Vector::ZERO),
            Law::linear(-h / get("mcw")),
        );
    if let Some(error) = error {
        motion = motion.joint(Twist::turn(Vector::Z, Vector::ZERO), error);
    }
    Envelope {
        surface: tool,
        motion,
        range: [-0.5, 0.5],
    }
}

/// z and radius at a share of face and height of a blank of c12.
fn nasa_section(case: &Value, settings: &Value, face: f64, height: f64) -> [f64; 2] {
    let get = |name: &str| number(&settings[name]);
    let common = |name: &str| number(&case["common_gear"][name]);
    let (root, addendum) = (get("deden").to_radians(), get("addan").to_radians());
    let (cl, width) = (get("cl"), common("face_width"));
    let g = get("mu").to_radians() - root;
    let along = (common("rl_mean_cone") - 0.5 * width) * root.cos() + face * width;
    let z = along * g.cos() - cl * g.sin();
    let r = z * g.tan() + cl / g.cos();
    let depth = z * (addendum + root).tan() / g.cos() - cl;
    [z - height * depth * g.sin(), r + height * depth * g.cos()]
}

/// Flank points and normals of a spiral bevel pair on its blank.
/// Source: NASA CR-191009 (Bibel, Reddy and Kumar 1994), settings pp. 4–6, points pp. 9–11; grids computed by two routes, data/reference/gear/c12_nasa_cr191009_flanks.json.
#[test]
fn ref_nasa_flanks() {
    let case = case("c12_nasa_cr191009_flanks");
    for name in ["pinion_concave", "gear_convex"] {
        let settings = &case["flanks"][name];
        let flank = nasa_flank(settings, None);
        let seed = vector(&settings["seed_u_theta_phi"]);
        let seed = [seed.x, seed.y.to_radians(), seed.z.to_radians()];
        let (mut places, mut normals, mut parameters) = (0f64, 0f64, 0f64);
        for node in case["grid_computed_here"][name].as_array().unwrap() {
            let (face, height) = (number(&node["face"]), number(&node["height"]));
            let at = flank
                .intersect_circle(nasa_section(&case, settings, face, height), seed)
                .unwrap();
            let point = flank.point(at).unwrap();
            places = places.max((point.point.coordinates - vector(&node["xyz"])).norm());
            normals = normals.max(point.normal.components.cross(vector(&node["n"])).norm());
            for (found, key) in at.iter().zip(["u", "theta", "phi_c"]) {
                parameters = parameters.max((found - number(&node[key])).abs());
            }
        }
        within(&format!("{name}: points, in"), places, 1e-13);
        within(&format!("{name}: normals"), normals, 1e-13);
        let at = flank
            .intersect_circle(nasa_section(&case, settings, 0.0, 0.0), seed)
            .unwrap();
        let published = vector(&settings["published_point_toe_root"]);
        let apart = (flank.point(at).unwrap().point.coordinates - published).norm();
        within(&format!("{name}: published point, in"), apart, 2e-7);
        within(&format!("{name}: parameters"), parameters, 1e-13);
    }
}

/// A generator in the words of Litvin: cutter axis z with the tip plane at z = 0, work axis z.
struct Generator {
    /// 1 for the inside blade, −1 for the outside blade.
    side: f64,
    point_radius: f64,
    blade_angle: f64,
    radial_distance: f64,
    cradle_angle: f64,
    blank_offset: f64,
    sliding_base: f64,
    centre_to_back: f64,
    root_angle: f64,
    tilt: f64,
    swivel: f64,
    /// Work over cradle, and the coefficients of its modification.
    roll: [f64; 3],
    /// −1 for the other hand.
    hand: f64,
}

impl Generator {
    /// Ordinary settings of a face-mill generator, moved by ten random numbers in (−1, 1).
    fn random(side: f64) -> Generator {
        let around = |middle: f64, by: f64| middle + by * (2.0 * fastrand::f64() - 1.0);
        Generator {
            side,
            point_radius: around(95.0, 10.0),
            blade_angle: around(0.35, 0.05),
            radial_distance: around(95.0, 10.0),
            cradle_angle: around(-0.95, 0.1),
            blank_offset: around(0.0, 5.0),
            sliding_base: around(0.0, 2.0),
            centre_to_back: around(0.0, 2.0),
            root_angle: around(0.9, 0.1),
            tilt: 0.0,
            swivel: 0.0,
            roll: [around(1.25, 0.05), 0.0, 0.0],
            hand: 1.0,
        }
    }

    fn flank(&self) -> Flank {
        let (sin, cos) = self.blade_angle.sin_cos();
        // Inside: n = (cos a, 0, −sin a) at θ = 0; outside: (−cos a, 0, −sin a).
        let blade = Arc::straight(
            self.point_radius * Vector::X,
            Vector::new(-self.side * sin, 0.0, -cos),
            [-5.0, 20.0],
        );
        let tool = Tool::new(blade, Twist::turn(Vector::Z, Vector::ZERO));
        let tool = if self.side > 0.0 {
            tool
        } else {
            tool.flipped()
        };
        let (sin, cos) = (self.hand * self.cradle_angle).sin_cos();
        let centre = Vector::new(cos, sin, 0.0) * self.radial_distance;
        let offsets = Vector::new(0.0, self.hand * self.blank_offset, -self.sliding_base);
        let [ratio, c, d] = self.roll;
        let turn = Twist::turn(Vector::Z, Vector::ZERO);
        let motion = Motion::fixed(Pose::<Cutter, Cutter>::turned(Vector::Z, -self.swivel))
            .then(Pose::<Cutter, Cutter>::turned(Vector::Y, self.tilt))
            .then(Pose::<Cutter, Cutter>::turned(Vector::Z, self.swivel))
            .then(Pose::<Machine, Cutter>::shifted(centre))
            .joint(turn, Law::linear(self.hand))
            .then(Pose::<Machine, Machine>::shifted(offsets))
            .then(Pose::<Work, Machine>::turned(
                Vector::Y,
                self.root_angle - std::f64::consts::FRAC_PI_2,
            ))
            .then(Pose::<Work, Work>::shifted(Vector::new(
                0.0,
                0.0,
                -self.centre_to_back,
            )))
            .joint(
                turn,
                Law::Polynomial([
                    0.0,
                    -self.hand * ratio,
                    self.hand * ratio * c,
                    self.hand * ratio * d,
                    0.0,
                    0.0,
                ]),
            );
        Envelope {
            surface: tool,
            motion,
            range: [-0.5, 0.5],
        }
    }
}

/// Flank points, normals and blade coordinates of a face-milled gear 38/51 of the other hand; the case lists (z, y, −x).
/// Source: settings of haomjc/SpyGO 417ac9a, points by its closed form, data/reference/gear/c16_gear_38_51_flank.json.
#[test]
fn ref_gear_38_51() {
    let case = case("c16_gear_38_51_flank");
    let get = |name: &str| number(&case["inputs"][name]);
    let pitch_angle = f64::atan2(51.0, 38.0);
    let generator = Generator {
        side: 1.0,
        point_radius: get("rc_inner_side"),
        blade_angle: get("alpha_inner").to_radians(),
        radial_distance: get("Sr"),
        cradle_angle: get("q2_deg").to_radians(),
        blank_offset: get("Em"),
        sliding_base: get("XB"),
        centre_to_back: get("XD"),
        root_angle: pitch_angle - get("dedendum_angle").to_radians(),
        tilt: 0.0,
        swivel: 0.0,
        roll: [1.0 / get("mr_cradle_over_work"), 0.0, 0.0],
        hand: -1.0,
    };
    let flank = generator.flank();
    let (mut places, mut normals, mut blades, mut start) = (0f64, 0f64, 0f64, [5.0, 5.3, 0.0]);
    for node in case["points"].as_array().unwrap() {
        let (xyz, n) = (vector(&node["xyz"]), vector(&node["n"]));
        let section = [xyz.x, f64::hypot(xyz.y, xyz.z)];
        let at = flank.intersect_circle(section, start).unwrap();
        let point = flank.point(at).unwrap();
        let listed = |v: Vector| Vector::new(v.z, v.y, -v.x);
        places = places.max((listed(point.point.coordinates) - xyz).norm());
        normals = normals.max(listed(point.normal.components).cross(n).norm());
        blades = blades.max((at[0] - number(&node["s"])).abs());
        start = at;
    }
    within("points, mm", places, 1e-12);
    within("normals", normals, 1e-14);
    within("blade coordinate, mm", blades, 1e-12);
}

/// The elimination of the blade coordinate against the closed equation of meshing of a straight blade, random settings, both blades.
#[test]
fn exact_equation_of_meshing_of_a_generator() {
    fastrand::seed(43);
    let mut worst = 0f64;
    for i in 0..100 {
        let sg = if i % 2 == 0 { 1.0 } else { -1.0 };
        let g = Generator::random(sg);
        let (phi, theta) = (0.3 * (fastrand::f64() - 0.5), 5.3 + 0.2 * fastrand::f64());
        let (sin_a, cos_a) = g.blade_angle.sin_cos();
        let (sin_g, cos_g) = g.root_angle.sin_cos();
        let tau = phi + theta;
        let q = g.cradle_angle;
        let s = g.radial_distance * (1.0 / g.roll[0] - sin_g) * cos_a * (theta - q).sin()
            / (cos_g * tau.sin())
            + sg * (g.radial_distance * (phi + q).sin() + g.blank_offset) * sin_a / tau.sin()
            + g.blank_offset * (sin_g / cos_g) * cos_a / tau.tan()
            + sg * g.point_radius * sin_a
            - g.sliding_base * cos_a;
        let mut flank = g.flank();
        flank.surface.curve.range = [-200.0, 200.0];
        let found = flank.surface_parameter([phi, theta]).unwrap();
        worst = worst.max((found - s).abs() / g.point_radius);
    }
    within(
        "blade coordinate, relative to the point radius",
        worst,
        1e-13,
    );
}

/// The elimination against the handbook's equation for generation by a flat crown gear, as rederived with its offsets.
#[test]
fn exact_equation_of_meshing_of_a_flat_crown_gear() {
    fastrand::seed(47);
    let mut worst = 0f64;
    for _ in 0..100 {
        let around = |middle: f64, by: f64| middle + by * (2.0 * fastrand::f64() - 1.0);
        let (r, alpha, distance) = (around(95.0, 10.0), around(0.35, 0.05), around(90.0, 10.0));
        let (psi, root) = (around(-0.9, 0.2), around(0.9, 0.1));
        let (dl, de, db) = (around(0.0, 3.0), around(0.0, 5.0), around(0.0, 2.0));
        let (i0, theta) = (around(0.8, 0.1), around(2.2, 0.1));
        // The cone of c12 about x with the apex towards −x; at the cradle angle 0 the blade's angle θ − ψ counts from the crown's own line.
        let blade = Arc::straight(
            Vector::new(-r / alpha.tan() - db, 0.0, 0.0),
            Vector::new(alpha.cos(), 0.0, alpha.sin()),
            [-500.0, 1000.0],
        );
        let tool = Tool::<_, Cutter>::new(blade, Twist::turn(-Vector::X, Vector::ZERO));
        let motion = Motion::fixed(Pose::<Cutter, Cutter>::turned(Vector::X, -psi))
            .then(Pose::<Machine, Cutter>::shifted(Vector::new(
                0.0,
                distance * psi.sin(),
                distance * psi.cos(),
            )))
            .joint(Twist::turn(Vector::X, Vector::ZERO), Law::linear(-1.0))
            .then(Pose::<Machine, Machine>::shifted(Vector::new(0.0, -de, dl)))
            .then(Pose::<Work, Machine>::turned(Vector::Y, root))
            .joint(Twist::turn(Vector::Z, Vector::ZERO), Law::linear(-1.0 / i0));
        let envelope = Envelope {
            surface: tool,
            motion,
            range: [-0.5, 0.5],
        };
        let (sin_a, cos_a) = alpha.sin_cos();
        let (sin_g, cos_g) = root.sin_cos();
        let rest = distance
            * (cos_a * (theta - psi).sin() * (sin_g - i0) + sin_a * cos_g * psi.sin())
            + de * (cos_a * theta.cos() * sin_g - sin_a * cos_g)
            + dl * cos_a * theta.sin() * sin_g;
        let v = r * cos_a / alpha.tan() + db * cos_a - rest / (theta.sin() * cos_g);
        let found = envelope.surface_parameter([0.0, theta - psi]).unwrap();
        worst = worst.max((found - v).abs() / r);
    }
    within(
        "blade coordinate, relative to the cutter radius",
        worst,
        1e-12,
    );
}

/// First derivative by fourth-order central differences.
fn difference(h: f64, f: impl Fn(f64) -> Vector) -> Vector {
    ((f(h) - f(-h)) * 8.0 - (f(2.0 * h) - f(-2.0 * h))) * (1.0 / (12.0 * h))
}

/// Curvature of flanks cut with tilt, swivel, offsets and modified roll against fourth-order differences of points and normals, and the
/// gradient of f against those of f.
#[test]
fn exact_curvature_of_bevel_flanks() {
    fastrand::seed(51);
    let (mut curvatures, mut gradients, mut jets) = (0f64, 0f64, 0f64);
    for i in 0..20 {
        let around = |by: f64| by * (2.0 * fastrand::f64() - 1.0);
        let (tilt, swivel) = (around(0.1), around(3.0));
        let [c2, d6] = [around(0.05), around(0.1)];
        let mut g = Generator::random(if i % 2 == 0 { 1.0 } else { -1.0 });
        (g.tilt, g.swivel, g.roll) = (tilt, swivel, [g.roll[0], c2, d6]);
        let mut flank = g.flank();
        flank.surface.curve.range = [-100.0, 100.0];
        let (x, theta) = (0.1, 5.4);
        let point = flank.flank([x, theta]).unwrap();
        let [u, ..] = point.at;
        let meeting = flank.meeting(point.at).unwrap();
        let f = |du: f64, dt: f64, dx: f64| {
            let m = flank.meeting([u + du, theta + dt, x + dx]).unwrap();
            m.f * Vector::X
        };
        let numeric = [
            difference(1e-2, |h| f(h, 0.0, 0.0)).x,
            difference(1e-3, |h| f(0.0, h, 0.0)).x,
            difference(1e-3, |h| f(0.0, 0.0, h)).x,
        ];
        let size = meeting.gradient.iter().fold(0f64, |m, g| m.max(g.abs()));
        for (a, b) in numeric.iter().zip(meeting.gradient) {
            gradients = gradients.max((a - b).abs() / size);
        }
        let jet = flank.jet([x, theta]).unwrap();
        let w = point.second_order.envelope().unwrap();
        let scale = w.principal().iter().fold(0f64, |m, k| m.max(k.0.abs()));
        for (k, direction) in [[1.0, 0.0], [0.0, 1.0]].iter().enumerate() {
            let at = |h: f64| {
                flank
                    .jet([x + h * direction[0], theta + h * direction[1]])
                    .unwrap()
            };
            let (dr, dn) = (difference(2e-3, |h| at(h).r), difference(2e-3, |h| at(h).n));
            jets = jets.max((dr - jet.dr[k]).norm() / jet.dr[k].norm());
            let [e1, e2] = w.tangents;
            for e in [e1, e2] {
                let error = (dn.dot(e) + w.between(dr, e)).abs();
                curvatures = curvatures.max(error / (scale * dr.norm()));
            }
        }
    }
    within("gradient of f, relative", gradients, 1e-9);
    within("tangents of the flank, relative", jets, 1e-9);
    within("curvature, relative", curvatures, 1e-9);
}

/// Deviation of a flank from an error of the turn of the work: first order by the envelope theorem, exact along the normal's ray.
/// Source: two computations of the changed flank, data/reference/gear/c22_machine_te_to_flank_error.json.
#[test]
fn ref_flank_from_an_error_of_the_roll() {
    const MICROMETRES: f64 = 25_400.0;
    let nodes = case("c12_nasa_cr191009_flanks");
    let settings = &nodes["flanks"]["pinion_concave"];
    let ideal = nasa_flank(settings, None);
    let seed = vector(&settings["seed_u_theta_phi"]);
    let seed = [seed.x, seed.y.to_radians(), seed.z.to_radians()];
    let (mut first, mut exact) = (0f64, 0f64);
    for row in case("c22_machine_te_to_flank_error")["rows"]
        .as_array()
        .unwrap()
    {
        let row: Vec<f64> = row.as_array().unwrap().iter().map(number).collect();
        let (amplitude, order) = ((row[0] / 3600.0).to_radians(), row[1]);
        let law = Law::Cosine {
            amplitude,
            order,
            phase: 0.3,
        };
        let at = ideal
            .intersect_circle(nasa_section(&nodes, settings, row[2], row[3]), seed)
            .unwrap();
        assert!((at[2] - row[4]).abs() < 6e-6, "{at:?} {row:?}");
        let point = ideal.point(at).unwrap();
        let arm = point
            .normal
            .components
            .dot(Vector::Z.cross(point.point.coordinates));
        let turn = law.at(at[2])[0];
        first = first.max((arm * turn * MICROMETRES - row[5]).abs());
        let changed = nasa_flank(settings, Some(law));
        let (_, distance) = changed
            .intersect_ray(point.point, point.normal, at)
            .unwrap();
        exact = exact.max((distance * MICROMETRES - row[6]).abs());
    }
    within("first order, µm", first, 5.1e-5);
    within("exact, µm", exact, 5.1e-5);
}

/// A formate flank is its cutter's cone where it stands: points of the blank lie on the cone, curvature is the cone's.
#[test]
fn exact_formate() {
    let case = case("c12_nasa_cr191009_flanks");
    let settings = &case["flanks"]["gear_convex"];
    let generated = nasa_flank(settings, None);
    let pose = generated.motion.pose(0.0);
    let formate = Envelope {
        surface: generated.surface,
        motion: Motion::fixed(pose),
        range: [0.0, 0.0],
    };
    assert_eq!(formate.surface_parameter([0.0, 4.1]), None);
    let [apex, axis] = [Vector::X * (2.9675 / 22f64.to_radians().tan()), Vector::X];
    let (mut off_cone, mut curvature, mut normals) = (0f64, 0f64, 0f64);
    for face in [0.1, 0.5, 0.9] {
        for height in [0.1, 0.5, 0.9] {
            let section = nasa_section(&case, settings, face, height);
            let at = formate.intersect_circle(section, [8.0, 4.1, 0.0]).unwrap();
            let point = formate.point(at).unwrap();
            let r = point.point.coordinates;
            within(
                "circle of the blank, in",
                (f64::hypot(r.x, r.y) - section[1])
                    .abs()
                    .max((r.z - section[0]).abs()),
                1e-14,
            );
            let in_cutter = (pose.inverse() * point.point).coordinates - apex;
            let angle = (in_cutter.cross(axis).norm()).atan2(in_cutter.dot(-axis));
            off_cone = off_cone.max((angle - 22f64.to_radians()).abs() * in_cutter.norm());
            // The normal of a cone makes the complement of its angle with the axis.
            let normal = (pose.inverse() * point.normal).components;
            normals = normals.max((normal.dot(axis).abs() - 22f64.to_radians().sin()).abs());
            let k = point.second_order.envelope().unwrap().principal();
            let expected = 1.0 / (in_cutter.norm() * 22f64.to_radians().tan());
            let bent = k[0].0.abs().max(k[1].0.abs());
            curvature = curvature.max((bent - expected).abs());
        }
    }
    within("off the cone, in", off_cone, 1e-14);
    within("normal to the axis", normals, 1e-15);
    within("curvature, 1/in", curvature, 1e-14);
}
