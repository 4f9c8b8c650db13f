//! Unloaded contact of two flanks: point, ellipse, path, hand-over, transmission error.

pub mod pair;

pub mod contact_point;

pub mod ellipse;

pub mod contact_path;

pub mod ease_off;

pub mod reference;

pub mod ridge;

pub mod overlap;

pub mod backlash;
