//! Output files and interrupts: a file is replaced whole or not at all, devices and pipes are written through, links stay links.
#![cfg(target_os = "linux")]

use std::ffi::OsStr;
use std::fs::{self, File};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

use serde_json::Value;

/// Every command that writes files: its arguments with `OUT` for the file, and how the file's name ends.
const WRITERS: &[(&str, &str)] = &[
    ("modes models/two_disc.toml --csv OUT", "csv"),
    ("modes models/two_disc.toml --svg OUT", "svg"),
    ("modes models/two_disc.toml --html OUT", "html"),
    ("run examples/tip_relief_plain.toml --html OUT", "html"),
    ("modes models/geared_damped.toml --state-space OUT", "json"),
    ("simulate examples/linear_chain.toml --csv OUT", "csv"),
    ("simulate examples/linear_chain.toml --svg OUT", "svg"),
    ("accuracy examples/linear_chain.toml --csv OUT", "csv"),
    ("accuracy examples/linear_chain.toml --svg OUT", "svg"),
    ("stability examples/linear_chain.toml --csv OUT", "csv"),
    ("stability examples/linear_chain.toml --svg OUT", "svg"),
    (
        "response models/y2250.toml --input motor --output workpiece --csv OUT",
        "csv",
    ),
    (
        "response models/y2250.toml --input motor --output workpiece --svg OUT",
        "svg",
    ),
    (
        "response models/y2250.toml --run-up 50:3000:120 --csv OUT",
        "csv",
    ),
    (
        "response models/y2250.toml --run-up 50:3000:120 --svg OUT",
        "svg",
    ),
    (
        "response examples/backlash_jumps.toml --harmonic-balance 2000:7000:60 --csv OUT",
        "csv",
    ),
    (
        "response examples/backlash_jumps.toml --harmonic-balance 2000:7000:60 --svg OUT",
        "svg",
    ),
    ("measure data/index_gear.toml --csv OUT", "csv"),
    ("measure data/index_gear.toml --svg OUT", "svg"),
    (
        "te models/three_stage_chain.toml --output spindle --csv OUT",
        "csv",
    ),
    (
        "te models/three_stage_chain.toml --output spindle --svg OUT",
        "svg",
    ),
    (
        "te models/three_stage_chain.toml --output spindle --window 1 --record OUT",
        "csv",
    ),
    (
        "te data/y2250_te.csv --input index_gear_1 --output work_spindle --teeth 30:37,54:36,1:90 --lines 10000,36000 --csv OUT",
        "csv",
    ),
    (
        "te data/y2250_te.csv --input index_gear_1 --output work_spindle --teeth 30:37,54:36,1:90 --lines 10000,36000 --svg OUT",
        "svg",
    ),
    (
        "identify data/spindle_impact.csv --input force --output ax --csv OUT",
        "csv",
    ),
    (
        "identify data/spindle_impact.csv --input force --output ax --svg OUT",
        "svg",
    ),
    (
        "identify data/spindle_impact.csv --input force --output ax --export OUT",
        "mat",
    ),
    (
        "identify data/spindle_impact.csv --input force --output ax --frf OUT",
        "uff",
    ),
    (
        "spectrum data/spindle_impact.csv --channel ax --csv OUT",
        "csv",
    ),
    (
        "spectrum data/spindle_impact.csv --channel ax --svg OUT",
        "svg",
    ),
    ("convert data/spindle_impact.csv --to OUT", "csv"),
    ("new OUT", "toml"),
];

fn geardyn() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_geardyn"));
    command
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .env("NO_COLOR", "1");
    command
}

/// Runs a line of arguments with `OUT` in place of a file.
fn run(line: &str, out: &Path) -> Output {
    let word = |word: &str| match word {
        "OUT" => out.as_os_str().to_owned(),
        _ => word.into(),
    };
    geardyn().args(line.split(' ').map(word)).output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&[output.stdout.clone(), output.stderr.clone()].concat()).into_owned()
}

/// The names in a folder, sorted.
fn names(folder: &Path) -> Vec<String> {
    let name = |e: std::io::Result<fs::DirEntry>| e.unwrap().file_name().into_string().unwrap();
    let mut all: Vec<String> = folder.read_dir().unwrap().map(name).collect();
    all.sort();
    all
}

/// Links to nothing and in circles, folders and read-only files are refused by every output flag before any work, and stay.
#[test]
fn refuses_outputs_that_do_not_resolve() {
    for (line, end) in WRITERS {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(format!("{name}.{end}"));
        symlink("nowhere/file", at("dangling")).unwrap();
        symlink(at("b"), at("a")).unwrap();
        symlink(at("a"), at("b")).unwrap();
        fs::create_dir(at("folder")).unwrap();
        fs::write(at("fixed"), "old").unwrap();
        let mut rights = at("fixed").metadata().unwrap().permissions();
        rights.set_readonly(true);
        fs::set_permissions(at("fixed"), rights).unwrap();
        let before = names(folder.path());
        for (name, word) in [
            ("dangling", "does not resolve"),
            ("a", "does not resolve"),
            ("folder", "is a folder"),
            ("fixed", "read-only"),
        ] {
            let output = run(line, &at(name));
            let said = said(&output);
            assert_eq!(output.status.code(), Some(2), "{line} {name}: {said}");
            let new = line.starts_with("new") && said.contains("exists already");
            assert!(new || said.contains(word), "{line} {name}: {said}");
        }
        assert_eq!(names(folder.path()), before, "{line}");
        assert!(at("dangling").is_symlink() && at("a").is_symlink());
        assert_eq!(fs::read_to_string(at("fixed")).unwrap(), "old");
    }
}

const CSV: &str = "modes models/two_disc.toml --csv OUT";

/// A link stays a link: the file it leads to is replaced whole, a device is written through.
#[test]
fn law_links_stay_links() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("file.csv"), "old").unwrap();
    for (link, target) in [("link.csv", "file.csv"), ("null.csv", "/dev/null")] {
        symlink(target, at(link)).unwrap();
        let output = run(CSV, &at(link));
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        assert_eq!(at(link).read_link().unwrap(), Path::new(target));
    }
    let rows = fs::read_to_string(at("file.csv")).unwrap();
    assert!(rows.starts_with("mode,frequency_hz"), "{rows}");
    assert_eq!(names(folder.path()), ["file.csv", "link.csv", "null.csv"]);
}

/// `/dev/stdout` is standard output, be it a pipe, a file, or a file that has lost its name; what is printed follows.
#[test]
fn law_standard_output_is_written_through() {
    let piped = run(CSV, Path::new("/dev/stdout"));
    let both = String::from_utf8(piped.stdout).unwrap();
    assert!(
        both.starts_with("mode,frequency_hz") && both.contains("rigid body"),
        "{both}"
    );
    let folder = tempfile::tempdir().unwrap();
    for (name, nameless) in [("out.txt", false), ("gone.txt", true)] {
        let path = folder.path().join(name);
        let file = File::options()
            .create(true)
            .truncate(true)
            .read(true)
            .write(true)
            .open(&path)
            .unwrap();
        if nameless {
            fs::remove_file(&path).unwrap();
        }
        let mut link = folder.path().join("link.csv");
        let _ = fs::remove_file(&link);
        symlink("/dev/stdout", &link).unwrap();
        if nameless {
            link = "/dev/stdout".into();
        }
        let status = geardyn()
            .args(["modes", "models/two_disc.toml", "--csv"])
            .arg(&link)
            .stdout(file.try_clone().unwrap())
            .stderr(Stdio::null())
            .status()
            .unwrap();
        assert_eq!(status.code(), Some(0));
        let mut text = String::new();
        use std::io::{Read, Seek};
        let mut file = file;
        file.rewind().unwrap();
        file.read_to_string(&mut text).unwrap();
        assert_eq!(text, both, "{name}");
    }
    assert!(Path::new("/dev/stdout").is_symlink());
}

/// Standard output takes the document of `--json` and no output file next to it; the null device takes anything.
#[test]
fn refuses_a_file_and_a_document_on_standard_output() {
    for (line, stream) in [
        ("modes models/two_disc.toml --json --csv", "/dev/stdout"),
        (
            "response models/y2250.toml --input motor --output workpiece --json --csv",
            "/dev/fd/1",
        ),
        (
            "spectrum data/spindle_impact.csv --channel ax --json --csv",
            "/proc/self/fd/1",
        ),
        (
            "identify data/spindle_impact.csv --input force --output ax --json --frf",
            "/dev/stdout",
        ),
    ] {
        let output = started(&format!("{line} {stream}"))
            .wait_with_output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2), "{line}: {}", said(&output));
        let found: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(found["errors"][0]["code"], "usage", "{line}");
        assert!(
            found["errors"][0]["message"]
                .as_str()
                .unwrap()
                .contains(stream)
        );
    }
    let output = geardyn()
        .args("modes models/two_disc.toml --json --csv /dev/null".split(' '))
        .stdout(File::options().write(true).open("/dev/null").unwrap())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
}

/// All files of a run are complete before the first takes its name.
#[test]
fn law_no_file_appears_where_another_fails() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("modes.csv"), "old").unwrap();
    symlink("/dev/full", at("full.json")).unwrap();
    let line = format!(
        "modes models/geared_damped.toml --csv OUT --state-space {} --json",
        at("full.json").display()
    );
    let output = run(&line, &at("modes.csv"));
    assert_eq!(output.status.code(), Some(2));
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["errors"][0]["code"], "output-failed");
    assert_eq!(fs::read_to_string(at("modes.csv")).unwrap(), "old");
    assert_eq!(names(folder.path()), ["full.json", "modes.csv"]);
}

/// A run removes what a killed one left in the folder, and nothing that another run still writes.
#[test]
fn law_temporary_files_of_killed_runs_are_removed() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at(".geardyn-killed123456.partial"), "half").unwrap();
    let busy = File::create(at(".geardyn-busy12345678.partial")).unwrap();
    busy.lock().unwrap();
    // Files of a user that begin alike are nobody's temporaries.
    for own in [
        ".geardyn-notes.txt",
        ".geardyn-mine.csv",
        ".geardyn-backup",
        ".geardyn-notes.partial",
    ] {
        fs::write(at(own), "mine").unwrap();
    }
    assert_eq!(run(CSV, &at("m.csv")).status.code(), Some(0));
    assert_eq!(
        names(folder.path()),
        [
            ".geardyn-backup",
            ".geardyn-busy12345678.partial",
            ".geardyn-mine.csv",
            ".geardyn-notes.partial",
            ".geardyn-notes.txt",
            "m.csv"
        ]
    );
}

/// A named pipe takes what a file would hold where a reader waits at it, and is refused where none does.
#[test]
fn law_named_pipes_are_written_to_their_reader() {
    let folder = tempfile::tempdir().unwrap();
    let (pipe, file) = (folder.path().join("pipe"), folder.path().join("m.csv"));
    assert!(
        Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .unwrap()
            .success()
    );
    let unread = run(CSV, &pipe);
    assert_eq!(unread.status.code(), Some(2));
    assert!(
        said(&unread).contains("without a reader"),
        "{}",
        said(&unread)
    );
    assert_eq!(run(CSV, &file).status.code(), Some(0));
    let reader = Command::new("cat")
        .arg(&pipe)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    // The reader may not have opened the pipe yet.
    let mut output = run(CSV, &pipe);
    while said(&output).contains("without a reader") {
        output = run(CSV, &pipe);
    }
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let read = reader.wait_with_output().unwrap().stdout;
    assert_eq!(read, fs::read(&file).unwrap());
}

/// The line that names what was written shows no control character of a name.
#[test]
fn law_names_written_are_shown_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let output = run(CSV, &folder.path().join("two\nlines.csv"));
    let text = said(&output);
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert!(text.contains("two\u{fffd}lines.csv"), "{text}");
}

/// Starts a command that hears every signal, whatever the tests were started with.
fn started(line: &str) -> Child {
    Command::new("env")
        .args(["--default-signal", env!("CARGO_BIN_EXE_geardyn")])
        .args(line.split(' '))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Whether the command handles a signal: bit `signal − 1` of SigCgt (proc_pid_status(5)).
fn catches(child: &Child, signal: u32) -> bool {
    let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
    let mask = status.lines().find_map(|l| l.strip_prefix("SigCgt:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

/// Waits until the command handles a signal, or has ended.
fn hears(child: &mut Child, signal: u32) {
    while child.try_wait().unwrap().is_none() && !catches(child, signal) {
        std::thread::yield_now();
    }
}

fn interrupted(line: &str, (name, number): (&str, u32), times: usize) -> Output {
    let mut child = started(line);
    hears(&mut child, number);
    for _ in 0..times {
        let sent = Command::new("kill")
            .args([&format!("-{name}"), &child.id().to_string()])
            .status();
        assert!(sent.is_ok());
    }
    child.wait_with_output().unwrap()
}

const SIGNALS: [(&str, u32); 3] = [("HUP", 1), ("INT", 2), ("TERM", 15)];

/// Every command ends with one JSON document at a signal, or has answered before it.
#[test]
fn law_interrupted_commands_end_with_a_document() {
    for (k, line) in [
        "check data/spindle_impact.csv",
        "plan models/y2250.toml",
        "modes models/y2250.toml",
        "simulate examples/backlash_pair.toml",
        "accuracy examples/backlash_pair.toml",
        "stability examples/backlash_pair.toml --until 0.005",
        "response models/y2250.toml --input motor --output workpiece --band 1:400",
        "response models/y2250.toml --run-up 50:3000:120",
        "measure data/index_gear.toml",
        "te models/three_stage_chain.toml --output spindle",
        "run examples/linear_chain.toml",
        "identify data/spindle_impact.csv --input force --output ax,ay",
        "spectrum data/spindle_impact.csv --channel ax",
    ]
    .iter()
    .enumerate()
    {
        let output = interrupted(&format!("{line} --json"), SIGNALS[k % 3], 2);
        let text = String::from_utf8_lossy(&output.stdout);
        let found: Value = serde_json::from_str(&text).unwrap_or_else(|e| panic!("{line}: {e}"));
        match output.status.code() {
            Some(130) if found["errors"].is_array() => {
                assert_eq!(found["errors"][0]["code"], "interrupted", "{line}");
            }
            Some(0 | 1 | 130) => assert!(found["geardyn"].is_object(), "{line}: {text}"),
            other => panic!("{line}: {other:?} {text}"),
        }
    }
}

/// The first signal while `run` finds modes: the document holds them, and no study after them.
#[test]
fn law_interrupted_modes_of_a_run_end_with_a_document() {
    let folder = tempfile::tempdir().unwrap();
    let model = "title = \"t\"\nsource = \"t\"\nunits = \"SI\"\nchain = [{ name = \"c\", count = 900, J = 1.0, k = 1e3 }]\n";
    fs::write(folder.path().join("long.toml"), model).unwrap();
    let study = "[[study]]\nkind = \"modes\"\n";
    let scene = folder.path().join("scene.toml");
    fs::write(
        &scene,
        format!("model = \"long.toml\"\n{study}{study}{study}{study}"),
    )
    .unwrap();
    for signal in SIGNALS {
        let output = interrupted(&format!("run {} --json", scene.display()), signal, 1);
        assert_eq!(output.status.code(), Some(130), "{}", said(&output));
        let found: Value = serde_json::from_slice(&output.stdout).unwrap();
        match found["studies"].as_array() {
            Some(studies) => assert!(studies.len() < 4, "{}", studies.len()),
            None => assert_eq!(found["errors"][0]["code"], "interrupted"),
        }
    }
}

/// Work that has nothing to show before its end says that it was interrupted; the files named stay as they were.
#[test]
fn law_interrupted_work_leaves_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let csv = folder.path().join("old.csv");
    fs::write(&csv, "old").unwrap();
    for (line, word) in [
        (
            "identify data/spindle_impact.csv --input force --output ax,ay",
            "interrupted before the work was finished [interrupted]",
        ),
        (
            "simulate examples/backlash_pair.toml --until 100 --samples 1000 --allow 5h",
            "interrupted",
        ),
    ] {
        for signal in SIGNALS {
            let line = format!("{line} --csv {}", csv.display());
            let output = interrupted(&line, signal, 1);
            let said = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(130), "{line}: {said}");
            assert!(said.contains(word), "{line}: {said}");
            assert_eq!(fs::read_to_string(&csv).unwrap(), "old");
            assert_eq!(names(folder.path()), ["old.csv"]);
        }
    }
}

/// A signal that the caller ignores stays ignored, and the others are heard.
#[test]
fn law_ignored_signals_stay_ignored() {
    let mut child = Command::new("env")
        .args(["--default-signal=INT,TERM", "--ignore-signal=HUP"])
        .arg(env!("CARGO_BIN_EXE_geardyn"))
        .args("simulate examples/backlash_pair.toml --until 100 --allow 5h".split(' '))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    hears(&mut child, SIGNALS[2].1);
    assert!(!catches(&child, SIGNALS[0].1));
    child.kill().unwrap();
    child.wait().unwrap();
}

/// Arguments that are not UTF-8 are refused with their place, as text and as JSON.
#[test]
fn refuses_arguments_that_are_not_text() {
    let wrong = OsStr::from_bytes(b"sp\xefndle.toml");
    for command in ["check", "modes", "identify", "new", "convert", "nonsense"] {
        for json in [false, true] {
            let output = geardyn()
                .arg(command)
                .arg(wrong)
                .args(json.then_some("--json"))
                .output()
                .unwrap();
            assert_eq!(output.status.code(), Some(2), "{command}");
            let said = said(&output);
            assert!(
                said.contains("argument 2 is not UTF-8: `sp\u{fffd}ndle.toml`"),
                "{said}"
            );
            if json {
                let found: Value = serde_json::from_slice(&output.stdout).unwrap();
                assert_eq!(found["errors"][0]["code"], "usage");
            }
        }
    }
}
