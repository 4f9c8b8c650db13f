//! Continuation steps: tangent predictor, Newton corrector, adaptive number of harmonics.

use super::balance::{HarmonicBalance, HarmonicUnknowns};
use super::family::SpeedFamily;
use super::linear_part::LinearPart;
use super::point::{PeriodicSolution, PointOptions, periodic_solution};
use crate::base::error::Error;
use crate::motion::dynamic_model::ForceLaw;

/// Speed range, step sizes and tolerances of a continuation.
#[derive(Debug, Clone, Copy)]
pub struct ContinuationOptions {
    /// Base frequency of the excitation at the beginning, rad/s.
    pub from: f64,
    /// At the end; below the beginning for a falling speed.
    pub to: f64,
    /// The largest step, rad/s.
    pub step: f64,
    /// Allowed contribution of higher orders, relative to the size of the deflections.
    pub tolerance: f64,
    /// So many orders and no others.
    pub orders: Option<usize>,
    /// The most points.
    pub max_points: usize,
}

/// Default contribution allowed to higher orders.
pub const DEFAULT_TOLERANCE: f64 = 1e-6;

/// A place on the curve.
#[derive(Clone)]
pub(super) struct CurvePoint {
    pub x: HarmonicUnknowns,
    pub tangent: Vec<f64>,
    pub orders: usize,
}

/// Unknowns beyond this take longer than they are worth.
const MAX_UNKNOWNS: usize = 1200;

/// Steps along a curve.
pub(super) struct Continuation<'a> {
    pub family: &'a SpeedFamily,
    pub lines: &'a LinearPart,
    pub options: PointOptions<'a>,
    pub course: ContinuationOptions,
    sizes: Vec<f64>,
    pub span: f64,
    pub limited: bool,
}

impl<'a> Continuation<'a> {
    /// Ready to follow.
    ///
    /// # Errors
    /// Those of the linear part.
    pub fn new(
        family: &'a SpeedFamily,
        lines: &'a LinearPart,
        options: PointOptions<'a>,
        course: ContinuationOptions,
    ) -> Result<Continuation<'a>, Error> {
        Ok(Continuation {
            sizes: sizes(family, lines, course.from)?,
            family,
            lines,
            options,
            course,
            span: (course.to - course.from).abs(),
            limited: false,
        })
    }

    /// The balance with a number of orders.
    pub fn balance(&self, orders: usize) -> HarmonicBalance<'a> {
        HarmonicBalance::new(self.family, self.lines, orders, &self.sizes, self.span)
    }

    fn max_orders(&self) -> usize {
        let each = MAX_UNKNOWNS / self.sizes.len().max(1);
        (each.saturating_sub(1) / 2).max(self.family.max_order)
    }

    fn first_orders(&self) -> usize {
        let few = 8.max(4 * self.family.max_order);
        self.course.orders.unwrap_or(few.min(self.max_orders()))
    }

    /// The motion at a place.
    pub fn point(&self, span: &CurvePoint) -> Result<PeriodicSolution, Error> {
        periodic_solution(
            &mut self.balance(span.orders),
            &span.x,
            &span.tangent,
            &self.options,
        )
    }

    /// The first motion, with enough orders.
    pub fn first(&mut self) -> Result<CurvePoint, Error> {
        let orders = self.first_orders();
        let mut balance = self.balance(orders);
        let guess = balance.initial_guess(self.course.from)?;
        let mut still = vec![0.0; guess.len()];
        still[guess.len() - 1] = 1.0;
        let (x, _) = balance.correct(&guess, &still).map_err(|error| {
            error.with_hint("no periodic motion was found at the first speed: begin elsewhere")
        })?;
        let sense = (self.course.to - self.course.from).signum();
        still.iter_mut().for_each(|t| *t *= sense);
        let tangent = balance.tangent(&x, &still)?;
        let mut span = self.adapt_orders(CurvePoint { x, tangent, orders })?;
        // More orders have moved it along the curve: back to the first speed.
        let last = span.x.len() - 1;
        let mut still = vec![0.0; span.x.len()];
        still[last] = sense;
        span.x[last] = self.course.from / self.span;
        let mut balance = self.balance(span.orders);
        span.x = balance.correct(&span.x, &still)?.0;
        span.tangent = balance.tangent(&span.x, &still)?;
        Ok(span)
    }

    /// Predictor deviation: distance of the next point from the tangent prediction, in steps.
    pub fn predictor_deviation(&self, here: &CurvePoint, next: &CurvePoint, length: f64) -> f64 {
        let active = self.sizes.len();
        let alike = |x: &[f64]| resize_orders(x, next.orders, here.orders, active);
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
    pub fn step(&mut self, from: &CurvePoint, length: f64) -> Result<(CurvePoint, usize), Error> {
        let (span, iterations) = self.advance(from, length)?;
        Ok((self.adapt_orders(span)?, iterations))
    }

    /// The place at a distance along the tangent, with the same orders.
    pub fn advance(&self, from: &CurvePoint, length: f64) -> Result<(CurvePoint, usize), Error> {
        let mut balance = self.balance(from.orders);
        let ahead: Vec<f64> = from
            .x
            .iter()
            .zip(&from.tangent)
            .map(|(x, t)| x + length * t)
            .collect();
        let (x, iterations) = balance.correct(&ahead, &from.tangent)?;
        let tangent = balance.tangent(&x, &from.tangent)?;
        Ok((
            CurvePoint {
                x,
                tangent,
                orders: from.orders,
            },
            iterations,
        ))
    }

    /// The same place with as many orders as its residual asks.
    fn adapt_orders(&mut self, span: CurvePoint) -> Result<CurvePoint, Error> {
        if self.course.orders.is_some() || self.lines.active.is_empty() {
            return Ok(span);
        }
        let least = self.first_orders();
        let mut span = span;
        loop {
            let mut balance = self.balance(span.orders);
            let left_out = balance.truncation_error(&span.x)?;
            let wanted = if left_out > self.course.tolerance {
                (3 * span.orders / 2 + 1).min(self.max_orders())
            } else if left_out < 0.01 * self.course.tolerance {
                (2 * span.orders / 3).max(least)
            } else {
                span.orders
            };
            if wanted == span.orders {
                self.limited |= left_out > self.course.tolerance;
                return Ok(span);
            }
            let fewer = wanted < span.orders;
            let (delta, omega) = (balance.deflections(&span.x), balance.omega(&span.x));
            let mut more = self.balance(wanted);
            let along =
                |t: &[f64]| -> Vec<f64> { resize_orders(t, span.orders, wanted, self.sizes.len()) };
            let tangent = along(&span.tangent);
            let x = more.unknowns(&delta, omega);
            let (x, _) = more.correct(&x, &tangent)?;
            let tangent = more.tangent(&x, &tangent)?;
            span = CurvePoint {
                x,
                tangent,
                orders: wanted,
            };
            if fewer {
                return Ok(span);
            }
        }
    }

    /// The place between two where the frequency is `omega`.
    pub fn point_at(&self, here: &CurvePoint, next: &CurvePoint, omega: f64) -> Option<CurvePoint> {
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
        let (x, _) = balance.correct(&ahead, &still).ok()?;
        let tangent = balance.tangent(&x, &still).ok()?;
        Some(CurvePoint {
            x,
            tangent,
            orders: here.orders,
        })
    }
}

/// The size of the deflection of every active branch.
fn sizes(family: &SpeedFamily, lines: &LinearPart, omega: f64) -> Result<Vec<f64>, Error> {
    let mut sizes = vec![0.0f64; lines.active.len()];
    for k in 0..=family.max_order {
        let line = lines.order_response(k, omega)?;
        sizes
            .iter_mut()
            .zip(&line.drive[0])
            .for_each(|(s, p)| *s = s.max(p.norm()));
    }
    for (size, active) in sizes.iter_mut().zip(&lines.active) {
        if let ForceLaw::Contact(contact) = &family.relative.model.elements[active.branch].law {
            *size = size.max(contact.half_play);
        }
    }
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    let least = if largest > 0.0 { 1e-6 * largest } else { 1.0 };
    Ok(sizes.into_iter().map(|s| s.max(least)).collect())
}

/// A vector of unknowns with another number of orders.
fn resize_orders(t: &[f64], orders: usize, wanted: usize, active: usize) -> Vec<f64> {
    let (width, wide) = (2 * orders + 1, 2 * wanted + 1);
    let mut out = Vec::with_capacity(active * wide + 1);
    for own in 0..active {
        let part = &t[own * width..(own + 1) * width];
        out.extend((0..wide).map(|j| part.get(j).copied().unwrap_or(0.0)));
    }
    out.push(t[t.len() - 1]);
    out
}
