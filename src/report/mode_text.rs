//! Dominant elements of a mode as text.

use crate::machine::components::Machine;
use crate::modes::energy::EnergyShares;
use crate::modes::mode::Mode;
use crate::numeric::sorting::sort_descending;

/// An element with its share: `belt (71 %)`.
pub fn element_share(machine: &Machine, element: usize, share: f64) -> String {
    let name = &machine.elements[element].name;
    format!("{name} ({:.0} %)", 100.0 * share)
}

/// Elements that dominate a mode's strain energy, or dissipate the energy of a non-oscillatory root: `belt (99.9 %)`, two elements where
/// the first does not hold half of it.
pub fn dominant_elements_text(machine: &Machine, mode: &Mode, energies: &EnergyShares) -> String {
    if mode.rigid {
        return "rigid body".to_string();
    }
    // A root that does not swing is where its energy is lost, not where it is stored.
    let lost = energies
        .dissipated
        .clone()
        .filter(|_| !mode.is_oscillatory());
    let mut strain = lost.or(energies.strain.clone()).unwrap_or_default();
    sort_descending(&mut strain, |a| a.1);
    let word = |&(e, share): &(usize, f64)| element_share(machine, e, share);
    match strain.as_slice() {
        [] => "–".to_string(),
        [first, second, ..] if first.1 < 0.5 => format!("{}, {}", word(first), word(second)),
        [first, ..] => word(first),
    }
}
