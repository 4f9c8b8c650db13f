//! Tests on measured logs that are not part of the project show as ignored where their folder is absent.

use std::path::Path;

/// Where the folder of measured logs is.
const FOLDER: &str = "GEARDYN_RECORDINGS";

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed={FOLDER}");
    println!("cargo:rustc-check-cfg=cfg(recordings)");
    if std::env::var_os(FOLDER).is_some_and(|folder| Path::new(&folder).is_dir()) {
        println!("cargo:rustc-cfg=recordings");
    }
}
