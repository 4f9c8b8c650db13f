//! Displacement of a flank by each setting at fixed parameters of cutter and cradle, without differences.
//!
//! An envelope moves along its normal by `n·∂r/∂p` at fixed (s, θ, φ_c), p any parameter of the surface or of its motion (envelope theorem: the change
//! of the place of contact moves the point within the tangent plane).

use std::f64::consts::FRAC_PI_2;

use super::setting::{FlankSetup, SHEET_FACTORS, Setting};
use crate::gear::bevel::settings::MachineSettings;
use crate::gear::hand::Hand;
use crate::gear::kernel::pose::Transform;
use crate::gear::kernel::tool::Curve;
use crate::gear::kernel::twist::Twist;
use crate::gear::kernel::vector::Vector;

/// The chain of the generator at one turn of the cradle: poses in the work of its frames, the innermost last.
#[derive(Debug, Clone, Copy)]
pub struct MachineChain<'a> {
    setup: &'a FlankSetup,
    hand: f64,
    /// Turn φ_c of the cradle.
    turn: f64,
    /// Pose of the root angle's axis.
    of_root_angle: Transform,
    /// Pose of the machine.
    of_machine: Transform,
    /// Pose of the cradle.
    of_cradle: Transform,
    /// Pose of the cutter.
    of_cutter: Transform,
}

impl<'a> MachineChain<'a> {
    /// The chain at the cradle's turn φ_c, rad.
    pub fn at(setup: &'a FlankSetup, hand: Hand, turn: f64) -> MachineChain<'a> {
        let (m, h) = (&setup.machine, hand.sign());
        let about =
            |axis: Vector, angle: f64| Transform::exp(&Twist::turn(axis, Vector::ZERO), angle);
        let shifted = |by: Vector| Transform {
            translation: by,
            ..Transform::IDENTITY
        };
        let work_turn = m.roll.map_or(0.0, |roll| roll.law(h).at(turn)[0]);
        let slide = m.sliding_base + m.helical_motion * turn;
        let offset = Vector::new(0.0, -h * m.blank_offset, -slide);
        let of_root_angle =
            about(Vector::Z, work_turn).after(&shifted(-m.centre_to_back * Vector::Z));
        let of_machine = of_root_angle.after(&about(Vector::Y, m.machine_root_angle - FRAC_PI_2));
        let of_cradle = of_machine
            .after(&shifted(offset))
            .after(&about(Vector::Z, -h * turn));
        let centre = radial_direction(m, h) * m.radial_distance;
        MachineChain {
            setup,
            hand: h,
            turn,
            of_root_angle,
            of_machine,
            of_cradle,
            of_cutter: of_cradle.after(&shifted(centre)).after(&tilted(m, h)),
        }
    }

    /// Displacement of the cutter's point at s, θ by a unit of a setting, in the work.
    pub fn displacement(&self, setting: Setting, [s, theta]: [f64; 2]) -> Vector {
        let cutter = &self.setup.cutter;
        let [across, along] = match setting {
            Setting::PointRadius => [1.0, 0.0],
            Setting::BladeAngle => cutter.displacement_by_blade_angle(s),
            Setting::ProfileCurvature => cutter.displacement_by_curvature(s),
            setting => return self.displacement_of_plane(setting, self.point([s, theta])),
        };
        self.of_cutter
            .rotate(spoke(theta) * across + Vector::Z * along)
    }

    /// Displacement at a point r of the cutter's tip plane by a unit of a setting, in the work; dimensions of the blade leave the plane.
    pub fn displacement_of_plane(&self, setting: Setting, r: Vector) -> Vector {
        let (m, h, x) = (&self.setup.machine, self.hand, self.turn);
        let about_work = Vector::Z.cross(r);
        match setting {
            Setting::PointRadius | Setting::BladeAngle | Setting::ProfileCurvature => Vector::ZERO,
            Setting::RadialDistance => self.of_cradle.rotate(radial_direction(m, h)),
            Setting::CradleAngle => {
                let (sin, cos) = m.cradle_angle.sin_cos();
                let along = Vector::new(-sin, h * cos, 0.0) * m.radial_distance;
                self.of_cradle.rotate(along)
            }
            Setting::BlankOffset => self.of_machine.rotate(-h * Vector::Y),
            Setting::SlidingBase => self.of_machine.rotate(-Vector::Z),
            Setting::HelicalMotion => self.of_machine.rotate(-x * Vector::Z),
            Setting::CentreToBack => -Vector::Z,
            Setting::MachineRootAngle => {
                let axis = Twist::turn(Vector::Y, Vector::ZERO);
                self.of_root_angle.carry(&axis).at(r)
            }
            Setting::TiltCosine => self.by_tilt(Vector::Y, r),
            Setting::TiltSine => self.by_tilt(-h * Vector::X, r),
            Setting::Ratio => match &m.roll {
                Some(roll) => about_work * (roll.law(h).at(x)[0] / roll.work_over_cradle),
                None => Vector::ZERO,
            },
            Setting::ModifiedRoll(k) => {
                let ratio = m.roll.map_or(0.0, |roll| roll.work_over_cradle);
                let power = x.powi(k as i32 + 2) / SHEET_FACTORS[k];
                about_work * (-h * ratio * power)
            }
        }
    }

    /// The cutter's point at s, θ in the work.
    fn point(&self, [s, theta]: [f64; 2]) -> Vector {
        let [on_profile, ..] = self.setup.cutter.profile().at(s);
        self.of_cutter
            .apply(spoke(theta) * on_profile.x + Vector::Z * on_profile.z)
    }

    /// Displacement of r by a change of the tilt's rotation vector, about the cutter's tip centre.
    fn by_tilt(&self, change: Vector, r: Vector) -> Vector {
        let turn = left_jacobian(rotation_vector(&self.setup.machine, self.hand), change);
        let lever = r - self.of_cutter.translation;
        self.of_cradle.rotate(turn).cross(lever)
    }
}

/// Direction from the cradle's axis to the cutter's centre.
fn radial_direction(m: &MachineSettings, h: f64) -> Vector {
    let (sin, cos) = m.cradle_angle.sin_cos();
    Vector::new(cos, h * sin, 0.0)
}

/// Rotation vector of tilt and swivel: `Rz(h j) Ry(i) Rz(−h j)` turns by i about y turned by h j.
fn rotation_vector(m: &MachineSettings, h: f64) -> Vector {
    let (sin, cos) = (h * m.swivel).sin_cos();
    Vector::new(-sin, cos, 0.0) * m.tilt
}

fn tilted(m: &MachineSettings, h: f64) -> Transform {
    Transform::exp(&Twist::turn(rotation_vector(m, h), Vector::ZERO), 1.0)
}

/// Turn by a change of a rotation vector ρ: the left Jacobian `J = I + (1 − cos ρ)/ρ² [ρ] + (ρ − sin ρ)/ρ³ [ρ]²` of rotations
/// (Chirikjian, Stochastic Models, Information Theory, and Lie Groups, vol. 2, 2012, chapter 10).
fn left_jacobian(rho: Vector, change: Vector) -> Vector {
    let angle = rho.norm();
    let (first, second) = match angle < SMALL_ANGLE {
        true => (
            0.5 - angle * angle / 24.0,
            1.0 / 6.0 - angle * angle / 120.0,
        ),
        false => (
            2.0 * (0.5 * angle).sin().powi(2) / (angle * angle),
            (angle - angle.sin()) / (angle * angle * angle),
        ),
    };
    let once = rho.cross(change);
    change + once * first + rho.cross(once) * second
}

/// Below this angle the series of [`left_jacobian`] is exact to rounding, rad.
const SMALL_ANGLE: f64 = 1e-3;

/// Direction of the blade at θ across the cutter's axis.
fn spoke(theta: f64) -> Vector {
    let (sin, cos) = theta.sin_cos();
    Vector::new(cos, sin, 0.0)
}
