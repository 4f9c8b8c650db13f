//! Settings of a face-mill generator and the motion of its cutter seen from the work.
//!
//! `work ← Rz(h φ_w) · T(0, 0, −X_D) · B(γ_m) · T(0, −h E_m, −X_B) · Rz(−h φ_c) · T(S_r cos q, h S_r sin q, 0) · Rz(h j) Ry(i) Rz(−h j)`
//! with `h = 1` for right-hand work and `B` the turn about y by `γ_m − 90°`: Litvin and Fuentes, Gear Geometry and Applied Theory, 2nd ed.
//! 2004, section 21.2, the hand written as one sign.

use std::f64::consts::FRAC_PI_2;

use super::frames::{CutterFrame, MachineFrame, WorkFrame};
use crate::gear::hand::Hand;
use crate::gear::kernel::law::Law;
use crate::gear::kernel::motion::Motion;
use crate::gear::kernel::pose::Pose;
use crate::gear::kernel::twist::Twist;
use crate::gear::kernel::vector::Vector;

/// Roll of the work with the cradle: `φ_w = R_a (φ_c − C φ_c² − D φ_c³ − E φ_c⁴ − F φ_c⁵)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Roll {
    /// Ratio of roll R_a, work over cradle.
    pub work_over_cradle: f64,
    /// Coefficients C, D, E, F of the modified roll.
    pub modification: [f64; 4],
}

impl Roll {
    /// A roll of constant ratio.
    pub fn constant(work_over_cradle: f64) -> Roll {
        Roll {
            work_over_cradle,
            modification: [0.0; 4],
        }
    }

    /// The roll of a setting sheet that gives 2C, 6D, 24E and 120F.
    pub fn from_sheet(work_over_cradle: f64, [c2, d6, e24, f120]: [f64; 4]) -> Roll {
        Roll {
            work_over_cradle,
            modification: [c2 / 2.0, d6 / 6.0, e24 / 24.0, f120 / 120.0],
        }
    }

    /// The turn of the work over that of the cradle.
    pub fn law(&self, sign: f64) -> Law {
        let (ratio, [c, d, e, f]) = (sign * self.work_over_cradle, self.modification);
        Law::Polynomial([0.0, ratio, -ratio * c, -ratio * d, -ratio * e, -ratio * f])
    }
}

/// Settings of a face-mill generator for one flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MachineSettings {
    /// Radial distance S_r, m.
    pub radial_distance: f64,
    /// Cradle angle q, rad.
    pub cradle_angle: f64,
    /// Blank offset E_m, m.
    pub blank_offset: f64,
    /// Sliding base X_B, m.
    pub sliding_base: f64,
    /// Helical motion X_B1: sliding base for a radian of the cradle, m.
    pub helical_motion: f64,
    /// Machine centre to back X_D, from the design apex, m.
    pub centre_to_back: f64,
    /// Machine root angle γ_m, rad.
    pub machine_root_angle: f64,
    /// Tilt i, rad.
    pub tilt: f64,
    /// Swivel j, rad.
    pub swivel: f64,
    /// Roll of generated work; none for formate work.
    pub roll: Option<Roll>,
}

impl MachineSettings {
    /// The cutter's motion in the frame of the work over the cradle's turn φ_c.
    pub fn motion(&self, hand: Hand) -> Motion<WorkFrame, CutterFrame> {
        self.motion_with_errors(hand, [None, None])
    }

    /// The motion where cradle and work are ahead of their roll by angles over φ_c, rad; formate work has neither.
    pub fn motion_with_errors(
        &self,
        hand: Hand,
        [cradle_error, work_error]: [Option<Law>; 2],
    ) -> Motion<WorkFrame, CutterFrame> {
        let h = hand.sign();
        let turned = Pose::<CutterFrame, CutterFrame>::turned;
        let (swivel, tilt) = (h * self.swivel, self.tilt);
        let tilted =
            turned(Vector::Z, swivel) * turned(Vector::Y, tilt) * turned(Vector::Z, -swivel);
        let (sin, cos) = self.cradle_angle.sin_cos();
        let centre = Vector::new(cos, h * sin, 0.0) * self.radial_distance;
        let offset = Vector::new(0.0, -h * self.blank_offset, -self.sliding_base);
        let axis = Twist::turn(Vector::Z, Vector::ZERO);
        let at_cradle = Pose::<MachineFrame, CutterFrame>::shifted(centre) * tilted;
        let towards_work = Pose::<WorkFrame, WorkFrame>::shifted(-self.centre_to_back * Vector::Z)
            * Pose::<WorkFrame, MachineFrame>::turned(
                Vector::Y,
                self.machine_root_angle - FRAC_PI_2,
            )
            * Pose::<MachineFrame, MachineFrame>::shifted(offset);
        let Some(roll) = &self.roll else {
            return Motion::fixed(towards_work * at_cradle);
        };
        let mut in_machine = Motion::fixed(at_cradle).joint(axis, Law::linear(-h));
        if let Some(error) = cradle_error {
            in_machine = in_machine.joint(axis.times(-h), error);
        }
        if self.helical_motion != 0.0 {
            let slide = Twist::slide(-Vector::Z);
            in_machine = in_machine.joint(slide, Law::linear(self.helical_motion));
        }
        let rolled = in_machine.then(towards_work).joint(axis, roll.law(h));
        match work_error {
            Some(error) => rolled.joint(axis.times(h), error),
            None => rolled,
        }
    }
}
