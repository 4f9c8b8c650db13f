//! Long lists of numbers of a page: differences of their bit patterns, bytes ordered by significance, deflated, as text.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::DeflateEncoder;
use serde_json::{Value, json};

use crate::numeric::statistics::extremes;

/// Lists shorter than this stay numbers of the JSON document.
const SHORT: usize = 256;

/// Texts shorter than this stay as they are, bytes.
const SHORT_TEXT: usize = 2048;

/// Deviation of an even grid from its numbers, relative to its span.
const EVEN: f64 = 1e-13;

/// Largest rounding to single precision, as a share of the range of the values: far below a pixel.
const SINGLE: f64 = 1e-6;

/// The packed columns of a page.
#[derive(Debug, Default)]
pub struct Columns {
    packed: Vec<(Vec<f64>, String)>,
    texts: Vec<String>,
}

impl Columns {
    /// A list as it is written in the JSON document: numbers, an even grid, or a reference to a column.
    pub fn value(&mut self, values: &[f64]) -> Value {
        if values.len() < SHORT {
            return json!(values);
        }
        if let Some([first, last]) = even_grid(values) {
            return json!({ "grid": [first, last, values.len()] });
        }
        let same = |known: &(Vec<f64>, String)| {
            let bits = |v: &f64| v.to_bits();
            known.0.len() == values.len() && known.0.iter().map(bits).eq(values.iter().map(bits))
        };
        let index = match self.packed.iter().position(same) {
            Some(index) => index,
            None => {
                self.packed.push((values.to_vec(), pack(values)));
                self.packed.len() - 1
            }
        };
        json!({ "column": index, "single": fits_single(values), "length": values.len() })
    }

    /// A text as it is written in the JSON document: itself, or a reference to a packed one.
    pub fn text(&mut self, text: &str) -> Value {
        if text.len() < SHORT_TEXT {
            return json!(text);
        }
        self.texts.push(STANDARD.encode(deflate(text.as_bytes())));
        json!({ "text": self.texts.len() - 1 })
    }

    /// A document with its long lists of numbers packed.
    pub fn pack(&mut self, document: &Value) -> Value {
        match document {
            Value::Array(list) => match numbers(list) {
                Some(values) => self.value(&values),
                None => list.iter().map(|v| self.pack(v)).collect(),
            },
            Value::Object(map) => {
                let entries = map.iter().map(|(key, v)| (key.clone(), self.pack(v)));
                Value::Object(entries.collect())
            }
            other => other.clone(),
        }
    }

    /// The elements of the page that hold the columns.
    pub fn elements(&self) -> String {
        let element = |(id, index, text): (&str, usize, &String)| {
            format!("<script type=\"text/plain\" id=\"{id}{index}\">{text}</script>\n")
        };
        let columns = self.packed.iter().enumerate();
        let columns = columns.map(|(k, (_, text))| ("column", k, text));
        let texts = self.texts.iter().enumerate();
        let texts = texts.map(|(k, text)| ("text", k, text));
        columns.chain(texts).map(element).collect()
    }
}

/// The values of a long list of nothing but numbers; missing ones become NaN.
fn numbers(list: &[Value]) -> Option<Vec<f64>> {
    let value = |v: &Value| {
        if v.is_null() {
            Some(f64::NAN)
        } else {
            v.as_f64()
        }
    };
    let values = || list.iter().map(value).collect();
    if list.len() < SHORT { None } else { values() }
}

/// First and last value of an evenly rising list.
fn even_grid(values: &[f64]) -> Option<[f64; 2]> {
    let (first, last) = (*values.first()?, *values.last()?);
    let (span, count) = (last - first, values.len() - 1);
    let is_even = |(i, v): (usize, &f64)| {
        let expected = first + span * i as f64 / count as f64;
        (v - expected).abs() <= EVEN * span.max(first.abs())
    };
    (span > 0.0 && values.iter().enumerate().all(is_even)).then_some([first, last])
}

/// Single precision keeps every value to a share of their range that no picture shows.
fn fits_single(values: &[f64]) -> bool {
    let known = || values.iter().filter(|v| v.is_finite());
    let (low, high) = extremes(known().copied());
    let least = known().fold(f64::INFINITY, |m, v| if *v > 0.0 { m.min(*v) } else { m });
    let limit = SINGLE * (high - low);
    // On a logarithmic axis the smallest value counts as much; below the least normal number digits are lost.
    let is_small = least < f64::from(f32::MIN_POSITIVE);
    !is_small && known().all(|&v| (f64::from(v as f32) - v).abs() <= limit)
}

/// The difference of the bit pattern of each value to the one before, which is small where values vary slowly: of all differences the first
/// bytes, the second bytes and so on; deflated, in base 64.
fn pack(values: &[f64]) -> String {
    let (size, bits): (usize, Vec<u64>) = match fits_single(values) {
        true => (
            4,
            values
                .iter()
                .map(|v| u64::from((*v as f32).to_bits()))
                .collect(),
        ),
        false => (8, values.iter().map(|v| v.to_bits()).collect()),
    };
    let before = std::iter::once(&0).chain(&bits);
    let differences: Vec<u64> = (bits.iter().zip(before))
        .map(|(now, before)| now.wrapping_sub(*before))
        .collect();
    let shuffled: Vec<u8> = (0..size)
        .flat_map(|k| differences.iter().map(move |d| d.to_le_bytes()[k]))
        .collect();
    STANDARD.encode(deflate(&shuffled))
}

fn deflate(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = DeflateEncoder::new(Vec::new(), Compression::default());
    // A list of bytes takes everything.
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    /// Values of a column as the page reads them.
    fn unpack(text: &str, single: bool, count: usize) -> Vec<f64> {
        let mut bytes = Vec::new();
        let packed = STANDARD.decode(text).unwrap();
        flate2::read::DeflateDecoder::new(&packed[..])
            .read_to_end(&mut bytes)
            .unwrap();
        let size = if single { 4 } else { 8 };
        let byte = |i: usize, k: usize| if k < size { bytes[k * count + i] } else { 0 };
        let mut bits = 0u64;
        (0..count)
            .map(|i| {
                let difference = u64::from_le_bytes(std::array::from_fn(|k| byte(i, k)));
                bits = bits.wrapping_add(difference);
                match single {
                    true => f64::from(f32::from_bits(bits as u32)),
                    false => f64::from_bits(bits),
                }
            })
            .collect()
    }

    #[test]
    fn keeps_short_lists_and_grids() {
        let mut columns = Columns::default();
        assert_eq!(columns.value(&[1.0, 2.5]), json!([1.0, 2.5]));
        let grid: Vec<f64> = (0..1000).map(|i| 0.1 * f64::from(i)).collect();
        assert_eq!(columns.value(&grid)["grid"][2], json!(1000));
        assert!(columns.elements().is_empty());
    }

    /// Small motion about a large mean keeps its digits; equal lists are stored once; what is not finite stays so.
    #[test]
    fn law_values_survive_packing() {
        let wave = |mean: f64, size: f64| -> Vec<f64> {
            (0..4000)
                .map(|i| mean + size * (0.01 * f64::from(i)).sin())
                .collect()
        };
        for (mean, size) in [(0.0, 1.0), (1e-4, 1e-11), (235.0, 1e-6), (0.0, 1e-45)] {
            let mut columns = Columns::default();
            let mut values = wave(mean, size);
            values[7] = f64::NAN;
            let value = columns.value(&values);
            assert_eq!(columns.value(&values)["column"], value["column"]);
            assert_eq!(columns.packed.len(), 1);
            let single = value["single"].as_bool().unwrap();
            let found = unpack(&columns.packed[0].1, single, values.len());
            assert!(found[7].is_nan());
            let off = found.iter().zip(&values).filter(|p| !p.1.is_nan());
            let off = off.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off <= 2.0 * SINGLE * size, "{mean} {size}: {off}");
        }
    }
}
