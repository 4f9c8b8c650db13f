//! Where the angles of a record begin: at the marks of index pulses, where there are any.

use std::f64::consts::TAU;

use super::flank::Flank;
use super::index::Index;
use super::survey::Run;
use super::teeth::Teeth;

/// Where angles begin.
pub struct Marks {
    /// Of the output, turns as the ratio makes them of the input's readings; 0 without an index.
    pub zero: f64,
    has_output: bool,
    /// Of the input, turns of the output from there.
    pub input: Option<f64>,
}

impl Marks {
    /// The output's mark in the direction with more turns.
    pub fn of(index: &[Option<Index>; 2], runs: &[Run], ratio: f64) -> Marks {
        let reach = |forward: bool| -> f64 {
            let of_way = runs.iter().filter(|run| run.forward == forward);
            of_way.map(Run::reach).sum()
        };
        let forward = reach(true) >= reach(false);
        let output = index[1].as_ref();
        let zero = output.and_then(|o| o.of_output(ratio, forward));
        Marks {
            zero: zero.unwrap_or(0.0),
            has_output: zero.is_some(),
            input: (index[0].as_ref()).map(|i| i.at * ratio - zero.unwrap_or(0.0)),
        }
    }

    /// Phases over the angle from the mark of the shaft that an order repeats with.
    pub fn refer(&self, flank: &mut Flank, teeth: &Teeth) {
        let ratio = teeth.ratio();
        for line in &mut flank.lines {
            let order = &line.order.exact;
            let with_input = self.input.filter(|_| (order * &ratio).is_whole());
            line.marked = match with_input {
                _ if self.has_output && order.is_whole() => Some((line.phase, "output")),
                Some(at) => Some((line.phase + order.value() * at * TAU, "input")),
                None => None,
            };
        }
    }
}
