//! Rough settings from spiral angle and blank: the flank has both angles at the mean point, and a pair of flanks touches there.

use geardyn::internals::gear::bevel::blank::Blank;
use geardyn::internals::gear::bevel::cutter::{Blade, Cutter};
use geardyn::internals::gear::bevel::flank::BevelFlank;
use geardyn::internals::gear::bevel::iso23509::{BlankDesign, BlankPair, PitchCones};
use geardyn::internals::gear::bevel::rough_settings::rough_settings;
use geardyn::internals::gear::bevel::settings::MachineSettings;
use geardyn::internals::gear::bevel::structure_elements::StructureElements;
use geardyn::internals::gear::contact::pair::{Assembly, FlankPair};
use geardyn::internals::gear::hand::Hand;
use geardyn::internals::gear::kernel::vector::Vector;

use crate::verification::within;

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
                    // A pitch apex apart from the crossing point, as of hypoids: all cones lie so much nearer to it.
                    let mut blank = Blank::of_one_apex(angles, 80.0, 22.0);
                    (blank.pitch_apex, blank.face_apex, blank.root_apex) = (4.0, 4.2, 3.9);
                    for blade in [Blade::Inside, Blade::Outside] {
                        let cutter = Cutter::straight(blade, 76.0, 20f64.to_radians());
                        let generated = rough_settings(&blank, &cutter, beta.to_radians());
                        // The same settings without the roll leave a formate flank of the same angles.
                        let formate = MachineSettings {
                            roll: None,
                            ..generated
                        };
                        for settings in [generated, formate] {
                            let flank =
                                BevelFlank::new(&cutter, &settings, hand, blank.section().unwrap());
                            let near = flank.middle();
                            let near =
                                near.unwrap_or_else(|| panic!("{shaft_angle} {ratio} {beta}"));
                            let mean = flank.tooth_point(blank.mean_point(), near).unwrap();
                            let e = StructureElements::of(&mean.point, blank.pitch_apex).unwrap();
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
            let cutter = Cutter::straight(blade, point_radius, 20f64.to_radians());
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

/// Random hypoid pairs by method 1, shaft angles from 70° to 110°, offsets of both signs to 0.2 of the wheel's diameter: with the generated
/// pressure angles as blade angles the mating flanks, drive and coast, have one normal where the circles of both mean points meet, and roll
/// there at the ratio of the tooth numbers without parting.
#[test]
fn law_rough_hypoids_touch_at_their_mean_points() {
    let rng = &mut fastrand::Rng::with_seed(13);
    let mut between = |low: f64, high: f64| low + (high - low) * rng.f64();
    let (mut count, mut worst) = (0, [0f64; 3]);
    for k in 0..60 {
        let pinion_teeth = between(9.0, 16.0).round();
        let offset = (2.0 * f64::from(k % 2) - 1.0) * between(4.0, 34.0);
        let design = BlankDesign {
            method: PitchCones::Hypoid {
                offset,
                pinion_spiral_angle: between(38.0, 50.0).to_radians(),
            },
            teeth: [pinion_teeth, pinion_teeth * between(2.0, 4.5)].map(|z| z as u32),
            shaft_angle: between(70.0, 110.0).to_radians(),
            outer_pitch_diameter: 170.0,
            face_width: 26.0,
            cutter_radius: between(63.0, 95.0),
            pressure_angles: [20f64.to_radians(); 2],
            limit_influence: between(0.0, 1.0),
            addendum_factor: 0.35,
            depth_factor: 2.0,
            clearance_factor: 0.125,
            thickness_factor: 0.1,
            backlash: 0.1,
            depth_angles: [1f64.to_radians(), 3.5f64.to_radians()],
        };
        // A wheel of a larger spiral angle is no gear: its flank passes the mean point a second time.
        let gear_like = |pair: &BlankPair| pair.spiral_angles[1].abs() < 65f64.to_radians();
        let Some(blanks) = design.blanks().ok().filter(gear_like) else {
            continue;
        };
        let assembly = Assembly {
            shaft_angle: design.shaft_angle,
            offset,
            ..Assembly::default()
        };
        for (flanks, angle) in [
            ([Blade::Outside, Blade::Inside], blanks.pressure_angles[0]),
            ([Blade::Inside, Blade::Outside], blanks.pressure_angles[1]),
        ] {
            let hands = [Hand::Right, Hand::Left];
            let flanks = [0, 1].map(|member| {
                let blank = &blanks.blanks[member];
                let cutter = Cutter::straight(flanks[member], design.cutter_radius, angle);
                let settings = rough_settings(blank, &cutter, blanks.spiral_angles[member]);
                BevelFlank::new(&cutter, &settings, hands[member], blank.section().unwrap())
            });
            let means = [0, 1].map(|member| {
                let near = flanks[member].middle()?;
                flanks[member].tooth_point(blanks.blanks[member].mean_point(), near)
            });
            let [Some(pinion), Some(gear)] = means else {
                continue;
            };
            let pair = FlankPair::new(flanks, design.teeth, hands[0], &assembly);
            // The circle of the pinion's mean point passes the plane of the gear's twice: once on the circle of the gear's.
            let ([z_1, r_1], [z_2, r_2]) =
                (blanks.blanks[0].mean_point(), blanks.blanks[1].mean_point());
            let (sin, cos) = design.shaft_angle.sin_cos();
            let x = (z_2 - z_1 * cos) / sin;
            let y = (r_1 * r_1 - x * x).sqrt();
            let radius = |y: f64| f64::hypot(y + offset, x * cos - z_1 * sin) - r_2;
            let y = if radius(y).abs() < radius(-y).abs() {
                y
            } else {
                -y
            };
            worst[0] = worst[0].max(radius(y).abs());
            let place = Vector::new(x, y, z_1);
            let at = [pinion.point, gear.point];
            let angles = [0, 1].map(|member| {
                let pose = pair.pose(member, 0.0);
                let [e_x, e_y, _] = pose.rotation;
                let off = place - pose.translation;
                let own = at[member].point.coordinates;
                off.dot(e_y).atan2(off.dot(e_x)) - own.y.atan2(own.x)
            });
            let normals = [0, 1].map(|member| {
                let [e_x, e_y, e_z] = pair.pose(member, angles[member]).rotation;
                let n = at[member].normal.components;
                e_x * n.x + e_y * n.y + e_z * n.z
            });
            let velocities = [0, 1].map(|member| {
                let axis = pair.turn(member).w;
                axis.cross(place - pair.centre(member))
            });
            let sliding = velocities[0] - velocities[1] * pair.ratio();
            worst[1] = worst[1].max((normals[0] + normals[1]).norm());
            worst[2] = worst[2].max(sliding.dot(normals[0]).abs() / velocities[0].norm());
            count += 1;
        }
    }
    assert!(count > 100, "{count}");
    within("circles of the mean points apart, mm", worst[0], 1e-7);
    within("normals apart, rad", worst[1], 1e-8);
    within("parting speed, relative", worst[2], 1e-8);
}
