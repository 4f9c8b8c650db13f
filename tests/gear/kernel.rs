//! The kernel of meshing against closed forms: involute, helicoids, canal surface, generated shapers, hobs.

use std::f64::consts::PI;

use geardyn::internals::gear::kernel::envelope::Envelope;
use geardyn::internals::gear::kernel::law::Law;
use geardyn::internals::gear::kernel::limits::{Limit, limit_points};
use geardyn::internals::gear::kernel::motion::Motion;
use geardyn::internals::gear::kernel::plane::{
    ProfilePoint, gear_rolling, plane_envelope, rack_rolling,
};
use geardyn::internals::gear::kernel::pose::{Point, Pose};
use geardyn::internals::gear::kernel::tool::Arc;
use geardyn::internals::gear::kernel::vector::Vector;

use crate::verification::{printed, within};

#[derive(Debug, Clone, Copy, PartialEq)]
struct Rack;
#[derive(Debug, Clone, Copy, PartialEq)]
struct Shaper;
#[derive(Debug, Clone, Copy, PartialEq)]
struct Work;

/// Polar angle of the involute at pressure angle α: tan α − α.
fn involute(cos_alpha: f64) -> f64 {
    let alpha = cos_alpha.acos();
    alpha.tan() - alpha
}

/// The straight flank of a rack that makes the right flank of a tooth: the metal of the work on its left.
fn rack_flank(alpha: f64, half: f64) -> Arc {
    Arc::straight(
        Vector::ZERO,
        Vector::new(-alpha.sin(), alpha.cos(), 0.0),
        [-half, half],
    )
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

/// The arc of a rack's tip makes the fillet: offset by its radius, along the line to the pitch point, from the path of its centre.
#[test]
fn exact_fillet_of_a_tip_arc() {
    let (r, alpha, rho) = (34.0, 20f64.to_radians(), 1.2);
    // Centre of the arc below the pitch line; the rounding lies between the tip line and the straight flank.
    let centre = Vector::new(1.9, -2.3, 0.0);
    // The gear's metal lies outside the circle: the arc runs clockwise.
    let arc = Arc::about(centre, rho, [Vector::Y, Vector::X], [0.5 * PI + alpha, PI]);
    let motion = rack_rolling::<Work, Rack>(r, 0.4);
    let envelope = plane_envelope(arc, motion, [-1.0, 1.0]);
    let (mut places, mut normals, mut curvatures, mut count) = (0f64, 0f64, 0f64, 0);
    for i in 1..20 {
        let u = arc.range[0] + (arc.range[1] - arc.range[0]) * f64::from(i) / 20.0;
        let contacts = envelope.motion_parameters([u, 0.0]);
        assert_eq!(contacts.len(), 1, "{u}");
        let x = contacts[0];
        let p = envelope.point([u, 0.0, x]).unwrap().profile();
        let pose = envelope.motion.pose(x);
        let at = |point: Vector| (pose * Point::<Rack>::new(point)).coordinates;
        // The pitch point lies on the line from the gear's centre across the rack.
        let pitch_point = at(Vector::new(r * x, -0.4, 0.0));
        let towards = (at(centre) - pitch_point).unit().unwrap();
        let expected = at(centre) + rho * towards;
        let found = Vector::new(p.point[0], p.point[1], 0.0);
        places = places.max((found - expected).norm());
        let n = Vector::new(p.normal[0], p.normal[1], 0.0);
        normals = normals.max((n + towards).norm());
        // Euler–Savary for a rack on a circle: (1/PA₂ − 1/PA₁) cos = 1/r, PA from the pitch point to both centres of curvature.
        let to_centre = (at(centre) - pitch_point).norm();
        curvatures = curvatures.max(savary(&p, pitch_point, r, to_centre));
        count += 1;
        let again = envelope.flank([x, 0.0]).unwrap().profile();
        places = places.max((again.u - u).abs());
    }
    assert_eq!(count, 19);
    within("place, mm", places, 1e-13);
    within("normal", normals, 1e-13);
    within("centre of curvature by Euler and Savary", curvatures, 1e-12);
}

/// Residual of Euler and Savary's equation `(1/PA₁ − 1/PA₂) sin = 1/R` of a rack's point with its centre of curvature at a signed distance
/// `first` beyond the pitch point, on a pitch circle of radius `r`.
fn savary(p: &ProfilePoint, pitch_point: Vector, r: f64, first: f64) -> f64 {
    let point = Vector::new(p.point[0], p.point[1], 0.0);
    let normal = Vector::new(p.normal[0], p.normal[1], 0.0);
    // dn = −κ dr: the centre of curvature lies at r + n/κ.
    let centre = point + normal * (1.0 / p.curvature);
    let along = (point - pitch_point).unit().unwrap();
    let second = (centre - pitch_point).dot(along);
    let outward = pitch_point.unit().unwrap();
    ((1.0 / second - 1.0 / first) * along.dot(outward) + 1.0 / r).abs() * r
}

/// Conjugate of a circular arc where the ratio falls linearly with the angle: every contact normal passes the instant centre, and the turn
/// of gear 2 is that of the handbook.
/// Source: worked example of a linear ratio, a = 100, i₀ = 2, K = 0.3183098862: φ₂ = 84.600653° and i = 1.25 at φ₁ = 135°.
#[test]
fn ref_conjugate_under_a_linear_ratio() {
    let (a, i0) = (100.0, 2.0);
    // i falls to 1/2 at 270°.
    let k = (i0 - 0.5) / 270f64.to_radians();
    // φ₂ = −(1/K) ln(1 − K φ₁/i₀), opposite to gear 1.
    let law = move |x: f64| {
        let left = i0 - k * x;
        [(-k * x / i0).ln_1p() / k, -1.0 / left, -k / (left * left)]
    };
    let turn = -law(135f64.to_radians())[0].to_degrees();
    printed("turn of gear 2", "°", 84.600653, turn, 5e-7);
    // A convex flank of gear 1 through the pitch point at φ₁ = 135°: there r₁ = 44.4444.
    let at = 135f64.to_radians();
    let pitch_radius = 44.0 + 4.0 / 9.0;
    let radial = Vector::new(at.cos(), -at.sin(), 0.0);
    let across = Vector::new(at.sin(), at.cos(), 0.0);
    let inward = -across * 20f64.to_radians().cos() - radial * 20f64.to_radians().sin();
    let arc = Arc::about(
        pitch_radius * radial + 20.0 * inward,
        20.0,
        [-inward, Vector::Z.cross(inward)],
        [-0.2, 0.2],
    );
    let motion = gear_rolling::<Work, Rack>(a, Law::function(law));
    let envelope = plane_envelope(arc, motion, [at - 0.4, at + 0.4]);
    let (mut law_of_gearing, mut count) = (0f64, 0);
    for i in -10..=10 {
        for x in envelope.motion_parameters([0.2 * f64::from(i), 0.0]) {
            let p = envelope
                .point([0.2 * f64::from(i), 0.0, x])
                .unwrap()
                .profile();
            // In gear 1: the instant centre on the line of centres, r₁ = a i₂₁/(1 + i₂₁).
            let ratio = -law(x)[1];
            let r1 = a * ratio / (1.0 + ratio);
            let centre = Point::<Rack>::new(Vector::new(r1 * x.cos(), -r1 * x.sin(), 0.0));
            let centre = (envelope.motion.pose(x) * centre).coordinates;
            let off = Vector::new(p.point[0], p.point[1], 0.0) - centre;
            law_of_gearing =
                law_of_gearing.max((off.x * p.normal[1] - off.y * p.normal[0]).abs() / a);
            count += 1;
        }
    }
    assert!(count > 10, "{count}");
    within(
        "normal past the instant centre, of the centre distance",
        law_of_gearing,
        1e-14,
    );
}
