//! Options of a spectrum study, and its results.

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

/// Kind of spectrum, selected by `kind`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SpectrumKind {
    /// Power spectral density, unit²/Hz.
    #[default]
    Density,
    /// Amplitude spectrum, zero to peak.
    Amplitude,
    /// Amplitude spectrum, root mean square.
    Rms,
    /// Multitaper power spectral density of the complete record.
    Multitaper,
    /// Spectrum of the squared envelope of a band.
    Envelope,
    /// Real cepstrum.
    Cepstrum,
    /// Power spectral density over time.
    Spectrogram,
    /// Amplitude spectrum over orders of a shaft.
    Order,
    /// Synchronous average over the revolutions of a shaft.
    SynchronousAverage,
}

/// Options of a spectrum study; options that are `None` are chosen from the data.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SpectrumStudy {
    /// Names of the channels.
    pub channels: Vec<String>,
    /// Requested kind of spectrum.
    pub kind: SpectrumKind,
    /// Frequency resolution, Hz.
    pub frequency_resolution_hz: Option<f64>,
    /// Window of each block.
    pub window: Option<Window>,
    /// Overlap of successive blocks, as a share of the block length.
    pub overlap: Option<f64>,
    /// Averaging over the blocks.
    pub averaging: Averaging,
    /// Trend removed from each block.
    pub detrend: Detrend,
    /// Band of the result, Hz or order; for an envelope the band-pass, Hz.
    pub band: Option<(f64, f64)>,
    /// Motion quantity into which the measured one is integrated or differentiated.
    pub history: Option<MotionQuantity>,
    /// Name of the tacho channel.
    pub tacho: Option<String>,
    /// Tacho pulses per revolution.
    pub pulses_per_rev: usize,
    /// Constant speed, rad/s.
    pub speed: Option<f64>,
    /// Revolutions per block of an order spectrum or order cut.
    pub revolutions: Option<usize>,
    /// Orders of the order cuts, cycles per revolution.
    pub cuts: Vec<f64>,
    /// True if only the random part of the signals is analysed.
    pub separate: bool,
    /// Lines expected from the machine, Hz; for an order spectrum, orders.
    pub expected_lines: Vec<ExpectedLine>,
}

/// Largest value of a count.
const MAX_COUNT: u32 = 1_000_000;

impl SpectrumStudy {
    /// Reads the options of a study from its table.
    pub fn read(f: &mut TableReader) -> SpectrumStudy {
        f.exclusive("tacho", "speed");
        f.requires("pulses", "tacho");
        let count = |f: &mut TableReader, key: &str| {
            f.optional_count(key, 1, MAX_COUNT)
                .map(|count| count as usize)
        };
        // `None` is an order cut, which is computed separately.
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

/// Parses `linear`, `exponential:N` or `peak-hold`.
fn parse_averaging(word: &str, subject: &str) -> Result<Averaging, Error> {
    let blocks = word
        .strip_prefix("exponential:")
        .and_then(|text| text.parse().ok());
    match (word, blocks.filter(|n: &f64| *n >= 1.0 && n.is_finite())) {
        ("linear", _) => Ok(Averaging::Linear),
        ("peak-hold", _) => Ok(Averaging::PeakHold),
        (_, Some(n)) => Ok(Averaging::Exponential(n)),
        _ => {
            let message = format!("\"{}\" is not an averaging method", truncate(word));
            let hint =
                format!("{subject} takes linear, exponential:8 (blocks, at least 1) or peak-hold");
            Err(Error::new(Code::Usage, message).with_hint(hint))
        }
    }
}

/// Parses a band `A:B` of orders.
fn parse_orders(text: &str, subject: &str) -> Result<(f64, f64), Error> {
    let number = |t: &str| t.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    let band = text
        .split_once(':')
        .and_then(|(low, high)| number(low).zip(number(high)));
    let valid = band.filter(|(low, high)| *low >= 0.0 && low < high);
    valid.ok_or_else(|| {
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
    /// Frequency, Hz.
    Frequency,
    /// Order, cycles per revolution.
    Order,
    /// Quefrency, s.
    Quefrency,
    /// Shaft angle, deg.
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

/// Peak of a spectrum with its candidate names.
#[derive(Debug, Clone)]
pub struct LabelledPeak {
    /// Interpolated abscissa: Hz, order or s.
    pub position: f64,
    /// Value of the spectrum at the peak, in its unit.
    pub value: f64,
    /// Amplitude of a tone with this peak, zero to peak (root mean square on request).
    pub amplitude: f64,
    /// Power ratio of the peak to the noise floor; `None` for cepstra.
    pub signal_to_noise: Option<f64>,
    /// True if the peak exceeds the noise level.
    pub significant: bool,
    /// Candidate names, the nearest first; more than one where the measurement cannot distinguish them.
    pub names: Vec<String>,
}

/// Spectrum of one channel.
#[derive(Debug, Clone)]
pub struct ChannelSpectrum {
    /// Name of the channel.
    pub channel: String,
    /// Unit of the values.
    pub unit: String,
    /// Unit of the peak amplitudes.
    pub amplitude_unit: String,
    /// Values over the abscissa of the result.
    pub value: Vec<f64>,
    /// Peaks, the strongest first.
    pub peaks: Vec<LabelledPeak>,
    /// Rows of a spectrogram over time; each row over the abscissa of the result.
    pub spectrogram_rows: Vec<SpectrogramRow>,
    /// Speed of the shaft at the centre of each row, rad/s; empty without a shaft.
    pub speed: Vec<f64>,
}

/// Spectra of the channels with the method and the data-quality warnings.
#[derive(Debug)]
pub struct SpectrumResult {
    /// Stages with their run time, s.
    pub trace: Vec<(&'static str, f64)>,
    /// Method as text.
    pub method_text: String,
    /// Requested kind of spectrum.
    pub kind: SpectrumKind,
    /// Kind of abscissa.
    pub abscissa_kind: AbscissaKind,
    /// Abscissa values, ascending.
    pub abscissa: Vec<f64>,
    /// Spectrum of each channel.
    pub channel_spectra: Vec<ChannelSpectrum>,
    /// Quefrency range searched for harmonic families, s.
    pub quefrency_range_s: Option<(f64, f64)>,
    /// Step of the abscissa, in its unit.
    pub abscissa_step: f64,
    /// Number of independent averages.
    pub averages: Option<f64>,
    /// Bounds of the 95 % confidence interval of a density, relative to the estimate.
    pub interval: Option<(f64, f64)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Estimated spectra before conversion to the requested kind: densities, or half squared amplitudes with a bandwidth of one.
pub struct SpectrumEstimate {
    /// Method as text.
    pub method_text: String,
    /// Kind of abscissa.
    pub abscissa_kind: AbscissaKind,
    /// Density of each channel.
    pub spectra: Spectra,
    /// Rows of each channel over time, for spectrograms.
    pub spectrogram_rows: Vec<Vec<SpectrogramRow>>,
    /// Speed of the shaft at the centre of each row, rad/s; empty without a shaft.
    pub speed: Vec<f64>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Finds a channel by its name.
///
/// # Errors
/// The recording has no channel of that name.
pub fn channel<'r>(recording: &'r Recording, name: &str) -> Result<&'r Channel, Error> {
    recording.channel(name).ok_or_else(|| {
        let known: Vec<String> = recording.channels.iter().map(|c| c.name.clone()).collect();
        unknown_channel(name, &known)
    })
}
