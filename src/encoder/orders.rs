//! Candidate orders of a gear train: shafts, meshes, multiples, sidebands, as fractions.
//!
//! A record of T turns tells two orders apart that differ by 1/T or more; of nearer ones the first is fitted for all.

use std::collections::HashMap;

use super::gear_train::{GearTrain, OrderSource};
use crate::numeric::fraction::Fraction;

/// An order and what may make it.
#[derive(Debug, Clone, PartialEq)]
pub struct CandidateOrder {
    /// Per turn of the output.
    pub fraction: Fraction,
    /// The same as a number.
    pub value: f64,
    /// Names of the sources with exactly this order: more than one cannot be distinguished by any record of these two shafts at one speed.
    pub names: Vec<String>,
    /// Orders too near to be resolved in this record.
    pub unresolved: Vec<UnresolvedOrder>,
}

/// An order that this record does not tell from another.
#[derive(Debug, Clone, PartialEq)]
pub struct UnresolvedOrder {
    /// Fraction and source of the order.
    pub name: String,
    /// Turns of the output that would tell it.
    pub turns: f64,
}

/// Orders that a model names, with what has them.
#[derive(Debug, Clone, Default)]
pub struct KnownOrders {
    /// Orders of declared errors: fitted.
    pub declared: Vec<(Fraction, String)>,
    /// Orders of all shafts and meshes, between the encoders or not: searched for.
    pub possible: Vec<(Fraction, String)>,
}

/// Range of orders that a record can resolve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrderRange {
    /// The highest order.
    pub band: f64,
    /// Turns of the output.
    pub turns: f64,
}

/// Share of 1/T by which two orders differ at least to be fitted both.
pub const MIN_SEPARATION: f64 = 0.9;

/// Orders in the order of their weight: those to be fitted, then those to be looked for.
#[derive(Debug, Default)]
pub struct OrderList {
    orders: Vec<CandidateOrder>,
    places: HashMap<Fraction, usize>,
}

impl OrderList {
    /// Adds an order, or a name to it.
    pub fn insert(&mut self, exact: Fraction, name: String) {
        let value = exact.to_f64();
        if exact.is_zero() || exact.is_negative() {
            return;
        }
        match self.places.get(&exact) {
            Some(&at) => {
                let names = &mut self.orders[at].names;
                if !names.contains(&name) {
                    names.push(name);
                }
            }
            None => {
                self.places.insert(exact.clone(), self.orders.len());
                self.orders.push(CandidateOrder {
                    fraction: exact,
                    value,
                    names: vec![name],
                    unresolved: Vec::new(),
                });
            }
        }
    }

    /// Adds the shafts with two multiples, the meshes with `multiples`, and one sideband on either side.
    pub fn add_gear_train(&mut self, teeth: &GearTrain, multiples: usize) {
        let (shafts, meshes) = (teeth.shafts(), teeth.meshes());
        for one in shafts.iter().rev().chain(&meshes) {
            self.insert(one.order.clone(), one.name.clone());
        }
        shafts.iter().rev().for_each(|s| self.multiple(s, 2));
        for k in 2..=multiples {
            meshes.iter().for_each(|m| self.multiple(m, k));
        }
        for k in 1..=multiples {
            self.sidebands(&shafts, &meshes, k, 1);
        }
    }

    /// Also the multiples of each shaft up to half its teeth, and further sidebands.
    pub fn add_extended(&mut self, teeth: &GearTrain, multiples: usize) {
        const MAX_SIDEBANDS: usize = 4;
        /// Beyond so many multiples of a shaft an unexplained line is not named after it.
        const MAX_COUNT: u32 = 200;
        let (shafts, meshes) = (teeth.shafts(), teeth.meshes());
        let pairs = teeth.pairs();
        for (k, shaft) in shafts.iter().enumerate().rev() {
            let driven = k.checked_sub(1).map_or(0, |j| pairs[j].1);
            let driving = pairs.get(k).map_or(0, |p| p.0);
            for n in 3..=(driven.max(driving) / 2).min(MAX_COUNT) {
                self.multiple(shaft, n as usize);
            }
        }
        for side in 2..=MAX_SIDEBANDS {
            (1..=multiples).for_each(|k| self.sidebands(&shafts, &meshes, k, side));
        }
    }

    fn multiple(&mut self, member: &OrderSource, n: usize) {
        let order = &member.order * &Fraction::new(n as i64, 1);
        self.insert(order, times(n, &member.name));
    }

    /// The n-th multiple of each mesh with its own two shafts on either side.
    fn sidebands(&mut self, shafts: &[OrderSource], meshes: &[OrderSource], n: usize, side: usize) {
        for (mesh, own) in meshes.iter().zip(shafts.windows(2)) {
            let carrier = &mesh.order * &Fraction::new(n as i64, 1);
            for shaft in own {
                let by = &shaft.order * &Fraction::new(side as i64, 1);
                for (order, sign) in [(&carrier - &by, '−'), (&carrier + &by, '+')] {
                    // What turns or meshes with an order is likelier to make it than a sideband.
                    if !self.places.contains_key(&order) {
                        let (a, b) = (times(n, &mesh.name), times(side, &shaft.name));
                        self.insert(order, format!("{a} {sign} {b}"));
                    }
                }
            }
        }
    }

    /// Orders that a record can resolve, in addition to those fitted `already`; an order nearer than the resolution to one before it is
    /// noted there.
    pub fn resolve(self, reach: OrderRange, already: &mut [CandidateOrder]) -> Vec<CandidateOrder> {
        let mut fresh: Vec<CandidateOrder> = Vec::new();
        let least = MIN_SEPARATION / reach.turns;
        for order in self.orders {
            // Below this the record is a constant.
            if order.value > reach.band || order.value < least {
                continue;
            }
            let near = |o: &&mut CandidateOrder| (o.value - order.value).abs() < least;
            let known = already.iter_mut().chain(&mut fresh).find(near);
            match known {
                Some(known) if known.fraction == order.fraction => {
                    let is_new = |n: &String| !known.names.contains(n) && !is_sideband(n);
                    let news: Vec<String> = order.names.into_iter().filter(is_new).collect();
                    known.names.extend(news);
                }
                Some(known) => {
                    let turns = 1.0 / (known.value - order.value).abs();
                    known.unresolved.push(UnresolvedOrder {
                        name: format!("{} ({})", order.fraction, order.names.join(", ")),
                        turns,
                    });
                }
                None => fresh.push(order),
            }
        }
        fresh
    }
}

fn is_sideband(name: &str) -> bool {
    name.contains(" − ") || name.contains(" + ")
}

fn times(n: usize, name: &str) -> String {
    match n {
        1 => name.to_string(),
        n => format!("{n} × {name}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resolve(teeth: &str, turns: f64) -> Vec<CandidateOrder> {
        let teeth = GearTrain::parse(teeth).unwrap();
        let reach = OrderRange { band: 400.0, turns };
        let mut list = OrderList::default();
        list.add_gear_train(&teeth, 3);
        list.resolve(reach, &mut Vec::new())
    }

    /// 21:63: one turn of the pinion is a third of the wheel's: the third multiple of the wheel has its order, exactly.
    #[test]
    fn exact_coincidence() {
        let teeth = GearTrain::parse("21:63").unwrap();
        let reach = OrderRange {
            band: 400.0,
            turns: 5.0,
        };
        let mut fitted = resolve("21:63", 5.0);
        let mut more = OrderList::default();
        more.add_extended(&teeth, 3);
        let more = more.resolve(reach, &mut fitted);
        let three = fitted
            .iter()
            .find(|o| o.fraction.to_string() == "3")
            .unwrap();
        assert_eq!(three.names, ["input", "3 × output"]);
        assert!(three.unresolved.is_empty());
        assert!(more.iter().any(|o| o.names == ["4 × output"]));
    }

    /// 21:64: the pinion's 64/21 lies 1/21 next to the wheel's third multiple: distinguished by 21 turns, noted in 5.
    #[test]
    fn exact_nearness() {
        let one = |turns: f64| {
            let mut fitted = resolve("21:64", turns);
            let mut more = OrderList::default();
            more.add_extended(&GearTrain::parse("21:64").unwrap(), 3);
            let reach = OrderRange { band: 400.0, turns };
            let fresh = more.resolve(reach, &mut fitted);
            let input = fitted.into_iter().find(|o| o.names[0] == "input").unwrap();
            (input, fresh)
        };
        let (short, fresh) = one(5.0);
        assert!(
            short
                .unresolved
                .iter()
                .any(|n| n.name.contains("3 × output") && (n.turns - 21.0).abs() < 1e-9)
        );
        assert!(!fresh.iter().any(|o| o.names[0] == "3 × output"));
        let (long, fresh) = one(21.5);
        assert!(long.unresolved.is_empty());
        assert!(fresh.iter().any(|o| o.names[0] == "3 × output"));
    }
}
