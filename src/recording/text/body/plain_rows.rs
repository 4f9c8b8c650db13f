//! Rows whose cells are all numbers, read chunk by chunk on several threads.
//!
//! Such a row says nothing of the next: in each chunk they are read up to the first line that is anything else, and from there on by the
//! reader that takes line after line. Samples, line numbers and errors are those of that reader alone.

use super::{BLOCK, RowReader};
use crate::base::error::Error;
use crate::numeric::parallel;
use crate::recording::text::time_stamps::StampParser;

/// Chunks that a thread has at a time.
const CHUNKS_PER_THREAD: usize = 2;

/// Chunks of a block at most.
const MAX_CHUNKS: usize = 32;

/// Rows of numbers from the beginning of a chunk.
struct PlainRows {
    /// Bytes of these rows.
    bytes: usize,
    rows: usize,
    /// Samples of every sink, and the number of rows up to its last number.
    columns: Vec<(Vec<f64>, usize)>,
    stamps: Vec<StampParser>,
}

/// Bytes of a block that is read at once.
pub(super) fn block_len() -> usize {
    match parallel::threads() {
        1 => BLOCK,
        threads => BLOCK * (CHUNKS_PER_THREAD * threads).min(MAX_CHUNKS),
    }
}

impl RowReader<'_> {
    /// As [`RowReader::lines`].
    pub(super) fn lines_in_parallel(&mut self, block: &[u8], ended: bool) -> Result<usize, Error> {
        let all_ready = self
            .plan
            .accumulators
            .iter()
            .all(StampParser::is_independent);
        let chunks = match parallel::threads() > 1 && all_ready {
            true => split(block),
            false => Vec::new(),
        };
        let parsed = parallel::map(&chunks, |chunk| self.plain_rows(chunk));
        let mut used = 0;
        for (chunk, plain) in chunks.into_iter().zip(parsed) {
            let mut taken = 0;
            if self.no_row.is_none() {
                taken = plain.bytes;
                self.take(plain)?;
            }
            self.lines(&chunk[taken..], false)?;
            used += chunk.len();
        }
        Ok(used + self.lines(&block[used..], ended)?)
    }

    /// The rows of numbers that a chunk begins with.
    fn plain_rows(&self, chunk: &[u8]) -> PlainRows {
        let mut plan = self.plan.clone();
        let width = plan.sinks.len();
        let mut reader = RowReader::new("", &mut plan, self.marks, self.coding, &[], 0);
        let (mut bytes, mut rows) = (0, 0);
        while let Some(length) = memchr::memchr2(b'\n', b'\r', &chunk[bytes..]) {
            let end = bytes + length;
            let line = &chunk[bytes..end];
            let kept = reader.batch.len();
            let is_plain = !line.trim_ascii().is_empty()
                && reader.row(line).is_ok()
                && reader.gaps.is_empty()
                && reader.groups.is_empty();
            if !is_plain {
                reader.batch.truncate(kept);
                break;
            }
            rows += 1;
            bytes = match chunk[end..].starts_with(b"\r\n") {
                true => end + 2,
                false => end + 1,
            };
        }
        let column = |sink: usize| {
            let samples: Vec<f64> = reader.batch[sink..]
                .iter()
                .step_by(width)
                .copied()
                .collect();
            let last = samples.iter().rposition(|x| x.is_finite());
            (samples, last.map_or(0, |last| last + 1))
        };
        PlainRows {
            bytes,
            rows,
            columns: match rows {
                0 => Vec::new(),
                _ => (0..width).map(column).collect(),
            },
            stamps: plan.accumulators,
        }
    }

    /// Appends rows to the columns.
    fn take(&mut self, plain: PlainRows) -> Result<(), Error> {
        if plain.rows == 0 {
            return Ok(());
        }
        self.flush()?;
        for (filled, (samples, last)) in self.body.sinks.iter_mut().zip(&plain.columns) {
            if *last > 0 {
                filled.last_row_with_value = self.body.rows + last;
            }
            filled.samples.push(samples)?;
        }
        for (own, read) in self.plan.accumulators.iter_mut().zip(&plain.stamps) {
            own.merge(read);
        }
        self.body.lines.push(self.body.rows, self.line);
        self.body.rows += plain.rows;
        self.line += plain.rows;
        Ok(())
    }
}

/// Chunks of about [`BLOCK`] bytes that end with a line; what is behind the last line is in none.
fn split(block: &[u8]) -> Vec<&[u8]> {
    let mut chunks = Vec::new();
    let mut rest = block;
    while !rest.is_empty() {
        let part = &rest[..BLOCK.min(rest.len())];
        let Some(end) = memchr::memrchr(b'\n', part) else {
            break;
        };
        let (chunk, after) = rest.split_at(end + 1);
        chunks.push(chunk);
        rest = after;
    }
    chunks
}
