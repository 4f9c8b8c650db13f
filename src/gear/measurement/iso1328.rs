//! Tolerances of ISO 1328-1:1995, -2:1997 and -1:2013: formula at grade 5 times `√2^(grade − 5)`.
//!
//! The 1995 edition evaluates the formulas at the geometric means of its table ranges, the 2013 edition at the actual gear dimensions.
//! Inside the formulas d, m_n and b are in mm and tolerances in µm; arguments and results are in m.

use super::deviation::GearDeviation;

/// Edition of ISO 1328.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edition {
    /// ISO 1328-1:1995, with ISO 1328-2:1997 for radial composite deviations and run-out.
    Y1995,
    /// ISO 1328-1:2013.
    Y2013,
}

/// Gear data on which the tolerances depend.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GearSize {
    /// Number of teeth.
    pub teeth: u32,
    /// Normal module, m.
    pub module: f64,
    /// Reference diameter, m.
    pub diameter: f64,
    /// Face width, m.
    pub face_width: f64,
    /// Helix angle, rad.
    pub helix: f64,
    /// Total contact ratio ε_γ with the mate, required by the single-flank tolerances of 1995.
    pub contact_ratio: Option<f64>,
    /// Design value of the short-wave component, m, which the single-flank tolerances of 2013 include.
    pub designed_short_wave: Option<f64>,
}

/// Limits of the table ranges of ISO 1328-1:1995, mm.
const DIAMETERS: [f64; 13] = [
    5.0, 20.0, 50.0, 125.0, 280.0, 560.0, 1000.0, 1600.0, 2500.0, 4000.0, 6000.0, 8000.0, 10000.0,
];
const MODULES: [f64; 9] = [0.5, 2.0, 3.5, 6.0, 10.0, 16.0, 25.0, 40.0, 70.0];
const WIDTHS: [f64; 10] = [
    4.0, 10.0, 20.0, 40.0, 80.0, 160.0, 250.0, 400.0, 650.0, 1000.0,
];
/// Limits of the ranges of ISO 1328-2:1997, mm; the actual size applies beyond them.
const DIAMETERS_2: [f64; 7] = [5.0, 20.0, 50.0, 125.0, 280.0, 560.0, 1000.0];
const MODULES_2: [f64; 9] = [0.2, 0.5, 0.8, 1.0, 1.5, 2.5, 4.0, 6.0, 10.0];

/// Relative excess over a limit attributed to rounding in the evaluation of the readings.
const ROUNDING: f64 = 1e-9;

impl Edition {
    /// Both editions.
    pub const ALL: [Edition; 2] = [Edition::Y1995, Edition::Y2013];

    /// Designation of the edition.
    pub fn name(self) -> &'static str {
        match self {
            Edition::Y1995 => "ISO 1328-1:1995",
            Edition::Y2013 => "ISO 1328-1:2013",
        }
    }

    /// Accuracy grades of the edition for a deviation.
    pub fn grades(self, quantity: GearDeviation) -> std::ops::RangeInclusive<u32> {
        match (self, quantity) {
            (Edition::Y1995, GearDeviation::DoubleFlankTotal | GearDeviation::DoubleFlankTooth) => {
                4..=12
            }
            (Edition::Y1995, _) => 0..=12,
            (Edition::Y2013, _) => 1..=11,
        }
    }

    /// Description of the first gear parameter outside the scope of the edition; `None` if all are inside.
    pub fn out_of_scope(self, quantity: GearDeviation, size: &GearSize) -> Option<String> {
        use GearDeviation::*;
        let (d, m, b) = millimetres(size);
        let is_double_flank = matches!(quantity, DoubleFlankTotal | DoubleFlankTooth);
        let (modules, diameters, widths) = match self {
            // Part 2 uses the actual sizes beyond its ranges, so only the lower limits apply.
            Edition::Y1995 if is_double_flank => ((0.2, 70.0), (5.0, 10000.0), (4.0, 1000.0)),
            Edition::Y1995 => ((0.5, 70.0), (5.0, 10000.0), (4.0, 1000.0)),
            Edition::Y2013 => ((0.5, 70.0), (5.0, 15000.0), (4.0, 1200.0)),
        };
        let check = |what: &str, value: f64, (low, high): (f64, f64)| {
            // Tolerance for rounding in the conversion to millimetres.
            let is_inside = value >= low * (1.0 - ROUNDING) && value <= high * (1.0 + ROUNDING);
            (!is_inside).then(|| format!("{what} {value:.6} mm is outside {low} to {high} mm"))
        };
        let is_helix = matches!(quantity, HelixTotal | HelixForm | HelixSlope);
        let is_2013 = self == Edition::Y2013;
        check("module", m, modules)
            .or_else(|| check("reference diameter", d, diameters))
            .or_else(|| is_helix.then(|| check("face width", b, widths)).flatten())
            .or_else(|| {
                let is_outside = is_2013 && !(5..=1000).contains(&size.teeth);
                is_outside.then(|| format!("{} teeth are outside 5 to 1000", size.teeth))
            })
            .or_else(|| {
                let is_steep = is_2013 && size.helix.abs().to_degrees() > 45.0 * (1.0 + ROUNDING);
                is_steep.then(|| "a helix above 45 deg is outside its range".to_string())
            })
    }

    /// Tolerance at a grade before rounding, m; `None` if the edition has no formula or a required gear parameter is missing.
    pub fn unrounded_tolerance(
        self,
        quantity: GearDeviation,
        size: &GearSize,
        grade: u32,
    ) -> Option<f64> {
        let base = match self {
            Edition::Y1995 => tolerance_1995(quantity, size)?,
            Edition::Y2013 => tolerance_2013(quantity, size)?,
        };
        // The design value does not scale with the grade.
        let step = std::f64::consts::SQRT_2.powi(grade as i32 - 5);
        Some(1e-6 * (base.graded * step + base.fixed))
    }

    /// Tolerance at a grade, rounded by the rules of the edition, m; `None` outside its grades or scope.
    pub fn tolerance(self, quantity: GearDeviation, size: &GearSize, grade: u32) -> Option<f64> {
        if !self.grades(quantity).contains(&grade) || self.out_of_scope(quantity, size).is_some() {
            return None;
        }
        let exact = 1e6 * self.unrounded_tolerance(quantity, size, grade)?;
        let part_2 = matches!(
            quantity,
            GearDeviation::DoubleFlankTotal
                | GearDeviation::DoubleFlankTooth
                | GearDeviation::Runout
        );
        let halves_only = self == Edition::Y1995 && part_2;
        Some(1e-6 * round_tolerance(exact, halves_only))
    }

    /// Finest grade whose tolerance is not exceeded by a deviation, m; `None` if every grade is exceeded or the edition has no formula.
    pub fn grade_of(self, quantity: GearDeviation, size: &GearSize, value: f64) -> Option<u32> {
        self.grades(quantity).find(|&grade| {
            self.tolerance(quantity, size, grade)
                .is_some_and(|limit| is_within(value, limit))
        })
    }
}

/// Whether the magnitude of a value is within a limit, apart from rounding.
pub fn is_within(value: f64, limit: f64) -> bool {
    value.abs() <= limit * (1.0 + ROUNDING)
}

/// Rounds a tolerance, µm: to 1 µm above 10 µm, to 0.5 µm from 5 µm, to 0.1 µm below (`halves_only`: to 0.5 µm, as in part 2 of 1997).
pub fn round_tolerance(micrometres: f64, halves_only: bool) -> f64 {
    match micrometres {
        x if x > 10.0 => x.round(),
        x if x >= 5.0 || halves_only => (2.0 * x).round() / 2.0,
        x => (10.0 * x).round() / 10.0,
    }
}

/// Tolerance at grade 5, µm.
struct Grade5Tolerance {
    /// Component scaled with the grade.
    graded: f64,
    /// Component independent of the grade.
    fixed: f64,
}

fn millimetres(size: &GearSize) -> (f64, f64, f64) {
    (
        1e3 * size.diameter,
        1e3 * size.module,
        1e3 * size.face_width,
    )
}

/// Geometric mean of the range that contains a value, upper limit included; the value itself outside all ranges.
fn mean_of_range(value: f64, limits: &[f64]) -> f64 {
    let range = limits
        .windows(2)
        .find(|w| value >= w[0] * (1.0 - ROUNDING) && value <= w[1] * (1.0 + ROUNDING));
    range.map_or(value, |w| (w[0] * w[1]).sqrt())
}

fn tolerance_1995(quantity: GearDeviation, size: &GearSize) -> Option<Grade5Tolerance> {
    use GearDeviation::*;
    let (d, m, b) = millimetres(size);
    let (d2, m2) = (mean_of_range(d, &DIAMETERS_2), mean_of_range(m, &MODULES_2));
    let (d, m, b) = (
        mean_of_range(d, &DIAMETERS),
        mean_of_range(m, &MODULES),
        mean_of_range(b, &WIDTHS),
    );
    let single = 0.3 * (m + 0.4 * d.sqrt()) + 4.0;
    let cumulative = 0.3 * m + 1.25 * d.sqrt() + 7.0;
    let profile = 3.2 * m.sqrt() + 0.22 * d.sqrt() + 0.7;
    let tooth = |contact_ratio: f64| {
        let k = match contact_ratio {
            e if e < 4.0 => 0.2 * (e + 4.0) / e,
            _ => 0.4,
        };
        k * (4.3 + single + profile)
    };
    let graded = match quantity {
        SinglePitch => single,
        CumulativePitch => cumulative,
        OverPitches(k) => single + 1.6 * (f64::from(k.saturating_sub(1)) * m).sqrt(),
        ProfileTotal => profile,
        ProfileForm => 2.5 * m.sqrt() + 0.17 * d.sqrt() + 0.5,
        ProfileSlope => 2.0 * m.sqrt() + 0.14 * d.sqrt() + 0.5,
        HelixTotal => 0.1 * d.sqrt() + 0.63 * b.sqrt() + 4.2,
        HelixForm | HelixSlope => 0.07 * d.sqrt() + 0.45 * b.sqrt() + 3.0,
        Runout => 0.8 * cumulative,
        SingleFlankTooth => tooth(size.contact_ratio?),
        SingleFlankTotal => cumulative + tooth(size.contact_ratio?),
        DoubleFlankTotal => 3.2 * m2 + 1.01 * d2.sqrt() + 6.4,
        DoubleFlankTooth => 2.96 * m2 + 0.01 * d2.sqrt() + 0.8,
        _ => return None,
    };
    Some(Grade5Tolerance { graded, fixed: 0.0 })
}

fn tolerance_2013(quantity: GearDeviation, size: &GearSize) -> Option<Grade5Tolerance> {
    use GearDeviation::*;
    let (d, m, b) = millimetres(size);
    let single = 0.001 * d + 0.4 * m + 5.0;
    let cumulative = 0.002 * d + 0.55 * d.sqrt() + 0.7 * m + 12.0;
    let (profile_slope, profile_form) = (0.4 * m + 0.001 * d + 4.0, 0.55 * m + 5.0);
    let helix_slope = 0.05 * d.sqrt() + 0.35 * b.sqrt() + 4.0;
    let helix_form = 0.07 * d.sqrt() + 0.45 * b.sqrt() + 4.0;
    let short = 0.375 * m + 5.0;
    let mut fixed = 0.0;
    let graded = match quantity {
        SinglePitch => single,
        CumulativePitch => cumulative,
        // Equal to the cumulative tolerance from k = z/4 on.
        OverPitches(k) => {
            let share = 4.0 * f64::from(k) / f64::from(size.teeth);
            single + share.min(1.0) * (0.001 * d + 0.55 * d.sqrt() + 0.3 * m + 7.0)
        }
        AdjacentPitch => std::f64::consts::SQRT_2 * single,
        ProfileSlope => profile_slope,
        ProfileForm => profile_form,
        ProfileTotal => profile_slope.hypot(profile_form),
        HelixSlope => helix_slope,
        HelixForm => helix_form,
        HelixTotal => helix_slope.hypot(helix_form),
        Runout => 0.9 * cumulative,
        SingleFlankShort => {
            fixed = 1e6 * size.designed_short_wave?;
            short
        }
        SingleFlankTotal => {
            fixed = 1e6 * size.designed_short_wave?;
            cumulative + short
        }
        _ => return None,
    };
    Some(Grade5Tolerance { graded, fixed })
}
