//! Regime cache: regime systems keyed by the states of the switching elements.

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

/// Bytes of a regime system per squared number of coordinates, measured at 30 coordinates.
const BYTES_PER_ENTRY: usize = 500;

/// Default capacity of the cache of a run, bytes: about 300 systems of 30 coordinates.
pub const MAX_BYTES: usize = 1 << 27;

/// Regime systems built so far, keyed by the states of contacts and friction.
pub struct RegimeCache {
    /// Indices of the elements with more than one state.
    switching: Vec<usize>,
    /// States of the switching elements of each system.
    contact_states: Vec<Vec<ElementState>>,
    systems: Vec<RegimeSystem>,
    /// Index of the linear system of each regime system.
    linear_index: Vec<usize>,
    linears: Vec<Rc<LinearSystem>>,
    /// Propagator cache of each linear system.
    caches: Vec<PropagatorCache>,
    /// Number of systems built, evicted ones included.
    built: u64,
    capacity: usize,
}

impl RegimeCache {
    /// Empty cache with a capacity of `max_bytes`; it holds at least one system.
    pub fn new(model: &DynamicModel, max_bytes: usize) -> RegimeCache {
        let switches = |law: &ForceLaw| matches!(law, ForceLaw::Contact(_) | ForceLaw::Friction(_));
        let elements = 0..model.elements.len();
        RegimeCache {
            switching: elements
                .filter(|&b| switches(&model.elements[b].law))
                .collect(),
            contact_states: Vec::new(),
            systems: Vec::new(),
            linear_index: Vec::new(),
            linears: Vec::new(),
            caches: Vec::new(),
            built: 0,
            capacity: (max_bytes
                / (BYTES_PER_ENTRY * model.coordinate_count() * model.coordinate_count()).max(1))
            .max(1),
        }
    }

    /// Number of systems built so far, evicted ones included.
    pub fn built_count(&self) -> u64 {
        self.built
    }

    /// Regime system by index.
    pub fn system(&self, index: usize) -> &RegimeSystem {
        &self.systems[index]
    }

    /// Mutable regime system by index.
    pub fn system_mut(&mut self, index: usize) -> &mut RegimeSystem {
        &mut self.systems[index]
    }

    /// Regime system with the propagator cache of its linear system.
    pub fn with_propagators(&mut self, index: usize) -> (&RegimeSystem, &mut PropagatorCache) {
        (
            &self.systems[index],
            &mut self.caches[self.linear_index[index]],
        )
    }

    /// Evicts all systems of a full cache except the one whose switching surface was just crossed; returns that surface with the new index.
    pub fn evict(&mut self, crossed: Option<(usize, usize)>) -> Option<(usize, usize)> {
        if self.systems.len() < self.capacity {
            return crossed;
        }
        let systems = std::mem::take(&mut self.systems);
        let (states, linear_index) = (
            std::mem::take(&mut self.contact_states),
            std::mem::take(&mut self.linear_index),
        );
        let linears = std::mem::take(&mut self.linears);
        self.caches.clear();
        let (at, event) = crossed?;
        let entries = systems.into_iter().zip(states).zip(linear_index);
        let ((system, states), linear) = entries.into_iter().nth(at)?;
        self.systems.push(system);
        self.contact_states.push(states);
        self.linear_index.push(0);
        self.linears.push(Rc::clone(&linears[linear]));
        self.caches.push(PropagatorCache::default());
        Some((0, event))
    }

    /// Index of the system with these states of the elements; a missing system is built.
    ///
    /// # Errors
    /// Those of the linear system; `BudgetExceeded` for oscillations whose phase is lost.
    pub fn index_of(
        &mut self,
        context: &RunContext,
        states: &[ElementState],
    ) -> Result<usize, Error> {
        let key = || self.switching.iter().map(|&b| &states[b]);
        let matches = |known: &Vec<ElementState>| key().eq(known);
        if let Some(index) = self.contact_states.iter().position(matches) {
            return Ok(index);
        }
        let laws = context.model.elements.iter().zip(states);
        let laws: Vec<LinearLaw> = laws
            .map(|(b, s)| linear_law(b, *s))
            .collect::<Result<_, _>>()?;
        let linear = match self.linears.iter().position(|known| known.matches(&laws)) {
            Some(linear) => linear,
            None => {
                let linear_model = LinearSystem::new(context, &laws)?;
                let phase = linear_model.parts.max_phase(context.span);
                check_phase("the fastest oscillation", phase, context.span)?;
                self.linears.push(Rc::new(linear_model));
                self.caches.push(PropagatorCache::default());
                self.linears.len() - 1
            }
        };
        let linear_model = Rc::clone(&self.linears[linear]);
        let system = RegimeSystem::new(context, linear_model, &laws, states)?;
        self.contact_states.push(key().copied().collect());
        self.systems.push(system);
        self.linear_index.push(linear);
        self.built += 1;
        Ok(self.systems.len() - 1)
    }
}

/// Phase, rad, above which rounding exceeds 0.01 rad.
const PHASE_LOST: f64 = 1e-2 / f64::EPSILON;

/// Checks that double precision resolves the phase, rad, that an oscillation accumulates over a span, s.
///
/// # Errors
/// `BudgetExceeded` for a phase above 0.01/ε.
pub fn check_phase(what: &str, phase: f64, span: f64) -> Result<(), Error> {
    match phase < PHASE_LOST {
        true => Ok(()),
        false => {
            let message = format!(
                "in {} {what} turns through {phase:.1e} rad, whose phase is lost in double precision",
                format_time(span)
            );
            Err(Error::new(Code::BudgetExceeded, message).with_hint(
                "request a shorter time; make the stiffest element rigid, or give it damping",
            ))
        }
    }
}
