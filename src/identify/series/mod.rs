//! Polynomial models fitted to samples: `A(q) y = B(q)/F(q) u + C(q) e` (Ljung §4.2, §10.2).
//!
//! Ljung, System Identification: Theory for the User, 2nd ed. (1999), §4.2 for the families, §10.2 for their fit.

pub mod io_data;

mod filter;

pub mod model;

pub mod autoregressive;

pub mod prediction_error;

pub mod order;

pub mod residuals;

pub mod recursive;

pub mod model_trajectory;
