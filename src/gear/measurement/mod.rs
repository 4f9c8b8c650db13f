//! Evaluation of gear charts and readings by ISO 1328. Lengths in m, angles in rad.
//!
//! Lengths in m, angles in rad, unless a line says otherwise.

pub mod estimate;

pub mod deviation;

pub mod iso1328;

pub mod limits;

pub mod accuracy_grades;

pub mod pitch;

pub mod runout;

pub mod trace;

pub mod tooth_thickness;

pub mod unloaded_te;
