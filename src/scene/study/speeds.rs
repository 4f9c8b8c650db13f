//! Equally spaced speeds, `A:B:N`.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity;
use crate::base::quantity_kind::QuantityKind;

/// Equally spaced speeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedRange {
    /// First speed, rad/s.
    pub from: f64,
    /// Last speed, rad/s.
    pub to: f64,
    /// Number of speeds, both ends included.
    pub count: u32,
}

impl SpeedRange {
    /// The speeds, rising, rad/s.
    pub fn values(self) -> Vec<f64> {
        let last = self.count - 1;
        let step = (self.to - self.from) / f64::from(last);
        let at = |k: u32| match k == last {
            true => self.to,
            false => self.from + step * f64::from(k),
        };
        (0..self.count).map(at).collect()
    }

    /// Reads `A:B:N`, two speeds (rpm where bare) and how many points; 50 points where `N` is left out.
    pub fn parse(text: &str, subject: &str) -> Result<SpeedRange, Error> {
        const DEFAULT: u32 = 50;
        const MAX_POINTS: u32 = 100_000;
        let form = |why: &str| {
            let shown = quantity::truncate(text);
            let message = format!("\"{shown}\" is not a range of speeds: {why}");
            let hint = format!(
                "{subject} takes first:last:points, such as 0:3000:61 or \"0 rpm:50 Hz:61\""
            );
            Error::new(Code::OutOfRange, message).with_hint(hint)
        };
        let parts: Vec<&str> = text.splitn(4, ':').collect();
        let (from, to, count) = match parts[..] {
            [from, to] => (from, to, DEFAULT),
            [from, to, count] => {
                let count = count.trim().parse();
                let count = count.map_err(|_| form("its third part is not a number of points"))?;
                (from, to, count)
            }
            _ => return Err(form("it does not have two or three parts")),
        };
        let speed = |text: &str| quantity::parse_or_bare(text, QuantityKind::Speed, "rpm", subject);
        let (from, to) = (speed(from)?, speed(to)?);
        if !(2..=MAX_POINTS).contains(&count) {
            return Err(form("2 to 100000 points are allowed"));
        }
        if from >= to {
            return Err(form("its first speed is not below its last"));
        }
        Ok(SpeedRange { from, to, count })
    }
}
