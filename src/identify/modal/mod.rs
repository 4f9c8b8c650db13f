//! Modal analysis of FRFs: poles over rising orders, stabilisation diagram, mode selection, residues.

pub mod measured_frf;

pub mod candidates;

mod lags;

mod nested_cholesky;

pub mod plscf;

pub mod lsce;

pub mod rfp;

pub mod sdof;

pub mod stabilisation;

pub(super) mod clusters;

pub mod selection;

pub mod lsfd;
