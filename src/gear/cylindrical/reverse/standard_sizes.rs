//! Series of tooth sizes, pressure angles and tooth heights that a gear of unknown origin is compared with.

/// The series a candidate's tooth size is from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ToothSize {
    /// Normal module, mm (ISO 54:1996 and older metric series).
    Module(f64),
    /// Normal diametral pitch, 1/in.
    DiametralPitch(f64),
}

impl ToothSize {
    /// Normal module, m.
    pub fn module(self) -> f64 {
        match self {
            ToothSize::Module(millimetres) => 1e-3 * millimetres,
            ToothSize::DiametralPitch(pitch) => 0.0254 / pitch,
        }
    }

    /// Every size of the series.
    pub(super) fn all() -> impl Iterator<Item = ToothSize> {
        let modules = MODULES.iter().map(|m| ToothSize::Module(*m));
        modules.chain(
            DIAMETRAL_PITCHES
                .iter()
                .map(|p| ToothSize::DiametralPitch(*p)),
        )
    }
}

/// Normal modules, mm: both series of ISO 54:1996, smaller ones, and 3.25, 3.75, 6.5 of older series.
const MODULES: &[f64] = &[
    0.1, 0.12, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6, 0.7, 0.75, 0.8, 0.9, 1.0,
    1.125, 1.25, 1.375, 1.5, 1.75, 2.0, 2.25, 2.5, 2.75, 3.0, 3.25, 3.5, 3.75, 4.0, 4.5, 5.0, 5.5,
    6.0, 6.5, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 14.0, 16.0, 18.0, 20.0, 22.0, 25.0, 28.0, 32.0,
    36.0, 40.0, 45.0, 50.0,
];

/// Usual normal diametral pitches, 1/in.
const DIAMETRAL_PITCHES: &[f64] = &[
    0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0, 2.25, 2.5, 2.75, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0,
    10.0, 11.0, 12.0, 14.0, 16.0, 18.0, 20.0, 22.0, 24.0, 26.0, 28.0, 30.0, 32.0, 36.0, 40.0, 48.0,
    64.0, 72.0, 80.0, 96.0, 120.0, 200.0,
];

/// Usual normal pressure angles, deg.
pub(super) const PRESSURE_ANGLES: &[f64] =
    &[14.5, 15.0, 16.0, 17.5, 20.0, 22.5, 25.0, 27.0, 28.0, 30.0];

/// Usual addendum coefficients: stub and full teeth.
pub(super) const ADDENDA: &[f64] = &[0.8, 1.0];

/// Usual dedendum coefficients: stub, 14.5° full depth, full, for shaving or grinding.
pub(super) const DEDENDA: &[f64] = &[1.0, 1.1, 1.157, 1.167, 1.2, 1.25, 1.3, 1.35, 1.4];

/// The value of an interval that comes nearest to one of a rising list, and that one; of several inside, the last.
pub(super) fn nearest(list: &[f64], [least, greatest]: [f64; 2]) -> [f64; 2] {
    let inside = |usual: f64| usual.max(least).min(greatest);
    let distance = |usual: &&f64| (inside(**usual) - **usual).abs();
    let by_distance = |a: &&f64, b: &&f64| distance(a).total_cmp(&distance(b));
    let usual = list.iter().rev().min_by(by_distance);
    usual.map_or([least; 2], |usual| [inside(*usual), *usual])
}
