//! Gear deviations: ISO 1328 symbol and name, JB 179-60 name, tolerance group.

/// The three groups of demands that grades are stated for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ToleranceGroup {
    /// Kinematic accuracy: exactness of the transmitted motion over a turn.
    Motion,
    /// Smoothness of motion, tooth by tooth.
    Smoothness,
    /// Contact of the flanks.
    Contact,
}

/// A quantity that is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum GearDeviation {
    /// Largest deviation of a pitch.
    SinglePitch,
    /// Range of the cumulative pitch deviations.
    CumulativePitch,
    /// Largest deviation over so many pitches.
    OverPitches(u32),
    /// Largest difference of neighbouring pitches.
    AdjacentPitch,
    /// Largest deviation of the base pitch.
    BasePitch,
    /// Range of a profile trace.
    ProfileTotal,
    /// Range about the mean profile.
    ProfileForm,
    /// Inclination of the mean profile.
    ProfileSlope,
    /// Range of a helix trace.
    HelixTotal,
    /// Range about the mean helix.
    HelixForm,
    /// Inclination of the mean helix.
    HelixSlope,
    /// Range of radial readings.
    Runout,
    /// Single-flank, over a turn.
    SingleFlankTotal,
    /// Single-flank, inside a pitch.
    SingleFlankTooth,
    /// Single-flank, inside a pitch, without the long wave.
    SingleFlankShort,
    /// Double-flank, over a turn.
    DoubleFlankTotal,
    /// Double-flank, inside a pitch.
    DoubleFlankTooth,
    /// Range of the span over a turn.
    SpanVariation,
    /// Normal tooth thickness less its value without backlash.
    Thickness,
    /// Measured tip relief.
    TipRelief,
    /// Distance of the teeth's axis from the axis of turning.
    Eccentricity,
}

/// Designation of a quantity in JB 179-60.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Jb179Name {
    /// Symbol.
    pub symbol: &'static str,
    /// The symbol in plain letters, as table files have it.
    pub key: &'static str,
    /// Name.
    pub name: &'static str,
}

impl GearDeviation {
    /// Every quantity JB 179-60 or ISO 1328 state limits for; the span of pitches represents any.
    pub const LIMITED: [GearDeviation; 18] = [
        GearDeviation::SinglePitch,
        GearDeviation::CumulativePitch,
        GearDeviation::OverPitches(2),
        GearDeviation::AdjacentPitch,
        GearDeviation::BasePitch,
        GearDeviation::ProfileTotal,
        GearDeviation::ProfileForm,
        GearDeviation::ProfileSlope,
        GearDeviation::HelixTotal,
        GearDeviation::HelixForm,
        GearDeviation::HelixSlope,
        GearDeviation::Runout,
        GearDeviation::SingleFlankTotal,
        GearDeviation::SingleFlankTooth,
        GearDeviation::SingleFlankShort,
        GearDeviation::DoubleFlankTotal,
        GearDeviation::DoubleFlankTooth,
        GearDeviation::SpanVariation,
    ];

    /// Symbol in plain letters: keys of JSON and of table files.
    pub fn key(self) -> &'static str {
        self.labels().0
    }

    /// Symbol as tables show it.
    pub fn symbol(self) -> &'static str {
        self.labels().1
    }

    /// Name.
    pub fn name(self) -> &'static str {
        self.labels().2
    }

    fn labels(self) -> (&'static str, &'static str, &'static str) {
        use GearDeviation::*;
        match self {
            SinglePitch => ("fp", "f_p", "single pitch"),
            CumulativePitch => ("Fp", "F_p", "cumulative pitch"),
            OverPitches(_) => ("Fpk", "F_pk", "pitch over k teeth"),
            AdjacentPitch => ("fu", "f_u", "adjacent pitch difference"),
            BasePitch => ("fpb", "f_pb", "base pitch"),
            ProfileTotal => ("Fa", "F_α", "profile, total"),
            ProfileForm => ("ffa", "f_fα", "profile, form"),
            ProfileSlope => ("fHa", "f_Hα", "profile, slope"),
            HelixTotal => ("Fb", "F_β", "helix, total"),
            HelixForm => ("ffb", "f_fβ", "helix, form"),
            HelixSlope => ("fHb", "f_Hβ", "helix, slope"),
            Runout => ("Fr", "F_r", "run-out"),
            SingleFlankTotal => ("Fis", "F_i′", "single-flank, total"),
            SingleFlankTooth => ("fis", "f_i′", "single-flank, tooth to tooth"),
            SingleFlankShort => ("fks", "f_k′", "single-flank, short wave"),
            DoubleFlankTotal => ("Fid", "F_i″", "double-flank, total"),
            DoubleFlankTooth => ("fid", "f_i″", "double-flank, tooth to tooth"),
            SpanVariation => ("Fw", "F_w", "span variation"),
            Thickness => ("Esn", "E_sn", "tooth thickness deviation"),
            TipRelief => ("Ca", "C_αa", "tip relief"),
            Eccentricity => ("fe", "f_e", "eccentricity"),
        }
    }

    /// Designation in JB 179-60, where it exists.
    pub fn jb179_name(self) -> Option<Jb179Name> {
        use GearDeviation::*;
        let (key, symbol, name) = match self {
            SingleFlankTotal => ("dF_sum", "ΔF_Σ", "kinematic error"),
            CumulativePitch => ("dt_sum", "Δt_Σ", "cumulative error of circular pitch"),
            Runout => ("e0", "e_0", "run-out of the gear ring"),
            SpanVariation => ("d0L", "δ_0L", "variation of the base tangent"),
            DoubleFlankTotal => ("d0a", "δ_0a", "variation of centre distance in a turn"),
            SingleFlankShort => ("dF", "ΔF", "cyclic error"),
            BasePitch => ("dt0", "Δt_0", "deviation of the base pitch"),
            AdjacentPitch => ("dt", "Δt", "difference of adjacent circular pitches"),
            ProfileTotal => ("df", "Δf", "profile error"),
            DoubleFlankTooth => ("dga", "δ_γa", "variation of centre distance in a tooth"),
            HelixTotal => ("dB0", "ΔB_0", "error of tooth direction"),
            _ => return None,
        };
        Some(Jb179Name { symbol, key, name })
    }

    /// The group of demands it belongs to.
    pub fn group(self) -> ToleranceGroup {
        use GearDeviation::*;
        match self {
            CumulativePitch | OverPitches(_) | Runout | SingleFlankTotal | DoubleFlankTotal
            | SpanVariation | Eccentricity => ToleranceGroup::Motion,
            HelixTotal | HelixForm | HelixSlope => ToleranceGroup::Contact,
            _ => ToleranceGroup::Smoothness,
        }
    }

    /// The limited quantity of a key, today's or that of JB 179-60.
    pub fn from_key(key: &str) -> Option<GearDeviation> {
        let meant =
            |q: &GearDeviation| q.key() == key || q.jb179_name().is_some_and(|old| old.key == key);
        GearDeviation::LIMITED.into_iter().find(meant)
    }
}
