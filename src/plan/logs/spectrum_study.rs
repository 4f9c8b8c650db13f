//! Spectrum study and its result.

use super::identify_study::{OVERLAPS, parse_band_hz, read_resolution};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::error_collector::ValueRange;
use crate::base::quantity::truncate;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::{TableReader, Word};
use crate::recording::preprocess::unknown_channel;
use crate::recording::signals::{Channel, Recording};
use crate::spectrum::integrate::MotionQuantity;
use crate::spectrum::line_labels::ExpectedLine;
use crate::spectrum::spectra::Spectra;
use crate::spectrum::spectrogram::SpectrogramRow;
use crate::spectrum::welch::{Averaging, Detrend};
use crate::spectrum::window::Window;

/// Kind of spectrum.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SpectrumKind {
    /// Power spectral density, unit²/Hz.
    #[default]
    Density,
    /// Amplitude of tones, zero to peak.
    Amplitude,
    /// Root mean square of tones.
    Rms,
    /// Power spectral density by several tapers of the whole record.
    Multitaper,
    /// Lines of the squared envelope of a band.
    Envelope,
    /// Real cepstrum.
    Cepstrum,
    /// Power spectral density by time.
    Spectrogram,
    /// Amplitude over orders of a shaft.
    Order,
    /// Mean over the turns of a shaft.
    SynchronousAverage,
}

/// The study; what is `None` is chosen from the data.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SpectrumStudy {
    /// Channels analysed.
    pub channels: Vec<String>,
    /// Kind of spectrum.
    pub kind: SpectrumKind,
    /// Frequency resolution, Hz.
    pub frequency_resolution_hz: Option<f64>,
    /// Window of each block.
    pub window: Option<Window>,
    /// Share of a block that the next has in common with it.
    pub overlap: Option<f64>,
    /// Average over the blocks.
    pub averaging: Averaging,
    /// Trend removed from each block.
    pub detrend: Detrend,
    /// Lines shown, Hz or order; the band-pass of an envelope, Hz.
    pub band: Option<(f64, f64)>,
    /// Motion quantity that replaces the measured one, by integration or differentiation.
    pub history: Option<MotionQuantity>,
    /// The channel of the tacho.
    pub tacho: Option<String>,
    /// Pulses per revolution.
    pub pulses_per_rev: usize,
    /// A steady speed, rad/s.
    pub speed: Option<f64>,
    /// Turns in a block of an order spectrum or cut.
    pub revolutions: Option<usize>,
    /// Orders to cut, cycles a turn.
    pub cuts: Vec<f64>,
    /// The analysis takes only the part that does not repeat with the turns.
    pub separate: bool,
    /// Lines that may be there, Hz; orders where the spectrum is one of orders.
    pub expected_lines: Vec<ExpectedLine>,
}

/// Counts at most.
const MAX_COUNT: u32 = 1_000_000;

impl SpectrumStudy {
    /// Reads its keys.
    pub fn read(f: &mut TableReader) -> SpectrumStudy {
        f.exclusive("tacho", "speed");
        f.requires("pulses", "tacho");
        let count = |f: &mut TableReader, key: &str| {
            f.optional_count(key, 1, MAX_COUNT)
                .map(|count| count as usize)
        };
        // An order cut is no spectrum and takes its own way.
        let kind = f.word("kind").unwrap_or(Some(SpectrumKind::default()));
        let kind_or_default = kind.unwrap_or_default();
        SpectrumStudy {
            channels: f.texts("channel"),
            kind: kind_or_default,
            frequency_resolution_hz: read_resolution(f),
            window: f.parsed("window", |text, _| Window::parse(text)),
            overlap: f.optional_number("overlap", OVERLAPS),
            averaging: f.parsed("average", parse_averaging).unwrap_or_default(),
            detrend: f.word("detrend").unwrap_or_default(),
            band: match kind_or_default {
                SpectrumKind::Order => f.parsed("band", parse_orders),
                _ => f.parsed("band", parse_band_hz),
            },
            history: f.word("as"),
            tacho: f.optional_text("tacho").map(str::to_string),
            pulses_per_rev: count(f, "pulses").unwrap_or(1),
            speed: f.optional_quantity("speed", QuantityKind::Speed, ValueRange::Positive),
            revolutions: count(f, "turns"),
            cuts: match kind {
                None => f.numbers("orders", ValueRange::Positive),
                Some(_) => Vec::new(),
            },
            separate: f.flag("separate"),
            expected_lines: Vec::new(),
        }
    }
}

/// `linear`, `exponential:N` or `peak-hold`.
fn parse_averaging(word: &str, subject: &str) -> Result<Averaging, Error> {
    let blocks = word
        .strip_prefix("exponential:")
        .and_then(|text| text.parse().ok());
    match (word, blocks.filter(|n: &f64| *n >= 1.0 && n.is_finite())) {
        ("linear", _) => Ok(Averaging::Linear),
        ("peak-hold", _) => Ok(Averaging::PeakHold),
        (_, Some(n)) => Ok(Averaging::Exponential(n)),
        _ => {
            let message = format!("\"{}\" is no way to average", truncate(word));
            let hint =
                format!("{subject} takes linear, exponential:8 (blocks, at least 1) or peak-hold");
            Err(Error::new(Code::Usage, message).with_hint(hint))
        }
    }
}

/// `A:B` in orders.
fn parse_orders(text: &str, subject: &str) -> Result<(f64, f64), Error> {
    let number = |t: &str| t.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    let band = text
        .split_once(':')
        .and_then(|(low, high)| number(low).zip(number(high)));
    let rising = band.filter(|(low, high)| *low >= 0.0 && low < high);
    rising.ok_or_else(|| {
        let message = format!("\"{}\" is not a band of orders", truncate(text));
        let hint = format!("{subject} takes low:high, such as 0.5:40");
        Error::new(Code::OutOfRange, message).with_hint(hint)
    })
}

#[rustfmt::skip]
impl Word for Option<SpectrumKind> {
    const WORDS: &'static [(&'static str, Option<SpectrumKind>, &'static str)] = &[
        ("psd", Some(SpectrumKind::Density), "Power spectral density"),
        ("amplitude", Some(SpectrumKind::Amplitude), "Amplitude of tones, zero to peak"),
        ("rms", Some(SpectrumKind::Rms), "Root mean square of tones"),
        ("multitaper", Some(SpectrumKind::Multitaper), "Power spectral density of the whole record by several tapers"),
        ("envelope", Some(SpectrumKind::Envelope), "Lines of the squared envelope of --band"),
        ("cepstrum", Some(SpectrumKind::Cepstrum), "Real cepstrum"),
        ("spectrogram", Some(SpectrumKind::Spectrogram), "Power spectral density by time; by speed with --tacho"),
        ("order", Some(SpectrumKind::Order), "Amplitude over orders of a shaft"),
        ("average", Some(SpectrumKind::SynchronousAverage), "Mean over the turns of a shaft"),
        ("order-cut", None, "Amplitude and phase of --orders over the speed of a run-up"),
    ];
}

impl Word for Detrend {
    const WORDS: &'static [(&'static str, Detrend, &'static str)] = &[
        ("none", Detrend::None, "Nothing"),
        ("mean", Detrend::Mean, "Its mean"),
        ("linear", Detrend::Linear, "Its straight line"),
    ];
}

impl Word for MotionQuantity {
    const WORDS: &'static [(&'static str, MotionQuantity, &'static str)] = &[
        (
            "acceleration",
            MotionQuantity::Acceleration,
            "m/s² or rad/s²",
        ),
        ("velocity", MotionQuantity::Velocity, "m/s or rad/s"),
        ("displacement", MotionQuantity::Displacement, "m or rad"),
    ];
}

/// Kind of abscissa of a spectrum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AbscissaKind {
    /// Hz.
    Frequency,
    /// Cycles a turn.
    Order,
    /// s.
    Quefrency,
    /// Degrees of a turn.
    Angle,
}

impl AbscissaKind {
    /// Label of the abscissa and its unit.
    pub fn label(self) -> (&'static str, &'static str) {
        match self {
            AbscissaKind::Frequency => ("frequency", "Hz"),
            AbscissaKind::Order => ("order", ""),
            AbscissaKind::Quefrency => ("quefrency", "s"),
            AbscissaKind::Angle => ("angle", "deg"),
        }
    }
}

/// A line of a spectrum.
#[derive(Debug, Clone)]
pub struct LabelledPeak {
    /// Between the lines: Hz, order or s.
    pub position: f64,
    /// Height of the curve there, in its unit.
    pub value: f64,
    /// Amplitude of a tone that would make it, zero to peak (root mean square on request).
    pub amplitude: f64,
    /// Power over that of the floor; `None` for cepstra.
    pub signal_to_noise: Option<f64>,
    /// True if the line is above the noise level.
    pub significant: bool,
    /// Candidate names, the nearest first; more than one where the measurement cannot distinguish them.
    pub names: Vec<String>,
}

/// The spectrum of one channel.
#[derive(Debug, Clone)]
pub struct ChannelSpectrum {
    /// The channel.
    pub channel: String,
    /// Unit of the values.
    pub unit: String,
    /// Unit of amplitudes of its lines.
    pub amplitude_unit: String,
    /// One for each place.
    pub value: Vec<f64>,
    /// Peaks, the strongest first.
    pub peaks: Vec<LabelledPeak>,
    /// Rows over time, for spectrograms; over the abscissa of the result.
    pub spectrogram_rows: Vec<SpectrogramRow>,
    /// Speed of the shaft in the middle of each row, rad/s; empty without a shaft.
    pub speed: Vec<f64>,
}

/// Spectra with the method that made them.
#[derive(Debug)]
pub struct SpectrumResult {
    /// Stages that ran, with seconds.
    pub trace: Vec<(&'static str, f64)>,
    /// Method as text.
    pub method_text: String,
    /// Requested kind of spectrum.
    pub kind: SpectrumKind,
    /// Kind of abscissa.
    pub abscissa_kind: AbscissaKind,
    /// Places, rising.
    pub abscissa: Vec<f64>,
    /// One for each channel.
    pub channel_spectra: Vec<ChannelSpectrum>,
    /// Quefrencies between which families of lines were sought, s.
    pub quefrency_range_s: Option<(f64, f64)>,
    /// Step of the abscissa.
    pub abscissa_step: f64,
    /// Independent averages.
    pub averages: Option<f64>,
    /// Multiples of a density between which the true one lies with 95 %.
    pub interval: Option<(f64, f64)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// The spectrum of a channel before it is shown: density, or half the square of an amplitude with a bandwidth of one.
pub struct SpectrumEstimate {
    /// In words.
    pub method_text: String,
    /// Kind of abscissa.
    pub abscissa_kind: AbscissaKind,
    /// One channel's density each.
    pub spectra: Spectra,
    /// By time, for spectrograms.
    pub spectrogram_rows: Vec<Vec<SpectrogramRow>>,
    /// Speed of the shaft in the middle of each row, rad/s; empty without a shaft.
    pub speed: Vec<f64>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// A channel by its name.
///
/// # Errors
/// There is none of that name.
pub fn channel<'r>(recording: &'r Recording, name: &str) -> Result<&'r Channel, Error> {
    recording.channel(name).ok_or_else(|| {
        let known: Vec<String> = recording.channels.iter().map(|c| c.name.clone()).collect();
        unknown_channel(name, &known)
    })
}
