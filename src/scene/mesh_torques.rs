//! Torques at the pinion as `[mesh]` of a gear file has them: `torque`, or `torques = "first:last:count"`.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::error_collector::ValueRange;
use crate::base::quantity;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::TableReader;

/// Most torques of a map.
const MAX_TORQUES: u32 = 1000;

/// `torque` or `torques` at the pinion, N·m; none of them is no load.
pub fn torques(f: &mut TableReader) -> Vec<f64> {
    f.exclusive("torque", "torques");
    let torque = f.optional_quantity("torque", QuantityKind::Torque, ValueRange::Positive);
    let torques = f.parsed("torques", parse_torques);
    torques.unwrap_or_else(|| torque.into_iter().collect())
}

/// Torques `A:B:N`, N·m where bare.
///
/// # Errors
/// What is no rising range of torques.
fn parse_torques(text: &str, subject: &str) -> Result<Vec<f64>, Error> {
    let form = |why: &str| {
        let shown = quantity::truncate(text);
        let message = format!("\"{shown}\" is not a range of torques: {why}");
        let hint = format!(
            "{subject} takes first:last:count, such as 20:400:20 or \"0.1 kN·m:2 kN·m:20\""
        );
        Error::new(Code::OutOfRange, message).with_hint(hint)
    };
    let [from, to, count] = text.split(':').collect::<Vec<_>>()[..] else {
        return Err(form("it does not have three parts"));
    };
    let torque = |text: &str| quantity::parse_or_bare(text, QuantityKind::Torque, "N·m", subject);
    let (from, to) = (torque(from)?, torque(to)?);
    let count: u32 = (count.trim().parse()).map_err(|_| form("the count is not a whole number"))?;
    if !(2..=MAX_TORQUES).contains(&count) {
        return Err(form(&format!("the count must be from 2 to {MAX_TORQUES}")));
    }
    if !(0.0 < from && from < to) {
        return Err(form("the first torque must be above 0 and below the last"));
    }
    let step = (to - from) / f64::from(count - 1);
    Ok((0..count).map(|k| from + step * f64::from(k)).collect())
}
