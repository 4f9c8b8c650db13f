//! Measured logs with known answers, from the command line with default settings. The folder of logs is no part of the project:
//! GEARDYN_RECORDINGS names it, and without it these tests show as ignored.

use std::f64::consts::TAU;
use std::io::Read;
use std::path::PathBuf;

use serde_json::Value;

use crate::support::command::{document, geardyn};
use crate::support::verification::printed;

fn log(name: &str) -> String {
    let folder = std::env::var("GEARDYN_RECORDINGS").unwrap();
    PathBuf::from(folder).join(name).display().to_string()
}

/// A known number, to a relative tolerance; both stand in the manual.
fn near(what: &str, unit: &str, expected: f64, found: f64, tolerance: f64) {
    printed(what, unit, expected, found, tolerance * expected);
}

/// Known modes `(frequency in Hz, damping ratio)`: frequencies to a relative tolerance, damping ratios to 15 %.
fn near_modes(found: &Value, known: &[(f64, f64)], tolerance: f64) {
    for (frequency, damping) in known {
        let (f, zeta) = mode(found, *frequency);
        near(
            &format!("mode at {frequency} Hz"),
            "Hz",
            *frequency,
            f,
            tolerance,
        );
        near(
            &format!("damping ratio at {frequency} Hz"),
            "",
            *damping,
            zeta,
            0.15,
        );
    }
}

/// Frequency and damping of the identified mode nearest to `frequency_hz`.
fn mode(found: &Value, frequency_hz: f64) -> (f64, f64) {
    let modes = found["modes"].as_array().unwrap();
    let pair = |m: &Value| {
        (
            m["frequency_hz"].as_f64().unwrap(),
            m["damping_ratio"].as_f64().unwrap(),
        )
    };
    let off = |m: &(f64, f64)| (m.0 - frequency_hz).abs();
    modes
        .iter()
        .map(pair)
        .min_by(|a, b| off(a).total_cmp(&off(b)))
        .unwrap_or_else(|| panic!("no modes"))
}

/// Stamps of a drifting, jittered clock: the mean rate, not the median step; the jitter is said.
/// Source: measured log of Raspberry-Pi-CNC-Tap-Tester, as analysed there.
#[test]
#[cfg_attr(
    not(recordings),
    ignore = "set GEARDYN_RECORDINGS to the folder of measured logs"
)]
fn ref_spindle_tap_has_its_mean_rate() {
    let found = document(&[
        "check",
        &log("pimodal_cnc_tap/tap_20260622_163222.csv"),
        "--json",
    ]);
    near(
        "sampling rate",
        "Hz",
        331.416,
        found["rate_hz"].as_f64().unwrap(),
        1e-3,
    );
    assert_eq!(found["repairs"][0]["kind"], "resampled");
    assert!(
        found["repairs"][0]["message"]
            .as_str()
            .unwrap()
            .contains("2.90 ms to 3.50 ms")
    );
}

/// Rates and rows of measured logs, by header or stamps.
/// Source: rows and rates published with each log.
#[test]
#[cfg_attr(
    not(recordings),
    ignore = "set GEARDYN_RECORDINGS to the folder of measured logs"
)]
fn ref_rates_and_rows() {
    let known = [
        (
            "cessipy_smartphone/Example02_Smartphone_Data.csv",
            425.08,
            25_291,
        ),
        ("dropbear/slow_10steps_test8.txt", 5000.0, 70_000),
        ("dropbear/random_set0_test0.txt", 5000.0, 60_000),
        ("munich_bridge/AllM100Hz.csv.zip", 100.0, 72_000),
        (
            "munich_bridge/ReferenceStateINCAt100Hz.csv.zip",
            100.0,
            60_000,
        ),
        ("echeynet_bridge/BridgeData.mat", 15.0, 54_000),
        ("ladisk_beam_camera/acceleration.lvm", 50_000.0, 50_030),
        (
            "pyuff_samples/MPSTD#Set001_2024_10_08_10_27_07.uff",
            3200.0,
            222_400,
        ),
        ("pyuff_samples/Sample_UFF58_ascii.uff", 0.0, 79_292),
        ("pyuff_samples/Sample_UFF58b_bin.uff", 0.0, 79_292),
    ];
    for (name, rate, rows) in known {
        let found = document(&["check", &log(name), "--json"]);
        if rate > 0.0 {
            near(name, "Hz", rate, found["rate_hz"].as_f64().unwrap(), 1e-4);
        }
        assert_eq!(found["samples"].as_u64(), Some(rows), "{name}");
    }
    let stamped = document(&[
        "check",
        &log("munich_bridge/ReferenceStateINCAt100Hz.csv.zip"),
        "--json",
    ]);
    assert!(
        stamped["repairs"][0]["message"]
            .as_str()
            .unwrap()
            .contains("rounded to 1.00 ms")
    );
}

/// A header that no longer holds is not believed, and neither is a guess.
#[test]
#[cfg_attr(
    not(recordings),
    ignore = "set GEARDYN_RECORDINGS to the folder of measured logs"
)]
fn refuses_rates_that_disagree_or_lack() {
    let stale = log("arts_beam_lvm/data_set_1_downsampled_by_16.lvm");
    let refused = geardyn(&["check", &stale]);
    assert_eq!(refused.status.code(), Some(2));
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(said.contains("51200 Hz") && said.contains("3200"), "{said}");
    assert!(said.contains("--rate-from time"), "{said}");
    let taken = document(&["check", &stale, "--rate-from", "time", "--json"]);
    let rate = taken["rate_hz"].as_f64().unwrap();
    assert!((rate - 3200.0).abs() < 3.2e-3, "{rate}");
    let bare = geardyn(&["check", &log("f16_vibration/f-16.txt")]);
    assert_eq!(bare.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&bare.stderr).contains("--rate"));
}

/// One hit on a beam: three modes by one response.
/// Source: measured beam of ladisk/ImageBasedModalAnalysisTutorial; modes by its least-squares complex frequency fit.
#[test]
#[cfg_attr(
    not(recordings),
    ignore = "set GEARDYN_RECORDINGS to the folder of measured logs"
)]
fn ref_impact_on_a_beam() {
    let name = log("ladisk_beam_camera/acceleration.lvm");
    let found = document(&[
        "identify",
        &name,
        "--input",
        "Force (Trigger)",
        "--output",
        "Acceleration (Trigger)",
        "--json",
    ]);
    let known = [(695.8, 0.0047), (1898.0, 0.0031), (3671.2, 0.0020)];
    near_modes(&found, &known, 2e-3);
}

/// Six responses of a beam to one force: its bending modes.
/// Source: measured beam of sdypy-EMA; modes by its least-squares complex frequency fit.
#[test]
#[cfg_attr(
    not(recordings),
    ignore = "set GEARDYN_RECORDINGS to the folder of measured logs"
)]
fn ref_six_responses_of_a_beam() {
    let found = document(&[
        "identify",
        &log("sdypy_ema_beam/sdypy_beam_frf_resp1.csv"),
        "--band",
        "10:5000",
        "--json",
    ]);
    let known = [
        (177.05, 0.0080),
        (477.37, 0.0017),
        (933.10, 0.0015),
        (1535.48, 0.0020),
        (2286.86, 0.0028),
        (3162.52, 0.0018),
        (4181.87, 0.0015),
    ];
    near_modes(&found, &known, 5e-3);
    for (frequency, _) in known {
        let all = found["modes"].as_array().unwrap().iter();
        let off = |m: &Value| m["frequency_hz"].as_f64().unwrap() / frequency - 1.0;
        assert_eq!(
            all.filter(|m| off(m).abs() < 5e-3).count(),
            1,
            "{frequency} Hz"
        );
    }
}

/// Hits of a plate one after the other, as a log.
fn plate(plate: usize, hits: std::ops::RangeInclusive<usize>, folder: &std::path::Path) -> String {
    let mut all = String::from("force,acceleration\n");
    for hit in hits {
        let name = log(&format!("tonewood_plates/plate_{plate}_hit_{hit}.csv.gz"));
        let mut text = String::new();
        let file = std::fs::File::open(name).unwrap();
        flate2::read::GzDecoder::new(file)
            .read_to_string(&mut text)
            .unwrap();
        all.extend(text.lines().skip(1).flat_map(|row| [row, "\n"]));
    }
    let path = folder.join("plate.csv");
    std::fs::write(&path, all).unwrap();
    path.display().to_string()
}

/// Frequency and half its 95 % interval of every mode, weak ones too.
fn plate_modes(path: &str, band: &str) -> Vec<(f64, f64)> {
    let found = document(&[
        "identify",
        path,
        "--rate",
        "48000",
        "--input",
        "force",
        "--output",
        "acceleration",
        "--kind",
        "accelerance",
        "--band",
        band,
        "--all",
        "--json",
    ]);
    let of = |m: &Value| {
        let std = m["frequency_std_hz"].as_f64().unwrap();
        (m["frequency_hz"].as_f64().unwrap(), 1.96 * std)
    };
    found["modes"].as_array().unwrap().iter().map(of).collect()
}

/// Five plates, five hits each, that place resonances differently: every peak is a mode, and one. The first three hits and the last two
/// agree within their intervals.
/// Source: measured spruce plates of Data-driven-characterization-of-spruce-tonewood-plates (commit 897fe345).
#[test]
#[cfg_attr(
    not(recordings),
    ignore = "set GEARDYN_RECORDINGS to the folder of measured logs"
)]
fn ref_plates_of_five_hits() {
    let folder = tempfile::tempdir().unwrap();
    let known = std::fs::read_to_string(log("tonewood_plates/reference.json")).unwrap();
    let known: Value = serde_json::from_str(&known).unwrap();
    let (mut found, mut missed, mut several) = (0, 0, 0);
    let (mut agree, mut both) = (0, 0);
    for k in 1..=5 {
        let all = plate_modes(&plate(k, 1..=5, folder.path()), "40:700");
        let peaks: Vec<f64> = (known["peaks_hz"][format!("plate_{k}")].as_array().unwrap())
            .iter()
            .map(|f| f.as_f64().unwrap())
            .collect();
        for (at, peak) in peaks.iter().enumerate() {
            // Half the way to the next peak, and no farther than 1 %.
            let next = (0..peaks.len()).filter(|&o| o != at);
            let apart = next.map(|o| (peaks[o] - peak).abs() / 2.0);
            let reach = apart.fold(0.01 * peak, f64::min).max(0.5);
            match all.iter().filter(|m| (m.0 - peak).abs() <= reach).count() {
                0 => missed += 1,
                1 => found += 1,
                _ => several += 1,
            }
        }
        let first = plate_modes(&plate(k, 1..=3, folder.path()), "40:700");
        let last = plate_modes(&plate(k, 4..=5, folder.path()), "40:700");
        for (f, interval) in &first {
            let near = last
                .iter()
                .min_by(|a, b| (a.0 - f).abs().total_cmp(&(b.0 - f).abs()));
            if let Some((g, other)) = near.filter(|m| (m.0 / f - 1.0).abs() < 0.005) {
                both += 1;
                agree += usize::from((f - g).abs() < interval.hypot(*other));
            }
        }
    }
    eprintln!("{found} found, {missed} missed, {several} several; {agree} of {both} agree");
    assert!(found >= 61 && missed <= 2 && several <= 3);
    assert!(10 * agree >= 9 * both);
}

/// The whole file, unasked: the first mode is a hundredth as high as the last.
/// Source: measured beam of sdypy-EMA; modes by its least-squares complex frequency fit.
#[test]
#[cfg_attr(
    not(recordings),
    ignore = "set GEARDYN_RECORDINGS to the folder of measured logs"
)]
fn ref_six_responses_of_a_beam_over_four_decades() {
    let name = log("sdypy_ema_beam/sdypy_beam_frf_resp1.csv");
    let found = document(&["identify", &name, "--json"]);
    let known = [
        (177.05, 0.0080),
        (477.37, 0.0017),
        (933.10, 0.0015),
        (1376.7, 0.0034),
        (1535.48, 0.0020),
        (2286.86, 0.0028),
        (3162.52, 0.0018),
        (4181.87, 0.0015),
    ];
    near_modes(&found, &known, 5e-3);
    for (frequency, _) in known {
        let (f, _) = mode(&found, frequency);
        let certain = found["modes"].as_array().unwrap().iter();
        let near_it = |m: &&Value| (m["frequency_hz"].as_f64().unwrap() / f - 1.0).abs() < 0.005;
        let all: Vec<&Value> = certain.filter(near_it).collect();
        assert_eq!(all.len(), 1, "{frequency} Hz is found once: {all:?}");
        assert!(all[0]["frequency_std_hz"].is_number(), "{all:?}");
    }
}

/// A slab's first mode. The peak of its spectrum is stated, in steps of 0.21 Hz; the subspace method, with an interval, says where the
/// middle of that flat peak lies.
/// Source: measured slab of CESSIPy (commit d8f1138a), its published modes.
#[test]
#[cfg_attr(
    not(recordings),
    ignore = "set GEARDYN_RECORDINGS to the folder of measured logs"
)]
fn ref_slab_by_a_telephone() {
    let name = log("cessipy_smartphone/Example02_Smartphone_Data.csv");
    let of = |more: &[&str]| {
        let flags = ["identify", &name, "--output", "Z-Axis", "--json"];
        document(&[&flags[..], more].concat())
    };
    let peaks = of(&["--method", "fdd"]);
    let frequencies = peaks["modes"].as_array().unwrap().iter();
    let peak = frequencies
        .map(|m| m["frequency_hz"].as_f64().unwrap())
        .min_by(|a, b| (a - 17.85).abs().total_cmp(&(b - 17.85).abs()))
        .unwrap();
    printed("peak of the spectra", "Hz", 17.85, peak, 0.1);
    let found = of(&["--all"]);
    let (f, _) = mode(&found, 17.85);
    let modes = found["modes"].as_array().unwrap();
    let own = modes.iter().find(|m| m["frequency_hz"] == f).unwrap();
    let std = own["frequency_std_hz"].as_f64().unwrap();
    // The frequency falls with amplitude: the standard deviation over parts of the record is wide.
    assert!((f - 17.85).abs() < 2.5 * std && std < 0.25, "{f} ± {std}");
}

/// A frequency response that an analyser wrote: its mode.
/// Source: measured response of the Vibration Toolbox, its published modes.
#[test]
#[cfg_attr(
    not(recordings),
    ignore = "set GEARDYN_RECORDINGS to the folder of measured logs"
)]
fn ref_response_of_an_analyser() {
    let found = document(&[
        "identify",
        &log("vibration_toolbox_frf/case1.mat"),
        "--json",
    ]);
    near_modes(&found, &[(212.09, 0.00087)], 1e-3);
}

/// A frame of five storeys from responses alone.
/// Source: simulated frame of koma (commit e28269d5), exact modes.
#[test]
#[cfg_attr(
    not(recordings),
    ignore = "set GEARDYN_RECORDINGS to the folder of measured logs"
)]
fn ref_frame_from_responses_alone() {
    let name = log("koma_shearframe/koma_shearframe.csv");
    let found = document(&[
        "identify",
        &name,
        "--output",
        "L1,L2,L3,L4,L5",
        "--rate",
        "12",
        "--all",
        "--json",
    ]);
    // The damping of the first and the third mode is not known: 4.5 ± 8.6 and 0.54 ± 0.55 %, so that they are weak. Of the first the lowest sample rate has five parts; it is 0.505 % off, 0.2 of its standard deviation.
    for (omega, tolerance) in [
        (1.136, 6e-3),
        (3.297, 5e-3),
        (5.149, 5e-3),
        (6.556, 5e-3),
        (7.441, 5e-3),
    ] {
        let f = omega / TAU;
        let what = format!("mode of {omega} rad/s");
        near(&what, "rad/s", omega, TAU * mode(&found, f).0, tolerance);
    }
}

/// A suspension bridge from five responses alone.
/// Source: simulated bridge of ECheynet/SSICOV (commit 82ce27aa), its six exact modes.
#[test]
#[cfg_attr(
    not(recordings),
    ignore = "set GEARDYN_RECORDINGS to the folder of measured logs"
)]
fn ref_bridge_from_responses_alone() {
    let name = log("echeynet_bridge/BridgeData.mat");
    let found = document(&[
        "identify",
        &name,
        "--output",
        "rz 1,rz 2,rz 3,rz 4,rz 5",
        "--json",
    ]);
    for f in [0.2046, 0.3189, 0.4391, 0.5852, 0.8643, 1.1944] {
        near(&format!("mode at {f} Hz"), "Hz", f, mode(&found, f).0, 2e-2);
    }
}

/// One channel of a bridge: its four modes; others are possible, no answer is known of them.
/// Source: measured test bridge of imcs-compsim/munich-bridge-data (commit f1057c12).
#[test]
#[cfg_attr(
    not(recordings),
    ignore = "set GEARDYN_RECORDINGS to the folder of measured logs"
)]
fn ref_bridge_of_one_channel_from_responses_alone() {
    let name = log("munich_bridge/AllM100Hz.csv.zip");
    let channels = document(&["check", &name, "--json"]);
    let channel = channels["channels"][0]["name"].as_str().unwrap();
    let arguments = ["identify", &name, "--output", channel, "--all", "--json"];
    let found = document(&arguments);
    for f in [10.79, 12.65, 13.62, 16.26] {
        near(&format!("mode at {f} Hz"), "Hz", f, mode(&found, f).0, 1e-2);
    }
}

/// A plate whose two poles about 207 Hz took each other's place in a wide band, so that neither was a mode: one mode there, whatever the
/// band.
/// Source: as the five plates above; a peak of its mean response that all hits show.
#[test]
#[cfg_attr(
    not(recordings),
    ignore = "set GEARDYN_RECORDINGS to the folder of measured logs"
)]
fn ref_a_peak_of_a_plate_in_every_band() {
    let folder = tempfile::tempdir().unwrap();
    let path = plate(4, 1..=5, folder.path());
    for band in ["40:700", "100:300", "200:500"] {
        let modes = plate_modes(&path, band);
        let near = modes.iter().filter(|m| (m.0 - 207.5).abs() <= 1.5);
        assert_eq!(near.count(), 1, "{band}: {modes:?}");
    }
}
