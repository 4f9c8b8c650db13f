//! `[[study]]`: what a scene asks of its model.

use super::common::MOST;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::fields::Fields;
use crate::base::kind::Kind;
use crate::base::notes::Range;
use crate::base::place::Place;
use crate::base::toml::Value;
use crate::base::units;

/// One question of a scene.
#[derive(Debug, Clone)]
pub struct Study {
    /// What is asked.
    pub kind: StudyKind,
    /// Where it is asked.
    pub place: Place,
}

/// What a study asks.
#[derive(Debug, Clone)]
pub enum StudyKind {
    /// Natural frequencies, damping and shapes.
    Modes(ModesStudy),
    /// Motion in time.
    Simulate(SimulateStudy),
    /// Error against run time.
    Accuracy(AccuracyStudy),
    /// Where methods and machine break.
    Stability(StabilityStudy),
    /// Steady answers to steady excitation.
    Response(ResponseStudy),
    /// Periodic motions over speed, play and all.
    HarmonicBalance(HarmonicBalanceStudy),
    /// Answers to all orders of a running machine over speed.
    RunUp(RunUpStudy),
    /// Transmission error of a chain.
    Transmission(TransmissionStudy),
}

/// Transmission error of a chain, as the command has it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TransmissionStudy {
    /// The node whose error is wanted.
    pub output: Option<String>,
    /// The node whose angle is prescribed; that of the first stated speed where absent.
    pub driver: Option<String>,
    /// The node the output should turn with.
    pub against: Option<String>,
    /// Where on the output the error is also told as an arc, m.
    pub radius: Option<f64>,
    /// Speed of the first node of `[speed]` for the error at speed, rad/s.
    pub speed: Option<f64>,
    /// Speeds of a map of all lines.
    pub speeds: Option<SpeedRange>,
    /// Turns of the output over which ranges are told and a record is made.
    pub window: Option<u32>,
    /// Teeth of the output by which a record is told tooth by tooth.
    pub teeth: Option<u32>,
    /// A machine that indexes tooth by tooth.
    pub index: Option<IndexStudy>,
    /// The error over the angle is wanted.
    pub record: bool,
}

/// A machine that indexes tooth by tooth.
#[derive(Debug, Clone, PartialEq)]
pub struct IndexStudy {
    /// The pair or shaft whose output side moves on from tooth to tooth.
    pub behind: String,
    /// Teeth of the work.
    pub teeth: u32,
}

impl IndexStudy {
    /// Reads `ELEMENT:TEETH`.
    ///
    /// # Errors
    /// What is not of that form.
    pub fn parse(text: &str, subject: &str) -> Result<IndexStudy, Error> {
        let parts = text.rsplit_once(':');
        let read = parts.and_then(|(behind, teeth)| {
            Some((behind, teeth.trim().parse().ok().filter(|z| *z >= 2)?))
        });
        let Some((behind, teeth)) = read else {
            let message = format!("\"{}\" is no indexing", units::shortened(text));
            let hint = format!(
                "{subject} takes the element behind which the work moves on, and the teeth of the work, such as differential:37"
            );
            return Err(Error::new(Code::OutOfRange, message).hint(hint));
        };
        Ok(IndexStudy {
            behind: behind.trim().to_string(),
            teeth,
        })
    }
}

/// Answers to all orders of a running machine over speed, as the command has them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RunUpStudy {
    /// Speeds of the first node of `[speed]`.
    pub speeds: Option<SpeedRange>,
    /// What is measured, as of a frequency response; forces in all meshes where left out.
    pub outputs: Vec<String>,
    /// Freedoms held still.
    pub held: Vec<String>,
}

/// Periodic motions over speed, as the command has them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HarmonicBalanceStudy {
    /// Speeds of the first node of `[speed]`; the number of points bounds the steps.
    pub speeds: Option<SpeedRange>,
    /// Signals as of a motion; deflections of what has play or varies where left out.
    pub outputs: Vec<String>,
    /// What higher orders may add, of the size of the deflections.
    pub tolerance: Option<f64>,
    /// So many orders; as many as the tolerance asks where absent.
    pub orders: Option<u32>,
    /// By orders alone, without refining motions by events.
    pub orders_alone: bool,
}

/// The most orders of a balance.
pub const MOST_ORDERS: u32 = 500;

/// Steady answers to steady excitation, as the command has them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ResponseStudy {
    /// What drives: `node.axis`, `branch.displacement`, `ground.x`, `node.axis.motion`.
    pub inputs: Vec<String>,
    /// What is measured: `node.axis`, `.speed`, `.acceleration`, sums, `branch.force`, `branch.deflection`.
    pub outputs: Vec<String>,
    /// Freedoms held still.
    pub held: Vec<String>,
    /// Motions are shown as displacement, speed or acceleration; as named where absent.
    pub shown: Option<ResponseKind>,
    /// From and to, rad/s.
    pub band: Option<(f64, f64)>,
    /// Lines in the band, both ends included.
    pub lines: Option<u32>,
    /// Speed of the first node of `[speed]`, rad/s.
    pub speed: Option<f64>,
    /// How it is found; chosen where absent.
    pub way: Option<ResponseWay>,
}

/// What a motion is shown as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResponseKind {
    /// Displacement.
    Receptance,
    /// Speed.
    Mobility,
    /// Acceleration.
    Accelerance,
}

/// How a response is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResponseWay {
    /// Solved line by line.
    Direct,
    /// A sum over modes.
    Modal,
}

/// The most lines of a response.
pub const MOST_LINES: u32 = 10_000_000;

/// Reads `A:B`, two frequencies (Hz where bare), into rad/s.
///
/// # Errors
/// What is no rising range of frequencies.
pub fn band(text: &str, subject: &str) -> Result<(f64, f64), Error> {
    let form = || {
        let message = format!("\"{}\" is not a band", units::shortened(text));
        let hint = format!("{subject} takes first:last, such as 10:500 or \"0 Hz:3 kHz\"");
        Error::new(Code::OutOfRange, message).hint(hint)
    };
    let (from, to) = text.split_once(':').ok_or_else(form)?;
    let frequency = |text: &str| units::parse_or_bare(text, Kind::Frequency, "Hz", subject);
    let (from, to) = (frequency(from)?, frequency(to)?);
    match from >= 0.0 && from < to && to.is_finite() {
        true => Ok((from, to)),
        false => Err(form()),
    }
}

/// Motion in time, as the command has it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SimulateStudy {
    /// To this instant, s; from zero.
    pub until: Option<f64>,
    /// Signals: `node.axis`, `node.axis.speed`, `node.axis.acceleration`, `branch.force`, `branch.deflection`.
    pub outputs: Vec<String>,
    /// The method by its word; chosen where absent.
    pub method: Option<String>,
    /// Local error per step, relative.
    pub tolerance: Option<f64>,
    /// Fixed step, s.
    pub step: Option<f64>,
    /// How many equal steps the outputs divide the time into.
    pub samples: Option<u32>,
    /// The energy balance.
    pub energy: bool,
    /// Speed of the first node of `[speed]` in place of the model's, rad/s.
    pub speed: Option<f64>,
    /// What is found while it runs.
    pub running: RunningStudy,
}

/// What is found of a motion while it runs, without its history.
#[derive(Debug, Clone, PartialEq)]
pub struct RunningStudy {
    /// The history of the outputs is kept.
    pub history: bool,
    /// Spectra of the outputs over blocks of so many samples.
    pub spectrum: Option<u32>,
    /// Orders of the outputs.
    pub track: Option<TrackStudy>,
    /// Over so many turns each point of the orders is a mean.
    pub turns: u32,
    /// Transmission error of the second node against the first.
    pub te: Option<[String; 2]>,
    /// Teeth between both, driver first: `21:63` or `21:63,17:40`.
    pub teeth: Option<String>,
}

impl Default for RunningStudy {
    fn default() -> RunningStudy {
        RunningStudy {
            history: true,
            spectrum: None,
            track: None,
            turns: USUAL_TURNS,
            te: None,
            teeth: None,
        }
    }
}

/// Turns of a point of the orders where nothing is said.
pub const USUAL_TURNS: u32 = 8;

/// Samples of a block at least and at most.
pub const BLOCKS: std::ops::RangeInclusive<u32> = 16..=(1 << 24);

/// The most orders followed at once.
const MOST_TRACKED: usize = 100;

/// Orders followed over the angle of a node.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackStudy {
    /// The node they turn with.
    pub node: String,
    /// Cycles a turn of it.
    pub orders: Vec<f64>,
}

impl TrackStudy {
    /// Reads `NODE:ORDER,ORDER…`, orders as numbers or fractions.
    ///
    /// # Errors
    /// What is not of that form.
    pub fn parse(text: &str, subject: &str) -> Result<TrackStudy, Error> {
        let order = |text: &str| -> Option<f64> {
            let number = |text: &str| text.trim().parse::<f64>().ok();
            let value = match text.split_once('/') {
                Some((a, b)) => number(a)? / number(b)?,
                None => number(text)?,
            };
            (value > 0.0 && value.is_finite()).then_some(value)
        };
        let read = text.rsplit_once(':').and_then(|(node, orders)| {
            let orders = orders.split(',').map(order).collect::<Option<Vec<f64>>>()?;
            (orders.len() <= MOST_TRACKED).then(|| TrackStudy {
                node: node.trim().to_string(),
                orders,
            })
        });
        read.ok_or_else(|| {
            let message = format!("\"{}\" names no orders of a node", units::shortened(text));
            let hint =
                format!("{subject} takes node:order,order…, such as motor:1,21 or motor:37/12");
            Error::new(Code::OutOfRange, message).hint(hint)
        })
    }
}

/// Reads `INPUT:OUTPUT`, two nodes.
///
/// # Errors
/// What is not of that form.
pub fn shafts(text: &str, subject: &str) -> Result<[String; 2], Error> {
    match text.split_once(':') {
        Some((a, b)) if !a.trim().is_empty() && !b.trim().is_empty() => {
            Ok([a, b].map(|node| node.trim().to_string()))
        }
        _ => {
            let message = format!("\"{}\" names no two nodes", units::shortened(text));
            let hint = format!("{subject} takes input:output, such as motor:spindle");
            Err(Error::new(Code::OutOfRange, message).hint(hint))
        }
    }
}

/// Error against run time, as the command has it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct AccuracyStudy {
    /// What is to be exact.
    pub of: Subject,
    /// The motion.
    pub motion: SimulateStudy,
    /// How many elastic modes are compared.
    pub lowest: Option<u32>,
    /// The responses.
    pub response: ResponseStudy,
    /// Only these methods; all that apply where empty.
    pub methods: Vec<String>,
    /// The error that is wanted in the end, relative.
    pub wanted: Option<f64>,
}

/// What a study of accuracy compares.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Subject {
    /// The motion in time.
    #[default]
    Motion,
    /// The lowest natural frequencies.
    Modes,
    /// Frequency responses.
    Response,
}

/// Where methods and machine break, as the command has it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StabilityStudy {
    /// The motion.
    pub motion: SimulateStudy,
    /// Only these methods; all that apply where empty.
    pub methods: Vec<String>,
    /// Speeds of a parametric stability chart.
    pub speeds: Option<SpeedRange>,
    /// What else the chart goes over.
    pub over: Option<Over>,
}

/// The second axis of a stability chart: factors on what the scene has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Over {
    /// What is changed.
    pub parameter: Parameter,
    /// The first factor.
    pub from: f64,
    /// The last.
    pub to: f64,
    /// How many, both ends included.
    pub count: u32,
}

/// What a stability chart can go over beside speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    /// How far every stiffness wave goes from its mean.
    Depth,
    /// Every damping.
    Damping,
}

impl Parameter {
    /// The word for it in files.
    pub fn name(self) -> &'static str {
        match self {
            Parameter::Depth => "depth",
            Parameter::Damping => "damping",
        }
    }
}

impl Over {
    /// Reads `depth=A:B:N` or `damping=A:B:N`.
    pub fn parse(text: &str, subject: &str) -> Result<Over, Error> {
        const MOST_ROWS: u32 = 1000;
        let form = || {
            let message = format!(
                "\"{}\" is no second axis of a chart",
                units::shortened(text)
            );
            let hint = format!(
                "{subject} takes depth=first:last:rows or damping=first:last:rows, factors on what the scene has, such as depth=0:1:21"
            );
            Error::new(Code::OutOfRange, message).hint(hint)
        };
        let (name, range) = text.split_once('=').ok_or_else(form)?;
        let known = [Parameter::Depth, Parameter::Damping];
        let parameter = known.into_iter().find(|p| p.name() == name.trim());
        let parts: Vec<&str> = range.split(':').map(str::trim).collect();
        let [from, to, count] = parts[..] else {
            return Err(form());
        };
        let number = |text: &str| {
            text.parse::<f64>()
                .ok()
                .filter(|x| x.is_finite() && *x >= 0.0)
        };
        match (parameter, number(from), number(to), count.parse::<u32>()) {
            (Some(parameter), Some(from), Some(to), Ok(count))
                if from < to && (2..=MOST_ROWS).contains(&count) =>
            {
                Ok(Over {
                    parameter,
                    from,
                    to,
                    count,
                })
            }
            _ => Err(form()),
        }
    }

    /// The factors, rising.
    pub fn factors(self) -> impl Iterator<Item = f64> {
        let steps = f64::from(self.count - 1);
        (0..self.count).map(move |k| self.from + (self.to - self.from) * f64::from(k) / steps)
    }
}

/// Options of the modes of a machine, as the command has them.
#[derive(Debug, Clone, Default)]
pub struct ModesStudy {
    /// Damping counts.
    pub damped: bool,
    /// Speed of the first node of `[speed]`, rad/s.
    pub speed: Option<f64>,
    /// Speeds of a Campbell diagram.
    pub campbell: Option<SpeedRange>,
    /// Only so many modes, from the lowest.
    pub lowest: Option<u32>,
    /// The modes nearest to this frequency, rad/s.
    pub near: Option<f64>,
    /// The state-space form.
    pub state_space: Option<StateSpaceStudy>,
    /// A reduced machine.
    pub reduce: Option<ReduceStudy>,
}

/// Which state-space form is wanted.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StateSpaceStudy {
    /// `node.axis` each; all freedoms where none is named.
    pub inputs: Vec<String>,
    /// `node.axis`, `node.axis.speed`, `node.axis.acceleration` or `branch.force` each; all freedoms where none is named.
    pub outputs: Vec<String>,
    /// Between samples, s; absent: continuous.
    pub sample_time: Option<f64>,
    /// What inputs do between samples.
    pub hold: Hold,
}

/// What an input is taken to do between samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Hold {
    /// It stays: exact for steps at samples.
    #[default]
    Zero,
    /// It goes straight to the next sample: exact for ramps. States are shifted by what the coming sample adds, outputs not.
    First,
    /// Tustin's rule: the trapezoidal rule in time. Stable forms stay stable; frequencies are warped, states are not the continuous ones.
    Bilinear,
}

impl Hold {
    /// The word for it in files.
    pub fn name(self) -> &'static str {
        match self {
            Hold::Zero => "zero-order",
            Hold::First => "first-order",
            Hold::Bilinear => "bilinear",
        }
    }
}

/// Which reduced machine is wanted.
#[derive(Debug, Clone, PartialEq)]
pub struct ReduceStudy {
    /// How.
    pub method: ReduceMethod,
    /// Freedoms kept, loaded and measured, `node.axis` each.
    pub keep: Vec<String>,
    /// The response matters up to here, Hz.
    pub below_hz: f64,
    /// Modes kept; absent: those below twice the band.
    pub modes: Option<u32>,
}

/// How a machine is reduced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ReduceMethod {
    /// Static condensation.
    Guyan,
    /// Condensation at a frequency, Hz.
    Dynamic(f64),
    /// Static condensation and fixed-interface modes.
    CraigBampton,
    /// Modes with a static residual.
    Modal,
}

/// Equally spaced speeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedRange {
    /// First speed, rad/s.
    pub from: f64,
    /// Last speed, rad/s.
    pub to: f64,
    /// How many speeds, both ends included.
    pub count: u32,
}

impl SpeedRange {
    /// The speeds, rising, rad/s.
    pub fn all(self) -> Vec<f64> {
        let steps = f64::from(self.count - 1);
        (0..self.count)
            .map(|k| self.from + (self.to - self.from) * f64::from(k) / steps)
            .collect()
    }

    /// Reads `A:B:N`, two speeds (rpm where bare) and how many points; 50 points where `N` is left out.
    pub fn parse(text: &str, subject: &str) -> Result<SpeedRange, Error> {
        const USUAL: u32 = 50;
        const MOST_POINTS: u32 = 100_000;
        let form = || {
            let message = format!("\"{}\" is not a range of speeds", units::shortened(text));
            let hint = format!(
                "{subject} takes first:last:points, such as 0:3000:61 or \"0 rpm:50 Hz:61\""
            );
            Error::new(Code::OutOfRange, message).hint(hint)
        };
        let parts: Vec<&str> = text.splitn(4, ':').collect();
        let (from, to, count) = match parts[..] {
            [from, to] => (from, to, USUAL),
            [from, to, count] => {
                let count = count.trim().parse().map_err(|_| form())?;
                (from, to, count)
            }
            _ => return Err(form()),
        };
        let speed = |text: &str| units::parse_or_bare(text, Kind::Speed, "rpm", subject);
        let (from, to) = (speed(from)?, speed(to)?);
        if !(2..=MOST_POINTS).contains(&count) || from >= to {
            return Err(form());
        }
        Ok(SpeedRange { from, to, count })
    }
}

/// Which kind of study.
#[derive(Clone, Copy)]
enum Word {
    Modes,
    Simulate,
    Accuracy,
    Stability,
    Response,
    HarmonicBalance,
    RunUp,
    Transmission,
}

/// A study; absent where its kind is missing or unknown, which is then noted.
pub fn read(f: &mut Fields) -> Option<Study> {
    let words = [
        ("modes", Word::Modes),
        ("simulate", Word::Simulate),
        ("accuracy", Word::Accuracy),
        ("stability", Word::Stability),
        ("response", Word::Response),
        ("harmonic_balance", Word::HarmonicBalance),
        ("run_up", Word::RunUp),
        ("te", Word::Transmission),
    ];
    let known = f.choice("kind", &words);
    f.need("kind");
    let kind = match known? {
        Word::Modes => StudyKind::Modes(modes(f)),
        Word::Simulate => StudyKind::Simulate(SimulateStudy {
            running: running(f),
            ..simulate(f)
        }),
        Word::Accuracy => StudyKind::Accuracy(accuracy(f)),
        Word::Stability => StudyKind::Stability(StabilityStudy {
            motion: simulate(f),
            methods: texts(f, "methods"),
            speeds: speeds(f, "speeds"),
            over: parsed(f, "over", Over::parse),
        }),
        Word::Response => StudyKind::Response(response(f)),
        Word::RunUp => StudyKind::RunUp(RunUpStudy {
            speeds: speeds(f, "speeds"),
            outputs: texts(f, "outputs"),
            held: texts(f, "hold"),
        }),
        Word::HarmonicBalance => StudyKind::HarmonicBalance(HarmonicBalanceStudy {
            speeds: speeds(f, "speeds"),
            outputs: texts(f, "outputs"),
            tolerance: f
                .optional_number("tolerance", Range::Between(0.0, 1.0, "above 0 and below 1")),
            orders: f.optional_count("orders", 1, MOST_ORDERS),
            orders_alone: f.flag("orders_alone"),
        }),
        Word::Transmission => StudyKind::Transmission(transmission(f)),
    };
    Some(Study {
        kind,
        place: f.place.clone(),
    })
}

fn accuracy(f: &mut Fields) -> AccuracyStudy {
    let words = [
        ("motion", Subject::Motion),
        ("modes", Subject::Modes),
        ("response", Subject::Response),
    ];
    let mut study = AccuracyStudy {
        of: f.choice("of", &words).unwrap_or_default(),
        wanted: f.optional_number("error", Range::Positive),
        ..AccuracyStudy::default()
    };
    match study.of {
        Subject::Motion => {
            study.motion = simulate(f);
            study.methods = texts(f, "methods");
        }
        Subject::Modes => study.lowest = f.optional_count("lowest", 1, MOST),
        Subject::Response => study.response = response(f),
    }
    study
}

fn modes(f: &mut Fields) -> ModesStudy {
    let study = ModesStudy {
        damped: f.flag("damped"),
        speed: f.optional_quantity("speed", Kind::Speed, Range::Any),
        campbell: speeds(f, "campbell"),
        lowest: f.optional_count("lowest", 1, MOST),
        near: f.optional_quantity("near", Kind::Frequency, Range::NotNegative),
        ..ModesStudy::default()
    };
    f.exclusive("speed", "campbell");
    study
}

fn response(f: &mut Fields) -> ResponseStudy {
    let shown = [
        ("receptance", ResponseKind::Receptance),
        ("mobility", ResponseKind::Mobility),
        ("accelerance", ResponseKind::Accelerance),
    ];
    let ways = [
        ("direct", ResponseWay::Direct),
        ("modal", ResponseWay::Modal),
    ];
    let parsed = f.optional_text("band").map(|text| band(text, "`band`"));
    let band = match parsed {
        Some(Err(error)) => {
            let place = f.place_of("band").clone();
            let label = format!("in {}", f.title);
            f.notes.push(error.at(&place).label(label));
            None
        }
        Some(Ok(band)) => Some(band),
        None => None,
    };
    ResponseStudy {
        inputs: texts(f, "inputs"),
        outputs: texts(f, "outputs"),
        held: texts(f, "hold"),
        shown: f.choice("shown", &shown),
        band,
        lines: f.optional_count("lines", 2, MOST_LINES),
        speed: f.optional_quantity("speed", Kind::Speed, Range::Any),
        way: f.choice("method", &ways),
    }
}

fn transmission(f: &mut Fields) -> TransmissionStudy {
    let text = |f: &mut Fields, key: &str| f.optional_text(key).map(str::to_string);
    TransmissionStudy {
        output: text(f, "output"),
        driver: text(f, "driver"),
        against: text(f, "against"),
        radius: f.optional_quantity("radius", Kind::Length, Range::Positive),
        speed: f.optional_quantity("speed", Kind::Speed, Range::Any),
        speeds: speeds(f, "speeds"),
        window: f.optional_count("window", 1, MOST),
        teeth: f.optional_count("teeth", 1, MOST),
        index: parsed(f, "index", IndexStudy::parse),
        record: false,
    }
}

fn simulate(f: &mut Fields) -> SimulateStudy {
    f.exclusive("tolerance", "step");
    SimulateStudy {
        until: f.optional_quantity("until", Kind::Time, Range::Positive),
        outputs: texts(f, "outputs"),
        method: f.optional_text("method").map(str::to_string),
        tolerance: f.optional_number("tolerance", Range::Between(0.0, 1.0, "above 0 and below 1")),
        step: f.optional_quantity("step", Kind::Time, Range::Positive),
        samples: f.optional_count("samples", 1, MOST_SAMPLES),
        energy: f.flag("energy"),
        speed: f.optional_quantity("speed", Kind::Speed, Range::Any),
        running: RunningStudy::default(),
    }
}

fn running(f: &mut Fields) -> RunningStudy {
    let usual = RunningStudy::default();
    let track = parsed(f, "track", TrackStudy::parse);
    if f.has("turns") && !f.has("track") {
        f.missing("track", ", the orders that `turns` is of");
    }
    if f.has("te") != f.has("teeth") {
        let (has, lacks) = if f.has("te") {
            ("te", "teeth")
        } else {
            ("teeth", "te")
        };
        f.missing(lacks, &format!(", and `{has}` is given"));
    }
    RunningStudy {
        history: f
            .choice("history", &[("kept", true), ("none", false)])
            .unwrap_or(usual.history),
        spectrum: f.optional_count("spectrum", *BLOCKS.start(), *BLOCKS.end()),
        track,
        turns: f.optional_count("turns", 1, MOST).unwrap_or(usual.turns),
        te: parsed(f, "te", shafts),
        teeth: f.optional_text("teeth").map(str::to_string),
    }
}

/// The most samples of a motion.
pub const MOST_SAMPLES: u32 = 100_000_000;

/// A list of texts.
pub(super) fn texts(f: &mut Fields, key: &str) -> Vec<String> {
    const TAKES: &str = "a list of texts";
    let Some(item) = f.item(key, TAKES) else {
        return Vec::new();
    };
    let Value::List(list) = &item.value else {
        return f.wrong_type(key, item, TAKES).unwrap_or_default();
    };
    let mut all = Vec::new();
    for item in list {
        match &item.value {
            Value::Text(text) => all.push(text.clone()),
            _ => {
                f.wrong_type::<()>(key, item, TAKES);
            }
        }
    }
    all
}

fn speeds(f: &mut Fields, key: &str) -> Option<SpeedRange> {
    parsed(f, key, SpeedRange::parse)
}

/// A text that has a form of its own.
fn parsed<T>(f: &mut Fields, key: &str, parse: fn(&str, &str) -> Result<T, Error>) -> Option<T> {
    let text = f.optional_text(key)?;
    match parse(text, &format!("`{key}`")) {
        Ok(value) => Some(value),
        Err(error) => {
            let place = f.place_of(key).clone();
            let label = format!("in {}", f.title);
            f.notes.push(error.at(&place).label(label));
            None
        }
    }
}
