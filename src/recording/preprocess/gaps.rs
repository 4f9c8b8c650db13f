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

    /// Splits segments at rows in which a channel has no number; channels marked in `empty` are ignored.
    pub(super) fn split_at_missing(&mut self, empty: &[bool]) -> Result<(), Error> {
        let rows = self.channels.first().map_or(0, |c| c.samples.len());
        let mut block = vec![0.0; BLOCK.min(rows)];
        let (mut n_missing, mut valid) = (0usize, Vec::new());
        let mut is_missing = vec![false; BLOCK.min(rows)];
        let mut segment_start: Option<usize> = None;
        let starts: Vec<usize> = self.segments.iter().map(|s| s.rows.start).collect();
        let mut row_index = 0;
        while row_index < rows {
            let count = BLOCK.min(rows - row_index);
            is_missing[..count].fill(false);
            for (channel, empty) in self.channels.iter().zip(empty) {
                if *empty {
                    continue;
                }
                channel.samples.read(row_index, &mut block[..count])?;
                for (is_missing, x) in is_missing.iter_mut().zip(&block[..count]) {
                    *is_missing |= !x.is_finite();
                }
            }
            for (j, &is_missing) in is_missing[..count].iter().enumerate() {
                let row = row_index + j;
                if (is_missing || starts.binary_search(&row).is_ok())
                    && let Some(start) = segment_start.take()
                    && start < row
                {
                    valid.push(start..row);
                }
                n_missing += usize::from(is_missing);
                if !is_missing && segment_start.is_none() {
                    segment_start = Some(row);
                }
            }
            row_index += count;
        }
        valid.extend(segment_start.map(|start| start..rows));
        if n_missing > 0 {
            let rows = match n_missing {
                1 => "1 row has a channel without a number".to_string(),
                n => format!("{n} rows have a channel without a number"),
            };
            let left = match valid.len() {
                1 => "the neighbouring segment is used".to_string(),
                n => format!("{n} segments without such rows are used"),
            };
            self.push_repair("cells-missing", format!("{rows}: {left}"));
        }
        if valid.is_empty() {
            return Err(
                Error::new(Code::NoSignal, "no sample has a number in every channel").with_hint(
                    "choose channels that have numbers at the same time: --channel, --output",
                ),
            );
        }
        let to_segment = |rows: Range<usize>| {
            let after = starts.partition_point(|&start| start <= rows.start);
            self.segments[after.saturating_sub(1)].slice(rows)
        };
        self.segments = valid.into_iter().map(to_segment).collect();
        Ok(())
    }

    /// Marks the channels without any number.
    pub(super) fn empty_channels(&self) -> Result<Vec<bool>, Error> {
        self.channels
            .iter()
            .map(|channel| {
                let n = channel.samples.len();
                let mut block = vec![0.0; BLOCK.min(n)];
                let mut row = 0;
                while row < n {
                    let count = BLOCK.min(n - row);
                    channel.samples.read(row, &mut block[..count])?;
                    if block[..count].iter().any(|x| x.is_finite()) {
                        return Ok(false);
                    }
                    row += count;
                }
                Ok(true)
            })
            .collect()
    }

    /// Fills gaps of the time stamps and missing numbers by linear interpolation.
    pub(super) fn interpolate_gaps(&mut self) -> Result<(), Error> {
        /// Largest ratio of the length after filling to the number of measured samples.
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
                .with_hint("keep the gaps, or analyse a part without them: --after, --before"));
        }
        let steps = (self.segments.windows(2)).map(|pair| pair[1].start - pair[0].end());
        let (mut missing, mut remainder, mut most) = (Vec::new(), 0.0, 0.0f64);
        for steps in steps {
            let count = (steps + remainder).round().max(0.0);
            remainder += steps - count;
            most = most.max(f64::abs(remainder));
            missing.push(count as usize);
        }
        for channel in &mut self.channels {
            let mut filled = SampleColumn::default();
            let mut previous = 0.0;
            for (at, segment) in self.segments.iter().enumerate() {
                let (mut first, mut last) = ([0.0], [0.0]);
                channel.samples.read(segment.rows.start, &mut first)?;
                channel.samples.read(segment.rows.end - 1, &mut last)?;
                if let Some(&missing) = at.checked_sub(1).and_then(|at| missing.get(at)) {
                    let step = (first[0] - previous) / (missing + 1) as f64;
                    let bridge: Vec<f64> =
                        (1..=missing).map(|k| previous + k as f64 * step).collect();
                    filled.push(&bridge)?;
                }
                copy(&channel.samples, segment.rows.clone(), &mut filled, 1.0)?;
                previous = last[0];
            }
            channel.samples = filled;
        }
        let n_filled: usize = missing.iter().sum();
        self.segments = vec![Segment {
            rows: 0..held + n_filled,
            start,
        }];
        let moved = match most > GRID_TOLERANCE {
            true => format!("; segments are moved by up to {most:.2} steps to fit"),
            false => String::new(),
        };
        let message = format!(
            "{} filled by straight lines, as requested: spectra near and above the width of the gaps are made up{moved}",
            pluralise(n_filled, "missing sample")
        );
        self.push_repair("gap-filled", message);
        Ok(())
    }
}
