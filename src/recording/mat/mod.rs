//! MATLAB files of level 5: which variable is time, which are channels, which are frequency responses.

/// Variables under the names they are reached by.
mod variables;

/// What a variable is, by its name and its numbers.
mod roles;

/// Channels over their time vectors.
mod signals;

/// Responses and spectra over a frequency vector.
mod spectra;

use variables::Flat;

use super::raw::Raw;
use super::settings::Settings;
use crate::base::code::Code;
use crate::base::error::{Error, Errors, Warning};
use crate::base::mat5;

/// Texts of a file that are kept as facts, characters at most each.
const LONGEST_FACT: usize = 200;

/// Names of variables shown in a message.
const SHOWN: usize = 8;

/// Reads a MATLAB file of level 5 whole.
///
/// Time is a vector named `t`, `time` or the like (else one that rises by equal steps from zero); channels are the
/// vectors and the rows or columns of matrices as long as it, or where there is no time the longest ones, with the rate a
/// scalar named `fs`, `dt` or the like states. Complex vectors as long as a frequency vector are frequency responses,
/// with their coherence where a variable named so matches; real ones are spectra.
///
/// # Errors
/// Those of [`mat5::read::read`]; `empty-log` where nothing fits these rules.
pub fn read(path: &str, bytes: &[u8], settings: &Settings) -> Result<Raw, Errors> {
    let (description, arrays) = mat5::read::read(bytes)?;
    let mut raw = Raw {
        path: path.to_string(),
        dialect: "MATLAB level 5".to_string(),
        facts: vec![("header".to_string(), description)],
        ..Raw::default()
    };
    let mut flat = Flat::default();
    let mut names: Vec<String> = Vec::new();
    for array in arrays {
        // Variables without a name are MATLAB's own workspace of functions.
        if array.name.is_empty() {
            continue;
        }
        let before = names.iter().filter(|&name| *name == array.name).count();
        names.push(array.name.clone());
        let name = match before {
            0 => array.name.clone(),
            _ => {
                raw.warnings.push(twice(&array.name));
                format!("{} #{}", array.name, before + 1)
            }
        };
        flat.walk(name, array);
    }
    let short = |(_, text): &&(String, String)| text.chars().count() <= LONGEST_FACT;
    raw.facts.extend(flat.texts.iter().filter(short).cloned());
    if !flat.others.is_empty() {
        let mut others = flat
            .others
            .iter()
            .map(|(name, what)| format!("`{name}` ({what})"));
        raw.warnings.push(Warning {
            code: "variables-left-out",
            message: format!("not read: {}", listed(&mut others)),
            hint: Some("in MATLAB, put their numbers into plain arrays and save those".into()),
        });
    }
    let found = spectra::take(&mut flat.numbers, &mut raw)?;
    signals::take(&mut flat.numbers, settings, &mut raw)?;
    if !found && raw.groups.is_empty() {
        return Err(nothing(&flat).into());
    }
    if !flat.numbers.is_empty() {
        let mut left = flat
            .numbers
            .iter()
            .map(|v| format!("`{}` ({})", v.name, v.size()));
        raw.warnings.push(Warning {
            code: "variables-left-out",
            message: format!(
                "neither as long as the time nor as the frequency, not read: {}",
                listed(&mut left)
            ),
            hint: None,
        });
    }
    Ok(raw)
}

fn twice(name: &str) -> Warning {
    Warning {
        code: "name-twice",
        message: format!("the MATLAB file holds two variables named `{name}`; both are kept"),
        hint: Some(format!(
            "MATLAB itself would load the last, here `{name} #2`"
        )),
    }
}

/// The file holds nothing that could be a log.
fn nothing(flat: &Flat) -> Error {
    let numbers = flat
        .numbers
        .iter()
        .map(|v| format!("`{}` ({})", v.name, v.size()));
    let others = flat
        .others
        .iter()
        .map(|(name, what)| format!("`{name}` ({what})"));
    let mut all = numbers.chain(others).peekable();
    let held = match all.peek() {
        None => "no numbers".to_string(),
        Some(_) => listed(&mut all),
    };
    Error::new(
        Code::EmptyLog,
        format!("the MATLAB file holds no signals and no frequency responses; it holds {held}"),
    )
    .hint("save the signals as plain vectors or matrices with a vector `t` in s or a scalar `fs` in Hz")
}

fn listed(items: &mut impl Iterator<Item = String>) -> String {
    let mut shown: Vec<String> = items.by_ref().take(SHOWN).collect();
    match items.count() {
        0 => {}
        more => shown.push(format!("and {more} more")),
    }
    shown.join(", ")
}
