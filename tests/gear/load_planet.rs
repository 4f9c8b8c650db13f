//! Phase of a planet's two meshes against contact searched in the outlines of sun, planet and ring.

use std::f64::consts::{PI, TAU};

use geardyn::internals::gear::cylindrical::basic_rack::BasicRack;
use geardyn::internals::gear::cylindrical::involute::InvoluteGear;
use geardyn::internals::gear::cylindrical::member::Member;
use geardyn::internals::gear::cylindrical::outline::ToothOutline;
use geardyn::internals::gear::cylindrical::pair::Pair;
use geardyn::internals::gear::load::planet_phase::planet_phase;

use crate::verification::within;

fn member(teeth: u32, shift: f64, internal: bool) -> Member {
    let gear = InvoluteGear {
        teeth,
        module: 2e-3,
        pressure_angle: 20f64.to_radians(),
        helix: 0.0,
        profile_shift: shift,
        internal,
    };
    Member::new(gear, BasicRack::PROFILE_C, 0.02)
}

/// Sun and planet at a centre distance without backlash, planet and ring at the same distance.
fn stage(teeth: [u32; 3], shifts: [f64; 3], thinner: f64) -> [Pair; 2] {
    let mut planet = member(teeth[1], shifts[1], false);
    planet.thickness_deviation = [-thinner; 2];
    let sun = Pair::new([member(teeth[0], shifts[0], false), planet], None).unwrap();
    let mut planet = sun.members[1];
    planet.tip_diameter = sun.members[1].tip_diameter;
    let ring = member(teeth[2], shifts[2], true);
    let ring = Pair::new([planet, ring], Some(sun.centre_distance)).unwrap();
    [sun, ring]
}

/// The planet at the origin, the mate's axis at (−a, 0), the planet's tooth with its middle at the angle `at`: the point of its flank on
/// the side `side` (+1 counter-clockwise) that the mate's flank reaches first from below. Only outlines at equal radii are compared.
fn contact(planet: &ToothOutline, mate: &ToothOutline, a: f64, at: f64, side: f64) -> [f64; 2] {
    let point = |share: f64| {
        let [radius, half] = planet.involute_point(share);
        let angle = at + side * half;
        [radius * angle.cos(), radius * angle.sin()]
    };
    let room = |share: f64| {
        let [x, y] = point(share);
        let half = mate.half_angle((x + a).hypot(y));
        half.map_or(f64::INFINITY, |half| y.atan2(x + a) - half)
    };
    let places = 2000;
    let place = |i: i32| f64::from(i.clamp(0, places)) / f64::from(places);
    let best = (0..=places)
        .min_by(|i, j| room(place(*i)).total_cmp(&room(place(*j))))
        .unwrap();
    let (mut low, mut high) = (place(best - 1), place(best + 1));
    for _ in 0..100 {
        let third = (high - low) / 3.0;
        if room(low + third) < room(high - third) {
            high -= third;
        } else {
            low += third;
        }
    }
    point(0.5 * (low + high))
}

/// The angle of the planet's tooth at which it touches its mate on the line of centres.
fn at_pitch_point(pair: &Pair, planet: &ToothOutline, mate: &ToothOutline, side: f64) -> f64 {
    let pitch = TAU / f64::from(planet.teeth);
    let across = |at: f64| contact(planet, mate, pair.centre_distance, at, side)[1];
    let middle = if side > 0.0 { PI } else { 0.0 } - side * 0.25 * pitch;
    let (mut low, mut high) = (middle - 0.3 * pitch, middle + 0.3 * pitch);
    let rises = across(high) > across(low);
    for _ in 0..60 {
        let at = 0.5 * (low + high);
        if (across(at) > 0.0) == rises {
            high = at;
        } else {
            low = at;
        }
    }
    0.5 * (low + high)
}

/// Sun, planet and ring with even and odd planets, shifts and a thinned planet: the phase of the ring's mesh against that of the sun.
#[test]
fn exact_phase_of_planet() {
    let mut worst = 0.0f64;
    for (teeth, shifts, thinner) in [
        ([24, 30, 84], [0.0, 0.0, 0.0], 0.0),
        ([25, 31, 87], [0.0, 0.0, 0.0], 0.0),
        ([21, 33, 87], [0.3, 0.1, -0.5], 0.0),
        ([24, 31, 86], [0.1, 0.2, -0.5], 60e-6),
    ] {
        let [sun, ring] = stage(teeth, shifts, thinner);
        let planet = &sun.outlines[1];
        // The sun turns counter-clockwise, the planet clockwise: its cycles go forward as its angle falls.
        let begins = at_pitch_point(&sun, planet, &sun.outlines[0], 1.0);
        let ring_begins = at_pitch_point(&ring, planet, &ring.outlines[1], -1.0);
        let found = (ring_begins - begins) * f64::from(teeth[1]) / TAU;
        let apart = (planet_phase(&sun, &ring).unwrap() - found).rem_euclid(1.0);
        worst = worst.max(apart.min(1.0 - apart));
    }
    within("share of a pitch", worst, 1e-6);
    for (teeth, exact) in [([24, 30, 84], 0.5), ([25, 31, 87], 0.0)] {
        let [sun, ring] = stage(teeth, [0.0; 3], 0.0);
        let apart = (planet_phase(&sun, &ring).unwrap() - exact).abs();
        within("without shifts", apart.min(1.0 - apart), 1e-12);
    }
}

/// Pairs that do not share the planet.
#[test]
fn refuses_other_planet() {
    let [sun, ring] = stage([24, 30, 84], [0.0; 3], 0.0);
    assert_eq!(
        planet_phase(&ring, &sun).unwrap_err().code.as_str(),
        "conflict"
    );
    let [_, other] = stage([25, 31, 87], [0.0; 3], 0.0);
    assert_eq!(
        planet_phase(&sun, &other).unwrap_err().code.as_str(),
        "conflict"
    );
    assert!(planet_phase(&sun, &ring).is_ok());
}
