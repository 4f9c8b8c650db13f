//! Header of data set 58: five text lines (records 1 to 5) and records 6 to 11 of fixed columns.

use super::codes;

/// Storage format of the ordinate: record 7, field 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct OrdinateType {
    pub is_complex: bool,
    pub is_double: bool,
}

/// Axis description: records 8 to 11.
#[derive(Debug, Clone, Default)]
pub(super) struct AxisRecord {
    pub data_type: i64,
    pub label: String,
    /// Unit as written; empty for `NONE`.
    pub unit: String,
}

/// Degree of freedom: entity name, node and direction.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct DofLabel {
    pub entity: String,
    pub node: i64,
    pub direction: i64,
}

impl DofLabel {
    /// Node and direction, `12+Z`; empty if neither is given.
    pub fn text(&self) -> String {
        match (self.node, self.direction) {
            (0, 0) => String::new(),
            (node, direction) => format!("{node}{}", codes::direction(direction)),
        }
    }
}

/// Header of a data set 58.
#[derive(Debug, Clone)]
pub(super) struct UffHeader {
    /// Lines 1 to 5; empty for `NONE`.
    pub ids: [String; 5],
    pub function: usize,
    pub response: DofLabel,
    pub reference: DofLabel,
    pub ordinate_kind: OrdinateType,
    /// Stated number of values; a complex value counts once.
    pub count: usize,
    pub is_uniform: bool,
    pub start: f64,
    pub step: f64,
    pub abscissa: AxisRecord,
    pub ordinate: AxisRecord,
    pub denominator: AxisRecord,
}

/// Parses the eleven lines; an error has the index of its line, from 0.
pub(super) fn parse(lines: &[String]) -> Result<UffHeader, (usize, String)> {
    const RECORD_6: usize = 5;
    const RECORD_7: usize = 6;
    let error = |at: usize, message: &str| Err((at, message.to_string()));
    let [ids @ .., dofs, form, abscissa, ordinate, denominator, _z] = lines else {
        return error(
            0,
            "the header of the data set 58 ends before its eleven lines",
        );
    };
    let mut texts = ids.iter().map(|id| trim_none(id));
    let ids: [String; 5] = std::array::from_fn(|_| texts.next().unwrap_or_default());

    let dof_label = |from: usize| DofLabel {
        entity: trim_none(&columns(dofs, from, from + 10)),
        node: integer(&columns(dofs, from + 10, from + 20)),
        direction: integer(&columns(dofs, from + 20, from + 24)),
    };
    let function = integer(&columns(dofs, 0, 5));
    let function = usize::try_from(function)
        .map_err(|_| (RECORD_6, format!("the type of function is {function}")))?;

    let fields = record_7_fields(form);
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
            format!("the number of values is `{}`", form.trim()),
        ));
    }
    let is_uniform = match spacing {
        1.0 => true,
        0.0 => false,
        _ => {
            return error(RECORD_7, "the abscissa is neither even (1) nor uneven (0)");
        }
    };
    let (start, step) = (number(3), number(4));
    if is_uniform && !(start + count * step).is_finite() {
        return Err((
            RECORD_7,
            format!(
                "start and increment of the abscissa cannot be read from `{}`",
                form.trim()
            ),
        ));
    }
    Ok(UffHeader {
        ids,
        function,
        response: dof_label(31),
        reference: dof_label(56),
        ordinate_kind: OrdinateType {
            is_complex: ordinate_kind.0,
            is_double: ordinate_kind.1,
        },
        count: count as usize,
        is_uniform,
        start,
        step,
        abscissa: axis(abscissa),
        ordinate: axis(ordinate),
        denominator: axis(denominator),
    })
}

/// Fields of record 7, split at blanks or, if there are fewer than five, by columns: negative numbers with three-digit exponents
/// fill their columns.
fn record_7_fields(line: &str) -> Vec<String> {
    let fields: Vec<String> = line.split_whitespace().map(str::to_string).collect();
    if fields.len() >= 5 {
        return fields;
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

/// The field without surrounding blanks; empty for `NONE`.
fn trim_none(field: &str) -> String {
    match field.trim().trim_matches('\0') {
        "NONE" | "None" | "none" => String::new(),
        text => text.to_string(),
    }
}
