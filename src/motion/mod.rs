//! Integration in time: machines in motion, and plain first-order problems.

/// Harmonics that begin and end.
pub mod burst;

/// Known functions of time.
pub mod signal;

/// Products of them.
pub mod product;

/// Periodic functions of a phase.
pub mod wave;

/// Contacts with play.
pub mod contact;

/// Dry friction.
pub mod friction;

/// Torque over speed.
pub mod curve;

/// Dry friction pressed by forces of the machine.
pub mod rubbing;

/// How everything that switches stands.
pub mod regime;

/// What methods take and give.
pub mod problem;

/// A machine in motion.
pub mod train;

/// Coordinates without inertia that stay.
pub mod light;

/// What presses friction pairs at a state.
pub mod pressing;

/// Forces of branches.
pub mod forces;

/// The equations of motion.
pub mod equations;

/// How a state makes everything stand.
pub mod standing;

/// What follows from coordinates.
pub mod combination;

/// Motions known in time, taken out of the equations.
pub mod prescribed;

/// How far a run has come.
pub mod progress;

/// Which branch is nearest to trouble.
pub mod trouble;

/// Exact motion from switch to switch.
pub mod segment;

/// The size of every state.
pub mod scale;

/// Steps with the motion inside each.
pub mod stepper;

/// Linear systems of implicit methods.
pub mod pencil;

/// The first crossing of zero inside a step.
pub mod bernstein;

/// Where a regime ends.
pub mod borders;

/// First roots of polynomials, none skipped.
pub mod bracket;

/// From regime to regime.
pub mod events;

/// Taylor series of what is known and of the motion it makes.
pub mod series;

/// The methods, one file each.
pub mod methods;

/// Parametric stability, periodic orbits.
pub mod floquet;

/// Sensitivity to the start.
pub mod sensitivity;

/// What of a state is wanted.
pub mod outputs;

/// What is stored, put in and lost at an instant.
pub mod energy;

/// The energy balance of a run.
pub mod meter;

/// Cutting torque.
mod cutting;

/// Functions of time alone.
mod known;

/// What meets at a coordinate without inertia, and what stands for it.
mod star;

/// Coordinates without inertia, taken out of the equations.
pub mod massless;

/// A machine in motion and the way back to what it was made from.
pub mod moving;

/// From a machine to a machine in motion.
pub mod assemble;

/// The state a scene starts from.
pub mod start;
