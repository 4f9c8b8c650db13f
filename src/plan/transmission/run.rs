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
use crate::plan::stages::Verdict;
use crate::response::frequency::Way;
use crate::response::system::Setting;
use crate::scene::study::TransmissionStudy;
use crate::transmission::chain::{Chain, Ends};
use crate::transmission::coincidence::{self, Coincidence};
use crate::transmission::dynamic::Transfer;
use crate::transmission::lines::{self, Line, Origin};
use crate::transmission::loaded;

/// The transmission error of a chain.
pub struct Answer {
    /// The chain.
    pub chain: Chain,
    /// Every line, by rising order.
    pub rows: Vec<Row>,
    /// Orders that coincide, by numbers of rows.
    pub coincidences: Vec<Coincidence>,
    /// After so many turns of the output everything repeats; absent where there is no line.
    pub period: Option<Fraction>,
    /// A rigid loop does not fit the errors, so that only elastic joints have an answer: the branches of the loop.
    pub misfit: Option<Vec<String>>,
    /// By how much the mean loads wind up the chain, rad.
    pub wind_up: f64,
    /// m.
    pub radius: Option<f64>,
    /// Speed of the output for the error at speed, rad/s.
    pub speed: Option<f64>,
    /// Stages with what they do.
    pub plan: Vec<(&'static str, Verdict)>,
    /// Doubts.
    pub warnings: Vec<Warning>,
}

/// A line of the table.
pub struct Row {
    /// Its source and order.
    pub line: Line,
    /// A and ψ at the output under load, slowly, rad.
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

    /// Rigid joints have an answer for every single error: no loop shares it out.
    pub fn is_rigid(&self) -> bool {
        self.chain.conditions.is_empty()
    }

    /// Sum of all amplitudes, rad.
    pub fn worst_case(&self) -> f64 {
        self.rows.iter().map(|row| self.slow(row).norm()).sum()
    }

    /// Root of the sum of squared amplitudes, rad.
    pub fn rss(&self) -> f64 {
        self.rows
            .iter()
            .map(|row| self.slow(row).norm_sqr())
            .sum::<f64>()
            .sqrt()
    }
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
        linear,
        ..
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
    let setting = Setting {
        machine,
        operating,
        linear,
        speeds: None,
    };
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
    let speed = match study.speed {
        None => None,
        Some(speed) => Some(mean_speeds(machine, kinematics, Some(speed))?[ends.output]),
    };
    let at_speed = speed
        .map(|speed| transfer.at_speed(speed, &all))
        .transpose()?;
    let coincidences = coincidence::coincidences(machine, &chain, &all);
    let mut answer = Answer {
        period: Fraction::common_measure(all.iter().map(|line| &line.order))
            .map(|m| &Fraction::one() / &m),
        misfit: misfit.map(|list| list.iter().map(|&b| machine.branch_name(b)).collect()),
        wind_up: loaded::wind_up(&setting, &chain)?,
        radius: study.radius,
        speed,
        plan: plan(machine, study),
        warnings: prepared.warnings(),
        coincidences,
        rows: (all.into_iter().enumerate())
            .map(|(k, line)| Row {
                line,
                loaded: under_load[k],
                dynamic: at_speed.as_ref().map(|all| all[k]),
                share: 0.0,
            })
            .collect(),
        chain,
    };
    let total: f64 = answer.rss().powi(2);
    let shares: Vec<f64> = answer
        .rows
        .iter()
        .map(|row| answer.slow(row).norm_sqr() / total)
        .collect();
    if total > 0.0 {
        answer
            .rows
            .iter_mut()
            .zip(shares)
            .for_each(|(row, share)| row.share = share);
    }
    answer.warnings.extend(doubts(machine, &answer));
    Ok(answer)
}

/// The rotation of a node.
fn angle(machine: &Machine, name: &str) -> Result<usize, Error> {
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
    let slips = machine.elements.iter().enumerate().find(|(at, element)| {
        let pulley = |g: &crate::machine::parts::Gear| g.element == *at && g.teeth.is_none();
        element.kind == "belt" && machine.gears.iter().any(pulley)
    });
    if let Some((_, element)) = slips {
        let message = format!(
            "{} is no gear: if it slips, the orders of what lies beyond it wander",
            element.name
        );
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
            match study.speed {
                Some(_) => runs("the dynamic stiffness solved at every order"),
                None => out("no speed was asked for"),
            },
        ),
    ]
}
