//! Grading of measured values: limits of the required grade, achieved grades by both editions of ISO 1328.

use crate::gear::measurement::deviation::GearDeviation;
use crate::gear::measurement::estimate::Estimate;
use crate::gear::measurement::iso1328::{Edition, GearSize, is_within};
use crate::gear::measurement::limits::{self, ToleranceLimit};
use crate::numeric::statistics::Z_95;
use crate::scene::measured_gear::{AccuracyRequirement, MeasuredGear};

/// Flanks of a measured value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GradedFlanks {
    /// Both flanks, or a value without flank.
    Both,
    /// Left flanks.
    Left,
    /// Right flanks.
    Right,
}

impl GradedFlanks {
    /// All variants, in the order of the column lists of a chart.
    pub const ALL: [GradedFlanks; 3] =
        [GradedFlanks::Both, GradedFlanks::Left, GradedFlanks::Right];

    /// Name of the flank; empty for both.
    pub fn name(self) -> &'static str {
        match self {
            GradedFlanks::Both => "",
            GradedFlanks::Left => "left",
            GradedFlanks::Right => "right",
        }
    }
}

/// Accuracy grade achieved by a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum AchievedGrade {
    /// Finest grade whose tolerance contains the value.
    Grade(u32),
    /// Outside the coarsest grade, which is given.
    Beyond(u32),
}

/// Measured value with its limits and grades.
#[derive(Debug, Clone)]
pub struct GradedValue {
    /// Quantity of the value.
    pub quantity: GearDeviation,
    /// Flanks of the value.
    pub side: GradedFlanks,
    /// Location or method of the value, such as `pitches 7 to 13`.
    pub location: String,
    /// Value with its standard deviation, m; angles are converted to lengths.
    pub estimate: Estimate,
    /// True if the value is computed from other charts, not measured.
    pub predicted: bool,
    /// Required grade.
    pub required_grade: Option<u32>,
    /// Lower and upper limit, m.
    pub limits: Option<(f64, f64)>,
    /// Grades by the editions of ISO 1328, in the order of [`Edition::ALL`]; `None` without a formula for the quantity or the gear.
    pub achieved: [Option<AchievedGrade>; 2],
    /// Grade by the table of limits.
    pub table_grade: Option<AchievedGrade>,
    /// True if the value determines the grade of the gear.
    pub limiting: bool,
}

impl GradedValue {
    /// True if the value is within its limits; `None` without limits.
    pub fn is_within_limits(&self) -> Option<bool> {
        let (low, high) = self.limits?;
        let value = self.estimate.value;
        Some(match low == -high {
            true => is_within(value, high),
            false => (low..=high).contains(&value),
        })
    }

    /// True if the 95 % interval of the value contains a limit.
    pub fn is_inconclusive(&self) -> bool {
        let (Some((low, high)), Some(std)) = (self.limits, self.estimate.std) else {
            return false;
        };
        let margin = (self.estimate.value - low)
            .abs()
            .min((high - self.estimate.value).abs());
        margin < Z_95 * std
    }
}

/// Gear size and requirements by which values are graded.
pub struct Grader {
    size: GearSize,
    requirement: Option<AccuracyRequirement>,
    table: Vec<ToleranceLimit>,
    thickness: Option<[f64; 2]>,
}

impl Grader {
    /// Grader of a gear with the limits of its table file; `table` is empty without one.
    pub fn new(gear: &MeasuredGear, table: Vec<ToleranceLimit>) -> Grader {
        Grader {
            size: GearSize {
                teeth: gear.gear.teeth,
                module: gear.gear.module,
                diameter: gear.gear.reference_diameter(),
                // NaN leaves helix deviations ungraded.
                face_width: gear.face_width.unwrap_or(f64::NAN),
                helix: gear.gear.helix,
                contact_ratio: gear.contact_ratio,
                designed_short_wave: gear.designed_short_wave,
            },
            requirement: gear.requirement.clone(),
            table,
            thickness: gear.thickness,
        }
    }

    /// Grades a value.
    pub fn grade(
        &self,
        quantity: GearDeviation,
        side: GradedFlanks,
        location: String,
        estimate: Estimate,
    ) -> GradedValue {
        let required = self
            .requirement
            .as_ref()
            .filter(|_| quantity != GearDeviation::Thickness)
            .map(|requirement| requirement.accuracy.grade(quantity.group()));
        let symmetric = |limit: f64| (-limit, limit);
        let limits = match quantity {
            GearDeviation::Thickness => self.thickness.map(|[low, high]| (low, high)),
            _ => required
                .and_then(|grade| self.limit(quantity, grade))
                .map(symmetric),
        };
        let by_edition = |edition: Edition| {
            let grades = edition.grades(quantity);
            let coarsest = *grades.end();
            // A tolerance of the coarsest grade implies tolerances of all grades.
            edition.tolerance(quantity, &self.size, coarsest)?;
            let grade = edition.grade_of(quantity, &self.size, estimate.value);
            Some(grade.map_or(AchievedGrade::Beyond(coarsest), AchievedGrade::Grade))
        };
        GradedValue {
            quantity,
            side,
            location,
            estimate,
            predicted: false,
            required_grade: limits.and(required),
            limits,
            achieved: Edition::ALL.map(by_edition),
            table_grade: self.table_grade(quantity, estimate.value),
            limiting: false,
        }
    }

    /// Grades a predicted value: without required grade and limits.
    pub fn grade_predicted(
        &self,
        quantity: GearDeviation,
        side: GradedFlanks,
        location: &str,
        estimate: Estimate,
    ) -> GradedValue {
        GradedValue {
            predicted: true,
            required_grade: None,
            limits: None,
            ..self.grade(quantity, side, location.to_string(), estimate)
        }
    }

    fn sizes(&self) -> [f64; 3] {
        let width = match self.size.face_width.is_nan() {
            // The widest class of the table.
            true => f64::MAX,
            false => self.size.face_width,
        };
        [self.size.module, self.size.diameter, width]
    }

    fn limit(&self, quantity: GearDeviation, grade: u32) -> Option<f64> {
        match self.requirement.as_ref()?.edition {
            Some(edition) => edition.tolerance(quantity, &self.size, grade),
            None => limits::find_limit(&self.table, quantity, grade, self.sizes()),
        }
    }

    fn table_grade(&self, quantity: GearDeviation, value: f64) -> Option<AchievedGrade> {
        let coarsest = (0..=12)
            .rev()
            .find(|&g| limits::find_limit(&self.table, quantity, g, self.sizes()).is_some())?;
        let grade = limits::grade_of(&self.table, quantity, value, self.sizes());
        Some(grade.map_or(AchievedGrade::Beyond(coarsest), AchievedGrade::Grade))
    }

    /// Grade of a row by the required standard: the table, the requested edition, by default the 2013 edition.
    fn required_achieved(&self, row: &GradedValue) -> Option<AchievedGrade> {
        match self
            .requirement
            .as_ref()
            .map(|requirement| requirement.edition)
        {
            Some(None) => row.table_grade,
            Some(Some(Edition::Y1995)) => row.achieved[0],
            Some(Some(Edition::Y2013)) | None => row.achieved[1],
        }
    }

    /// Marks the measured row that exceeds the required grade of its group most; the first of equal rows.
    pub fn mark_limiting(&self, rows: &mut [GradedValue]) {
        let grade = |row: &GradedValue| match self.required_achieved(row)? {
            AchievedGrade::Grade(grade) => Some(f64::from(grade)),
            // One grade coarser than the coarsest.
            AchievedGrade::Beyond(coarsest) => Some(f64::from(coarsest) + 1.0),
        };
        let excess = |row: &GradedValue| {
            let required = self.requirement.as_ref();
            let required = required.map_or(0, |requirement| {
                requirement.accuracy.grade(row.quantity.group())
            });
            Some(grade(row)? - f64::from(required))
        };
        let mut worst: Option<(usize, f64)> = None;
        for (index, row) in rows.iter().enumerate().filter(|(_, row)| !row.predicted) {
            if let Some(grades) = excess(row)
                && worst.is_none_or(|(_, largest)| grades > largest)
            {
                worst = Some((index, grades));
            }
        }
        if let Some((index, _)) = worst {
            rows[index].limiting = true;
        }
    }

    /// Ratio of the tolerance of the finest grade to a total deviation, m, if this is implausibly small; infinite for zero.
    pub fn implausible_ratio(&self, quantity: GearDeviation, value: f64) -> Option<f64> {
        use GearDeviation::*;
        /// Smallest plausible deviation, relative to the tolerance of the finest grade (0 of 1995, 1 of 2013): above readings in a unit
        /// a thousand times too small, below those of a master gear.
        const MIN_SHARE: f64 = 0.1;
        let totals = [
            CumulativePitch,
            ProfileTotal,
            HelixTotal,
            Runout,
            SingleFlankTotal,
            DoubleFlankTotal,
        ];
        if !totals.contains(&quantity) {
            return None;
        }
        let finest = |edition: &Edition| {
            let grade = *edition.grades(quantity).start();
            edition.unrounded_tolerance(quantity, &self.size, grade)
        };
        let finest = Edition::ALL.iter().find_map(finest)?;
        (value < MIN_SHARE * finest).then_some(finest / value)
    }

    /// Reason why a quantity graded by the requested edition has no limit for this gear.
    pub fn reason_without_limit(&self, quantity: GearDeviation) -> Option<String> {
        let edition = self.requirement.as_ref()?.edition?;
        let tolerance =
            edition.unrounded_tolerance(quantity, &self.size, *edition.grades(quantity).end());
        // The tolerance is NaN if a size of the formula is missing.
        tolerance?;
        edition.out_of_scope(quantity, &self.size)
    }
}
