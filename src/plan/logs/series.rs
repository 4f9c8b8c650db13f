//! Modes from difference equations: the order by Schwarz's criterion, the residuals tested.

use super::found::{Evidence, FoundMode, FromSignals, Orders, apart};
use super::method::{self, Method};
use super::modal::within;
use super::record::Record;
use super::running;
use super::study::IdentifyStudy;
use crate::base::code::Code;
use crate::base::error::{Error, Warning};
use crate::identify::modal::selection::SelectionRule;
use crate::identify::mode::IdentifiedMode;
use crate::identify::operational::channels::Channels;
use crate::identify::operational::harmonics::{Bands, HALF_BANDS, LINES};
use crate::identify::series::autoregressive;
use crate::identify::series::model::{Family, SeriesModel, Shares};
use crate::identify::series::order::{self, Criterion};
use crate::identify::series::record;
use crate::identify::series::residuals::{Test, cross_correlation, ljung_box};

/// The highest order of a recursion over orders, and of a linear fit for each.
const LINEAR: usize = 60;

/// The highest order where each is iterated.
pub const ITERATED: usize = 12;

/// Samples wanted for each unknown.
const SAMPLES_PER_UNKNOWN: usize = 10;

/// Lags tested beyond the coefficients.
const LAGS: usize = 20;

/// Residuals as unlikely as this leave something unmodelled.
const UNLIKELY: f64 = 0.01;

/// Identifies from an output, the last channel of the record, and from an input, the first of two.
///
/// # Errors
/// Those of the fit: too few samples, equations that do not determine the coefficients.
pub fn identify(
    method: Method,
    samples: &Record,
    band_hz: (f64, f64),
    study: &IdentifyStudy,
) -> Result<FromSignals, Error> {
    let record = of_samples(samples)?;
    let output = record.output();
    let bearable = (output.len() / SAMPLES_PER_UNKNOWN).max(2);
    let orders: Vec<usize> = match study.order {
        Some(modes) => {
            check_cost(method, 2 * modes, output.len())?;
            vec![2 * modes]
        }
        None => {
            let most = match method {
                Method::Ar | Method::Arx => LINEAR.min(bearable),
                _ => ITERATED.min(bearable),
            };
            (2..=most).step_by(2).collect()
        }
    };
    let last = orders.last().copied().unwrap_or(2);
    let (model, choice) = match (method, study.order) {
        (Method::Ar, _) => {
            let choice = order::autoregressive(&record, last, Criterion::Bic)?;
            let a = study.order.map_or(choice.family.unknowns(), |m| 2 * m);
            let model = autoregressive::fit(&record, a, autoregressive::Method::Burg)?;
            (model, choice)
        }
        _ => {
            let families: Vec<Family> = orders.iter().map(|&n| of_order(method, n)).collect();
            order::among(&record, &families, Criterion::Bic)?
        }
    };
    let mut warnings = samples.warnings.clone();
    let is_last = model.family == of_order(method, last) && orders.len() > 1;
    if is_last && !choice.is_noise {
        warnings.push(Warning {
            code: "order-limit",
            message: format!(
                "BIC still falls at {}, where the search ends",
                method::family(model.family)
            ),
            hint: Some("state a higher --order, or narrow the --band".to_string()),
        });
    }
    let (modes, omitted) = match choice.is_noise {
        true => {
            warnings.push(Warning {
                code: "no-mode",
                message: "no model has a smaller BIC than none at all: the output is noise, as far as this method sees".to_string(),
                hint: Some("look whether the channel is the right one; take a longer record".to_string()),
            });
            (Vec::new(), Vec::new())
        }
        false => told_apart(&model, &record, band_hz)?,
    };
    let (modes, harmonics) = apart(modes);
    warnings.extend(running::of_harmonics(&harmonics));
    let tests = tests(&model, &record)?;
    warnings.extend(
        tests
            .iter()
            .filter_map(|(what, test)| left_over(what, test)),
    );
    let rule = format!(
        "{} {}; {}",
        method::family(model.family),
        match study.order {
            Some(_) => "as asked",
            None => "by the smallest BIC",
        },
        root_rule()
    );
    Ok(FromSignals {
        modes,
        harmonics,
        rule,
        evidence: Evidence::Orders(Orders {
            chosen: model.family,
            candidates: std::iter::once(choice.nothing)
                .chain(choice.candidates)
                .collect(),
            omitted,
            tests,
        }),
        warnings,
    })
}

/// An output, the last channel, and an input, the first of two.
///
/// # Errors
/// Those of [`record::Record`].
pub fn of_samples(samples: &Record) -> Result<record::Record<'_>, Error> {
    match samples.samples.as_slice() {
        [input, output] => record::Record::new(output, samples.rate_hz)?.driven_by(input),
        all => record::Record::new(&all[0], samples.rate_hz),
    }
}

/// Refuses an order that the samples do not bear, or that would take too long.
pub fn check_cost(method: Method, order: usize, samples: usize) -> Result<(), Error> {
    /// Seconds worth waiting for, steps of a slow iteration, and operations a second.
    const PATIENCE: f64 = 300.0;
    const STEPS: f64 = 100.0;
    const SPEED: f64 = 1e9;
    let unknowns = of_order(method, order).unknowns();
    if unknowns * 2 > samples {
        let message = format!(
            "--order {} makes {} with {unknowns} unknowns; {samples} samples bear {} at most",
            order / 2,
            method::family(of_order(method, order)),
            samples / 2
        );
        return Err(
            Error::new(Code::TooShort, message).hint("lower --order, or take a longer record")
        );
    }
    let steps = match method {
        Method::Ar | Method::Arx => 1.0,
        _ => STEPS,
    };
    let seconds = steps * samples as f64 * (unknowns * unknowns) as f64 / SPEED;
    if seconds > PATIENCE {
        let bearable = (PATIENCE * SPEED / steps / samples as f64).sqrt() as usize;
        let per_mode = unknowns / (order / 2).max(1);
        let message = format!(
            "{} over {samples} samples would take about {seconds:.0} s",
            method::family(of_order(method, order))
        );
        return Err(Error::new(Code::Hopeless, message).hint(format!(
            "ask for {} modes at most, take a part of the record (--before), or narrow the --band, which decimates",
            (bearable / per_mode.max(1)).max(1)
        )));
    }
    Ok(())
}

/// Share of the response at its own frequency that makes a root a mode.
const AT_PEAK: f64 = 0.5;

/// Share of the power of the output below which a root is noise, whatever its shape.
const LEAST_POWER: f64 = 1e-4;

/// Roots inside the band: modes, and what is none, with the reason.
type ToldApart = (Vec<FoundMode>, Vec<(IdentifiedMode, &'static str)>);

/// Tells modes from roots that only fill up the polynomial.
fn told_apart(
    model: &SeriesModel,
    record: &record::Record,
    band_hz: (f64, f64),
) -> Result<ToldApart, Error> {
    let signals = [record.output()];
    let channels = Channels::new(&signals, model.rate_hz)?;
    // A response to a measured input may be as constant as that is.
    let bands = (record.input().is_none()).then(|| Bands::new(&channels));
    let spacing = model.rate_hz / record.output().len() as f64;
    let (mut modes, mut omitted) = (Vec::new(), Vec::new());
    for (mode, shares) in model.modes()?.into_iter().zip(model.shares()?) {
        if !within(mode.pole, band_hz) {
            continue;
        }
        if let Some(reason) = no_mode(&mode, shares) {
            omitted.push((mode, reason));
            continue;
        }
        let (damping, f) = (mode.damping_ratio(), mode.frequency_hz());
        let half = (HALF_BANDS * damping * f).max(LINES * spacing);
        let harmonic = (bands.as_ref()).map(|b| b.look(0, mode.damped_frequency_hz(), half, None));
        modes.push(FoundMode {
            harmonic,
            ..FoundMode::from(mode)
        });
    }
    Ok((modes, omitted))
}

/// Why a root is no mode.
pub fn no_mode(mode: &IdentifiedMode, shares: Shares) -> Option<&'static str> {
    let most_damping = SelectionRule::default().most_damping;
    let (damping, f) = (mode.damping_ratio(), mode.frequency_hz());
    let std = mode.frequency_std_hz().unwrap_or(0.0);
    match () {
        () if damping <= 0.0 => Some("it grows"),
        () if damping > most_damping => Some("it is damped too much for a resonance"),
        () if std > damping * f => Some("its frequency is less certain than its half-power width"),
        () if shares.at_peak < AT_PEAK || shares.power < LEAST_POWER => Some(
            "it fills up the polynomial: other roots make most of the response at its frequency",
        ),
        () => None,
    }
}

/// How roots are told from modes, in words.
pub fn root_rule() -> String {
    format!(
        "a root inside the band is a mode where its damping ratio is up to {}, its frequency known to half its bandwidth, and it makes \
         up {} % of the response at its own frequency",
        SelectionRule::default().most_damping,
        100.0 * AT_PEAK
    )
}

fn of_order(method: Method, n: usize) -> Family {
    match method {
        Method::Arma => Family::Arma { a: n, c: n - 1 },
        Method::Arx => Family::Arx {
            a: n,
            b: n + 1,
            delay: 0,
        },
        Method::Armax => Family::Armax {
            a: n,
            b: n + 1,
            c: n,
            delay: 0,
        },
        Method::OutputError => Family::OutputError {
            b: n + 1,
            f: n,
            delay: 0,
        },
        _ => Family::Ar { a: n },
    }
}

/// That residuals hold what should have been modelled, where chance does not give as much.
pub(super) fn left_over(what: &str, test: &Test) -> Option<Warning> {
    (test.probability < UNLIKELY).then(|| Warning {
        code: "residuals",
        message: format!(
            "the residuals are not {what}: chance gives as much with {}, so the intervals are too narrow",
            match test.probability < 1e-16 {
                true => "p below 1e-16".to_string(),
                false => format!("p = {:.1e}", test.probability),
            }
        ),
        hint: Some("state a higher --order, or take another family of models".to_string()),
    })
}

/// Whether residuals of a model of so many fitted coefficients are white.
pub(super) fn whiteness(residuals: &[f64], fitted: usize) -> Result<Test, Error> {
    ljung_box(residuals, fitted + LAGS, fitted)
}

/// Whether the residuals are white, and unrelated to the input.
fn tests(model: &SeriesModel, record: &record::Record) -> Result<Vec<(&'static str, Test)>, Error> {
    let all = model.residuals(record)?;
    // The first ones only start the recursion.
    let start = model.family.unknowns().min(all.len());
    let residuals = &all[start..];
    let fitted = model.a.len() + model.c.len();
    let mut tests = vec![("white", whiteness(residuals, fitted)?)];
    if let Some(input) = record.input().filter(|_| !model.b.is_empty()) {
        let test = cross_correlation(residuals, &input[start..], LAGS)?;
        tests.push(("unrelated to the input", test));
    }
    Ok(tests)
}
