//! The branch that most likely made a step fail.

use super::train::{Law, Train};
use crate::base::error::Error;

/// The error, with the branch nearest to a switch named in its hint.
#[must_use]
pub fn beside(mut error: Error, train: &Train, t: f64, y: &[f64]) -> Error {
    if let Some(name) = nearest(train, t, y) {
        let hint = error.hint.unwrap_or_default();
        error.hint = Some(format!(
            "{hint}; at the last sample, t = {t:?} s, branch {name} is nearest to switching"
        ));
    }
    error
}

/// The branch nearest to a switch: a contact by its distance from the edge over its play, a friction pair by its rate over
/// its creep speed.
pub fn nearest<'t>(train: &'t Train, t: f64, y: &[f64]) -> Option<&'t str> {
    let n = train.n();
    let (q, v) = (&y[..n], &y[n..2 * n]);
    let distance = |b: &super::train::Branch| {
        let piece = b.imposed.as_ref().map_or(0, |e| e.piece(t) as u32);
        let (delta, rate) = b.deflection(t, q, v, piece);
        match &b.law {
            Law::Contact(contact) if contact.opens() => {
                Some((delta.abs() - contact.half).abs() / contact.half.max(f64::MIN_POSITIVE))
            }
            Law::Friction(friction) | Law::Clutch { friction, .. } => {
                Some(rate.abs() / friction.creep)
            }
            Law::Pressed(pressed) => Some(rate.abs() / pressed.friction.creep),
            _ => None,
        }
    };
    train
        .branches
        .iter()
        .filter_map(|b| distance(b).map(|d| (d, b.name.as_str())))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}
