//! Modes in words.

use crate::machine::parts::Machine;
use crate::modes::energy::Energies;
use crate::modes::mode::Mode;

/// Where a mode's strain energy sits, or where a root that does not swing loses its energy: `belt (99.9 %)`, two elements
/// where the first does not hold half of it.
pub fn mostly_in(machine: &Machine, mode: &Mode, energies: &Energies) -> String {
    if mode.rigid {
        return "rigid body".to_string();
    }
    // A root that does not swing is where its energy is lost, not where it is stored.
    let lost = energies.dissipated.clone().filter(|_| !mode.oscillates());
    let mut strain = lost.or(energies.strain.clone()).unwrap_or_default();
    strain.sort_by(|a, b| b.1.total_cmp(&a.1));
    let word = |&(e, share): &(usize, f64)| {
        format!("{} ({:.0} %)", machine.elements[e].name, 100.0 * share)
    };
    match strain.as_slice() {
        [] => "–".to_string(),
        [first, second, ..] if first.1 < 0.5 => format!("{}, {}", word(first), word(second)),
        [first, ..] => word(first),
    }
}
