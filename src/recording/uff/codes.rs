//! Codes in the header of data set 58: function type, data type, direction.
//!
//! Structural Dynamics Research Corporation, “Universal File Datasets Summary”, data set 58, function at nodal degree of
//! degree of freedom (kept in public by the University of Cincinnati, SDRL).

/// Words for the types of function, record 6 field 1.
pub(super) const FUNCTION_TYPES: &[&str] = &[
    "general",
    "time response",
    "auto spectrum",
    "cross spectrum",
    "frequency response",
    "transmissibility",
    "coherence",
    "auto correlation",
    "cross correlation",
    "power spectral density",
    "energy spectral density",
    "probability density",
    "spectrum",
    "cumulative frequency distribution",
    "peaks valley",
    "stress/cycles",
    "strain/cycles",
    "orbit",
    "mode indicator function",
    "force pattern",
    "partial power",
    "partial coherence",
    "eigenvalue",
    "eigenvector",
    "shock response spectrum",
    "finite impulse response filter",
    "multiple coherence",
    "order function",
    "phase compensation",
];

pub(super) const TYPE_GENERAL: usize = 0;
pub(in crate::recording) const TIME_RESPONSE: usize = 1;
pub(in crate::recording) const FREQUENCY_RESPONSE: usize = 4;
pub(super) const TYPE_TRANSMISSIBILITY: usize = 5;
pub(in crate::recording) const COHERENCE: usize = 6;
pub(super) const TYPE_MULTIPLE_COHERENCE: usize = 26;

/// Type of the abscissa that is time, and frequency, record 8 field 1.
pub(in crate::recording) const TIME: i64 = 17;
pub(in crate::recording) const FREQUENCY: i64 = 18;

/// Beginning and end of the header line that states the rate with all its digits.
pub(in crate::recording) const RATE_LINE: (&str, &str) = ("sample rate ", " Hz");

/// Beginning, middle and end of the header lines that state what lies behind a frequency response: the effective number of averages with
/// the rate of an exponential window on it, and the band worth fitting with how many independent lines a line of it holds.
pub(in crate::recording) const AVERAGES_LINE: [&str; 3] =
    ["effective averages ", ", exponential window ", " 1/s"];
pub(in crate::recording) const INDEPENDENCE_LINE: [&str; 3] =
    ["independent lines ", " in ", " line"];
pub(in crate::recording) const USABLE_LINE: [&str; 3] = ["usable from ", " to ", " Hz"];

/// Two numbers between the words of such a line.
pub(in crate::recording) fn pair(
    line: &str,
    [before, between, after]: [&str; 3],
) -> Option<(f64, f64)> {
    let (a, b) = line
        .strip_prefix(before)?
        .strip_suffix(after)?
        .split_once(between)?;
    let number = |text: &str| text.parse::<f64>().ok().filter(|x| x.is_finite());
    Some((number(a)?, number(b)?))
}

/// SI unit of a type of data, records 8 to 11 field 1; empty where the type does not fix it.
pub(super) fn si_unit(data_type: i64) -> &'static str {
    match data_type {
        2 | 15 | 21 => "Pa",
        5 => "°C",
        6 => "W/m²",
        8 => "m",
        9 | 13 => "N",
        11 => "m/s",
        12 => "m/s²",
        16 => "kg",
        17 => "s",
        18 => "Hz",
        19 => "rpm",
        22 => "W/m²",
        23 => "W",
        _ => "",
    }
}

/// The type of data a unit belongs to; 0, unknown, for others.
pub(in crate::recording) fn data_type(unit: &str) -> i64 {
    match unit {
        "m" | "mm" | "µm" => 8,
        "m/s" | "mm/s" => 11,
        "m/s²" | "m/s^2" | "m/s2" | "g" => 12,
        "N" | "kN" => 13,
        "Pa" | "kPa" => 15,
        "kg" => 16,
        "rpm" => 19,
        _ => 0,
    }
}

/// Direction as text: 1 is `+X`, −6 is `-RZ`; empty for a scalar.
pub(super) fn direction(code: i64) -> String {
    let axes = ["", "X", "Y", "Z", "RX", "RY", "RZ"];
    match usize::try_from(code.unsigned_abs())
        .ok()
        .and_then(|at| axes.get(at))
    {
        None | Some(&"") => String::new(),
        Some(axis) if code > 0 => format!("+{axis}"),
        Some(axis) => format!("-{axis}"),
    }
}
