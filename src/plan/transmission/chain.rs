//! Ends of the chain that a study names, and what is moved on when the work is indexed.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::text::suggestion;
use crate::machine::components::Machine;
use crate::modes::excitation_orders::reference_dof;
use crate::plan::prepared_machine::PreparedMachine;
use crate::scene::study::{IndexingStudy, TransmissionStudy};
use crate::transmission::chain::{ChainEnds, TransmissionChain};
use crate::transmission::coincidence;

/// The chain from the driver to the output that a study names.
pub(super) fn chain_of(
    prepared_machine: &PreparedMachine,
    study: &TransmissionStudy,
) -> Result<TransmissionChain, Error> {
    let PreparedMachine {
        machine, operating, ..
    } = prepared_machine;
    let of_work = prepared_machine.work.as_ref().map(|(work, _)| work);
    let (output, against) = match (&study.output, of_work) {
        (Some(output), _) => (output, study.against.as_deref()),
        (None, Some(work)) => (&work.work.text, Some(work.cradle.text.as_str())),
        (None, None) => {
            return Err(
                Error::new(Code::Usage, "the node of the error is not stated")
                    .with_hint("state `output`, a node"),
            );
        }
    };
    let ends = ChainEnds {
        driver: match &study.driver {
            Some(name) => angle_dof(machine, name)?,
            None => reference_dof(machine)?,
        },
        output: angle_dof(machine, output)?,
        relative_to: against.map(|name| angle_dof(machine, name)).transpose()?,
    };
    if machine.errors.is_empty() {
        return Err(
            Error::new(Code::MissingKey, "no element has a declared error").with_hint(
                "write [[error]] with `on`, `cause` and `amplitude` into the model or the scene",
            ),
        );
    }
    let chain = TransmissionChain::new(machine, operating, ends)?;
    let slides = !machine.dofs[ends.output].axis.is_rotation();
    if let (true, Some(what)) = (
        slides,
        [
            ("a radius", study.radius.is_some()),
            ("indexing", study.index.is_some()),
        ]
        .iter()
        .find_map(|(what, asked)| asked.then_some(what)),
    ) {
        let message = format!("{what} is of an output that turns, and {output} slides");
        return Err(Error::new(Code::Conflict, message)
            .with_hint("omit it: the error of a slide is given in µm of its travel"));
    }
    Ok(chain)
}

/// True for every degree of freedom that moves on with the work from tooth to tooth.
pub(super) fn index_positions(
    machine: &Machine,
    chain: &TransmissionChain,
    index: &IndexingStudy,
) -> Result<Vec<bool>, Error> {
    let named = machine
        .elements
        .iter()
        .position(|e| e.name == index.element);
    let Some(element) = named else {
        let known = machine.elements.iter().map(|e| e.name.as_str());
        let hint = match suggestion(&index.element, known) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => "name a pair or a shaft of the model".to_string(),
        };
        let message = format!("there is no element `{}`", index.element);
        return Err(Error::new(Code::UnknownNode, message).with_hint(hint));
    };
    let side = coincidence::connected_side(machine, element, chain.ends.output);
    if side[chain.ends.driver] {
        let message = format!(
            "`{}` is not between the driver and the output",
            index.element
        );
        return Err(Error::new(Code::Conflict, message)
            .with_hint("name the element behind which the work is moved on: the differential"));
    }
    Ok(side)
}

/// The angle of a node, the travel of a slide.
///
/// # Errors
/// `UnknownNode`.
pub fn angle_dof(machine: &Machine, name: &str) -> Result<usize, Error> {
    machine.dof(name).ok_or_else(|| {
        let known = machine.nodes.iter().map(|node| node.name.as_str());
        let hint = match suggestion(name, known) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => "name a node of the model".to_string(),
        };
        Error::new(Code::UnknownNode, format!("there is no node `{name}`")).with_hint(hint)
    })
}
