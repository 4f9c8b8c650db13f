//! Readings of a drawing: span, over balls and pins, chords, nominal and at both limits of the thickness (ISO 21771-2:2025).

use super::member::Member;

/// A reading of a nominal tooth and at both thickness limits, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReadingLimits {
    /// Reading of the tooth without deviation.
    pub nominal: f64,
    /// Smallest allowed reading.
    pub least: f64,
    /// Largest allowed reading.
    pub greatest: f64,
}

impl Member {
    /// A reading over the normal thickness, at the nominal thickness and at both limits; `None` where it does not exist at one of them.
    fn reading(&self, at_thickness: impl Fn(f64) -> f64) -> Option<ReadingLimits> {
        let nominal = self.gear.nominal_thickness();
        let [lower, upper] = self.thickness_deviation.map(|e| at_thickness(nominal + e));
        let reading = ReadingLimits {
            nominal: at_thickness(nominal),
            least: lower.min(upper),
            greatest: lower.max(upper),
        };
        (reading.nominal + lower + upper)
            .is_finite()
            .then_some(reading)
    }

    /// Span W_k over `k` teeth, of an internal spur gear over `k` spaces; `None` where the anvils do not touch the involute flanks.
    pub fn span(&self, k: u32) -> Option<ReadingLimits> {
        let gear = &self.gear;
        if k == 0 || k > gear.teeth || (gear.internal && gear.helix != 0.0) {
            return None;
        }
        let reading = self.reading(|thickness| gear.span(k, thickness))?;
        // In the transverse section the anvils touch half the span cos β_b off the base circle's tangent point.
        let roll = 0.5 * reading.nominal * gear.base_helix_angle().cos();
        self.is_on_flank(gear.diameter_at_roll(roll))
            .then_some(reading)
    }

    /// Dimension M_dK over (inside: between) two balls.
    pub fn over_balls(&self, ball: f64) -> Option<ReadingLimits> {
        self.reading(|thickness| self.gear.dimension_over_balls(ball, thickness))
    }

    /// True if a ball touches the involute flanks of the nominal tooth, between root form and tip diameter. In the transverse section it
    /// touches D/2 cos β_b off its centre along the base tangent.
    pub fn touches_ball(&self, ball: f64) -> bool {
        let gear = &self.gear;
        let centres = gear.ball_centre_diameter(ball, gear.nominal_thickness());
        let off = 0.5 * self.sense() * ball * gear.base_helix_angle().cos();
        self.is_on_flank(gear.diameter_at_roll(gear.roll_length(centres) - off))
    }

    fn is_on_flank(&self, diameter: f64) -> bool {
        let shift = self.gear.profile_shift;
        let root = self.root_diameter(shift);
        let inner = self.root_form_diameter(shift).unwrap_or(root);
        (diameter - inner) * (diameter - self.tip_diameter()) < 0.0
    }

    /// Dimension M_dR over (inside: between) two pins.
    pub fn over_pins(&self, pin: f64) -> Option<ReadingLimits> {
        self.reading(|thickness| {
            let over = self.gear.dimension_over_pins(pin, thickness);
            over.unwrap_or(f64::NAN)
        })
    }

    /// Chordal thickness s̄_n at the reference cylinder, and its height h̄_a below the tip at the nominal thickness, m.
    pub fn chord(&self) -> Option<(ReadingLimits, f64)> {
        let chord = |thickness| self.gear.chordal_thickness(self.tip_diameter(), thickness);
        let height = chord(self.gear.nominal_thickness()).1;
        Some((self.reading(|thickness| chord(thickness).0)?, height))
    }

    /// Constant chord s̄_c, and its height h̄_c below the tip at the nominal thickness, m.
    pub fn constant_chord(&self) -> Option<(ReadingLimits, f64)> {
        let chord = |thickness| self.gear.constant_chord(self.tip_diameter(), thickness);
        let height = chord(self.gear.nominal_thickness()).1;
        Some((self.reading(|thickness| chord(thickness).0)?, height))
    }
}
