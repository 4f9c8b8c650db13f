//! Strides of a machine over round times, made when first wanted and kept: what goes on by one of them takes no exponential.

use super::course::{Parts, Stride};

/// Leading binary digits of a stride after the first: it is at most a quarter shorter than what was asked for.
const DIGITS: u32 = 2;

/// Strides kept at most.
const MOST: usize = 256;

/// The strides of one machine.
#[derive(Debug, Default)]
pub struct Ladder {
    /// By rising time; its leading bits.
    rungs: Vec<(u64, Stride)>,
}

impl Ladder {
    /// The longest round stride that is no longer than `span`, s; nothing where that is no usual number, or where too many are kept.
    pub fn below(&mut self, parts: &Parts, span: f64) -> Option<&Stride> {
        if !span.is_normal() || span < 0.0 {
            return None;
        }
        const REST: u32 = f64::MANTISSA_DIGITS - 1 - DIGITS;
        let key = span.to_bits() >> REST;
        let at = match self.rungs.binary_search_by_key(&key, |rung| rung.0) {
            Ok(at) => at,
            Err(_) if self.rungs.len() >= MOST => return None,
            Err(at) => {
                let stride = parts.stride(f64::from_bits(key << REST));
                self.rungs.insert(at, (key, stride));
                at
            }
        };
        self.rungs.get(at).map(|rung| &rung.1)
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
