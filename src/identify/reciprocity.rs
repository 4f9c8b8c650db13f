//! Reciprocity of a linear structure, `H_oi = H_io` (Ewins, Modal Testing, 2nd ed. (2000), §2.3): the difference of the two responses of a
//! pair of points, each excited once, is compared with their variances.

use crate::base::error::Diagnostic;
use crate::recording::frequency_responses::{FrequencyResponse, FrequencyResponses};

/// Pair of reciprocal responses and their difference.
#[derive(Debug, Clone, PartialEq)]
pub struct Reciprocity {
    /// Output and input of the first response.
    pub first: (String, String),
    /// Output and input of the second response, at the same points exchanged.
    pub second: (String, String),
    /// Rms difference of the responses relative to their rms value, over the lines of the band.
    pub difference: f64,
    /// Relative rms difference that the variances explain; `None` if a variance is unknown.
    pub explained: Option<f64>,
}

/// Ratio of the difference to that explained by the variances above which it exceeds the noise: variances of few averages are
/// uncertain by up to one half.
const NOISE_FACTOR: f64 = 1.5;

/// Largest relative difference without a warning if the variances are unknown.
const MAX_DIFFERENCE: f64 = 0.1;

impl Reciprocity {
    /// Returns `true` if the responses differ by more than their noise.
    pub fn exceeds_noise(&self) -> bool {
        self.difference > self.explained.map_or(MAX_DIFFERENCE, |e| NOISE_FACTOR * e)
    }
}

/// Reciprocal pairs of responses in `band_hz`. A point has one name as output and as input, or is a driving point `(input, output)`.
pub fn pairs(
    responses: &FrequencyResponses,
    driving_points: &[(String, String)],
    band_hz: (f64, f64),
) -> Vec<Reciprocity> {
    let point_of = |input: &str| -> String {
        let driving_point = driving_points.iter().find(|p| p.0 == input);
        driving_point.map_or(input, |p| &p.1).to_string()
    };
    let points = |f: &FrequencyResponse| {
        let input = f.input.as_ref()?;
        Some((f.output.name.clone(), point_of(&input.name)))
    };
    let list = &responses.responses;
    let mut reciprocal_pairs = Vec::new();
    for (k, f) in list.iter().enumerate() {
        for g in &list[k + 1..] {
            let (Some(a), Some(b)) = (points(f), points(g)) else {
                continue;
            };
            let is_pair = a.0 == b.1 && a.1 == b.0 && a.0 != a.1;
            if is_pair && units(f) == units(g) {
                reciprocal_pairs.extend(compare(responses, f, g, band_hz));
            }
        }
    }
    reciprocal_pairs
}

fn units(f: &FrequencyResponse) -> (&str, &str) {
    (&f.output.unit, f.input.as_ref().map_or("", |i| &i.unit))
}

fn compare(
    responses: &FrequencyResponses,
    f: &FrequencyResponse,
    g: &FrequencyResponse,
    (low, high): (f64, f64),
) -> Option<Reciprocity> {
    let in_band = |&k: &usize| {
        (low..=high).contains(&responses.frequency_hz[k]) && responses.is_determined(k)
    };
    let lines: Vec<usize> = (0..responses.frequency_hz.len()).filter(in_band).collect();
    let sum = |value: &dyn Fn(usize) -> f64| lines.iter().map(|&k| value(k)).sum::<f64>();
    let power = 0.5 * sum(&|k| f.values[k].norm_sqr() + g.values[k].norm_sqr());
    let difference = sum(&|k| (f.values[k] - g.values[k]).norm_sqr());
    let variance = f.variance.as_ref().zip(g.variance.as_ref());
    let explained = variance.map(|(v, w)| (sum(&|k| v[k] + w[k]) / power).sqrt());
    let names = |f: &FrequencyResponse| {
        let input = f.input.as_ref().map_or(String::new(), |i| i.name.clone());
        (f.output.name.clone(), input)
    };
    (power > 0.0).then(|| Reciprocity {
        first: names(f),
        second: names(g),
        difference: (difference / power).sqrt(),
        explained,
    })
}

/// Data-quality warning that lists the pairs whose difference exceeds the noise.
pub fn warning(pairs: &[Reciprocity]) -> Option<Diagnostic> {
    let differences: Vec<String> = (pairs.iter().filter(|r| r.exceeds_noise()))
        .map(|r| {
            let explained = r.explained.map_or(String::new(), |e| {
                format!(", where noise explains {:.2} %", 100.0 * e)
            });
            format!(
                "{} over {} and {} over {} by {:.2} %{explained}",
                r.first.0,
                r.first.1,
                r.second.0,
                r.second.1,
                100.0 * r.difference
            )
        })
        .collect();
    (!differences.is_empty()).then(|| Diagnostic {
        code: "not-reciprocal",
        message: format!("reciprocal responses differ: {}", differences.join("; ")),
        hint: Some("check whether force and sensor at each of the two points act along one direction, and drive both at one level: a structure that is not linear is not reciprocal".into()),
    })
}
