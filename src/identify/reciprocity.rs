//! Reciprocity: of a linear structure `H_oi = H_io` (Ewins, Modal Testing, 2nd ed. (2000), §2.3). Where a pair of points was driven both
//! ways, the difference of the two responses is compared with what their variances explain.

use crate::base::error::Diagnostic;
use crate::recording::frequency_responses::{FrequencyResponse, FrequencyResponses};

/// Two responses that reciprocity makes equal.
#[derive(Debug, Clone, PartialEq)]
pub struct Reciprocity {
    /// Output and input of the first; those of the second are at the same points, exchanged.
    pub first: (String, String),
    /// Output and input of the second.
    pub second: (String, String),
    /// Root mean square difference over that of the responses, over the lines of the band.
    pub difference: f64,
    /// The same as their variances explain it; `None` where these are not known.
    pub explained: Option<f64>,
}

/// The difference is more than noise where it is so many times what the variances explain: variances of few averages are off by up
/// to a half.
const BEYOND: f64 = 1.5;

/// Without variances a difference of this share is worth a warning.
const LARGE: f64 = 0.1;

impl Reciprocity {
    /// Whether the two differ by more than their noise.
    pub fn is_broken(&self) -> bool {
        self.difference > self.explained.map_or(LARGE, |e| BEYOND * e)
    }
}

/// Every pair of points that was driven both ways. A point has one name as output and as input, or is a driving point `(input, output)`.
pub fn pairs(
    responses: &FrequencyResponses,
    driving_points: &[(String, String)],
    band_hz: (f64, f64),
) -> Vec<Reciprocity> {
    let point_of = |input: &str| -> String {
        let known = driving_points.iter().find(|p| p.0 == input);
        known.map_or(input, |p| &p.1).to_string()
    };
    let ends = |f: &FrequencyResponse| {
        let input = f.input.as_ref()?;
        Some((f.output.name.clone(), point_of(&input.name)))
    };
    let all = &responses.responses;
    let mut found = Vec::new();
    for (k, f) in all.iter().enumerate() {
        for g in &all[k + 1..] {
            let (Some(a), Some(b)) = (ends(f), ends(g)) else {
                continue;
            };
            let is_pair = a.0 == b.1 && a.1 == b.0 && a.0 != a.1;
            if is_pair && units(f) == units(g) {
                found.extend(compared(responses, f, g, band_hz));
            }
        }
    }
    found
}

fn units(f: &FrequencyResponse) -> (&str, &str) {
    (&f.output.unit, f.input.as_ref().map_or("", |i| &i.unit))
}

fn compared(
    responses: &FrequencyResponses,
    f: &FrequencyResponse,
    g: &FrequencyResponse,
    (low, high): (f64, f64),
) -> Option<Reciprocity> {
    let inside = |&k: &usize| {
        (low..=high).contains(&responses.frequency_hz[k]) && responses.is_determined(k)
    };
    let lines: Vec<usize> = (0..responses.frequency_hz.len()).filter(inside).collect();
    let sum = |of: &dyn Fn(usize) -> f64| lines.iter().map(|&k| of(k)).sum::<f64>();
    let size = 0.5 * sum(&|k| f.values[k].norm_sqr() + g.values[k].norm_sqr());
    let apart = sum(&|k| (f.values[k] - g.values[k]).norm_sqr());
    let variance = f.variance.as_ref().zip(g.variance.as_ref());
    let explained = variance.map(|(v, w)| (sum(&|k| v[k] + w[k]) / size).sqrt());
    let names = |f: &FrequencyResponse| {
        let input = f.input.as_ref().map_or(String::new(), |i| i.name.clone());
        (f.output.name.clone(), input)
    };
    (size > 0.0).then(|| Reciprocity {
        first: names(f),
        second: names(g),
        difference: (apart / size).sqrt(),
        explained,
    })
}

/// Says which pairs differ by more than their noise.
pub fn warning(all: &[Reciprocity]) -> Option<Diagnostic> {
    let broken: Vec<String> = (all.iter().filter(|r| r.is_broken()))
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
    (!broken.is_empty()).then(|| Diagnostic {
        code: "not-reciprocal",
        message: format!("responses that reciprocity makes equal differ: {}", broken.join("; ")),
        hint: Some("check whether force and sensor at each of the two points act along one direction, and drive both at one level: a structure that is not linear is not reciprocal".into()),
    })
}
