//! Rotors in bearings: closed forms of textbooks, with a massless shaft or a rigid rotor, since there is no shaft element with bending.

use std::f64::consts::{PI, TAU};

use crate::support::verification::printed;
use crate::support::{damped, model, plain, solve, within, worst};
use geardyn::internals::numeric::Complex;
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::response::frf::{ResponseMethod, frf_matrix};
use geardyn::internals::response::ports::Ports;
use geardyn::internals::response::system::OperatingModel;
use geardyn::internals::scene::study::ModesStudy;

const HEAD: &str = "units = \"SI\"\ntitle = \"rotor\"\nsource = \"a test\"\n";

/// Eigenvalues above the real axis of a mass in a bearing, by rising imaginary part.
fn eigenvalues(mass: f64, bearing: &str) -> Vec<Complex> {
    let text = format!(
        "{HEAD}[[inertia]]\nname = \"disc\"\nJ = 1.0\nmass = {mass:?}\n\
         [[bearing]]\nname = \"bearing\"\nat = \"disc\"\n{bearing}"
    );
    let solved = solve(&text, &damped());
    let modes = solved.answer.modes.iter().filter(|mode| !mode.rigid);
    let mut found: Vec<Complex> = modes.map(|mode| mode.eigenvalue).collect();
    found.sort_by(|a, b| a.im.total_cmp(&b.im));
    found
}

/// A heavy disc on the end of a massless cantilever: backward and forward whirl at four speeds,
/// `m J_d ω⁴ − m J_p Ω ω³ − (m k₂₂ + J_d k₁₁) ω² + k₁₁ J_p Ω ω + k₁₁ k₂₂ − k₁₂² = 0`.
/// Source: J. P. Den Hartog, Mechanical Vibrations (1956), sec. 6.4; roots with 30 digits by mpmath.
#[test]
fn exact_overhung_disc() {
    let (e, length, diameter) = (210e9, 0.5_f64, 0.02_f64);
    let bending = e * PI * diameter.powi(4) / 64.0;
    let (across, both, tilt) = (
        12.0 * bending / length.powi(3),
        6.0 * bending / length.powi(2),
        4.0 * bending / length,
    );
    let text = format!(
        "{HEAD}[[inertia]]\nname = \"disc\"\nJ = 0.18\nmass = 10.0\nJ_diametral = 0.1\n\
         [[bearing]]\nname = \"cantilever\"\nat = \"disc\"\nk_radial = {across:?}\nk_tilt = {tilt:?}\n\
         k_x_ry = {:?}\nk_ry_x = {:?}\nk_y_rx = {both:?}\nk_rx_y = {both:?}\n",
        -both, -both
    );
    for (rpm, whirl) in [
        (
            0.0,
            [
                60.192353089368,
                60.192353089368,
                379.68065404288,
                379.68065404288,
            ],
        ),
        (
            1000.0,
            [
                52.081066123266,
                68.217525406738,
                306.80372881816,
                479.16282875007,
            ],
        ),
        (
            3000.0,
            [
                38.101471255249,
                81.846518625505,
                224.45303567747,
                746.19466595337,
            ],
        ),
        (
            10000.0,
            [
                16.44433427006,
                104.42398388631,
                155.76118516246,
                1952.7371277001,
            ],
        ),
    ] {
        let study = ModesStudy {
            speed: (rpm > 0.0).then_some(rpm * TAU / 60.0),
            ..plain()
        };
        let omega = solve(&text, &study).omega();
        let elastic: Vec<f64> = omega.into_iter().filter(|w| *w > 0.0).collect();
        within(
            &format!("whirl at {rpm} rpm"),
            worst(&elastic, &whirl),
            1e-12,
        );
    }
}

/// Damping that turns with a rotor drives forward whirl above a threshold, `Ω = (1 + c_e/c_i) √(k/m)` where the support is isotropic.
/// Source: D. M. Smith, Proc. Roy. Soc. A 142 (1933) 92; roots with 30 digits by mpmath.
#[test]
fn exact_internal_damping() {
    let bearing = |k_y: f64, speed: f64| {
        let internal = 150.0;
        format!(
            "k_x = 1e6\nk_y = {k_y:?}\nc_x = 250.0\nc_y = 250.0\nk_x_y = {:?}\nk_y_x = {:?}\n",
            internal * speed,
            -internal * speed
        )
    };
    let stiff = 1.2e6;
    for (k_y, speed, exact) in [
        (1e6, 0.0, [(-12.5, 315.98061649), (-12.5, 315.98061649)]),
        (
            1e6,
            400.0,
            [(-3.0100257742, 316.1230925), (-21.989974226, 316.1230925)],
        ),
        (
            1e6,
            600.0,
            [(-26.726966509, 316.30073755), (1.7269665092, 316.30073755)],
        ),
        (stiff, 0.0, [(-12.5, 315.98061649), (-12.5, 346.1845606)]),
        (stiff, 600.0, [(-12.5, 324.78431467), (-12.5, 337.93882426)]),
        (
            stiff,
            1000.0,
            [(-29.345235893, 331.85465489), (4.3452358928, 331.85465489)],
        ),
    ] {
        let mut found = eigenvalues(10.0, &bearing(k_y, speed));
        assert_eq!(found.len(), 2, "{found:?}");
        for (re, im) in exact {
            let exact = Complex::new(re, im);
            let apart = |z: &Complex| (z - exact).norm() / exact.norm();
            let at = usize::from(found.len() == 2 && apart(&found[1]) < apart(&found[0]));
            within("eigenvalues", apart(&found.remove(at)), 1e-10);
        }
    }
    for (k_y, threshold, whirl) in [
        (1e6, 527.04627669473, 316.22776601684),
        (stiff, 866.02540378444, 331.66247903554),
    ] {
        let found = eigenvalues(10.0, &bearing(k_y, threshold));
        let driven = found.iter().max_by(|a, b| a.re.total_cmp(&b.re)).unwrap();
        within("growth at the threshold", driven.re.abs() / whirl, 1e-12);
        within(
            "whirl at the threshold",
            (driven.im / whirl - 1.0).abs(),
            1e-12,
        );
    }
}

/// A rigid rotor in a short plain bearing at the speed where it begins to whirl: coefficients of the half film as given, mass
/// `M c Ω²/W` of the threshold, whirl ratio.
/// Source: Ocvirk's short bearing (NACA R-1157, 1953); coefficients and threshold with 30 digits by mpmath.
#[test]
fn ref_ocvirk_threshold() {
    // Eccentricity ratio, stiffness xx, xy, yx, yy over W/c, damping xx, xy = yx, yy over W/(c Ω), Ω √(M c/W), whirl over Ω.
    for (eccentricity, k, c, threshold, ratio) in [
        (
            0.1,
            [2.5307716861, 9.7576920556, -10.381119852, 1.3284240405],
            [19.790465676, -2.5324946394, 20.48715814],
            2.74127864,
            0.502938393,
        ),
        (
            0.2,
            [2.4849313081, 4.5202784085, -5.7630887883, 1.4978206311],
            [9.5869420385, -2.4916360137, 10.979792355],
            2.68141109,
            0.510562321,
        ),
        (
            0.4,
            [2.3188815548, 1.5714842037, -4.047783989, 2.2493021333],
            [4.216435654, -2.3430197207, 7.0221007314],
            2.54456914,
            0.523805785,
        ),
        (
            0.6,
            [2.0917231584, 0.30707042041, -4.1376991788, 3.951211664],
            [2.2388840013, -2.1379767349, 6.6506551971],
            2.70097619,
            0.473955082,
        ),
    ] {
        let bearing = format!(
            "k_x = {:?}\nk_x_y = {:?}\nk_y_x = {:?}\nk_y = {:?}\nc_x = {:?}\nc_x_y = {:?}\nc_y_x = {:?}\nc_y = {:?}\n",
            k[0], k[1], k[2], k[3], c[0], c[1], c[1], c[2]
        );
        let found = eigenvalues(threshold * threshold, &bearing);
        let slowest = found.iter().max_by(|a, b| a.re.total_cmp(&b.re)).unwrap();
        within("growth over the speed", slowest.re.abs(), 1e-8);
        let what = format!("whirl ratio at eccentricity {eccentricity}");
        printed(&what, "", ratio, slowest.im, 2e-9);
    }
}

/// Unbalance of a mass on a damped spring: amplitude and lag of its whirl below, near and above the critical speed; the peak.
/// Source: `e r²/√((1 − r²)² + (2 ζ r)²)`, evaluated by mpmath.
#[test]
fn exact_jeffcott_unbalance() {
    let (mass, k, zeta, eccentricity) = (50.0_f64, 5e6_f64, 0.05, 2e-5);
    let c = 2.0 * zeta * (k * mass).sqrt();
    let text = format!(
        "{HEAD}[[inertia]]\nname = \"disc\"\nJ = 1.0\nmass = {mass:?}\n\
         [[bearing]]\nname = \"shaft\"\nat = \"disc\"\nk_x = {k:?}\nk_y = {k:?}\nc_x = {c:?}\nc_y = {c:?}\n"
    );
    let prepared_machine = PreparedMachine::new(&model(&text)).unwrap();
    let setting = OperatingModel {
        machine: &prepared_machine.machine,
        operating: &prepared_machine.operating,
        model: &prepared_machine.model,
        speeds: None,
    };
    let port = ["disc.x".to_string()];
    let ports = Ports::parse(&prepared_machine.machine, &port, &port, &[]).unwrap();
    for (rpm, amplitude, lag) in [
        (1500.0, 6.53706294326e-6, Some(3.77284814)),
        (3000.0, 1.97002069938e-4, Some(82.52243566)),
        (6000.0, 2.67239887323e-5, Some(176.1439563)),
        (3019.75272627, 2e-4, Some(90.0)),
        (3027.33053674, 2.00250469729e-4, None),
        (2885.95216188, 2.00250469729e-4 / 2f64.sqrt(), None),
        (3191.75479635, 2.00250469729e-4 / 2f64.sqrt(), None),
    ] {
        let speed = rpm * TAU / 60.0;
        let found = frf_matrix(&setting, &ports, &[speed], ResponseMethod::Direct).unwrap();
        let whirl = found.values[0][(0, 0)] * (mass * eccentricity * speed * speed);
        // Speeds with twelve digits stand on flanks of the peak, 10 times as steep.
        within("amplitudes", (whirl.norm() / amplitude - 1.0).abs(), 1e-10);
        if let Some(lag) = lag {
            within(
                "lag, degrees",
                (-whirl.arg().to_degrees() - lag).abs(),
                1e-7,
            );
        }
    }
}
