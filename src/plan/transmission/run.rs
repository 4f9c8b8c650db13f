//! Runs a chain: its lines with rigid joints, under load and at speed, and the orders that coincide.

use crate::base::code::Code;
use crate::base::error::{Error, Warning};
use crate::base::words::suggestion;
use crate::machine::kinematics::mean_speeds;
use crate::machine::parts::{Law, Machine};
use crate::modes::orders::reference;
use crate::numeric::Complex;
use crate::numeric::fraction::Fraction;
use crate::plan::prepared::Prepared;
use crate::plan::response::run::natural;
use crate::plan::stages::Verdict;
use crate::plan::transmission::recorded::{self, Recorded};
use crate::response::frequency::Way;
use crate::scene::study::{IndexStudy, TransmissionStudy};
use crate::transmission::budget::{self, Budget};
use crate::transmission::chain::{Chain, Ends};
use crate::transmission::coincidence::{self, Coincidence};
use crate::transmission::dynamic::Transfer;
use crate::transmission::eccentric_pair;
use crate::transmission::indexing::{self, Mark};
use crate::transmission::lines::{self, Line, Origin};
use crate::transmission::loaded;
use crate::transmission::spread::{self, Term};

/// The transmission error of a chain.
pub struct Answer {
    /// The chain.
    pub chain: Chain,
    /// Every line, by rising order.
    pub rows: Vec<Row>,
    /// Orders that coincide, by numbers of rows.
    pub coincidences: Vec<Coincidence>,
    /// After so many turns of what orders are counted by everything repeats; absent where there is no line.
    pub period: Option<Fraction>,
    /// A rigid loop does not fit the errors, so that only elastic joints have an answer: the branches of the loop.
    pub misfit: Option<Vec<String>>,
    /// Sums and percentiles.
    pub budget: Budget,
    /// Names of the elements of the budget.
    pub elements: Vec<String>,
    /// The same at speed, where one is asked for.
    pub at_speed: Option<Sums>,
    /// Elements that could be left out, and what that takes off the root of the sum of squares and off the worst case.
    pub negligible: (Vec<usize>, f64, f64),
    /// Second order of offsets, which the lines leave out, at the output, rad.
    pub second_order: f64,
    /// What each line does to work that is indexed tooth by tooth.
    pub marks: Option<Vec<Mark>>,
    /// Lines over speed.
    pub map: Option<Map>,
    /// The error over the angle.
    pub record: Option<Recorded>,
    /// By how much the mean loads wind up the chain, rad.
    pub wind_up: f64,
    /// m.
    pub radius: Option<f64>,
    /// Speed of what orders are counted by, for the error at speed, rad/s.
    pub speed: Option<f64>,
    /// Stages with what they do.
    pub plan: Vec<(&'static str, Verdict)>,
    /// Doubts.
    pub warnings: Vec<Warning>,
}

/// Sums at speed.
pub struct Sums {
    /// Sums and percentiles.
    pub budget: Budget,
    /// As [`Answer::negligible`].
    pub negligible: (Vec<usize>, f64, f64),
}

/// Every line over the speed of the machine.
pub struct Map {
    /// Speeds of the first node of `[speed]`, rad/s.
    pub speeds: Vec<f64>,
    /// Of every row A at each speed, rad.
    pub amplitudes: Vec<Vec<f64>>,
    /// Of every row the speed at which it is largest, rad/s, and A there, rad: of these speeds and of those between them at which the
    /// row's order meets a natural frequency.
    pub largest: Vec<(f64, f64)>,
}

/// A line of the table.
pub struct Row {
    /// Its source and order.
    pub line: Line,
    /// A and ψ at the output with rigid joints, slowly, rad; absent where they would lock: a loop does not fit this line alone.
    pub kinematic: Option<Complex>,
    /// The same under load, where joints give way.
    pub loaded: Complex,
    /// The same at speed.
    pub dynamic: Option<Complex>,
    /// Of the sum of squared amplitudes.
    pub share: f64,
}

impl Answer {
    /// A and ψ of a row, slowly: with rigid joints where these have an answer, in loops as the elastic joints share it out.
    pub fn slow(&self, row: &Row) -> Complex {
        match row.line.origin {
            Origin::Declared(_) if self.is_rigid() => row.line.kinematic,
            _ => row.loaded,
        }
    }

    /// A of a row wherever it is largest of what was asked: slowly, at speed, over speeds, rad.
    pub fn most(&self, row: usize) -> f64 {
        let slow = self.slow(&self.rows[row]).norm();
        let at_speed = self.rows[row].dynamic.map_or(0.0, |z| z.norm());
        let over = self.map.as_ref().map_or(0.0, |map| map.largest[row].1);
        slow.max(at_speed).max(over)
    }

    /// Some line is another under load than with rigid joints, beyond what is shown of either.
    pub fn differs_under_load(&self) -> bool {
        /// Half a unit of the fourth digit, and rounding of the largest.
        const SHOWN: (f64, f64) = (5e-4, 1e-9);
        let largest = self.rows.iter().fold(0.0f64, |m, r| m.max(r.loaded.norm()));
        let differs = |row: &Row| {
            let loaded = row.loaded.norm();
            let off = |rigid: Complex| (rigid.norm() - loaded).abs();
            let shown = SHOWN.0 * loaded + SHOWN.1 * largest;
            row.kinematic.is_none_or(|rigid| off(rigid) > shown)
        };
        self.rows.iter().any(differs)
    }

    /// Rigid joints have an answer for every single error: no loop shares it out.
    pub fn is_rigid(&self) -> bool {
        self.chain.conditions.is_empty()
    }
}

/// The chain from the driver to the output that a study names.
fn chain_of(prepared: &Prepared, study: &TransmissionStudy) -> Result<Chain, Error> {
    let Prepared {
        machine, operating, ..
    } = prepared;
    let Some(output) = &study.output else {
        return Err(Error::new(
            Code::Usage,
            "nothing says at which node the error is wanted",
        )
        .hint("add --output NODE, or `output` to the study"));
    };
    let ends = Ends {
        driver: match &study.driver {
            Some(name) => angle(machine, name)?,
            None => reference(machine)?,
        },
        output: angle(machine, output)?,
        against: study
            .against
            .as_deref()
            .map(|name| angle(machine, name))
            .transpose()?,
    };
    if machine.errors.is_empty() {
        return Err(
            Error::new(Code::MissingKey, "no element has a declared error").hint(
                "write [[error]] with `on`, `cause` and `amplitude` into the model or the scene",
            ),
        );
    }
    let chain = Chain::new(machine, operating, ends)?;
    let slides = !machine.freedoms[ends.output].axis.turns();
    if let (true, Some(what)) = (
        slides,
        [
            ("a radius", study.radius.is_some()),
            ("indexing", study.index.is_some()),
        ]
        .iter()
        .find_map(|(what, asked)| asked.then_some(what)),
    ) {
        let message = format!("{what} is of an output that turns, and {output} slides");
        return Err(Error::new(Code::Conflict, message)
            .hint("leave it out: the error of a slide is told in µm of its travel"));
    }
    Ok(chain)
}

/// Refuses what [`run`] would refuse before it solves anything.
///
/// # Errors
/// Names that do not exist; no declared error; what does not go with an output that slides.
pub fn refuse(prepared: &Prepared, study: &TransmissionStudy) -> Result<(), Error> {
    chain_of(prepared, study).map(|_| ())
}

/// Runs a study.
///
/// # Errors
/// Names that do not exist; ends that do not turn together; a model without errors; rigid loops that do not fit; those of the
/// equations.
pub fn run(prepared: &Prepared, study: &TransmissionStudy) -> Result<Answer, Error> {
    let Prepared {
        machine,
        kinematics,
        operating,
        ..
    } = prepared;
    let chain = chain_of(prepared, study)?;
    let setting = prepared.setting(None);
    let mut all = lines::lines(machine, operating, &chain);
    let misfit = lines::misfit(machine, &chain, &all);
    if let Some(loop_of) = &misfit
        && loop_of
            .iter()
            .all(|&b| machine.branches[b].law == Law::Rigid)
    {
        return Err(does_not_fit(machine, loop_of));
    }
    all.extend(loaded::lines(&setting, &chain)?);
    all.sort_by(|a, b| a.order.cmp(&b.order));
    let transfer = Transfer::new(&setting, &chain, &all, Way::Direct)?;
    let refs: Vec<&Line> = all.iter().collect();
    let under_load = transfer.at(0.0, &refs)?;
    let output_at = |speed: f64| -> Result<f64, Error> {
        Ok(mean_speeds(machine, kinematics, Some(speed))?[chain.per])
    };
    let speed = study.speed.map(output_at).transpose()?;
    let mut undamped = false;
    let map = match study.speeds {
        None => None,
        Some(range) => {
            let speeds = range.all();
            let mut amplitudes = vec![Vec::with_capacity(speeds.len()); all.len()];
            for &speed in &speeds {
                let values = transfer.at_speed(output_at(speed)?, &all)?;
                let each = amplitudes.iter_mut().zip(values);
                each.for_each(|(row, z)| row.push(z.norm()));
            }
            let mut largest: Vec<(f64, f64)> = (amplitudes.iter())
                .map(|row| {
                    let both = speeds.iter().copied().zip(row.iter().copied());
                    both.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default()
                })
                .collect();
            let unit = output_at(1.0)?.abs();
            let ends = speeds
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |m, &s| {
                    (m.0.min(s), m.1.max(s))
                });
            let fastest = all.iter().fold(0.0f64, |m, line| m.max(line.order.value()));
            let most = fastest * unit * ends.0.abs().max(ends.1.abs());
            for omega in natural(prepared, transfer.ports(), (0.0, most)) {
                // Nothing damps it: there is no answer there, and what is told is of the speeds asked for.
                let Ok(values) = transfer.at(omega, &refs) else {
                    undamped = true;
                    continue;
                };
                for ((line, z), best) in all.iter().zip(values).zip(&mut largest) {
                    let speed = omega / (line.order.value() * unit);
                    let inside = [speed, -speed]
                        .into_iter()
                        .find(|s| (ends.0..=ends.1).contains(s));
                    if let Some(speed) = inside
                        && z.norm() > best.1
                    {
                        *best = (speed, z.norm());
                    }
                }
            }
            Some(Map {
                speeds,
                amplitudes,
                largest,
            })
        }
    };
    let marks = match &study.index {
        None => None,
        Some(index) => {
            let moved = indexed(machine, &chain, index)?;
            Some(indexing::marks(machine, &chain, &all, &moved, index.teeth))
        }
    };
    let at_speed = speed
        .map(|speed| transfer.at_speed(speed, &all))
        .transpose()?;
    let slow: Vec<Complex> = (all.iter().zip(&under_load))
        .map(|(line, &loaded)| match line.origin {
            Origin::Declared(_) if chain.conditions.is_empty() => line.kinematic,
            _ => loaded,
        })
        .collect();
    // Of the largest line: what is common to both ends of a relative error cancels, and rounding is left.
    const COUNTS: f64 = 1e-12;
    let largest = slow.iter().fold(0.0f64, |m, z| m.max(z.norm()));
    let counts: Vec<bool> = slow.iter().map(|z| z.norm() > COUNTS * largest).collect();
    let coincidences = coincidence::coincidences(machine, &chain, &all, &counts);
    let (terms, sources, elements) = of_budget(machine, &all, &slow);
    let window = f64::from(study.window.unwrap_or(1));
    let budget = budget::budget(&terms, &sources, window, POINTS);
    let squares = budget.rss.powi(2);
    let counted = all.iter().zip(&counts).filter(|(_, counts)| **counts);
    let period = Fraction::common_measure(counted.map(|(line, _)| &line.order))
        .map(|measure| &Fraction::one() / &measure);
    let shown = at_speed.as_ref().unwrap_or(&slow);
    let record = match study.record {
        true => Some(recorded::recorded(
            machine,
            &chain,
            &all,
            shown,
            period.as_ref(),
            study,
        )?),
        false => None,
    };
    let sums_at_speed = at_speed.as_ref().map(|values| {
        let (terms, sources, _) = of_budget(machine, &all, values);
        let budget = budget::budget(&terms, &sources, window, POINTS);
        Sums {
            negligible: budget::negligible(&budget.elements, THRESHOLD),
            budget,
        }
    });
    let mut answer = Answer {
        at_speed: sums_at_speed,
        negligible: budget::negligible(&budget.elements, THRESHOLD),
        budget,
        elements,
        second_order: eccentric_pair::second_order(machine, &chain),
        marks,
        map,
        record,
        period,
        misfit: misfit.map(|list| list.iter().map(|&b| machine.branch_name(b)).collect()),
        wind_up: loaded::wind_up(&setting, &chain)?,
        radius: study.radius,
        speed,
        plan: plan(machine, study),
        warnings: prepared.warnings(),
        coincidences,
        rows: (all.into_iter().enumerate())
            .map(|(k, line)| Row {
                kinematic: rigidly(&chain, &line),
                line,
                loaded: under_load[k],
                dynamic: at_speed.as_ref().map(|all| all[k]),
                share: match squares > 0.0 {
                    true => slow[k].norm_sqr() / squares,
                    false => 0.0,
                },
            })
            .collect(),
        chain,
    };
    answer.warnings.extend(doubts(machine, &answer));
    if undamped {
        answer.warnings.push(Warning {
            code: "undamped",
            message: "nothing damps some resonances between the speeds: lines are infinite there, and the largest told are those at the speeds asked for".to_string(),
            hint: Some("give branches a damping_ratio or c".to_string()),
        });
    }
    Ok(answer)
}

/// A line with rigid joints, where these can turn with it; what gives way adds nothing there.
fn rigidly(chain: &Chain, line: &Line) -> Option<Complex> {
    match line.origin {
        Origin::Stiffness(_) => Some(Complex::ZERO),
        Origin::Declared(_) => lines::fits(chain, line).then_some(line.kinematic),
    }
}

/// Lattice points a shift of the budget's percentiles.
const POINTS: usize = 61;

/// Of the root of the sum of squares: so much may be left out.
pub const THRESHOLD: f64 = 0.01;

/// Terms, sources and names of elements: each declared error is a source, errors on one node are one element.
fn of_budget(
    machine: &Machine,
    lines: &[Line],
    values: &[Complex],
) -> (Vec<Term>, Vec<spread::Source>, Vec<String>) {
    let mut sources: Vec<(Origin, spread::Source)> = Vec::new();
    let mut elements: Vec<String> = Vec::new();
    let mut terms = Vec::new();
    for (line, &value) in lines.iter().zip(values) {
        let known = sources.iter().position(|s| s.0 == line.origin);
        let source = known.unwrap_or_else(|| {
            let name = match line.origin {
                Origin::Declared(number) => machine.errors[number].element.clone(),
                Origin::Stiffness(branch) => machine.branch_name(branch),
            };
            let known = elements.iter().position(|e| *e == name);
            let element = known.unwrap_or_else(|| {
                elements.push(name);
                elements.len() - 1
            });
            let source = spread::Source {
                element,
                phase_known: line.phase_known(machine),
                tolerance: line.declared(machine).map_or(0.0, |error| error.tolerance),
                graded: matches!(line.origin, Origin::Declared(_)),
            };
            sources.push((line.origin, source));
            sources.len() - 1
        });
        terms.push(Term {
            source,
            order: line.order.value(),
            harmonic: line.harmonic,
            value,
        });
    }
    let sources = sources.into_iter().map(|s| s.1).collect();
    (terms, sources, elements)
}

/// Of every freedom: it moves on with the work from tooth to tooth.
fn indexed(machine: &Machine, chain: &Chain, index: &IndexStudy) -> Result<Vec<bool>, Error> {
    let named = machine.elements.iter().position(|e| e.name == index.behind);
    let Some(element) = named else {
        let known = machine.elements.iter().map(|e| e.name.as_str());
        let hint = match suggestion(&index.behind, known) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => "name a pair or a shaft of the model".to_string(),
        };
        let message = format!("there is no element `{}`", index.behind);
        return Err(Error::new(Code::UnknownNode, message).hint(hint));
    };
    let side = coincidence::side(machine, element, chain.ends.output);
    if side[chain.ends.driver] {
        let message = format!(
            "`{}` does not lie between the driver and the output",
            index.behind
        );
        return Err(Error::new(Code::Conflict, message)
            .hint("name the element behind which the work is moved on: the differential"));
    }
    Ok(side)
}

/// The angle of a node, the travel of a slide.
///
/// # Errors
/// `UnknownNode`.
pub fn angle(machine: &Machine, name: &str) -> Result<usize, Error> {
    machine.freedom(name).ok_or_else(|| {
        let known = machine.nodes.iter().map(|node| node.name.as_str());
        let hint = match suggestion(name, known) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => "name a node of the model".to_string(),
        };
        Error::new(Code::UnknownNode, format!("there is no node `{name}`")).hint(hint)
    })
}

fn does_not_fit(machine: &Machine, loop_of: &[usize]) -> Error {
    let names: Vec<String> = loop_of
        .iter()
        .map(|&b| format!("`{}`", machine.branch_name(b)))
        .collect();
    let message = format!(
        "the errors of {} do not fit: these rigid joints close a loop, which would have to break",
        names.join(", ")
    );
    let element = machine.branches[loop_of[0]].element;
    Error::new(Code::ContradictoryRatios, message)
        .at(&machine.elements[element].place)
        .hint("give the joints of the loop their stiffness k: it shares the errors out")
}

fn doubts(machine: &Machine, answer: &Answer) -> Vec<Warning> {
    let mut all = Vec::new();
    let mut warn = |code, message: String, hint: &str| {
        all.push(Warning {
            code,
            message,
            hint: Some(hint.to_string()),
        });
    };
    if let Some(names) = &answer.misfit {
        let message = format!(
            "the errors do not fit the loop through {}: with rigid joints it could not turn",
            names.join(", ")
        );
        warn(
            "loop-misfit",
            message,
            "the table is that of the elastic joints, which share the errors out",
        );
    }
    let still: Vec<&str> = (machine.errors.iter().enumerate())
        .filter(|(number, error)| {
            let has_line = answer
                .rows
                .iter()
                .any(|row| row.line.origin == Origin::Declared(*number));
            !has_line && !error.shape.harmonics().iter().all(|h| h.1 == 0.0)
        })
        .map(|(_, error)| error.on.as_str())
        .collect();
    if !still.is_empty() {
        let message = format!(
            "errors of elements that do not turn with the output have no line: {}",
            still.join(", ")
        );
        warn(
            "still",
            message,
            "they stand still, or nothing ties their speed to the output's",
        );
    }
    // What lies on the far side of a friction belt, and still has a line.
    let slips = |at: usize| {
        let pulley = machine
            .gears
            .iter()
            .any(|g| g.element == at && g.teeth.is_none());
        let near = coincidence::side(machine, at, answer.chain.ends.output);
        let across = answer.rows.iter().any(|row| {
            let far = row
                .line
                .declared(machine)
                .is_some_and(|error| !near[error.turning]);
            far && row.share > 0.0
        });
        machine.elements[at].kind == "belt" && pulley && across
    };
    if let Some(at) = (0..machine.elements.len()).find(|&at| slips(at)) {
        let name = &machine.elements[at].name;
        let message =
            format!("{name} is no gear: if it slips, the orders of what lies beyond it wander");
        warn(
            "belt",
            message,
            "orders across a belt hold to its slip; a timing belt does not slip",
        );
    }
    all
}

/// What a study does and leaves out.
pub fn plan(machine: &Machine, study: &TransmissionStudy) -> Vec<(&'static str, Verdict)> {
    let runs = |text: &str| Verdict::Runs(text.to_string());
    let out = |text: &str| Verdict::LeftOut(text.to_string());
    let waves = machine.branches.iter().any(|b| b.wave.is_some());
    vec![
        ("ratios", runs("exact fractions of tooth numbers")),
        (
            "rigid joints",
            Verdict::Runs(format!(
                "{} declared errors to the output",
                machine.errors.len()
            )),
        ),
        (
            "static transmission",
            runs("elastic joints at rest, the driver's angle held"),
        ),
        (
            "mesh stiffness under load",
            match (waves, machine.loads.is_empty()) {
                (true, false) => runs("what carries a torque gives way as its stiffness changes"),
                (true, true) => out("no load is stated"),
                (false, _) => out("no mesh has a stiffness wave"),
            },
        ),
        (
            "at speed",
            match (study.speed, study.speeds) {
                (None, None) => out("no speed was asked for"),
                _ => runs("the dynamic stiffness solved at every order"),
            },
        ),
        (
            "budget",
            runs("sums, and percentiles of the range over unknown phases and tolerances"),
        ),
        (
            "second order of offsets",
            out("told as a sum, not line by line"),
        ),
        (
            "flank form and pitch",
            match study.index {
                Some(_) => runs("what repeats from tooth to tooth and what does not"),
                None => out("the work is not indexed"),
            },
        ),
        (
            "record",
            match study.record {
                true => runs("the error over the angle, with its ranges"),
                false => out("no record was asked for"),
            },
        ),
    ]
}
