//! Places where the teeth of a pair touch as the gears turn: on the line of action, or with a tip corner off it; the gap there.
//!
//! The pinion turned by φ from contact at the pitch point C meets its mate at the length of roll `s = s_C + r_b1 φ + j p_bt` of tooth
//! pair j. Before A the tip corner of gear 2 faces the flank of gear 1, beyond E the corner of gear 1 that of gear 2. Involutes of a
//! base circle are parallel curves, so the gap of a corner is the length of the base circle between its involute and the flank: the gear
//! of the flank turned by it touches the corner, and the force along the flank's normal turns that gear with its base radius. So a pair
//! has the same gaps and forces whichever gear is named first.

use crate::gear::cylindrical::pair::Pair;

/// Base pitches beyond the ends of the path over which corners are followed.
const CORNER_REACH: f64 = 0.5;

/// The path of contact of a pair in one transverse section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactPath {
    /// Base radii, m.
    pub base: [f64; 2],
    /// Lengths of roll at the pitch point, m.
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

/// A place where a pair of flanks touches or would touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactPlace {
    /// Lengths of roll on both flanks, m.
    pub rolls: [f64; 2],
    /// Gap of the involutes along the normal, m.
    pub gap: f64,
    /// The gear whose tip corner touches.
    pub corner: Option<usize>,
}

impl ContactPath {
    /// The path of a pair.
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

    /// The lengths of roll of gear 1 between which a pair may touch, corners included, m.
    pub fn reach(&self) -> [f64; 2] {
        let [start, end] = self.ends;
        let beyond = CORNER_REACH * self.base_pitch;
        [start - beyond, end + beyond]
    }

    /// Relative radius of curvature in the transverse section, m; none at a corner and at a base circle.
    pub fn relative_radius(&self, place: &ContactPlace) -> Option<f64> {
        let [first, second] = place.rolls;
        let curvature = first.recip() + self.sense * second.recip();
        (place.corner.is_none() && first > 0.0 && second > 0.0).then(|| curvature.recip())
    }

    /// The place of a pair whose flanks would meet at the length of roll `roll` of gear 1; `None` out of reach.
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

    /// The tip corner of a gear at the flank of its mate, both flanks at the rolls at which they cross the line of action.
    fn corner(&self, tip: usize, rolls: [f64; 2]) -> Option<ContactPlace> {
        let flank = 1 - tip;
        let tip_roll = self.flank_ends[tip][1];
        // Where a fillet ended the path before the tip reached it, nothing touches in between.
        let beyond_tip = (rolls[tip] - tip_roll) * self.outward(tip) > 0.0;
        if !beyond_tip {
            return None;
        }
        let at_tip = involute_point(self.base[tip], rolls[tip], tip_roll);
        let at_flank = self.in_frame_of(flank, at_tip);
        let crossing = Involute::through(self.base[flank], at_flank)?;
        let [form, mate_tip] = self.flank_ends[flank];
        let on_flank = (crossing.roll - form) * (crossing.roll - mate_tip) <= 0.0;
        let gap = self.outward(flank) * (crossing.on_line - rolls[flank]);
        let mut touching = [0.0; 2];
        touching[tip] = tip_roll;
        touching[flank] = crossing.roll;
        (on_flank && gap >= 0.0).then_some(ContactPlace {
            rolls: touching,
            gap,
            corner: Some(tip),
        })
    }

    /// +1 of a gear whose metal lies at the shorter rolls of the line and whose tip at the longest roll; −1 of an internal gear.
    fn outward(&self, gear: usize) -> f64 {
        if gear == 1 { self.sense } else { 1.0 }
    }

    /// A point in the frame of the other gear. A frame has the tangent point of the line of action as origin, the line as x axis in the
    /// direction of growing roll, and the gear's axis at y = −r_b.
    fn in_frame_of(&self, gear: usize, [x, y]: [f64; 2]) -> [f64; 2] {
        let length = self.pitch_rolls[1] + self.sense * self.pitch_rolls[0];
        match self.sense > 0.0 {
            true => [length - x, -y],
            false if gear == 1 => [x + length, y],
            false => [x - length, y],
        }
    }
}

/// The point of roll `roll` on an involute that crosses the line of action at the roll `on_line`.
fn involute_point(base: f64, on_line: f64, roll: f64) -> [f64; 2] {
    let turn = (roll - on_line) / base;
    let (sine, cosine) = turn.sin_cos();
    // 1 − cos by half angles: corners lie near the line.
    let half = (0.5 * turn).sin();
    [
        roll * cosine - base * sine,
        roll * sine - 2.0 * base * half * half,
    ]
}

/// The involute of a base circle through a point.
struct Involute {
    /// Length of roll at the point.
    roll: f64,
    /// Length of roll at which it crosses the line of action.
    on_line: f64,
}

impl Involute {
    /// `None` inside the base circle.
    fn through(base: f64, [x, y]: [f64; 2]) -> Option<Involute> {
        // R² − r_b² = x² + y² + 2 y r_b.
        let square = x * x + y * (y + 2.0 * base);
        let roll = (square >= 0.0).then(|| square.sqrt())?;
        let turn = (roll / base).atan() - x.atan2(y + base);
        Some(Involute {
            roll,
            on_line: roll - base * turn,
        })
    }
}
