//! Largest edge radii of the blades that cut a pair of blanks: without running interference, as the blade's point carries them, without
//! mutilation of the opposite flank.
//!
//! AGMA 929-B22, 4.6, both members generated and completed; numbers in brackets are its equations.

use super::iso23509::BlankPair;

/// A blade's point keeps this flat between its edge radii (144)–(147), m.
const FLAT: f64 = 0.2e-3;
/// Depth to which the blade of one flank may cut the opposite fillet (154)–(161), m.
const MUTILATION: f64 = 0.05e-3;

/// Largest edge radii of pinion and wheel, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeRadii {
    /// Without contact of the mate's tip and the fillet at the toe (128)–(135); below zero where the tip reaches beneath the flank of a sharp
    /// blade. None with an internal wheel.
    pub without_interference: Option<[f64; 2]>,
    /// On the blade's point (144)–(151).
    pub carried: [f64; 2],
    /// Without mutilation (158)–(163).
    pub without_mutilation: [f64; 2],
}

/// The virtual cylindrical gears of the toe; lengths in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VirtualToe {
    /// Pitch radii (100), (101).
    pub radii: [f64; 2],
    /// Addenda (102), (103).
    pub addenda: [f64; 2],
    /// Dedenda.
    pub dedenda: [f64; 2],
    /// Depths by which the pitch circles approach without backlash (104), (105).
    pub approach: [f64; 2],
}

impl VirtualToe {
    fn of(pair: &BlankPair, dedenda: [f64; 2]) -> VirtualToe {
        let [toe, heel] = [0, 1].map(|end| pair.blanks.map(|b| b.cone_distances()[end]));
        let cosines = pair.end_spiral_angles.map(|angles| angles.map(f64::cos));
        let mean = |k: usize| pair.blanks[k].mean_cone_distance * pair.spiral_angles[k].cos();
        let [drive, coast] = pair.pressure_angles;
        // (51)–(53).
        let play =
            std::f64::consts::PI * pair.normal_module - pair.thicknesses[0] - pair.thicknesses[1];
        let outer = play * heel[1] * cosines[1][0] * (0.5 * (drive + coast)).cos() / mean(1);
        let clearance = [0, 1].map(|k| {
            let share = toe[k] * cosines[k][1] / (heel[k] * cosines[k][0]);
            outer * share / (drive.sin() + coast.sin())
        });
        let teeth = [0, 1].map(|k| mean(k) * pair.blanks[k].pitch_angle.tan());
        let share = |k: usize| teeth[k] / (teeth[0] + teeth[1]);
        VirtualToe {
            radii: [0, 1]
                .map(|k| toe[k] * pair.blanks[k].pitch_angle.tan() / cosines[k][1].powi(2)),
            addenda: [1, 0].map(|other| dedenda[other] - pair.clearance),
            dedenda,
            approach: [0, 1].map(|k| clearance[1 - k] * share(k)),
        }
    }

    /// The edge radius at which the fillet of a member begins where the tip of its mate touches last, on flanks of a pressure angle (112)–(131).
    pub fn edge_radius(&self, member: usize, pressure_angle: f64) -> f64 {
        let (sin, cos) = pressure_angle.sin_cos();
        let tight = [0, 1].map(|k| self.radii[k] - self.approach[k]);
        let working = (self.radii[0] * cos / tight[0]).acos();
        let mate = 1 - member;
        let tip = self.radii[mate] + self.addenda[mate];
        let mate_roll = (tip * tip - (self.radii[mate] * cos).powi(2)).sqrt();
        let roll = (tight[0] + tight[1]) * working.sin() - mate_roll;
        let height = self.radii[member] * (cos * cos - 1.0) + roll * sin + self.dedenda[member];
        height / (1.0 - sin)
    }
}

impl EdgeRadii {
    /// The radii of a pair with its dedenda at the toe, least slot widths and blade points.
    pub(super) fn of(
        pair: &BlankPair,
        toe_dedenda: [f64; 2],
        slots: [f64; 2],
        blade_points: [f64; 2],
    ) -> EdgeRadii {
        let toe = VirtualToe::of(pair, toe_dedenda);
        let least = |of: &dyn Fn(f64) -> f64| {
            let [drive, coast] = pair.pressure_angles.map(of);
            drive.min(coast)
        };
        let share = |alpha: f64| 1.0 / alpha.cos() - alpha.tan();
        let interfering = [0, 1].map(|k| least(&|alpha| toe.edge_radius(k, alpha)));
        let is_external = toe.radii.iter().all(|radius| *radius > 0.0);
        EdgeRadii {
            without_interference: is_external.then_some(interfering),
            carried: blade_points
                .map(|point| least(&|alpha| ((point - FLAT) / share(alpha)).max(0.0))),
            without_mutilation: [0, 1].map(|k| {
                let spare = slots[k] - blade_points[k];
                least(&|alpha| {
                    let across = spare * share(alpha);
                    let root = (MUTILATION * (MUTILATION + 2.0 * across)).max(0.0).sqrt();
                    (MUTILATION + across + root) / share(alpha).powi(2)
                })
            }),
        }
    }

    /// The least of the three; none with an internal wheel.
    pub fn largest(&self) -> Option<[f64; 2]> {
        let interfering = self.without_interference?;
        Some([0, 1].map(|k| {
            let both = self.carried[k].min(self.without_mutilation[k]);
            both.min(interfering[k])
        }))
    }
}
