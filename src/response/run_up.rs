//! Responses to the orders of a machine over its speed, and critical speeds.

use super::excitation::OrderExcitation;
use super::frf::ResponseSolver;
use super::ports::{Ports, ResponseInput};
use super::strain_energy::StrainEnergy;
use super::system::{OperatingModel, natural_frequencies};
use crate::base::error::Error;
use crate::numeric::{Complex, parallel, statistics};

/// The strain energy at a resonance is so much of what it is alongside.
const MIN_ENERGY_RATIO: f64 = 2.0;

/// Next to: this far off, relative.
const REFERENCE_OFFSET: f64 = 0.1;

/// Critical speed: an order meets a natural frequency and the machine responds.
#[derive(Debug, Clone, Copy)]
pub struct CriticalSpeed {
    /// Speed of the node, rad/s.
    pub speed: f64,
    /// The natural frequency, rad/s.
    pub omega: f64,
    /// Which excitation.
    pub excitation: usize,
    /// The first output there; absent where nothing damps the machine, it is infinite, and where the excitation has no size.
    pub amplitude: Option<f64>,
    /// The element with the largest share of the strain energy, and the share.
    pub highest_strain_energy: Option<(usize, f64)>,
}

/// Amplitudes by output, excitation and speed; nothing of excitations without a size.
pub type AmplitudeMap = Vec<Vec<Option<Vec<f64>>>>;

/// The root of the sum of squares over all excitations of an output at a speed: their phases are not known.
pub fn rss_amplitude(of_output: &[Option<Vec<f64>>], speed: usize) -> f64 {
    let squares = of_output.iter().flatten().map(|a| a[speed].powi(2));
    squares.sum::<f64>().sqrt()
}

/// An order with the inputs it acts through.
struct OrderInput {
    /// Per turn of the reference.
    order: f64,
    /// Inputs with their complex amplitudes.
    inputs: Vec<(usize, Complex)>,
    /// Whether its size is declared, or assumed of all.
    has_size: bool,
}

/// Responses of a machine to its orders.
pub struct OrderResponses<'a> {
    solver: &'a ResponseSolver,
    ports: &'a Ports,
    orders: Vec<OrderInput>,
}

impl<'a> OrderResponses<'a> {
    /// Responses to `excitations`, all or only the declared of which have a size.
    pub fn new(
        solver: &'a ResponseSolver,
        ports: &'a Ports,
        excitations: &[OrderExcitation],
        all_have_size: bool,
    ) -> OrderResponses<'a> {
        let order = |e: &OrderExcitation| OrderInput {
            order: e.order,
            inputs: input_amplitudes(e, ports),
            has_size: all_have_size || e.declared,
        };
        OrderResponses {
            solver,
            ports,
            orders: excitations.iter().map(order).collect(),
        }
    }

    /// Amplitude of every output to one order at a speed, rad/s.
    fn amplitudes_at(&self, order: &OrderInput, speed: f64) -> Result<Vec<f64>, Error> {
        let h = self.solver.response_at((order.order * speed).abs())?;
        let of = |output: usize| {
            let each = order.inputs.iter().map(|&(i, a)| h[(output, i)] * a);
            each.sum::<Complex>().norm()
        };
        Ok((0..self.ports.outputs.len()).map(of).collect())
    }

    /// Amplitudes over speeds, rad/s.
    ///
    /// # Errors
    /// Those of the responses.
    pub fn amplitudes(&self, speeds: &[f64]) -> Result<AmplitudeMap, Error> {
        let column = |o: &OrderInput| o.has_size.then(|| vec![0.0; speeds.len()]);
        let empty: Vec<_> = self.orders.iter().map(column).collect();
        let mut map = vec![empty; self.ports.outputs.len()];
        let at_speed = |&speed: &f64| {
            let sized = self.orders.iter().filter(|o| o.has_size);
            let each = sized.map(|order| self.amplitudes_at(order, speed));
            each.collect::<Result<Vec<_>, Error>>()
        };
        let found = parallel::try_map(speeds, at_speed)?;
        for (at, found) in found.iter().enumerate() {
            for (output, table) in map.iter_mut().enumerate() {
                for (column, own) in table.iter_mut().flatten().zip(found) {
                    column[at] = own[output];
                }
            }
        }
        Ok(map)
    }

    /// Speed of the largest total of every output, rad/s, and that total: of the speeds of a map, and of `critical` ones where
    /// the machine is damped.
    ///
    /// # Errors
    /// Those of the responses.
    pub fn largest_totals(
        &self,
        speeds: &[f64],
        map: &AmplitudeMap,
        critical: &[CriticalSpeed],
    ) -> Result<Vec<(f64, f64)>, Error> {
        let largest = |table: &Vec<Option<Vec<f64>>>| {
            let all = speeds.iter().enumerate();
            all.map(|(at, &speed)| (speed, rss_amplitude(table, at)))
                .max_by(|a, b| a.1.total_cmp(&b.1))
                .unwrap_or_default()
        };
        let mut largest: Vec<(f64, f64)> = map.iter().map(largest).collect();
        for c in critical {
            let mut squares = vec![0.0; largest.len()];
            for order in self.orders.iter().filter(|o| o.has_size) {
                let here = self.amplitudes_at(order, c.speed)?;
                squares.iter_mut().zip(here).for_each(|(s, a)| *s += a * a);
            }
            for (best, square) in largest.iter_mut().zip(squares) {
                if square.sqrt() > best.1 {
                    *best = (c.speed, square.sqrt());
                }
            }
        }
        Ok(largest)
    }

    /// Critical speeds within the range of `speeds`, rad/s, by falling response of the first output.
    ///
    /// # Errors
    /// Those of the responses.
    pub fn critical_speeds(
        &self,
        model: &OperatingModel,
        speeds: &[f64],
        damped: bool,
    ) -> Result<Vec<CriticalSpeed>, Error> {
        let (mut low, high) = statistics::extremes(speeds.iter().map(|s| s.abs()));
        // A range through standstill holds every speed down to zero.
        if let [first, .., last] = speeds
            && *first < 0.0
            && *last > 0.0
        {
            low = 0.0;
        }
        let fastest = self.orders.iter().fold(0.0f64, |m, o| m.max(o.order));
        let strain = StrainEnergy::new(model, self.ports)?;
        let mut all = Vec::new();
        for omega in natural_frequencies(model, self.ports, (0.0, fastest * high)) {
            for (excitation, order) in self.orders.iter().enumerate() {
                let speed = omega / order.order;
                if speed < low || speed > high || speed == 0.0 {
                    continue;
                }
                // On the very frequency of an undamped machine there is no answer; next to it the shape is the same.
                let near = if damped { omega } else { omega * (1.0 + 1e-6) };
                let energies = strain.energies(near, &order.inputs)?;
                let beside = [1.0 - REFERENCE_OFFSET, 1.0 + REFERENCE_OFFSET]
                    .map(|share| strain.energies(omega * share, &order.inputs));
                let [below, above] = beside;
                if energies.total() < MIN_ENERGY_RATIO * below?.total().max(above?.total()) {
                    continue;
                }
                let amplitude = match damped && order.has_size {
                    true => self.amplitudes_at(order, speed)?.first().copied(),
                    false => None,
                };
                all.push(CriticalSpeed {
                    speed,
                    omega,
                    excitation,
                    amplitude,
                    highest_strain_energy: energies.largest_share(),
                });
            }
        }
        all.sort_by(|a, b| {
            let [a_size, b_size] = [a, b].map(|c| c.amplitude.unwrap_or(0.0));
            b_size.total_cmp(&a_size).then(a.speed.total_cmp(&b.speed))
        });
        Ok(all)
    }
}

/// Inputs of an excitation, with their complex amplitudes.
fn input_amplitudes(e: &OrderExcitation, ports: &Ports) -> Vec<(usize, Complex)> {
    let input = |(branch, share): &(usize, Complex)| {
        let kind = ResponseInput::Displacement(*branch);
        let number = ports.inputs.iter().position(|p| p.kind == kind)?;
        Some((number, share * e.amplitude))
    };
    e.branches.iter().filter_map(input).collect()
}
