//! The time that is kept: between the times asked for, from a trigger on.

use super::channels::no_channel;
use super::{BLOCK, Settled, Stretch};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::recording::names;
use crate::recording::settings::{Settings, Trigger};

impl Settled {
    /// The place, at or after another, before which nothing is kept: the trigger's level is reached there or a little later.
    fn triggered(&mut self, trigger: &Trigger, from: f64) -> Result<f64, Error> {
        let known: Vec<String> = self.channels.iter().map(|c| c.name.clone()).collect();
        let found = names::find(&trigger.channel, &known);
        let at = found.ok_or_else(|| no_channel(&trigger.channel, &known))?;
        let mut largest = 0.0f64;
        let mut reached = None;
        for stretch in &self.stretches {
            let mut block = vec![0.0; BLOCK.min(stretch.rows.len())];
            let mut row = stretch.rows.start;
            while row < stretch.rows.end && reached.is_none() {
                let count = BLOCK.min(stretch.rows.end - row);
                self.channels[at].samples.read(row, &mut block[..count])?;
                for (k, x) in block[..count].iter().enumerate() {
                    let place = stretch.start + (row + k - stretch.rows.start) as f64;
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
                .hint("choose a lower level, in the numbers of the log"));
        };
        let start = (place - (trigger.before_s * self.rate_hz).round()).max(from);
        let message = format!(
            "kept from {:.6} s on: {} reaches {} at {:.6} s",
            start / self.rate_hz,
            known[at],
            trigger.level,
            place / self.rate_hz
        );
        self.repair("triggered", message);
        Ok(start)
    }

    /// Only the time that was asked for.
    pub(super) fn crop(&mut self, settings: &Settings) -> Result<(), Error> {
        let end = self.stretches.last().map_or(0.0, Stretch::end);
        let steps = |t: f64| (t * self.rate_hz).round();
        let (mut from, to) = (
            settings.from_s.map_or(0.0, steps),
            settings.to_s.map_or(end, steps),
        );
        if let Some(trigger) = &settings.trigger {
            from = self.triggered(trigger, from)?;
        }
        if from >= to.min(end) {
            let message = format!(
                "nothing lies between the times asked for: the log lasts {:.6} s",
                end / self.rate_hz
            );
            return Err(Error::new(Code::OutOfRange, message));
        }
        let cut = |s: &Stretch| {
            let row = |place: f64| {
                s.rows.start + (place - s.start).round().clamp(0.0, s.rows.len() as f64) as usize
            };
            s.part(row(from)..row(to))
        };
        self.stretches = self
            .stretches
            .iter()
            .map(cut)
            .filter(|s| !s.rows.is_empty())
            .collect();
        if self.stretches.is_empty() {
            return Err(Error::new(
                Code::NoSignal,
                "no samples lie between the times asked for",
            ));
        }
        Ok(())
    }
}
