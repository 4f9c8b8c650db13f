//! Frames of a generator, from the cutter to the work.

/// Cutter: z along its axis out of the tips, tip plane z = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutterFrame;

/// Machine: z along the cradle's axis towards the work, machine plane z = 0, x towards the heel in the plane of the cradle's and the work's axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MachineFrame;

/// Work: z along its axis from apex to heel, the design apex at the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorkFrame;
