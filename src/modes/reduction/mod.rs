//! Model reduction `p = T_r r` and its error over a frequency band.

mod interior;

mod method;

mod band_error;

mod condensable;

pub use band_error::{BandError, ComparisonBand};
pub use condensable::{CondensableCoordinate, CondensationAdvice, find_condensable};
pub use method::{
    ModeSelection, ReducedModel, ReductionMethod, coordinate_by_name, natural_frequencies,
};
