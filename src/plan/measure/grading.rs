//! Comparison of values with tolerances: required grade, achieved grade of both ISO 1328 editions.

use crate::gear::measurement::deviation::GearDeviation;
use crate::gear::measurement::estimate::Estimate;
use crate::gear::measurement::iso1328::{Edition, GearSize, is_within};
use crate::gear::measurement::limits::{self, ToleranceLimit};
use crate::numeric::statistics::Z_95;
use crate::scene::measured_gear::{AccuracyRequirement, MeasuredGear};

/// Flanks that a measured value belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GradedFlanks {
    /// Both, or neither in particular.
    Both,
    /// Left flanks.
    Left,
    /// Right flanks.
    Right,
}

impl GradedFlanks {
    /// In the order files name columns.
    pub const ALL: [GradedFlanks; 3] =
        [GradedFlanks::Both, GradedFlanks::Left, GradedFlanks::Right];

    /// The word for it; empty for both.
    pub fn name(self) -> &'static str {
        match self {
            GradedFlanks::Both => "",
            GradedFlanks::Left => "left",
            GradedFlanks::Right => "right",
        }
    }
}

/// Grade achieved by a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum AchievedGrade {
    /// The finest grade that holds it.
    Grade(u32),
    /// Coarser than the coarsest there is.
    Beyond(u32),
}

/// Graded value with its quantity, flank, place and grades.
#[derive(Debug, Clone)]
pub struct GradedValue {
    /// Quantity of the value.
    pub quantity: GearDeviation,
    /// Flanks of the value.
    pub side: GradedFlanks,
    /// Place, or method, of the value: `pitches 7 to 13`.
    pub location: String,
    /// The value, m; angles were turned into lengths.
    pub estimate: Estimate,
    /// Computed from other charts, not measured.
    pub predicted: bool,
    /// Required grade.
    pub required_grade: Option<u32>,
    /// Lowest and highest value allowed, m.
    pub limits: Option<(f64, f64)>,
    /// By the editions of ISO 1328, in the order of [`Edition::ALL`]; `None` where one has no formula for it or for this gear.
    pub achieved: [Option<AchievedGrade>; 2],
    /// By the table of limits.
    pub reached_by_table: Option<AchievedGrade>,
    /// It sets the grade of the gear.
    pub limiting: bool,
}

impl GradedValue {
    /// Within its limits; `None` where it has none.
    pub fn is_within_limits(&self) -> Option<bool> {
        let (low, high) = self.limits?;
        let value = self.estimate.value;
        Some(match low == -high {
            true => is_within(value, high),
            false => (low..=high).contains(&value),
        })
    }

    /// The uncertainty reaches across a limit.
    pub fn is_inconclusive(&self) -> bool {
        let (Some((low, high)), Some(std)) = (self.limits, self.estimate.std) else {
            return false;
        };
        let off = (self.estimate.value - low)
            .abs()
            .min((high - self.estimate.value).abs());
        off < Z_95 * std
    }
}

/// Limits that rows are graded against.
pub struct Grader {
    size: GearSize,
    requirement: Option<AccuracyRequirement>,
    table: Vec<ToleranceLimit>,
    thickness: Option<[f64; 2]>,
}

impl Grader {
    /// For a gear and the limits of its table file, where it has one.
    pub fn new(gear: &MeasuredGear, table: Vec<ToleranceLimit>) -> Grader {
        Grader {
            size: GearSize {
                teeth: gear.gear.teeth,
                module: gear.gear.module,
                diameter: gear.gear.reference_diameter(),
                // Without a face width, no helix can be graded.
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

    /// A value as a row.
    pub fn grade(
        &self,
        quantity: GearDeviation,
        side: GradedFlanks,
        found: String,
        estimate: Estimate,
    ) -> GradedValue {
        let asked = self
            .requirement
            .as_ref()
            .filter(|_| quantity != GearDeviation::Thickness)
            .map(|requirement| requirement.accuracy.grade(quantity.group()));
        let symmetric = |limit: f64| (-limit, limit);
        let limits = match quantity {
            GearDeviation::Thickness => self.thickness.map(|[low, high]| (low, high)),
            _ => asked
                .and_then(|grade| self.limit(quantity, grade))
                .map(symmetric),
        };
        let by = |edition: Edition| {
            let grades = edition.grades(quantity);
            let coarsest = *grades.end();
            // Where the coarsest has a tolerance, all have.
            edition.tolerance(quantity, &self.size, coarsest)?;
            let grade = edition.grade_of(quantity, &self.size, estimate.value);
            Some(grade.map_or(AchievedGrade::Beyond(coarsest), AchievedGrade::Grade))
        };
        GradedValue {
            quantity,
            side,
            location: found,
            estimate,
            predicted: false,
            required_grade: limits.and(asked),
            limits,
            achieved: Edition::ALL.map(by),
            reached_by_table: self.reached_by_table(quantity, estimate.value),
            limiting: false,
        }
    }

    /// A value that was not measured: graded, but nothing is refused by it.
    pub fn grade_predicted(
        &self,
        quantity: GearDeviation,
        side: GradedFlanks,
        found: &str,
        estimate: Estimate,
    ) -> GradedValue {
        GradedValue {
            predicted: true,
            required_grade: None,
            limits: None,
            ..self.grade(quantity, side, found.to_string(), estimate)
        }
    }

    fn sizes(&self) -> [f64; 3] {
        let width = match self.size.face_width.is_nan() {
            // Any width the table has no border for.
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

    fn reached_by_table(&self, quantity: GearDeviation, value: f64) -> Option<AchievedGrade> {
        let coarsest = (0..=12)
            .rev()
            .find(|&g| limits::find_limit(&self.table, quantity, g, self.sizes()).is_some())?;
        let grade = limits::grade_of(&self.table, quantity, value, self.sizes());
        Some(grade.map_or(AchievedGrade::Beyond(coarsest), AchievedGrade::Grade))
    }

    /// Grade of a row by the required standard: the table, the requested edition, else the newer one.
    fn required_achieved(&self, row: &GradedValue) -> Option<AchievedGrade> {
        match self
            .requirement
            .as_ref()
            .map(|requirement| requirement.edition)
        {
            Some(None) => row.reached_by_table,
            Some(Some(Edition::Y1995)) => row.achieved[0],
            Some(Some(Edition::Y2013)) | None => row.achieved[1],
        }
    }

    /// Marks the measured row that is worst against the required grade of its group; the first of equals.
    pub fn mark_limiting(&self, rows: &mut [GradedValue]) {
        let grade = |row: &GradedValue| match self.required_achieved(row)? {
            AchievedGrade::Grade(grade) => Some(f64::from(grade)),
            // Beyond the coarsest there is no next one.
            AchievedGrade::Beyond(coarsest) => Some(f64::from(coarsest) + 1.0),
        };
        let worse = |row: &GradedValue| {
            let asked = self.requirement.as_ref();
            let asked = asked.map_or(0, |requirement| {
                requirement.accuracy.grade(row.quantity.group())
            });
            Some(grade(row)? - f64::from(asked))
        };
        let mut worst: Option<(usize, f64)> = None;
        for (at, row) in rows.iter().enumerate().filter(|(_, row)| !row.predicted) {
            if let Some(by) = worse(row)
                && worst.is_none_or(|(_, most)| by > most)
            {
                worst = Some((at, by));
            }
        }
        if let Some((at, _)) = worst {
            rows[at].limiting = true;
        }
    }

    /// Ratio of the finest grade's limit to a total deviation, m, where no gear is made so well; infinite for zero.
    pub fn below_all_gears(&self, quantity: GearDeviation, value: f64) -> Option<f64> {
        use GearDeviation::*;
        /// Parts of the tolerance of the finest grade (0 of 1995, 1 of 2013), which is itself finer than gears are made: readings a
        /// thousand times too small lie below it, those of a master gear do not.
        const SMALLEST: f64 = 0.1;
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
        (value < SMALLEST * finest).then_some(finest / value)
    }

    /// Reason why a quantity graded by the requested edition has no limit here.
    pub fn reason_without_limit(&self, quantity: GearDeviation) -> Option<String> {
        let edition = self.requirement.as_ref()?.edition?;
        let graded =
            edition.unrounded_tolerance(quantity, &self.size, *edition.grades(quantity).end());
        // Without a size in the formula it comes out as no number.
        graded?;
        edition.out_of_scope(quantity, &self.size)
    }
}
