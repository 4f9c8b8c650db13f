//! Chips of the blades that cut a slot from the solid.

use geardyn::internals::gear::bevel::cutter::{Blade, Cutter};
use geardyn::internals::gear::bevel::flank_grid::FlankGrid;
use geardyn::internals::gear::bevel::frames::{CutterFrame, WorkFrame};
use geardyn::internals::gear::bevel::tooth_section::Side;
use geardyn::internals::gear::cut::chips::ChipCutter;
use geardyn::internals::gear::cut::cutter_head::{BladeFeed, BladeOffset};
use geardyn::internals::gear::kernel::law::Law;
use geardyn::internals::gear::kernel::motion::Motion;
use geardyn::internals::gear::kernel::pose::{Pose, Transform};
use geardyn::internals::gear::kernel::twist::Twist;
use geardyn::internals::gear::kernel::vector::Vector;

use crate::bevel_flank::nasa_cut;
use crate::cases::{case, number};
use crate::verification::within;

/// A cutter of two blades, 80 and 82 mm, m.
fn straight(blade: Blade) -> Cutter {
    Cutter::straight(
        blade,
        if blade == Blade::Inside { 0.080 } else { 0.082 },
        0.35,
    )
}

/// A cutter that plunges along its axis into a flat face: passes at the depths `d` and `d − f` leave the chip `A(d) − A(d − f)`,
/// `A(d) = w d + d² tan α`, as the area of a trapezoid; a blade that stands out by e cuts e deeper and the next one e less.
#[test]
fn exact_chip_of_a_plunge() {
    let [inside, outside] = [Blade::Inside, Blade::Outside].map(straight);
    let feed = BladeFeed {
        blades: 8,
        cradle_per_turn: 0.8,
    };
    // 0.1 mm for a pass.
    let rest = Pose::<WorkFrame, CutterFrame>::new(Transform::IDENTITY);
    let motion = Motion::fixed(rest).joint(Twist::slide(Vector::Z), Law::linear(1e-3));
    let blank = vec![[-1.0, 0.0, 0.0]];
    let of = |offsets: &[BladeOffset]| {
        let space = (blank.clone(), 0.01);
        ChipCutter::new(
            [&inside, &outside],
            motion.clone(),
            space,
            (feed, offsets),
            0.0,
        )
    };
    let area = |d: f64| d.max(0.0) * 0.002 + d.max(0.0).powi(2) * 0.35f64.tan();
    let mut worst = 0f64;
    for pass in [1, 5, 20] {
        let d = f64::from(pass as i32) * 1e-4;
        let found = of(&[]).chip(pass, 0.0);
        let exact = area(d) - area(d - 1e-4);
        worst = worst.max((found.area / exact - 1.0).abs());
        assert!((found.volume / (found.area * 0.081) - 1.0).abs() < 1e-3);
    }
    within("chip area, relative", worst, 1e-2);
    let mut offsets = vec![BladeOffset::default(); 8];
    offsets[5].axial = 4e-5;
    let cut = of(&offsets);
    let mut worst = 0f64;
    for (pass, deep, before) in [(21, 2.14e-3, 2.0e-3), (22, 2.2e-3, 2.14e-3)] {
        let exact = area(deep) - area(before);
        worst = worst.max((cut.chip(pass, 0.0).area / exact - 1.0).abs());
    }
    within("chip area with run-out, relative", worst, 1e-2);
}

/// The chips of all passes through a slot of the report's gear, cut by one head in one setting, add up to the volume between its flanks
/// above the root.
#[test]
fn law_chips_fill_the_slot() {
    let case = case("c12_nasa_cr191009_flanks");
    // The report cuts both flanks in one setting by blades 0.065 in apart.
    let (inside, hand, section) = nasa_cut(&case, "gear_convex");
    let mut outside = inside;
    outside.cutter.blade = Blade::Outside;
    outside.cutter.point_radius = 3.0325;
    // The report's section begins its clearance above the root that the tips leave.
    let clearance = 0.999 * number(&case["flanks"]["gear_convex"]["cl"]);
    let mut section = section;
    for end in &mut section.corners {
        let [root, tip] = *end;
        let height = f64::hypot(tip[0] - root[0], tip[1] - root[1]);
        end[0] = [0, 1].map(|k| root[k] - clearance * (tip[k] - root[k]) / height);
    }
    let flanks = [outside, inside].map(|setup| setup.flank(hand, section));
    let blank = [Side::Tip, Side::Toe, Side::Heel].map(|side| section.side(side));
    let middle = flanks[0].middle().unwrap();
    let feed = |blades| BladeFeed {
        blades,
        cradle_per_turn: 8f64.to_radians(),
    };
    let of = |feed| {
        let cut = ChipCutter::new(
            [&inside.cutter, &outside.cutter],
            outside.machine.motion(hand),
            (blank.to_vec(), 1.5 * section.depth()),
            (feed, &[]),
            middle[1],
        );
        cut.chips(middle[2]).unwrap()
    };
    let n = 41;
    let grids = flanks.each_ref().map(|f| FlankGrid::of(f, n, n).unwrap());
    let mut slot = 0.0;
    // Close to the root the corners of the blades cut: there the width goes on straight.
    let mut widths = vec![[0.0; 2]; n];
    for row in (0..n).rev() {
        for column in 0..n {
            let nodes = grids.each_ref().map(|g| g.node(row, column));
            let [here, above] = widths[column];
            let mut width = 2.0 * here - above;
            if let [Some(a), Some(b)] = nodes {
                let [a, b] = [a, b].map(|node| node.point.point.coordinates);
                let apart = (a.y.atan2(a.x) - b.y.atan2(b.x)).abs();
                width = f64::hypot(a.x, a.y) * apart;
            }
            widths[column] = [width, here];
            let weight = |i: usize| if i == 0 || i == n - 1 { 0.5 } else { 1.0 };
            let [height, face] = [row, column].map(|i| i as f64 / (n - 1) as f64);
            let [[p, q], [s, t]] = section.corners;
            let along = [0, 1].map(|k| (1.0 - height) * (s[k] - p[k]) + height * (t[k] - q[k]));
            let up = section.up(face);
            let cell = (along[0] * up[1] - along[1] * up[0]).abs() / ((n - 1) * (n - 1)) as f64;
            slot += weight(row) * weight(column) * cell * width;
        }
    }
    let run = of(feed(16));
    within(
        "volume of all chips, relative",
        (run.volume / slot - 1.0).abs(),
        1e-2,
    );
    let finer = of(feed(32));
    within(
        "volume with twice the blades, relative",
        (finer.volume / run.volume - 1.0).abs(),
        5e-3,
    );
}
