//! Path of contact of a tooth pair: contact points on the line of action, and tip-corner contact off the line with its gap.
//!
//! At a pinion rotation φ from contact at the pitch point C, tooth pair j touches at the length of roll `s = s_C + r_b1 φ + j p_bt`. Before
//! A the tip corner of gear 2 faces the flank of gear 1, beyond E the corner of gear 1 the flank of gear 2. Involutes of a base circle are
//! parallel curves, so the gap of a corner is the arc of the base circle between its involute and the flank: rotating the gear of the
//! flank by this arc closes the gap, and the lever arm of the force along the flank normal is the base radius of that gear. Gaps and
//! forces do not depend on the order of the gears.

use crate::gear::cylindrical::pair::Pair;

/// Range of corner contact beyond the ends of the path, in base pitches.
const CORNER_REACH: f64 = 0.5;

/// Path of contact of a pair in a transverse section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactPath {
    /// Base radii of both gears, m.
    pub base: [f64; 2],
    /// Lengths of roll of both gears at the pitch point, m.
    pub pitch_rolls: [f64; 2],
    /// Lengths of roll at the form and the tip diameter of each gear, m.
    pub flank_ends: [[f64; 2]; 2],
    /// Lengths of roll of gear 1 at the start A and the end E of contact, m.
    pub ends: [f64; 2],
    /// Transverse base pitch, m.
    pub base_pitch: f64,
    /// +1 external, −1 internal second gear.
    sense: f64,
}

/// Contact or closest points of a pair of flanks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactPlace {
    /// Lengths of roll on both flanks, m.
    pub rolls: [f64; 2],
    /// Gap of the involutes along the normal, m.
    pub gap: f64,
    /// Index of the gear in tip-corner contact; `None` on the line of action.
    pub corner: Option<usize>,
}

impl ContactPath {
    /// Path of contact of a cylindrical pair.
    pub fn new(pair: &Pair) -> ContactPath {
        let geometry = pair.path_geometry();
        let pitch_rolls = geometry.pitch_point();
        let [approach, recess] = pair.path_ends();
        ContactPath {
            base: geometry.base,
            pitch_rolls,
            flank_ends: std::array::from_fn(|i| {
                let outline = &pair.outlines[i];
                [outline.form_radius, outline.tip_radius].map(|r| outline.roll_length(r))
            }),
            ends: [pitch_rolls[0] - approach, pitch_rolls[0] + recess],
            base_pitch: pair.base_pitch(),
            sense: if geometry.internal { -1.0 } else { 1.0 },
        }
    }

    /// Range of the length of roll of gear 1 in which a pair may touch, corner contact included, m.
    pub fn reach(&self) -> [f64; 2] {
        let [start, end] = self.ends;
        let extension = CORNER_REACH * self.base_pitch;
        [start - extension, end + extension]
    }

    /// Relative radius of curvature in the transverse section, m; `None` at a corner and at a base circle.
    pub fn relative_radius(&self, place: &ContactPlace) -> Option<f64> {
        let [first, second] = place.rolls;
        let curvature = first.recip() + self.sense * second.recip();
        (place.corner.is_none() && first > 0.0 && second > 0.0).then(|| curvature.recip())
    }

    /// Contact of a pair whose involutes touch at the length of roll `roll`, m, of gear 1; `None` out of range.
    pub fn place(&self, roll: f64) -> Option<ContactPlace> {
        let mate = self.pitch_rolls[1] - self.sense * (roll - self.pitch_rolls[0]);
        let rolls = [roll, mate];
        let [start, end] = self.ends;
        if roll < start {
            return self.corner(1, rolls);
        }
        if roll > end {
            return self.corner(0, rolls);
        }
        Some(ContactPlace {
            rolls,
            gap: 0.0,
            corner: None,
        })
    }

    /// Contact of the tip corner of gear `tip` with the mating flank; `rolls`: lengths of roll of both flanks on the line of action, m.
    fn corner(&self, tip: usize, rolls: [f64; 2]) -> Option<ContactPlace> {
        let flank = 1 - tip;
        let tip_roll = self.flank_ends[tip][1];
        // If the fillet ends the path before the tip, there is no contact in between.
        let is_beyond_tip = (rolls[tip] - tip_roll) * self.outward(tip) > 0.0;
        if !is_beyond_tip {
            return None;
        }
        let tip_point = involute_point(self.base[tip], rolls[tip], tip_roll);
        let flank_frame_point = self.to_gear_frame(flank, tip_point);
        let crossing = Involute::through(self.base[flank], flank_frame_point)?;
        let [form, mate_tip] = self.flank_ends[flank];
        let is_on_flank = (crossing.roll - form) * (crossing.roll - mate_tip) <= 0.0;
        let gap = self.outward(flank) * (crossing.on_line - rolls[flank]);
        let mut contact_rolls = [0.0; 2];
        contact_rolls[tip] = tip_roll;
        contact_rolls[flank] = crossing.roll;
        (is_on_flank && gap >= 0.0).then_some(ContactPlace {
            rolls: contact_rolls,
            gap,
            corner: Some(tip),
        })
    }

    /// Direction of the tip along the length of roll: +1 for an external, −1 for an internal gear.
    fn outward(&self, gear: usize) -> f64 {
        if gear == 1 { self.sense } else { 1.0 }
    }

    /// Transforms a point, m, from the frame of the mate to that of `gear`. The origin of a frame is the tangent point of the line of
    /// action, the x axis the line in the direction of increasing roll; the gear axis is at y = −r_b.
    fn to_gear_frame(self, gear: usize, [x, y]: [f64; 2]) -> [f64; 2] {
        let length = self.pitch_rolls[1] + self.sense * self.pitch_rolls[0];
        match self.sense > 0.0 {
            true => [length - x, -y],
            false if gear == 1 => [x + length, y],
            false => [x - length, y],
        }
    }
}

/// Point at the length of roll `roll` on an involute that crosses the line of action at the length of roll `on_line`, m.
fn involute_point(base: f64, on_line: f64, roll: f64) -> [f64; 2] {
    let rotation = (roll - on_line) / base;
    let (sine, cosine) = rotation.sin_cos();
    // 1 − cos by half angles, since corners lie near the line of action.
    let sine_of_half = (0.5 * rotation).sin();
    [
        roll * cosine - base * sine,
        roll * sine - 2.0 * base * sine_of_half * sine_of_half,
    ]
}

/// Involute of a base circle through a point.
struct Involute {
    /// Length of roll at the point, m.
    roll: f64,
    /// Length of roll at the intersection with the line of action, m.
    on_line: f64,
}

impl Involute {
    /// Involute through a point, m; `None` inside the base circle.
    fn through(base: f64, [x, y]: [f64; 2]) -> Option<Involute> {
        // R² − r_b² = x² + y² + 2 y r_b.
        let square = x * x + y * (y + 2.0 * base);
        let roll = (square >= 0.0).then(|| square.sqrt())?;
        let rotation = (roll / base).atan() - x.atan2(y + base);
        Some(Involute {
            roll,
            on_line: roll - base * rotation,
        })
    }
}
