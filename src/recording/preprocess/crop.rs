//! Time range kept: from/to limits and trigger level.

use super::channels::unknown_channel;
use super::{BLOCK, Preprocessing, Segment};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::recording::channel_names;
use crate::recording::read_options::{ReadOptions, Trigger};

impl Preprocessing {
    /// The place, at or after another, before which nothing is kept: the trigger's level is reached there or a little later.
    fn trigger_position(&mut self, trigger: &Trigger, from: f64) -> Result<f64, Error> {
        let known: Vec<String> = self.channels.iter().map(|c| c.name.clone()).collect();
        let found = channel_names::find_channel(&trigger.channel, &known);
        let at = found.ok_or_else(|| unknown_channel(&trigger.channel, &known))?;
        let mut largest = 0.0f64;
        let mut reached = None;
        for segment in &self.segments {
            let mut block = vec![0.0; BLOCK.min(segment.rows.len())];
            let mut row = segment.rows.start;
            while row < segment.rows.end && reached.is_none() {
                let count = BLOCK.min(segment.rows.end - row);
                self.channels[at].samples.read(row, &mut block[..count])?;
                for (k, x) in block[..count].iter().enumerate() {
                    let place = segment.start + (row + k - segment.rows.start) as f64;
                    if place < from {
                        continue;
                    }
                    largest = largest.max(x.abs());
                    if x.abs() >= trigger.level {
                        reached = Some(place);
                        break;
                    }
                }
                row += count;
            }
        }
        let Some(place) = reached else {
            let message = format!(
                "the channel {} never reaches the level {} of the trigger: {largest:.6} at most",
                known[at], trigger.level
            );
            return Err(Error::new(Code::NoSignal, message)
                .with_hint("choose a lower level, in the numbers of the log"));
        };
        let start = (place - (trigger.before_s * self.rate_hz).round()).max(from);
        let message = format!(
            "kept from {:.6} s on: {} reaches {} at {:.6} s",
            start / self.rate_hz,
            known[at],
            trigger.level,
            place / self.rate_hz
        );
        self.push_repair("triggered", message);
        Ok(start)
    }

    /// Crops to the requested time range.
    pub(super) fn crop(&mut self, options: &ReadOptions) -> Result<(), Error> {
        let end = self.segments.last().map_or(0.0, Segment::end);
        let steps = |t: f64| (t * self.rate_hz).round();
        let (mut from, to) = (
            options.from_s.map_or(0.0, steps),
            options.to_s.map_or(end, steps),
        );
        if let Some(trigger) = &options.trigger {
            from = self.trigger_position(trigger, from)?;
        }
        if from >= to.min(end) {
            let message = format!(
                "no samples between the requested times: the log lasts {:.6} s",
                end / self.rate_hz
            );
            return Err(Error::new(Code::OutOfRange, message)
                .with_hint("state --after below --before, both within the log"));
        }
        let cut = |s: &Segment| {
            let row = |place: f64| {
                s.rows.start + (place - s.start).round().clamp(0.0, s.rows.len() as f64) as usize
            };
            s.slice(row(from)..row(to))
        };
        self.segments = self
            .segments
            .iter()
            .map(cut)
            .filter(|s| !s.rows.is_empty())
            .collect();
        if self.segments.is_empty() {
            return Err(Error::new(
                Code::NoSignal,
                "no samples between the requested times",
            ));
        }
        Ok(())
    }
}
