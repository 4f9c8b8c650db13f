//! Modal masses of identified modes, where the driving point is named or found by its name.

use std::f64::consts::PI;

use super::identification_result::{DrivingPoint, IdentificationResult};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::text::quoted_list;
use crate::identify::modal_mass::modal_mass;
use crate::identify::transfer::function::TransferFunction;
use crate::recording::channel_names;
use crate::recording::channel_unit::{self, ChannelUnit};
use crate::recording::frequency_responses::FrequencyResponses;

/// Phase beyond which a modal mass is none, rad.
const MAX_PHASE_DEVIATION: f64 = PI / 6.0;

/// A component of the shape below which its phase tells nothing.
const MIN_SHAPE_COMPONENT: f64 = 0.1;

/// Gives every mode its modal mass, where the driving point is named (`OUTPUT`, or `INPUT=OUTPUT` with several inputs) or a response
/// has one name on both sides.
///
/// # Errors
/// `no-channel` for a name that is not there; `conflict` where force and motion do no work on each other; `usage` where several inputs
/// leave the one meant open.
pub fn add_modal_masses(found: &mut IdentificationResult, word: Option<&str>) -> Result<(), Error> {
    let Some(at) = driving_function(found, word)? else {
        return Ok(());
    };
    let function = &found.functions[at];
    let (input, output) = (function.input.clone().unwrap_or_default(), &function.output);
    let Some((factor, derivative, unit)) = si_factors(&input.unit, &output.unit)? else {
        if word.is_some() {
            found.diagnostics.push(Diagnostic {
                code: "uncalibrated",
                message: format!(
                    "the units of {} and {} are not those of force and motion: no modal mass",
                    input.name, output.name
                ),
                hint: Some("state them: --unit, or in the sidecar".into()),
            });
        }
        return Ok(());
    };
    let place = found.outputs.iter().position(|o| o.name == output.name);
    let point = DrivingPoint {
        input: input.name,
        output: output.name.clone(),
        unit,
    };
    let mut turned = Vec::new();
    for (k, mode) in found.modes.iter_mut().enumerate() {
        let Some(&here) = place.and_then(|p| mode.mode.shape.get(p)) else {
            continue;
        };
        mode.modal_mass =
            modal_mass(mode.mode.pole, here, function, derivative).map(|m| m / factor);
        if here.norm() > MIN_SHAPE_COMPONENT
            && mode
                .modal_mass
                .is_some_and(|m| m.arg().abs() > MAX_PHASE_DEVIATION)
        {
            turned.push((k + 1).to_string());
        }
    }
    if !turned.is_empty() {
        found.diagnostics.push(Diagnostic {
            code: "driving-point",
            message: format!(
                "modal masses of modes {} have a phase of more than 30°: {} is not at the point and in the direction of {}, or shapes are complex",
                turned.join(", "),
                point.output,
                point.input
            ),
            hint: Some("check the directions of force and sensor; a reversed sensor gives negative masses".into()),
        });
    }
    found.driving_point = Some(point);
    Ok(())
}

/// Input and output at each driving point that is named with both.
///
/// # Errors
/// `no-channel`.
pub fn driving_points(
    responses: &FrequencyResponses,
    words: &[String],
) -> Result<Vec<(String, String)>, Error> {
    let functions = &responses.responses;
    let inputs = functions.iter().filter_map(|f| f.input.as_ref());
    let inputs: Vec<String> = inputs.map(|i| i.name.clone()).collect();
    let outputs: Vec<String> = functions.iter().map(|f| f.output.name.clone()).collect();
    let named = |word: &str, known: &[String]| {
        let at = channel_names::find_channel(word, known).ok_or_else(|| not_in_fit(word, known))?;
        Ok(known[at].clone())
    };
    (words.iter().filter_map(|word| word.split_once('=')))
        .filter(|_| words.len() > 1)
        .map(|(input, output)| Ok((named(input, &inputs)?, named(output, &outputs)?)))
        .collect()
}

/// SI size of one unit of receptance, how often the motion was differentiated, and the unit of the mass; `None` for unknown units.
fn si_factors(input: &str, output: &str) -> Result<Option<(f64, u8, &'static str)>, Error> {
    use channel_unit::MeasuredQuantity::{
        Angle, AngularAcceleration, AngularVelocity, Force, Torque,
    };
    let (Some(drive), Some(answer)) = (channel_unit::parse(input), channel_unit::parse(output))
    else {
        return Ok(None);
    };
    let (Some(derivative), true) = (
        answer.quantity.time_derivative_order(),
        drive.quantity.is_excitation(),
    ) else {
        return Ok(None);
    };
    let turns =
        |q: ChannelUnit| matches!(q.quantity, Angle | AngularVelocity | AngularAcceleration);
    let unit = match (drive.quantity, turns(answer)) {
        (Force, false) => "kg",
        (Torque, true) => "kg·m²",
        _ => {
            let message = format!("{input} does no work on {output}: no driving point");
            return Err(Error::new(Code::Conflict, message)
                .with_hint("take the motion along the force, or the angle about the torque"));
        }
    };
    Ok(Some((answer.factor / drive.factor, derivative, unit)))
}

/// The transfer function at the driving point.
fn driving_function(
    found: &IdentificationResult,
    word: Option<&str>,
) -> Result<Option<usize>, Error> {
    let functions = &found.functions;
    let same = |f: &TransferFunction| f.input.as_ref().is_some_and(|i| i.name == f.output.name);
    let Some(word) = word else {
        return Ok(functions.iter().position(same));
    };
    let outputs: Vec<String> = found.outputs.iter().map(|o| o.name.clone()).collect();
    let (input, output) = match (
        channel_names::find_channel(word, &outputs),
        word.split_once('='),
    ) {
        (None, Some((input, output))) => (Some(input), output),
        _ => (None, word),
    };
    let at = channel_names::find_channel(output, &outputs)
        .ok_or_else(|| not_in_fit(output, &outputs))?;
    let drives = |f: &TransferFunction| match (input, &f.input) {
        (Some(word), Some(i)) => {
            channel_names::find_channel(word, std::slice::from_ref(&i.name)).is_some()
        }
        (Some(_), None) => false,
        (None, _) => true,
    };
    let mut fitting = (0..functions.len())
        .filter(|&k| functions[k].output.name == outputs[at] && drives(&functions[k]));
    match (fitting.next(), fitting.next()) {
        (Some(only), None) => Ok(Some(only)),
        (Some(_), Some(_)) => Err(Error::new(
            Code::Usage,
            format!(
                "there are several inputs: --driving-point {word} does not name the one that acts there"
            ),
        )
        .with_hint(format!("give --driving-point INPUT={word}"))),
        // Modes without transfer functions have no residues to scale by.
        (None, _) if functions.is_empty() => Ok(None),
        (None, _) => {
            let inputs: Vec<String> = (functions.iter())
                .filter_map(|f| f.input.as_ref().map(|i| i.name.clone()))
                .collect();
            Err(not_in_fit(input.unwrap_or(word), &inputs))
        }
    }
}

/// Error for a channel that is none of the inputs or outputs of the fit.
fn not_in_fit(name: &str, channels: &[String]) -> Error {
    let list = quoted_list(channels.iter().map(String::as_str));
    Error::new(
        Code::NoChannel,
        format!("\"{name}\" is not a channel of the fit: it has {list}"),
    )
    .with_hint("name the channel in --input or --output too")
}
