//! A table of limits as CSV: `quantity,grade,module_from,module_to,diameter_from,diameter_to,limit`, sizes in mm, limits in µm.
//!
//! `width_from,width_to` may be added. A size belongs to a line where it is above `from` and at most `to`; an empty cell is no border.

use std::path::Path;
use std::sync::Arc;

use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::load;
use crate::base::quantity::truncate;
use crate::base::source_span::{SourceFile, SourceSpan};
use crate::base::text::suggestion;
use crate::gear::measurement::deviation::GearDeviation;
use crate::gear::measurement::limits::ToleranceLimit;

const REQUIRED_COLUMNS: [&str; 7] = [
    "quantity",
    "grade",
    "module_from",
    "module_to",
    "diameter_from",
    "diameter_to",
    "limit",
];

/// Reads a table.
///
/// # Errors
/// Everything wrong in it.
pub fn read(path: &Path) -> Result<(Arc<SourceFile>, Vec<ToleranceLimit>), Errors> {
    let source = load::load(path)?;
    let mut lines = lines(&source);
    let head = lines
        .next()
        .map(|(_, text)| cells(text))
        .unwrap_or_default();
    let at = |name: &str| head.iter().position(|h| *h == name);
    if let Some(missing) = REQUIRED_COLUMNS.iter().find(|name| at(name).is_none()) {
        let message = format!("the table of limits has no column `{missing}`");
        return Err(Error::new(Code::MissingKey, message)
            .with_span(&SourceSpan::new(source.clone(), 0..0))
            .with_hint(format!(
                "its first line reads {}",
                REQUIRED_COLUMNS.join(",")
            ))
            .into());
    }
    let mut errors = Vec::new();
    let mut table = Vec::new();
    for (start, text) in lines {
        let row = cells(text);
        let cell = |name: &str| at(name).and_then(|i| row.get(i)).copied().unwrap_or("");
        match line(&cell) {
            Ok(limit) => table.push(limit),
            Err(error) => {
                let span = SourceSpan::new(source.clone(), start..start + text.len());
                errors.push(error.with_span(&span));
            }
        }
    }
    if table.is_empty() && errors.is_empty() {
        let error = Error::new(Code::EmptyLog, "the table of limits has no rows");
        errors.push(error.with_span(&SourceSpan::new(source.clone(), 0..0)));
    }
    Errors::into_result(errors, || (source, table))
}

/// Lines that hold something, with where they begin; `#` begins a diagnostic.
pub(super) fn lines(source: &SourceFile) -> impl Iterator<Item = (usize, &str)> {
    let mut start = 0;
    source.text.split_inclusive('\n').filter_map(move |raw| {
        let begins = start;
        start += raw.len();
        let text = raw.trim_end();
        (!text.is_empty() && !text.starts_with('#')).then_some((begins, text))
    })
}

/// Cells of a line, separated by semicolons where it has any, else by commas.
pub(super) fn cells(text: &str) -> Vec<&str> {
    let separator = if text.contains(';') { ';' } else { ',' };
    text.split(separator)
        .map(|c| c.trim().trim_matches('"'))
        .collect()
}

fn line<'c>(cell: &impl Fn(&str) -> &'c str) -> Result<ToleranceLimit, Error> {
    let key = cell("quantity");
    let quantity = GearDeviation::from_key(key).ok_or_else(|| {
        let keys = GearDeviation::LIMITED
            .into_iter()
            .flat_map(|q| std::iter::once(q.key()).chain(q.jb179_name().map(|old| old.key)));
        let hint = match suggestion(key, keys) {
            Some(meant) => format!("did you mean {meant}?"),
            None => "it takes dF_sum, dt_sum, e0, d0L, d0a, dF, dt0, dt, df, dga, dB0, or today's keys such as Fp".into(),
        };
        let message = format!("\"{}\" is not a known quantity", truncate(key));
        Error::new(Code::OutOfRange, message).with_hint(hint)
    })?;
    let grade = cell("grade");
    let grade = grade.parse().map_err(|_| {
        let message = format!("grade \"{}\" is not a whole number", truncate(grade));
        Error::new(Code::OutOfRange, message).with_hint("give a grade from 0 to 12")
    })?;
    let range = |what: &str| -> Result<(f64, f64), Error> {
        let (from, to) = (format!("{what}_from"), format!("{what}_to"));
        let low = number(&from, cell(&from), 0.0)?;
        let high = number(&to, cell(&to), f64::INFINITY)?;
        match low < high {
            true => Ok((1e-3 * low, 1e-3 * high)),
            false => Err(Error::new(
                Code::OutOfRange,
                format!("`{from}` {low} is not below `{to}` {high}"),
            )
            .with_hint("a row applies to sizes above `from` and at most `to`")),
        }
    };
    let limit = number("limit", cell("limit"), f64::NAN)?;
    if !(limit > 0.0 && limit.is_finite()) {
        let message = format!("`limit` \"{}\" is not above zero", truncate(cell("limit")));
        return Err(Error::new(Code::OutOfRange, message).with_hint("limits are in µm"));
    }
    Ok(ToleranceLimit {
        quantity,
        grade,
        modules: range("module")?,
        diameters: range("diameter")?,
        widths: range("width")?,
        limit: 1e-6 * limit,
    })
}

fn number(name: &str, text: &str, empty: f64) -> Result<f64, Error> {
    if text.is_empty() {
        return Ok(empty);
    }
    let found: Option<f64> = text.parse().ok();
    found.filter(|x| !x.is_nan()).ok_or_else(|| {
        let message = format!("`{name}` \"{}\" is not a number", truncate(text));
        Error::new(Code::NotANumber, message)
            .with_hint("sizes are in mm, limits in µm, with a decimal point")
    })
}
