//! Rough settings from spiral angle and blank: the flank has both angles at the mean point, and a pair of flanks touches there.

use geardyn::internals::gear::bevel::blank::Blank;
use geardyn::internals::gear::bevel::cutter::{Blade, Cutter};
use geardyn::internals::gear::bevel::flank::BevelFlank;
use geardyn::internals::gear::bevel::rough_settings::rough_settings;
use geardyn::internals::gear::bevel::settings::Hand;
use geardyn::internals::gear::bevel::structure_elements::StructureElements;
use geardyn::internals::gear::contact::pair::{Assembly, FlankPair};

/// Shaft angles from 40° to 130°, ratios 1 to 5, pitch angles from 9° to 86°, spiral angles from 0° (Zerol) to 45°, both blades and hands: at
/// the mean point the spiral angle is the stated one with the hand's sign and the pressure angle that of the blade.
#[test]
fn law_rough_settings_give_the_spiral_angle() {
    let (mut count, mut worst) = (0, 0f64);
    for shaft_angle in [40f64, 90.0, 130.0] {
        for ratio in [1.0, 2.5, 5.0] {
            for beta in [0.0, 15.0, 35.0, 45.0f64] {
                let sigma = shaft_angle.to_radians();
                let pinion = sigma.sin().atan2(sigma.cos() + ratio);
                for (pitch, hand) in [(pinion, Hand::Right), (sigma - pinion, Hand::Left)] {
                    if !(0.15..1.5).contains(&pitch) {
                        continue;
                    }
                    let angles = [pitch, pitch + 0.03, pitch - 0.035];
                    let blank = Blank::of_one_apex(angles, 80.0, 22.0);
                    for blade in [Blade::Inside, Blade::Outside] {
                        let cutter = Cutter {
                            blade,
                            point_radius: 76.0,
                            blade_angle: 20f64.to_radians(),
                            edge_radius: 0.0,
                        };
                        let settings = rough_settings(&blank, &cutter, beta.to_radians());
                        let flank =
                            BevelFlank::new(&cutter, &settings, hand, blank.section().unwrap());
                        let near = flank.middle();
                        let near = near.unwrap_or_else(|| panic!("{shaft_angle} {ratio} {beta}"));
                        let mean = flank.tooth_point(blank.mean_point(), near).unwrap();
                        let e = StructureElements::of(&mean.point).unwrap();
                        let spiral = hand.sign() * e.spiral_angle.to_degrees();
                        let pressure = e.pressure_angle.to_degrees();
                        worst = worst.max((spiral - beta).abs());
                        worst = worst.max((pressure - 20.0).abs());
                        count += 1;
                    }
                }
            }
        }
    }
    assert!(count > 100, "{count}");
    assert!(worst < 1e-9, "{worst}°");
}

/// Random pairs on meeting axes, shaft angles from 60° to 120°, ratios from 1 to 6, spiral angles to 40°, dedendum angles of their own: the
/// mating flanks touch at the mean points of both blanks, where the ratio is that of the tooth numbers.
#[test]
fn law_rough_pairs_touch_at_their_mean_points() {
    let rng = &mut fastrand::Rng::with_seed(11);
    let mut between = |low: f64, high: f64| low + (high - low) * rng.f64();
    for k in 0..60 {
        let sigma = between(60.0, 120.0).to_radians();
        let pinion_teeth = between(10.0, 20.0).round();
        let teeth = [pinion_teeth, (pinion_teeth * between(1.0, 6.0)).round()];
        let pitch = sigma.sin().atan2(sigma.cos() + teeth[1] / teeth[0]);
        let beta = between(0.0, 40.0).to_radians();
        let depth = 2.0 * pitch.sin() / teeth[0] * beta.cos();
        let radius = between(60.0, 100.0);
        // The pinion's concave flank is cut on the larger radius: the contact is crowned.
        let flanks = [
            (pitch, Hand::Right, Blade::Outside, radius + 1.0, 1.3),
            (sigma - pitch, Hand::Left, Blade::Inside, radius - 1.0, 0.7),
        ];
        let mut points = Vec::new();
        let flanks = flanks.map(|(pitch, hand, blade, point_radius, share)| {
            let angles = [pitch, pitch + share * depth, pitch - (2.2 - share) * depth];
            let blank = Blank::of_one_apex(angles, 80.0, 20.0);
            let cutter = Cutter {
                blade,
                point_radius,
                blade_angle: 20f64.to_radians(),
                edge_radius: 0.0,
            };
            points.push(blank.mean_point());
            let settings = rough_settings(&blank, &cutter, beta);
            BevelFlank::new(&cutter, &settings, hand, blank.section().unwrap())
        });
        let assembly = Assembly {
            shaft_angle: sigma,
            ..Assembly::default()
        };
        let pair = FlankPair::new(flanks, teeth.map(|z| z as u32), Hand::Right, &assembly);
        let path = pair
            .path_near_teeth(1.0, 20)
            .unwrap_or_else(|| panic!("{k}"));
        let reference = path.reference;
        assert!((reference.ratio() - pair.ratio()).abs() < 1e-9, "{k}");
        for member in 0..2 {
            let off = reference.point - pair.centre(member);
            let axis = pair.turn(member).w;
            let place = [off.dot(axis), axis.cross(off).norm()];
            let apart = [0, 1].map(|i| (place[i] - points[member][i]).abs());
            assert!(
                apart.iter().all(|x| *x < 1e-5),
                "{k} {member}: {apart:?} mm"
            );
        }
    }
}
