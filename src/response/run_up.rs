//! Order responses of a machine over speed, and critical speeds.

use super::excitation::OrderExcitation;
use super::frf::ResponseSolver;
use super::ports::{Ports, ResponseInput};
use super::strain_energy::StrainEnergy;
use super::system::{OperatingModel, natural_frequencies};
use crate::base::error::Error;
use crate::numeric::{Complex, parallel, statistics};

/// Smallest ratio of the strain energy at a critical speed to that at the reference frequencies.
const MIN_ENERGY_RATIO: f64 = 2.0;

/// Relative offset of the reference frequencies.
const REFERENCE_OFFSET: f64 = 0.1;

/// Critical speed: an excitation order coincides with a natural frequency and excites its mode.
#[derive(Debug, Clone, Copy)]
pub struct CriticalSpeed {
    /// Speed of the reference node, rad/s.
    pub speed: f64,
    /// Natural frequency, rad/s.
    pub omega: f64,
    /// Index of the excitation.
    pub excitation: usize,
    /// Amplitude of the first output; `None` for an undamped machine or an excitation without amplitude.
    pub amplitude: Option<f64>,
    /// Element with the largest share of the strain energy, and that share.
    pub highest_strain_energy: Option<(usize, f64)>,
}

/// Amplitudes by output, excitation and speed; `None` for excitations without amplitude.
pub type AmplitudeMap = Vec<Vec<Option<Vec<f64>>>>;

/// Root sum of squares of the amplitudes of an output over all excitations at a speed; their phases are unknown.
pub fn rss_amplitude(of_output: &[Option<Vec<f64>>], speed: usize) -> f64 {
    let squares = of_output.iter().flatten().map(|a| a[speed].powi(2));
    squares.sum::<f64>().sqrt()
}

/// Excitation order with its inputs.
struct OrderInput {
    /// Order, cycles per revolution of the reference.
    order: f64,
    /// Input numbers with complex amplitudes.
    inputs: Vec<(usize, Complex)>,
    /// Whether the amplitude is declared, or assumed for all excitations.
    has_amplitude: bool,
}

/// Responses of a machine to its excitation orders.
pub struct OrderResponses<'a> {
    solver: &'a ResponseSolver,
    ports: &'a Ports,
    orders: Vec<OrderInput>,
}

impl<'a> OrderResponses<'a> {
    /// Responses to `excitations`; without `all_have_amplitude` only declared excitations have an amplitude.
    pub fn new(
        solver: &'a ResponseSolver,
        ports: &'a Ports,
        excitations: &[OrderExcitation],
        all_have_amplitude: bool,
    ) -> OrderResponses<'a> {
        let order = |e: &OrderExcitation| OrderInput {
            order: e.order,
            inputs: input_amplitudes(e, ports),
            has_amplitude: all_have_amplitude || e.declared,
        };
        OrderResponses {
            solver,
            ports,
            orders: excitations.iter().map(order).collect(),
        }
    }

    /// Amplitude of every output due to one order at a speed, rad/s.
    fn amplitudes_at(&self, order: &OrderInput, speed: f64) -> Result<Vec<f64>, Error> {
        let h = self.solver.response_at((order.order * speed).abs())?;
        let amplitude = |output: usize| {
            let terms = order.inputs.iter().map(|&(i, a)| h[(output, i)] * a);
            terms.sum::<Complex>().norm()
        };
        Ok((0..self.ports.outputs.len()).map(amplitude).collect())
    }

    /// Amplitudes over `speeds`, rad/s.
    ///
    /// # Errors
    /// Errors of the responses.
    pub fn amplitudes(&self, speeds: &[f64]) -> Result<AmplitudeMap, Error> {
        let column = |o: &OrderInput| o.has_amplitude.then(|| vec![0.0; speeds.len()]);
        let empty: Vec<_> = self.orders.iter().map(column).collect();
        let mut map = vec![empty; self.ports.outputs.len()];
        let at_speed = |&speed: &f64| {
            let active = self.orders.iter().filter(|o| o.has_amplitude);
            let columns = active.map(|order| self.amplitudes_at(order, speed));
            columns.collect::<Result<Vec<_>, Error>>()
        };
        let amplitudes = parallel::try_map(speeds, at_speed)?;
        for (k, amplitudes) in amplitudes.iter().enumerate() {
            for (output, table) in map.iter_mut().enumerate() {
                for (column, values) in table.iter_mut().flatten().zip(amplitudes) {
                    column[k] = values[output];
                }
            }
        }
        Ok(map)
    }

    /// Speed, rad/s, and value of the largest root-sum-square amplitude of every output, over the speeds of a map and the `critical` speeds
    /// of a damped machine.
    ///
    /// # Errors
    /// Errors of the responses.
    pub fn largest_rss(
        &self,
        speeds: &[f64],
        map: &AmplitudeMap,
        critical: &[CriticalSpeed],
    ) -> Result<Vec<(f64, f64)>, Error> {
        let largest = |table: &Vec<Option<Vec<f64>>>| {
            let grid = speeds.iter().enumerate();
            grid.map(|(k, &speed)| (speed, rss_amplitude(table, k)))
                .max_by(|a, b| a.1.total_cmp(&b.1))
                .unwrap_or_default()
        };
        let mut largest: Vec<(f64, f64)> = map.iter().map(largest).collect();
        for c in critical {
            let mut squares = vec![0.0; largest.len()];
            for order in self.orders.iter().filter(|o| o.has_amplitude) {
                let terms = self.amplitudes_at(order, c.speed)?;
                squares.iter_mut().zip(terms).for_each(|(s, a)| *s += a * a);
            }
            for (maximum, square) in largest.iter_mut().zip(squares) {
                if square.sqrt() > maximum.1 {
                    *maximum = (c.speed, square.sqrt());
                }
            }
        }
        Ok(largest)
    }

    /// Critical speeds within the range of `speeds`, rad/s, by falling amplitude of the first output.
    ///
    /// # Errors
    /// Errors of the responses.
    pub fn critical_speeds(
        &self,
        model: &OperatingModel,
        speeds: &[f64],
        damped: bool,
    ) -> Result<Vec<CriticalSpeed>, Error> {
        let (mut low, high) = statistics::extremes(speeds.iter().map(|s| s.abs()));
        // A range through standstill includes every speed down to zero.
        if let [first, .., last] = speeds
            && *first < 0.0
            && *last > 0.0
        {
            low = 0.0;
        }
        let fastest = self.orders.iter().fold(0.0f64, |m, o| m.max(o.order));
        let strain = StrainEnergy::new(model, self.ports)?;
        let mut critical = Vec::new();
        for omega in natural_frequencies(model, self.ports, (0.0, fastest * high)) {
            for (excitation, order) in self.orders.iter().enumerate() {
                let speed = omega / order.order;
                if speed < low || speed > high || speed == 0.0 {
                    continue;
                }
                // The undamped response is infinite at resonance; slightly off it the shape is the same.
                let resonance = if damped { omega } else { omega * (1.0 + 1e-6) };
                let energies = strain.energies(resonance, &order.inputs)?;
                let reference = [1.0 - REFERENCE_OFFSET, 1.0 + REFERENCE_OFFSET]
                    .map(|share| strain.energies(omega * share, &order.inputs));
                let [below, above] = reference;
                if energies.total() < MIN_ENERGY_RATIO * below?.total().max(above?.total()) {
                    continue;
                }
                let amplitude = match damped && order.has_amplitude {
                    true => self.amplitudes_at(order, speed)?.first().copied(),
                    false => None,
                };
                critical.push(CriticalSpeed {
                    speed,
                    omega,
                    excitation,
                    amplitude,
                    highest_strain_energy: energies.largest_share(),
                });
            }
        }
        critical.sort_by(|a, b| {
            let [a_size, b_size] = [a, b].map(|c| c.amplitude.unwrap_or(0.0));
            b_size.total_cmp(&a_size).then(a.speed.total_cmp(&b.speed))
        });
        Ok(critical)
    }
}

/// Input numbers of an excitation with complex amplitudes.
fn input_amplitudes(e: &OrderExcitation, ports: &Ports) -> Vec<(usize, Complex)> {
    let input = |(branch, share): &(usize, Complex)| {
        let kind = ResponseInput::Displacement(*branch);
        let number = ports.inputs.iter().position(|p| p.kind == kind)?;
        Some((number, share * e.amplitude))
    };
    e.branches.iter().filter_map(input).collect()
}
