//! Measured lines and what a model says of their orders: which declared error makes each, how large that error is then, and what stays
//! ambiguous.
//!
//! A source alone on its order has the amplitude `a · A/|z|`: a as declared, z what of it arrives at the output at the speed of the
//! record while the input turns evenly, A what would be measured then. The input as it was recorded, θ₁ = Ωt + δ, cuts off whatever
//! drives it: `e = z + (G(ω)/G(0) − 1) r δ`, G from the motion of the input to that of the output, r = G(0) the ratio.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::kinematics::mean_speeds;
use crate::machine::parts::Machine;
use crate::numeric::Complex;
use crate::numeric::fraction::Fraction;
use crate::numeric::statistics::HALF_INTERVAL;
use crate::plan::prepared::Prepared;
use crate::plan::transmission::run::{angle, run};
use crate::scene::model::{Axis, Cause};
use crate::scene::study::TransmissionStudy;
use crate::transmission::chain::{Chain, Ends};
use crate::transmission::dynamic::Passing;
use crate::transmission::lines::{self, Line as Declared, Origin};
use crate::transmission::measured::flank::{Flank, Line};
use crate::transmission::measured::orders::Named;
use crate::transmission::measured::teeth::Teeth;

/// A model and where the encoders sit in it.
pub struct Model {
    /// The machine.
    pub prepared: Prepared,
    /// Node of the input's encoder.
    pub input: String,
    /// Node of the output's encoder.
    pub output: String,
}

/// What makes the measured lines.
#[derive(Debug, Default)]
pub struct Attribution {
    /// Orders with a declared source, ascending.
    pub rows: Vec<Row>,
    /// Declared harmonics that reach the output.
    pub sources: usize,
    /// Orders among them that the record tells apart: so many numbers are known of the sources.
    pub rank: usize,
    /// Sources whose order the record does not hold.
    pub beyond: Vec<String>,
}

/// A measured order and its declared sources.
#[derive(Debug)]
pub struct Row {
    /// Per turn of the output.
    pub order: Fraction,
    /// Measured, rad; with its interval where the order is told from others.
    pub amplitude: f64,
    /// See [`Row::amplitude`].
    pub interval: Option<(f64, f64)>,
    /// What would be measured if the input turned evenly, rad.
    pub even: f64,
    /// What may make it.
    pub sources: Vec<Source>,
}

/// A declared error on one order.
#[derive(Debug)]
pub struct Source {
    /// Element and cause, and the harmonic beyond the first.
    pub name: String,
    /// Of the error as declared, m, of couplings rad.
    pub declared: f64,
    /// It is one of a coupling.
    pub is_angle: bool,
    /// What of it arrives at the output, rad.
    pub arrives: f64,
    /// The error as the record has it, with its interval, where nothing else declared has the order.
    pub found: Option<(f64, (f64, f64))>,
}

impl Source {
    /// The unit a declared error is shown in: of couplings it is an angle.
    pub fn unit(&self) -> &'static str {
        if self.is_angle { "mrad" } else { "µm" }
    }

    /// A size in that unit.
    pub fn shown(&self, size: f64) -> f64 {
        size * if self.is_angle { 1e3 } else { 1e6 }
    }
}

impl Model {
    fn chain(&self) -> Result<Chain, Error> {
        let Prepared {
            machine, operating, ..
        } = &self.prepared;
        let ends = Ends {
            driver: angle(machine, &self.input)?,
            output: angle(machine, &self.output)?,
            against: None,
        };
        Chain::new(machine, operating, ends)
    }

    /// The orders of a model whose ratio between the encoders is that of the teeth.
    ///
    /// # Errors
    /// Nodes that are not there or do not turn together; `RatioMismatch`.
    pub fn named(&self, teeth: &Teeth) -> Result<Named, Error> {
        let Prepared {
            machine, operating, ..
        } = &self.prepared;
        let chain = self.chain()?;
        let between = chain.turns(chain.ends.driver).map(Fraction::abs);
        let stated = &Fraction::one() / &teeth.ratio();
        if between.as_ref() != Some(&stated) {
            let message = format!(
                "in the model {} turns {} times for one turn of {}, and the stated teeth make {stated}",
                self.input,
                between.map_or("0".to_string(), |b| b.to_string()),
                self.output
            );
            return Err(Error::new(Code::RatioMismatch, message)
                .hint("look at --at (input, then output) and at --teeth"));
        }
        let mut named = Named::default();
        for line in lines::lines(machine, operating, &chain) {
            // What lies before the input's encoder does not come between the two.
            if line.kinematic.norm() > 0.0 {
                let name = name(machine, &line);
                named.declared.push((line.order, name));
            }
        }
        for (freedom, part) in machine.freedoms.iter().enumerate() {
            if let (Axis::Theta, Some(turns)) = (part.axis, chain.turns(freedom)) {
                let name = format!("{} turns", machine.nodes[part.node].name);
                named.possible.push((turns.abs(), name));
            }
        }
        for gear in &machine.gears {
            let (Some(teeth), Some(own)) = (gear.teeth, chain.turns(gear.turning)) else {
                continue;
            };
            let carried = match gear.carrier.map(|c| chain.turns(c)) {
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

    /// What makes the lines of a flank, the output turning at `speed`, rad/s, where it is known;
    /// `error` of a line is lost or added by the cells, relative.
    ///
    /// # Errors
    /// Those of the chain at speed.
    pub fn attribute(
        &self,
        flank: &Flank,
        speed: Option<f64>,
        error: f64,
    ) -> Result<Attribution, Error> {
        let machine = &self.prepared.machine;
        if machine.errors.is_empty() {
            return Ok(Attribution::default());
        }
        let output = angle(machine, &self.output)?;
        let reference = |omega: f64| -> Result<f64, Error> {
            let unit = mean_speeds(machine, &self.prepared.kinematics, Some(1.0))?;
            Ok(omega / unit[output].abs())
        };
        let study = TransmissionStudy {
            driver: Some(self.input.clone()),
            output: Some(self.output.clone()),
            speed: speed.map(reference).transpose()?,
            ..TransmissionStudy::default()
        };
        let answer = run(&self.prepared, &study)?;
        let output_speed = speed.unwrap_or(0.0);
        let is_known = speed.is_some() && flank.lines.iter().any(|l| l.input.is_some());
        let passing = is_known
            .then(|| Passing::new(&self.prepared.setting(None), &answer.chain))
            .transpose()?;
        let mut all = Attribution::default();
        for row in &answer.rows {
            let Origin::Declared(number) = row.line.origin else {
                continue;
            };
            let arrives = row.dynamic.unwrap_or(answer.slow(row)).norm();
            if row.line.kinematic.norm() == 0.0 {
                continue;
            }
            all.sources += 1;
            let harmonics = machine.errors[number].shape.harmonics();
            let own = harmonics.iter().find(|h| h.0 == row.line.harmonic);
            let source = Source {
                name: name(machine, &row.line),
                declared: own.map_or(0.0, |h| h.1.abs()),
                is_angle: machine.errors[number].cause == Cause::Misalignment,
                arrives,
                found: None,
            };
            let Some(line) = flank.lines.iter().find(|l| l.order.exact == row.line.order) else {
                all.beyond.push(source.name);
                continue;
            };
            match all.rows.iter_mut().find(|r| r.order == row.line.order) {
                Some(known) => known.sources.push(source),
                None => {
                    let omega = row.line.order.value() * output_speed;
                    let (even, wider) = match &passing {
                        Some(passing) => evenly(passing, omega, line, flank.forward, error)?,
                        None => (line.amplitude, 0.0),
                    };
                    let by = even - line.amplitude;
                    all.rows.push(Row {
                        order: row.line.order.clone(),
                        amplitude: line.amplitude,
                        interval: line
                            .interval
                            .map(|(low, high)| ((low + by - wider).max(0.0), high + by + wider)),
                        even,
                        sources: vec![source],
                    });
                }
            }
        }
        for row in &mut all.rows {
            if let ([source], Some((low, high))) = (&mut row.sources[..], row.interval)
                && source.arrives > 0.0
            {
                let scale = source.declared / source.arrives;
                source.found = Some((scale * row.even, (scale * low, scale * high)));
            }
        }
        all.rank = all.rows.iter().filter(|r| r.interval.is_some()).count();
        Ok(all)
    }
}

/// What a line would be, were the input even, and by how much taking that off widens its interval on either side.
fn evenly(
    passing: &Passing,
    omega: f64,
    line: &Line,
    forward: bool,
    error: f64,
) -> Result<(f64, f64), Error> {
    let Some((ahead, deviation)) = line.input else {
        return Ok((line.amplitude, 0.0));
    };
    let more = passing.beyond(omega)?;
    // Turning back, the angle runs against time.
    let more = if forward { more } else { more.conj() };
    let whole = Complex::from_polar(line.amplitude, line.phase);
    let off = more * ahead;
    let wider = HALF_INTERVAL * more.norm() * deviation + error * off.norm();
    Ok(((whole - off).norm(), wider))
}

fn name(machine: &Machine, line: &Declared) -> String {
    let Some(error) = line.declared(machine) else {
        return String::new();
    };
    let more = match line.harmonic {
        1 => String::new(),
        n => format!(", harmonic {n}"),
    };
    format!("{} {}{more}", error.on, error.cause.name())
}
