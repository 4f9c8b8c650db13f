//! Tests on measured logs that are not part of the project show as ignored where their folder is absent, those of pages where no browser is installed.

use std::path::Path;

/// Where the folder of measured logs is.
const FOLDER: &str = "GEARDYN_RECORDINGS";

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed={FOLDER}");
    println!("cargo:rustc-check-cfg=cfg(recordings, chromium, firefox)");
    println!("cargo:rerun-if-env-changed=PATH");
    let path = std::env::var_os("PATH").unwrap_or_default();
    for browser in ["chromium", "firefox"] {
        if std::env::split_paths(&path).any(|folder| folder.join(browser).is_file()) {
            println!("cargo:rustc-cfg={browser}");
        }
    }
    if std::env::var_os(FOLDER).is_some_and(|folder| Path::new(&folder).is_dir()) {
        println!("cargo:rustc-cfg=recordings");
    }
}
