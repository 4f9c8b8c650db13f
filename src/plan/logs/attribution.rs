//! Attribution of measured orders to declared errors of a model, with amplitude, interval and ambiguity.
//!
//! The only source of an order has the identified amplitude `a A/|z|`: a is the declared amplitude, z its response at the output at the
//! speed of the record with uniform input speed, and A the measured amplitude referred to uniform input speed. The recorded input motion
//! θ₁ = Ωt + δ adds a term: `e = z + (G(ω)/G(0) − 1) r δ`, G the transfer function from input to output motion, r = G(0) the ratio.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::encoder::flank::{FlankEvaluation, OrderEstimate};
use crate::encoder::gear_train::GearTrain;
use crate::encoder::orders::KnownOrders;
use crate::machine::components::Machine;
use crate::machine::kinematics::mean_speeds;
use crate::numeric::Complex;
use crate::numeric::fraction::Fraction;
use crate::numeric::statistics::Z_95;
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::transmission::{chain::angle_dof, run::run};
use crate::scene::model::{Axis, ErrorCause};
use crate::scene::study::TransmissionStudy;
use crate::transmission::chain::{ChainEnds, TransmissionChain};
use crate::transmission::dynamic::DriverTransfer;
use crate::transmission::order_lines::{self, LineOrigin, OrderLine as Declared};

/// Model of the machine and the nodes of its encoders.
pub struct EncoderModel {
    /// Prepared machine.
    pub machine: PreparedMachine,
    /// Node of the input encoder.
    pub input: String,
    /// Node of the output encoder.
    pub output: String,
}

/// Attribution of measured orders to declared sources.
#[derive(Debug, Default)]
pub struct Attribution {
    /// Orders with a declared source, ascending.
    pub rows: Vec<AttributedOrder>,
    /// Number of declared harmonics with a response at the output.
    pub sources: usize,
    /// Number of their orders that the record separates: the rank of the identification.
    pub rank: usize,
    /// Sources whose order is not among the measured lines.
    pub unresolved: Vec<String>,
}

/// Measured order and its declared sources.
#[derive(Debug)]
pub struct AttributedOrder {
    /// Order in cycles per revolution of the output.
    pub order: Fraction,
    /// Measured amplitude, rad.
    pub amplitude: f64,
    /// Confidence interval of the amplitude, rad; `None` if the order is not separable from others.
    pub interval: Option<(f64, f64)>,
    /// Amplitude expected at a uniform input speed, rad.
    pub amplitude_uniform_input: f64,
    /// Declared sources of this order, the candidate causes.
    pub sources: Vec<DeclaredSource>,
}

/// Harmonic of a declared error at one order.
#[derive(Debug)]
pub struct DeclaredSource {
    /// Element and cause, with the harmonic if it is not the first.
    pub name: String,
    /// Declared amplitude of the error, m; for couplings rad.
    pub declared: f64,
    /// True if the error is an angle, that of a coupling.
    pub is_angle: bool,
    /// Amplitude of its contribution at the output, rad.
    pub output_amplitude: f64,
    /// Identified amplitude and its interval, if no other declared source has this order; units as `declared`.
    pub identified: Option<(f64, (f64, f64))>,
}

impl DeclaredSource {
    /// Display unit of the error.
    pub fn display_unit(&self) -> &'static str {
        if self.is_angle { "mrad" } else { "µm" }
    }

    /// Converts an amplitude, m or rad, to the display unit.
    pub fn to_display_unit(&self, amplitude: f64) -> f64 {
        amplitude * if self.is_angle { 1e3 } else { 1e6 }
    }
}

impl EncoderModel {
    fn chain(&self) -> Result<TransmissionChain, Error> {
        let PreparedMachine {
            machine, operating, ..
        } = &self.machine;
        let ends = ChainEnds {
            driver: angle_dof(machine, &self.input)?,
            output: angle_dof(machine, &self.output)?,
            relative_to: None,
        };
        TransmissionChain::new(machine, operating, ends)
    }

    /// Orders of the model; its ratio between the encoders must agree with the stated teeth.
    ///
    /// # Errors
    /// Unknown nodes, nodes whose rotations are not coupled; `RatioMismatch`.
    pub fn source_orders(&self, teeth: &GearTrain) -> Result<KnownOrders, Error> {
        let PreparedMachine {
            machine, operating, ..
        } = &self.machine;
        let chain = self.chain()?;
        let model_ratio = chain.ratio(chain.ends.driver).map(Fraction::abs);
        let stated_ratio = &Fraction::one() / &teeth.ratio();
        if model_ratio.as_ref() != Some(&stated_ratio) {
            let message = format!(
                "in the model {} turns {} times per turn of {}, but the stated teeth give {stated_ratio}",
                self.input,
                model_ratio.map_or("0".to_string(), |b| b.to_string()),
                self.output
            );
            return Err(Error::new(Code::RatioMismatch, message)
                .with_hint("check --at (input, then output) and --teeth"));
        }
        let mut orders = KnownOrders::default();
        for line in order_lines::order_lines(machine, operating, &chain) {
            // Errors upstream of the input encoder have no quasi-static effect between the encoders.
            if line.quasi_static.norm() > 0.0 {
                let name = source_name(machine, &line);
                orders.declared.push((line.order, name));
            }
        }
        for (dof, coordinate) in machine.dofs.iter().enumerate() {
            if let (Axis::Theta, Some(turns)) = (coordinate.axis, chain.ratio(dof)) {
                let name = format!("{} turns", machine.nodes[coordinate.node].name);
                orders.possible.push((turns.abs(), name));
            }
        }
        for gear in &machine.gears {
            let (Some(teeth), Some(rotation)) = (gear.teeth, chain.ratio(gear.rotation_dof)) else {
                continue;
            };
            let carrier = match gear.carrier.map(|c| chain.ratio(c)) {
                None => Fraction::zero(),
                Some(Some(carrier)) => carrier.clone(),
                Some(None) => continue,
            };
            let order = (rotation - &carrier).abs().times(teeth);
            let name = format!("{} meshes", machine.elements[gear.element].name);
            orders.possible.push((order, name));
        }
        Ok(orders)
    }

    /// Attributes the lines of a flank to declared sources, at the output `speed`, rad/s, if known; `error` is the relative amplitude error
    /// of a line due to the cells of the averaging.
    ///
    /// # Errors
    /// Those of the transmission study at speed.
    pub fn attribute(
        &self,
        flank: &FlankEvaluation,
        speed: Option<f64>,
        error: f64,
    ) -> Result<Attribution, Error> {
        let machine = &self.machine.machine;
        if machine.errors.is_empty() {
            return Ok(Attribution::default());
        }
        let output = angle_dof(machine, &self.output)?;
        let reference = |omega: f64| -> Result<f64, Error> {
            let unit = mean_speeds(machine, &self.machine.kinematics, Some(1.0))?;
            Ok(omega / unit[output].abs())
        };
        let study = TransmissionStudy {
            driver: Some(self.input.clone()),
            output: Some(self.output.clone()),
            speed: speed.map(reference).transpose()?,
            ..TransmissionStudy::default()
        };
        let te = run(&self.machine, &study)?;
        let output_speed = speed.unwrap_or(0.0);
        let is_known = speed.is_some() && flank.lines.iter().any(|l| l.input.is_some());
        let transfer = is_known
            .then(|| DriverTransfer::new(&self.machine.operating_model(None), &te.chain))
            .transpose()?;
        let mut result = Attribution::default();
        for row in &te.lines {
            let LineOrigin::Declared(number) = row.line.origin else {
                continue;
            };
            let output_amplitude = row.dynamic.unwrap_or(te.quasi_static(row)).norm();
            if row.line.quasi_static.norm() == 0.0 {
                continue;
            }
            result.sources += 1;
            let harmonics = machine.errors[number].waveform.harmonics();
            let harmonic = harmonics.iter().find(|h| h.0 == row.line.harmonic);
            let source = DeclaredSource {
                name: source_name(machine, &row.line),
                declared: harmonic.map_or(0.0, |h| h.1.abs()),
                is_angle: machine.errors[number].cause == ErrorCause::Misalignment,
                output_amplitude,
                identified: None,
            };
            let Some(line) = flank
                .lines
                .iter()
                .find(|l| l.order.fraction == row.line.order)
            else {
                result.unresolved.push(source.name);
                continue;
            };
            match result.rows.iter_mut().find(|r| r.order == row.line.order) {
                Some(attributed) => attributed.sources.push(source),
                None => {
                    let omega = row.line.order.to_f64() * output_speed;
                    let (uniform, widening) = match &transfer {
                        Some(transfer) => {
                            uniform_input_amplitude(transfer, omega, line, flank.forward, error)?
                        }
                        None => (line.amplitude, 0.0),
                    };
                    let shift = uniform - line.amplitude;
                    result.rows.push(AttributedOrder {
                        order: row.line.order.clone(),
                        amplitude: line.amplitude,
                        interval: line.interval.map(|(low, high)| {
                            ((low + shift - widening).max(0.0), high + shift + widening)
                        }),
                        amplitude_uniform_input: uniform,
                        sources: vec![source],
                    });
                }
            }
        }
        for row in &mut result.rows {
            if let ([source], Some((low, high))) = (&mut row.sources[..], row.interval)
                && source.output_amplitude > 0.0
            {
                let scale = source.declared / source.output_amplitude;
                source.identified = Some((
                    scale * row.amplitude_uniform_input,
                    (scale * low, scale * high),
                ));
            }
        }
        result.rank = result.rows.iter().filter(|r| r.interval.is_some()).count();
        Ok(result)
    }
}

/// Amplitude of a line referred to uniform input speed, rad, and the widening of its interval to either side by this correction, rad.
fn uniform_input_amplitude(
    transfer: &DriverTransfer,
    omega: f64,
    line: &OrderEstimate,
    forward: bool,
    error: f64,
) -> Result<(f64, f64), Error> {
    let Some((input_line, deviation)) = line.input else {
        return Ok((line.amplitude, 0.0));
    };
    let factor = transfer.dynamic_deviation(omega)?;
    // In reverse rotation the angle decreases with time.
    let factor = if forward { factor } else { factor.conj() };
    let measured = Complex::from_polar(line.amplitude, line.phase);
    let correction = factor * input_line;
    let widening = Z_95 * factor.norm() * deviation + error * correction.norm();
    Ok(((measured - correction).norm(), widening))
}

fn source_name(machine: &Machine, line: &Declared) -> String {
    let Some(error) = line.declared(machine) else {
        return String::new();
    };
    let suffix = match line.harmonic {
        1 => String::new(),
        n => format!(", harmonic {n}"),
    };
    format!("{} {}{suffix}", error.location, error.cause.name())
}
