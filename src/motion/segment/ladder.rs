//! Strides of a machine over round times, made when first wanted and kept: what goes on by one of them takes no exponential.

use std::collections::VecDeque;

use super::course::{Parts, Stride};

/// Leading binary digits of a stride after the first: it is at most a quarter shorter than what was asked for.
const DIGITS: u32 = 2;

/// Strides kept at most, from the shortest to the longest; beyond, the others are made again.
const MOST: usize = 512;

/// The strides of one machine.
#[derive(Debug, Default)]
pub struct Ladder {
    /// Leading bits of the shortest.
    shortest: usize,
    /// By rising time.
    rungs: VecDeque<Option<Stride>>,
}

impl Ladder {
    /// The longest round stride that is no longer than `span`, s; nothing where that is no usual number.
    pub fn below(&mut self, parts: &Parts, span: f64) -> Option<&Stride> {
        const REST: u32 = f64::MANTISSA_DIGITS - 1 - DIGITS;
        if !span.is_normal() || span < 0.0 {
            return None;
        }
        let key = (span.to_bits() >> REST) as usize;
        let reach = (key + 1).max(self.shortest + self.rungs.len()) - key.min(self.shortest);
        if self.rungs.is_empty() || reach > MOST {
            self.rungs.clear();
            self.shortest = key;
        }
        while key < self.shortest {
            self.rungs.push_front(None);
            self.shortest -= 1;
        }
        while key >= self.shortest + self.rungs.len() {
            self.rungs.push_back(None);
        }
        let rung = self.rungs.get_mut(key - self.shortest)?;
        let length = f64::from_bits((key as u64) << REST);
        Some(rung.get_or_insert_with(|| parts.stride(length)))
    }
}

#[cfg(test)]
mod tests {
    use super::super::spectrum::Spectrum;
    use super::*;

    /// Never longer than asked, at most a quarter shorter.
    #[test]
    fn law_strides_are_safe() {
        let parts = Parts::new(Spectrum::default(), &[], Vec::new());
        let mut ladder = Ladder::default();
        for span in [1e-300, 0.1, 0.124999, 1.0, 1.2499, 7.999, 3e7] {
            let found = ladder.below(&parts, span).unwrap().span;
            assert!(found <= span && found > 0.8 * span, "{span} {found}");
        }
        assert!(ladder.below(&parts, 0.0).is_none());
        assert!(ladder.below(&parts, f64::INFINITY).is_none());
    }
}
