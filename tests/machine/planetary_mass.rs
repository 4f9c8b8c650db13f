//! Planets that ride with their carrier, and stages that turn with it.

use crate::support;
use std::f64::consts::TAU;

use geardyn::internals::base::time_budget::CancelToken;
use geardyn::internals::modes::mode::Mode;
use geardyn::internals::plan::modes_run::run;
use geardyn::internals::plan::motion::method_choice;
use geardyn::internals::plan::motion::run as motion;
use geardyn::internals::plan::motion::simulation_setup::SimulationSetup;
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::plan::stages::ModesPlan;
use geardyn::internals::scene;
use geardyn::internals::scene::initial_conditions::InitialConditions;
use geardyn::internals::scene::laws::InitialState;
use geardyn::internals::scene::study::{ModesStudy, SimulateStudy};

fn first_hz(lateral: &str) -> f64 {
    let text = format!(
        "title = \"t\"\nsource = \"test\"\nunits = \"SI\"\n\
         [[inertia]]\nname = \"sun\"\nJ = 0.5\nmass = 5.0\n[[inertia]]\nname = \"carrier\"\nJ = 10.0\nmass = 50.0\n[[inertia]]\nname = \"anchor\"\nJ = 100.0\n\
         [[planetary]]\nname = \"stage\"\nsun = \"sun\"\nring = \"ground\"\ncarrier = \"carrier\"\nplanets = 3\nteeth = [20, 31, 82]\nmodule = 0.006\nplanet_J = 0.01\nplanet_mass = 10.0\nk_sun = 1e12\nk_ring = 1e12\n{lateral}\n\
         [[shaft]]\nname = \"out\"\nbetween = [\"carrier\", \"anchor\"]\nk = 1e6\n\
         [[bearing]]\nname = \"s\"\nat = \"sun\"\nk_radial = 1e12\n[[bearing]]\nname = \"c\"\nat = \"carrier\"\nk_radial = 1e12\n"
    );
    let scene = scene::read_text("test.toml", &text).unwrap_or_else(|e| panic!("{e}"));
    let machine = PreparedMachine::new(&scene.model).unwrap_or_else(|e| panic!("{e}"));
    let study = ModesStudy::default();
    let answer = run(&machine, &study, &ModesPlan::plan_modes(&machine, &study)).unwrap();
    answer
        .modes
        .iter()
        .find(|m| !m.rigid)
        .unwrap()
        .frequency_hz()
}

/// With stiff bearings a lateral stage and a rotational one are the same machine: `n m r²` sits on the carrier.
#[test]
fn law_rotational_is_the_stiff_limit_of_lateral() {
    let rotational = first_hz("");
    let lateral = first_hz("lateral = true\nk_bearing = 1e13");
    assert!(
        (rotational / lateral - 1.0).abs() < 1e-5,
        "{rotational} {lateral}"
    );
}

/// A bearing that cannot give way is refused where planets do not move sideways.
#[test]
fn refuses_planet_bearings_without_lateral() {
    let text = "title = \"t\"\nsource = \"test\"\nunits = \"SI\"\n\
         [[inertia]]\nname = \"sun\"\nJ = 0.5\n[[inertia]]\nname = \"carrier\"\nJ = 10.0\n\
         [[planetary]]\nname = \"stage\"\nsun = \"sun\"\nring = \"ground\"\ncarrier = \"carrier\"\nplanets = 3\nteeth = [20, 31, 82]\nmodule = 0.006\nplanet_J = 0.01\nk_bearing = 1e9\n";
    let scene = scene::read_text("test.toml", text).unwrap();
    assert!(
        PreparedMachine::new(&scene.model)
            .err()
            .unwrap()
            .message
            .contains("stage")
    );
}

/// The shipped stage with its carrier free, at 1 000 rpm of it.
fn turning(change: impl Fn(String) -> String) -> String {
    let text = std::fs::read_to_string("models/lin_parker_n3.toml").unwrap();
    format!("{}\n[speed]\ncarrier = \"1000 rpm\"\n", change(text))
}

fn prepared(text: &str) -> Result<PreparedMachine, String> {
    let scene = scene::read_text("test.toml", text).map_err(|e| e.to_string())?;
    PreparedMachine::new(&scene.model).map_err(|e| e.to_string())
}

fn at_speed(text: &str, damped: bool) -> Result<Vec<Mode>, String> {
    let machine = prepared(text)?;
    let study = ModesStudy {
        speed: Some(1000.0 * TAU / 60.0),
        damped,
        ..ModesStudy::default()
    };
    let plan = ModesPlan::plan_modes(&machine, &study);
    let answer = run(&machine, &study, &plan).map_err(|e| e.message)?;
    Ok(answer.modes)
}

/// Against the same stage in the inertial frame, not linear, which says nothing of frames (tools/reference_turning_stage.py): its turn has
/// zero twice for a root, and all frequencies agree to what the centrifugal stretch of the radius changes, 7e-5 of it. Centripetal terms
/// without the preload they come with had made the turn grow by 44.3 1/s, and frequencies 1.6 % wrong.
/// Source: a model of the stage in the inertial frame, SciPy (tools/reference_turning_stage.py).
#[test]
fn ref_stage_that_turns_in_the_inertial_frame() {
    let reference = support::reference("turning_stage");
    let modes = at_speed(&turning(|text| text), false).unwrap();
    let rigid = modes.iter().filter(|m| m.rigid).count();
    assert_eq!(rigid, 1);
    let wanted = support::numbers(&reference["frequencies_hz"]);
    let elastic: Vec<&Mode> = modes.iter().filter(|m| !m.rigid).collect();
    assert_eq!(elastic.len(), wanted.len());
    for (mode, hertz) in elastic.iter().zip(&wanted) {
        assert!(
            mode.eigenvalue.re.abs() < 1e-10 * mode.omega(),
            "{}",
            mode.eigenvalue
        );
        let off = mode.frequency_hz() / hertz - 1.0;
        assert!(off.abs() < 5e-5, "{} {hertz}: {off}", mode.frequency_hz());
    }
}

/// In time the stage keeps its speed, as the inertial one does, and planets go outwards as far.
/// Source: a model of the stage in the inertial frame, SciPy (tools/reference_turning_stage.py).
#[test]
fn ref_stage_that_turns_keeps_its_speed() {
    let reference = support::reference("turning_stage");
    let machine = prepared(&turning(|text| text)).unwrap();
    let start = InitialConditions {
        at: InitialState::Steady,
        ..InitialConditions::default()
    };
    let study = SimulateStudy {
        end_time: Some(0.2),
        outputs: vec!["carrier.speed".to_string(), "stage.planet_1.x".to_string()],
        ..SimulateStudy::default()
    };
    let ready = SimulationSetup::new(&machine, &start, &study).unwrap();
    let choice = method_choice::choose_method(&ready.model.model, &study).unwrap();
    let motion = motion::run(&ready, &choice, false, &CancelToken::default())
        .unwrap()
        .values;
    let speed = 1000.0 * TAU / 60.0;
    let interval = support::number(&reference["planet_stretch_m"]);
    for (&v, &x) in motion[0].iter().zip(&motion[1]) {
        assert!((v / speed - 1.0).abs() < 1e-6, "{v}");
        assert!((x / interval - 1.0).abs() < 1e-3, "{x}");
    }
}

/// Without any support the stage keeps both turns at zero, exactly; the translation, which goes round backward in the turning frame, at ±iΩ twice;
/// and sun and ring, which float against planets that turn along, depart at 47.2 1/s, as they do in the inertial frame, followed in time.
/// Source: a model of the stage in the inertial frame, SciPy (tools/reference_turning_stage.py).
#[test]
fn ref_stage_without_supports_in_the_inertial_frame() {
    let reference = support::reference("turning_stage");
    let free = &reference["without_supports"];
    let text = turning(|text| text.split("[[bearing]]").next().unwrap().to_string());
    let modes = at_speed(&format!("{text}ring = \"300 rpm\"\n"), false).unwrap();
    let omega = 1000.0 * TAU / 60.0;
    let turns: Vec<&Mode> = modes.iter().filter(|m| m.rigid).collect();
    assert_eq!(turns.len(), 2);
    for turn in turns {
        assert!(turn.eigenvalue.re == 0.0 && turn.eigenvalue.im == 0.0);
    }
    let others: Vec<&Mode> = modes.iter().filter(|m| !m.rigid).collect();
    let translations: Vec<&&Mode> = others
        .iter()
        .filter(|m| (m.omega() / omega - 1.0).abs() < 1e-6)
        .collect();
    assert_eq!(translations.len(), 2);
    for mode in translations {
        assert!(mode.eigenvalue.re.abs() <= 1e-10 * mode.omega());
    }
    let float = support::numbers(&free["floating_root_per_s"]);
    let pair: Vec<&&Mode> = others
        .iter()
        .filter(|m| m.eigenvalue.re.abs() > 1.0)
        .collect();
    assert_eq!(pair.len(), 2);
    for mode in pair {
        assert!((mode.eigenvalue.re.abs() / float[0] - 1.0).abs() < 1e-4);
        assert!((mode.eigenvalue.im / float[1] - 1.0).abs() < 1e-4);
    }
    // The reference's own linearisation holds in time.
    let followed = support::numbers(&free["followed_per_s"]);
    for (a, b) in followed.iter().zip(support::numbers(&free["softer_per_s"])) {
        assert!((a / b - 1.0).abs() < 1e-3, "{a} {b}");
    }
}

/// A sun alone on k and c to ground whirls in the inertial frame at `−c/2m ± i ω`: in the frame of the carrier at `−c/2m ± i (ω ± Ω)`.
#[test]
fn exact_damper_to_ground_in_a_turning_frame() {
    let (m, k, c) = (0.4f64, 1e8f64, 800.0f64);
    let text = turning(|text| {
        text.replace("k_sun = \"5e8 N/m\"", "k_sun = \"1e-3 N/m\"")
            .replace(
                "at = \"sun\"\nk_radial = \"1e8 N/m\"",
                "at = \"sun\"\nk_radial = \"1e8 N/m\"\nc_radial = \"800 N·s/m\"",
            )
    });
    let modes = at_speed(&text, true).unwrap();
    let omega = 1000.0 * TAU / 60.0;
    let own = (k / m - (c / (2.0 * m)).powi(2)).sqrt();
    for wanted in [own - omega, own + omega] {
        let near = |m: &&Mode| (m.eigenvalue.im / wanted - 1.0).abs() < 1e-9;
        let found = modes
            .iter()
            .find(near)
            .unwrap_or_else(|| panic!("no root at {wanted}"));
        assert!(
            (found.eigenvalue.re + c / (2.0 * m)).abs() < 1e-6 * c / m,
            "{}",
            found.eigenvalue
        );
    }
}

/// What would make the equations periodic in the carrier's frame is refused at speed, and taken at rest.
#[test]
fn refuses_what_varies_in_a_turning_frame() {
    let sun = "at = \"sun\"\nk_radial = \"1e8 N/m\"";
    for (from, to, named) in [
        (
            sun,
            "at = \"sun\"\nk_x = \"1e8 N/m\"\nk_y = \"2e8 N/m\"",
            "same in all directions",
        ),
        (
            sun,
            "at = \"sun\"\nk_radial = \"1e8 N/m\"\nc_x = \"100 N·s/m\"",
            "same in all directions",
        ),
        (
            sun,
            "at = \"sun\"\nk_x = \"1e8 N/m\"\nk_y = \"1e8 N/m\"\n\n[[bearing]]\nname = \"sun_more\"\nat = \"sun\"\nk_x = \"1e7 N/m\"\nloss_factor = 0.1\n\n[[bearing]]\nname = \"sun_most\"\nat = \"sun\"\nk_y = \"1e7 N/m\"",
            "same in all directions",
        ),
        (
            sun,
            "at = \"sun\"\nk_x = \"1e8 N/m\"\nk_y = \"1e8 N/m\"\n\n[[bearing]]\nname = \"sun_more\"\nat = \"sun\"\nk_x = \"1e7 N/m\"\ndamping_ratio = 0.1\n\n[[bearing]]\nname = \"sun_most\"\nat = \"sun\"\nk_y = \"1e7 N/m\"",
            "same in all directions",
        ),
        (
            "[[planetary]]",
            "[damping]\nrayleigh_mass = \"2 1/s\"\n\n[[planetary]]",
            "rayleigh_mass",
        ),
        (
            sun,
            "at = \"sun\"\nk_radial = \"1e8 N/m\"\n\n[[inertia]]\nname = \"wheel\"\nJ = \"0.01 kg·m²\"\nmass = \"1 kg\"\n\n[[bearing]]\nname = \"joint\"\nbetween = [\"sun\", \"wheel\"]\nk_radial = \"1e7 N/m\"\nk_theta = \"1e5 N·m/rad\"",
            "outside that frame",
        ),
    ] {
        let text = turning(|text| text.replacen(from, to, 1));
        let message = at_speed(&text, true)
            .err()
            .unwrap_or_else(|| panic!("{named} was taken"));
        assert!(message.contains(named), "{message}");
        let rest = prepared(&text).unwrap();
        let study = ModesStudy::default();
        assert!(run(&rest, &study, &ModesPlan::plan_modes(&rest, &study)).is_ok());
    }
}
