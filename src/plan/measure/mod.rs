//! Gear inspection: charts read, deviations evaluated, values graded.

pub mod chart_columns;

pub mod grading;

pub mod charts;

mod single_flank;

pub mod run;
