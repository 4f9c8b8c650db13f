//! Motion between switches, exactly: every regime of a machine is linear, and its motion a sum of exponentials.

/// The functions φ.
pub mod phi;

/// Instants to twice the digits.
pub mod instant;

/// What is known in time.
pub mod inputs;

/// When what is known jumps.
pub mod clock;

/// Coordinates of unit inertia, and modes in them.
pub mod frame;

/// From modal states to parts and back.
pub mod stage;

/// Machines by matrix exponentials.
pub mod dense;

/// Parts in closed form.
pub mod spectrum;

/// What borders are read by.
pub mod sensor;

/// Their motion in time.
pub mod course;

/// Round strides, kept.
pub mod ladder;

/// A regime over its modes.
pub mod equations;

/// Modes that do not act on each other.
pub mod apart;

/// Damped roots from undamped modes.
pub mod light;

/// Modes that do.
pub mod mixed;

/// Branches in a regime.
pub mod law;

/// What regimes share.
pub mod shared;

/// Pairs that stick.
pub mod hold;

/// Borders of a regime.
pub mod border;

/// What regimes share that differ by constants.
pub mod linear;

/// Inputs while their lines last.
pub mod load;

/// The machine of a regime.
pub mod machine;

/// Its motion from a state.
pub mod flight;

/// The next switch.
pub mod search;

/// The regimes met so far.
pub mod met;

/// From switch to switch.
pub mod journey;
