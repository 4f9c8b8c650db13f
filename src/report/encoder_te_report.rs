//! Transmission error from encoder records as it is shown by `te`.

use serde_json::Value;

use super::presentation::{Figure, Presentation, Provenance};
use super::table::Table;
use super::{encoder_te, encoder_te_plot, encoder_te_table};
use crate::base::error::Error;
use crate::plan::logs::encoder_analysis::EncoderResult;
use crate::recording::raw::Repair;
use crate::transmission::encoder::gear_train::GearTrain;

/// The transmission error of a record of two encoders.
pub struct EncoderReport {
    /// Above the plot.
    pub title: String,
    /// Repairs of the data.
    pub repairs: Vec<Repair>,
    /// The evaluation.
    pub result: EncoderResult,
    /// The teeth between the encoders.
    pub teeth: GearTrain,
    /// Every order is shown, not the largest only.
    pub all: bool,
}

impl Presentation for EncoderReport {
    fn provenance(&self) -> Provenance<'_> {
        Provenance::of_log(&self.result.trace, &self.repairs, &self.result.diagnostics)
    }

    fn body(&self) -> Result<Value, Error> {
        Ok(encoder_te::body(&self.result, &self.teeth))
    }

    fn text(&self) -> String {
        encoder_te_table::record(&self.result, self.all)
    }

    fn table(&self) -> Table<'_> {
        encoder_te::table(&self.result)
    }

    fn figures(&self) -> Result<Vec<Figure>, Error> {
        let drawn = encoder_te_plot::draw_record(&self.result, &self.title);
        Ok(vec![Figure::first(drawn)])
    }
}
