//! The error of a chain over the angle of its output, with the ranges gear measurement reads off it.

use std::f64::consts::TAU;

use crate::base::error::Error;
use crate::gear::measurement::composite::Record;
use crate::machine::parts::Machine;
use crate::numeric::Complex;
use crate::numeric::fraction::Fraction;
use crate::numeric::lattice::Lattice;
use crate::scene::study::TransmissionStudy;
use crate::transmission::chain::Chain;
use crate::transmission::lines::{Line, Origin};
use crate::transmission::record::{self, Synthetic};

/// Samples that ranges are read from for one of the record: with 64 in the fastest cycle 1/800 of its amplitude is missed.
const FINER: usize = 8;

/// The most of these samples.
const MOST: usize = 1 << 22;

/// A record and its ranges, rad.
pub struct Recorded {
    /// The record.
    pub record: Synthetic,
    /// Of every line A and ψ as they went into it; unknown phases are drawn.
    pub lines: Vec<Complex>,
    /// Teeth of the output; absent where no gear turns with it and none are stated.
    pub teeth: Option<u32>,
    /// F_i′ over the whole record.
    pub total: f64,
    /// F_i′ over one turn.
    pub by_turn: f64,
    /// f_i′, long wave, short wave, by teeth: long are the orders below half of them, short the others within one pitch.
    pub by_tooth: Option<[f64; 3]>,
}

/// Makes the record of `values`, one of every line.
///
/// # Errors
/// More samples than a record holds; those of the evaluation.
pub fn recorded(
    machine: &Machine,
    chain: &Chain,
    lines: &[Line],
    values: &[Complex],
    period: Option<&Fraction>,
    study: &TransmissionStudy,
) -> Result<Recorded, Error> {
    let drawn = drawn(machine, lines, values);
    let turns_itself = machine.freedoms[chain.ends.output].axis.turns();
    let teeth = study
        .teeth
        .or_else(|| teeth(machine, chain).filter(|_| turns_itself));
    // Tooth by tooth: 8 samples of a cycle, 20 of a tooth.
    let by_teeth = 2.5 * f64::from(teeth.unwrap_or(0));
    let fastest = lines
        .iter()
        .fold(by_teeth.max(1.0), |m, line| m.max(line.order.value()));
    let (turns, closed) = record::turns(study.window, period, fastest)?;
    let added: Vec<(f64, Complex)> = lines
        .iter()
        .zip(&drawn)
        .map(|(line, z)| (line.order.value(), *z))
        .collect();
    let made = record::synthetic(&added, turns, fastest, closed);
    // Crests stand between the samples of a record: ranges are read from finer ones.
    let finer = (MOST / made.values.len().max(1)).clamp(1, FINER) as f64 * fastest;
    let fine = match finer > fastest {
        true => record::synthetic(&added, turns, finer, closed).values,
        false => made.values.clone(),
    };
    let record = Record::new(&fine, turns, teeth.unwrap_or(1) as usize, closed)?;
    let (total, by_turn) = (record.total(), record.by_turn().sliding);
    let by_pitch = teeth.map(|_| record.by_pitch().sliding);
    let by_tooth = match (by_pitch, teeth) {
        (Some(by_pitch), Some(teeth)) => {
            // The lines are known: long are those below half the teeth, exactly, and nothing leaks.
            let is_long = |order: f64| order < 0.5 * f64::from(teeth);
            let long: Vec<(f64, Complex)> =
                added.iter().copied().filter(|l| is_long(l.0)).collect();
            let mut wave = record::synthetic(&long, turns, finer, closed).values;
            let long_range = Record::new(&wave, turns, teeth as usize, closed)?.total();
            let both = wave.iter_mut().zip(&fine);
            both.for_each(|(long, whole)| *long = whole - *long);
            let short = Record::new(&wave, turns, teeth as usize, closed)?;
            Some([by_pitch, long_range, short.by_pitch().sliding])
        }
        _ => None,
    };
    Ok(Recorded {
        lines: drawn,
        teeth,
        total,
        by_turn,
        by_tooth,
        record: made,
    })
}

/// Values with unknown phases drawn from a fixed seed: harmonics of one error turn together.
fn drawn(machine: &Machine, lines: &[Line], values: &[Complex]) -> Vec<Complex> {
    let phases = Lattice::new(machine.errors.len(), 1, 1).point(0, 0);
    let turned = |(line, value): (&Line, &Complex)| match line.origin {
        Origin::Declared(number) if !machine.errors[number].phase_known => {
            *value * Complex::cis(TAU * phases[number] * f64::from(line.harmonic))
        }
        _ => *value,
    };
    lines.iter().zip(values).map(turned).collect()
}

/// Teeth of a gear that turns with the output.
fn teeth(machine: &Machine, chain: &Chain) -> Option<u32> {
    let with_output = |freedom: usize| {
        chain
            .turns(freedom)
            .is_some_and(|t| t.abs() == Fraction::one())
    };
    let gears = machine
        .gears
        .iter()
        .filter(|gear| gear.carrier.is_none() && with_output(gear.turning));
    gears.filter_map(|gear| gear.teeth).max()
}
