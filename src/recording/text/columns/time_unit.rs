//! Unit of time stamps: as stated, or from the magnitude of Unix epoch values.

/// Seconds of a unit of time.
pub(super) fn unit_seconds(unit: &str) -> Option<f64> {
    Some(match unit.trim().to_lowercase().as_str() {
        "s" | "sec" | "secs" | "second" | "seconds" | "sekunden" | "秒" => 1.0,
        "ms" | "msec" | "milliseconds" | "毫秒" => 1e-3,
        "us" | "µs" | "μs" | "usec" | "microseconds" | "微秒" => 1e-6,
        "ns" | "nanoseconds" => 1e-9,
        "min" | "minutes" => 60.0,
        "h" | "hours" => 3600.0,
        _ => return None,
    })
}

/// Seconds of one unit of time stamps without a unit: those since 1970 tell theirs by their size.
pub(super) fn epoch_unit_s(sample: &[f64]) -> f64 {
    match sample
        .iter()
        .copied()
        .find(|x| x.is_finite())
        .unwrap_or(0.0)
    {
        t if t > 1e17 => 1e-9,
        t if t > 1e14 => 1e-6,
        t if t > 1e11 => 1e-3,
        _ => 1.0,
    }
}

pub(super) fn unit_name(unit_s: f64) -> String {
    let known = [(1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns")];
    let word = known.iter().find(|(seconds, _)| *seconds == unit_s);
    word.map_or("s", |(_, word)| word).to_string()
}
