//! Why the data of a bevel pair give no blanks, or the cones of a blank no teeth.

/// End of the teeth of a bevel gear.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The end nearer the apex.
    Toe,
    /// The outer end.
    Heel,
}

/// Why a blank has no teeth; lengths in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ToothFault {
    /// The face reaches the pitch apex.
    BeyondApex {
        /// Inner cone distance R_i, not above zero.
        inner_cone_distance: f64,
    },
    /// The face cone does not lie outside the root cone.
    NoDepth {
        /// The end.
        end: End,
        /// Depth of the tooth there, not above zero.
        depth: f64,
    },
    /// A corner of the tooth does not lie on its side of the axis.
    AtAxis {
        /// The end.
        end: End,
    },
}

/// Why data give no blanks; members are 0 for the pinion and 1 for the wheel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BlankFault {
    /// No cones of both axes touch at the stated radius, offset and spiral angle.
    NoPitchCones,
    /// Pitch cones exist, none of which has the cutter radius for its limit radius of curvature.
    LimitCurvature {
        /// Least and greatest limit curvature `1/ρ_lim` of these cones, 1/m.
        reached: [f64; 2],
    },
    /// At this offset the face of one member does not lie across that of the other.
    NoFace {
        /// The member.
        member: usize,
    },
    /// A tooth has no section.
    Tooth {
        /// The member.
        member: usize,
        /// The missing part.
        fault: ToothFault,
    },
    /// The tooth line of the cutter does not reach an end of the face.
    ToothLine,
    /// A tooth has no thickness at the mean point.
    NoThickness {
        /// The member.
        member: usize,
        /// Mean normal thickness s_mn, m.
        thickness: f64,
    },
}
