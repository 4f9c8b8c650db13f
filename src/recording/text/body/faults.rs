//! Errors of a row, with their place.

use std::ops::Range;

use super::RowReader;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::source_span::SourceSpan;
use crate::recording::text::cells;
use crate::recording::text::time_stamps::StampError;

/// Error of a row, and its place in the line.
pub(super) struct RowError {
    pub code: Code,
    pub message: String,
    pub span: Range<usize>,
    pub label: String,
    pub hint: &'static str,
}

pub(super) const HINT_CELLS: &str =
    "correct the file, or state its layout: --delimiter, --decimal, --header-lines";

impl RowReader<'_> {
    pub(super) fn too_many(&self, line: &[u8], span: Range<usize>) -> RowError {
        let cells = cells::CellIter::new(line, self.marks.delimiter).count();
        let width = self.plan.roles.len();
        RowError {
            code: Code::RaggedRow,
            message: format!("the row has {cells} cells, the rows before it {width}"),
            span,
            label: format!("beyond column {width}"),
            hint: HINT_CELLS,
        }
    }

    pub(super) fn not_a_number(&self, sink: usize, cell: &[u8], span: Range<usize>) -> RowError {
        let name = &self.plan.sinks[sink].name;
        let text = self.encoding.text(cells::trim_cell(cell));
        let text = crate::base::quantity::truncate(&text);
        RowError {
            code: Code::NotANumber,
            message: format!("\"{text}\" is not a number of `{name}`"),
            span,
            label: "not a number".into(),
            hint: "correct the cell, leave it blank if the sample is missing, or select other channels",
        }
    }

    pub(super) fn invalid_stamp(
        &self,
        trouble: StampError,
        sink: usize,
        cell: &[u8],
        span: Range<usize>,
    ) -> RowError {
        let name = &self.plan.sinks[sink].name;
        let text = self.encoding.text(cells::trim_cell(cell));
        let text = crate::base::quantity::truncate(&text);
        match trouble {
            StampError::Invalid => RowError {
                code: Code::NotANumber,
                message: format!("\"{text}\" is not a time stamp of `{name}`"),
                span,
                label: "not a time stamp".into(),
                hint: "correct the cell, or state which column is the time",
            },
            StampError::ConflictingOrder => RowError {
                code: Code::InvalidTimeStamps,
                message: format!(
                    "\"{text}\" of `{name}` cannot have day and month in the order stated"
                ),
                span,
                label: "no such month".into(),
                hint: "omit --day-first and --month-first, and `dates` in the sidecar, or correct the cell",
            },
            StampError::AmbiguousOrder => RowError {
                code: Code::InvalidTimeStamps,
                message: format!(
                    "\"{text}\" of `{name}` may have the day or the month first; the dates are ambiguous"
                ),
                span,
                label: "day or month".into(),
                hint: "state which comes first: --day-first or --month-first, or `dates` in the sidecar",
            },
        }
    }

    pub(super) fn error(&self, fault: &RowError, line: &[u8], number: usize) -> Error {
        // Lines far too long to be shown are shown around the cell.
        const MAX_LINE_SHOWN: usize = 2000;
        let from = if line.len() <= MAX_LINE_SHOWN {
            0
        } else {
            fault.span.start.saturating_sub(MAX_LINE_SHOWN / 2)
        };
        let to = line.len().min(from + MAX_LINE_SHOWN);
        let clip = |at: usize| at.clamp(from, to);
        let before = self.encoding.text(&line[from..clip(fault.span.start)]);
        let within = self
            .encoding
            .text(&line[clip(fault.span.start)..clip(fault.span.end)]);
        let after = self.encoding.text(&line[clip(fault.span.end)..to]);
        let span = before.len()..before.len() + within.len();
        let place =
            SourceSpan::within_line(self.path, number, &format!("{before}{within}{after}"), span);
        Error::new(fault.code, fault.message.clone())
            .with_span(&place)
            .with_label(fault.label.clone())
            .with_hint(fault.hint)
    }
}
