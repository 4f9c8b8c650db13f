//! What runs and what is left out, for every shipped model; and that leaving out changes no answer.
//!
//! `tests/left_out/<model>.txt` holds the stages that run. `GEARDYN_RENEW=1 cargo test --test machine plan_left_out` writes them anew.

use std::f64::consts::TAU;
use std::fs;

use crate::support::{
    Solved, damped, lowest, model, plain, solve, solve_file, solve_model, within, worst,
};
use geardyn::internals::base::code::Code;
use geardyn::internals::plan::stages::{ModesPlan, Stage, StageDecision};
use geardyn::internals::scene::study::ModesStudy;

fn models() -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir("models")
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .map(|path| path.file_stem().unwrap().to_str().unwrap().to_string())
        .collect();
    names.sort();
    names
}

/// A speed where the model states one.
/// Stages the plan says will run.
fn announced(plan: &ModesPlan) -> Vec<&str> {
    let runs = plan
        .rows()
        .filter(|r| matches!(r.1, StageDecision::Runs(_)));
    runs.map(|r| r.0).collect()
}

fn studies(turns: bool) -> Vec<(&'static str, ModesStudy)> {
    let near = ModesStudy {
        near: Some(100.0 * TAU),
        ..lowest(3)
    };
    let mut list = vec![
        ("lowest 10", lowest(10)),
        (
            "lowest 10, damped",
            ModesStudy {
                damped: true,
                ..lowest(10)
            },
        ),
        ("3 near 100 Hz", near),
    ];
    if turns {
        let speed = Some(100.0);
        list.push((
            "lowest 10 at 100 rad/s",
            ModesStudy {
                speed,
                ..lowest(10)
            },
        ));
    }
    list
}

/// The stages announced are those that ran, in that order; each file's are as before.
#[test]
fn keeps_left_out() {
    let renew = std::env::var_os("GEARDYN_RENEW").is_some();
    let mut changed = Vec::new();
    for name in models() {
        let turns = fs::read_to_string(format!("models/{name}.toml"))
            .unwrap()
            .contains("[speed]");
        let mut text = String::new();
        for (what, study) in studies(turns) {
            // A thousand complex modes at once are too slow for a test.
            if study.damped && name == "uniform_chain" {
                continue;
            }
            let solved = solve_file(&name, &study);
            let ran: Vec<&str> = solved.answer.trace.iter().map(|t| t.1).collect();
            assert_eq!(
                ran,
                announced(&solved.plan),
                "{name}, {what}: announced and run"
            );
            text += &format!("{what}\n");
            for (_, stage, decision) in &solved.plan.stages {
                text += &match decision {
                    StageDecision::Runs(how) => format!("  runs      {stage}: {how}\n"),
                    StageDecision::LeftOut(why) => format!("  left out  {stage}: {why}\n"),
                };
            }
        }
        let path = format!("tests/left_out/{name}.txt");
        if renew {
            fs::create_dir_all("tests/left_out").unwrap();
            fs::write(&path, &text).unwrap();
        } else if fs::read_to_string(&path).unwrap_or_default() != text {
            changed.push(path);
        }
    }
    let hint = "if that is meant: GEARDYN_RENEW=1 cargo test --test machine plan_left_out";
    assert!(
        changed.is_empty(),
        "the stages differ from {changed:?}; {hint}"
    );
}

/// Only the lowest, only those near: the same numbers as among all.
#[test]
fn law_fewer_modes_are_the_same_modes() {
    for name in models() {
        if name == "uniform_chain" {
            continue;
        }
        let all = solve_file(&name, &plain());
        let count = all.answer.modes.len().min(4);
        let few = solve_file(&name, &lowest(4));
        assert_eq!(few.omega(), all.omega()[..count], "{name}");
        let middle = all.omega()[all.answer.modes.len() / 2];
        let near = solve_file(
            &name,
            &ModesStudy {
                near: Some(middle),
                ..lowest(2)
            },
        );
        for omega in near.omega() {
            assert!(all.omega().contains(&omega) && omega > 0.0, "{name}");
        }
        assert!(near.omega().contains(&middle) || middle == 0.0, "{name}");
    }
}

/// Nothing that only looks at the answer changes it: damping asked of a machine that has none.
#[test]
fn law_undamped_machines_stay_so() {
    let (asked, not) = (
        solve_file("two_disc", &damped()),
        solve_file("two_disc", &plain()),
    );
    // Damped studies build on shapes and take the factored form: as many digits, not the same last bit.
    let pairs = asked.omega().into_iter().zip(not.omega());
    assert_eq!(asked.omega().len(), not.omega().len());
    pairs.for_each(|(a, b)| assert!((a - b).abs() <= 1e-14 * b, "{a} {b}"));
    assert!(!asked.plan.runs(Stage::Complex));
}

fn chain_of_400(held: &str) -> String {
    format!(
        "units = \"SI\"\ntitle = \"400 discs\"\nsource = \"a test\"\n\
         [[chain]]\nname = \"disc\"\ncount = 400\nJ = 0.01\nk = 1e6\nheld = \"{held}\"\n\
         [[inertia]]\nname = \"wheel\"\nJ = 0.3\n\
         [[gear_pair]]\nname = \"pair\"\nbetween = [\"disc.200\", \"wheel\"]\nteeth = [20, 40]\nmodule = 0.004\nk = 1e9\n"
    )
}

fn compare(what: &str, few: &Solved, all: &Solved, from: usize) {
    assert!(
        few.plan.runs(Stage::Lowest) && !few.plan.runs(Stage::Basis),
        "{what}"
    );
    assert!(all.plan.runs(Stage::Basis), "{what}");
    let part = from..from + few.answer.modes.len();
    let error = worst(&few.omega(), &all.omega()[part.clone()]);
    // The dense answer says how many digits it has.
    let digits = all.answer.modes[part.clone()]
        .iter()
        .map(|mode| mode.trusted_digits)
        .fold(f64::INFINITY, f64::min);
    within(what, error, 10f64.powf(-digits).max(1e-12));
    for (one, other) in few.answer.modes.iter().zip(&all.answer.modes[part]) {
        let product: f64 = one
            .shape
            .iter()
            .zip(&other.shape)
            .map(|(a, b)| (a.re - b.re).abs())
            .fold(0.0, f64::max);
        assert!(product < 1e-6, "{what}: shapes {product:.1e} apart");
    }
}

/// Iteration and dense solution of 400 discs with a wheel: frequencies and shapes.
#[test]
fn law_iteration_and_dense_agree() {
    for held in ["start", "none"] {
        let text = chain_of_400(held);
        let all = solve(&text, &plain());
        compare(
            &format!("lowest 12, {held}"),
            &solve(&text, &lowest(12)),
            &all,
            0,
        );
        let omega = all.omega();
        let middle = (omega[200] + omega[201]) / 2.0;
        let study = ModesStudy {
            near: Some(middle),
            ..lowest(2)
        };
        compare(
            &format!("2 near the middle, {held}"),
            &solve(&text, &study),
            &all,
            200,
        );
    }
}

/// Far above all frequencies the nearest modes are the highest; where one stands alone far above the rest it may be said that this is hopeless.
#[test]
fn survives_near_a_frequency_above_all() {
    let above = ModesStudy {
        near: Some(1e9),
        ..lowest(3)
    };
    let text = "units = \"SI\"\ntitle = \"500 discs\"\nsource = \"a test\"\n\
                [[chain]]\nname = \"disc\"\ncount = 500\nJ = 0.01\nk = 1e6\nheld = \"start\"\n";
    compare(
        "3 near 1e9 rad/s",
        &solve(text, &above),
        &solve(text, &plain()),
        497,
    );
    match solve_model(&model(&chain_of_400("start")), &above) {
        Ok(solved) => assert_eq!(solved.answer.modes.len(), 3),
        Err(error) => {
            assert_eq!(error.code, Code::NoConvergence);
            assert!(error.hint.is_some());
        }
    }
}

/// Nearest in ω, not in ω²: between two modes, a hair nearer to the upper one.
#[test]
fn law_near_means_near_in_frequency() {
    let text = chain_of_400("start");
    let all = solve(&text, &plain());
    let omega = all.omega();
    for at in [0, 1, 2, 150] {
        let middle = omega[at] + 0.501 * (omega[at + 1] - omega[at]);
        let study = ModesStudy {
            near: Some(middle),
            ..lowest(1)
        };
        compare("nearest", &solve(&text, &study), &all, at + 1);
    }
}
