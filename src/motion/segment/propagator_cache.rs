//! Cache of propagators over round step sizes; a cached step needs no exponential.

use std::collections::VecDeque;

use super::trajectory::{ForcedParts, Propagator};

/// Leading binary digits of a stride after the first: it is at most a quarter shorter than requested.
const DIGITS: u32 = 2;

/// Strides kept at most, from the shortest to the longest; beyond, the others are made again.
const MAX_PROPAGATORS: usize = 512;

/// The strides of one machine.
#[derive(Debug, Default)]
pub struct PropagatorCache {
    /// Leading bits of the shortest.
    shortest: usize,
    /// By rising time.
    propagators: VecDeque<Option<Propagator>>,
}

impl PropagatorCache {
    /// The longest round stride that is no longer than `span`, s; nothing where that is no usual number.
    pub fn longest_within(&mut self, parts: &ForcedParts, span: f64) -> Option<&Propagator> {
        const REST: u32 = f64::MANTISSA_DIGITS - 1 - DIGITS;
        if !span.is_normal() || span < 0.0 {
            return None;
        }
        let key = (span.to_bits() >> REST) as usize;
        let reach = (key + 1).max(self.shortest + self.propagators.len()) - key.min(self.shortest);
        if self.propagators.is_empty() || reach > MAX_PROPAGATORS {
            self.propagators.clear();
            self.shortest = key;
        }
        while key < self.shortest {
            self.propagators.push_front(None);
            self.shortest -= 1;
        }
        while key >= self.shortest + self.propagators.len() {
            self.propagators.push_back(None);
        }
        let rung = self.propagators.get_mut(key - self.shortest)?;
        let length = f64::from_bits((key as u64) << REST);
        Some(rung.get_or_insert_with(|| parts.propagator(length)))
    }
}

#[cfg(test)]
mod tests {
    use super::super::modal_parts::ModalParts;
    use super::*;

    /// Strides are never longer than requested, at most a quarter shorter.
    #[test]
    fn law_strides_are_safe() {
        let parts = ForcedParts::new(ModalParts::default(), &[], Vec::new());
        let mut cache = PropagatorCache::default();
        for span in [1e-300, 0.1, 0.124999, 1.0, 1.2499, 7.999, 3e7] {
            let found = cache.longest_within(&parts, span).unwrap().span;
            assert!(found <= span && found > 0.8 * span, "{span} {found}");
        }
        assert!(cache.longest_within(&parts, 0.0).is_none());
        assert!(cache.longest_within(&parts, f64::INFINITY).is_none());
    }
}
