//! Readings of an unknown gear: spans, diameters, helix angle, mate.

use crate::base::code::Code;
use crate::base::error::Error;

/// A reading and its standard uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Value, m or rad.
    pub value: f64,
    /// Standard uncertainty, of the same unit.
    pub std: f64,
}

/// Span over `k` teeth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpanReading {
    /// Teeth, of an internal gear spaces, spanned.
    pub k: u32,
    /// Size, m.
    pub size: Reading,
}

/// Readings of an unknown gear.
#[derive(Debug, Clone, PartialEq)]
pub struct GearReadings {
    /// Number of teeth.
    pub teeth: u32,
    /// Teeth point inward.
    pub internal: bool,
    /// Spans over at least two numbers of teeth.
    pub spans: Vec<SpanReading>,
    /// Tip diameter, m.
    pub tip_diameter: Option<Reading>,
    /// Root diameter, m.
    pub root_diameter: Option<Reading>,
    /// Helix angle at the tip cylinder, rad; `None` for a spur gear. It needs the tip diameter.
    pub tip_helix: Option<Reading>,
    /// Deviation E_sn of the normal thickness, m, negative where the tooth was thinned: spans tell x_E, not x. `None`: unknown between 0
    /// and `unknown_thinning`.
    pub thickness_deviation: Option<f64>,
    /// The mate, as far as it is known.
    pub mate: Option<MateReadings>,
}

/// Readings of the mate of an unknown gear.
#[derive(Debug, Clone, PartialEq)]
pub struct MateReadings {
    /// Number of teeth.
    pub teeth: u32,
    /// Teeth point inward.
    pub internal: bool,
    /// Spans; none where the mate was not measured.
    pub spans: Vec<SpanReading>,
    /// Centre distance, m.
    pub centre_distance: Option<Reading>,
}

/// Lowest deviation of the normal thickness taken as possible where none is stated, m: −0.1 mm − 0.05 m_n, of small modules −0.15 m_n.
///
/// That is two to three times the share of each gear in the least backlash that ISO/TR 10064-2:1996 recommends for industrial drives,
/// `2/3 (0.06 + 0.0005 a + 0.03 m_n)` mm.
pub fn unknown_thinning(module: f64) -> f64 {
    -(1e-4 + 0.05 * module).min(0.15 * module)
}

impl GearReadings {
    /// Least and greatest deviation E_sn of the normal thickness that a gear of a module may have, m.
    pub(super) fn thickness_deviations(&self, module: f64) -> [f64; 2] {
        let unknown = [unknown_thinning(module), 0.0];
        self.thickness_deviation
            .map_or(unknown, |stated| [stated; 2])
    }

    /// # Errors
    /// `OutOfRange`: a reading no gear has. `IllPosed`: spans over one number of teeth only, or a helix angle without the tip diameter.
    pub(super) fn check(&self) -> Result<(), Error> {
        let mate_spans = self.mate.iter().flat_map(|mate| &mate.spans);
        let sizes = self.spans.iter().chain(mate_spans).map(|span| span.size);
        let diameters = [self.tip_diameter, self.root_diameter]
            .into_iter()
            .flatten();
        let distance = self.mate.iter().filter_map(|mate| mate.centre_distance);
        for reading in sizes.chain(diameters).chain(distance).chain(self.tip_helix) {
            let sensible = reading.value > 0.0
                && reading.std > 0.0
                && (reading.value + reading.std).is_finite();
            if !sensible {
                let message = format!(
                    "a reading is {} with a standard uncertainty of {}; both are positive",
                    reading.value, reading.std
                );
                return Err(Error::new(Code::OutOfRange, message));
            }
        }
        if self.teeth < 3 {
            return Err(Error::new(
                Code::OutOfRange,
                format!("{} teeth; give 3 or more", self.teeth),
            ));
        }
        if self.thickness_deviation.is_some_and(|e| !e.is_finite()) {
            return Err(Error::new(
                Code::OutOfRange,
                "the thickness deviation is not finite",
            ));
        }
        let first = self.spans.first().map(|span| span.k);
        if self.spans.iter().all(|span| Some(span.k) == first) {
            let message = "all spans are over one number of teeth, so the base pitch is unknown";
            return Err(Error::new(Code::IllPosed, message)
                .with_hint("measure over k and over k + 1 teeth"));
        }
        if self.tip_helix.is_some() && (self.tip_diameter.is_none() || self.internal) {
            let message = "the helix angle at the tip needs the tip diameter of an external gear";
            return Err(Error::new(Code::IllPosed, message).with_hint("measure the tip diameter"));
        }
        Ok(())
    }
}
