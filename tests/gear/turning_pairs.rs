//! Worm pairs and crossed pairs that turn in space: the curves of contact lie on both members, the bodies touch and do not enter each other.

use std::f64::consts::{PI, TAU};

use geardyn::internals::gear::helicoid::crossed_pair::{CrossedGear, CrossedPair, CrossedPath};
use geardyn::internals::gear::helicoid::plane_worm::PlaneWorm;
use geardyn::internals::gear::helicoid::plane_worm_zone::PlaneWormZone;
use geardyn::internals::gear::helicoid::turning_pair::{TurningMember, TurningPair};
use geardyn::internals::gear::helicoid::worm_pair::WormPair;
use geardyn::internals::gear::helicoid::worm_thread::{FlankType, WormThread};
use geardyn::internals::gear::helicoid::worm_zone::WormZone;
use geardyn::internals::gear::kernel::vector::Vector;

use crate::verification::within;

/// A worm of two starts and a wheel of 40 teeth, mm.
fn worm_pair() -> (WormPair, WormZone) {
    let thread = WormThread {
        flank: FlankType::Zi,
        starts: 2,
        module: 5.0,
        diameter_quotient: 10.0,
        pressure_angle: 20f64.to_radians(),
    };
    let worm = thread.helicoid().unwrap().through(25.0, 0.0).unwrap();
    let pair = WormPair {
        worm,
        ratio: 2.0 / 40.0,
        centre_distance: 125.0,
    };
    let zone = WormZone {
        radii: [20.0, 30.0],
        length: 80.0,
        face_width: 40.0,
        outer_radius: 107.5,
    };
    (pair, zone)
}

/// Radius, azimuth and height of a point in a member that has turned.
fn place(member: &TurningMember, angle: f64, point: Vector) -> [f64; 3] {
    let [x, y, z] = member.axes.map(|axis| axis.dot(point - member.centre));
    [x.hypot(y), y.atan2(x) - angle, z]
}

/// Angle to the nearest multiple of a pitch.
fn off_pitch(angle: f64, teeth: u32) -> f64 {
    let pitch = TAU / f64::from(teeth);
    angle - pitch * (angle / pitch).round()
}

/// Points of contact at every angle that is shown, with the angles.
fn contacts(pair: &TurningPair) -> impl Iterator<Item = ([f64; 2], Vector)> {
    let positions = pair.positions.iter();
    positions.flat_map(|p| p.curves.iter().flatten().map(|point| (p.angles, *point)))
}

/// The lines of contact that a page shows of a worm pair lie on the flanks of worm and wheel, for both hands.
#[test]
fn exact_lines_lie_on_worm_and_wheel() {
    let (pair, zone) = worm_pair();
    let mut off = 0f64;
    for hand in [1.0, -1.0] {
        let turning = pair.turning_pair(&zone, [2, 40]).unwrap().of_hand(hand);
        let [worm, wheel] = &turning.members;
        assert!(contacts(&turning).count() > 1000);
        for (angles, point) in contacts(&turning) {
            let [radius, azimuth, z] = place(worm, angles[0], point);
            let flank = z / pair.worm.lead + pair.worm.transverse_azimuth(radius).unwrap();
            off = off.max((radius * off_pitch(hand * azimuth - flank, 2)).abs());
            let [radius, azimuth, h] = place(wheel, angles[1], point);
            let Some(flank) = pair.wheel_azimuth(&zone, radius, -h) else {
                // The end of the flank, by rounding.
                assert!(point.x.hypot(point.y) > zone.radii[1] - 1e-9, "{point:?}");
                continue;
            };
            off = off.max((radius * off_pitch(hand * azimuth - flank, 40)).abs());
        }
    }
    within("distance of lines from both flanks, mm", off, 1e-6);
}

/// Each ring of a drawn body goes on to the first point of the next tooth at growing azimuth, for both hands: bodies close without a slit.
#[test]
fn law_rings_go_on_to_the_next_tooth() {
    let (pair, zone) = worm_pair();
    for hand in [1.0, -1.0] {
        let turning = pair.turning_pair(&zone, [2, 40]).unwrap().of_hand(hand);
        for member in &turning.members {
            let points = &member.sector.points;
            let around = points.len() / member.sector.rings;
            let pitch = TAU / f64::from(member.teeth);
            for ring in points.chunks(around) {
                let azimuth = |p: &[f64; 3]| p[1].atan2(p[0]);
                let step = azimuth(&ring[0]) + pitch - azimuth(&ring[around - 1]);
                let step = step - TAU * (step / TAU).round();
                assert!(step.abs() < 0.3 * pitch, "{hand} {step} of {pitch}");
            }
        }
    }
}

/// No point of the drawn wheel enters the thread of the drawn worm at any turn, and both flanks of each section touch it.
#[test]
fn law_wheel_touches_the_worm() {
    let (pair, zone) = worm_pair();
    let turning = pair.turning_pair(&zone, [2, 40]).unwrap();
    let wheel = &turning.members[1];
    let flank =
        |radius: f64, z: f64| Some(z / pair.worm.lead + pair.worm.transverse_azimuth(radius)?);
    let other_flank = 2.0 * flank(25.0, 0.0).unwrap() - 0.5 * PI;
    // Depth in the thread along the circle, below zero outside it.
    let depth = |point: &[f64; 3], turn: f64| {
        let (sin, cos) = (pair.ratio * turn).sin_cos();
        let (x, y) = (
            cos * point[0] - sin * point[1],
            sin * point[0] + cos * point[1],
        );
        let at = [x, y, point[2]];
        let space = (0..3).fold(wheel.centre, |sum, k| sum + wheel.axes[k] * at[k]);
        let radius = f64::hypot(space.x, space.y);
        if radius > zone.radii[1] {
            return None;
        }
        let azimuth = space.y.atan2(space.x) - turn;
        let one = flank(radius, space.z)? - azimuth;
        let other = azimuth - other_flank + flank(radius, -space.z)?;
        // Of all threads the nearest: half a pitch is metal.
        let shift = PI * (one / PI + 0.25).floor();
        Some(radius * (one - shift).min(other + shift))
    };
    let deepest = |point: &[f64; 3]| {
        let turns = (-40_000..=40_000).map(|k| 8.0 * f64::from(k) / 40_000.0);
        turns
            .filter_map(|turn| depth(point, turn))
            .fold(f64::NEG_INFINITY, f64::max)
    };
    let around = wheel.sector.points.len() / wheel.sector.rings;
    let azimuth = |p: &[f64; 3]| p[1].atan2(p[0]);
    for pair in wheel.sector.points.windows(2) {
        let step = off_pitch(azimuth(&pair[1]) - azimuth(&pair[0]), 1);
        assert!(
            step.abs() < 0.5,
            "a pitch of 0.16 goes round the wheel: {step}"
        );
    }
    for ring in [1, 5, 8, 12, 15] {
        let of = &wheel.sector.points[ring * around..(ring + 1) * around];
        for point in of.iter().step_by(3) {
            let found = deepest(point);
            assert!(
                found < 1e-6,
                "ring {ring}, {point:?}: {found} mm in the thread"
            );
        }
        // Nine steps from root to tip, three of a land.
        for k in [6, 10 + 3 + 3] {
            let found = deepest(&of[k]);
            assert!(
                found > -1e-4,
                "ring {ring}, point {k}: {found} mm off the thread"
            );
        }
    }
}

/// Both lines of contact of a plane double-enveloping worm lie on the flanks of worm and wheel at every angle that is shown.
#[test]
fn exact_lines_lie_on_hourglass_worm_and_wheel() {
    let pair = PlaneWorm {
        centre_distance: 125.0,
        ratio: 1.0 / 40.0,
        base_radius: 40.0,
        plane_angle: 11f64.to_radians(),
    };
    let zone = PlaneWormZone {
        length: 70.0,
        face_width: 32.0,
        worm_tip_radius: 25.0,
        wheel_tip_radius: 106.0,
    };
    let turns = zone.turns(&pair).unwrap();
    let turning = pair.turning_pair(&zone, [1, 40]).unwrap();
    let [worm, wheel] = &turning.members;
    let mut off = [0f64; 2];
    assert!(contacts(&turning).count() > 1000);
    for (angles, point) in contacts(&turning) {
        let [radius, azimuth, z] = place(worm, angles[0], point);
        let flank = pair.worm_azimuth(radius, z).unwrap();
        off[0] = off[0].max((radius * off_pitch(azimuth - flank, 1)).abs());
        let [radius, azimuth, h] = place(wheel, angles[1], point);
        let at = pair.tooth_point(radius, -h, turns).unwrap();
        off[1] = off[1].max((radius * off_pitch(azimuth - at.z.atan2(-at.x), 40)).abs());
    }
    within("distance of lines from the worm, mm", off[0], 1e-6);
    within("distance of lines from the wheel, mm", off[1], 1e-6);
}

/// Points of contact of crossed gears lie on both flanks at every angle that is shown, the angles follow the ratio, and along each ellipse
/// the flanks are one coating apart.
#[test]
fn exact_ellipses_lie_between_crossed_gears() {
    let gear = |teeth: u32, helix: f64, shift: f64| {
        let (helix, normal) = (helix.to_radians(), 20f64.to_radians());
        let transverse = (normal.tan() / helix.cos()).atan();
        let radius = 1.5 * f64::from(teeth) / helix.cos();
        let thickness = 3.0 * (0.5 * PI + 2.0 * shift * normal.tan()) / helix.cos();
        CrossedGear {
            teeth,
            helix,
            radius,
            base_radius: radius * transverse.cos(),
            tip_radius: radius + 3.0 * (1.0 + shift),
            base_half_angle: 0.5 * thickness / radius + transverse.tan() - transverse,
        }
    };
    let pair = CrossedPair {
        gears: [gear(15, 20.0, 0.4), gear(24, 30.0, 0.2)],
        pressure_angle: 20f64.to_radians(),
        centre_distance: 67.4,
        shaft_angle: 50f64.to_radians(),
    };
    let path = pair.path().unwrap();
    let coating = 6e-3;
    let turning = pair.turning_pair(&path, [30.0; 2], coating).unwrap();
    // Height of a point over the flank of a member, out of the metal along the base helix.
    let height = |k: usize, angle: f64, point: Vector| {
        let gear = pair.gears[k];
        let [radius, azimuth, h] = place(&turning.members[k], angle, point);
        let a = (gear.base_radius / radius).acos();
        let unwound = a.tan() - a;
        let sine = gear.helix.sin() * pair.pressure_angle.cos();
        let along = gear.base_radius * (1.0 - sine * sine).sqrt();
        let side = turning_side(&pair, &path, k);
        let phase = side * (azimuth - h * gear.helix.tan() / gear.radius) + unwound;
        along * off_pitch(phase, gear.teeth)
    };
    let (mut off, mut ratio, mut apart) = (0f64, 0f64, 0f64);
    let first = turning.positions[0].angles;
    for position in &turning.positions {
        let [one, two] = [0, 1].map(|k| position.angles[k] - first[k]);
        ratio = ratio.max((two + 15.0 / 24.0 * one).abs());
        for ellipse in &position.curves {
            let count = ellipse.len() - 1;
            let sum = ellipse[..count]
                .iter()
                .fold(Vector::ZERO, |sum, p| sum + *p);
            let middle = sum * (1.0 / count as f64);
            for k in 0..2 {
                off = off.max(height(k, position.angles[k], middle).abs());
            }
            for point in ellipse {
                let gap = (0..2)
                    .map(|k| height(k, position.angles[k], *point))
                    .sum::<f64>();
                apart = apart.max((gap / coating - 1.0).abs());
            }
        }
    }
    within("distance of points from both flanks, mm", off, 1e-9);
    within("ratio of the angles, rad", ratio, 1e-12);
    // The third order of the flanks over half an axis of 2 mm.
    within("gap at the ellipse over the coating, less one", apart, 0.1);
}

/// Sense of the azimuth in which the flank of a gear looks: along the path from the pinion, against it from the gear.
fn turning_side(pair: &CrossedPair, path: &CrossedPath, k: usize) -> f64 {
    let (sine, cosine) = pair.shaft_angle.sin_cos();
    let axis = [Vector::Z, Vector::new(0.0, sine, cosine)][k];
    let foot = Vector::X * (k as f64 * pair.centre_distance);
    let round = axis.cross(path.tangent_points[k] - foot);
    round.dot(path.direction * [1.0, -1.0][k]).signum()
}
