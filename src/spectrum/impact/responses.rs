//! Responses to the hits that were accepted: sums over all, and over each.

use std::f64::consts::PI;

use super::blocks::{HitBlock, ImpactRecord};
use super::{HitResponses, MIN_NOISE_SAMPLES};
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::fft::RealFft;
use crate::spectrum::frf::{Estimator, FrfEstimate, estimate, required_pairs};
use crate::spectrum::spectra::{CrossSpectrum, Spectra};
use crate::spectrum::welch::{WelchEstimator, WelchOptions};

/// Most responses hit by hit: more hits are joined to groups, alike in size to within one.
const MAX_BY_HIT: usize = 64;

/// Fewest groups of hits, however many responses there are: seven degrees of freedom of their scatter.
const MIN_GROUPS: usize = 8;

/// Behind a pulse the force is kept for so many of its widths, and faded out over the next two.
const FORCE_WINDOW_WIDTHS: usize = 4;

/// Sums over all hits, and over each.
pub(super) struct HitSums {
    pub(super) estimate: FrfEstimate,
    pub(super) force_power: Vec<f64>,
    pub(super) hit_responses: Vec<HitResponses>,
}

impl ImpactRecord<'_> {
    pub(super) fn estimate(&self, block: usize, sigma: f64) -> Result<HitSums, Error> {
        let window: Vec<f64> = (0..block)
            .map(|j| (-sigma * j as f64 / self.rate_hz).exp())
            .collect();
        let mut fft = RealFft::new(block);
        let zero = Complex::new(0.0, 0.0);
        let mut lines = vec![vec![zero; fft.lines()]; self.channels.len()];
        let outputs: Vec<usize> = (1..self.channels.len()).collect();
        let hits = self.accepted().count();
        let mut spectra = Spectra {
            rate_hz: self.rate_hz,
            frequency_hz: (0..fft.lines())
                .map(|k| k as f64 * self.rate_hz / block as f64)
                .collect(),
            psd: vec![vec![0.0; fft.lines()]; self.channels.len()],
            cross: required_pairs(&[0], &outputs)
                .into_iter()
                .map(|pair| CrossSpectrum {
                    pair,
                    values: vec![zero; fft.lines()],
                })
                .collect(),
            bandwidth_hz: self.rate_hz / block as f64,
            blocks: hits,
            averages: Some(hits as f64),
            window_decay: sigma,
            window: None,
        };
        let groups = (MAX_BY_HIT / outputs.len().max(1))
            .max(MIN_GROUPS)
            .min(hits);
        let group = |nth: usize| nth * groups / hits;
        let mut by_hit: Vec<HitResponses> = Vec::new();
        let mut power = vec![0.0; fft.lines()];
        let places = (0..self.hits.len()).filter(|&at| self.hits[at].rejected.is_none());
        for (nth, place) in places.enumerate() {
            let cut = &self.hits[place];
            let fade = force_window(cut, block, self.force_share);
            for (channel, lines) in lines.iter_mut().enumerate() {
                let mut samples = self.response(channel, cut, cut.start..cut.start + block);
                for j in 0..block {
                    samples[j] *= window[j] * if channel == 0 { fade[j] } else { 1.0 };
                }
                fft.forward(&mut samples, lines);
                let psd = spectra.psd[channel].iter_mut().zip(lines.iter());
                psd.for_each(|(s, x)| *s += x.norm_sqr() / hits as f64);
            }
            for CrossSpectrum {
                pair,
                values: value,
            } in &mut spectra.cross
            {
                let ends = lines[pair.0].iter().zip(&lines[pair.1]);
                for (s, (x, y)) in value.iter_mut().zip(ends) {
                    *s += x.conj() * y / hits as f64;
                }
            }
            if nth == 0 || group(nth) != group(nth - 1) {
                power.fill(0.0);
                by_hit.push(HitResponses {
                    hits: Vec::new(),
                    value: vec![vec![zero; fft.lines()]; outputs.len()],
                });
            }
            if let Some(own) = by_hit.last_mut() {
                own.add(place, &lines, &mut power);
                if nth + 1 == hits || group(nth + 1) != group(nth) {
                    own.divide(&power);
                }
            }
        }
        let mut found = estimate(&spectra, &[0], &outputs, Estimator::H1)?;
        if let (1, Some(cut)) = (hits, self.accepted().next()) {
            self.error_by_noise(cut, &window, &spectra, &mut found)?;
        }
        Ok(HitSums {
            estimate: found,
            force_power: spectra.psd.swap_remove(0),
            hit_responses: by_hit,
        })
    }

    /// The variance of a single hit's responses: `(E|N_y|² + |H|² E|N_f|²)/|F|²` by the noise before the hit, or, where the record
    /// begins too near it, by what is left once the responses have decayed.
    fn error_by_noise(
        &self,
        cut: &HitBlock,
        window: &[f64],
        spectra: &Spectra,
        found: &mut FrfEstimate,
    ) -> Result<(), Error> {
        let after = cut.start + window.len()..cut.limit;
        let quiet = if cut.pre_hit.len() >= MIN_NOISE_SAMPLES {
            cut.pre_hit.clone()
        } else if spectra.window_decay == 0.0 && after.len() >= MIN_NOISE_SAMPLES {
            after
        } else {
            return Ok(());
        };
        let samples: Vec<&[f64]> = self
            .channels
            .iter()
            .map(|channel| &channel[quiet.clone()])
            .collect();
        let mut estimator = WelchEstimator::new(
            self.rate_hz,
            samples.len(),
            &[],
            &WelchOptions {
                block: (quiet.len() / 8).clamp(MIN_NOISE_SAMPLES / 2, window.len()),
                ..WelchOptions::default()
            },
        )?;
        estimator.push(&samples);
        let noise_psd = estimator.finish()?;
        let energy: f64 = window.iter().map(|w| w * w).sum();
        let fade = force_window(cut, window.len(), self.force_share);
        let weights = window.iter().zip(&fade);
        let force_energy: f64 = weights.map(|(w, f)| (w * f).powi(2)).sum();
        let noise = |channel: usize, energy: f64, f: f64| {
            0.5 * self.rate_hz
                * energy
                * interpolate(&noise_psd.frequency_hz, &noise_psd.psd[channel], f)
        };
        for function in &mut found.functions {
            let error = |(line, h): (usize, &Complex)| {
                let f = spectra.frequency_hz[line];
                let variance =
                    noise(function.output, energy, f) + h.norm_sqr() * noise(0, force_energy, f);
                variance / spectra.psd[0][line]
            };
            let variance = function.values.iter().enumerate().map(error);
            function.variance = Some(variance.collect());
        }
        Ok(())
    }
}

impl HitResponses {
    /// Adds the transforms of a hit, force first; `power` sums that of the force.
    fn add(&mut self, place: usize, lines: &[Vec<Complex>], power: &mut [f64]) {
        self.hits.push(place);
        for (value, y) in self.value.iter_mut().zip(&lines[1..]) {
            for ((sum, x), y) in value.iter_mut().zip(&lines[0]).zip(y) {
                *sum += x.conj() * y;
            }
        }
        power
            .iter_mut()
            .zip(&lines[0])
            .for_each(|(p, x)| *p += x.norm_sqr());
    }

    fn divide(&mut self, power: &[f64]) {
        for (h, p) in self.value.iter_mut().flat_map(|v| v.iter_mut().zip(power)) {
            *h = if *p > 0.0 {
                *h / p
            } else {
                Complex::new(0.0, 0.0)
            };
        }
    }
}

/// Force window: one over the requested share, or over the pulse and some widths behind it, then a quarter of a cosine down to zero.
fn force_window(cut: &HitBlock, block: usize, share: Option<f64>) -> Vec<f64> {
    let width = cut.pulse.samples.len();
    let kept = match share {
        Some(share) => (share * block as f64) as usize,
        None => cut.pulse.samples.end - cut.start + FORCE_WINDOW_WIDTHS * width,
    };
    let fade = 2 * width;
    (0..block)
        .map(|j| {
            let x = j.saturating_sub(kept) as f64 / fade as f64;
            if x < 1.0 {
                (0.5 * PI * x).cos().powi(2)
            } else {
                0.0
            }
        })
        .collect()
}

/// Straight between the lines of a table.
fn interpolate(x: &[f64], y: &[f64], at: f64) -> f64 {
    let next = x.partition_point(|&x| x < at).clamp(1, x.len() - 1);
    let share = (at - x[next - 1]) / (x[next] - x[next - 1]);
    y[next - 1] + share * (y[next] - y[next - 1])
}
