//! Compression of long number lists of a page: differences of the bit patterns, bytes ordered by significance, deflated, base 64.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::DeflateEncoder;
use serde_json::{Value, json};

use crate::numeric::statistics::extremes;

/// Shortest list that is packed; shorter ones remain numbers in the JSON document.
const MIN_LEN: usize = 256;

/// Shortest text that is packed, bytes.
const MIN_TEXT: usize = 2048;

/// Tolerance of an even grid, relative to its span.
const GRID_TOLERANCE: f64 = 1e-13;

/// Tolerance of single precision, relative to the range of the values; far below a pixel.
const TOLERANCE: f64 = 1e-6;

/// Packed columns and texts of a page.
#[derive(Debug, Default)]
pub struct Columns {
    packed: Vec<(Vec<f64>, String)>,
    texts: Vec<String>,
}

impl Columns {
    /// JSON value of a list: numbers, an even grid, or a reference to a packed column.
    pub fn value(&mut self, values: &[f64]) -> Value {
        if values.len() < MIN_LEN {
            return json!(values);
        }
        if let Some([first, last]) = even_grid(values) {
            return json!({ "grid": [first, last, values.len()] });
        }
        let same = |column: &(Vec<f64>, String)| {
            let bits = |v: &f64| v.to_bits();
            column.0.len() == values.len() && column.0.iter().map(bits).eq(values.iter().map(bits))
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

    /// JSON value of a text: the text, or a reference to a packed text.
    pub fn text(&mut self, text: &str) -> Value {
        if text.len() < MIN_TEXT {
            return json!(text);
        }
        self.texts.push(STANDARD.encode(deflate(text.as_bytes())));
        json!({ "text": self.texts.len() - 1 })
    }

    /// Packs the long number lists of a document.
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

    /// HTML elements of the packed columns and texts.
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

/// Values of a long list of numbers, null as NaN; `None` for a short or mixed list.
fn numbers(list: &[Value]) -> Option<Vec<f64>> {
    let value = |v: &Value| {
        if v.is_null() {
            Some(f64::NAN)
        } else {
            v.as_f64()
        }
    };
    let values = || list.iter().map(value).collect();
    if list.len() < MIN_LEN { None } else { values() }
}

/// First and last value of an evenly rising list; `None` otherwise.
fn even_grid(values: &[f64]) -> Option<[f64; 2]> {
    let (first, last) = (*values.first()?, *values.last()?);
    let (span, count) = (last - first, values.len() - 1);
    let is_even = |(i, v): (usize, &f64)| {
        let expected = first + span * i as f64 / count as f64;
        (v - expected).abs() <= GRID_TOLERANCE * span.max(first.abs())
    };
    (span > 0.0 && values.iter().enumerate().all(is_even)).then_some([first, last])
}

/// Whether single precision represents every value to `TOLERANCE` of their range.
fn fits_single(values: &[f64]) -> bool {
    let finite = || values.iter().filter(|v| v.is_finite());
    let (low, high) = extremes(finite().copied());
    let smallest = finite().fold(f64::INFINITY, |m, v| if *v > 0.0 { m.min(*v) } else { m });
    let limit = TOLERANCE * (high - low);
    // A logarithmic axis shows the smallest values too; subnormal single-precision numbers lose digits.
    let is_small = smallest < f64::from(f32::MIN_POSITIVE);
    !is_small && finite().all(|&v| (f64::from(v as f32) - v).abs() <= limit)
}

/// Packs values: differences of successive bit patterns, small for slowly varying values, their bytes grouped by significance, deflated,
/// base 64.
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
    let previous = std::iter::once(&0).chain(&bits);
    let differences: Vec<u64> = (bits.iter().zip(previous))
        .map(|(current, previous)| current.wrapping_sub(*previous))
        .collect();
    let shuffled: Vec<u8> = (0..size)
        .flat_map(|k| differences.iter().map(move |d| d.to_le_bytes()[k]))
        .collect();
    STANDARD.encode(deflate(&shuffled))
}

fn deflate(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = DeflateEncoder::new(Vec::new(), Compression::default());
    // Writing to a vector cannot fail.
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    /// Unpacks a column as the script of the page does.
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

    /// Packing preserves small oscillations about a large mean and non-finite values, and stores equal lists once.
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
            let unpacked = unpack(&columns.packed[0].1, single, values.len());
            assert!(unpacked[7].is_nan());
            let error = unpacked.iter().zip(&values).filter(|p| !p.1.is_nan());
            let error = error.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(error <= 2.0 * TOLERANCE * size, "{mean} {size}: {error}");
        }
    }
}
