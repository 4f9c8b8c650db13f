//! Values beside their limits: the grade asked, the grade reached by either edition, what limits.

use crate::gear::measurement::estimate::Estimate;
use crate::gear::measurement::iso::{Edition, Size, keeps};
use crate::gear::measurement::limits::{self, Limit};
use crate::gear::measurement::quantity::Quantity;
use crate::numeric::statistics::HALF_INTERVAL;
use crate::scene::measured::{Demand, MeasuredGear};

/// Which flanks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Both, or neither in particular.
    Both,
    /// Left flanks.
    Left,
    /// Right flanks.
    Right,
}

impl Side {
    /// In the order files name columns.
    pub const ALL: [Side; 3] = [Side::Both, Side::Left, Side::Right];

    /// The word for it; empty for both.
    pub fn word(self) -> &'static str {
        match self {
            Side::Both => "",
            Side::Left => "left",
            Side::Right => "right",
        }
    }
}

/// How fine a value is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reached {
    /// The finest grade that holds it.
    Grade(u32),
    /// Coarser than the coarsest there is.
    Beyond(u32),
}

/// One value and all that is said of it.
#[derive(Debug, Clone)]
pub struct Row {
    /// What it is.
    pub quantity: Quantity,
    /// Of which flanks.
    pub side: Side,
    /// Where it was found, or how: `pitches 7 to 13`.
    pub found: String,
    /// The value, m; angles were turned into lengths.
    pub estimate: Estimate,
    /// Computed from other charts, not measured.
    pub predicted: bool,
    /// The grade asked of it.
    pub asked: Option<u32>,
    /// Lowest and highest value allowed, m.
    pub limits: Option<(f64, f64)>,
    /// By the editions of ISO 1328, in the order of [`Edition::ALL`]; `None` where one has no formula for it or for this gear.
    pub reached: [Option<Reached>; 2],
    /// By the table of limits.
    pub reached_by_table: Option<Reached>,
    /// It sets the grade of the gear.
    pub limiting: bool,
}

impl Row {
    /// Within its limits; `None` where it has none.
    pub fn within(&self) -> Option<bool> {
        let (low, high) = self.limits?;
        let value = self.estimate.value;
        Some(match low == -high {
            true => keeps(value, high),
            false => (low..=high).contains(&value),
        })
    }

    /// The uncertainty reaches across a limit.
    pub fn in_doubt(&self) -> bool {
        let (Some((low, high)), Some(std)) = (self.limits, self.estimate.std) else {
            return false;
        };
        let off = (self.estimate.value - low)
            .abs()
            .min((high - self.estimate.value).abs());
        off < HALF_INTERVAL * std
    }
}

/// What rows are held against.
pub struct Grader {
    size: Size,
    demand: Option<Demand>,
    table: Vec<Limit>,
    thickness: Option<[f64; 2]>,
}

impl Grader {
    /// For a gear and the limits of its table file, where it has one.
    pub fn new(gear: &MeasuredGear, table: Vec<Limit>) -> Grader {
        Grader {
            size: Size {
                teeth: gear.gear.teeth,
                module: gear.gear.module,
                diameter: gear.gear.diameter(),
                // Without a face width, no helix can be graded.
                face_width: gear.face_width.unwrap_or(f64::NAN),
                helix: gear.gear.helix,
                contact_ratio: gear.contact_ratio,
                designed_short_wave: gear.designed_short_wave,
            },
            demand: gear.demand.clone(),
            table,
            thickness: gear.thickness,
        }
    }

    /// A value as a row.
    pub fn row(&self, quantity: Quantity, side: Side, found: String, estimate: Estimate) -> Row {
        let asked = self
            .demand
            .as_ref()
            .filter(|_| quantity != Quantity::Thickness)
            .map(|demand| demand.accuracy.of(quantity.group()));
        let symmetric = |limit: f64| (-limit, limit);
        let limits = match quantity {
            Quantity::Thickness => self.thickness.map(|[low, high]| (low, high)),
            _ => asked
                .and_then(|grade| self.limit(quantity, grade))
                .map(symmetric),
        };
        let by = |edition: Edition| {
            let grades = edition.grades(quantity);
            let coarsest = *grades.end();
            // Where the coarsest has a tolerance, all have.
            edition.tolerance(quantity, &self.size, coarsest)?;
            let grade = edition.reached(quantity, &self.size, estimate.value);
            Some(grade.map_or(Reached::Beyond(coarsest), Reached::Grade))
        };
        Row {
            quantity,
            side,
            found,
            estimate,
            predicted: false,
            asked: limits.and(asked),
            limits,
            reached: Edition::ALL.map(by),
            reached_by_table: self.reached_by_table(quantity, estimate.value),
            limiting: false,
        }
    }

    /// A value that was not measured: graded, but nothing is refused by it.
    pub fn predicted(
        &self,
        quantity: Quantity,
        side: Side,
        found: &str,
        estimate: Estimate,
    ) -> Row {
        Row {
            predicted: true,
            asked: None,
            limits: None,
            ..self.row(quantity, side, found.to_string(), estimate)
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

    fn limit(&self, quantity: Quantity, grade: u32) -> Option<f64> {
        match self.demand.as_ref()?.edition {
            Some(edition) => edition.tolerance(quantity, &self.size, grade),
            None => limits::limit(&self.table, quantity, grade, self.sizes()),
        }
    }

    fn reached_by_table(&self, quantity: Quantity, value: f64) -> Option<Reached> {
        let coarsest = (0..=12)
            .rev()
            .find(|&g| limits::limit(&self.table, quantity, g, self.sizes()).is_some())?;
        let grade = limits::reached(&self.table, quantity, value, self.sizes());
        Some(grade.map_or(Reached::Beyond(coarsest), Reached::Grade))
    }

    /// The grade a row reached by what is asked: the table, the edition asked, else the newer one.
    fn judged(&self, row: &Row) -> Option<Reached> {
        match self.demand.as_ref().map(|demand| demand.edition) {
            Some(None) => row.reached_by_table,
            Some(Some(Edition::Y1995)) => row.reached[0],
            Some(Some(Edition::Y2013)) | None => row.reached[1],
        }
    }

    /// Marks the measured row that stands worst against the grade asked of its group; the first of equals.
    pub fn mark_limiting(&self, rows: &mut [Row]) {
        let grade = |row: &Row| match self.judged(row)? {
            Reached::Grade(grade) => Some(f64::from(grade)),
            // Beyond the coarsest there is no next one.
            Reached::Beyond(coarsest) => Some(f64::from(coarsest) + 1.0),
        };
        let worse = |row: &Row| {
            let asked = self.demand.as_ref();
            let asked = asked.map_or(0, |demand| demand.accuracy.of(row.quantity.group()));
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

    /// How many times a measured total is smaller than the finest grade allows, where no gear is made so well.
    pub fn below_all_gears(&self, row: &Row) -> Option<f64> {
        use Quantity::*;
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
        let value = row.estimate.value.abs();
        if row.predicted || value == 0.0 || !totals.contains(&row.quantity) {
            return None;
        }
        let finest = |edition: &Edition| {
            let grade = *edition.grades(row.quantity).start();
            edition.exact(row.quantity, &self.size, grade)
        };
        let finest = Edition::ALL.iter().find_map(finest)?;
        (value < SMALLEST * finest).then_some(finest / value)
    }

    /// Why a quantity that the edition asked grades has no limit here.
    pub fn outside(&self, quantity: Quantity) -> Option<String> {
        let edition = self.demand.as_ref()?.edition?;
        let graded = edition.exact(quantity, &self.size, *edition.grades(quantity).end());
        // Without a size in the formula it comes out as no number.
        graded?;
        edition.outside(quantity, &self.size)
    }
}
