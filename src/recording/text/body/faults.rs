//! What is wrong with a row, with its place.

use std::ops::Range;

use super::Reader;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::place::Place;
use crate::recording::text::cells;
use crate::recording::text::stamps::Trouble;

/// What is wrong with a row, and where.
pub(super) struct Fault {
    pub code: Code,
    pub message: String,
    pub span: Range<usize>,
    pub label: String,
    pub hint: &'static str,
}

pub(super) const MEND: &str =
    "mend the file, or say how it is laid out: --delimiter, --decimal, --header-lines";

impl Reader<'_> {
    pub(super) fn too_many(&self, line: &[u8], span: Range<usize>) -> Fault {
        let cells = cells::Cells::new(line, self.marks.delimiter).count();
        let width = self.plan.roles.len();
        Fault {
            code: Code::RaggedRow,
            message: format!("the row has {cells} cells where the rows before it have {width}"),
            span,
            label: format!("beyond column {width}"),
            hint: MEND,
        }
    }

    pub(super) fn no_number(&self, sink: usize, cell: &[u8], span: Range<usize>) -> Fault {
        let name = &self.plan.sinks[sink].name;
        let text = self.coding.text(cells::bare(cell));
        let text = crate::base::units::shortened(&text);
        Fault {
            code: Code::NotANumber,
            message: format!("\"{text}\" stands where a number of `{name}` is meant"),
            span,
            label: "not a number".into(),
            hint: "mend the cell, leave it blank if the sample is missing, or keep only other channels",
        }
    }

    pub(super) fn no_stamp(
        &self,
        trouble: Trouble,
        sink: usize,
        cell: &[u8],
        span: Range<usize>,
    ) -> Fault {
        let name = &self.plan.sinks[sink].name;
        let text = self.coding.text(cells::bare(cell));
        let text = crate::base::units::shortened(&text);
        match trouble {
            Trouble::NotAStamp => Fault {
                code: Code::NotANumber,
                message: format!("\"{text}\" stands where a time stamp of `{name}` is meant"),
                span,
                label: "not a time stamp".into(),
                hint: "mend the cell, or say which column is the time",
            },
            Trouble::OtherOrder => Fault {
                code: Code::BadTime,
                message: format!(
                    "\"{text}\" of `{name}` cannot have day and month in the order stated"
                ),
                span,
                label: "no such month".into(),
                hint: "leave --day-first and --month-first out, and `dates` in the sidecar, or mend the cell",
            },
            Trouble::DayOrMonth => Fault {
                code: Code::BadTime,
                message: format!(
                    "\"{text}\" of `{name}` may have the day or the month first, and the dates do not tell"
                ),
                span,
                label: "day or month".into(),
                hint: "say which comes first: --day-first or --month-first, or `dates` in the sidecar",
            },
        }
    }

    pub(super) fn error(&self, fault: &Fault, line: &[u8], number: usize) -> Error {
        // Lines far too long to be shown are shown around the cell.
        const SHOWN: usize = 2000;
        let from = if line.len() <= SHOWN {
            0
        } else {
            fault.span.start.saturating_sub(SHOWN / 2)
        };
        let to = line.len().min(from + SHOWN);
        let clip = |at: usize| at.clamp(from, to);
        let before = self.coding.text(&line[from..clip(fault.span.start)]);
        let within = self
            .coding
            .text(&line[clip(fault.span.start)..clip(fault.span.end)]);
        let after = self.coding.text(&line[clip(fault.span.end)..to]);
        let span = before.len()..before.len() + within.len();
        let place = Place::in_line(self.path, number, &format!("{before}{within}{after}"), span);
        Error::new(fault.code, fault.message.clone())
            .at(&place)
            .label(fault.label.clone())
            .hint(fault.hint)
    }
}
