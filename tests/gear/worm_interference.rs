//! Interference of worm-like pairs: the flank of the wheel against every turn of the worm; contacts that the same point of the worm has twice.

use std::f64::consts::{FRAC_PI_2, PI};

use geardyn::internals::gear::helicoid::crossed_pair::{CrossedGear, CrossedPair};
use geardyn::internals::gear::helicoid::plane_worm::{PlaneWorm, PlaneWormContact};
use geardyn::internals::gear::helicoid::plane_worm_zone::PlaneWormZone;
use geardyn::internals::gear::helicoid::worm_pair::{WormContact, WormPair};
use geardyn::internals::gear::helicoid::worm_thread::{FlankType, WormThread};
use geardyn::internals::gear::helicoid::worm_zone::WormZone;

use geardyn::internals::gear::kernel::vector::Vector;

use crate::verification::within;

/// Axial module of the worms, mm.
const MODULE: f64 = 5.0;
/// Axial thickness of the thread at the reference cylinder.
const THICKNESS: f64 = FRAC_PI_2 * MODULE;

/// A worm of two starts with a wheel, and the zone of both.
fn worm(flank: FlankType, alpha: f64, teeth: f64) -> (WormPair, WormZone) {
    let thread = WormThread {
        flank,
        starts: 2,
        module: MODULE,
        diameter_quotient: 10.0,
        pressure_angle: alpha.to_radians(),
    };
    let centre_distance = 0.5 * MODULE * (10.0 + teeth);
    let pair = WormPair {
        worm: thread.helicoid().unwrap().through(25.0, 0.0).unwrap(),
        ratio: 2.0 / teeth,
        centre_distance,
    };
    let zone = WormZone {
        radii: [20.0, 30.0],
        length: 70.0,
        face_width: 36.0,
        outer_radius: centre_distance - 17.0,
    };
    (pair, zone)
}

/// Contacts over the zone that touch from outside.
fn contacts(pair: &WormPair, zone: &WormZone) -> Vec<WormContact> {
    let mut found = Vec::new();
    for j in 0..=20 {
        let radius = zone.radii[0] + 0.5 * f64::from(j);
        for k in -20..=20 {
            let azimuth = 0.04 * f64::from(k);
            found.extend(pair.contact(radius, azimuth).filter(|c| zone.holds(c)));
        }
    }
    found
}

/// Azimuth in the wheel at which the worm, at a turn, holds a place of radius and y of the wheel, by bisection: without normals.
fn azimuth_of_worm(pair: &WormPair, turn: f64, radius: f64, y: f64, near: f64) -> Option<f64> {
    let off = |azimuth: f64| {
        // The wheel's point at this azimuth, in space.
        let (x, z) = (
            pair.centre_distance - radius * azimuth.cos(),
            radius * azimuth.sin(),
        );
        let at = pair.worm.at(f64::hypot(x, y))?;
        Some(z - at.height - pair.worm.lead * (y.atan2(x) - turn))
    };
    let (mut low, mut high) = (near - 0.06, near + 0.06);
    if !(off(low)? < 0.0 && off(high)? > 0.0) {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        match off(middle)? < 0.0 {
            true => low = middle,
            false => high = middle,
        }
    }
    Some(0.5 * (low + high))
}

/// A wheel of 40 teeth at 20° is nowhere cut into, one of 20 teeth at 15° is above its limit of the first kind; the deepest point is cut to
/// the depth by which the worm passes it in azimuth at its other turn.
#[test]
fn exact_interference_of_worm_wheels() {
    for flank in [FlankType::Za, FlankType::Zi] {
        let (pair, zone) = worm(flank, 20.0, 40.0);
        let turns = zone.turns(&pair).unwrap();
        let all = contacts(&pair, &zone);
        assert!(all.len() > 200, "{}", all.len());
        let found = zone.interference(&pair, &all, turns, [THICKNESS, 1e-6]);
        assert_eq!(found, None);
        let (pair, zone) = worm(flank, 15.0, 20.0);
        let all = contacts(&pair, &zone);
        let turns = zone.turns(&pair).unwrap();
        let cut = zone
            .interference(&pair, &all, turns, [THICKNESS, 1e-6])
            .unwrap();
        // In azimuth: the worm at the other turn against the point.
        let at = cut.contact.in_wheel();
        let spun = -pair.ratio * cut.worm_turn;
        let (s, c) = spun.sin_cos();
        let (x, z) = (at.x * c + at.z * s, at.z * c - at.x * s);
        let own = z.atan2(-x);
        let radius = f64::hypot(x, z);
        let reached = azimuth_of_worm(&pair, cut.worm_turn, radius, at.y, own).unwrap();
        let space = pair.centre_distance - radius * own.cos();
        let rho = f64::hypot(space, at.y);
        let profile = pair.worm.at(rho).unwrap();
        // To first order the depth is the azimuth passed, along the wheel's circle, times the normal's share of it.
        let psi = at.y.atan2(space);
        let steep = pair.worm.lead / rho;
        let across = (1.0 + profile.slope.powi(2) + steep * steep).sqrt();
        let outward = -profile.slope * psi.cos() + steep * psi.sin();
        let along = (own.cos() + outward * own.sin()) / across;
        let depth = radius * (own - reached) * along;
        within(
            &format!("{flank:?}: depth against azimuth, relative"),
            (depth / cut.depth - 1.0).abs(),
            0.1,
        );
    }
}

/// The same point of the worm touches again at the turn Δ, at the same place along the worm, and from there at −Δ.
#[test]
fn exact_second_contact_of_worms() {
    let mut worst = 0f64;
    let mut count = 0;
    for flank in [FlankType::Za, FlankType::Zi, FlankType::ZnSpace] {
        let (pair, zone) = worm(flank, 20.0, 40.0);
        for contact in contacts(&pair, &zone) {
            let again = pair.second_contact(&contact).unwrap();
            worst = worst.max((again.from_wheel.z - contact.from_wheel.z).abs());
            let turned = again.worm_turn - contact.worm_turn;
            worst = worst.max((turned - (again.azimuth - contact.azimuth)).abs());
            let back = pair.second_contact(&again).unwrap();
            worst = worst.max((back.azimuth - contact.azimuth).abs());
            count += 1;
        }
    }
    assert!(count > 600, "{count}");
    within("place along the worm, mm; turns, rad", worst, 1e-7);
}

/// Second contacts of a plane-generated worm that touch from outside are left by the worm at every turn; the same points 10 µm higher are
/// cut away.
#[test]
fn law_second_contacts_bound_the_worm() {
    let pair = PlaneWorm {
        centre_distance: 125.0,
        ratio: 1.0 / 40.0,
        base_radius: 40.0,
        plane_angle: 11f64.to_radians(),
    };
    let zone = PlaneWormZone {
        length: 100.0,
        face_width: 24.0,
        worm_tip_radius: 30.0,
        wheel_tip_radius: 112.0,
    };
    let on_tooth = |c: &PlaneWormContact| {
        let r = f64::hypot(c.in_wheel.x, c.in_wheel.z);
        c.in_wheel.y.abs() < 8.0 && (96.0..108.0).contains(&r)
    };
    let normal = Vector::new(0.0, -pair.plane_angle.sin(), pair.plane_angle.cos());
    let mut points = Vec::new();
    for turn in [0.25, 0.35, 0.45] {
        let line = pair.generating_line(turn);
        let second = (-8..=8).filter_map(|k| line.second_contact_at(f64::from(k)));
        let real = second.filter(|c| c.relative_curvature < 0.0 && on_tooth(c));
        points.extend(real.map(|c| c.in_wheel));
    }
    assert!(points.len() > 8, "{}", points.len());
    let cut = |lift: f64, tolerance: f64| {
        let lifted = points.iter().map(|p| *p + normal * lift);
        pair.interference(&zone, lifted, [0.2, 0.6], tolerance)
    };
    assert_eq!(cut(0.0, 1e-6), None);
    let depth = cut(0.01, 1e-6).unwrap().depth;
    assert!((0.005..0.0101).contains(&depth), "{depth}");
}

/// Involute gears on crossed axes, face widths from 4 to 90 mm at module 3: while both flanks touch on the path no point of one lies in the
/// other; the least gap is that beside the contact.
#[test]
fn law_crossed_flanks_stay_apart() {
    let alpha = 20f64.to_radians();
    let module = 3.0;
    let gear = |teeth: u32, helix: f64| {
        let radius = 0.5 * module * f64::from(teeth) / helix.cos();
        let transverse = (alpha.tan() / helix.cos()).atan();
        CrossedGear {
            teeth,
            helix,
            radius,
            base_radius: radius * transverse.cos(),
            tip_radius: radius + module,
            base_half_angle: PI / (2.0 * f64::from(teeth)) + transverse.tan() - transverse,
        }
    };
    for helices in [[45f64, 45.0], [30.0, 60.0], [60.0, 20.0]] {
        let [b1, b2] = helices.map(f64::to_radians);
        let gears = [gear(15, b1), gear(24, b2)];
        let pair = CrossedPair {
            gears,
            pressure_angle: alpha,
            centre_distance: gears[0].radius + gears[1].radius,
            shaft_angle: b1 + b2,
        };
        let path = pair.path().unwrap();
        for width in [4.0, 12.0, 30.0, 90.0] {
            let found = pair.interference(&path, [width; 2], 1e-6);
            assert_eq!(found, None, "{helices:?}, {width} mm");
        }
        // The least gap is that of points next to the contact.
        let least = pair.interference(&path, [4.0; 2], -0.05).unwrap();
        assert!((-0.03..1e-9).contains(&least.depth), "{least:?}");
    }
}
