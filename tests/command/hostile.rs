//! Hostile inputs, a row each: what is given, how the command ends, what the message names. No row may panic (exit code 101) or hang.
#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::Command;
use std::thread;

/// Arguments of every command.
mod arguments;

/// Gears and their charts.
mod gears;

/// Logs of every format, and sidecars.
mod logs;

/// Models and scenes.
mod models;

/// One hostile input.
pub struct Row {
    /// A file in the folder of the row, and what it holds.
    file: &'static str,
    bytes: Vec<u8>,
    /// The arguments: `FILE` is that file, `@` stands for the project's folder.
    line: &'static str,
    exit: i32,
    /// What standard output and standard error name between them, parted by ` | `; `@` for the project's folder.
    says: &'static str,
}

impl Row {
    /// A row of the table.
    pub fn new(
        file: &'static str,
        bytes: impl Into<Vec<u8>>,
        line: &'static str,
        exit: i32,
        says: &'static str,
    ) -> Row {
        let bytes = bytes.into();
        Row {
            file,
            bytes,
            line,
            exit,
            says,
        }
    }

    /// Runs the row in a folder of its own, next to a good model, gear and chart; says what is wrong, if anything is.
    fn wrong(&self) -> Option<String> {
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/");
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in [
            ("good.toml", models::GOOD),
            ("gear.toml", gears::GEAR),
            ("chart.csv", gears::CHART),
        ] {
            fs::write(folder.path().join(name), text).unwrap();
        }
        if !self.file.is_empty() {
            fs::write(folder.path().join(self.file), &self.bytes).unwrap();
        }
        let word = |word: &str| match word {
            "FILE" => self.file.to_string(),
            "EMPTY" => String::new(),
            word => word.replace('@', root),
        };
        let output = Command::new(env!("CARGO_BIN_EXE_geardyn"))
            .args(self.line.split(' ').map(word))
            .current_dir(folder.path())
            .env("NO_COLOR", "1")
            .output()
            .unwrap();
        let said = [output.stdout, output.stderr].concat();
        let said = String::from_utf8_lossy(&said).replace(root, "@");
        let silent: Vec<&str> = self
            .says
            .split(" | ")
            .filter(|s| !said.contains(s))
            .collect();
        let whole = names(folder.path())
            .iter()
            .all(|n| !n.starts_with(".geardyn"));
        let right = output.status.code() == Some(self.exit) && silent.is_empty() && whole;
        let start = String::from_utf8_lossy(&self.bytes[..self.bytes.len().min(80)]).into_owned();
        (!right).then(|| {
            let code = output.status.code();
            format!(
                "{} {start:?}\n  exit {code:?}, not named: {silent:?}\n{said}",
                self.line
            )
        })
    }
}

fn names(folder: &Path) -> Vec<String> {
    let name = |e: std::io::Result<fs::DirEntry>| e.unwrap().file_name();
    let names = folder.read_dir().unwrap().map(name);
    names.map(|n| n.to_string_lossy().into_owned()).collect()
}

/// Every row ends with its code and names what is wrong.
#[test]
fn refuses_hostile_inputs() {
    let rows: Vec<Row> = [
        arguments::rows(),
        models::rows(),
        logs::rows(),
        gears::rows(),
    ]
    .into_iter()
    .flatten()
    .collect();
    assert!(rows.len() >= 200, "{} rows", rows.len());
    let threads = thread::available_parallelism().map_or(1, |n| n.get());
    let share = rows.len().div_ceil(threads);
    let wrong: Vec<String> = thread::scope(|scope| {
        let run = |rows: &[Row]| rows.iter().filter_map(Row::wrong).collect::<Vec<_>>();
        let parts = rows
            .chunks(share)
            .map(|rows| scope.spawn(move || run(rows)));
        let parts: Vec<_> = parts.collect();
        parts
            .into_iter()
            .flat_map(|part| part.join().unwrap())
            .collect()
    });
    assert!(
        wrong.is_empty(),
        "{} of {}:\n{}",
        wrong.len(),
        rows.len(),
        wrong.join("\n")
    );
}

/// A file that is no model file is refused by its size before it is read: 1 GB without a block on the disk.
#[test]
fn refuses_a_model_of_a_gigabyte() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("large.toml");
    fs::File::create(&path).unwrap().set_len(1 << 30).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_geardyn"))
        .arg("check")
        .arg(&path)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        said.contains("[file-too-large]") && said.contains("1024 MB"),
        "{said}"
    );
}
