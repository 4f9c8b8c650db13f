//! Outlines of gears cut by a rack: circular gears in closed form, elliptic gears by their laws, a cutter that is never inside.

use std::f64::consts::{FRAC_PI_2, PI};

use geardyn::internals::gear::plane::centrodes::{Centrodes, Mate, Member};
use geardyn::internals::gear::plane::conjugate::conjugate;
use geardyn::internals::gear::plane::law_of_gearing::check_gearing;
use geardyn::internals::gear::plane::profile::Shape;
use geardyn::internals::gear::plane::rack_cut::{Outline, OutlinePart, cut_outline};
use geardyn::internals::gear::plane::rack_cutter::RackCutter;
use geardyn::internals::gear::plane::ratio_law::RatioLaw;
use geardyn::internals::gear::plane::rolling::{Centrode, Rolling};
use geardyn::internals::numeric::Complex;

use crate::verification::within;

fn circular(teeth: u32) -> Centrodes {
    // Module 1 mm, ratio 2.
    let r1 = 0.5e-3 * f64::from(teeth);
    Centrodes::of_gears(&RatioLaw::constant(2.0).unwrap(), 3.0 * r1, Mate::External).unwrap()
}

fn elliptic() -> Centrodes {
    Centrodes::of_gears(&RatioLaw::elliptic(0.3).unwrap(), 0.1, Mate::External).unwrap()
}

/// Whether a closed polygon crosses itself.
fn is_simple(points: &[Complex]) -> bool {
    let n = points.len();
    let cross = |a: Complex, b: Complex| (a.conj() * b).im;
    for i in 0..n {
        let (p, d) = (points[i], points[(i + 1) % n] - points[i]);
        for j in i + 2..n {
            if i == 0 && j == n - 1 {
                continue;
            }
            let (q, e) = (points[j], points[(j + 1) % n] - points[j]);
            if (q - p).norm() > 4.0 * (d.norm() + e.norm()) {
                continue;
            }
            let (x, y) = (cross(q - p, e) / cross(d, e), cross(q - p, d) / cross(d, e));
            if (0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y) {
                return false;
            }
        }
    }
    true
}

fn positions(outline: &Outline) -> Vec<Complex> {
    outline.points.iter().map(|p| p.point).collect()
}

/// A circular gear: flanks are involutes of the base circle, roots and tips circles, the chordal thickness at the pitch circle is half a pitch.
#[test]
fn exact_circular_gear() {
    for member in [Member::First, Member::Second] {
        let pair = circular(24);
        let teeth = if member == Member::First { 24 } else { 48 };
        let outline = cut_outline(&pair, member, teeth, &RackCutter::default(), 12, 0.0).unwrap();
        let module = 1e-3;
        within("module", (outline.module / module - 1.0).abs(), 1e-13);
        assert!(outline.undercut_spaces.is_empty());
        let pitch = 0.5 * module * f64::from(teeth);
        let base = pitch * 20_f64.to_radians().cos();
        let sweep = |z: Complex| {
            let tan = ((z.norm() / base).powi(2) - 1.0).sqrt();
            tan - tan.atan()
        };
        for p in &outline.points {
            let r = p.point.norm();
            match p.part {
                OutlinePart::Tip => within("tip circle", (r / (pitch + module) - 1.0).abs(), 1e-13),
                OutlinePart::Root => within(
                    "root circle",
                    (r / (pitch - 1.25 * module) - 1.0).abs(),
                    1e-13,
                ),
                _ => {}
            }
        }
        for space in 0..teeth as usize {
            let of: Vec<&_> = outline
                .points
                .iter()
                .filter(|p| p.space == space && p.part == OutlinePart::Flank)
                .collect();
            // Two flanks of a space: azimuths mirror each other, and differ by the involute function.
            let half = of.len() / 2;
            let spread = of[half - 1].point.norm() - of[0].point.norm();
            assert!(spread < -1.5 * module, "{spread}");
            // Root form of a rack-cut gear: where the straight flank of the rack ends.
            let (alpha, straight) = (
                20_f64.to_radians(),
                1.25 - 0.38 * (1.0 - 20_f64.to_radians().sin()),
            );
            let form = (pitch * alpha.sin() - straight * module / alpha.sin()).hypot(base);
            within(
                "root form radius",
                (of[half - 1].point.norm() / form - 1.0).abs(),
                1e-13,
            );
            let at_pitch = sweep(Complex::new(pitch, 0.0));
            for (a, b) in of[..half].iter().zip(of[half..].iter().rev()) {
                let width = (b.point / a.point).arg();
                let exact = PI / f64::from(teeth) + 2.0 * (sweep(a.point) - at_pitch);
                within("space width", (width.abs() - exact).abs(), 1e-13);
                within(
                    "same radius",
                    (a.point.norm() / b.point.norm() - 1.0).abs(),
                    1e-13,
                );
            }
        }
        assert!(is_simple(&positions(&outline)));
    }
}

/// Least depth of the work's points inside the rack over the rolled arc: a rack that only touches leaves none inside, and touches each.
fn penetration(
    pair: &Centrodes,
    member: Member,
    cutter: &RackCutter,
    outline: &Outline,
    space: usize,
    first: f64,
) -> [f64; 2] {
    let side = if member == Member::First { 1.0 } else { -1.0 };
    let work = Centrode::Member {
        pair: pair.clone(),
        member,
    };
    let m = outline.module;
    let (alpha, h, rho) = (
        cutter.pressure_angle,
        cutter.dedendum * m,
        cutter.tip_radius * m,
    );
    let middle = first + space as f64 * PI * m;
    let centre = [
        h - rho,
        0.25 * PI * m - (h - rho * (1.0 - alpha.sin())) * alpha.tan() - rho * alpha.cos(),
    ];
    // Signed distance into the rack's tooth: positive inside.
    let inside = |t: f64, y: f64| {
        let y = y.abs();
        let flank = (0.25 * PI * m - t * alpha.tan() - y) * alpha.cos();
        let tip = h - t;
        let corner = rho - (t - centre[0]).hypot(y - centre[1]);
        let (dt, dy) = (t - centre[0], y - centre[1]);
        // The rounded corner holds where the point lies in the wedge of its normals.
        let is_corner = dy > 0.0 && dt > dy * alpha.tan();
        if is_corner { corner } else { flank.min(tip) }
    };
    let states: Vec<_> = (-900..=900)
        .map(|i| {
            let arc = middle + 4.5 * m * f64::from(i) / 900.0;
            (arc, work.at(arc).unwrap())
        })
        .collect();
    let (mut deepest, mut farthest) = (f64::MIN, f64::MAX);
    let of_space = outline
        .points
        .iter()
        .filter(|p| p.space == space && p.part != OutlinePart::Tip);
    for p in of_space {
        let most = states
            .iter()
            .map(|(arc, at)| {
                let local = (p.point - at.point) * at.tangent.conj();
                // x along the tangent, the left is y > 0: depth towards the body.
                inside(side * local.im, arc + local.re - middle)
            })
            .fold(f64::MIN, f64::max);
        deepest = deepest.max(most);
        farthest = farthest.min(most);
    }
    [deepest / m, farthest / m]
}

/// No point of an outline is ever inside the rack, and every point is touched: circular gears with and without undercut, both elliptic gears.
#[test]
fn law_rack_touches_and_never_enters() {
    let sharp = RackCutter {
        tip_radius: 0.1,
        ..RackCutter::default()
    };
    for (pair, member, teeth, cutter, undercut) in [
        (
            circular(24),
            Member::First,
            24,
            RackCutter::default(),
            false,
        ),
        (circular(9), Member::First, 9, RackCutter::default(), true),
        (circular(9), Member::First, 9, sharp, true),
        (elliptic(), Member::First, 31, RackCutter::default(), false),
        (elliptic(), Member::Second, 31, RackCutter::default(), false),
        (elliptic(), Member::First, 15, sharp, true),
    ] {
        let outline = cut_outline(&pair, member, teeth, &cutter, 16, 0.001).unwrap();
        assert_eq!(
            !outline.undercut_spaces.is_empty(),
            undercut,
            "{teeth}: {:?}",
            outline.undercut_spaces
        );
        for space in (0..teeth as usize).step_by(3) {
            let [deepest, farthest] = penetration(&pair, member, &cutter, &outline, space, 0.001);
            assert!(
                deepest < 1e-9,
                "{teeth} teeth, space {space}: {deepest} modules inside"
            );
            // 0.005 modules between positions of the rack: the second order of the touch.
            assert!(
                farthest > -3e-4,
                "{teeth} teeth, space {space}: {farthest} modules away"
            );
        }
        assert!(is_simple(&positions(&outline)));
    }
}

/// Teeth of an elliptic gear are equally spaced along the arc: flanks cross the pitch curve every half pitch, roots and tips lie at their
/// depths.
#[test]
fn law_teeth_equally_spaced_along_the_arc() {
    for member in [Member::First, Member::Second] {
        let pair = elliptic();
        let outline = cut_outline(&pair, member, 31, &RackCutter::default(), 10, 0.0).unwrap();
        let work = Centrode::Member {
            pair: pair.clone(),
            member,
        };
        let turn = pair.closed_arc(member).unwrap();
        let side = if member == Member::First { 1.0 } else { -1.0 };
        let table: Vec<(f64, Complex)> = (0..1000)
            .map(|i| turn * (f64::from(i) / 1000.0 - 0.02))
            .map(|arc| (arc, work.at(arc).unwrap().point))
            .collect();
        let foot = |z: Complex| {
            let near = table
                .iter()
                .min_by(|a, b| (a.1 - z).norm().total_cmp(&(b.1 - z).norm()))
                .unwrap();
            let mut arc = near.0;
            for _ in 0..6 {
                let at = work.at(arc).unwrap();
                let local = (z - at.point) * at.tangent.conj();
                arc += local.re / (1.0 - at.curvature * local.im);
            }
            let at = work.at(arc).unwrap();
            (-side * ((z - at.point) * at.tangent.conj()).im, arc)
        };
        let m = outline.module;
        for p in outline.points.iter().step_by(7) {
            let (height, _) = foot(p.point);
            match p.part {
                OutlinePart::Root => within("root depth", (height / m + 1.25).abs(), 1e-12),
                OutlinePart::Tip => within("tip height", (height / m - 1.0).abs(), 1e-12),
                _ => assert!(height <= m * (1.0 + 1e-9) && height >= -m * 1.2500001),
            }
        }
        // Crossings of the flanks with the pitch curve: interpolate height over arc in the steps that change its sign.
        let mut crossings = vec![];
        for pair_of in outline.points.windows(2) {
            if pair_of[0].part == OutlinePart::Flank
                && pair_of[1].part == OutlinePart::Flank
                && pair_of[0].space == pair_of[1].space
            {
                let (a, b) = (foot(pair_of[0].point), foot(pair_of[1].point));
                if a.0 * b.0 < 0.0 && (a.1 - b.1).abs() < m {
                    crossings.push(a.1 + (b.1 - a.1) * a.0 / (a.0 - b.0));
                }
            }
        }
        assert_eq!(crossings.len(), 62);
        for pair_of in crossings.windows(2) {
            let step = (pair_of[1] - pair_of[0]).rem_euclid(turn);
            within("half pitch", (step / (0.5 * PI * m) - 1.0).abs(), 5e-3);
        }
    }
}

/// The flanks one rack makes on both gears of an elliptic pair mesh at the law of the pair.
#[test]
fn exact_rack_made_elliptic_pair() {
    let pair = elliptic();
    let alpha = 20_f64.to_radians();
    let body = |member| Centrode::Member {
        pair: pair.clone(),
        member,
    };
    for start in [0.02, 0.09, 0.16] {
        let lean = Complex::new(1.0, alpha.tan()) * 0.0025;
        let middle = Complex::new(0.0, start);
        let flank = Shape::line(middle - lean, middle + lean).unwrap();
        let on = |member| {
            let rolling = Rolling {
                tool: Centrode::Line,
                work: body(member),
            };
            conjugate(&rolling, flank.clone(), 40).unwrap()
        };
        let (gear_1, gear_2) = (on(Member::First), on(Member::Second));
        let angles: Vec<f64> = gear_1.contacts()[4..36]
            .iter()
            .map(|c| pair.angle_at_arc(c.arc).unwrap())
            .collect();
        for check in check_gearing(&pair, &gear_1, &gear_2, &angles).unwrap() {
            within("error of an elliptic pair", check.error.abs(), 1e-13);
            within(
                "miss of the pitch point",
                check.pitch_point_deviation.abs() / 0.1,
                1e-10,
            );
        }
    }
}

/// Distance from a point to a closed polygon, positive inside.
fn depth_inside(polygon: &[Complex], z: Complex) -> f64 {
    let mut winding = 0.0;
    let mut least = f64::MAX;
    for (i, p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        winding += ((q - z) / (p - z)).arg();
        let (d, e) = (q - p, z - p);
        let share = ((e * d.conj()).re / d.norm_sqr()).clamp(0.0, 1.0);
        least = least.min((e - d * share).norm());
    }
    if winding.abs() > PI { least } else { -least }
}

/// Whole outlines of both elliptic gears in mesh: the mate's teeth fill the spaces without entering, at every position.
#[test]
fn law_outlines_mesh_without_backlash() {
    let pair = elliptic();
    let half = 0.5 * pair.closed_arc(Member::First).unwrap() / 31.0;
    let cutter = RackCutter::default();
    let gear_1 = cut_outline(&pair, Member::First, 31, &cutter, 24, 0.0).unwrap();
    let gear_2 = cut_outline(&pair, Member::Second, 31, &cutter, 24, half).unwrap();
    let m = gear_1.module;
    for i in 0..12 {
        let state = pair.at(0.53 * f64::from(i)).unwrap();
        let placed = |member, outline: &Outline| {
            let (origin, angle) = pair.pose(member, &state);
            let at_pitch = |z: &Complex| (z - state.radius_1).norm() < 3.0 * m;
            let fixed = positions(outline)
                .into_iter()
                .map(|z| origin + z * Complex::cis(angle));
            (
                fixed.clone().collect::<Vec<_>>(),
                fixed.filter(at_pitch).collect::<Vec<_>>(),
            )
        };
        let (body_1, near_1) = placed(Member::First, &gear_1);
        let (body_2, near_2) = placed(Member::Second, &gear_2);
        let depths: Vec<f64> = near_2
            .iter()
            .map(|z| depth_inside(&body_1, *z) / m)
            .chain(near_1.iter().map(|z| depth_inside(&body_2, *z) / m))
            .collect();
        let deepest = depths.iter().fold(f64::MIN, |most, d| most.max(*d));
        assert!(deepest < 1e-3, "position {i}: {deepest} modules inside");
        // Both flanks touch: the sag of chords is below a thousandth of a module.
        assert!(
            depths.iter().filter(|d| d.abs() < 2e-3).count() >= 2,
            "position {i}"
        );
    }
}

/// Refusals name the limit and the nearest value that works.
#[test]
fn refuses_gears_a_rack_cannot_cut() {
    let cut = |pair: &Centrodes, teeth: u32, cutter: RackCutter| {
        cut_outline(pair, Member::First, teeth, &cutter, 8, 0.0)
            .map(|_| ())
            .unwrap_err()
            .to_string()
    };
    let ok = |pair: &Centrodes, teeth: u32, cutter: RackCutter| {
        cut_outline(pair, Member::First, teeth, &cutter, 8, 0.0).is_ok()
    };
    let normal = RackCutter::default();
    let round = RackCutter {
        tip_radius: 0.6,
        ..normal
    };
    let text = cut(&circular(24), 24, round);
    assert!(
        text.contains("do not fit") && text.contains("at most 0.47"),
        "{text}"
    );
    let high = RackCutter {
        addendum: 2.0,
        ..normal
    };
    let text = cut(&circular(24), 24, high);
    assert!(text.contains("pointed"), "{text}");
    let largest: f64 = text
        .split("at most ")
        .nth(1)
        .unwrap()
        .split(' ')
        .next()
        .unwrap()
        .parse()
        .unwrap();
    assert!(ok(
        &circular(24),
        24,
        RackCutter {
            addendum: largest - 1e-4,
            ..normal
        }
    ));
    assert!(!ok(
        &circular(24),
        24,
        RackCutter {
            addendum: largest + 1e-4,
            ..normal
        }
    ));
    let waves =
        Centrodes::of_gears(&RatioLaw::sine(1.25, 0.75, 4).unwrap(), 0.1, Mate::External).unwrap();
    let text = cut(&waves, 40, normal);
    assert!(text.contains("concave"), "{text}");
    let linear = Centrodes::of_gears(
        &RatioLaw::linear(2.0, 1.0, 3.0).unwrap(),
        0.1,
        Mate::External,
    )
    .unwrap();
    assert!(cut(&linear, 40, normal).contains("open"));
    let internal =
        Centrodes::of_gears(&RatioLaw::constant(2.0).unwrap(), 0.1, Mate::Internal).unwrap();
    let text = cut_outline(&internal, Member::Second, 40, &normal, 8, 0.0)
        .unwrap_err()
        .to_string();
    assert!(text.contains("internal gear"), "{text}");
    let flat = RackCutter {
        pressure_angle: FRAC_PI_2,
        ..normal
    };
    assert!(cut(&circular(24), 24, flat).contains("between 0 and 45"));
}
