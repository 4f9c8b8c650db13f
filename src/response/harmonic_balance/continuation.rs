//! Arc-length continuation steps: tangent predictor, Newton corrector, adaptive number of harmonics.

use super::balance::{HarmonicBalance, HarmonicUnknowns};
use super::family::SpeedFamily;
use super::linear_part::LinearPart;
use super::point::{PeriodicSolution, PointOptions, periodic_solution};
use crate::base::error::Error;
use crate::motion::dynamic_model::ForceLaw;

/// Speed range, step sizes and tolerances of a continuation.
#[derive(Debug, Clone, Copy)]
pub struct ContinuationOptions {
    /// Base frequency of the excitation at the start, rad/s.
    pub from: f64,
    /// Base frequency at the end, rad/s; below `from` for a falling speed.
    pub to: f64,
    /// Largest step, rad/s.
    pub step: f64,
    /// Allowed contribution of truncated orders, relative to the deflections.
    pub tolerance: f64,
    /// Fixed number of orders; `None` for an adaptive number.
    pub orders: Option<usize>,
    /// Largest number of points.
    pub max_points: usize,
}

/// Default tolerance of the truncated orders, relative.
pub const DEFAULT_TOLERANCE: f64 = 1e-6;

/// Point on the solution curve: unknowns, unit tangent and number of orders.
#[derive(Clone)]
pub(super) struct CurvePoint {
    pub x: HarmonicUnknowns,
    pub tangent: Vec<f64>,
    pub orders: usize,
}

/// Largest number of unknowns, a limit of the run time.
const MAX_UNKNOWNS: usize = 1200;

/// Continuation of a solution curve over speed.
pub(super) struct Continuation<'a> {
    pub family: &'a SpeedFamily,
    pub lines: &'a LinearPart,
    pub options: PointOptions<'a>,
    pub setup: ContinuationOptions,
    scales: Vec<f64>,
    pub span: f64,
    pub order_limited: bool,
}

impl<'a> Continuation<'a> {
    /// Sets the scales of the unknowns at the first speed.
    ///
    /// # Errors
    /// Errors of the linear part.
    pub fn new(
        family: &'a SpeedFamily,
        lines: &'a LinearPart,
        options: PointOptions<'a>,
        setup: ContinuationOptions,
    ) -> Result<Continuation<'a>, Error> {
        Ok(Continuation {
            scales: scales(family, lines, setup.from)?,
            family,
            lines,
            options,
            setup,
            span: (setup.to - setup.from).abs(),
            order_limited: false,
        })
    }

    /// Harmonic balance with a number of orders.
    pub fn balance(&self, orders: usize) -> HarmonicBalance<'a> {
        HarmonicBalance::new(self.family, self.lines, orders, &self.scales, self.span)
    }

    fn max_orders(&self) -> usize {
        let per_branch = MAX_UNKNOWNS / self.scales.len().max(1);
        (per_branch.saturating_sub(1) / 2).max(self.family.max_order)
    }

    fn first_orders(&self) -> usize {
        let count = 8.max(4 * self.family.max_order);
        self.setup.orders.unwrap_or(count.min(self.max_orders()))
    }

    /// Periodic solution at a point of the curve.
    pub fn solution(&self, point: &CurvePoint) -> Result<PeriodicSolution, Error> {
        periodic_solution(
            &mut self.balance(point.orders),
            &point.x,
            &point.tangent,
            &self.options,
        )
    }

    /// First point of the curve, with a sufficient number of orders.
    pub fn first_point(&mut self) -> Result<CurvePoint, Error> {
        let orders = self.first_orders();
        let mut balance = self.balance(orders);
        let guess = balance.initial_guess(self.setup.from)?;
        let mut direction = vec![0.0; guess.len()];
        direction[guess.len() - 1] = 1.0;
        let (x, _) = balance.correct(&guess, &direction).map_err(|error| {
            error.with_hint("no periodic motion was found at the first speed: start at another one")
        })?;
        let sign = (self.setup.to - self.setup.from).signum();
        direction.iter_mut().for_each(|t| *t *= sign);
        let tangent = balance.tangent(&x, &direction)?;
        let mut point = self.adapt_orders(CurvePoint { x, tangent, orders })?;
        // Additional orders shift the point along the curve; return to the first speed.
        let last = point.x.len() - 1;
        let mut direction = vec![0.0; point.x.len()];
        direction[last] = sign;
        point.x[last] = self.setup.from / self.span;
        let mut balance = self.balance(point.orders);
        point.x = balance.correct(&point.x, &direction)?.0;
        point.tangent = balance.tangent(&point.x, &direction)?;
        Ok(point)
    }

    /// Distance of the next point from the tangent prediction, relative to the step length.
    pub fn predictor_deviation(&self, current: &CurvePoint, next: &CurvePoint, length: f64) -> f64 {
        let active = self.scales.len();
        let resized = |x: &[f64]| resize_orders(x, next.orders, current.orders, active);
        let predicted = current
            .x
            .iter()
            .zip(&current.tangent)
            .map(|(x, t)| x + length * t);
        let square: f64 = predicted
            .zip(resized(&next.x))
            .map(|(a, b)| (a - b).powi(2))
            .sum();
        square.sqrt() / length
    }

    /// Steps along the curve and adapts the number of orders; also returns the Newton iterations.
    pub fn step(&mut self, from: &CurvePoint, length: f64) -> Result<(CurvePoint, usize), Error> {
        let (point, iterations) = self.advance(from, length)?;
        Ok((self.adapt_orders(point)?, iterations))
    }

    /// Corrects the tangent prediction at a step length, with the same orders; also returns the Newton iterations.
    pub fn advance(&self, from: &CurvePoint, length: f64) -> Result<(CurvePoint, usize), Error> {
        let mut balance = self.balance(from.orders);
        let predicted: Vec<f64> = from
            .x
            .iter()
            .zip(&from.tangent)
            .map(|(x, t)| x + length * t)
            .collect();
        let (x, iterations) = balance.correct(&predicted, &from.tangent)?;
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

    /// Adapts the number of orders of a point to its truncation error.
    fn adapt_orders(&mut self, point: CurvePoint) -> Result<CurvePoint, Error> {
        if self.setup.orders.is_some() || self.lines.active.is_empty() {
            return Ok(point);
        }
        let min_orders = self.first_orders();
        let mut point = point;
        loop {
            let mut balance = self.balance(point.orders);
            let error = balance.truncation_error(&point.x)?;
            let orders = if error > self.setup.tolerance {
                (3 * point.orders / 2 + 1).min(self.max_orders())
            } else if error < 0.01 * self.setup.tolerance {
                (2 * point.orders / 3).max(min_orders)
            } else {
                point.orders
            };
            if orders == point.orders {
                self.order_limited |= error > self.setup.tolerance;
                return Ok(point);
            }
            let is_reduced = orders < point.orders;
            let (delta, omega) = (balance.deflections(&point.x), balance.omega(&point.x));
            let mut refined = self.balance(orders);
            let resize = |t: &[f64]| -> Vec<f64> {
                resize_orders(t, point.orders, orders, self.scales.len())
            };
            let tangent = resize(&point.tangent);
            let x = refined.unknowns(&delta, omega);
            let (x, _) = refined.correct(&x, &tangent)?;
            let tangent = refined.tangent(&x, &tangent)?;
            point = CurvePoint { x, tangent, orders };
            if is_reduced {
                return Ok(point);
            }
        }
    }

    /// Point between two others at the frequency `omega`, rad/s.
    pub fn point_at(&self, from: &CurvePoint, next: &CurvePoint, omega: f64) -> Option<CurvePoint> {
        let mut balance = self.balance(from.orders);
        let start = balance.omega(&from.x);
        let end = self.balance(next.orders).omega(&next.x);
        if start == omega || end == start {
            return None;
        }
        let share = (omega - start) / (end - start);
        let mut direction = vec![0.0; from.x.len()];
        direction[from.x.len() - 1] = (end - start).signum();
        let slope = from.tangent[from.x.len() - 1];
        let length = share * (end - start) / self.span / slope;
        let mut predicted: Vec<f64> = from
            .x
            .iter()
            .zip(&from.tangent)
            .map(|(x, t)| x + length * t)
            .collect();
        let last = predicted.len() - 1;
        predicted[last] = omega / self.span;
        let (x, _) = balance.correct(&predicted, &direction).ok()?;
        let tangent = balance.tangent(&x, &direction).ok()?;
        Some(CurvePoint {
            x,
            tangent,
            orders: from.orders,
        })
    }
}

/// Scale of the deflection of every active branch.
fn scales(family: &SpeedFamily, lines: &LinearPart, omega: f64) -> Result<Vec<f64>, Error> {
    let mut scales = vec![0.0f64; lines.active.len()];
    for k in 0..=family.max_order {
        let line = lines.order_response(k, omega)?;
        scales
            .iter_mut()
            .zip(&line.drive[0])
            .for_each(|(s, p)| *s = s.max(p.norm()));
    }
    for (size, active) in scales.iter_mut().zip(&lines.active) {
        if let ForceLaw::Contact(contact) = &family.relative.model.elements[active.branch].law {
            *size = size.max(contact.half_play);
        }
    }
    let largest = scales.iter().copied().fold(0.0, f64::max);
    let least = if largest > 0.0 { 1e-6 * largest } else { 1.0 };
    Ok(scales.into_iter().map(|s| s.max(least)).collect())
}

/// Pads or truncates a vector of unknowns to another number of orders.
fn resize_orders(t: &[f64], orders: usize, new_orders: usize, active: usize) -> Vec<f64> {
    let (width, new_width) = (2 * orders + 1, 2 * new_orders + 1);
    let mut out = Vec::with_capacity(active * new_width + 1);
    for k in 0..active {
        let block = &t[k * width..(k + 1) * width];
        out.extend((0..new_width).map(|j| block.get(j).copied().unwrap_or(0.0)));
    }
    out.push(t[t.len() - 1]);
    out
}
