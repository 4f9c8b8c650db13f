//! Blades with a profile arc and a Toprem: curvature, formate flanks in closed form, generated ones against the swept body of the blade.

use geardyn::internals::gear::bevel::blank::Blank;
use geardyn::internals::gear::bevel::cutter::{Blade, BladeFault, Cutter, Toprem};
use geardyn::internals::gear::bevel::flank::BevelFlank;
use geardyn::internals::gear::bevel::rough_settings::rough_settings;
use geardyn::internals::gear::bevel::settings::MachineSettings;
use geardyn::internals::gear::cut::blade_passes::{BladePasses, CutConditions, scallop_height};
use geardyn::internals::gear::cut::cutter_head::BladeFeed;
use geardyn::internals::gear::hand::Hand;
use geardyn::internals::gear::kernel::jet::Surface;
use geardyn::internals::gear::kernel::root::greatest;
use geardyn::internals::gear::kernel::second_order::Curvature;
use geardyn::internals::gear::kernel::vector::Vector;

use crate::verification::{order, within};

/// Depth of the teeth, mm.
const DEPTH: f64 = 8.8;

/// A blade of each side with a hollow or bulging profile of 400 mm and a Toprem of 2.5° up to 2 mm, edge radius 0.8 mm.
fn blades() -> Vec<Cutter> {
    let of = |blade, radius: f64| Cutter {
        edge_radius: 0.8,
        profile_curvature: 1.0 / radius,
        profile_height: 4.8,
        toprem: Some(Toprem {
            angle: 2.5f64.to_radians(),
            depth: 2.0,
        }),
        ..Cutter::straight(blade, 76.0, 20f64.to_radians())
    };
    let radii = [400.0, -400.0].into_iter();
    radii
        .flat_map(|radius| [of(Blade::Inside, radius), of(Blade::Outside, radius)])
        .collect()
}

/// Blank of a gear, mm.
fn blank() -> Blank {
    Blank::of_one_apex([1.0, 1.05, 0.94], 80.0, 20.0)
}

fn settings(cutter: &Cutter) -> MachineSettings {
    rough_settings(&blank(), cutter, 30f64.to_radians())
}

fn generated(cutter: &Cutter) -> BevelFlank {
    let section = blank().section().unwrap();
    BevelFlank::new(cutter, &settings(cutter), Hand::Right, section)
}

fn formate(cutter: &Cutter) -> BevelFlank {
    let fixed = MachineSettings {
        roll: None,
        ..settings(cutter)
    };
    BevelFlank::new(cutter, &fixed, Hand::Right, blank().section().unwrap())
}

/// A straight blade of the same point radius and blade angle.
fn straight(cutter: &Cutter) -> Cutter {
    Cutter::straight(cutter.blade, cutter.point_radius, cutter.blade_angle)
}

/// A curved blade has the curvature of its arc along its profile and cos a/ρ across, a from the sines of its heights.
#[test]
fn exact_curvatures_of_a_curved_blade() {
    let mut apart = 0f64;
    for cutter in blades() {
        let surface = cutter.surfaces(DEPTH).blade;
        let [from, to] = surface.range();
        let k = cutter.profile_curvature;
        for i in 0..=10 {
            let u = from + (to - from) * f64::from(i) / 10.0;
            let jet = surface.jet([u, 0.4]).unwrap();
            let rho = f64::hypot(jet.r.x, jet.r.y);
            let height = -jet.r.z;
            let sine = cutter.blade_angle.sin() + k * (height - cutter.profile_height);
            // Normals point into the blade, dn = −W dr: a hollow profile is negative, and so is the cone of an inside blade.
            let across = cutter.outwards() * (1.0 - sine * sine).sqrt() / rho;
            let mut expected = [-k, across];
            expected.sort_by(f64::total_cmp);
            let found = Curvature::of(&jet).unwrap().principal();
            for (found, expected) in found.iter().zip(expected) {
                apart = apart.max((found.0 - expected).abs() * rho);
            }
        }
    }
    within("curvature × radius", apart, 1e-13);
}

/// The parts of a blade join without a gap: the edge in the tangent of the part above and of the tip plane, the Toprem at its angle.
#[test]
fn exact_joints_of_a_blade() {
    let (mut places, mut angles) = (0f64, 0f64);
    for with_toprem in blades() {
        let without = Cutter {
            toprem: None,
            ..with_toprem
        };
        for cutter in [with_toprem, without] {
            let surfaces = cutter.surfaces(DEPTH);
            let edge = surfaces.edge.unwrap();
            let end = |surface: &dyn Surface<Frame = _>, k: usize| {
                surface.jet([surface.range()[k], 0.7]).unwrap()
            };
            let [tip, edge_end] = [0, 1].map(|k| end(&edge, k));
            places = places.max(tip.r.z.abs());
            angles = angles.max((tip.n + Vector::Z).norm());
            let lowest = surfaces.toprem.unwrap_or(surfaces.blade);
            let above = end(&lowest, 0);
            places = places.max((above.r - edge_end.r).norm());
            angles = angles.max((above.n - edge_end.n).norm());
            if let (Some(surface), Some(toprem)) = (surfaces.toprem, cutter.toprem) {
                let (below, above) = (end(&surface, 1), end(&surfaces.blade, 0));
                places = places.max((below.r - above.r).norm());
                places = places.max((above.r.z + toprem.depth).abs());
                angles = angles.max((below.n.dot(above.n).acos() - toprem.angle).abs());
            }
        }
    }
    within("places, mm", places, 1e-13);
    within("directions, rad", angles, 1e-13);
}

/// A formate flank of a curved blade lies `R − √(R² − σ²)` below that of the straight blade, σ from the profile height along the blade.
#[test]
fn exact_profile_crowning_of_a_formate_flank() {
    let mut apart = 0f64;
    for cutter in blades() {
        let cutter = Cutter {
            toprem: None,
            edge_radius: 0.0,
            ..cutter
        };
        let (curved, plain) = (formate(&cutter), formate(&straight(&cutter)));
        let radius = 1.0 / cutter.profile_curvature;
        let (_, cos) = cutter.blade_angle.sin_cos();
        for height in [0.5, 2.0, 4.8, 7.0, 8.5] {
            for theta in [0.3, 2.0] {
                let s = height / cos;
                let point = plain.envelope.point([s, theta, 0.0]).unwrap();
                let ray = (point.point, point.normal);
                let (_, found) = curved
                    .envelope
                    .intersect_ray(ray.0, ray.1, point.at)
                    .unwrap();
                let off = (height - cutter.profile_height) / cos;
                // Normals point out of the metal.
                let rise = radius.abs() - (radius * radius - off * off).sqrt();
                apart = apart.max((found + rise.copysign(radius)).abs());
            }
        }
    }
    within("profile crowning, mm", apart, 1e-13);
}

/// On a formate flank of a straight blade the Toprem takes `d tan Δα` at a distance d along the blade below it.
#[test]
fn exact_toprem_relief_of_a_formate_flank() {
    let mut apart = 0f64;
    for cutter in blades() {
        let cutter = Cutter {
            profile_curvature: 0.0,
            ..cutter
        };
        let (relieved, plain) = (formate(&cutter), formate(&straight(&cutter)));
        let toprem = cutter.toprem.unwrap();
        let relief = relieved.toprem.unwrap();
        let (sin, cos) = cutter.blade_angle.sin_cos();
        // Of heights to the end of the edge.
        let edge = cutter.edge_radius * (1.0 - sin);
        for share in [0.1, 0.5, 0.9] {
            let height = toprem.depth - share * (toprem.depth - edge);
            let (s, theta) = (height / cos, 1.1);
            let point = plain.envelope.point([s, theta, 0.0]).unwrap();
            let (at, found) = relief
                .intersect_ray(point.point, point.normal, point.at)
                .unwrap();
            let [first, last] = relief.surface.range();
            assert!(first < at[0] && at[0] < last);
            let depth = (toprem.depth - height) / cos;
            apart = apart.max((found + depth * toprem.angle.tan()).abs());
        }
    }
    within("relief, mm", apart, 1e-13);
}

/// The generated flank of a curved blade nears that of the straight blade as its curvature falls.
#[test]
fn order_straight_blade_is_the_limit() {
    let hollow = Cutter {
        toprem: None,
        edge_radius: 0.0,
        ..blades()[0]
    };
    let plain = generated(&straight(&hollow));
    let middle = plain.middle().unwrap();
    let distance = |radius: f64| {
        let curved = generated(&Cutter {
            profile_curvature: 1.0 / radius,
            ..hollow
        });
        let at = |height: f64| {
            let point = plain.point([0.5, height], middle).unwrap();
            let (_, found) = (curved.envelope)
                .intersect_ray(point.point, point.normal, point.at)
                .unwrap();
            found
        };
        at(0.9)
    };
    let (near, far) = (distance(1e5), distance(2e5));
    assert!(near < 0.0, "a hollow blade leaves profile crowning: {near}");
    order(
        "distance from the straight blade's flank",
        1.0,
        (near / far).log2(),
    );
}

/// Radius of the blade at a height above the tip plane: circle, line and circle from the definitions.
fn radius_at(cutter: &Cutter, height: f64) -> f64 {
    let o = cutter.outwards();
    let (sin, cos) = cutter.blade_angle.sin_cos();
    let big = 1.0 / cutter.profile_curvature;
    let at_height = cutter.point_radius + o * cutter.profile_height * sin / cos;
    let centre = [at_height + o * big * cos, cutter.profile_height - big * sin];
    let blade = |h: f64| {
        let rise = h - centre[1];
        centre[0] - o * big.signum() * (big * big - rise * rise).sqrt()
    };
    let toprem = cutter.toprem.unwrap();
    if height >= toprem.depth {
        return blade(height);
    }
    let joint = blade(toprem.depth);
    let tangent = -o * (toprem.depth - centre[1]) / (joint - centre[0]);
    let angle = tangent.atan() - toprem.angle;
    let line = |h: f64| joint + o * (h - toprem.depth) * angle.tan();
    let edge = cutter.edge_radius;
    if height >= edge * (1.0 - angle.sin()) {
        return line(height);
    }
    let middle = line(edge) - o * edge / angle.cos();
    middle + o * (edge * edge - (height - edge).powi(2)).sqrt()
}

/// The tooth of a generated gear, flank, relief and fillet, against the body of the blade in the whole roll: along each normal the body
/// begins at the tooth and nowhere before.
#[test]
fn law_tooth_is_what_the_blade_leaves() {
    let mut apart = [0f64; 3];
    let (mut counts, mut in_corner) = ([0; 3], 0);
    for cutter in blades() {
        let flank = generated(&cutter);
        let middle = flank.middle().unwrap();
        for face in [0.1, 0.5, 0.9] {
            for i in 0..=40 {
                let height = f64::from(i) / 40.0;
                let place = flank.section.at(face, height);
                let Some(found) = flank.tooth_point(place, middle) else {
                    continue;
                };
                let on_blade = flank.envelope.intersect_circle(place, middle);
                let reaches = on_blade.is_some_and(|at| at[0] >= flank.envelope.surface.range()[0]);
                in_corner += usize::from(reaches && found.in_fillet);
                let point = found.point.point.coordinates;
                let normal = found.point.normal.components;
                // Where the blade begins on the ray at a turn of the cradle.
                let entry = |x: f64| {
                    let from_work = flank.envelope.motion.at(x).pose.inverse();
                    let inside = |d: f64| {
                        let r = from_work.apply(point + normal * d);
                        let rho = f64::hypot(r.x, r.y);
                        let beyond = cutter.outwards() * (radius_at(&cutter, -r.z) - rho);
                        r.z < 0.0 && beyond > 0.0
                    };
                    let (mut metal, mut blade) = (-0.5, 0.5);
                    if inside(metal) || !inside(blade) {
                        return None;
                    }
                    for _ in 0..60 {
                        let half = 0.5 * (metal + blade);
                        match inside(half) {
                            true => blade = half,
                            false => metal = half,
                        }
                    }
                    Some(-blade)
                };
                let x = found.point.at[2];
                let Some([_, deepest]) = greatest([x - 0.3, x + 0.3], 3000, entry) else {
                    panic!("no blade on the ray at {face} {height}");
                };
                let part = match (found.in_fillet, found.point.at) {
                    (false, _) => 0,
                    (true, at) => {
                        let toprem = flank.toprem.as_ref().unwrap();
                        let on_toprem = toprem
                            .point(at)
                            .is_some_and(|p| (p.point.coordinates - point).norm() < 1e-12);
                        if on_toprem { 1 } else { 2 }
                    }
                };
                counts[part] += 1;
                apart[part] = apart[part].max(deepest.abs());
            }
        }
    }
    assert!(counts.iter().all(|count| *count > 10), "{counts:?}");
    assert!(
        in_corner > 0,
        "the Toprem cuts deeper than the blade nowhere"
    );
    within("flank, mm", apart[0], 1e-12);
    within("relieved root, mm", apart[1], 1e-12);
    within("fillet, mm", apart[2], 1e-12);
}

/// Facets of a curved blade with a Toprem, a quarter of a degree of the cradle apart, leave the scallops of the law.
#[test]
fn law_scallops_of_a_curved_blade() {
    let mut off = 0f64;
    for cutter in blades() {
        let flank = generated(&cutter);
        let middle = flank.middle().unwrap();
        let feed = BladeFeed {
            blades: 16,
            cradle_per_turn: 4f64.to_radians(),
        };
        let machine = (&cutter, &settings(&cutter), Hand::Right);
        let passes = BladePasses::new(machine, DEPTH, middle[1], &CutConditions::regular(feed));
        for height in [0.5, 0.9] {
            let point = flank.point([0.5, height], middle).unwrap();
            let by_law = scallop_height(&point.second_order, feed.step());
            off = off.max((passes.scallop(&point).unwrap() / by_law - 1.0).abs());
        }
    }
    within("scallops against the law, relative", off, 1e-2);
}

/// Blades whose parts do not join are refused, each for its reason.
#[test]
fn refuses_blades_that_do_not_join() {
    let [good, ..] = blades()[..] else { panic!() };
    assert_eq!(good.fault(DEPTH), None);
    let turned = Cutter {
        profile_curvature: -1.0 / 10.0,
        ..good
    };
    assert_eq!(
        turned.fault(DEPTH),
        Some(BladeFault::Turned { height: DEPTH })
    );
    let toprem = |angle: f64, depth: f64| Cutter {
        toprem: Some(Toprem { angle, depth }),
        ..good
    };
    assert_eq!(
        toprem(0.04, DEPTH).fault(DEPTH),
        Some(BladeFault::DeepToprem)
    );
    let steep = toprem(0.36, 2.0).fault(DEPTH);
    assert!(
        matches!(steep, Some(BladeFault::SteepToprem { .. })),
        "{steep:?}"
    );
    let short = toprem(0.04, 0.5).fault(DEPTH);
    assert!(
        matches!(short, Some(BladeFault::LongEdge { limit: 0.5, .. })),
        "{short:?}"
    );
}
