//! Drawing data of each gear: readings of its tooth thickness, nominal and at both limits.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_number;
use crate::gear::cylindrical::drawing::ReadingLimits;
use crate::gear::cylindrical::member::Member;

/// A reading of tooth thickness.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawingReading {
    /// Name of ISO 21771-2, with the number of teeth or the diameter of the ball.
    pub name: String,
    /// Symbol.
    pub symbol: &'static str,
    /// The readings, m.
    pub limits: ReadingLimits,
    /// Height of a chord below the tip, m.
    pub height: Option<f64>,
}

/// Steps of the default ball diameter, m.
const BALL_STEP: f64 = 1e-5;

/// Diameter of the ball that touches near the middle of the flanks, as it is shown, m.
fn default_ball(member: &Member) -> f64 {
    (member.gear.default_ball_diameter() / BALL_STEP).round() * BALL_STEP
}

/// Refuses a stated ball that does not touch the involute flanks.
///
/// # Errors
/// `OutOfRange`, with the ball that touches near their middle.
pub fn check_ball(member: &Member, ball: Option<f64>) -> Result<(), Error> {
    let Some(ball) = ball.filter(|ball| !member.touches_ball(*ball)) else {
        return Ok(());
    };
    let shown = format_number(1e3 * ball);
    let message = format!("a ball of {shown} mm does not touch the involute flanks");
    let usual = default_ball(member);
    let hint = match usual > 0.0 {
        true => format!(
            "ball_diameter = \"{:.2} mm\" touches near their middle",
            1e3 * usual
        ),
        false => "omit `ball_diameter`".into(),
    };
    let error = Error::new(Code::OutOfRange, message).with_key("ball_diameter");
    Err(error.with_hint(hint))
}

/// The readings of a gear that exist: span, over balls of a stated diameter or by default one that touches in the middle of the flanks,
/// chord, constant chord.
pub fn readings(member: &Member, ball: Option<f64>) -> Vec<DrawingReading> {
    let k = member.gear.default_span_teeth();
    let what = if member.gear.internal {
        "spaces"
    } else {
        "teeth"
    };
    let span = member.span(k).map(|limits| DrawingReading {
        name: format!("span over {k} {what}"),
        symbol: "W_k",
        limits,
        height: None,
    });
    let usual = default_ball(member);
    let side = if member.gear.internal {
        "between"
    } else {
        "over"
    };
    let by_default = if ball.is_none() { " (default)" } else { "" };
    let balls = Some(ball.unwrap_or(usual))
        .filter(|ball| *ball > 0.0)
        .and_then(|ball| {
            let limits = member.over_balls(ball)?;
            // Off the rounding of a conversion of units.
            let shown = format_number((1e9 * ball).round() / 1e6);
            Some(DrawingReading {
                name: format!("{side} balls of {shown} mm{by_default}"),
                symbol: "M_dK",
                limits,
                height: None,
            })
        });
    let chord = member.chord().map(|(limits, height)| DrawingReading {
        name: "chordal thickness".into(),
        symbol: "s̄_n",
        limits,
        height: Some(height),
    });
    let constant = member
        .constant_chord()
        .map(|(limits, height)| DrawingReading {
            name: "constant chord".into(),
            symbol: "s̄_c",
            limits,
            height: Some(height),
        });
    [span, balls, chord, constant]
        .into_iter()
        .flatten()
        .collect()
}
