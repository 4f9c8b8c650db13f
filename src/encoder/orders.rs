//! Candidate orders of a gear train: shafts, meshes, multiples, sidebands, as fractions.
//!
//! A record of T revolutions resolves two orders that differ by 1/T or more; of closer orders only the first is fitted.

use std::collections::HashMap;

use super::gear_train::{GearTrain, OrderSource};
use crate::numeric::fraction::Fraction;

/// Order of a gear train and the names of its sources.
#[derive(Debug, Clone, PartialEq)]
pub struct CandidateOrder {
    /// Order per output revolution.
    pub fraction: Fraction,
    /// Order as a floating-point number.
    pub value: f64,
    /// Names of the sources with exactly this order, inseparable in any record of these two shafts at one speed.
    pub names: Vec<String>,
    /// Orders closer than the resolution of the record.
    pub unresolved: Vec<UnresolvedOrder>,
}

/// Order not resolved from another in the record.
#[derive(Debug, Clone, PartialEq)]
pub struct UnresolvedOrder {
    /// Fraction and source of the order.
    pub name: String,
    /// Output revolutions required to resolve the order.
    pub turns: f64,
}

/// Orders known from a model, with the names of their sources.
#[derive(Debug, Clone, Default)]
pub struct KnownOrders {
    /// Orders of declared errors, always fitted.
    pub declared: Vec<(Fraction, String)>,
    /// Orders of all shafts and meshes of the model, fitted if significant.
    pub possible: Vec<(Fraction, String)>,
}

/// Order band of a record and its length, which limits the resolution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrderRange {
    /// Highest order, per output revolution.
    pub band: f64,
    /// Length of the record, output revolutions.
    pub turns: f64,
}

/// Minimum difference of two fitted orders, as a multiple of 1/T.
pub const MIN_SEPARATION: f64 = 0.9;

/// Distinct candidate orders by decreasing priority.
#[derive(Debug, Default)]
pub struct OrderList {
    orders: Vec<CandidateOrder>,
    indices: HashMap<Fraction, usize>,
}

impl OrderList {
    /// Adds an order, or the name to an existing order.
    pub fn insert(&mut self, exact: Fraction, name: String) {
        let value = exact.to_f64();
        if exact.is_zero() || exact.is_negative() {
            return;
        }
        match self.indices.get(&exact) {
            Some(&index) => {
                let names = &mut self.orders[index].names;
                if !names.contains(&name) {
                    names.push(name);
                }
            }
            None => {
                self.indices.insert(exact.clone(), self.orders.len());
                self.orders.push(CandidateOrder {
                    fraction: exact,
                    value,
                    names: vec![name],
                    unresolved: Vec::new(),
                });
            }
        }
    }

    /// Adds the shafts with two harmonics, the meshes with `multiples` harmonics, and their first-order sidebands.
    pub fn add_gear_train(&mut self, teeth: &GearTrain, multiples: usize) {
        let (shafts, meshes) = (teeth.shafts(), teeth.meshes());
        for source in shafts.iter().rev().chain(&meshes) {
            self.insert(source.order.clone(), source.name.clone());
        }
        shafts.iter().rev().for_each(|s| self.multiple(s, 2));
        for k in 2..=multiples {
            meshes.iter().for_each(|m| self.multiple(m, k));
        }
        for k in 1..=multiples {
            self.sidebands(&shafts, &meshes, k, 1);
        }
    }

    /// Adds the multiples of each shaft up to half its tooth number, and sidebands of higher order.
    pub fn add_extended(&mut self, teeth: &GearTrain, multiples: usize) {
        const MAX_SIDEBANDS: usize = 4;
        /// Highest multiple of a shaft order.
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

    /// Sidebands of the n-th mesh harmonic at multiples of the orders of the two shafts in mesh.
    fn sidebands(&mut self, shafts: &[OrderSource], meshes: &[OrderSource], n: usize, side: usize) {
        for (mesh, pair) in meshes.iter().zip(shafts.windows(2)) {
            let carrier = &mesh.order * &Fraction::new(n as i64, 1);
            for shaft in pair {
                let spacing = &shaft.order * &Fraction::new(side as i64, 1);
                for (order, sign) in [(&carrier - &spacing, '−'), (&carrier + &spacing, '+')] {
                    // A shaft or mesh of the same order is the more probable source.
                    if !self.indices.contains_key(&order) {
                        let (a, b) = (times(n, &mesh.name), times(side, &shaft.name));
                        self.insert(order, format!("{a} {sign} {b}"));
                    }
                }
            }
        }
    }

    /// Resolvable orders in addition to the `fitted` ones. An order closer than the resolution to an earlier one is recorded there as
    /// unresolved.
    pub fn resolve(self, range: OrderRange, fitted: &mut [CandidateOrder]) -> Vec<CandidateOrder> {
        let mut resolved: Vec<CandidateOrder> = Vec::new();
        let resolution = MIN_SEPARATION / range.turns;
        for order in self.orders {
            // An order below the resolution is indistinguishable from the mean.
            if order.value > range.band || order.value < resolution {
                continue;
            }
            let is_close = |o: &&mut CandidateOrder| (o.value - order.value).abs() < resolution;
            let known = fitted.iter_mut().chain(&mut resolved).find(is_close);
            match known {
                Some(known) if known.fraction == order.fraction => {
                    let is_new = |n: &String| !known.names.contains(n) && !is_sideband(n);
                    let new_names: Vec<String> = order.names.into_iter().filter(is_new).collect();
                    known.names.extend(new_names);
                }
                Some(known) => {
                    let turns = 1.0 / (known.value - order.value).abs();
                    known.unresolved.push(UnresolvedOrder {
                        name: format!("{} ({})", order.fraction, order.names.join(", ")),
                        turns,
                    });
                }
                None => resolved.push(order),
            }
        }
        resolved
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

    /// 21:63: the order of the pinion equals the third multiple of the wheel.
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

    /// 21:64: the pinion order 64/21 is 1/21 from the third multiple of the wheel: resolved in 21 revolutions, unresolved in 5.
    #[test]
    fn exact_nearness() {
        let resolved_in = |turns: f64| {
            let mut fitted = resolve("21:64", turns);
            let mut more = OrderList::default();
            more.add_extended(&GearTrain::parse("21:64").unwrap(), 3);
            let reach = OrderRange { band: 400.0, turns };
            let fresh = more.resolve(reach, &mut fitted);
            let input = fitted.into_iter().find(|o| o.names[0] == "input").unwrap();
            (input, fresh)
        };
        let (short, fresh) = resolved_in(5.0);
        assert!(
            short
                .unresolved
                .iter()
                .any(|n| n.name.contains("3 × output") && (n.turns - 21.0).abs() < 1e-9)
        );
        assert!(!fresh.iter().any(|o| o.names[0] == "3 × output"));
        let (long, fresh) = resolved_in(21.5);
        assert!(long.unresolved.is_empty());
        assert!(fresh.iter().any(|o| o.names[0] == "3 × output"));
    }
}
