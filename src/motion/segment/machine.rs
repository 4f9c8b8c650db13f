//! The machine of one regime: a linear machine, its constant forces and its borders.

use std::collections::BTreeMap;
use std::rc::Rc;

use super::border::{Border, Kind};
use super::frame::{dot, spread};
use super::inputs::{Entry, Input, Inputs};
use super::law::Held;
use super::linear::Linear;
use super::load::Load;
use super::sensor::{Sensor, drop_unseen};
use super::shared::Shared;
use crate::base::error::Error;
use crate::motion::contact::Affine;
use crate::motion::friction::Slip;
use crate::motion::train::{BranchStand, Law};
use crate::numeric::Complex;

/// A machine in one regime.
#[derive(Debug)]
pub struct Machine {
    /// What it shares with others.
    pub linear: Rc<Linear>,
    /// Constant push on σ.
    constant: Vec<f64>,
    /// What acts at present.
    pub load: Load,
    /// Where it gives way.
    pub borders: Vec<Border>,
    /// What these are read by.
    pub sensors: Vec<Sensor>,
    /// Which of the parts that do not turn no sensor sees.
    pub unseen: Vec<bool>,
}

impl Machine {
    /// Of a regime, whose branches are held by `laws`.
    ///
    /// # Errors
    /// Numbers out of range.
    pub fn new(
        shared: &Shared,
        linear: Rc<Linear>,
        laws: &[Held],
        stands: &[BranchStand],
    ) -> Result<Machine, Error> {
        let mut sensors = Vec::new();
        let borders = linear.borders(shared, laws, stands, &mut sensors)?;
        let parts = &linear.parts;
        let unseen = match parts.rings() {
            true => vec![false; parts.others.len()],
            false => drop_unseen(&mut sensors, parts.turning.len(), &parts.others),
        };
        Ok(Machine {
            constant: linear.constant(shared.train, laws),
            load: Load::default(),
            borders,
            sensors,
            unseen,
            linear,
        })
    }

    /// Takes up the lines that carry the inputs now.
    pub fn take_up(&mut self, inputs: &Inputs, pieces: &[u32]) {
        if self.load.push.is_empty() || !self.load.is_on(pieces) {
            let own = (&*self.linear, &self.constant[..]);
            self.load = Load::new(inputs, pieces, own, &self.borders);
        }
    }
}

impl Linear {
    /// Every border of every stand.
    fn borders(
        &self,
        shared: &Shared,
        laws: &[Held],
        stands: &[BranchStand],
        sensors: &mut Vec<Sensor>,
    ) -> Result<Vec<Border>, Error> {
        let mut found = Vec::new();
        for (at, branch) in shared.train.branches.iter().enumerate() {
            match (&branch.law, stands[at]) {
                (Law::Contact(contact), BranchStand::Contact(stand, piece)) => {
                    let factor = branch.factor(0.0, &[], piece).0;
                    for (affine, to) in contact.borders(stand, factor) {
                        let kind = Kind::Deflection(affine);
                        let next = BranchStand::Contact(to, piece);
                        found.push(self.border(shared, (at, kind, next), sensors));
                    }
                }
                (Law::Friction(_), BranchStand::Friction(slip)) if slip != Slip::Stick => {
                    let affine = Affine {
                        rate: slip.sign(),
                        ..Default::default()
                    };
                    let kind = Kind::Deflection(affine);
                    let next = BranchStand::Friction(Slip::Stick);
                    found.push(self.border(shared, (at, kind, next), sensors));
                }
                (Law::Friction(friction), BranchStand::Friction(_)) => {
                    let Some(hold) = &self.hold else { continue };
                    for slip in [Slip::Forward, Slip::Backward] {
                        let held = hold.reaction(shared, laws, at, friction.breakaway, slip)?;
                        let next = BranchStand::Friction(slip);
                        let kind = Kind::Reaction(held);
                        found.push(self.border(shared, (at, kind, next), sensors));
                    }
                }
                _ => {}
            }
        }
        Ok(found)
    }

    fn border(
        &self,
        shared: &Shared,
        (branch, kind, to): (usize, Kind, BranchStand),
        sensors: &mut Vec<Sensor>,
    ) -> Border {
        let (m, len) = (self.modes.count(), self.spectrum.count());
        let seen = &self.seen;
        let mut modal = vec![0.0; 2 * m + shared.train.inner()];
        let mut direct: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
        let (constant, dense) = match &kind {
            Kind::Deflection(affine) => {
                for j in 0..m {
                    modal[j] = affine.deflection * seen.sees[branch][j];
                    modal[m + j] = affine.rate * seen.sees[branch][j];
                }
                let own = |input: &Input| input.entry == Entry::Imposed(branch);
                if let Some(at) = shared.inputs.list.iter().position(own) {
                    direct.insert(at, [-affine.deflection, -affine.rate]);
                }
                let dense = self.hold.as_ref().map(|_| {
                    let w = spread(&shared.train.branches[branch].direction, shared.train.n());
                    let times = |a: f64| w.iter().map(|w| a * w).collect::<Vec<f64>>();
                    [times(affine.deflection), times(affine.rate)]
                });
                (affine.constant, dense)
            }
            Kind::Reaction(held) => {
                for j in 0..m {
                    let shape = self.modes.shapes.col_as_slice(j);
                    modal[j] = dot(&held.place, shape);
                    modal[m + j] = dot(&held.rate, shape);
                }
                modal[2 * m..].copy_from_slice(&held.inner);
                direct.extend(held.direct.iter().copied());
                (held.constant, Some([held.place.clone(), held.rate.clone()]))
            }
        };
        let row = self.stage.row(&modal, len);
        let rate = self.spectrum.rate_of(&row);
        let phasors = shared.inputs.frequencies.iter().enumerate();
        let phasors = phasors.map(|(f, &omega)| {
            let s = Complex::new(0.0, omega);
            let along = |of: &[Complex]| {
                let both = row.iter().zip(of);
                both.fold(Complex::ZERO, |sum, (c, x)| sum + x * *c)
            };
            let fed = direct
                .iter()
                .fold(Complex::ZERO, |sum, (&input, [value, rate])| {
                    let own = shared.inputs.list[input].harmonics.iter();
                    own.filter(|(at, _)| *at == f)
                        .fold(sum, |sum, (_, phasor)| sum + phasor * (s * rate + *value))
                });
            let value = along(&self.steady[f]) + fed;
            [value, value * s + along(&self.left[f])]
        });
        let phasors: Vec<[Complex; 2]> = phasors.collect();
        let turning = |which: usize| {
            phasors
                .iter()
                .flat_map(move |p| [p[which].re, -p[which].im])
        };
        let sizes = phasors.iter().map(|[p, _]| p.norm());
        let sizes: Vec<f64> = sizes.chain(self.spectrum.sizes_of(&row)).collect();
        let rate: Vec<f64> = turning(1).chain(rate).collect();
        let row: Vec<f64> = turning(0).chain(row.iter().copied()).collect();
        let own = Sensor::new(&self.parts.turning, &row, &rate, &sizes);
        let alike = sensors.iter().map(|known| own.sign(known)).enumerate();
        let alike = alike.filter_map(|(at, sign)| Some((at, sign?))).next();
        let (sensor, sign) = alike.unwrap_or_else(|| {
            sensors.push(own);
            (sensors.len() - 1, 1.0)
        });
        Border {
            branch,
            to,
            sensor,
            sign,
            sizes,
            row,
            constant,
            direct: direct.into_iter().collect(),
            dense,
            kind,
        }
    }
}
