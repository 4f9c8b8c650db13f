//! Answers as CSV: one row a mode, one column a freedom of its shape.

use super::words::mostly_in;
use crate::plan::prepared::Prepared;
use crate::plan::run::Answer;

/// One row a mode; a complex shape has two columns a freedom.
pub fn modes(prepared: &Prepared, answer: &Answer) -> String {
    let machine = &prepared.machine;
    let mut text = String::from(
        "mode,frequency_hz,damped_frequency_hz,damping_ratio,time_constant_s,rigid,residual,digits_trusted,mostly_in",
    );
    for i in 0..machine.freedoms.len() {
        let name = machine.freedom_name(i);
        if answer.complex {
            text += &format!(
                ",{},{}",
                quoted(&format!("{name} re")),
                quoted(&format!("{name} im"))
            );
        } else {
            text += &format!(",{}", quoted(&name));
        }
    }
    text.push('\n');
    for (k, mode) in answer.modes.iter().enumerate() {
        let swings = mode.rigid || mode.oscillates();
        let or_blank = |x: Option<f64>| x.map_or(String::new(), |x| format!("{x}"));
        let damping = if answer.complex {
            mode.damping_ratio
        } else {
            answer.energies[k].light_damping
        };
        let fields = [
            (k + 1).to_string(),
            or_blank(swings.then(|| mode.frequency_hz())),
            or_blank(swings.then(|| mode.eigenvalue.im / std::f64::consts::TAU)),
            or_blank(damping),
            or_blank((!swings).then(|| -1.0 / mode.eigenvalue.re)),
            mode.rigid.to_string(),
            format!("{:e}", mode.residual),
            or_blank(
                mode.digits
                    .is_finite()
                    .then_some((mode.digits * 10.0).floor() / 10.0),
            ),
            quoted(&mostly_in(machine, mode, &answer.energies[k])),
        ];
        text += &fields.join(",");
        for z in &mode.shape {
            text += &if answer.complex {
                format!(",{},{}", z.re, z.im)
            } else {
                format!(",{}", z.re)
            };
        }
        text.push('\n');
    }
    text
}

/// A field in quotes where it needs them (RFC 4180, sec. 2).
pub(super) fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_string()
    }
}
