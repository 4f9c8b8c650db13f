//! Header of data set 58: five text lines and six records of fixed columns.

use super::codes;

/// Storage format of the numbers of a set: record 7 field 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct OrdinateType {
    pub is_complex: bool,
    pub is_double: bool,
}

/// One axis: records 8 to 11.
#[derive(Debug, Clone, Default)]
pub(super) struct AxisRecord {
    pub data_type: i64,
    pub label: String,
    /// As written; empty where the file says `NONE`.
    pub unit: String,
}

/// A degree of freedom: name of the entity, node and direction.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct DofLabel {
    pub entity: String,
    pub node: i64,
    pub direction: i64,
}

impl DofLabel {
    /// `12+Z`; empty where neither node nor direction says anything.
    pub fn text(&self) -> String {
        match (self.node, self.direction) {
            (0, 0) => String::new(),
            (node, direction) => format!("{node}{}", codes::direction(direction)),
        }
    }
}

/// Contents of the eleven lines.
#[derive(Debug, Clone)]
pub(super) struct UffHeader {
    /// Lines 1 to 5; empty where the file says `NONE`.
    pub ids: [String; 5],
    pub function: usize,
    pub response: DofLabel,
    pub reference: DofLabel,
    pub ordinate_kind: OrdinateType,
    /// Values the header states; a complex one counts once.
    pub count: usize,
    pub is_even: bool,
    pub start: f64,
    pub step: f64,
    pub abscissa: AxisRecord,
    pub ordinate: AxisRecord,
    pub denominator: AxisRecord,
}

/// Reads the eleven lines; what is wrong comes with the place of its line among them, from 0.
pub(super) fn parse(lines: &[String]) -> Result<UffHeader, (usize, String)> {
    const RECORD_6: usize = 5;
    const RECORD_7: usize = 6;
    let wrong = |at: usize, message: &str| Err((at, message.to_string()));
    let [ids @ .., place, shape, abscissa, ordinate, denominator, _z] = lines else {
        return wrong(
            0,
            "the header of the data set 58 ends before its eleven lines",
        );
    };
    let mut kept = ids.iter().map(|id| trim_none(id));
    let ids: [String; 5] = std::array::from_fn(|_| kept.next().unwrap_or_default());

    let point = |from: usize| DofLabel {
        entity: trim_none(&columns(place, from, from + 10)),
        node: integer(&columns(place, from + 10, from + 20)),
        direction: integer(&columns(place, from + 20, from + 24)),
    };
    let function = integer(&columns(place, 0, 5));
    let function = usize::try_from(function)
        .map_err(|_| (RECORD_6, format!("the type of function is {function}")))?;

    let fields = record_7_fields(shape);
    let number = |field: usize| -> f64 {
        let text = fields.get(field).map(|text| text.replace(['D', 'd'], "E"));
        text.and_then(|text| text.trim().parse().ok())
            .unwrap_or(f64::NAN)
    };
    let ordinate_kind = match number(0) {
        2.0 => (false, false),
        4.0 => (false, true),
        5.0 => (true, false),
        6.0 => (true, true),
        other => {
            return Err((
                RECORD_7,
                format!("the ordinate is of type {other} where 2, 4, 5 and 6 are known"),
            ));
        }
    };
    let (count, spacing) = (number(1), number(2));
    if !(0.0..1e15).contains(&count) || count.fract() != 0.0 {
        return Err((
            RECORD_7,
            format!("the number of values is `{}`", shape.trim()),
        ));
    }
    let is_even = match spacing {
        1.0 => true,
        0.0 => false,
        _ => {
            return wrong(RECORD_7, "the abscissa is neither even (1) nor uneven (0)");
        }
    };
    let (start, step) = (number(3), number(4));
    if is_even && !(start + count * step).is_finite() {
        return Err((
            RECORD_7,
            format!(
                "start and increment of the abscissa cannot be read from `{}`",
                shape.trim()
            ),
        ));
    }
    Ok(UffHeader {
        ids,
        function,
        response: point(31),
        reference: point(56),
        ordinate_kind: OrdinateType {
            is_complex: ordinate_kind.0,
            is_double: ordinate_kind.1,
        },
        count: count as usize,
        is_even,
        start,
        step,
        abscissa: axis(abscissa),
        ordinate: axis(ordinate),
        denominator: axis(denominator),
    })
}

/// The six fields of record 7: apart by blanks where they are, else by columns (negative numbers with three digits of
/// exponent fill theirs).
fn record_7_fields(line: &str) -> Vec<String> {
    let apart: Vec<String> = line.split_whitespace().map(str::to_string).collect();
    if apart.len() >= 5 {
        return apart;
    }
    let bounds = [0, 10, 20, 30, 43, 56, 69];
    bounds
        .windows(2)
        .map(|b| columns(line, b[0], b[1]))
        .collect()
}

fn axis(line: &str) -> AxisRecord {
    AxisRecord {
        data_type: integer(&columns(line, 0, 10)),
        label: trim_none(&columns(line, 26, 46)),
        unit: trim_none(&columns(line, 47, 67)),
    }
}

/// Characters `from..to` of a line.
fn columns(line: &str, from: usize, to: usize) -> String {
    line.chars().skip(from).take(to - from).collect()
}

fn integer(field: &str) -> i64 {
    field.trim().parse().unwrap_or(0)
}

/// Without blanks around it; empty for `NONE`.
fn trim_none(field: &str) -> String {
    match field.trim().trim_matches('\0') {
        "NONE" | "None" | "none" => String::new(),
        text => text.to_string(),
    }
}
