//! Planets that do not move sideways ride with the carrier.

use geardyn::plan::prepared::Prepared;
use geardyn::plan::run::run;
use geardyn::plan::stages::Plan;
use geardyn::scene;
use geardyn::scene::study::ModesStudy;

fn first_hz(lateral: &str) -> f64 {
    let text = format!(
        "title = \"t\"\nsource = \"test\"\nunits = \"SI\"\n\
         [[inertia]]\nname = \"sun\"\nJ = 0.5\nmass = 5.0\n[[inertia]]\nname = \"carrier\"\nJ = 10.0\nmass = 50.0\n[[inertia]]\nname = \"anchor\"\nJ = 100.0\n\
         [[planetary]]\nname = \"stage\"\nsun = \"sun\"\nring = \"ground\"\ncarrier = \"carrier\"\nplanets = 3\nteeth = [20, 31, 82]\nmodule = 0.006\nplanet_J = 0.01\nplanet_mass = 10.0\nk_sun = 1e12\nk_ring = 1e12\n{lateral}\n\
         [[shaft]]\nname = \"out\"\nbetween = [\"carrier\", \"anchor\"]\nk = 1e6\n\
         [[bearing]]\nname = \"s\"\nat = \"sun\"\nk_radial = 1e12\n[[bearing]]\nname = \"c\"\nat = \"carrier\"\nk_radial = 1e12\n"
    );
    let scene = scene::read_text("test.toml", &text).unwrap_or_else(|e| panic!("{e}"));
    let prepared = Prepared::new(&scene.model).unwrap_or_else(|e| panic!("{e}"));
    let study = ModesStudy::default();
    let answer = run(&prepared, &study, &Plan::modes(&prepared, &study)).unwrap();
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
        Prepared::new(&scene.model)
            .err()
            .unwrap()
            .message
            .contains("stage")
    );
}
