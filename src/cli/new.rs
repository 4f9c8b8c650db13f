//! `geardyn new`: a model or a gear file to start from.

use std::path::Path;

use super::{files, output};
use crate::base::code::Code;
use crate::base::error::Error;

/// The model it writes: small, annotated, and right.
pub const STARTER: &str = include_str!("starter.toml");

/// Gear files by the kind of pair.
const GEARS: [(&str, &str); 7] = [
    (
        "cylindrical",
        include_str!("../../models/gears/helical.toml"),
    ),
    ("bevel", include_str!("../../models/gears/bevel_12_36.toml")),
    (
        "hypoid",
        include_str!("../../models/gears/hypoid_13_42.toml"),
    ),
    ("worm", include_str!("../../models/gears/worm_zi_2_40.toml")),
    (
        "crossed",
        include_str!("../../models/gears/crossed_15_24.toml"),
    ),
    (
        "non-circular",
        include_str!("../../models/gears/elliptic.toml"),
    ),
    (
        "helicoid",
        include_str!("../../models/gears/worm_zk_grinding.toml"),
    ),
];

/// Kinds of gear files that it writes.
pub fn gear_kinds() -> [&'static str; GEARS.len()] {
    GEARS.map(|(kind, _)| kind)
}

/// Writes the starter model, or the gear file of a kind; never over a file.
///
/// # Errors
/// The file exists, or cannot be written.
pub fn run(path: &Path, gear: Option<&str>) -> Result<u8, Error> {
    if path.symlink_metadata().is_ok() {
        let message = format!("{} exists already", path.display());
        return Err(Error::new(Code::OutputFailed, message).with_hint("name another file"));
    }
    let gear = GEARS.iter().find(|(kind, _)| Some(*kind) == gear);
    let (text, next) = match gear {
        Some((_, text)) => (*text, "gear"),
        None => (STARTER, "modes"),
    };
    files::write_one(path, text.as_bytes())?;
    let name = path.display();
    output::print(&format!(
        "wrote {name}\nnext: `geardyn check {name}`, then `geardyn {next} {name}`\n"
    ))?;
    Ok(0)
}
