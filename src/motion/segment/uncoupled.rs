//! Decomposition of uncoupled modal equations into single modes.

use super::equations::{ModalDamping, ModalEquations};
use super::modal_parts::{ModalParts, NonOscillatoryPart};
use super::modal_transform::{ModalTransform, ModePair};
use crate::numeric::Complex;

/// Roots nearer to each other than this share of ω are taken together.
const NEAR_CRITICAL: f64 = 0.25;

/// The parts; nothing where modes are mixed.
pub fn decompose_uncoupled(equations: &ModalEquations) -> Option<(ModalParts, ModalTransform)> {
    let ModalDamping::Diagonal(damping) = &equations.damping else {
        return None;
    };
    if equations.stiffness.is_some() || !equations.inner.is_empty() {
        return None;
    }
    let under = |w: f64, d: f64| w > 0.0 && (w - 0.5 * d) * (w + 0.5 * d) >= NEAR_CRITICAL * w * w;
    let modes = || equations.omega.iter().zip(damping);
    let oscillations = modes().filter(|&(&w, &d)| under(w, d)).count();
    let mut spectrum = ModalParts::default();
    let mut pairs = Vec::with_capacity(equations.count());
    let mut next = 2 * oscillations;
    for (&w, &d) in modes() {
        if under(w, d) {
            let nu = ((w - 0.5 * d) * (w + 0.5 * d)).sqrt();
            let at = 2 * spectrum.oscillatory.len();
            // ζ = (η̇ + dη/2)/ν + iη
            spectrum.oscillatory.push(Complex::new(-0.5 * d, nu));
            pairs.push(ModePair {
                at,
                out: [0.0, 1.0, nu, -0.5 * d],
                into: [0.5 * d / nu, 1.0 / nu, 1.0, 0.0],
            });
            continue;
        }
        let gap = 0.25 * d * d - w * w;
        let own = ModePair {
            at: next,
            out: [1.0, 0.0, 0.0, 1.0],
            into: [1.0, 0.0, 0.0, 1.0],
        };
        next += 2;
        if w == 0.0 {
            spectrum.others.push(NonOscillatoryPart::RigidMotion(-d));
            pairs.push(own);
        } else if gap < NEAR_CRITICAL * w * w {
            spectrum
                .others
                .push(NonOscillatoryPart::Critical { d, square: w * w });
            pairs.push(own);
        } else {
            // The larger root by a sum, the other from their product.
            let fast = -(0.5 * d + gap.sqrt().copysign(d));
            let slow = w * w / fast;
            let apart = fast - slow;
            spectrum.others.extend([
                NonOscillatoryPart::Decay(fast),
                NonOscillatoryPart::Decay(slow),
            ]);
            pairs.push(ModePair {
                out: [1.0, 1.0, fast, slow],
                into: [-slow / apart, 1.0 / apart, fast / apart, -1.0 / apart],
                ..own
            });
        }
    }
    Some((spectrum, ModalTransform::Pairs(pairs)))
}
