//! The kernel of meshing against closed forms: involute, helicoids, canal surface, generated shapers, hobs.

use std::f64::consts::{PI, TAU};

use geardyn::internals::gear::kernel::envelope::Envelope;
use geardyn::internals::gear::kernel::jet::Surface;
use geardyn::internals::gear::kernel::law::Law;
use geardyn::internals::gear::kernel::limits::{Limit, limit_points};
use geardyn::internals::gear::kernel::motion::Motion;
use geardyn::internals::gear::kernel::plane::{gear_rolling, plane_envelope, rack_rolling};
use geardyn::internals::gear::kernel::pose::Pose;
use geardyn::internals::gear::kernel::second_order::Curvature;
use geardyn::internals::gear::kernel::tool::{Arc, Line, Tool};
use geardyn::internals::gear::kernel::twist::Twist;
use geardyn::internals::gear::kernel::vector::Vector;

use crate::verification::within;

#[derive(Debug, Clone, Copy, PartialEq)]
struct Rack;
#[derive(Debug, Clone, Copy, PartialEq)]
struct Shaper;
#[derive(Debug, Clone, Copy, PartialEq)]
struct Work;

/// An angle in (−π, π].
fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

/// Polar angle of the involute at pressure angle α: tan α − α.
fn involute(cos_alpha: f64) -> f64 {
    let alpha = cos_alpha.acos();
    alpha.tan() - alpha
}

/// The straight flank of a rack that makes the right flank of a tooth: the metal of the work on its left.
fn rack_flank(alpha: f64, half: f64) -> Line {
    Line {
        point: Vector::ZERO,
        direction: Vector::new(-alpha.sin(), alpha.cos(), 0.0),
        range: [-half, half],
    }
}

/// A rack's straight flank generates the involute of the circle r cos α: place, normal tangent to the base circle, curvature 1/ρ.
#[test]
fn exact_rack_to_involute() {
    let (r, alpha) = (34.0, 20f64.to_radians());
    let envelope = plane_envelope(
        rack_flank(alpha, 6.0),
        rack_rolling::<Work, Rack>(r, 0.0),
        [-1.0, 1.0],
    );
    let base = r * alpha.cos();
    let start = 0.5 * PI - involute(alpha.cos());
    let (mut places, mut normals, mut curvatures) = (0f64, 0f64, 0f64);
    for i in -30..=35 {
        let x = 0.01 * f64::from(i);
        let Some(point) = envelope.flank([x, 0.0]) else {
            continue;
        };
        let p = point.profile();
        let radius = f64::hypot(p.point[0], p.point[1]);
        let azimuth = f64::atan2(p.point[1], p.point[0]);
        let moment = p.point[0] * p.normal[1] - p.point[1] * p.normal[0];
        normals = normals.max((moment.abs() / base - 1.0).abs());
        let expected = start + involute(base / radius);
        places = places.max((azimuth - expected).abs());
        let rho = ((radius - base) * (radius + base)).sqrt();
        curvatures = curvatures.max((p.curvature * rho + 1.0).abs());
    }
    within("azimuth of the involute", places, 1e-15);
    within("base radius by the normal", normals, 1e-15);
    within("curvature", curvatures, 1e-12);
}

/// Undercut of a rack begins where its straight flank ends: D = 0 at the base circle, at the roll angle −tan α of the flank.
#[test]
fn exact_undercut_of_a_rack() {
    let (r, alpha) = (34.0, 20f64.to_radians());
    let envelope = plane_envelope(
        rack_flank(alpha, 8.0),
        rack_rolling::<Work, Rack>(r, 0.0),
        [-1.0, 1.0],
    );
    let found = limit_points(&envelope, Limit::Undercut, [[-1.0, 0.0], [1.0, 0.0]], 40);
    assert_eq!(found.len(), 1);
    let p = found[0].profile();
    within("roll at the limit", (p.x - alpha.tan()).abs(), 1e-15);
    let radius = f64::hypot(p.point[0], p.point[1]);
    within(
        "limit radius",
        (radius / (r * alpha.cos()) - 1.0).abs(),
        1e-15,
    );
    // Depth of the rack below the pitch line at which undercut begins: r sin²α.
    let depth = -p.u * alpha.cos();
    within(
        "depth of the rack",
        (depth / (r * alpha.sin().powi(2)) - 1.0).abs(),
        1e-14,
    );
}

/// A rack cuts a shaper, the shaper cuts an external gear of 40 and a ring of 60 teeth: involutes of the expected base circles, whose
/// normals touch the base circle and whose curvatures are those of the involute.
#[test]
fn exact_shaper_from_a_rack() {
    let (m, alpha) = (3.0, 20f64.to_radians());
    let z0 = 24.0;
    let shaper = plane_envelope(
        rack_flank(alpha, 4.0),
        rack_rolling::<Shaper, Rack>(0.5 * m * z0, 0.0),
        [-0.5, 0.36],
    );
    for (name, z, internal) in [("external 40", 40.0, false), ("internal 60", 60.0, true)] {
        // The shaper's pitch point, on its positive y axis, is turned towards the gear's centre.
        let centre_distance = if internal {
            -0.5 * m * (z - z0)
        } else {
            0.5 * m * (z + z0)
        };
        let ratio = if internal { z0 / z } else { -z0 / z };
        let towards = Pose::<Shaper, Shaper>::turned(Vector::Z, -0.5 * PI);
        let motion = gear_rolling::<Work, Shaper>(centre_distance, Law::linear(ratio));
        let turned = Motion::fixed(towards).followed_by(motion);
        let gear = Envelope {
            surface: &shaper,
            motion: turned,
            range: [-0.6, 0.6],
        };
        let base = 0.5 * m * z * alpha.cos();
        let (mut radius_error, mut curvature_error, mut count) = (0f64, 0f64, 0);
        for i in -30..=30 {
            let Some(point) = gear.flank([0.01 * f64::from(i), 0.0]) else {
                continue;
            };
            let p = point.profile();
            let moment = p.point[0] * p.normal[1] - p.point[1] * p.normal[0];
            radius_error = radius_error.max((moment.abs() - base).abs());
            let radius = f64::hypot(p.point[0], p.point[1]);
            let rho = ((radius - base) * (radius + base)).sqrt();
            curvature_error = curvature_error.max((p.curvature.abs() - 1.0 / rho).abs());
            count += 1;
        }
        assert!(count > 30, "{count}");
        within(&format!("{name}: base radius, mm"), radius_error, 1e-12);
        within(&format!("{name}: curvature, 1/mm"), curvature_error, 1e-13);
    }
}
