//! Reader of MATLAB level 5 files: assigns variables to time vectors, channels, frequency responses and spectra.

mod variables;

mod roles;

mod signals;

mod spectra;

use variables::Variables;

use super::raw::RawLog;
use super::read_options::ReadOptions;
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error, Errors};
use crate::base::mat5;

/// Maximum length of a text variable stored as metadata, characters.
const MAX_METADATA_LEN: usize = 200;

/// Maximum number of variable names in a message.
const MAX_NAMES_SHOWN: usize = 8;

/// Reads a MATLAB level 5 file.
///
/// Time is a vector named `t`, `time` or similar, else one that rises by equal steps from zero. Channels are vectors and rows or
/// columns of matrices of the same length; without a time vector they are the longest ones, at the rate of a scalar named `fs`,
/// `dt` or similar. Complex vectors as long as a frequency vector are frequency responses, with coherence if a variable of
/// that name matches; real ones are spectra.
///
/// # Errors
/// Errors of [`mat5::read::read`]; `empty-log` if no variable matches these rules.
pub fn read(path: &str, bytes: &[u8], options: &ReadOptions) -> Result<RawLog, Errors> {
    let (description, arrays) = mat5::read::read(bytes)?;
    let mut log = RawLog {
        path: path.to_string(),
        dialect: "MATLAB level 5".to_string(),
        metadata: vec![("header".to_string(), description)],
        ..RawLog::default()
    };
    let mut variables = Variables::default();
    let mut names: Vec<String> = Vec::new();
    for array in arrays {
        // Variables without a name hold the function workspace of MATLAB.
        if array.name.is_empty() {
            continue;
        }
        let earlier = names.iter().filter(|&name| *name == array.name).count();
        names.push(array.name.clone());
        let name = match earlier {
            0 => array.name.clone(),
            _ => {
                log.diagnostics.push(duplicate_variable(&array.name));
                format!("{} #{}", array.name, earlier + 1)
            }
        };
        variables.flatten(name, array);
    }
    let is_short = |(_, text): &&(String, String)| text.chars().count() <= MAX_METADATA_LEN;
    log.metadata
        .extend(variables.texts.iter().filter(is_short).cloned());
    if !variables.others.is_empty() {
        let mut others = variables
            .others
            .iter()
            .map(|(name, kind)| format!("`{name}` ({kind})"));
        log.diagnostics.push(Diagnostic {
            code: "variables-left-out",
            message: format!("not read: {}", list_names(&mut others)),
            hint: Some("in MATLAB, copy their numbers to plain arrays and save those".into()),
        });
    }
    let has_spectra = spectra::take_spectra(&mut variables.numbers, &mut log)?;
    signals::take_channels(&mut variables.numbers, options, &mut log)?;
    if !has_spectra && log.groups.is_empty() {
        return Err(no_log_data(&variables).into());
    }
    if !variables.numbers.is_empty() {
        let mut unused = variables
            .numbers
            .iter()
            .map(|v| format!("`{}` ({})", v.name, v.size_text()));
        log.diagnostics.push(Diagnostic {
            code: "variables-left-out",
            message: format!(
                "neither as long as the time nor as the frequency, not read: {}",
                list_names(&mut unused)
            ),
            hint: None,
        });
    }
    Ok(log)
}

fn duplicate_variable(name: &str) -> Diagnostic {
    Diagnostic {
        code: "name-twice",
        message: format!("the MATLAB file contains two variables named `{name}`; both are kept"),
        hint: Some(format!(
            "MATLAB itself would load the last, here `{name} #2`"
        )),
    }
}

/// Error of a file without signals and frequency responses.
fn no_log_data(variables: &Variables) -> Error {
    let numbers = variables
        .numbers
        .iter()
        .map(|v| format!("`{}` ({})", v.name, v.size_text()));
    let others = variables
        .others
        .iter()
        .map(|(name, kind)| format!("`{name}` ({kind})"));
    let mut names = numbers.chain(others).peekable();
    let contents = match names.peek() {
        None => "no numbers".to_string(),
        Some(_) => list_names(&mut names),
    };
    Error::new(
        Code::EmptyLog,
        format!("the MATLAB file contains no signals and no frequency responses, only {contents}"),
    )
    .with_hint("save the signals as plain vectors or matrices with a vector `t` in s or a scalar `fs` in Hz")
}

fn list_names(items: &mut impl Iterator<Item = String>) -> String {
    let mut shown: Vec<String> = items.by_ref().take(MAX_NAMES_SHOWN).collect();
    match items.count() {
        0 => {}
        more => shown.push(format!("and {more} more")),
    }
    shown.join(", ")
}
