//! MATLAB files of level 5: time vectors, channels and frequency responses among the variables.

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

/// Texts of a file that are kept as facts, characters at most each.
const MAX_METADATA_LEN: usize = 200;

/// Names of variables shown in a message.
const MAX_NAMES_SHOWN: usize = 8;

/// Reads a MATLAB file of level 5 whole.
///
/// Time is a vector named `t`, `time` or the like (else one that rises by equal steps from zero); channels are the
/// vectors and the rows or columns of matrices as long as it, or where there is no time the longest ones, with the rate a
/// scalar named `fs`, `dt` or the like states. Complex vectors as long as a frequency vector are frequency responses,
/// with their coherence where a variable named so matches; real ones are spectra.
///
/// # Errors
/// Those of [`mat5::read::read`]; `empty-log` where nothing fits these rules.
pub fn read(path: &str, bytes: &[u8], options: &ReadOptions) -> Result<RawLog, Errors> {
    let (description, arrays) = mat5::read::read(bytes)?;
    let mut log = RawLog {
        path: path.to_string(),
        dialect: "MATLAB level 5".to_string(),
        metadata: vec![("header".to_string(), description)],
        ..RawLog::default()
    };
    let mut flat = Variables::default();
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
                log.diagnostics.push(duplicate_variable(&array.name));
                format!("{} #{}", array.name, before + 1)
            }
        };
        flat.flatten(name, array);
    }
    let short = |(_, text): &&(String, String)| text.chars().count() <= MAX_METADATA_LEN;
    log.metadata
        .extend(flat.texts.iter().filter(short).cloned());
    if !flat.others.is_empty() {
        let mut others = flat
            .others
            .iter()
            .map(|(name, what)| format!("`{name}` ({what})"));
        log.diagnostics.push(Diagnostic {
            code: "variables-left-out",
            message: format!("not read: {}", list_names(&mut others)),
            hint: Some("in MATLAB, put their numbers into plain arrays and save those".into()),
        });
    }
    let found = spectra::take_spectra(&mut flat.numbers, &mut log)?;
    signals::take_channels(&mut flat.numbers, options, &mut log)?;
    if !found && log.groups.is_empty() {
        return Err(no_log_data(&flat).into());
    }
    if !flat.numbers.is_empty() {
        let mut left = flat
            .numbers
            .iter()
            .map(|v| format!("`{}` ({})", v.name, v.size_text()));
        log.diagnostics.push(Diagnostic {
            code: "variables-left-out",
            message: format!(
                "neither as long as the time nor as the frequency, not read: {}",
                list_names(&mut left)
            ),
            hint: None,
        });
    }
    Ok(log)
}

fn duplicate_variable(name: &str) -> Diagnostic {
    Diagnostic {
        code: "name-twice",
        message: format!("the MATLAB file holds two variables named `{name}`; both are kept"),
        hint: Some(format!(
            "MATLAB itself would load the last, here `{name} #2`"
        )),
    }
}

/// The file holds nothing that could be a log.
fn no_log_data(flat: &Variables) -> Error {
    let numbers = flat
        .numbers
        .iter()
        .map(|v| format!("`{}` ({})", v.name, v.size_text()));
    let others = flat
        .others
        .iter()
        .map(|(name, what)| format!("`{name}` ({what})"));
    let mut all = numbers.chain(others).peekable();
    let held = match all.peek() {
        None => "no numbers".to_string(),
        Some(_) => list_names(&mut all),
    };
    Error::new(
        Code::EmptyLog,
        format!("the MATLAB file holds no signals and no frequency responses; it holds {held}"),
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
