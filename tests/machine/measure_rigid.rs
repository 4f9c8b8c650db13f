//! A pair that rolls rigidly: its record from pitch and profile, and back.

use std::f64::consts::TAU;

use crate::support::verification::within;
use geardyn::internals::base::code::Code;
use geardyn::internals::gear::measurement::unloaded_te::{
    FlankDeviations, separate_pitch_and_profile, te_against_master, te_of_pair,
};
use geardyn::internals::te_record::single_flank::SingleFlankRecord;

const BASE_PITCH: f64 = 8.856e-3;

fn along(reach: f64, points: usize) -> Vec<f64> {
    (0..points)
        .map(|i| 4e-3 + reach * i as f64 / (points - 1) as f64)
        .collect()
}

fn near(found: f64, expected: f64, tolerance: f64) {
    within("values, absolute", (found - expected).abs(), tolerance);
}

/// Perfect profiles with pitch errors: at each place the tooth further out carries, so the record is the larger of the two in contact.
#[test]
fn exact_pitch_alone() {
    let places = [0.0, 3e-6, -2e-6, 5e-6, 1e-6];
    let along = along(1.4 * BASE_PITCH, 30);
    let flat = [vec![0.0; 30]];
    let flanks = FlankDeviations {
        pitch_surplus: &places,
        roll: &along,
        profiles: &flat,
    };
    let record = te_against_master(&flanks, BASE_PITCH, 100).unwrap();
    assert_eq!(record.len(), 500);
    for j in 0..5 {
        // From 0 to 0.4 pitches the tooth before is still in contact.
        let both = places[j].max(places[(j + 4) % 5]);
        near(record[100 * j + 20], both, 0.0);
        near(record[100 * j + 70], places[j], 0.0);
    }
    let composite = SingleFlankRecord::new(&record, 1, 5, true).unwrap();
    near(composite.total_deviation(), 7e-6, 1e-18);
}

/// Crowned profiles: neighbours hand over where their parabolas cross, half a pitch from the middle; f_i′ is the parabola's drop there.
#[test]
fn exact_crowned_profiles() {
    let reach = 1.6 * BASE_PITCH;
    let along = along(reach, 2001);
    let middle = 4e-3 + 0.5 * reach;
    let crown = 6e-6;
    let parabola = |s: f64| -crown * (2.0 * (s - middle) / reach).powi(2);
    let profile = [along.iter().map(|&s| parabola(s)).collect()];
    let places = [0.0; 12];
    let flanks = FlankDeviations {
        pitch_surplus: &places,
        roll: &along,
        profiles: &profile,
    };
    let record = te_against_master(&flanks, BASE_PITCH, 400).unwrap();
    let drop = -parabola(middle + 0.5 * BASE_PITCH);
    let composite = SingleFlankRecord::new(&record, 1, 12, true).unwrap();
    near(composite.ranges_per_pitch().sliding, drop, 1e-11);
    near(composite.split_by_order().long_range, 0.0, 1e-18);
}

/// Both gears' surpluses add; the record closes after the full hunting cycle, and with a mate without errors is that with a master.
#[test]
fn law_pair_adds_up() {
    let (z1, z2) = (6, 9);
    let line = along(1.5 * BASE_PITCH, 50);
    let centre = 2.0 * 4e-3 + 1.5 * BASE_PITCH;
    let eccentric = |z: usize, a: f64| -> Vec<f64> {
        (0..z)
            .map(|j| a * (TAU * j as f64 / z as f64).cos())
            .collect()
    };
    let (first, second) = (eccentric(z1, 4e-6), eccentric(z2, 3e-6));
    let flat = [vec![0.0; 50]];
    let flanks = |places| FlankDeviations {
        pitch_surplus: places,
        roll: &line,
        profiles: &flat,
    };
    let pair = te_of_pair(&flanks(&first), &flanks(&second), BASE_PITCH, centre, 60).unwrap();
    assert_eq!(
        pair.len(),
        18 * 60,
        "18 pitches until the same teeth meet again"
    );
    let none = vec![0.0; z2];
    let alone = te_of_pair(&flanks(&first), &flanks(&none), BASE_PITCH, centre, 60).unwrap();
    let master = te_against_master(&flanks(&first), BASE_PITCH, 60).unwrap();
    for (i, e) in alone.iter().enumerate() {
        near(*e, master[i % master.len()], 1e-20);
    }
    // In the stretch where one pair touches alone the sum is plain.
    for tooth in 0..18 {
        near(
            pair[60 * tooth + 45],
            first[tooth % z1] + second[tooth % z2],
            1e-20,
        );
    }
}

/// Charts to record and back: places and mean profile of the stretch with one pair are recovered; nothing else is claimed.
#[test]
fn law_round_trip() {
    let z = 17;
    let places: Vec<f64> = (0..z)
        .map(|j| 1e-6 * ((7 * j * j + 3 * j) % 11) as f64)
        .collect();
    let mean = places.iter().sum::<f64>() / z as f64;
    let overlap = 1.45;
    let along = along(overlap * BASE_PITCH, 400);
    let shape = |s: f64| 2e-6 * (400.0 * s).sin();
    let profiles = [along.iter().map(|&s| shape(s)).collect()];
    let flanks = FlankDeviations {
        pitch_surplus: &places,
        roll: &along,
        profiles: &profiles,
    };
    let record = te_against_master(&flanks, BASE_PITCH, 200).unwrap();
    let teeth = separate_pitch_and_profile(&record, z, overlap, Some(0.1e-6)).unwrap();
    for (found, place) in teeth.pitch_surplus.iter().zip(&places) {
        near(found.value, place - mean, 1e-18);
    }
    assert!(teeth.max_residual < 1e-18);
    assert!(teeth.roll[0] > 0.45 && *teeth.roll.last().unwrap() < 1.0);
    let true_profile: Vec<f64> = teeth
        .roll
        .iter()
        .map(|r| shape(4e-3 + r * BASE_PITCH))
        .collect();
    let middle = true_profile.iter().sum::<f64>() / true_profile.len() as f64;
    for (found, truth) in teeth.profile.iter().zip(&true_profile) {
        // Straight lines between the points of the profile: (Δs)² p″/8.
        near(found.value, truth - middle, 1e-10);
    }
    // The mean of 109 samples is that much surer than one.
    near(
        teeth.pitch_surplus[0].std.unwrap(),
        0.1e-6 * (16.0 / 17.0 / 109f64).sqrt(),
        1e-15,
    );
}

#[test]
fn refuses_what_cannot_be_known() {
    let places = [0.0; 5];
    let flat = [vec![0.0; 30]];
    let short = along(0.9 * BASE_PITCH, 30);
    let flanks = FlankDeviations {
        pitch_surplus: &places,
        roll: &short,
        profiles: &flat,
    };
    let error = te_against_master(&flanks, BASE_PITCH, 50).unwrap_err();
    assert_eq!(error.code, Code::OutOfRange);
    assert!(error.message.contains("no teeth touch"));
    let twice = [vec![0.0; 30], vec![0.0; 30]];
    let flanks = FlankDeviations {
        pitch_surplus: &places,
        roll: &short,
        profiles: &twice,
    };
    assert!(
        te_against_master(&flanks, BASE_PITCH, 50)
            .unwrap_err()
            .message
            .contains("2 profiles for 5")
    );
    assert_eq!(
        separate_pitch_and_profile(&[0.0; 50], 5, 2.0, None)
            .unwrap_err()
            .code,
        Code::IllPosed
    );
    assert_eq!(
        separate_pitch_and_profile(&[0.0; 51], 5, 1.5, None)
            .unwrap_err()
            .code,
        Code::OutOfRange
    );
    assert_eq!(
        separate_pitch_and_profile(&[0.0; 5], 5, 1.5, None)
            .unwrap_err()
            .code,
        Code::OutOfRange
    );
}
