//! Rough settings from spiral angle and blank: the flank lies on its blank with the spiral angle.

use geardyn::internals::gear::bevel::blank::Blank;
use geardyn::internals::gear::bevel::cutter::{Blade, Cutter};
use geardyn::internals::gear::bevel::flank::BevelFlank;
use geardyn::internals::gear::bevel::rough_settings::rough_settings;
use geardyn::internals::gear::bevel::settings::Hand;
use geardyn::internals::gear::bevel::structure_elements::StructureElements;

/// Shaft angles from 40° to 130°, ratios 1 to 5, pitch angles from 9° to 86°, spiral angles from 0° (Zerol) to 45°, both blades and hands: the cutter reaches the middle
/// of the tooth, the spiral angle there is within 2° of the stated one with the hand's sign, the pressure angle within 3° of the blade angle.
#[test]
fn law_rough_settings_give_the_spiral_angle() {
    let mut count = 0;
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
                        let settings = rough_settings(&blank, 76.0, beta.to_radians());
                        let flank =
                            BevelFlank::new(&cutter, &settings, hand, blank.section().unwrap());
                        let near = flank.middle();
                        let near = near.unwrap_or_else(|| panic!("{shaft_angle} {ratio} {beta}"));
                        let mean = flank.tooth_point(blank.mean_point(), near).unwrap();
                        let e = StructureElements::of(&mean.point).unwrap();
                        let spiral = hand.sign() * e.spiral_angle.to_degrees();
                        let pressure = e.pressure_angle.to_degrees();
                        assert!((spiral - beta).abs() < 2.0, "{spiral} for {beta}");
                        assert!((pressure - 20.0).abs() < 3.0, "{pressure}");
                        count += 1;
                    }
                }
            }
        }
    }
    assert!(count > 100, "{count}");
}
