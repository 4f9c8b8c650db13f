//! The regimes met so far, each with its machine.

use std::rc::Rc;

use super::ladder::Ladder;
use super::law::{Held, held};
use super::linear::Linear;
use super::machine::Machine;
use super::shared::Shared;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::units::seconds;
use crate::motion::train::{BranchStand, Law, Train};

/// Bytes of a machine by the square of its coordinates, measured at thirty.
const BYTES: usize = 500;

/// Bytes that all machines of a run may take together: a train of thirty coordinates keeps two thousand.
pub const ROOM: usize = 1 << 30;

/// The machines met so far, by how what can switch stood.
pub struct Met {
    /// Branches that can stand in more than one way.
    switching: Vec<usize>,
    /// How these stand, of every machine.
    stands: Vec<Vec<BranchStand>>,
    machines: Vec<Machine>,
    /// Which linear machine each of these is.
    kinds: Vec<usize>,
    linears: Vec<Rc<Linear>>,
    /// Of every linear machine.
    ladders: Vec<Ladder>,
    /// Machines made, those that were dropped among them.
    made: u64,
    most: usize,
}

impl Met {
    /// None yet; together they may take so many bytes, but one is always kept.
    pub fn new(train: &Train, room: usize) -> Met {
        let switches = |law: &Law| matches!(law, Law::Contact(_) | Law::Friction(_));
        let branches = 0..train.branches.len();
        Met {
            switching: branches
                .filter(|&b| switches(&train.branches[b].law))
                .collect(),
            stands: Vec::new(),
            machines: Vec::new(),
            kinds: Vec::new(),
            linears: Vec::new(),
            ladders: Vec::new(),
            made: 0,
            most: (room / (BYTES * train.n() * train.n()).max(1)).max(1),
        }
    }

    /// Machines made so far.
    pub fn made(&self) -> u64 {
        self.made
    }

    /// A machine.
    pub fn machine(&self, place: usize) -> &Machine {
        &self.machines[place]
    }

    /// The same, to be changed.
    pub fn machine_mut(&mut self, place: usize) -> &mut Machine {
        &mut self.machines[place]
    }

    /// A machine and the strides kept of its linear part.
    pub fn with_ladder(&mut self, place: usize) -> (&Machine, &mut Ladder) {
        (&self.machines[place], &mut self.ladders[self.kinds[place]])
    }

    /// Drops all machines where they fill their room, but that whose border was just crossed, and says where it is now.
    pub fn make_room(&mut self, crossed: Option<(usize, usize)>) -> Option<(usize, usize)> {
        if self.machines.len() < self.most {
            return crossed;
        }
        let old = std::mem::take(&mut self.machines);
        let (stands, kinds) = (
            std::mem::take(&mut self.stands),
            std::mem::take(&mut self.kinds),
        );
        let linears = std::mem::take(&mut self.linears);
        self.ladders.clear();
        let (at, border) = crossed?;
        let machines = old.into_iter().zip(stands).zip(kinds);
        let ((machine, stands), kind) = machines.into_iter().nth(at)?;
        self.machines.push(machine);
        self.stands.push(stands);
        self.kinds.push(0);
        self.linears.push(Rc::clone(&linears[kind]));
        self.ladders.push(Ladder::default());
        Some((0, border))
    }

    /// Where the machine of these stands is; it is made where there is none.
    ///
    /// # Errors
    /// Numbers out of range; swings whose phase is lost.
    pub fn place(&mut self, shared: &Shared, stands: &[BranchStand]) -> Result<usize, Error> {
        let own = || self.switching.iter().map(|&b| &stands[b]);
        let is_it = |known: &Vec<BranchStand>| own().eq(known);
        if let Some(place) = self.stands.iter().position(is_it) {
            return Ok(place);
        }
        let laws = shared.train.branches.iter().zip(stands);
        let laws: Vec<Held> = laws.map(|(b, s)| held(b, *s)).collect::<Result<_, _>>()?;
        let kind = match self.linears.iter().position(|known| known.is_of(&laws)) {
            Some(kind) => kind,
            None => {
                let linear = Linear::new(shared, &laws)?;
                let turned = linear.parts.turned(shared.span);
                has_a_phase("the fastest swing", turned, shared.span)?;
                self.linears.push(Rc::new(linear));
                self.ladders.push(Ladder::default());
                self.linears.len() - 1
            }
        };
        let linear = Rc::clone(&self.linears[kind]);
        let machine = Machine::new(shared, linear, &laws, stands)?;
        self.stands.push(own().copied().collect());
        self.machines.push(machine);
        self.kinds.push(kind);
        self.made += 1;
        Ok(self.machines.len() - 1)
    }
}

/// A phase of so many radians is known to a hundredth at best, and what is made of it to nothing.
const PHASE_LOST: f64 = 1e-2 / f64::EPSILON;

/// Refuses what turns so often over a span, s, that double precision keeps nothing of its phase.
///
/// # Errors
/// `Hopeless`.
pub fn has_a_phase(what: &str, turned: f64, span: f64) -> Result<(), Error> {
    match turned < PHASE_LOST {
        true => Ok(()),
        false => {
            let message = format!(
                "in {} {what} turns through {turned:.1e} rad, of which double precision keeps no phase",
                seconds(span)
            );
            Err(Error::new(Code::Hopeless, message)
                .hint("ask for a shorter time; make what is so stiff rigid, or give it damping"))
        }
    }
}
