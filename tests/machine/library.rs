//! The library's surface: the example programs run, and a model is the same from a file, from text and from the builder.

#[path = "../../examples/gear_mesh.rs"]
mod gear_mesh;
#[path = "../../examples/identify.rs"]
mod identify;
#[path = "../../examples/modes.rs"]
mod modes;
#[path = "../../examples/parameter_study.rs"]
mod parameter_study;
#[path = "../../examples/response.rs"]
mod response;
#[path = "../../examples/simulate.rs"]
mod simulate;
#[path = "../../examples/transmission_error.rs"]
mod transmission_error;

use std::f64::consts::PI;

use geardyn::prelude::*;
use geardyn::{ReductionKind, ReductionStudy, SpeedRange};

#[test]
fn examples_run() {
    gear_mesh::main().unwrap();
    identify::main().unwrap();
    modes::main().unwrap();
    parameter_study::main().unwrap();
    response::main().unwrap();
    simulate::main().unwrap();
    transmission_error::main().unwrap();
}

const TWO_DISCS: &str = r#"
inertia = [{ name = "motor", J = "0.02 kg·m²" }, { name = "work", J = "0.05 kg·m²" }]
shaft = [{ name = "shaft_1", between = ["motor", "work"], k = "12000 N·m/rad" }]
"#;

fn two_discs() -> ModelBuilder {
    Model::builder()
        .inertia("motor", 0.02)
        .inertia("work", 0.05)
        .shaft("motor", "work", 1.2e4)
}

fn frequencies(model: &Model) -> Vec<f64> {
    let modes = model.machine().unwrap().modes(&ModesStudy::default());
    modes.unwrap().iter().map(|m| m.frequency_hz).collect()
}

/// Two discs on a shaft: `ω² = k (1/J₁ + 1/J₂)`, from text and from the builder.
#[test]
fn exact_two_discs_built_and_parsed() {
    let exact = (1.2e4_f64 * (1.0 / 0.02 + 1.0 / 0.05)).sqrt() / std::f64::consts::TAU;
    let built = frequencies(&two_discs().build().unwrap());
    assert_eq!(built, frequencies(&Model::parse(TWO_DISCS).unwrap()));
    let error = (built[1] / exact - 1.0).abs();
    crate::support::within("frequency", error, 1e-14);
}

/// Results name degrees of freedom and elements.
#[test]
fn results_own_their_names() {
    let machine = two_discs().build().unwrap().machine().unwrap();
    let modes = machine.modes(&ModesStudy::default()).unwrap();
    assert_eq!(modes.dofs, machine.dofs());
    let ratio =
        modes.component(1, "work.theta").unwrap() / modes.component(1, "motor.theta").unwrap();
    assert!((ratio.re + 0.4).abs() < 1e-12, "{ratio}");
    assert_eq!(modes.component(1, "nobody.theta"), None);
    assert!(modes[1].dominant_element().is_some());
}

/// Guyan's reduction keeps the inertia of the rigid body, and its frequencies are above those of the machine.
#[test]
fn reduced_machines_with_their_errors() {
    let model = two_discs()
        .inertia("fan", 0.01)
        .shaft("work", "fan", 3e4)
        .build();
    let machine = model.unwrap().machine().unwrap();
    let reduce = ReductionStudy {
        method: ReductionKind::Guyan,
        keep: vec!["motor".into(), "work".into()],
        max_frequency_hz: 150.0,
        modes: None,
    };
    let modes = machine.modes(&ModesStudy {
        reduce: Some(reduce),
        ..ModesStudy::default()
    });
    let modes = modes.unwrap();
    let reduced = modes.reduction.unwrap();
    let inertia: f64 = reduced.mass.iter().flatten().sum();
    assert!((inertia - 0.08).abs() < 1e-15, "{inertia}");
    // The fan follows the work.
    let fan = modes.dofs.iter().position(|d| d == "fan.theta").unwrap();
    let follows = &reduced.transformation[fan];
    assert!(follows[0].abs() < 1e-15 && (follows[1] - 1.0).abs() < 1e-15);
    assert_eq!(reduced.full_frequency_hz[1], modes.modes[1].frequency_hz);
    assert!(reduced.frequency_hz[1] > reduced.full_frequency_hz[1]);
    assert!(reduced.error.measured > 0.0 && reduced.error.measured < reduced.error.estimate);
}

/// The speed map at one speed is the error at this speed; the record has the sum of the squares of its components.
#[test]
fn transmission_errors_over_speed_and_angle() {
    let machine = Model::open("examples/y2250_index_te.toml")
        .unwrap()
        .machine();
    let error = machine.unwrap().transmission_error(&TransmissionStudy {
        driver: Some("index_gear_1".into()),
        output: Some("work_spindle".into()),
        speed: Some(100.0),
        speeds: Some(SpeedRange {
            from: 50.0,
            to: 100.0,
            count: 3,
        }),
        record: true,
        ..TransmissionStudy::default()
    });
    let error = error.unwrap();
    let map = error.over_speed.unwrap();
    for (component, amplitudes) in error.components.iter().zip(&map.amplitudes) {
        let at_speed = component.value_at_speed.unwrap().norm();
        assert!((amplitudes[2] - at_speed).abs() <= 1e-12 * at_speed);
    }
    let record = error.record.unwrap();
    let mean_square: f64 =
        record.values.iter().map(|v| v * v).sum::<f64>() / record.values.len() as f64;
    let squares = error
        .components
        .iter()
        .map(|c| c.value_at_speed.unwrap().norm_sqr());
    let expected = 0.5 * squares.sum::<f64>();
    assert!(
        (mean_square / expected - 1.0).abs() < 1e-9,
        "{mean_square} {expected}"
    );
    assert!(record.total_deviation >= record.deviation_per_revolution);
}

/// The energy of a motion is balanced.
#[test]
fn motions_with_their_energy() {
    let machine = Model::open("examples/linear_chain.toml").unwrap().machine();
    let motion = machine.unwrap().simulate(&SimulateStudy {
        end_time: Some(0.01),
        energy: true,
        ..SimulateStudy::default()
    });
    let energy = motion.unwrap().energy.unwrap();
    assert!(energy.work_in > 0.0 && energy.relative_error().abs() < 1e-6);
}

/// Two encoders: the amplitudes that made the shipped log are found within three standard deviations.
#[test]
fn transmission_errors_of_encoders() {
    let recording = Recording::open("data/y2250_te.csv").unwrap();
    let study = EncoderStudy::new("index_gear_1", "work_spindle", "30:37,54:36,1:90").unwrap();
    let wrong = EncoderStudy {
        lines: Some((10_000, 18_000)),
        ..study.clone()
    };
    let text = recording
        .transmission_error(&wrong)
        .unwrap_err()
        .to_string();
    assert!(text.contains("ratio"), "{text}");
    let error = recording.transmission_error(&EncoderStudy {
        lines: Some((10_000, 36_000)),
        ..study
    });
    let flank = &error.unwrap().flanks[0];
    let truth = [
        (1.0, 10.6952),
        (60.0, 0.8130),
        (74.0, 0.9888),
        (90.0, 4.5837),
        (180.0, 0.9168),
    ];
    for (order, arcsec) in truth {
        let line = flank.orders.iter().find(|o| o.order == order).unwrap();
        let error = line.amplitude - arcsec * PI / 648_000.0;
        assert!(
            error.abs() < 3.0 * line.amplitude_std,
            "order {order}: {error}"
        );
        let (low, high) = line.interval.unwrap();
        assert!(low < line.amplitude && line.amplitude < high);
        assert!(line.significant && !line.sources.is_empty());
    }
    assert!(EncoderStudy::new("a", "b", "30").is_err());
    let same = EncoderStudy::new("work_spindle", "work_spindle", "1:90").unwrap();
    let missing = EncoderStudy {
        input: vec![],
        ..same.clone()
    };
    let without_lines = EncoderStudy {
        lines: Some((0, 36_000)),
        input: vec!["index_gear_1".into()],
        ..same.clone()
    };
    for wrong in [same, missing, without_lines] {
        let errors = recording.transmission_error(&wrong).unwrap_err();
        assert!(errors.to_string().contains("encoder"), "{errors}");
    }
}

/// A wrong value in the builder is refused as in a file.
#[test]
fn the_builder_is_checked_by_the_reader() {
    let errors = two_discs()
        .shaft("motor", "nobody", 1.0)
        .build()
        .and_then(|m| m.machine().map(|_| ()));
    let text = errors.unwrap_err().to_string();
    assert!(text.contains("nobody"), "{text}");
    let errors = Model::builder().inertia("a\"b", -1.0).build().unwrap_err();
    assert!(errors.to_string().contains('J'), "{errors}");
}

/// Two channels of arrays: wrong shapes are refused, a tone is found.
#[test]
fn recordings_from_arrays() {
    let tone: Vec<f64> = (0..8192).map(|k| (0.1 * f64::from(k)).sin()).collect();
    let recording = Recording::from_arrays(1000.0, &[("ax", "m/s²", &tone)]).unwrap();
    let spectrum = recording.spectrum(&SpectrumStudy::default()).unwrap();
    let curve = &spectrum.channel_spectra[0];
    assert_eq!(curve.value.len(), spectrum.abscissa.len());
    for channels in [
        vec![("a", "", &tone[..]), ("b", "", &tone[1..])],
        vec![("a", "", &tone[..]), ("a", "", &tone[..])],
        vec![("a", "", &[f64::NAN][..])],
        vec![],
    ] {
        assert!(Recording::from_arrays(1000.0, &channels).is_err());
    }
    assert!(Recording::from_arrays(0.0, &[("ax", "", &tone)]).is_err());
}

/// A log whose sidecar lists the files of a test is refused, as by the command.
#[test]
fn refuses_a_log_of_a_list() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("hit.csv");
    std::fs::write(&log, "t,f\n0,1\n1,2\n2,1\n").unwrap();
    let list = "[log]\nfiles = [\"hit.csv\", \"other.csv\"]\n";
    std::fs::write(folder.path().join("hit.toml"), list).unwrap();
    let errors = Recording::open(&log).unwrap_err();
    assert!(errors.to_string().contains("lists 2 files"), "{errors}");
}
