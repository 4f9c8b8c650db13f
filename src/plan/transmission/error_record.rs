//! Synthetic transmission-error record over the output angle, with F_i′, f_i′, long and short wave.

use std::f64::consts::TAU;

use crate::base::error::Error;
use crate::machine::components::Machine;
use crate::numeric::Complex;
use crate::numeric::fraction::Fraction;
use crate::numeric::lattice::RankOneLattice;
use crate::scene::study::TransmissionStudy;
use crate::te_record::single_flank::SingleFlankRecord;
use crate::transmission::chain::TransmissionChain;
use crate::transmission::order_lines::{LineOrigin, OrderLine};
use crate::transmission::record::{self, SyntheticRecord};

/// Samples that ranges are read from for one of the record: with 64 in the fastest cycle 1/800 of its amplitude is missed.
const OVERSAMPLING: usize = 8;

/// The most of these samples.
const MAX_SAMPLES: usize = 1 << 22;

/// A record and its ranges, rad.
pub struct TransmissionErrorRecord {
    /// The record.
    pub record: SyntheticRecord,
    /// Amplitude A and phase ψ of every line as input; unknown phases are drawn.
    pub lines: Vec<Complex>,
    /// Teeth of the output; absent where no gear turns with it and none are stated.
    pub teeth: Option<u32>,
    /// F_i′ over the whole record.
    pub total: f64,
    /// F_i′ over one turn.
    pub per_revolution: f64,
    /// f_i′, long wave, short wave, by teeth: long are the orders below half of them, short the others within one pitch.
    pub per_tooth: Option<[f64; 3]>,
}

/// Makes the record of `values`, one of every line.
///
/// # Errors
/// More samples than a record holds; those of the evaluation.
pub fn error_record(
    machine: &Machine,
    chain: &TransmissionChain,
    lines: &[OrderLine],
    values: &[Complex],
    period: Option<&Fraction>,
    study: &TransmissionStudy,
) -> Result<TransmissionErrorRecord, Error> {
    let drawn = draw_phases(machine, lines, values);
    let turns_itself = machine.dofs[chain.ends.output].axis.is_rotation();
    let teeth = study
        .teeth
        .or_else(|| output_teeth(machine, chain).filter(|_| turns_itself));
    // Tooth by tooth: 8 samples of a cycle, 20 of a tooth.
    let by_teeth = 2.5 * f64::from(teeth.unwrap_or(0));
    let fastest = lines
        .iter()
        .fold(by_teeth.max(1.0), |m, line| m.max(line.order.to_f64()));
    let (turns, closed) = record::record_revolutions(study.window_revs, period, fastest)?;
    let added: Vec<(f64, Complex)> = lines
        .iter()
        .zip(&drawn)
        .map(|(line, z)| (line.order.to_f64(), *z))
        .collect();
    let made = record::synthesise(&added, turns, fastest, closed);
    // Crests stand between the samples of a record: ranges are read from finer ones.
    let finer = (MAX_SAMPLES / made.values.len().max(1)).clamp(1, OVERSAMPLING) as f64 * fastest;
    let fine = match finer > fastest {
        true => record::synthesise(&added, turns, finer, closed).values,
        false => made.values.clone(),
    };
    let record = SingleFlankRecord::new(&fine, turns, teeth.unwrap_or(1) as usize, closed)?;
    let (total, by_turn) = (record.total_deviation(), record.ranges_per_rev().sliding);
    let by_pitch = teeth.map(|_| record.ranges_per_pitch().sliding);
    let by_tooth = match (by_pitch, teeth) {
        (Some(by_pitch), Some(teeth)) => {
            // The lines are known: long are those below half the teeth, exactly, and nothing leaks.
            let is_long = |order: f64| order < 0.5 * f64::from(teeth);
            let long: Vec<(f64, Complex)> =
                added.iter().copied().filter(|l| is_long(l.0)).collect();
            let mut wave = record::synthesise(&long, turns, finer, closed).values;
            let long_range =
                SingleFlankRecord::new(&wave, turns, teeth as usize, closed)?.total_deviation();
            let both = wave.iter_mut().zip(&fine);
            both.for_each(|(long, whole)| *long = whole - *long);
            let short = SingleFlankRecord::new(&wave, turns, teeth as usize, closed)?;
            Some([by_pitch, long_range, short.ranges_per_pitch().sliding])
        }
        _ => None,
    };
    Ok(TransmissionErrorRecord {
        lines: drawn,
        teeth,
        total,
        per_revolution: by_turn,
        per_tooth: by_tooth,
        record: made,
    })
}

/// Values with unknown phases drawn from a fixed seed: harmonics of one error turn together.
fn draw_phases(machine: &Machine, lines: &[OrderLine], values: &[Complex]) -> Vec<Complex> {
    let phases = RankOneLattice::new(machine.errors.len(), 1, 1).point(0, 0);
    let turned = |(line, value): (&OrderLine, &Complex)| match line.origin {
        LineOrigin::Declared(number) if !machine.errors[number].phase_known => {
            *value * Complex::cis(TAU * phases[number] * f64::from(line.harmonic))
        }
        _ => *value,
    };
    lines.iter().zip(values).map(turned).collect()
}

/// Teeth of a gear that turns with the output.
fn output_teeth(machine: &Machine, chain: &TransmissionChain) -> Option<u32> {
    let with_output = |dof: usize| chain.ratio(dof).is_some_and(|t| t.abs() == Fraction::one());
    let gears = machine
        .gears
        .iter()
        .filter(|gear| gear.carrier.is_none() && with_output(gear.rotation_dof));
    gears.filter_map(|gear| gear.teeth).max()
}
