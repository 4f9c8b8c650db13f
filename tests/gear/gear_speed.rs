//! Time of the kernel of meshing and of bevel contact; `cargo test --release --test gear gear_speed -- --ignored --nocapture` prints it next
//! to tools/gear_flank_peer.py.

use std::hint::black_box;
use std::time::Instant;

use geardyn::internals::gear::bevel::flank_grid::FlankGrid;

use crate::bevel_flank::nasa_flank;
use crate::cases::case;
use crate::contact::pair;

/// Least time of one of `count` calls in a hundred batches, ns: on a busy machine the least is the one that was not interrupted.
fn nanoseconds(count: usize, mut call: impl FnMut(usize)) -> f64 {
    let mut least = f64::INFINITY;
    for _ in 0..100 {
        let start = Instant::now();
        (0..count).for_each(&mut call);
        least = least.min(start.elapsed().as_secs_f64() * 1e9 / count as f64);
    }
    least
}

/// Evaluation with all derivatives ≤ 0.2 µs, flank point on the blank ≤ 1.5 µs, contact with ellipse ≤ 5 µs, 60 contacts ≤ 0.5 ms.
#[test]
#[ignore = "prints times"]
fn speed_of_flanks_and_contacts() {
    let case = case("c12_nasa_cr191009_flanks");
    let flank = nasa_flank(&case, "pinion_concave");
    let middle = flank.middle().unwrap();
    let [s, theta, x] = middle;
    let evaluation = nanoseconds(2000, |i| {
        black_box(
            flank
                .envelope
                .meeting(black_box([s, theta, x + 1e-9 * i as f64])),
        );
    });
    println!("evaluation with all derivatives  {evaluation:9.0} ns");
    let nodes = 45 * 30;
    let grid = nanoseconds(1, |_| {
        black_box(FlankGrid::of(&flank, 30, 45));
    });
    let start = nanoseconds(1, |_| {
        black_box(flank.middle());
    });
    println!("start without hints              {start:9.0} ns");
    println!(
        "flank point on the blank         {:9.0} ns",
        (grid - start) / f64::from(nodes)
    );
    let pair = pair([0.0, 0.02, 0.0, 0.0]);
    let first = pair.first_contact().unwrap();
    let contact = nanoseconds(20, |i| {
        let angle = first.pinion_angle + 0.002 * (i % 5) as f64;
        let contact = pair.contact(angle, first.unknowns);
        black_box(contact.and_then(|c| pair.ellipse(&c, 0.00025)));
    });
    println!("contact with ellipse             {contact:9.0} ns");
    let path = nanoseconds(1, |_| {
        black_box(pair.path(first, 1.5, 20));
    });
    println!("path of 60 contacts              {path:9.0} ns");
}
