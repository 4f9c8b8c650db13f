//! Tooth stiffness.
