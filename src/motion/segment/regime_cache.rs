//! Cache of regime systems, keyed by the states of the switching elements.

use std::rc::Rc;

use super::linear_law::{LinearLaw, linear_law};
use super::linear_system::LinearSystem;
use super::propagator_cache::PropagatorCache;
use super::regime_system::RegimeSystem;
use super::run_context::RunContext;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_time;
use crate::motion::dynamic_model::{DynamicModel, ElementState, ForceLaw};

/// Bytes of a regime system by the square of its coordinates, measured at thirty.
const BYTES_PER_ENTRY: usize = 500;

/// Bytes that all regime systems of a run may take together: a train of thirty coordinates keeps three hundred.
pub const MAX_BYTES: usize = 1 << 27;

/// Regime systems built so far, keyed by the states of contacts and friction.
pub struct RegimeCache {
    /// Branches with more than one state.
    switching: Vec<usize>,
    /// States of these branches, of every system.
    contact_states: Vec<Vec<ElementState>>,
    systems: Vec<RegimeSystem>,
    /// Index of the linear system of each.
    linear_index: Vec<usize>,
    linears: Vec<Rc<LinearSystem>>,
    /// Propagator cache of every linear system.
    caches: Vec<PropagatorCache>,
    /// Systems built, those that were dropped among them.
    built: u64,
    capacity: usize,
}

impl RegimeCache {
    /// None yet; together they may take so many bytes, but one is always kept.
    pub fn new(model: &DynamicModel, room: usize) -> RegimeCache {
        let switches = |law: &ForceLaw| matches!(law, ForceLaw::Contact(_) | ForceLaw::Friction(_));
        let branches = 0..model.elements.len();
        RegimeCache {
            switching: branches
                .filter(|&b| switches(&model.elements[b].law))
                .collect(),
            contact_states: Vec::new(),
            systems: Vec::new(),
            linear_index: Vec::new(),
            linears: Vec::new(),
            caches: Vec::new(),
            built: 0,
            capacity: (room
                / (BYTES_PER_ENTRY * model.coordinate_count() * model.coordinate_count()).max(1))
            .max(1),
        }
    }

    /// Systems built so far.
    pub fn built_count(&self) -> u64 {
        self.built
    }

    /// A system.
    pub fn system(&self, place: usize) -> &RegimeSystem {
        &self.systems[place]
    }

    /// The same, mutable.
    pub fn system_mut(&mut self, place: usize) -> &mut RegimeSystem {
        &mut self.systems[place]
    }

    /// A system and the propagators kept of its linear part.
    pub fn with_propagators(&mut self, place: usize) -> (&RegimeSystem, &mut PropagatorCache) {
        (
            &self.systems[place],
            &mut self.caches[self.linear_index[place]],
        )
    }

    /// Drops all systems where they fill their room, but that whose switching surface was just crossed; returns its new index.
    pub fn evict(&mut self, crossed: Option<(usize, usize)>) -> Option<(usize, usize)> {
        if self.systems.len() < self.capacity {
            return crossed;
        }
        let old = std::mem::take(&mut self.systems);
        let (states, kinds) = (
            std::mem::take(&mut self.contact_states),
            std::mem::take(&mut self.linear_index),
        );
        let linears = std::mem::take(&mut self.linears);
        self.caches.clear();
        let (at, event) = crossed?;
        let machines = old.into_iter().zip(states).zip(kinds);
        let ((system, states), kind) = machines.into_iter().nth(at)?;
        self.systems.push(system);
        self.contact_states.push(states);
        self.linear_index.push(0);
        self.linears.push(Rc::clone(&linears[kind]));
        self.caches.push(PropagatorCache::default());
        Some((0, event))
    }

    /// Index of the system with these states; it is built where there is none.
    ///
    /// # Errors
    /// Numbers out of range; oscillations whose phase is lost.
    pub fn index_of(
        &mut self,
        context: &RunContext,
        states: &[ElementState],
    ) -> Result<usize, Error> {
        let own = || self.switching.iter().map(|&b| &states[b]);
        let is_it = |known: &Vec<ElementState>| own().eq(known);
        if let Some(place) = self.contact_states.iter().position(is_it) {
            return Ok(place);
        }
        let laws = context.model.elements.iter().zip(states);
        let laws: Vec<LinearLaw> = laws
            .map(|(b, s)| linear_law(b, *s))
            .collect::<Result<_, _>>()?;
        let kind = match self.linears.iter().position(|known| known.matches(&laws)) {
            Some(kind) => kind,
            None => {
                let linear_model = LinearSystem::new(context, &laws)?;
                let turned = linear_model.parts.max_phase(context.span);
                check_phase("the fastest oscillation", turned, context.span)?;
                self.linears.push(Rc::new(linear_model));
                self.caches.push(PropagatorCache::default());
                self.linears.len() - 1
            }
        };
        let linear_model = Rc::clone(&self.linears[kind]);
        let system = RegimeSystem::new(context, linear_model, &laws, states)?;
        self.contact_states.push(own().copied().collect());
        self.systems.push(system);
        self.linear_index.push(kind);
        self.built += 1;
        Ok(self.systems.len() - 1)
    }
}

/// A phase of so many radians is known to a hundredth at best, and what is made of it to nothing.
const PHASE_LOST: f64 = 1e-2 / f64::EPSILON;

/// Refuses what turns so often over a span, s, that double precision keeps nothing of its phase.
///
/// # Errors
/// `BudgetExceeded`.
pub fn check_phase(what: &str, turned: f64, span: f64) -> Result<(), Error> {
    match turned < PHASE_LOST {
        true => Ok(()),
        false => {
            let message = format!(
                "in {} {what} turns through {turned:.1e} rad, of which double precision keeps no phase",
                format_time(span)
            );
            Err(Error::new(Code::BudgetExceeded, message).with_hint(
                "request a shorter time; make what is so stiff rigid, or give it damping",
            ))
        }
    }
}
