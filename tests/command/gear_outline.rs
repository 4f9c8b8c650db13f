//! Outlines of gears as files: closed, at scale, with the area that the tooth thickness gives.

use std::collections::BTreeMap;

use geardyn::internals::base::flags::Flags;
use geardyn::internals::base::load;
use geardyn::internals::gear::cylindrical::pair::Pair;
use geardyn::internals::scene::gear_file;

use crate::support::command::{geardyn, put, refusal};
use crate::support::verification::within;

const RING: &str = "pair = { kind = \"cylindrical\", module = \"2 mm\", helix_angle = \"15 deg\" }\npinion = { teeth = 21, profile_shift = 0.3 }\ngear = { teeth = 60, internal = true }\n";

/// A file of outlines as it is written.
fn outline(file: &str, suffix: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("outline.{suffix}"));
    let done = geardyn(&["gear", file, "--quiet", "--outline", path.to_str().unwrap()]);
    assert!(done.status.success(), "{done:?}");
    std::fs::read_to_string(path).unwrap()
}

/// Polygons of a CSV file by member, mm, with the first point repeated.
fn polygons(text: &str) -> BTreeMap<String, Vec<[f64; 2]>> {
    let mut all: BTreeMap<String, Vec<[f64; 2]>> = BTreeMap::new();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("member,x [mm],y [mm]"));
    for line in lines {
        let [name, x, y] = line.split(',').collect::<Vec<_>>()[..] else {
            panic!("{line}")
        };
        let point = [x, y].map(|x| x.parse().unwrap());
        all.entry(name.to_string()).or_default().push(point);
    }
    all
}

/// Area inside a closed polygon, positive anticlockwise, about its first point.
fn area(points: &[[f64; 2]]) -> f64 {
    let [x0, y0] = points[0];
    let edge = |p: &[[f64; 2]]| (p[0][0] - x0) * (p[1][1] - y0) - (p[1][0] - x0) * (p[0][1] - y0);
    0.5 * points.windows(2).map(edge).sum::<f64>()
}

/// The area inside the outline is `π r_f² + ∫ 2 z ψ(r) r dr` from root to tip, of an internal gear `π r_f² − …`; tips lie on their circles, the
/// axes at the centre distance.
#[test]
fn exact_outlines_at_scale() {
    let folder = tempfile::tempdir().unwrap();
    let ring = put(folder.path(), "ring.toml", RING);
    for path in ["models/gears/fzg_c.toml", ring.to_str().unwrap()] {
        let source = load::load(path.as_ref()).unwrap();
        let file = gear_file::read(&source, &Flags::default()).unwrap();
        let pair = Pair::new(file.members, file.centre_distance).unwrap();
        let drawn = polygons(&outline(path, "csv"));
        for (k, name) in ["pinion", "gear"].into_iter().enumerate() {
            let (points, tooth) = (&drawn[name], &pair.outlines[k]);
            assert_eq!(points.first(), points.last());
            let sense = if tooth.internal { -1.0 } else { 1.0 };
            let axis = [0.0, sense * 1e3 * pair.centre_distance][k];
            let from_axis = |p: &[f64; 2]| (p[0] - axis).hypot(p[1]);
            let tip = points
                .iter()
                .map(from_axis)
                .fold(0.0, |tip: f64, r| match sense > 0.0 {
                    true => tip.max(r),
                    false => tip.max(1e6 - r),
                });
            let tip = if sense > 0.0 { tip } else { 1e6 - tip };
            let off = tip / (1e3 * tooth.tip_radius) - 1.0;
            within("tip circle, relative", off.abs(), 1e-9);
            // Simpson's rule in u, r = root + u² (tip − root): ψ rises like a root at the root circle.
            let (root, height) = (tooth.root_radius, tooth.tip_radius - tooth.root_radius);
            const PANELS: usize = 4000;
            let metal = |i: usize| {
                let u = i as f64 / PANELS as f64;
                let radius = root + u * u * height;
                let psi = tooth.half_angle(radius).unwrap_or(0.0);
                2.0 * f64::from(tooth.teeth) * psi * radius * 2.0 * u * height
            };
            let weight = |i: usize| match i {
                0 | PANELS => 1.0,
                _ if i % 2 == 1 => 4.0,
                _ => 2.0,
            };
            let sum: f64 = (0..=PANELS).map(|i| weight(i) * metal(i)).sum();
            let exact = std::f64::consts::PI * root * root + sum / (3.0 * PANELS as f64);
            let found = area(points);
            within("area, relative", (found / (1e6 * exact) - 1.0).abs(), 2e-5);
        }
    }
}

/// DXF holds a closed polyline on a layer of each member in millimetres, SVG a closed path of each at scale.
#[test]
fn law_formats_hold_the_same_outline() {
    let path = "models/gears/fzg_c.toml";
    let drawn = polygons(&outline(path, "csv"));
    let dxf = outline(path, "dxf");
    let lines: Vec<&str> = dxf.lines().collect();
    let groups: Vec<(&str, &str)> = lines.chunks(2).map(|pair| (pair[0], pair[1])).collect();
    assert_eq!(groups.last(), Some(&("0", "EOF")));
    let count = |code: &str, value: &str| groups.iter().filter(|g| **g == (code, value)).count();
    assert_eq!((count("0", "POLYLINE"), count("0", "SEQEND")), (2, 2));
    let points: usize = drawn.values().map(|points| points.len() - 1).sum();
    assert_eq!(count("0", "VERTEX"), points);
    for (k, group) in groups.iter().enumerate() {
        if *group == ("0", "POLYLINE") {
            assert_eq!(groups[k + 3], ("70", "1"), "closed");
        }
    }
    let first = groups.iter().position(|g| *g == ("0", "VERTEX")).unwrap();
    let [x, y] = [2, 3].map(|k| groups[first + k].1.parse::<f64>().unwrap());
    let [x0, y0] = drawn["pinion"][0];
    assert!((x - x0).abs() < 1e-8 && (y - y0).abs() < 1e-8);
    let svg = outline(path, "svg");
    assert_eq!(svg.matches("<path id=").count(), 2);
    assert_eq!(svg.matches("Z\"/>").count(), 2);
    let number = |from: &str, to: &str| -> f64 {
        let rest = svg.split(from).nth(1).unwrap();
        rest.split(to).next().unwrap().parse().unwrap()
    };
    let view: Vec<f64> = (svg
        .split("viewBox=\"")
        .nth(1)
        .unwrap()
        .split('"')
        .next()
        .unwrap())
    .split(' ')
    .map(|x| x.parse().unwrap())
    .collect();
    assert_eq!(
        (number("width=\"", "mm"), number("height=\"", "mm")),
        (view[2], view[3])
    );
    let (code, message) = refusal(&["gear", path, "--outline", "teeth.step"]);
    assert!(
        code == "usage" && message.contains("teeth.step"),
        "{message}"
    );
}
