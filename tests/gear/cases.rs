//! Cases of `data/reference/gear` and the numbers in them.

use geardyn::internals::gear::kernel::vector::Vector;
use serde_json::Value;

/// A case of data/reference/gear.
pub fn case(name: &str) -> Value {
    let path = format!("data/reference/gear/{name}.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// The number at a JSON pointer.
pub fn number_at(value: &Value, path: &str) -> f64 {
    number(value.pointer(path).unwrap_or_else(|| panic!("{path}")))
}

/// A list of numbers; NaN for null.
pub fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().unwrap();
    list.iter()
        .map(|x| x.as_f64().unwrap_or(f64::NAN))
        .collect()
}

pub fn vector(value: &Value) -> Vector {
    let x = value.as_array().unwrap();
    Vector::new(number(&x[0]), number(&x[1]), number(&x[2]))
}
