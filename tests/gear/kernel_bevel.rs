//! The kernel of meshing on flanks cut by face mills: published machines, equations of meshing, curvature against differences.

use geardyn::internals::gear::kernel::envelope::Envelope;
use geardyn::internals::gear::kernel::jet::Surface;
use geardyn::internals::gear::kernel::law::Law;
use geardyn::internals::gear::kernel::motion::Motion;
use geardyn::internals::gear::kernel::pose::Pose;
use geardyn::internals::gear::kernel::tool::{Line, Tool};
use geardyn::internals::gear::kernel::twist::Twist;
use geardyn::internals::gear::kernel::vector::Vector;
use serde_json::Value;

use crate::verification::within;

#[derive(Debug, Clone, Copy, PartialEq)]
struct Cutter;
#[derive(Debug, Clone, Copy, PartialEq)]
struct Machine;
#[derive(Debug, Clone, Copy, PartialEq)]
struct Work;

type Flank = Envelope<Tool<Line, Cutter>, Work>;

/// A case of data/reference/gear.
fn case(name: &str) -> Value {
    let path = format!("data/reference/gear/{name}.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn vector(value: &Value) -> Vector {
    let x = value.as_array().unwrap();
    Vector::new(number(&x[0]), number(&x[1]), number(&x[2]))
}

/// The machine of NASA CR-191009 in the words of c12: cone about x, cradle about x, work axis z; a law is added to the turn of the work.
fn nasa_flank(settings: &Value, error: Option<Law>) -> Flank {
    let get = |name: &str| number(&settings[name]);
    let angle = |name: &str| get(name).to_radians();
    let (h, r, psi, s) = (get("h"), get("r"), angle("psi"), get("s"));
    let (em, lm, root, mu) = (get("em"), get("lm"), angle("deden"), angle("mu"));
    let (sin, cos) = (h * angle("q")).sin_cos();
    let blade = Line {
        point: Vector::new(r / psi.tan(), 0.0, 0.0),
        direction: Vector::new(-psi.cos(), 0.0, psi.sin()),
        range: [7.0, 11.0],
    };
    let tool = Tool::new(blade, Twist::turn(-Vector::X, Vector::ZERO));
    let mut motion = Motion::fixed(Pose::<Cutter, Cutter>::turned(Vector::X, h * angle("q")))
        .then(Pose::<Machine, Cutter>::shifted(Vector::new(0.0, -s * sin * 1.0, s * cos)))
        .joint(Twist::turn(Vector::X, Vector::ZERO), Law::linear(-h))
        .then(Pose::<Machine, Machine>::turned(Vector::Y, -root))
        .then(Pose::<Machine, Machine>::shifted(Vector::new(-lm * root.sin(), h * em, lm * root.cos())))
        .then(Pose::<Work, Machine>::turned(Vector::Y, mu))
        .joint(Twist::turn(Vector::Z, Vector::ZERO), Law::linear(-h / get("mcw")));
    if let Some(error) = error {
        motion = motion.joint(Twist::turn(Vector::Z, Vector::ZERO), error);
    }
    Envelope { surface: tool, motion, range: [-0.5, 0.5] }
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
            let at = flank.on_circle(nasa_section(&case, settings, face, height), seed).unwrap();
            let point = flank.point(at).unwrap();
            places = places.max((point.point.coordinates - vector(&node["xyz"])).norm());
            normals = normals.max(point.normal.components.cross(vector(&node["n"])).norm());
            for (found, key) in at.iter().zip(["u", "theta", "phi_c"]) {
                parameters = parameters.max((found - number(&node[key])).abs());
            }
        }
        within(&format!("{name}: points, in"), places, 1e-13);
        within(&format!("{name}: normals"), normals, 1e-13);
        let at = flank.on_circle(nasa_section(&case, settings, 0.0, 0.0), seed).unwrap();
        let published = vector(&settings["published_point_toe_root"]);
        let apart = (flank.point(at).unwrap().point.coordinates - published).norm();
        within(&format!("{name}: published point, in"), apart, 1.5e-7);
        println!("{parameters}");
    }
}
