//! Modes as CSV: one row per mode, one column per degree of freedom.

use super::mode_text::dominant_elements_text;
use crate::plan::modes_run::ModesResult;
use crate::plan::prepared_machine::PreparedMachine;

/// One row a mode; a complex shape has two columns a degree of freedom.
pub fn modes(prepared_machine: &PreparedMachine, result: &ModesResult) -> String {
    let machine = &prepared_machine.machine;
    let mut text = String::from(
        "mode,frequency_hz,damped_frequency_hz,damping_ratio,time_constant_s,rigid,residual,digits_trusted,mostly_in",
    );
    for i in 0..machine.dofs.len() {
        let name = machine.dof_name(i);
        if result.complex {
            text += &format!(
                ",{},{}",
                csv_field(&format!("{name} re")),
                csv_field(&format!("{name} im"))
            );
        } else {
            text += &format!(",{}", csv_field(&name));
        }
    }
    text.push('\n');
    for (k, mode) in result.modes.iter().enumerate() {
        let swings = mode.rigid || mode.is_oscillatory();
        let or_blank = |x: Option<f64>| x.map_or(String::new(), |x| format!("{x}"));
        let damping = if result.complex {
            mode.damping_ratio
        } else {
            result.energies[k].estimated_damping_ratio
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
                mode.trusted_digits
                    .is_finite()
                    .then_some((mode.trusted_digits * 10.0).floor() / 10.0),
            ),
            csv_field(&dominant_elements_text(machine, mode, &result.energies[k])),
        ];
        text += &fields.join(",");
        for z in &mode.shape {
            text += &if result.complex {
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
pub(super) fn csv_field(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_string()
    }
}
