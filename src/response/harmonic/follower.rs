//! Steps along a curve of periodic motions: predictor along the tangent, Newton's corrector, as many orders as the residual asks.

use super::balance::{Balance, Unknowns};
use super::family::Family;
use super::lines::Lines;
use super::point::{Asked, Point, point};
use crate::base::error::Error;
use crate::motion::train::Law;

/// Where the curve goes, and how finely.
#[derive(Debug, Clone, Copy)]
pub struct Course {
    /// What everything repeats with at the beginning, rad/s.
    pub from: f64,
    /// At the end; below the beginning for a falling speed.
    pub to: f64,
    /// The largest step, rad/s.
    pub step: f64,
    /// What higher orders may add, of the size of the deflections.
    pub tolerance: f64,
    /// So many orders and no others.
    pub orders: Option<usize>,
    /// The most points.
    pub most: usize,
}

/// What higher orders may add where nothing is asked.
pub const TOLERANCE: f64 = 1e-6;

/// A place on the curve.
#[derive(Clone)]
pub(super) struct Place {
    pub x: Unknowns,
    pub tangent: Vec<f64>,
    pub orders: usize,
}

/// Unknowns beyond this take longer than they are worth.
const MOST_UNKNOWNS: usize = 1200;

/// Steps along a curve.
pub(super) struct Follower<'a> {
    pub family: &'a Family,
    pub lines: &'a Lines,
    pub asked: Asked<'a>,
    pub course: Course,
    sizes: Vec<f64>,
    pub span: f64,
    pub limited: bool,
}

impl<'a> Follower<'a> {
    /// Ready to follow.
    ///
    /// # Errors
    /// Those of the linear part.
    pub fn new(
        family: &'a Family,
        lines: &'a Lines,
        asked: Asked<'a>,
        course: Course,
    ) -> Result<Follower<'a>, Error> {
        Ok(Follower {
            sizes: sizes(family, lines, course.from)?,
            family,
            lines,
            asked,
            course,
            span: (course.to - course.from).abs(),
            limited: false,
        })
    }

    /// The balance with a number of orders.
    pub fn balance(&self, orders: usize) -> Balance<'a> {
        Balance::new(self.family, self.lines, orders, &self.sizes, self.span)
    }

    fn most_orders(&self) -> usize {
        let each = MOST_UNKNOWNS / self.sizes.len().max(1);
        (each.saturating_sub(1) / 2).max(self.family.highest)
    }

    fn first_orders(&self) -> usize {
        let few = 8.max(4 * self.family.highest);
        self.course.orders.unwrap_or(few.min(self.most_orders()))
    }

    /// The motion at a place.
    pub fn point(&self, place: &Place) -> Result<Point, Error> {
        point(
            &mut self.balance(place.orders),
            &place.x,
            &place.tangent,
            &self.asked,
        )
    }

    /// The first motion, with enough orders.
    pub fn first(&mut self) -> Result<Place, Error> {
        let orders = self.first_orders();
        let mut balance = self.balance(orders);
        let guess = balance.guess(self.course.from)?;
        let mut still = vec![0.0; guess.len()];
        still[guess.len() - 1] = 1.0;
        let (x, _) = balance.corrected(&guess, &still).map_err(|error| {
            error.hint("no periodic motion was found at the first speed: begin elsewhere")
        })?;
        let sense = (self.course.to - self.course.from).signum();
        still.iter_mut().for_each(|t| *t *= sense);
        let tangent = balance.tangent(&x, &still)?;
        let mut place = self.adapted(Place { x, tangent, orders })?;
        // More orders have moved it along the curve: back to the first speed.
        let last = place.x.len() - 1;
        let mut still = vec![0.0; place.x.len()];
        still[last] = sense;
        place.x[last] = self.course.from / self.span;
        let mut balance = self.balance(place.orders);
        place.x = balance.corrected(&place.x, &still)?.0;
        place.tangent = balance.tangent(&place.x, &still)?;
        Ok(place)
    }

    /// How far the next place is from where the tangent pointed, in steps.
    pub fn off(&self, here: &Place, next: &Place, length: f64) -> f64 {
        let active = self.sizes.len();
        let alike = |x: &[f64]| more_of(x, next.orders, here.orders, active);
        let ahead = here
            .x
            .iter()
            .zip(&here.tangent)
            .map(|(x, t)| x + length * t);
        let square: f64 = ahead
            .zip(alike(&next.x))
            .map(|(a, b)| (a - b).powi(2))
            .sum();
        square.sqrt() / length
    }

    /// One step along the tangent.
    pub fn step(&mut self, from: &Place, length: f64) -> Result<(Place, usize), Error> {
        let (place, iterations) = self.on(from, length)?;
        Ok((self.adapted(place)?, iterations))
    }

    /// The place at a distance along the tangent, with the same orders.
    pub fn on(&self, from: &Place, length: f64) -> Result<(Place, usize), Error> {
        let mut balance = self.balance(from.orders);
        let ahead: Vec<f64> = from
            .x
            .iter()
            .zip(&from.tangent)
            .map(|(x, t)| x + length * t)
            .collect();
        let (x, iterations) = balance.corrected(&ahead, &from.tangent)?;
        let tangent = balance.tangent(&x, &from.tangent)?;
        Ok((
            Place {
                x,
                tangent,
                orders: from.orders,
            },
            iterations,
        ))
    }

    /// The same place with as many orders as its residual asks.
    fn adapted(&mut self, place: Place) -> Result<Place, Error> {
        if self.course.orders.is_some() || self.lines.active.is_empty() {
            return Ok(place);
        }
        let least = self.first_orders();
        let mut place = place;
        loop {
            let mut balance = self.balance(place.orders);
            let left_out = balance.left_out(&place.x)?;
            let wanted = if left_out > self.course.tolerance {
                (3 * place.orders / 2 + 1).min(self.most_orders())
            } else if left_out < 0.01 * self.course.tolerance {
                (2 * place.orders / 3).max(least)
            } else {
                place.orders
            };
            if wanted == place.orders {
                self.limited |= left_out > self.course.tolerance;
                return Ok(place);
            }
            let fewer = wanted < place.orders;
            let (delta, omega) = (balance.deflections(&place.x), balance.omega(&place.x));
            let mut more = self.balance(wanted);
            let along =
                |t: &[f64]| -> Vec<f64> { more_of(t, place.orders, wanted, self.sizes.len()) };
            let tangent = along(&place.tangent);
            let x = more.unknowns(&delta, omega);
            let (x, _) = more.corrected(&x, &tangent)?;
            let tangent = more.tangent(&x, &tangent)?;
            place = Place {
                x,
                tangent,
                orders: wanted,
            };
            if fewer {
                return Ok(place);
            }
        }
    }

    /// The place between two where the frequency is `omega`.
    pub fn ended_at(&self, here: &Place, next: &Place, omega: f64) -> Option<Place> {
        let mut balance = self.balance(here.orders);
        let between = balance.omega(&here.x);
        let beyond = self.balance(next.orders).omega(&next.x);
        if between == omega || beyond == between {
            return None;
        }
        let share = (omega - between) / (beyond - between);
        let mut still = vec![0.0; here.x.len()];
        still[here.x.len() - 1] = (beyond - between).signum();
        let slope = here.tangent[here.x.len() - 1];
        let length = share * (beyond - between) / self.span / slope;
        let mut ahead: Vec<f64> = here
            .x
            .iter()
            .zip(&here.tangent)
            .map(|(x, t)| x + length * t)
            .collect();
        let last = ahead.len() - 1;
        ahead[last] = omega / self.span;
        let (x, _) = balance.corrected(&ahead, &still).ok()?;
        let tangent = balance.tangent(&x, &still).ok()?;
        Some(Place {
            x,
            tangent,
            orders: here.orders,
        })
    }
}

/// The size of the deflection of every active branch.
fn sizes(family: &Family, lines: &Lines, omega: f64) -> Result<Vec<f64>, Error> {
    let mut sizes = vec![0.0f64; lines.active.len()];
    for k in 0..=family.highest {
        let line = lines.at(k, omega)?;
        sizes
            .iter_mut()
            .zip(&line.drive[0])
            .for_each(|(s, p)| *s = s.max(p.norm()));
    }
    for (size, active) in sizes.iter_mut().zip(&lines.active) {
        if let Law::Contact(contact) = &family.relative.train.branches[active.branch].law {
            *size = size.max(contact.half);
        }
    }
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    let least = if largest > 0.0 { 1e-6 * largest } else { 1.0 };
    Ok(sizes.into_iter().map(|s| s.max(least)).collect())
}

/// A vector of unknowns with another number of orders.
fn more_of(t: &[f64], orders: usize, wanted: usize, active: usize) -> Vec<f64> {
    let (width, wide) = (2 * orders + 1, 2 * wanted + 1);
    let mut out = Vec::with_capacity(active * wide + 1);
    for own in 0..active {
        let part = &t[own * width..(own + 1) * width];
        out.extend((0..wide).map(|j| part.get(j).copied().unwrap_or(0.0)));
    }
    out.push(t[t.len() - 1]);
    out
}
