//! What a channel measures, known by its unit: `g` is the acceleration of gravity here, not the gram.

use crate::base::kind::Dimension;
use crate::base::units;

/// Standard acceleration of gravity, m/s² (CGPM 1901).
pub const GRAVITY: f64 = 9.806_65;

/// What a channel measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sensed {
    /// A length.
    Displacement,
    /// Its rate.
    Velocity,
    /// The rate of that.
    Acceleration,
    /// An angle.
    Angle,
    /// Its rate.
    AngularVelocity,
    /// The rate of that.
    AngularAcceleration,
    /// A force.
    Force,
    /// A torque.
    Torque,
    /// A voltage: a sensor that was not calibrated.
    Voltage,
    /// Something else: pressure, strain, temperature, counts.
    Other,
}

/// What a unit measures and its size in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantity {
    /// What it measures.
    pub sensed: Sensed,
    /// Number in SI = factor × number in the unit.
    pub factor: f64,
}

/// Units of sensors that mean something else, or nothing, elsewhere.
const SENSORS: &[(&str, Sensed, f64)] = &[
    ("g", Sensed::Acceleration, GRAVITY),
    ("gn", Sensed::Acceleration, GRAVITY),
    ("g_n", Sensed::Acceleration, GRAVITY),
    ("G", Sensed::Acceleration, GRAVITY),
    ("mg", Sensed::Acceleration, 1e-3 * GRAVITY),
    ("Gal", Sensed::Acceleration, 1e-2),
    ("ips", Sensed::Velocity, 0.0254),
    ("mil", Sensed::Displacement, 25.4e-6),
    ("mils", Sensed::Displacement, 25.4e-6),
    ("Newtons", Sensed::Force, 1.0),
    ("Newton", Sensed::Force, 1.0),
    ("V", Sensed::Voltage, 1.0),
    ("mV", Sensed::Voltage, 1e-3),
    ("µV", Sensed::Voltage, 1e-6),
    ("kV", Sensed::Voltage, 1e3),
    ("Volts", Sensed::Voltage, 1.0),
    ("Volt", Sensed::Voltage, 1.0),
];

const MOTIONS: &[([i8; 4], Sensed)] = &[
    ([1, 0, 0, 0], Sensed::Displacement),
    ([1, 0, -1, 0], Sensed::Velocity),
    ([1, 0, -2, 0], Sensed::Acceleration),
    ([0, 0, 0, 1], Sensed::Angle),
    ([0, 0, -1, 1], Sensed::AngularVelocity),
    ([0, 0, -2, 1], Sensed::AngularAcceleration),
    ([1, 1, -2, 0], Sensed::Force),
    ([2, 1, -2, 0], Sensed::Torque),
];

/// What a unit as written in a log measures; `None` where it is not known.
pub fn of(unit: &str) -> Option<Quantity> {
    // The micro sign, the Greek letter and `u` are all in use; so are `sec` and `s`.
    let plain = unit.trim().replace('μ', "µ").replace("sec", "s");
    let plain = match plain.strip_prefix("um") {
        Some(rest) => format!("µm{rest}"),
        None => plain,
    };
    if let Some(&(_, sensed, factor)) = SENSORS.iter().find(|s| s.0 == plain) {
        return Some(Quantity { sensed, factor });
    }
    let (factor, dimension) = units::of_unit(&plain)?;
    if plain.is_empty() {
        return None;
    }
    let sensed = MOTIONS
        .iter()
        .find(|m| Dimension(m.0) == dimension)
        .map_or(Sensed::Other, |m| m.1);
    Some(Quantity { sensed, factor })
}

impl Sensed {
    /// How often a displacement or an angle was differentiated in time; `None` for what is no motion.
    pub fn derivative(self) -> Option<u8> {
        match self {
            Sensed::Displacement | Sensed::Angle => Some(0),
            Sensed::Velocity | Sensed::AngularVelocity => Some(1),
            Sensed::Acceleration | Sensed::AngularAcceleration => Some(2),
            _ => None,
        }
    }

    /// A force or a torque: what drives.
    pub fn drives(self) -> bool {
        matches!(self, Sensed::Force | Sensed::Torque)
    }
}

/// What a frequency response is, by what it joins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResponseKind {
    /// Motion over force, the motion differentiated so often: receptance (0), mobility (1), accelerance (2).
    Compliance(u8),
    /// Motion over motion or force over force: its poles are not the modes of the structure.
    Transmissibility,
    /// Force over motion, the motion differentiated so often: dynamic stiffness (0), impedance (1), apparent mass (2). Its poles are the
    /// zeros of the inverse response.
    Inverse(u8),
    /// The units do not tell.
    Unknown,
}

impl ResponseKind {
    /// By the units of what drives and what answers.
    pub fn of(input: &str, output: &str) -> ResponseKind {
        let (Some(input), Some(output)) = (of(input), of(output)) else {
            return ResponseKind::Unknown;
        };
        match (input.sensed, output.sensed.derivative()) {
            (s, Some(times)) if s.drives() => ResponseKind::Compliance(times),
            (s, None) if s.drives() && output.sensed.drives() => ResponseKind::Transmissibility,
            (s, Some(_)) if s.derivative().is_some() => ResponseKind::Transmissibility,
            (s, None) if output.sensed.drives() => {
                (s.derivative()).map_or(ResponseKind::Unknown, ResponseKind::Inverse)
            }
            _ => ResponseKind::Unknown,
        }
    }

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            ResponseKind::Compliance(0) => "receptance",
            ResponseKind::Compliance(1) => "mobility",
            ResponseKind::Compliance(_) => "accelerance",
            ResponseKind::Transmissibility => "transmissibility",
            ResponseKind::Inverse(0) => "dynamic stiffness",
            ResponseKind::Inverse(1) => "impedance",
            ResponseKind::Inverse(_) => "apparent mass",
            ResponseKind::Unknown => "frequency response",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_units_of_sensors() {
        let known = [
            ("g", Sensed::Acceleration, GRAVITY),
            ("m/s2", Sensed::Acceleration, 1.0),
            ("m/s²", Sensed::Acceleration, 1.0),
            ("in/s²", Sensed::Acceleration, 0.0254),
            ("mm/s", Sensed::Velocity, 1e-3),
            ("um", Sensed::Displacement, 1e-6),
            ("μm", Sensed::Displacement, 1e-6),
            ("lbf", Sensed::Force, 4.448_221_615_260_5),
            ("kN", Sensed::Force, 1e3),
            ("mV", Sensed::Voltage, 1e-3),
            ("rad/s", Sensed::AngularVelocity, 1.0),
        ];
        for (unit, sensed, factor) in known {
            let found = of(unit).unwrap();
            assert_eq!(found.sensed, sensed, "{unit}");
            assert!((found.factor / factor - 1.0).abs() < 1e-14, "{unit}");
        }
        assert_eq!(of("um/m").unwrap().sensed, Sensed::Other);
        assert_eq!(of("wobble"), None);
        assert_eq!(of(""), None);
    }

    #[test]
    fn exact_kinds_of_responses() {
        assert_eq!(ResponseKind::of("N", "g"), ResponseKind::Compliance(2));
        assert_eq!(
            ResponseKind::of("m/s²", "g"),
            ResponseKind::Transmissibility
        );
        assert_eq!(ResponseKind::of("V", "g"), ResponseKind::Unknown);
        assert_eq!(ResponseKind::of("m/s²", "N"), ResponseKind::Inverse(2));
        assert_eq!(ResponseKind::of("V", "N"), ResponseKind::Unknown);
    }
}
