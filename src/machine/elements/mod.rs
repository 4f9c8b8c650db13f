//! Machine elements, one file each: equation, signs, limits.

pub mod body;

pub mod shaft;

pub mod chain;

pub mod mesh;

pub mod friction;

pub mod gear_pair;

pub mod worm_pair;

pub mod planetary;

pub mod belt;

pub mod screw;

pub mod coupling;

pub mod bearing;

pub mod damper;

pub mod geometric_error;
