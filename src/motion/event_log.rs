//! Events of a motion by kind: contact lost or made, friction that sticks, slips or reverses.

use std::cell::RefCell;
use std::rc::Rc;

use super::contact::ContactState;
use super::dynamic_model::DynamicModel;
use super::friction::FrictionState;
use super::problem::{DenseOutput, Observer};
use super::regime::ElementState;

/// Most events kept of each kind. Beyond them every second one goes.
pub const MAX_EVENTS: usize = 2000;

/// Kind of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventKind {
    /// A contact ceases to carry a force.
    ContactLoss,
    /// A contact begins to carry a force.
    Impact,
    /// A friction pair stops sliding.
    Stick,
    /// A friction pair that stuck slides.
    Slip,
    /// A friction pair slides the other way.
    SlipReversal,
}

impl EventKind {
    /// All kinds, in their order.
    const ALL: [EventKind; 5] = [
        EventKind::ContactLoss,
        EventKind::Impact,
        EventKind::Stick,
        EventKind::Slip,
        EventKind::SlipReversal,
    ];

    /// Name of the kind.
    pub fn name(self) -> &'static str {
        match self {
            EventKind::ContactLoss => "contact loss",
            EventKind::Impact => "impact",
            EventKind::Stick => "stick",
            EventKind::Slip => "slip",
            EventKind::SlipReversal => "slip reversal",
        }
    }

    /// Kind of the change from one state of an element to another; a change within a closed contact has none.
    fn of(before: ElementState, after: ElementState) -> Option<EventKind> {
        let carries =
            |s: ContactState| matches!(s, ContactState::Closed(_) | ContactState::DamperLimited(_));
        match (before, after) {
            (ElementState::Contact(a, _), ElementState::Contact(b, _)) => {
                match (carries(a), carries(b)) {
                    (true, false) => Some(EventKind::ContactLoss),
                    (false, true) => Some(EventKind::Impact),
                    _ => None,
                }
            }
            (ElementState::Friction(a), ElementState::Friction(b)) if a != b => {
                Some(match (a, b) {
                    (_, FrictionState::Stick) => EventKind::Stick,
                    (FrictionState::Stick, _) => EventKind::Slip,
                    _ => EventKind::SlipReversal,
                })
            }
            _ => None,
        }
    }
}

/// Events of one kind.
#[derive(Debug, Clone, PartialEq)]
pub struct EventRecord {
    /// Kind.
    pub kind: EventKind,
    /// Number of events.
    pub count: u64,
    /// One of so many events is kept.
    pub stride: u64,
    /// Instants, s, and the elements of the model, by number, that switched.
    pub events: Vec<(f64, usize)>,
}

impl EventRecord {
    fn new(kind: EventKind) -> EventRecord {
        EventRecord {
            kind,
            count: 0,
            stride: 1,
            events: Vec::new(),
        }
    }

    fn push(&mut self, t: f64, element: usize) {
        if self.count.is_multiple_of(self.stride) {
            if self.events.len() == MAX_EVENTS {
                self.stride *= 2;
                self.events = self.events.iter().copied().step_by(2).collect();
            }
            self.events.push((t, element));
        }
        self.count += 1;
    }
}

/// Record of the events of a run, from the regimes of its intervals.
#[derive(Debug)]
pub struct EventLog {
    states: Vec<ElementState>,
    /// By kind.
    records: [EventRecord; EventKind::ALL.len()],
}

impl EventLog {
    /// A log that observes a run of a method that locates events.
    pub fn observe(model: &DynamicModel, observer: &mut Observer) -> Rc<RefCell<EventLog>> {
        let log = Rc::new(RefCell::new(EventLog {
            states: Vec::new(),
            records: EventKind::ALL.map(EventRecord::new),
        }));
        if model.has_events() {
            let shared = Rc::clone(&log);
            observer.add(move |interval: DenseOutput| {
                shared.borrow_mut().record(&interval);
                0
            });
        }
        log
    }

    /// Compares the regime of an interval with that of the one before.
    fn record(&mut self, interval: &DenseOutput) {
        let Some(regime) = interval.regime else {
            return;
        };
        for (element, (before, after)) in self.states.iter().zip(&regime.states).enumerate() {
            let Some(kind) = EventKind::of(*before, *after) else {
                continue;
            };
            self.records[kind as usize].push(interval.from, element);
        }
        self.states.clone_from(&regime.states);
    }

    /// The records of the kinds that occurred.
    pub fn records(&self) -> Vec<EventRecord> {
        let occurred = self.records.iter().filter(|r| r.count > 0);
        occurred.cloned().collect()
    }
}
