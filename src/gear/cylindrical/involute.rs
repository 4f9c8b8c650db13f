//! Involute cylindrical gears: `r_b = r cos α_t`, `s_n = m (π/2 + 2x tan α_n)`, `inv α = tan α − α`.
//!
//! The space of an internal gear equals the tooth of an external gear of thickness `e_n = π m − s_n`, whose formulas apply to measurements
//! in spaces. A positive profile shift makes external and internal teeth thicker (ISO 21771; books that count it outward have the opposite
//! sign for internal gears). Tooth numbers are positive for both.
//!
//! Lengths in m, angles in rad; module and profile shift in the normal section, as in ISO 21771.

use std::f64::consts::{FRAC_PI_2, PI};

/// Involute cylindrical gear, external or internal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InvoluteGear {
    /// Number of teeth, positive for internal gears too.
    pub teeth: u32,
    /// Normal module, m.
    pub module: f64,
    /// Normal pressure angle, rad.
    pub pressure_angle: f64,
    /// Helix angle at the reference cylinder, rad; its sign has no effect.
    pub helix: f64,
    /// Profile shift coefficient, positive for a thicker tooth.
    pub profile_shift: f64,
    /// True for an internal gear.
    pub internal: bool,
}

/// Upper limit of angles and tangents for the power series, whose first omitted term is then below 1e-16 of the sum.
const SMALL: f64 = 0.05;

/// Involute function `inv α = tan α − α`.
pub fn inv(angle: f64) -> f64 {
    if angle.abs() >= SMALL {
        return angle.tan() - angle;
    }
    let x = angle * angle;
    let series = [
        21844.0 / 6081075.0,
        1382.0 / 155925.0,
        62.0 / 2835.0,
        17.0 / 315.0,
        2.0 / 15.0,
        1.0 / 3.0,
    ];
    angle * x * series.into_iter().fold(0.0, |sum, c| sum * x + c)
}

/// `t − atan t`.
fn t_minus_atan(t: f64) -> f64 {
    if t.abs() >= SMALL {
        return t - t.atan();
    }
    let x = t * t;
    let series = [-13.0, 11.0, -9.0, 7.0, -5.0, 3.0];
    t * x
        * series
            .into_iter()
            .fold(0.0, |sum, n: f64| sum * x + n.recip())
}

/// Inverse involute function, an angle in [0, π/2), rad; NaN for a negative or infinite value.
pub fn angle_from_inv(value: f64) -> f64 {
    if !(value >= 0.0 && value.is_finite()) {
        return f64::NAN;
    }
    if value == 0.0 {
        return 0.0;
    }
    // With t = tan α, t − atan t is convex and increasing: Newton's method converges monotonically from above.
    let mut t = (3.0 * value).cbrt() + value;
    for _ in 0..60 {
        let step = (t_minus_atan(t) - value) * (1.0 + t * t) / (t * t);
        t -= step;
        if step.abs() <= 2.0 * f64::EPSILON * t {
            break;
        }
    }
    t.atan()
}

impl InvoluteGear {
    /// Transverse pressure angle α_t at the reference cylinder.
    pub fn transverse_pressure_angle(&self) -> f64 {
        (self.pressure_angle.tan() / self.helix.cos()).atan()
    }

    /// Reference diameter d.
    pub fn reference_diameter(&self) -> f64 {
        f64::from(self.teeth) * self.module / self.helix.cos()
    }

    /// Lead of the flanks `p_z = π z m_n / sin β` (ISO 21771-1:2024); `None` for spur gears.
    pub fn lead(&self) -> Option<f64> {
        let sine = self.helix.sin().abs();
        (sine > 0.0).then(|| PI * f64::from(self.teeth) * self.module / sine)
    }

    /// Base diameter d_b.
    pub fn base_diameter(&self) -> f64 {
        self.reference_diameter() * self.transverse_pressure_angle().cos()
    }

    /// Transverse base pitch p_bt, the distance of adjacent flanks along the line of action.
    pub fn base_pitch(&self) -> f64 {
        PI * self.base_diameter() / f64::from(self.teeth)
    }

    /// Normal tooth thickness at the reference cylinder without backlash.
    pub fn nominal_thickness(&self) -> f64 {
        self.module * (FRAC_PI_2 + 2.0 * self.profile_shift * self.pressure_angle.tan())
    }

    /// Base helix angle β_b, `sin β_b = sin β cos α_n`.
    pub fn base_helix_angle(&self) -> f64 {
        (self.helix.sin() * self.pressure_angle.cos()).asin()
    }

    /// Transverse pressure angle α_yt at a diameter; NaN inside the base circle.
    pub fn pressure_angle_at(&self, diameter: f64) -> f64 {
        (2.0 * self.roll_length(diameter) / self.base_diameter()).atan()
    }

    /// Diameter at a length of roll.
    pub fn diameter_at_roll(&self, roll: f64) -> f64 {
        self.base_diameter().hypot(2.0 * roll)
    }

    /// Transverse tooth thickness s_yt at a diameter for a normal thickness at the reference cylinder:
    /// `s_yt = d_y (s_t/d ± (inv α_t − inv α_yt))`, − for internal teeth (ISO 21771-2:2025); NaN inside the base circle.
    pub fn thickness_at(&self, diameter: f64, thickness: f64) -> f64 {
        let involute =
            inv(self.transverse_pressure_angle()) - inv(self.pressure_angle_at(diameter));
        let involute = if self.internal { -involute } else { involute };
        let zm = f64::from(self.teeth) * self.module;
        diameter * (thickness / zm + involute)
    }

    /// Length of roll, along the line of action from the base circle, at a diameter; NaN inside the base circle.
    pub fn roll_length(&self, diameter: f64) -> f64 {
        0.5 * ((diameter - self.base_diameter()) * (diameter + self.base_diameter())).sqrt()
    }

    /// Normal space width at the reference cylinder for a normal tooth thickness.
    fn space_width(&self, thickness: f64) -> f64 {
        PI * self.module - thickness
    }

    /// External gear whose tooth equals a space of this internal gear.
    fn space_as_gear(&self) -> InvoluteGear {
        InvoluteGear {
            internal: false,
            profile_shift: -self.profile_shift,
            ..*self
        }
    }

    /// Span W over `k` teeth (internal gears: `k` spaces) for a normal thickness at the reference cylinder.
    pub fn span(&self, k: u32, thickness: f64) -> f64 {
        if self.internal {
            return self.space_as_gear().span(k, self.space_width(thickness));
        }
        let pitches = PI * (f64::from(k) - 1.0) * self.module;
        let base = f64::from(self.teeth) * inv(self.transverse_pressure_angle()) * self.module;
        (pitches + base + thickness) * self.pressure_angle.cos()
    }

    /// Number of teeth (internal gears: spaces) to span so that the anvils touch near the middle of the flanks.
    pub fn default_span_teeth(&self) -> u32 {
        if self.internal {
            return self.space_as_gear().default_span_teeth();
        }
        let z = f64::from(self.teeth);
        let shift = self.profile_shift / z;
        let (sine, cosine) = self.helix.sin_cos();
        let tangent = self.pressure_angle.tan();
        let size = cosine * cosine + tangent * tangent;
        let reach = 1.0 / cosine + 2.0 * shift;
        let roll = (1.0 + sine * sine / size) * (size * reach * reach - 1.0).max(0.0).sqrt();
        let k =
            (roll - inv(self.transverse_pressure_angle()) - 2.0 * shift * tangent) * z / PI + 0.5;
        k.round().clamp(1.0, z) as u32
    }

    /// Diameter d_K of the circle through the centres of balls of the diameter `ball` that touch both flanks of a space, for a normal
    /// thickness; NaN if the ball is too small.
    pub fn ball_centre_diameter(&self, ball: f64, thickness: f64) -> f64 {
        let zm = f64::from(self.teeth) * self.module;
        let excess = ball / self.pressure_angle.cos() - self.space_width(thickness);
        // The ball touches convex flanks, or concave ones of an internal gear.
        let arc = if self.internal { -excess } else { excess };
        let involute = inv(self.transverse_pressure_angle()) + arc / zm;
        self.base_diameter() / angle_from_inv(involute).cos()
    }

    /// Contribution of the ball diameter to a dimension over balls; negative for a dimension between balls.
    fn ball_reach(&self, ball: f64) -> f64 {
        if self.internal { -ball } else { ball }
    }

    /// Dimension M_dK over two balls (pins for spur gears), between them for internal gears, for a normal thickness; NaN if the ball
    /// is too small.
    pub fn dimension_over_balls(&self, ball: f64, thickness: f64) -> f64 {
        let centres = self.ball_centre_diameter(ball, thickness);
        centres * self.odd_tooth_factor() + self.ball_reach(ball)
    }

    /// Radial dimension M_rK over one ball; to the inner side of the ball for internal gears.
    pub fn radial_dimension_over_ball(&self, ball: f64, thickness: f64) -> f64 {
        0.5 * (self.ball_centre_diameter(ball, thickness) + self.ball_reach(ball))
    }

    /// Dimension M_dR over two pins for a normal thickness, equal to that over balls for spur gears. Pins along the helix of a helical gear
    /// are diametrically opposite with odd tooth numbers too (ISO 21771-2:2025); `None` for internal helical gears, in whose concave spaces
    /// pins do not fit.
    pub fn dimension_over_pins(&self, pin: f64, thickness: f64) -> Option<f64> {
        match (self.helix == 0.0, self.internal) {
            (true, _) => Some(self.dimension_over_balls(pin, thickness)),
            (false, false) => Some(self.ball_centre_diameter(pin, thickness) + pin),
            (false, true) => None,
        }
    }

    /// Diameter of the ball that touches the flanks of the nominal tooth at the diameter `d + 2 x m_n`, near mid-height; NaN if this
    /// diameter is inside the base circle.
    pub fn default_ball_diameter(&self) -> f64 {
        let outward = if self.internal { -1.0 } else { 1.0 };
        let middle = self.reference_diameter() + 2.0 * outward * self.profile_shift * self.module;
        let angle = self.pressure_angle_at(middle);
        let zm = f64::from(self.teeth) * self.module;
        let space = self.space_width(self.nominal_thickness()) / zm;
        // Half space angle η_b at the base circle: α_K = tan α + η_b at the ball centre, tan α − η_b for internal gears.
        let half_space = space - outward * inv(self.transverse_pressure_angle());
        let centre = angle.tan() + outward * half_space;
        outward * zm * self.pressure_angle.cos() * (centre.tan() - angle.tan())
    }

    /// Factor on the centre circle for two spaces that are not diametrically opposite: `cos(π/2z)` for odd tooth numbers.
    fn odd_tooth_factor(&self) -> f64 {
        match self.teeth.is_multiple_of(2) {
            true => 1.0,
            false => (FRAC_PI_2 / f64::from(self.teeth)).cos(),
        }
    }

    /// Normal thickness for a dimension over two balls (internal gears: between balls); NaN if the balls would be inside the base
    /// circle.
    pub fn thickness_from_balls(&self, ball: f64, dimension: f64) -> f64 {
        let (sense, centres) = match self.internal {
            false => (1.0, dimension - ball),
            true => (-1.0, dimension + ball),
        };
        let involute = inv((self.base_diameter() * self.odd_tooth_factor() / centres).acos());
        let arc = (involute - inv(self.transverse_pressure_angle()))
            * f64::from(self.teeth)
            * self.module;
        sense * arc - ball / self.pressure_angle.cos() + PI * self.module
    }

    /// Addendum: radial distance from the reference cylinder to a tip cylinder.
    fn addendum(&self, tip_diameter: f64) -> f64 {
        let outward = 0.5 * (tip_diameter - self.reference_diameter());
        if self.internal { -outward } else { outward }
    }

    /// Chordal thickness at the reference cylinder and its height below a tip cylinder, on the virtual gear of z/cos³β teeth.
    pub fn chordal_thickness(&self, tip_diameter: f64, thickness: f64) -> (f64, f64) {
        let virtual_diameter = f64::from(self.teeth) * self.module / self.helix.cos().powi(3);
        let half = thickness / virtual_diameter;
        let rise = 0.5 * virtual_diameter * (1.0 - half.cos());
        // The chord is inside its arc, on an internal gear nearer to the tip.
        let rise = if self.internal { -rise } else { rise };
        (
            virtual_diameter * half.sin(),
            self.addendum(tip_diameter) + rise,
        )
    }

    /// Constant chord at the contact with the basic rack and its height below a tip cylinder, independent of the number of teeth.
    pub fn constant_chord(&self, tip_diameter: f64, thickness: f64) -> (f64, f64) {
        let (sine, cosine) = self.pressure_angle.sin_cos();
        let chord = thickness * cosine * cosine;
        (
            chord,
            self.addendum(tip_diameter) - 0.5 * thickness * sine * cosine,
        )
    }
}
