//! `geardyn new`: a model to start from.

use std::path::Path;

use super::{files, output};
use crate::base::code::Code;
use crate::base::error::Error;

/// The model it writes: small, annotated, and right.
pub const STARTER: &str = include_str!("starter.toml");

/// Writes the starter model; never over a file.
///
/// # Errors
/// The file exists, or cannot be written.
pub fn run(path: &Path) -> Result<u8, Error> {
    if path.symlink_metadata().is_ok() {
        let message = format!("{} exists already", path.display());
        return Err(Error::new(Code::OutputFailed, message).with_hint("name another file"));
    }
    files::write_one(path, STARTER.as_bytes())?;
    let name = path.display();
    output::print(&format!(
        "wrote {name}\nnext: `geardyn check {name}`, then `geardyn modes {name}`\n"
    ))?;
    Ok(0)
}
