//! The house itself: import order of the floors, words, the verification manual.

#[path = "../support/verification.rs"]
mod figures;

mod floors;
mod sources;
mod verification;
mod words;
