//! The command as a person uses it: answers, exit codes, JSON, files, help that runs.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Runs the command in the project's folder.
fn geardyn(arguments: &[&str]) -> Output {
    run_in(root(), arguments)
}

fn run_in(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_geardyn"))
        .args(arguments)
        .current_dir(folder)
        .env("NO_COLOR", "1")
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn answer(arguments: &[&str]) -> String {
    let output = geardyn(arguments);
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}\n{errors}");
    text(&output.stdout)
}

fn document(arguments: &[&str]) -> Value {
    serde_json::from_str(&answer(arguments)).unwrap_or_else(|e| panic!("{arguments:?}: {e}"))
}

fn models() -> Vec<String> {
    let mut models: Vec<String> = std::fs::read_dir(root().join("models"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .map(|path| format!("models/{}", path.file_name().unwrap().to_string_lossy()))
        .collect();
    models.sort();
    assert!(models.len() >= 17);
    models
}

/// Every shipped model is right, has a title and a source, and is at most a page or two.
#[test]
fn law_shipped_models_are_right() {
    for model in models() {
        let found = document(&["check", &model, "--json"]);
        assert!(found["title"].as_str().unwrap().len() > 10, "{model}");
        let warnings = found["warnings"].as_array().unwrap();
        let codes: Vec<&str> = warnings.iter().filter_map(|w| w["code"].as_str()).collect();
        // The published pair of the box touches at its edges under load.
        let expected: &[&str] = match model.as_str() {
            "models/bevel_box.toml" => &["edge-contact"],
            _ => &[],
        };
        assert_eq!(codes, expected, "{model}");
        let file = std::fs::read_to_string(root().join(&model)).unwrap();
        assert!(
            file.contains("source") && file.lines().count() < 200,
            "{model}"
        );
    }
}

/// Shares sum to one, rigid modes are exactly zero and strain nothing, keys are those of docs/json.md.
#[test]
fn law_json_of_modes() {
    for model in models() {
        let found = document(&["modes", &model, "--lowest", "12", "--json"]);
        for mode in found["modes"].as_array().unwrap() {
            let sum = |key: &str| -> Option<f64> {
                let shares = mode[key].as_object()?;
                Some(shares.values().map(|x| x.as_f64().unwrap()).sum())
            };
            let kinetic = sum("kinetic_energy").unwrap();
            assert!((kinetic - 1.0).abs() < 1e-9, "{model}: {kinetic}");
            match mode["rigid"].as_bool().unwrap() {
                true => {
                    assert_eq!(mode["frequency_hz"].as_f64(), Some(0.0), "{model}");
                    assert!(mode["strain_energy"].is_null(), "{model}");
                }
                false => {
                    assert!(
                        (sum("strain_energy").unwrap() - 1.0).abs() < 1e-9,
                        "{model}"
                    );
                    // Small components of a shape are right to the size of the whole, not to their own, and twelve
                    // decades of inertia make that seen; the frequencies keep their digits.
                    let bound = if model.contains("extreme") {
                        1e-6
                    } else {
                        1e-10
                    };
                    assert!(mode["residual"].as_f64().unwrap() < bound, "{model}");
                }
            }
        }
    }
}

/// Every document begins with its header and ends with its warnings.
#[test]
fn law_documents_share_header_and_warnings() {
    for line in [
        "check models/two_disc.toml",
        "check data/spindle_impact.csv",
        "plan models/two_disc.toml",
        "modes models/two_disc.toml",
        "simulate examples/linear_chain.toml",
        "response models/y2250.toml --input motor --output workpiece --band 1:400",
        "response models/y2250.toml --run-up 50:3000:20",
        "measure data/index_gear.toml",
        "te models/three_stage_chain.toml --output spindle",
        "identify data/spindle_impact.csv --input force --output ax",
        "spectrum data/spindle_impact.csv --channel ax",
        "run examples/linear_chain.toml",
    ] {
        let arguments: Vec<&str> = line.split(' ').chain(["--json"]).collect();
        let found = document(&arguments);
        let keys: Vec<&String> = found.as_object().unwrap().keys().collect();
        let ends = [keys[0].as_str(), keys[keys.len() - 1].as_str()];
        assert_eq!(ends, ["geardyn", "warnings"], "{line}");
    }
}

/// `--top` shortens every list.
#[test]
fn exact_top_shortens_shapes() {
    let found = document(&["modes", "models/y2250.toml", "--json", "--top", "3"]);
    for mode in found["modes"].as_array().unwrap() {
        assert_eq!(mode["shape"].as_object().unwrap().len(), 3);
        assert!(mode["kinetic_energy"].as_object().unwrap().len() <= 3);
    }
}

/// What the plan announces is what a run does.
#[test]
fn law_plan_is_what_runs() {
    for model in [
        "models/y2250.toml",
        "models/uniform_chain.toml",
        "models/overhung_rotor.toml",
    ] {
        for flags in [
            &[][..],
            &["--lowest", "5"],
            &["--damped", "--lowest", "5"],
            &["--speed", "100"],
        ] {
            let fixed = model == "models/uniform_chain.toml" && flags.contains(&"--speed");
            if fixed {
                continue;
            }
            let plan = document(&[&["plan", model, "--json"], flags].concat());
            let run = document(&[&["modes", model, "--json"], flags].concat());
            assert_eq!(plan["geardyn"], run["geardyn"], "{model} {flags:?}");
        }
    }
}

/// Bad input ends with 2, names the file and the line, and says it in JSON where JSON was asked for.
#[test]
fn refuses_with_exit_code_two() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("wrong.toml");
    std::fs::write(
        &file,
        "title = \"x\"\nsource = \"y\"\n[[inertia]]\nname = \"a\"\nJ = 3\n",
    )
    .unwrap();
    let path = file.to_str().unwrap();
    for command in ["check", "plan", "modes"] {
        let output = geardyn(&[command, path]);
        assert_eq!(output.status.code(), Some(2), "{command}");
        assert!(output.stdout.is_empty(), "{command}");
        let shown = text(&output.stderr);
        assert!(
            shown.contains("wrong.toml:5") && shown.contains("missing-unit"),
            "{command}: {shown}"
        );
        let output = geardyn(&[command, path, "--json"]);
        assert_eq!(output.status.code(), Some(2), "{command}");
        let found: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(found["errors"][0]["code"], "missing-unit", "{command}");
        assert_eq!(found["errors"][0]["line"], 5, "{command}");
    }
    for usage in [
        &["modes"][..],
        &["modes", "models/two_disc.toml", "--lowest", "0"],
        &["nonsense"],
    ] {
        assert_eq!(geardyn(usage).status.code(), Some(2), "{usage:?}");
    }
    let missing = geardyn(&["modes", "models/no_such_file.toml"]);
    assert_eq!(missing.status.code(), Some(2));
    assert!(text(&missing.stderr).contains("file-missing"));
}

/// Contradicting rigid ratios name the loop and both ratios.
#[test]
fn refuses_contradicting_ratios_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("loop.toml");
    let body = |name: &str| format!("[[inertia]]\nname = \"{name}\"\nJ = \"1 kg·m²\"\n");
    let pair = |name: &str, a: &str, b: &str, teeth: &str| {
        format!("[[gear_pair]]\nname = \"{name}\"\nbetween = [\"{a}\", \"{b}\"]\nteeth = {teeth}\n")
    };
    let text_of = [
        "title = \"x\"\nsource = \"y\"\n".to_string(),
        body("a"),
        body("b"),
        body("c"),
        body("d"),
    ]
    .concat()
        + &pair("first", "a", "b", "[20, 40]")
        + &pair("second", "b", "c", "[20, 40]")
        + &pair("third", "c", "d", "[30, 30]")
        + &pair("closing", "d", "a", "[40, 11]");
    std::fs::write(&file, text_of).unwrap();
    let output = geardyn(&["modes", file.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    let shown = text(&output.stderr);
    for word in [
        "contradictory-ratios",
        "`closing`",
        "`first`",
        "`second`",
        "`third`",
        "-11/40",
    ] {
        assert!(shown.contains(word), "{word} in {shown}");
    }
}

/// `new` writes a model that is right, and never over another file.
#[test]
fn law_the_starter_is_right() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| run_in(folder.path(), arguments);
    assert_eq!(run(&["new", "drive.toml"]).status.code(), Some(0));
    assert_eq!(run(&["check", "drive.toml"]).status.code(), Some(0));
    let modes = run(&["modes", "drive.toml"]);
    assert_eq!(modes.status.code(), Some(0), "{}", text(&modes.stderr));
    assert!(text(&modes.stdout).contains("rigid body"));
    let before = std::fs::read(folder.path().join("drive.toml")).unwrap();
    assert_eq!(run(&["new", "drive.toml"]).status.code(), Some(2));
    assert_eq!(
        std::fs::read(folder.path().join("drive.toml")).unwrap(),
        before
    );
    for kind in [
        "cylindrical",
        "bevel",
        "hypoid",
        "worm",
        "crossed",
        "non-circular",
        "helicoid",
    ] {
        let name = format!("{kind}.toml");
        assert_eq!(run(&["new", &name, "--gear", kind]).status.code(), Some(0));
        let computed = run(&["gear", &name]);
        assert_eq!(
            computed.status.code(),
            Some(0),
            "{}",
            text(&computed.stderr)
        );
    }
}

/// Output files appear whole, beside nothing temporary; what cannot be written is said.
#[test]
fn law_outputs_are_whole() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let (csv, svg, mat) = (at("modes.csv"), at("modes.svg"), at("system.mat"));
    answer(&[
        "modes",
        "models/geared_damped.toml",
        "--csv",
        &csv,
        "--svg",
        &svg,
        "--state-space",
        &mat,
        "--sample-time",
        "1 ms",
    ]);
    let mut names: Vec<PathBuf> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|e| e.unwrap().path())
        .collect();
    names.sort();
    let names: Vec<_> = names
        .iter()
        .map(|p| p.file_name().unwrap().to_str().unwrap())
        .collect();
    assert_eq!(
        names,
        ["modes-energies.svg", "modes.csv", "modes.svg", "system.mat"]
    );
    let rows = std::fs::read_to_string(&csv).unwrap();
    let columns = |row: &str| row.split(',').count();
    let head = rows.lines().next().unwrap();
    assert_eq!(rows.lines().count(), 1 + 3);
    assert!(head.starts_with("mode,frequency_hz,") && columns(head) >= 9 + 4);
    let refused = geardyn(&[
        "modes",
        "models/two_disc.toml",
        "--csv",
        &at("no/such/folder.csv"),
    ]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("output-failed"));
}

/// Every code is explained at length.
#[test]
fn law_every_code_is_explained() {
    let list = answer(&["explain"]);
    let words: Vec<&str> = list
        .lines()
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert!(words.len() > 20);
    for word in words {
        assert!(answer(&["explain", word]).contains("exit code"), "{word}");
    }
    let output = geardyn(&["explain", "unknwn-key"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("did you mean `unknown-key`"));
}

/// Every `--help` ends in an example that runs.
#[test]
fn law_examples_of_help_run() {
    let folder = tempfile::tempdir().unwrap();
    // Examples name shipped files from the project's folder and write beside them: a folder with models and data will do.
    std::fs::create_dir(folder.path().join("models")).unwrap();
    for model in models() {
        std::fs::copy(root().join(&model), folder.path().join(&model)).unwrap();
    }
    for shipped in ["data", "models/gears"] {
        let to = folder.path().join(shipped);
        std::fs::create_dir(&to).unwrap();
        for entry in std::fs::read_dir(root().join(shipped)).unwrap() {
            let path = entry.unwrap().path();
            if path.is_file() {
                std::fs::copy(&path, to.join(path.file_name().unwrap())).unwrap();
            }
        }
    }
    let mut ran = 0;
    for command in [
        "",
        "spectrum",
        "identify",
        "convert",
        "new",
        "check",
        "explain",
        "plan",
        "modes",
        "completions",
        "man",
    ] {
        let help = match command {
            "" => answer(&["--help"]),
            command => answer(&[command, "--help"]),
        };
        let examples: Vec<&str> = help
            .lines()
            .rev()
            .map_while(|line| line.strip_prefix("  geardyn "))
            .collect();
        assert!(!examples.is_empty(), "{command}: {help}");
        for example in examples {
            let example = example.split(" > ").next().unwrap();
            let output = run_in(
                folder.path(),
                &example.split_whitespace().collect::<Vec<_>>(),
            );
            assert_eq!(
                output.status.code(),
                Some(0),
                "{example}: {}",
                text(&output.stderr)
            );
            ran += 1;
        }
    }
    assert!(ran >= 10);
}

/// The console blocks of the tutorial run in order and print what stands there.
#[test]
fn law_the_tutorial_runs() {
    let page = std::fs::read_to_string(root().join("docs/tutorial.md")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut ran = 0;
    for block in page.split("```console\n").skip(1) {
        let block = block.split("```").next().unwrap();
        let mut lines = block.lines();
        let command = lines.next().unwrap().strip_prefix("$ geardyn ").unwrap();
        let output = run_in(
            folder.path(),
            &command.split_whitespace().collect::<Vec<_>>(),
        );
        assert_eq!(output.status.code(), Some(0), "{command}");
        let shown: Vec<&str> = lines.collect();
        if !shown.is_empty() {
            assert_eq!(
                text(&output.stdout).lines().collect::<Vec<_>>(),
                shown,
                "{command}"
            );
        }
        ran += 1;
    }
    assert!(ran >= 4);
}

/// The head of the table in the README is what its first command prints.
#[test]
fn law_the_readme_shows_what_is_printed() {
    let page = std::fs::read_to_string(root().join("README.md")).unwrap();
    let printed = answer(&["modes", "models/y2250.toml"]);
    let table = page
        .split("```text\n")
        .nth(1)
        .unwrap()
        .split("    …")
        .next()
        .unwrap();
    assert!(printed.starts_with(table), "{printed}");
}

/// An output never replaces an input or another output; it is refused before any work is done.
#[test]
fn refuses_outputs_over_inputs_and_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("model.toml");
    std::fs::copy(root().join("models/two_disc.toml"), &model).unwrap();
    let before = std::fs::read(&model).unwrap();
    let run = |arguments: &[&str]| {
        run_in(
            folder.path(),
            &[&["modes", "model.toml"], arguments].concat(),
        )
    };
    for wrong in [
        &["--csv", "model.toml"][..],
        &["--csv", "./model.toml"],
        &["--csv", "a.svg", "--svg", "a.svg"],
        &["--svg", "a.svg", "--csv", "a-energies.svg"],
        &["--svg", "a.png"],
        &["--csv", "ok.csv", "--state-space", "a.txt"],
    ] {
        assert_eq!(run(wrong).status.code(), Some(2), "{wrong:?}");
    }
    assert_eq!(std::fs::read(&model).unwrap(), before);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

/// A scene's study is what `modes` starts from; flags add to it.
#[test]
fn law_modes_takes_the_study_of_a_scene() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(
        root().join("models/geared_damped.toml"),
        folder.path().join("model.toml"),
    )
    .unwrap();
    let scene = "model = \"model.toml\"\n[[study]]\nkind = \"modes\"\ndamped = true\nlowest = 3\n";
    std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let modes = |arguments: &[&str]| -> Value {
        let output = run_in(
            folder.path(),
            &[&["modes", "scene.toml", "--json"], arguments].concat(),
        );
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let found = modes(&[]);
    assert_eq!(found["modes"].as_array().unwrap().len(), 3);
    assert!(
        found["geardyn"]["trace"]
            .as_array()
            .unwrap()
            .contains(&Value::from("complex modes"))
    );
    assert_eq!(
        modes(&["--lowest", "2"])["modes"].as_array().unwrap().len(),
        2
    );
}

/// Wrong usage is JSON too where JSON was asked for, and what a terminal would obey is not printed.
#[test]
fn refuses_usage_as_json_and_prints_nothing_a_terminal_obeys() {
    let output = geardyn(&["modes", "--json"]);
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["errors"][0]["code"], "usage");
    let folder = tempfile::tempdir().unwrap();
    let text = "title = \"x\\u001b]0;pwn\\u0007\"\nsource = \"y\"\n[[inertia]]\nname = \"a\"\nJ = \"1 kg·m²\"\n";
    std::fs::write(folder.path().join("m.toml"), text).unwrap();
    let output = run_in(folder.path(), &["check", "m.toml"]);
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stdout.iter().all(|&b| b >= 0x20 || b == b'\n'));
}

/// Several files are one document with the keys of every document; each of them has its file, wrong ones too.
#[test]
fn law_check_of_several_files_keeps_its_keys() {
    let files = ["models/two_disc.toml", "none.toml", "data/run_up.csv"];
    let output = geardyn(&[&["check", "--json"], &files[..]].concat());
    assert_eq!(output.status.code(), Some(2));
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(found["geardyn"]["version"].is_string() && found["warnings"].is_array());
    for (document, file) in found["files"].as_array().unwrap().iter().zip(files) {
        assert_eq!(document["file"], file);
        assert!(document["geardyn"].is_object() || document["errors"].is_array());
    }
}
