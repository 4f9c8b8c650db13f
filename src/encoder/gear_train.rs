//! Gear train between two encoders as tooth numbers, with exact ratio and orders.
//!
//! Shaft k turns `Π z₂/z₁` of the pairs behind it for each turn of the output; a pair meshes `z₁` times a turn of its driver. All of
//! it repeats after the least common multiple of the denominators: the hunting cycle.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::truncate;
use crate::numeric::fraction::Fraction;

/// Most teeth of a gear, or threads of a worm.
const MAX_TEETH: u32 = 100_000;

/// Pairs in the order of the flow, `(driver, driven)`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GearTrain {
    pairs: Vec<(u32, u32)>,
}

/// A shaft or mesh with its own order.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderSource {
    /// Such as `input`, `shaft 2`, `mesh 21:63`.
    pub name: String,
    /// Per turn of the output.
    pub order: Fraction,
}

impl GearTrain {
    /// `21:63` or `21:63,17:40`, driver first.
    ///
    /// # Errors
    /// `Usage`: not of that form; `OutOfRange`: no teeth, or more than any gear has.
    pub fn parse(text: &str) -> Result<GearTrain, Error> {
        let wrong = || {
            let message = format!("\"{}\" is not a list of tooth numbers", truncate(text));
            Error::new(Code::Usage, message).with_hint("write driver:driven, pair by pair from input to output: 21:63 or 21:63,17:40; for a worm, its threads")
        };
        let mut pairs = Vec::new();
        for pair in text.split(',') {
            let (a, b) = pair.split_once(':').ok_or_else(wrong)?;
            let number = |t: &str| t.trim().parse::<u32>().map_err(|_| wrong());
            pairs.push((number(a)?, number(b)?));
        }
        GearTrain::new(pairs)
    }

    /// Gear train of pairs `(driver, driven)`.
    ///
    /// # Errors
    /// `OutOfRange`: no pair, no teeth, or more than any gear has.
    pub fn new(pairs: Vec<(u32, u32)>) -> Result<GearTrain, Error> {
        let out =
            |&(a, b): &(u32, u32)| !(1..=MAX_TEETH).contains(&a) || !(1..=MAX_TEETH).contains(&b);
        if let Some((a, b)) = pairs.iter().find(|p| out(p)) {
            let message = format!("{a}:{b} are not tooth numbers");
            return Err(Error::new(Code::OutOfRange, message)
                .with_hint(format!("they are 1 to {MAX_TEETH}")));
        }
        if pairs.is_empty() {
            return Err(Error::new(Code::OutOfRange, "no tooth numbers are stated")
                .with_hint("state them from input to output, such as 21:63"));
        }
        Ok(GearTrain { pairs })
    }

    /// Pairs in the order of the flow.
    pub fn pairs(&self) -> &[(u32, u32)] {
        &self.pairs
    }

    /// Teeth of the last driven gear.
    pub fn output_teeth(&self) -> usize {
        self.pairs.last().map_or(1, |p| p.1 as usize)
    }

    /// Turns of the output for one of the input.
    pub fn ratio(&self) -> Fraction {
        let one = |r: Fraction, &(a, b): &(u32, u32)| &r * &Fraction::new(a.into(), b.into());
        self.pairs.iter().fold(Fraction::one(), one)
    }

    /// Every shaft, the input first.
    pub fn shafts(&self) -> Vec<OrderSource> {
        let mut order = Fraction::one();
        let mut all = vec![OrderSource {
            name: "output".to_string(),
            order: order.clone(),
        }];
        for (k, &(a, b)) in self.pairs.iter().enumerate().rev() {
            order = &order * &Fraction::new(b.into(), a.into());
            let name = match k {
                0 => "input".to_string(),
                k => format!("shaft {}", k + 1),
            };
            all.push(OrderSource {
                name,
                order: order.clone(),
            });
        }
        all.reverse();
        all
    }

    /// Every mesh, from input to output.
    pub fn meshes(&self) -> Vec<OrderSource> {
        let shafts = self.shafts();
        let mesh = |(&(a, b), shaft): (&(u32, u32), &OrderSource)| OrderSource {
            name: format!("mesh {a}:{b}"),
            order: &shaft.order * &Fraction::new(a.into(), 1),
        };
        self.pairs.iter().zip(&shafts).map(mesh).collect()
    }

    /// Turns of the output until every tooth meets its mate as at first.
    pub fn hunting_turns(&self) -> Fraction {
        let shafts = self.shafts();
        let measure = Fraction::greatest_common_divisor(shafts.iter().map(|s| &s.order));
        &Fraction::one() / &measure.unwrap_or_else(Fraction::one)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A synthetic generator chain: 24:60, 30:75, worm with 2 threads and 90 teeth (orders by hand).
    #[test]
    fn exact_orders_of_a_chain() {
        let teeth = GearTrain::parse("24:60, 30:75,2:90").unwrap();
        let orders = |list: Vec<OrderSource>| -> Vec<String> {
            list.iter().map(|m| m.order.to_string()).collect()
        };
        assert_eq!(orders(teeth.shafts()), ["1125/4", "225/2", "45", "1"]);
        assert_eq!(orders(teeth.meshes()), ["6750", "3375", "90"]);
        assert_eq!(teeth.hunting_turns().to_string(), "4");
        assert_eq!(teeth.ratio().to_string(), "4/1125");
        let pair = GearTrain::parse("21:64").unwrap();
        assert_eq!(pair.hunting_turns().to_string(), "21");
    }

    #[test]
    fn refuses_what_are_no_teeth() {
        for text in ["", "21", "21:", "21;63", "a:b", "-1:3", "21:63,"] {
            assert_eq!(
                GearTrain::parse(text).unwrap_err().code,
                Code::Usage,
                "{text}"
            );
        }
        assert_eq!(GearTrain::parse("0:63").unwrap_err().code, Code::OutOfRange);
        assert_eq!(
            GearTrain::new(Vec::new()).unwrap_err().code,
            Code::OutOfRange
        );
    }
}
