//! Speeds of a map or a diagram.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::kind::Kind;
use crate::base::units;

/// Equally spaced speeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedRange {
    /// First speed, rad/s.
    pub from: f64,
    /// Last speed, rad/s.
    pub to: f64,
    /// How many speeds, both ends included.
    pub count: u32,
}

impl SpeedRange {
    /// The speeds, rising, rad/s.
    pub fn all(self) -> Vec<f64> {
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
        const USUAL: u32 = 50;
        const MOST_POINTS: u32 = 100_000;
        let form = || {
            let message = format!("\"{}\" is not a range of speeds", units::shortened(text));
            let hint = format!(
                "{subject} takes first:last:points, such as 0:3000:61 or \"0 rpm:50 Hz:61\""
            );
            Error::new(Code::OutOfRange, message).hint(hint)
        };
        let parts: Vec<&str> = text.splitn(4, ':').collect();
        let (from, to, count) = match parts[..] {
            [from, to] => (from, to, USUAL),
            [from, to, count] => {
                let count = count.trim().parse().map_err(|_| form())?;
                (from, to, count)
            }
            _ => return Err(form()),
        };
        let speed = |text: &str| units::parse_or_bare(text, Kind::Speed, "rpm", subject);
        let (from, to) = (speed(from)?, speed(to)?);
        if !(2..=MOST_POINTS).contains(&count) || from >= to {
            return Err(form());
        }
        Ok(SpeedRange { from, to, count })
    }
}
