//! Execution of one study: plan of stages, each run at most once, with a trace.

pub mod plausible;

pub mod decision;

pub mod gear_limits;

pub mod gear;

pub mod meshes;

pub mod prepared_machine;

pub mod stages;

pub mod linear_stability;

pub mod modes_run;

pub mod motion;

pub mod response;

pub mod transmission;

pub mod logs;

pub mod online;

pub mod simulate;

pub mod measure;
