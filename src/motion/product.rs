//! Products of known functions of time: piece by piece a sum of polynomials times cosines,
//! `cos α cos β = ½ cos(α + β) + ½ cos(α − β)`.

use super::burst::Burst;
use super::signal::{Harmonic, Knot, Signal};
use crate::base::code::Code;
use crate::base::error::Error;

/// `(c₀ + c₁ τ + c₂ τ²) cos(ω t + φ)`, τ the time since the piece began.
#[derive(Debug, Clone, Copy)]
struct Term {
    power: [f64; 3],
    omega: f64,
    phase: f64,
}

/// The product of two signals.
///
/// # Errors
/// Lines times lines beyond a parabola; a harmonic whose amplitude is not a straight line.
pub fn product(a: &Signal, b: &Signal) -> Result<Signal, Error> {
    let knots = a.knots.iter().chain(&b.knots).map(|k| k.time);
    let mut times: Vec<f64> = knots.chain([f64::NEG_INFINITY]).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let mut made = Signal::default();
    for (at, &from) in times.iter().enumerate() {
        let to = times.get(at + 1).copied().unwrap_or(f64::INFINITY);
        let always = times.len() == 1;
        let mut line = Knot::line(from, 0.0, 0.0);
        for x in terms(a, from) {
            for y in terms(b, from) {
                for term in multiplied(&x, &y)? {
                    push_term(&mut made, &mut line, term, (from, to, always))?;
                }
            }
        }
        made.knots.push(line);
    }
    Ok(made)
}

/// Terms of a signal on the piece that begins at an instant.
fn terms(signal: &Signal, from: f64) -> Vec<Term> {
    let origin = if from.is_finite() { from } else { 0.0 };
    let piece = signal.piece(from);
    let mut all = Vec::new();
    if let Some(knot) = piece.checked_sub(1).map(|at| signal.knots[at]) {
        let power = [
            knot.value_at(origin),
            knot.slope_at(origin),
            0.5 * knot.curvature,
        ];
        all.push(Term {
            power,
            omega: 0.0,
            phase: 0.0,
        });
    }
    all.extend(signal.harmonics.iter().map(|h| Term {
        power: [h.amplitude, 0.0, 0.0],
        omega: h.omega,
        phase: h.phase,
    }));
    let bursts = signal.bursts.iter().filter(|b| b.lasts(from));
    all.extend(bursts.map(|b| {
        let before = if b.from.is_finite() {
            origin - b.from
        } else {
            origin
        };
        Term {
            power: [b.amplitude + b.growth * before, b.growth, 0.0],
            omega: b.omega,
            phase: b.phase,
        }
    }));
    all.retain(|term| term.power != [0.0; 3]);
    all
}

fn multiplied(x: &Term, y: &Term) -> Result<Vec<Term>, Error> {
    let ([a, b, c], [d, e, f]) = (x.power, y.power);
    if b * f + c * e != 0.0 || c * f != 0.0 {
        let message = "the product of these functions is of degree 3 or higher between its knots";
        return Err(Error::new(Code::Conflict, message)
            .with_hint("at most two factors may be piecewise linear at the same time; combine the other factors in one table"));
    }
    let power = [a * d, a * e + b * d, a * f + b * e + c * d];
    let whole = |phase: f64, omega: f64, share: f64| Term {
        power: power.map(|p| share * p),
        omega,
        phase,
    };
    Ok(match (x.omega == 0.0, y.omega == 0.0) {
        (true, true) => vec![whole(0.0, 0.0, x.phase.cos() * y.phase.cos())],
        (true, false) => vec![whole(y.phase, y.omega, x.phase.cos())],
        (false, true) => vec![whole(x.phase, x.omega, y.phase.cos())],
        (false, false) => vec![
            whole(x.phase + y.phase, x.omega + y.omega, 0.5),
            whole(x.phase - y.phase, x.omega - y.omega, 0.5),
        ],
    })
}

/// Adds a term to a signal: to its line, or as a harmonic where it lasts always, else as a burst.
fn push_term(
    made: &mut Signal,
    line: &mut Knot,
    term: Term,
    (from, to, always): (f64, f64, bool),
) -> Result<(), Error> {
    let Term {
        power: [value, slope, square],
        omega,
        phase,
    } = term;
    if omega == 0.0 {
        let share = phase.cos();
        line.value += share * value;
        line.slope += share * slope;
        line.curvature += 2.0 * share * square;
        return Ok(());
    }
    if square != 0.0 {
        let message = "the amplitude of a harmonic in this product is a parabola";
        return Err(Error::new(Code::Conflict, message).with_hint(
            "at most one factor other than harmonics may be piecewise linear at one time",
        ));
    }
    match always && slope == 0.0 {
        true => made.harmonics.push(Harmonic {
            amplitude: value,
            omega,
            phase,
        }),
        false => made.bursts.push(Burst {
            from,
            to,
            amplitude: value,
            growth: slope,
            omega,
            phase,
        }),
    }
    Ok(())
}
