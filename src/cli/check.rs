//! `geardyn check`: is a file what it means to be?

use std::path::PathBuf;

use serde_json::{Value, json};

use super::{diagnostic, output};
use crate::base::error::{Errors, Warning};
use crate::plan::prepared::Prepared;
use crate::report;
use crate::scene;

/// Checks every file; 2 where one is wrong.
///
/// # Errors
/// Standard output cannot be written.
pub fn run(files: &[PathBuf], as_json: bool) -> Result<u8, Errors> {
    let (mut exit, mut documents) = (0, Vec::new());
    for path in files {
        match check(path) {
            Ok(found) if as_json => documents.push(found.json()),
            Ok(found) => {
                output::print(&found.line())?;
                found
                    .warnings
                    .iter()
                    .for_each(|w| output::tell(&diagnostic::warning(w, diagnostic::colour())));
            }
            Err(errors) => {
                exit = exit.max(
                    errors
                        .list()
                        .iter()
                        .map(|e| e.code.exit())
                        .max()
                        .unwrap_or(2),
                );
                if as_json {
                    documents.push(diagnostic::json(&errors));
                } else {
                    output::tell(&diagnostic::errors(&errors, diagnostic::colour()));
                }
            }
        }
    }
    if as_json {
        let document = match documents.len() {
            1 => documents.remove(0),
            _ => json!({ "files": documents }),
        };
        output::print(&format!("{document:#}\n"))?;
    }
    Ok(exit)
}

struct Found {
    header: Value,
    path: String,
    title: String,
    freedoms: usize,
    stay: usize,
    elements: usize,
    rigid: usize,
    studies: usize,
    warnings: Vec<Warning>,
}

fn check(path: &std::path::Path) -> Result<Found, Errors> {
    let scene = scene::read(path)?;
    let prepared = Prepared::new(&scene.model)?;
    Ok(Found {
        header: report::json::header(&scene.sources, &[]),
        path: path.display().to_string(),
        title: scene.model.title.clone(),
        freedoms: prepared.machine.freedoms.len(),
        stay: prepared.linear.n,
        elements: prepared.machine.elements.len(),
        rigid: prepared.linear.rigid.len(),
        studies: scene.studies.len(),
        warnings: prepared.warnings(),
    })
}

impl Found {
    fn line(&self) -> String {
        let joints = match self.freedoms - self.stay {
            0 => String::new(),
            _ => format!(", {} after rigid joints", self.stay),
        };
        let studies = if self.studies > 0 {
            format!(", {} studies", self.studies)
        } else {
            String::new()
        };
        format!(
            "{}   {}\n  {} elements, {} freedoms{joints}, {} rigid-body {}{studies}\n",
            self.path,
            diagnostic::harmless(&self.title),
            self.elements,
            self.freedoms,
            self.rigid,
            if self.rigid == 1 { "mode" } else { "modes" },
        )
    }

    fn json(&self) -> Value {
        json!({
            "geardyn": self.header,
            "file": self.path,
            "title": self.title,
            "elements": self.elements,
            "freedoms": self.freedoms,
            "freedoms_after_rigid_joints": self.stay,
            "rigid_body_modes": self.rigid,
            "studies": self.studies,
            "warnings": report::json::warnings(&self.warnings),
        })
    }
}
