//! Gaps and missing samples: split into segments, or filled by linear interpolation on request.

use std::ops::Range;

use super::{BLOCK, GRID_TOLERANCE, Preprocessing, Segment, copy};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::text::pluralise;
use crate::recording::read_options::{GapPolicy, ReadOptions};
use crate::recording::sample_column::SampleColumn;
use crate::recording::time_base::{Spacing, TimeBase};

impl Preprocessing {
    pub(super) fn report_gaps(&mut self, base: &TimeBase, options: &ReadOptions) {
        if let Spacing::Rounded {
            resolution_s,
            digits,
        } = base.spacing
        {
            let unit = crate::base::quantity::format_time(resolution_s);
            let rounded = match digits {
                Some(digits) => format!("{digits} significant digits, {unit} at the coarsest"),
                None => unit,
            };
            let message =
                format!("time stamps are rounded to {rounded}: samples are taken as evenly spaced");
            self.diagnostics.push(Diagnostic {
                code: "time-rounded",
                message,
                hint: None,
            });
        }
        if base.gaps.is_empty() || options.gaps == GapPolicy::Fill {
            return;
        }
        let missing: usize = base.gaps.iter().map(|g| g.missing).sum();
        let first = &base.gaps[0];
        let place = first
            .line
            .map_or(format!("sample {}", first.row + 1), |line| {
                format!("line {line}")
            });
        let count = base.gaps.len();
        let message = format!(
            "{} of {}{}, the first before {place} ({:.6} s): split into {} segments",
            pluralise(count, "gap"),
            if count == 1 { "" } else { "together " },
            pluralise(missing, "sample"),
            first.seconds,
            base.segments.len()
        );
        self.push_repair("gap-split", message);
    }

    /// Ends segments where a channel has no number.
    pub(super) fn split_at_missing(&mut self, empty: &[bool]) -> Result<(), Error> {
        let rows = self.channels.first().map_or(0, |c| c.samples.len());
        let mut block = vec![0.0; BLOCK.min(rows)];
        let (mut holes, mut rows_kept) = (0usize, Vec::new());
        let mut bad = vec![false; BLOCK.min(rows)];
        let mut open: Option<usize> = None;
        let starts: Vec<usize> = self.segments.iter().map(|s| s.rows.start).collect();
        let mut at = 0;
        while at < rows {
            let count = BLOCK.min(rows - at);
            bad[..count].fill(false);
            for (channel, empty) in self.channels.iter().zip(empty) {
                if *empty {
                    continue;
                }
                channel.samples.read(at, &mut block[..count])?;
                for (bad, x) in bad.iter_mut().zip(&block[..count]) {
                    *bad |= !x.is_finite();
                }
            }
            for (j, &bad) in bad[..count].iter().enumerate() {
                let row = at + j;
                if (bad || starts.binary_search(&row).is_ok())
                    && let Some(start) = open.take()
                    && start < row
                {
                    rows_kept.push(start..row);
                }
                holes += usize::from(bad);
                if !bad && open.is_none() {
                    open = Some(row);
                }
            }
            at += count;
        }
        rows_kept.extend(open.map(|start| start..rows));
        if holes > 0 {
            let rows = match holes {
                1 => "1 row has a channel without a number".to_string(),
                n => format!("{n} rows have a channel without a number"),
            };
            let left = match rows_kept.len() {
                1 => "the neighbouring segment is used".to_string(),
                n => format!("{n} segments without such rows are used"),
            };
            self.push_repair("cells-missing", format!("{rows}: {left}"));
        }
        if rows_kept.is_empty() {
            return Err(
                Error::new(Code::NoSignal, "no sample has a number in every channel").with_hint(
                    "choose channels that have numbers at the same time: --channel, --output",
                ),
            );
        }
        let of = |rows: Range<usize>| {
            let after = starts.partition_point(|&start| start <= rows.start);
            self.segments[after.saturating_sub(1)].slice(rows)
        };
        self.segments = rows_kept.into_iter().map(of).collect();
        Ok(())
    }

    /// Channels without any number, which are harmless unless requested.
    pub(super) fn empty_channels(&self) -> Result<Vec<bool>, Error> {
        self.channels
            .iter()
            .map(|channel| {
                let n = channel.samples.len();
                let mut block = vec![0.0; BLOCK.min(n)];
                let mut at = 0;
                while at < n {
                    let count = BLOCK.min(n - at);
                    channel.samples.read(at, &mut block[..count])?;
                    if block[..count].iter().any(|x| x.is_finite()) {
                        return Ok(false);
                    }
                    at += count;
                }
                Ok(true)
            })
            .collect()
    }

    /// Straight lines over gaps of the stamps and over missing numbers.
    pub(super) fn interpolate_gaps(&mut self) -> Result<(), Error> {
        /// More than this many times what was measured is nothing but straight lines.
        const MAX_FILL_RATIO: f64 = 10.0;
        let (Some(first), Some(last)) = (self.segments.first(), self.segments.last()) else {
            return Ok(());
        };
        if self.segments.len() < 2 {
            return Ok(());
        }
        let (start, length) = (first.start, last.end() - first.start);
        let held: usize = self.segments.iter().map(|s| s.rows.len()).sum();
        if length > MAX_FILL_RATIO * held as f64 {
            let message = format!(
                "{held} samples lie spread over {:.6} s, {length:.0} steps: filling the gaps would make up nearly all of it",
                length / self.rate_hz
            );
            return Err(Error::new(Code::OutOfRange, message)
                .with_hint("leave the gaps, or analyse a part without them: --after, --before"));
        }
        let steps = (self.segments.windows(2)).map(|pair| pair[1].start - pair[0].end());
        let (mut missing, mut off, mut most) = (Vec::new(), 0.0, 0.0f64);
        for steps in steps {
            let whole = (steps + off).round().max(0.0);
            off += steps - whole;
            most = most.max(f64::abs(off));
            missing.push(whole as usize);
        }
        for channel in &mut self.channels {
            let mut whole = SampleColumn::default();
            let mut before = 0.0;
            for (at, segment) in self.segments.iter().enumerate() {
                let (mut first, mut last) = ([0.0], [0.0]);
                channel.samples.read(segment.rows.start, &mut first)?;
                channel.samples.read(segment.rows.end - 1, &mut last)?;
                if let Some(&missing) = at.checked_sub(1).and_then(|at| missing.get(at)) {
                    let step = (first[0] - before) / (missing + 1) as f64;
                    let bridge: Vec<f64> =
                        (1..=missing).map(|k| before + k as f64 * step).collect();
                    whole.push(&bridge)?;
                }
                copy(&channel.samples, segment.rows.clone(), &mut whole, 1.0)?;
                before = last[0];
            }
            channel.samples = whole;
        }
        let filled: usize = missing.iter().sum();
        self.segments = vec![Segment {
            rows: 0..held + filled,
            start,
        }];
        let moved = match most > GRID_TOLERANCE {
            true => format!("; segments are moved by up to {most:.2} steps to fit"),
            false => String::new(),
        };
        let message = format!(
            "{} filled by straight lines, as requested: spectra near and above the width of the gaps are made up{moved}",
            pluralise(filled, "missing sample")
        );
        self.push_repair("gap-filled", message);
        Ok(())
    }
}
