//! Physical quantity and SI factor of a channel's unit; `g` is standard gravity here, not the gram.

use crate::base::quantity;
use crate::base::quantity_kind::Dimension;

/// Standard acceleration of gravity, m/s² (CGPM 1901).
pub const GRAVITY: f64 = 9.806_65;

/// Quantity measured by a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeasuredQuantity {
    /// A length.
    Displacement,
    /// Time derivative of displacement.
    Velocity,
    /// The rate of that.
    Acceleration,
    /// An angle.
    Angle,
    /// Time derivative of angle.
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

/// Quantity and SI size of a unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChannelUnit {
    /// Measured quantity.
    pub quantity: MeasuredQuantity,
    /// Number in SI = factor × number in the unit.
    pub factor: f64,
}

/// Units of sensors that mean something else, or nothing, elsewhere.
const SENSOR_UNITS: &[(&str, MeasuredQuantity, f64)] = &[
    ("g", MeasuredQuantity::Acceleration, GRAVITY),
    ("gn", MeasuredQuantity::Acceleration, GRAVITY),
    ("g_n", MeasuredQuantity::Acceleration, GRAVITY),
    ("G", MeasuredQuantity::Acceleration, GRAVITY),
    ("mg", MeasuredQuantity::Acceleration, 1e-3 * GRAVITY),
    ("Gal", MeasuredQuantity::Acceleration, 1e-2),
    ("ips", MeasuredQuantity::Velocity, 0.0254),
    ("mil", MeasuredQuantity::Displacement, 25.4e-6),
    ("mils", MeasuredQuantity::Displacement, 25.4e-6),
    ("Newtons", MeasuredQuantity::Force, 1.0),
    ("Newton", MeasuredQuantity::Force, 1.0),
    ("V", MeasuredQuantity::Voltage, 1.0),
    ("mV", MeasuredQuantity::Voltage, 1e-3),
    ("µV", MeasuredQuantity::Voltage, 1e-6),
    ("kV", MeasuredQuantity::Voltage, 1e3),
    ("Volts", MeasuredQuantity::Voltage, 1.0),
    ("Volt", MeasuredQuantity::Voltage, 1.0),
];

const MOTION_DIMENSIONS: &[([i8; 4], MeasuredQuantity)] = &[
    ([1, 0, 0, 0], MeasuredQuantity::Displacement),
    ([1, 0, -1, 0], MeasuredQuantity::Velocity),
    ([1, 0, -2, 0], MeasuredQuantity::Acceleration),
    ([0, 0, 0, 1], MeasuredQuantity::Angle),
    ([0, 0, -1, 1], MeasuredQuantity::AngularVelocity),
    ([0, 0, -2, 1], MeasuredQuantity::AngularAcceleration),
    ([1, 1, -2, 0], MeasuredQuantity::Force),
    ([2, 1, -2, 0], MeasuredQuantity::Torque),
];

/// Quantity and SI size of a unit as written in a log; `None` where it is not known.
pub fn parse(unit: &str) -> Option<ChannelUnit> {
    // The micro sign, the Greek letter and `u` are all in use; so are `sec` and `s`.
    let plain = unit.trim().replace('μ', "µ").replace("sec", "s");
    let plain = match plain.strip_prefix("um") {
        Some(rest) => format!("µm{rest}"),
        None => plain,
    };
    if let Some(&(_, sensed, factor)) = SENSOR_UNITS.iter().find(|s| s.0 == plain) {
        return Some(ChannelUnit {
            quantity: sensed,
            factor,
        });
    }
    let (factor, dimension) = quantity::parse_unit(&plain)?;
    if plain.is_empty() {
        return None;
    }
    let sensed = MOTION_DIMENSIONS
        .iter()
        .find(|m| Dimension(m.0) == dimension)
        .map_or(MeasuredQuantity::Other, |m| m.1);
    Some(ChannelUnit {
        quantity: sensed,
        factor,
    })
}

impl MeasuredQuantity {
    /// Order of the time derivative of a displacement or an angle; `None` for what is no motion.
    pub fn time_derivative_order(self) -> Option<u8> {
        match self {
            MeasuredQuantity::Displacement | MeasuredQuantity::Angle => Some(0),
            MeasuredQuantity::Velocity | MeasuredQuantity::AngularVelocity => Some(1),
            MeasuredQuantity::Acceleration | MeasuredQuantity::AngularAcceleration => Some(2),
            _ => None,
        }
    }

    /// A force or a torque: what drives.
    pub fn is_excitation(self) -> bool {
        matches!(self, MeasuredQuantity::Force | MeasuredQuantity::Torque)
    }
}

/// Kind of a frequency response, by the quantities it joins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResponseKind {
    /// Motion over force, the motion differentiated so often: receptance (0), mobility (1), accelerance (2).
    MotionOverForce(u8),
    /// Motion over motion or force over force: its poles are not the modes of the structure.
    Transmissibility,
    /// Force over motion, the motion differentiated so often: dynamic stiffness (0), impedance (1), apparent mass (2). Its poles are the
    /// zeros of the inverse response.
    ForceOverMotion(u8),
    /// The units do not tell.
    Unknown,
}

impl ResponseKind {
    /// Response kind by the units of the excitation and response channels.
    pub fn from_units(input: &str, output: &str) -> ResponseKind {
        let (Some(input), Some(output)) = (parse(input), parse(output)) else {
            return ResponseKind::Unknown;
        };
        match (input.quantity, output.quantity.time_derivative_order()) {
            (s, Some(times)) if s.is_excitation() => ResponseKind::MotionOverForce(times),
            (s, None) if s.is_excitation() && output.quantity.is_excitation() => {
                ResponseKind::Transmissibility
            }
            (s, Some(_)) if s.time_derivative_order().is_some() => ResponseKind::Transmissibility,
            (s, None) if output.quantity.is_excitation() => (s.time_derivative_order())
                .map_or(ResponseKind::Unknown, ResponseKind::ForceOverMotion),
            _ => ResponseKind::Unknown,
        }
    }

    /// Name of the response kind, such as `receptance`.
    pub fn name(self) -> &'static str {
        match self {
            ResponseKind::MotionOverForce(0) => "receptance",
            ResponseKind::MotionOverForce(1) => "mobility",
            ResponseKind::MotionOverForce(_) => "accelerance",
            ResponseKind::Transmissibility => "transmissibility",
            ResponseKind::ForceOverMotion(0) => "dynamic stiffness",
            ResponseKind::ForceOverMotion(1) => "impedance",
            ResponseKind::ForceOverMotion(_) => "apparent mass",
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
            ("g", MeasuredQuantity::Acceleration, GRAVITY),
            ("m/s2", MeasuredQuantity::Acceleration, 1.0),
            ("m/s²", MeasuredQuantity::Acceleration, 1.0),
            ("in/s²", MeasuredQuantity::Acceleration, 0.0254),
            ("mm/s", MeasuredQuantity::Velocity, 1e-3),
            ("um", MeasuredQuantity::Displacement, 1e-6),
            ("μm", MeasuredQuantity::Displacement, 1e-6),
            ("lbf", MeasuredQuantity::Force, 4.448_221_615_260_5),
            ("kN", MeasuredQuantity::Force, 1e3),
            ("mV", MeasuredQuantity::Voltage, 1e-3),
            ("rad/s", MeasuredQuantity::AngularVelocity, 1.0),
        ];
        for (unit, sensed, factor) in known {
            let found = parse(unit).unwrap();
            assert_eq!(found.quantity, sensed, "{unit}");
            assert!((found.factor / factor - 1.0).abs() < 1e-14, "{unit}");
        }
        assert_eq!(parse("um/m").unwrap().quantity, MeasuredQuantity::Other);
        assert_eq!(parse("wobble"), None);
        assert_eq!(parse(""), None);
    }

    #[test]
    fn exact_kinds_of_responses() {
        assert_eq!(
            ResponseKind::from_units("N", "g"),
            ResponseKind::MotionOverForce(2)
        );
        assert_eq!(
            ResponseKind::from_units("m/s²", "g"),
            ResponseKind::Transmissibility
        );
        assert_eq!(ResponseKind::from_units("V", "g"), ResponseKind::Unknown);
        assert_eq!(
            ResponseKind::from_units("m/s²", "N"),
            ResponseKind::ForceOverMotion(2)
        );
        assert_eq!(ResponseKind::from_units("V", "N"), ResponseKind::Unknown);
    }
}
