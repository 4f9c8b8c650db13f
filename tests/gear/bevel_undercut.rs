//! The limit of undercut along a bevel flank.

use std::f64::consts::FRAC_PI_2;

use geardyn::internals::gear::bevel::cutter::{Blade, Cutter};
use geardyn::internals::gear::bevel::flank::BevelFlank;
use geardyn::internals::gear::bevel::flank_grid::FlankGrid;
use geardyn::internals::gear::bevel::flank_lines::FlankLimits;
use geardyn::internals::gear::bevel::iso23509::{BlankDesign, PitchCones};
use geardyn::internals::gear::bevel::rough_settings::rough_settings;
use geardyn::internals::gear::hand::Hand;
use geardyn::internals::gear::kernel::limits::{Limit, limit_points};

use crate::verification::{printed, within};

/// The pinion of 5 and 60 teeth that rough settings undercut: at every step of the cradle the limit found across the cutter is where that along
/// the line from tip to root at its share of the face is found; the highest place is at the heel, 1.50 mm above the root, whatever the edge radius.
/// Source: D = 0 by differences of a Python envelope at fixed cradle angles, 1.497 mm at 97.7 % and 1.512 mm at 112.8 % of the face.
#[test]
fn ref_undercut_along_a_flank() {
    let design = BlankDesign {
        method: PitchCones::Bevel {
            spiral_angle: 35f64.to_radians(),
        },
        teeth: [5, 60],
        shaft_angle: FRAC_PI_2,
        outer_pitch_diameter: 205.0,
        face_width: 32.0,
        cutter_radius: 95.25,
        pressure_angles: [20f64.to_radians(); 2],
        limit_influence: 0.0,
        addendum_factor: 0.3,
        depth_factor: 2.0,
        clearance_factor: 0.125,
        thickness_factor: 0.0,
        backlash: 0.15,
        depth_angles: [1f64.to_radians(), 3.5f64.to_radians()],
    };
    let [blank, _] = design.blanks().unwrap().blanks;
    let section = blank.section().unwrap();
    let heights = [(Blade::Outside, 95.0), (Blade::Inside, 95.5)].map(|(blade, point_radius)| {
        let heights = [0.0, 0.8].map(|edge_radius| {
            let cutter = Cutter {
                edge_radius,
                ..Cutter::straight(blade, point_radius, 20f64.to_radians())
            };
            let settings = rough_settings(&blank, &cutter, 35f64.to_radians());
            let flank = BevelFlank::new(&cutter, &settings, Hand::Left, section);
            let grid = FlankGrid::of(&flank, 9, 15).unwrap();
            let [[from, to], _] = grid.ranges().unwrap();
            let [_, theta] = grid.domain().unwrap();
            let (mut count, mut worst) = (0, 0f64);
            for k in 0..=40 {
                let x = from + (to - from) * f64::from(k) / 40.0;
                let line = [[x, theta[0]], [x, theta[1]]];
                for p in limit_points(&flank.envelope, Limit::Undercut, line, 200) {
                    let r = p.point.coordinates;
                    let place = [r.z, f64::hypot(r.x, r.y)];
                    let [face, height] = section.shares(place).unwrap();
                    if !(0.0..=1.0).contains(&face) || !(0.0..=1.0).contains(&height) {
                        continue;
                    }
                    let [_, near] = grid.ends_of_column(face).unwrap();
                    let found = flank.undercut_limit(face, near).unwrap();
                    let r = found.point.coordinates;
                    let [_, found] = section.shares([r.z, f64::hypot(r.x, r.y)]).unwrap();
                    worst = worst.max((found - height).abs());
                    count += 1;
                }
            }
            assert!(count >= 10, "{count}");
            within("height of the limit, of the depth", worst, 1e-9);
            let limits = FlankLimits::of(&flank, &grid, |_| true);
            let [curve] = &limits.curves[0][..] else {
                panic!("one curve")
            };
            assert!(curve[0][0] < 1e-9 && curve[curve.len() - 1][0] > 1.0 - 1e-9);
            let [face, height] = limits.highest[0].unwrap();
            assert!(face > 0.999, "{face}");
            let [z, radius] = section.up(face);
            height * f64::hypot(z, radius)
        });
        within(
            "with and without edge radius, mm",
            (heights[0] - heights[1]).abs(),
            1e-9,
        );
        heights[0]
    });
    // Interpolated between both places of the source.
    printed(
        "highest place of the concave flank",
        "mm",
        1.4993,
        heights[0],
        0.002,
    );
    assert!(heights[1] > 1.4, "{heights:?}");
}
