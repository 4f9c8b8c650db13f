//! A pair of flanks in mesh: the frames of both members, errors of assembly included.
//!
//! The fixed frame is the pinion's: z along its axis from apex to heel, the gear's axis at the shaft angle towards x. The gear's x axis is
//! the pinion's axis made perpendicular to its own. Gear points: `B Rz(φ₂) r₂ + G z_g + (0, −h E, 0)`, pinion points: `Rz(φ₁) r₁ + P z`, h
//! the hand of the pinion: where the offset E grows, the pinion's spiral angle exceeds the gear's by more.

use crate::gear::bevel::flank::BevelFlank;
use crate::gear::hand::Hand;
use crate::gear::kernel::pose::Transform;
use crate::gear::kernel::twist::Twist;
use crate::gear::kernel::vector::Vector;

/// Places of both members, nominal and erroneous.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Assembly {
    /// Shaft angle Σ with its error, rad.
    pub shaft_angle: f64,
    /// Offset a with its error E, m.
    pub offset: f64,
    /// Pinion moved along its axis from apex to heel, P, m.
    pub pinion_axial: f64,
    /// Gear moved along its axis from apex to heel, G, m.
    pub gear_axial: f64,
}

impl Assembly {
    /// The places with a share of a change added.
    pub fn changed(&self, change: &Assembly, share: f64) -> Assembly {
        Assembly {
            shaft_angle: self.shaft_angle + share * change.shaft_angle,
            offset: self.offset + share * change.offset,
            pinion_axial: self.pinion_axial + share * change.pinion_axial,
            gear_axial: self.gear_axial + share * change.gear_axial,
        }
    }
}

/// Two flanks in mesh.
#[derive(Debug, Clone)]
pub struct FlankPair {
    /// Flanks of pinion and gear.
    pub flanks: [BevelFlank; 2],
    /// Tooth numbers of pinion and gear.
    pub teeth: [u32; 2],
    /// Places of both.
    places: [Transform; 2],
    /// Turns of both about their axes, in the fixed frame.
    turns: [Twist; 2],
}

impl FlankPair {
    /// The pair of two flanks at their places; `hand` is that of the pinion.
    pub fn new(
        flanks: [BevelFlank; 2],
        teeth: [u32; 2],
        hand: Hand,
        assembly: &Assembly,
    ) -> FlankPair {
        let (sin, cos) = assembly.shaft_angle.sin_cos();
        let (x, z) = (Vector::new(-cos, 0.0, sin), Vector::new(sin, 0.0, cos));
        let aside = Vector::new(0.0, -hand.sign() * assembly.offset, 0.0);
        let pinion = Transform {
            translation: assembly.pinion_axial * Vector::Z,
            ..Transform::IDENTITY
        };
        let gear = Transform {
            rotation: [x, z.cross(x), z],
            translation: assembly.gear_axial * z + aside,
        };
        let places = [pinion, gear];
        FlankPair {
            flanks,
            teeth,
            turns: places.map(|place| place.carry(&Twist::turn(Vector::Z, Vector::ZERO))),
            places,
        }
    }

    /// Pose of a member in the fixed frame at its angle.
    #[inline]
    pub fn pose(&self, member: usize, angle: f64) -> Transform {
        let (sin, cos) = angle.sin_cos();
        let place = &self.places[member];
        let [x, y, z] = place.rotation;
        Transform {
            rotation: [x * cos + y * sin, y * cos - x * sin, z],
            ..*place
        }
    }

    /// Turn of a member about its axis, in the fixed frame.
    #[inline]
    pub fn turn(&self, member: usize) -> &Twist {
        &self.turns[member]
    }

    /// Origin of a member's frame in the fixed frame.
    pub fn centre(&self, member: usize) -> Vector {
        self.places[member].translation
    }

    /// `dφ₂/dφ₁ = −z₁/z₂` of the tooth numbers.
    pub fn ratio(&self) -> f64 {
        -f64::from(self.teeth[0]) / f64::from(self.teeth[1])
    }

    /// Pitch of the pinion, rad.
    pub fn pitch(&self) -> f64 {
        std::f64::consts::TAU / f64::from(self.teeth[0])
    }
}
