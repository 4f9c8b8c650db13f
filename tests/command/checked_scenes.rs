//! `check` of scenes: what studies would refuse, values that are not plausible, losses put in place of others, titles.

use std::path::Path;

use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::scene;

use serde_json::Value;

use crate::support::command::{document, geardyn, put, refusal, said};

const HEAD: &str = "title = \"t\"\nsource = \"t\"\nunits = \"SI\"\n";

/// Two bodies and a shaft.
const TWO: &str = r#"
inertia = [{ name = "a", J = 1.0 }, { name = "b", J = 2.0 }]
shaft = [{ name = "s", between = ["a", "b"], k = 100.0, damping_ratio = 0.02 }]
"#;

fn warnings(text: &str) -> Vec<(&'static str, String)> {
    let scene = scene::read_text("test.toml", &format!("{HEAD}{text}")).unwrap();
    let all = PreparedMachine::new(&scene.model).unwrap().warnings();
    all.into_iter().map(|w| (w.code, w.message)).collect()
}

/// `check` refuses what `run` refuses, with the same code and message.
#[test]
fn refuses_what_the_studies_of_a_scene_would_refuse() {
    let folder = tempfile::tempdir().unwrap();
    put(folder.path(), "two.toml", &format!("{HEAD}{TWO}"));
    for study in [
        "kind = \"simulate\"\nuntil = \"1 s\"\noutputs = [\"c.theta\"]",
        "kind = \"simulate\"\nuntil = \"1 s\"\nmethod = \"eule\"",
        "kind = \"simulate\"",
        "kind = \"simulate\"\nuntil = \"1 s\"\nmethod = \"newmark\"",
        "kind = \"accuracy\"\nuntil = \"1 s\"\nmethods = [\"eule\"]",
        "kind = \"stability\"\nuntil = \"1 s\"\noutputs = [\"c.theta\"]",
        "kind = \"response\"\nband = \"1:50\"\ninputs = [\"a.theta\"]\noutputs = [\"c.theta\"]",
        "kind = \"response\"\ninputs = [\"a.theta\"]\noutputs = [\"b.theta\"]",
        "kind = \"run_up\"\nspeeds = \"0:3000:31\"",
        "kind = \"harmonic_balance\"\nspeeds = \"100:3000:100\"",
        "kind = \"te\"\noutput = \"b\"",
        "kind = \"accuracy\"\nuntil = \"1 s\"\nsamples = 1000000000",
        "kind = \"accuracy\"\nof = \"response\"\ninputs = [\"a.theta\"]\noutputs = [\"b.theta\"]",
        "kind = \"stability\"\nspeeds = \"100:3000:30\"",
        "kind = \"modes\"\nreduce = \"guyan\"\nbelow = \"100 Hz\"\nkeep = [\"nix\"]",
        "kind = \"modes\"\nstate_space = true\ninput = [\"nix\"]",
        "kind = \"modes\"\nstate_space = true\noutput = [\"nix\"]",
    ] {
        let text = format!("model = \"two.toml\"\n\n[[study]]\n{study}\n");
        let path = put(folder.path(), "scene.toml", &text);
        let path = path.to_str().unwrap();
        assert_eq!(
            refusal(&["check", path]),
            refusal(&["run", path]),
            "{study}"
        );
    }
}

/// Studies of accuracy and stability refuse machines too large or without a mode, and `check` does so before them.
#[test]
fn refuses_machines_that_a_study_cannot_take() {
    let folder = tempfile::tempdir().unwrap();
    let rigid = "inertia = [{ name = \"a\", J = 1.0 }, { name = \"b\", J = 1.0 }]\ncoupling = [{ name = \"c\", between = [\"a\", \"b\"] }]\n";
    let long = "chain = [{ name = \"c\", count = 2500, J = 1.0, k = 1e3 }]\n";
    for (model, study, words) in [
        (
            rigid,
            "kind = \"accuracy\"\nof = \"modes\"",
            "no elastic mode",
        ),
        (long, "kind = \"stability\"", "needs all modes"),
    ] {
        put(folder.path(), "model.toml", &format!("{HEAD}{model}"));
        let text = format!("model = \"model.toml\"\n\n[[study]]\n{study}\n");
        let path = put(folder.path(), "scene.toml", &text);
        let path = path.to_str().unwrap();
        let [check, run] = ["check", "run"].map(|command| said(&[command, path]));
        assert_eq!((check.0, &check.2), (run.0, &run.2), "{study}");
        assert!(check.2.contains(words), "{check:?}");
    }
}

/// Every shipped scene passes, and no shipped model holds a value far off.
#[test]
fn law_shipped_files_are_plausible() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = vec!["check".to_string(), "--json".to_string()];
    for folder in ["examples", "models"] {
        for entry in std::fs::read_dir(root.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|e| e == "toml") {
                files.push(path.to_str().unwrap().to_string());
            }
        }
    }
    let arguments: Vec<&str> = files.iter().map(String::as_str).collect();
    let all = document(&arguments);
    for file in all["files"].as_array().unwrap() {
        let words = file["warnings"].as_array().unwrap().iter();
        let mut words = words.map(|w| w["code"].as_str().unwrap());
        assert!(
            words.all(|w| w != "implausible" && w != "speeds-misfit"),
            "{file:#}"
        );
    }
}

/// A slip of units in each place, and what is said of it; the same with a usual value passes.
#[test]
fn law_implausible_values_are_named_with_the_usual_range() {
    let pair = |keys: &str| {
        format!(
            "inertia = [{{ name = \"a\", J = 1.0 }}, {{ name = \"b\", J = 1.0 }}]\n\
             gear_pair = [{{ name = \"p\", between = [\"a\", \"b\"], teeth = [20, 40], {keys} }}]\n"
        )
    };
    let body = |keys: &str| {
        format!(
            "inertia = [{{ name = \"a\", J = 1.0, mass = 3.0, {keys} }}]\n\
             bearing = [{{ name = \"f\", at = \"a\", k_radial = 1e8, k_tilt = 1e6 }}]\n"
        )
    };
    let speeds = |keys: &str| format!("{}speed = {{ {keys} }}\n", pair("module = 4e-3, k = 4e8"));
    for (slip, said, usual) in [
        (
            pair("module = 4e-3, k = 400.0"),
            "ISO 6336-1",
            pair("module = 4e-3, k = 4e8"),
        ),
        (
            pair("module = 4e-3, k = 4e14"),
            "ISO 6336-1",
            pair("module = 4e-3, k = 6e9"),
        ),
        (
            pair("module = 4.0, k = 4e8"),
            "ISO 54",
            pair("module = 0.05, k = 4e9"),
        ),
        (
            pair("module = 4e-3, k = 4e8, damping_ratio = 5.0"),
            "Kasuba and Evans",
            pair("module = 4e-3, k = 4e8, damping_ratio = 0.05"),
        ),
        (
            pair("module = 4e-3, k = 4e8, loss_factor = 1.5"),
            "a damping ratio of 0.75",
            pair("module = 4e-3, k = 4e8, loss_factor = 0.1"),
        ),
        (
            pair("module = 4e-3, k = 4e8") + "damping = { modal = [0.02, 0.7] }\n",
            "[damping] modal is 0.7",
            pair("module = 4e-3, k = 4e8") + "damping = { modal = 0.02 }\n",
        ),
        (
            body("J_diametral = 0.4"),
            "perpendicular-axis",
            body("J_diametral = 0.5"),
        ),
        (
            speeds("a = 100.0, b = 100.0"),
            "speeds stated",
            speeds("a = 100.0"),
        ),
    ] {
        let of = |text: &str| -> Vec<String> {
            let all = warnings(text).into_iter();
            let own = all.filter(|w| w.0 == "implausible" || w.0 == "speeds-misfit");
            own.map(|w| w.1).collect()
        };
        let found = of(&slip);
        assert!(
            found.len() == 1 && found[0].contains(said),
            "{slip}\n{found:?}"
        );
        assert_eq!(of(&usual), Vec::<String>::new(), "{usual}");
    }
}

/// `[set]` puts one kind of loss in place of another; two set at once stay a conflict.
#[test]
fn law_set_may_change_the_kind_of_loss() {
    let folder = tempfile::tempdir().unwrap();
    put(folder.path(), "two.toml", &format!("{HEAD}{TWO}"));
    let scene = |set: &str| {
        let text = format!("model = \"two.toml\"\ntitle = \"Another loss\"\n\n[set]\n{set}\n");
        put(folder.path(), "scene.toml", &text)
    };
    let damped = |path: &Path| {
        let found = document(&["modes", path.to_str().unwrap(), "--damped", "--json"]);
        found["modes"][1]["damping_ratio"].as_f64().unwrap()
    };
    // λ = iω √(1 + iη): ζ = sin(½ atan η); a coefficient c damps by c ω/(2k).
    let eta = damped(&scene("\"s.loss_factor\" = 0.2"));
    assert!((eta - (0.5 * 0.2f64.atan()).sin()).abs() < 1e-9, "{eta}");
    let omega = (100.0f64 * 1.5).sqrt();
    let c = damped(&scene("\"s.c\" = \"4 N·m·s/rad\""));
    assert!((c - 4.0 * omega / 200.0).abs() < 1e-9, "{c}");
    let both = scene("s.c = \"4 N·m·s/rad\"\ns.loss_factor = 0.2");
    assert_eq!(refusal(&["check", both.to_str().unwrap()]).0, "conflict");
    // The title of the scene, not of its model.
    let path = scene("\"s.loss_factor\" = 0.2");
    let (_, text, _) = said(&["check", path.to_str().unwrap()]);
    assert!(text.contains("Another loss"), "{text}");
}

/// The loss of a bearing changes between dampers by axis and one factor for all its springs.
#[test]
fn law_set_may_change_the_loss_of_a_bearing() {
    let folder = tempfile::tempdir().unwrap();
    let model = "[[inertia]]\nname = \"a\"\nJ = \"1 kg·m²\"\n[[bearing]]\nname = \"e\"\nat = \"a\"\nk_theta = \"100 N·m/rad\"\n";
    for (loss, set) in [
        ("c_theta = \"1 N·m·s/rad\"", "\"e.loss_factor\" = 0.2"),
        ("loss_factor = 0.2", "\"e.c_theta\" = \"1 N·m·s/rad\""),
    ] {
        put(folder.path(), "one.toml", &format!("{model}{loss}\n"));
        let scene = format!("model = \"one.toml\"\n[set]\n{set}\n");
        let path = put(folder.path(), "scene.toml", &scene);
        let found = document(&["modes", path.to_str().unwrap(), "--damped", "--json"]);
        let ratio = found["modes"][0]["damping_ratio"].as_f64().unwrap();
        let expected = match set.contains("loss_factor") {
            true => (0.5 * 0.2f64.atan()).sin(),
            false => 1.0 * 10.0 / 200.0,
        };
        assert!((ratio - expected).abs() < 1e-9, "{set}: {ratio}");
    }
}

/// Stated speeds that contradict the tooth numbers: the one that follows from the others is named.
#[test]
fn refuses_speeds_that_contradict_the_teeth() {
    let folder = tempfile::tempdir().unwrap();
    let model = "[[inertia]]\nname = \"a\"\nJ = \"1 kg·m²\"\n[[inertia]]\nname = \"b\"\nJ = \"1 kg·m²\"\n[[gear_pair]]\nname = \"p\"\nbetween = [\"a\", \"b\"]\nteeth = [20, 40]\n[speed]\na = \"1000 rpm\"\nb = \"700 rpm\"\n";
    let path = put(folder.path(), "pair.toml", model);
    let (_, text, notes) = said(&["check", path.to_str().unwrap()]);
    let all = text + &notes;
    assert!(
        all.contains("700 rpm") && all.contains("give -500 rpm"),
        "{all}"
    );
}

/// Every element with a stiffness takes each kind of loss, and it damps.
#[test]
fn law_every_elastic_element_takes_the_loss_keys() {
    let bodies = "inertia = [{ name = \"a\", J = 1.0, mass = 1.0 }, { name = \"b\", J = 2.0, mass = 1.0 }, { name = \"r\", J = 3.0 }]\ncoupling = [JOINED{ name = \"j\", between = [\"a\", \"b\"], k = 10.0 }, { name = \"i\", between = [\"b\", \"r\"], k = 10.0 }]\n";
    let elements = [
        (
            "shaft = [{ name = \"e\", between = [\"a\", \"b\"], k = 1e3, LOSS }]",
            "",
            "2.0",
        ),
        (
            "chain = [{ name = \"e\", count = 3, J = 1.0, k = 1e3, LOSS }]",
            "",
            "2.0",
        ),
        (
            "coupling: { name = \"e\", between = [\"a\", \"b\"], k = 1e3, LOSS }, ",
            "",
            "2.0",
        ),
        (
            "gear_pair = [{ name = \"e\", between = [\"a\", \"b\"], teeth = [20, 30], module = 1e-2, k = 1e8, LOSS }]",
            "",
            "1e3",
        ),
        (
            "worm_pair = [{ name = \"e\", between = [\"a\", \"b\"], teeth = [1, 30], module = 1e-2, lead_angle = 0.1, k = 1e8, LOSS }]",
            "",
            "1e3",
        ),
        (
            "planetary = [{ name = \"e\", sun = \"a\", ring = \"r\", carrier = \"b\", planets = 3, teeth = [20, 20, 60], module = 1e-2, planet_J = 0.1, k_sun = 1e8, k_ring = 1e8, LOSS }]",
            "_sun",
            "1e3",
        ),
        (
            "planetary = [{ name = \"e\", sun = \"a\", ring = \"r\", carrier = \"b\", planets = 3, teeth = [20, 20, 60], module = 1e-2, planet_J = 0.1, k_sun = 1e8, k_ring = 1e8, LOSS }]",
            "_ring",
            "1e3",
        ),
        (
            "planetary = [{ name = \"e\", sun = \"a\", ring = \"ground\", carrier = \"b\", planets = 3, teeth = [20, 20, 60], module = 1e-2, planet_J = 0.1, planet_mass = 1.0, k_sun = 1e8, k_ring = 1e8, lateral = true, k_bearing = 1e8, LOSS }]",
            "_bearing",
            "1e3",
        ),
        (
            "belt = [{ name = \"e\", between = [\"a\", \"b\"], diameters = [0.1, 0.2], k = 1e6, LOSS }]",
            "",
            "1e2",
        ),
        (
            "slide = [{ name = \"t\", mass = 5.0 }]\nscrew = [{ name = \"e\", between = [\"a\", \"t\"], lead = 0.01, k = 1e8, LOSS }]",
            "",
            "1e3",
        ),
        (
            "bearing = [{ name = \"e\", at = \"a\", k_radial = 1e8, LOSS }]",
            "",
            "",
        ),
    ];
    for (element, suffix, c) in elements {
        for (key, value) in [("c", c), ("damping_ratio", "0.05"), ("loss_factor", "0.1")] {
            if value.is_empty() {
                continue;
            }
            let loss = format!("{key}{suffix} = {value}");
            let element = element.replace("LOSS", &loss);
            // Couplings join all bodies; one more of them stands in their list.
            let text = match element.strip_prefix("coupling: ") {
                Some(own) => format!("{HEAD}{}", bodies.replace("JOINED", own)),
                None => format!("{HEAD}{}{element}\n", bodies.replace("JOINED", "")),
            };
            let scene =
                scene::read_text("test.toml", &text).unwrap_or_else(|e| panic!("{text}\n{e}"));
            let machine =
                PreparedMachine::new(&scene.model).unwrap_or_else(|e| panic!("{text}\n{e}"));
            assert!(machine.model.is_damped(&machine.machine), "{text}");
        }
    }
}

/// The picture of a scene bears its title.
#[test]
fn law_pictures_bear_the_title_of_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let svg = folder.path().join("x.svg");
    let svg = svg.to_str().unwrap();
    let scene = "examples/backlash_pair.toml";
    let flags = [
        "--until",
        "0.002",
        "--samples",
        "50",
        "--svg",
        svg,
        "--json",
    ];
    let found = document(&[&["simulate", scene], &flags[..]].concat());
    let title =
        "Gear pair with play and rectangular stiffness: 1 000 mesh cycles, contact lost in each";
    assert_eq!(found["title"], title);
    assert!(std::fs::read_to_string(svg).unwrap().contains(title));
    document(&["modes", scene, "--svg", svg, "--json"]);
    for name in ["x.svg", "x-energies.svg"] {
        let svg = std::fs::read_to_string(folder.path().join(name)).unwrap();
        assert!(svg.contains(title), "{name}");
    }
}

/// An element named for indexing that does not exist is refused by `check` as by `run`.
#[test]
fn refuses_indexing_behind_an_unknown_element() {
    let folder = tempfile::tempdir().unwrap();
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/three_stage_chain.toml");
    let text = format!(
        "model = {model:?}\n[[study]]\nkind = \"te\"\noutput = \"spindle\"\nindex = \"nix:3\"\n"
    );
    let path = put(folder.path(), "scene.toml", &text);
    let path = path.to_str().unwrap();
    let (code, message) = refusal(&["check", path]);
    assert!(
        code == "unknown-node" && message.contains("`nix`"),
        "{message}"
    );
    assert_eq!(refusal(&["run", path]), (code, message));
}

/// A load that no motion can take is refused with its place in the model, by `check` and by each motion.
#[test]
fn refuses_loads_that_no_motion_can_take() {
    let folder = tempfile::tempdir().unwrap();
    let load = "[[load]]\nkind = \"product\"\nat = \"a\"\ntorque = 5.0\nfactors = [{ kind = \"table\", times = [0.0, 1.0], values = [0, 1] }, { kind = \"ramp\", between = [0.1, 0.6] }, { kind = \"harmonic\", frequency = 30.0 }]\n";
    let path = put(folder.path(), "model.toml", &format!("{HEAD}{TWO}{load}"));
    let path = path.to_str().unwrap();
    let line = 1 + HEAD.lines().count() + TWO.lines().count() + 2;
    for arguments in [&["check", path][..], &["simulate", path, "--until", "1"]] {
        let output = geardyn(&[arguments, &["--json"]].concat());
        let found: Value = serde_json::from_slice(&output.stdout).unwrap();
        let errors = found["errors"].as_array().unwrap();
        assert_eq!(errors.len(), 1, "{found}");
        assert_eq!(errors[0]["code"], "conflict", "{found}");
        assert_eq!(errors[0]["line"], line, "{found}");
    }
}

/// A file of values that is missing is one error, whose hint names the folder that the path starts from.
#[test]
fn refuses_a_missing_file_of_values_once() {
    let folder = tempfile::tempdir().unwrap();
    let pair = "inertia = [{ name = \"a\", J = 1.0 }, { name = \"b\", J = 1.0 }]\n\
         gear_pair = [{ name = \"p\", between = [\"a\", \"b\"], teeth = [20, 40], module = 4e-3, k = 4e8 }]\n\
         error = [{ on = \"a\", cause = \"cumulative-pitch\", file = \"nix.csv\", file_unit = \"µm\" }]\n";
    let path = put(folder.path(), "pair.toml", &format!("{HEAD}{pair}"));
    let output = geardyn(&["check", path.to_str().unwrap(), "--json"]);
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let errors = found["errors"].as_array().unwrap();
    assert_eq!(errors.len(), 1, "{found}");
    assert_eq!(errors[0]["code"], "file-missing", "{found}");
    assert!(errors[0]["hint"].as_str().unwrap().contains("[[error]]"));
}

/// A steady start cannot turn a body that a torsional spring holds to ground.
#[test]
fn refuses_a_steady_start_against_a_torsional_support() {
    let folder = tempfile::tempdir().unwrap();
    let held =
        "[[bearing]]\nname = \"ctl\"\nat = \"b\"\nk_theta = 1e3\n[speed]\na = \"1500 rpm\"\n";
    put(folder.path(), "two.toml", &format!("{HEAD}{TWO}{held}"));
    let start = |at: &str| {
        let text = format!(
            "model = \"two.toml\"\n[start]\nat = \"{at}\"\n[[study]]\nkind = \"simulate\"\nuntil = \"1 s\"\n"
        );
        put(folder.path(), "scene.toml", &text)
    };
    let (code, message) = refusal(&["check", start("steady").to_str().unwrap()]);
    assert_eq!(code, "conflict");
    assert!(message.contains("`ctl`"), "{message}");
    document(&["check", start("rest").to_str().unwrap(), "--json"]);
}
