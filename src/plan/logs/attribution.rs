//! Attribution of measured orders to declared errors of a model, with size, interval and ambiguity.
//!
//! A source alone on its order has the amplitude `a · A/|z|`: a as declared, z what of it arrives at the output at the speed of the
//! record while the input turns evenly, A what would be measured then. The input as it was recorded, θ₁ = Ωt + δ, cuts off whatever
//! drives it: `e = z + (G(ω)/G(0) − 1) r δ`, G from the motion of the input to that of the output, r = G(0) the ratio.

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

/// A model and where the encoders sit in it.
pub struct EncoderModel {
    /// The machine.
    pub machine: PreparedMachine,
    /// Node of the input's encoder.
    pub input: String,
    /// Node of the output's encoder.
    pub output: String,
}

/// Attribution of the measured lines to declared sources.
#[derive(Debug, Default)]
pub struct Attribution {
    /// Orders with a declared source, ascending.
    pub rows: Vec<AttributedOrder>,
    /// Declared harmonics that reach the output.
    pub sources: usize,
    /// Orders among them that the record distinguishes: so many numbers are known of the sources.
    pub rank: usize,
    /// Sources whose order the record does not hold.
    pub unresolved: Vec<String>,
}

/// A measured order and its declared sources.
#[derive(Debug)]
pub struct AttributedOrder {
    /// Per turn of the output.
    pub order: Fraction,
    /// Measured amplitude, rad; with its interval where the order is separable from others.
    pub amplitude: f64,
    /// See [`AttributedOrder::amplitude`].
    pub interval: Option<(f64, f64)>,
    /// Amplitude expected at a uniform input speed, rad.
    pub amplitude_uniform_input: f64,
    /// Declared sources of the same order: the candidate causes.
    pub sources: Vec<DeclaredSource>,
}

/// A declared error on one order.
#[derive(Debug)]
pub struct DeclaredSource {
    /// Element and cause, and the harmonic beyond the first.
    pub name: String,
    /// Declared amplitude of the error, m; of couplings rad.
    pub declared: f64,
    /// It is one of a coupling.
    pub is_angle: bool,
    /// Contribution of the source at the output, rad.
    pub output_amplitude: f64,
    /// The error as the record has it, with its interval, where nothing else declared has the order.
    pub identified: Option<(f64, (f64, f64))>,
}

impl DeclaredSource {
    /// The unit a declared error is shown in: of couplings it is an angle.
    pub fn display_unit(&self) -> &'static str {
        if self.is_angle { "mrad" } else { "µm" }
    }

    /// A size in that unit.
    pub fn to_display_unit(&self, size: f64) -> f64 {
        size * if self.is_angle { 1e3 } else { 1e6 }
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

    /// The orders of a model whose ratio between the encoders is that of the teeth.
    ///
    /// # Errors
    /// Nodes that are not there or do not turn together; `RatioMismatch`.
    pub fn source_orders(&self, teeth: &GearTrain) -> Result<KnownOrders, Error> {
        let PreparedMachine {
            machine, operating, ..
        } = &self.machine;
        let chain = self.chain()?;
        let between = chain.ratio(chain.ends.driver).map(Fraction::abs);
        let stated = &Fraction::one() / &teeth.ratio();
        if between.as_ref() != Some(&stated) {
            let message = format!(
                "in the model {} turns {} times for one turn of {}, and the stated teeth make {stated}",
                self.input,
                between.map_or("0".to_string(), |b| b.to_string()),
                self.output
            );
            return Err(Error::new(Code::RatioMismatch, message)
                .with_hint("check --at (input, then output) and --teeth"));
        }
        let mut named = KnownOrders::default();
        for line in order_lines::order_lines(machine, operating, &chain) {
            // What lies before the input's encoder does not come between the two.
            if line.quasi_static.norm() > 0.0 {
                let name = source_name(machine, &line);
                named.declared.push((line.order, name));
            }
        }
        for (dof, part) in machine.dofs.iter().enumerate() {
            if let (Axis::Theta, Some(turns)) = (part.axis, chain.ratio(dof)) {
                let name = format!("{} turns", machine.nodes[part.node].name);
                named.possible.push((turns.abs(), name));
            }
        }
        for gear in &machine.gears {
            let (Some(teeth), Some(own)) = (gear.teeth, chain.ratio(gear.rotation_dof)) else {
                continue;
            };
            let carried = match gear.carrier.map(|c| chain.ratio(c)) {
                None => Fraction::zero(),
                Some(Some(carried)) => carried.clone(),
                Some(None) => continue,
            };
            let order = (own - &carried).abs().times(teeth);
            let name = format!("{} meshes", machine.elements[gear.element].name);
            named.possible.push((order, name));
        }
        Ok(named)
    }

    /// Attributes the lines of a flank to declared sources, at output `speed`, rad/s, where known; `error` is the relative gain or loss of
    /// a line by the cells.
    ///
    /// # Errors
    /// Those of the chain at speed.
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
        let answer = run(&self.machine, &study)?;
        let output_speed = speed.unwrap_or(0.0);
        let is_known = speed.is_some() && flank.lines.iter().any(|l| l.input.is_some());
        let passing = is_known
            .then(|| DriverTransfer::new(&self.machine.frequency_setting(None), &answer.chain))
            .transpose()?;
        let mut all = Attribution::default();
        for row in &answer.lines {
            let LineOrigin::Declared(number) = row.line.origin else {
                continue;
            };
            let arrives = row.dynamic.unwrap_or(answer.quasi_static(row)).norm();
            if row.line.quasi_static.norm() == 0.0 {
                continue;
            }
            all.sources += 1;
            let harmonics = machine.errors[number].waveform.harmonics();
            let own = harmonics.iter().find(|h| h.0 == row.line.harmonic);
            let source = DeclaredSource {
                name: source_name(machine, &row.line),
                declared: own.map_or(0.0, |h| h.1.abs()),
                is_angle: machine.errors[number].cause == ErrorCause::Misalignment,
                output_amplitude: arrives,
                identified: None,
            };
            let Some(line) = flank
                .lines
                .iter()
                .find(|l| l.order.fraction == row.line.order)
            else {
                all.unresolved.push(source.name);
                continue;
            };
            match all.rows.iter_mut().find(|r| r.order == row.line.order) {
                Some(known) => known.sources.push(source),
                None => {
                    let omega = row.line.order.to_f64() * output_speed;
                    let (even, wider) = match &passing {
                        Some(passing) => {
                            uniform_input_amplitude(passing, omega, line, flank.forward, error)?
                        }
                        None => (line.amplitude, 0.0),
                    };
                    let by = even - line.amplitude;
                    all.rows.push(AttributedOrder {
                        order: row.line.order.clone(),
                        amplitude: line.amplitude,
                        interval: line
                            .interval
                            .map(|(low, high)| ((low + by - wider).max(0.0), high + by + wider)),
                        amplitude_uniform_input: even,
                        sources: vec![source],
                    });
                }
            }
        }
        for row in &mut all.rows {
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
        all.rank = all.rows.iter().filter(|r| r.interval.is_some()).count();
        Ok(all)
    }
}

/// Amplitude of a line at a uniform input speed, and the widening of its interval on either side by that correction.
fn uniform_input_amplitude(
    passing: &DriverTransfer,
    omega: f64,
    line: &OrderEstimate,
    forward: bool,
    error: f64,
) -> Result<(f64, f64), Error> {
    let Some((ahead, deviation)) = line.input else {
        return Ok((line.amplitude, 0.0));
    };
    let more = passing.dynamic_deviation(omega)?;
    // Turning back, the angle runs against time.
    let more = if forward { more } else { more.conj() };
    let whole = Complex::from_polar(line.amplitude, line.phase);
    let off = more * ahead;
    let wider = Z_95 * more.norm() * deviation + error * off.norm();
    Ok(((whole - off).norm(), wider))
}

fn source_name(machine: &Machine, line: &Declared) -> String {
    let Some(error) = line.declared(machine) else {
        return String::new();
    };
    let more = match line.harmonic {
        1 => String::new(),
        n => format!(", harmonic {n}"),
    };
    format!("{} {}{more}", error.location, error.cause.name())
}
