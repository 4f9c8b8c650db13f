//! Motions of two periods, born where a multiplier of the curve passes −1: found by shooting from beside the motion that lost its stability,
//! along the direction that grows, and followed speed by speed (Seydel, Practical Bifurcation and Stability Analysis, 3rd ed. 2010, sec. 7.6).

use std::ops::Range;

use super::family::Family;
use super::point::{Asked, Found, Point, sampled_exactly};
use super::special::{Kind, Special};
use crate::motion::floquet::orbit::{after, orbit};
use crate::motion::train::Train;

/// The motions of two periods that a doubling begins.
#[derive(Debug, Clone)]
pub struct Doubled {
    /// The number of the doubling among the special places.
    pub born: usize,
    /// From the doubling on, at the speeds of the curve; multipliers are those of two periods.
    pub points: Vec<Point>,
    /// Points of the curve that they stand beside.
    beside: Range<usize>,
}

impl Doubled {
    /// They end or begin in the step of the curve after this point.
    pub fn stands_beside(&self, after: usize) -> bool {
        (self.beside.start..=self.beside.end).contains(&(after + 1))
    }
}

/// Displacements tried to leave the motion that lost its stability, of the size of the motion.
const BESIDE: [f64; 4] = [0.01, 0.03, 0.1, 0.3];

/// A motion that comes back this near after one period already, of its size, is no doubled one.
const SINGLE: f64 = 1e-5;

/// Points of the curve beyond a doubling at which its motions are looked for: nearer ones are born too small to be told from it.
const TRIED: usize = 6;

/// Turns of the power iteration: what grows most stands out of the rest by its ratio to them, this many times.
const TURNS: usize = 200;

/// Follows every doubling of a curve whose motions are refined by events.
pub(super) fn doubled(
    family: &Family,
    asked: &Asked,
    points: &[Point],
    specials: &[Special],
) -> Vec<Doubled> {
    let mut all: Vec<Doubled> = Vec::new();
    for (born, special) in specials.iter().enumerate() {
        if special.kind != Kind::PeriodDoubling || special.after + 1 >= points.len() {
            continue;
        }
        let (one, other) = (special.after, special.after + 1);
        let rising = points[other].unstable() > points[one].unstable();
        let stretch = stretch(points, one, rising);
        // The other end of a stretch that has been followed from here.
        let known =
            |d: &Doubled| stretch.contains(&d.beside.start) || d.beside.contains(&stretch.start);
        if all.iter().any(known) {
            continue;
        }
        let order: Vec<usize> = match rising {
            true => stretch.clone().collect(),
            false => stretch.clone().rev().collect(),
        };
        let followed = along(family, asked, points, &order);
        if !followed.is_empty() {
            all.push(Doubled {
                born,
                points: followed,
                beside: stretch,
            });
        }
    }
    all
}

/// Numbers of the points on the unstable side of the step after `one`, as far as they are unstable.
fn stretch(points: &[Point], one: usize, rising: bool) -> Range<usize> {
    let counts = |k: &usize| points[*k].unstable() > 0 && points[*k].found == Found::Events;
    match rising {
        true => one + 1..one + 1 + (one + 1..points.len()).take_while(counts).count(),
        false => one + 1 - (0..=one).rev().take_while(counts).count()..one + 1,
    }
}

fn along(family: &Family, asked: &Asked, points: &[Point], order: &[usize]) -> Vec<Point> {
    let mut found: Vec<Point> = Vec::new();
    // From the motion of one period to that of two, at the last speed.
    let mut beside: Option<Vec<f64>> = None;
    for (tried, &at) in order.iter().enumerate() {
        let single = &points[at];
        let train = family.at(single.omega);
        let next = match &beside {
            Some(offset) => near(&train, single, std::slice::from_ref(offset)),
            None if tried < TRIED => near(&train, single, &grows(&train, single)),
            None => break,
        };
        let Some((start, multipliers)) = next else {
            match beside {
                Some(_) => break,
                None => continue,
            }
        };
        let Ok(outputs) = sampled_exactly(family, single.omega, 2, &start, asked.outputs) else {
            break;
        };
        beside = Some(
            start
                .iter()
                .zip(&single.start)
                .map(|(a, b)| a - b)
                .collect(),
        );
        found.push(Point {
            omega: single.omega,
            orders: single.orders,
            left_out: single.left_out,
            found: Found::Events,
            start,
            multipliers,
            outputs,
            sense: single.sense,
        });
    }
    found
}

/// Start and multipliers of a motion of two periods beside one of one.
fn near(
    train: &Train,
    single: &Point,
    offsets: &[Vec<f64>],
) -> Option<(Vec<f64>, Vec<crate::numeric::Complex>)> {
    offsets.iter().find_map(|offset| {
        let guess: Vec<f64> = single
            .start
            .iter()
            .zip(offset)
            .map(|(y, o)| y + o)
            .collect();
        let found = orbit(train, &guess, 2).ok()?;
        let once = after(train, &found.start, 1).ok()?;
        let size = |values: &[f64]| values.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let comes_back = size(&once.apart(&found.start)) <= SINGLE * size(&once.end);
        (!comes_back).then_some((found.start, found.multipliers))
    })
}

/// Displacements along what grows most in a period, of several sizes.
fn grows(train: &Train, single: &Point) -> Vec<Vec<f64>> {
    let Ok(back) = after(train, &single.start, 1) else {
        return Vec::new();
    };
    let n = back.end.len();
    let mut along: Vec<f64> = (0..n).map(|i| 1.0 + 0.1 * i as f64).collect();
    for _ in 0..TURNS {
        let next: Vec<f64> = back
            .slope
            .chunks_exact(n)
            .map(|row| row.iter().zip(&along).map(|(a, b)| a * b).sum())
            .collect();
        let size = next.iter().fold(0.0f64, |m: f64, x: &f64| m.max(x.abs()));
        if !(size > 0.0 && size.is_finite()) {
            return Vec::new();
        }
        along = next.iter().map(|x| x / size).collect();
    }
    let size = back.end.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let sized = |share: &f64| {
        let each = along.iter().zip(&back.units);
        each.map(|(x, unit)| share * size * x * unit).collect()
    };
    BESIDE.iter().map(sized).collect()
}
