//! Helicoids and what meshes with them: worm threads, disk tools, worm pairs, crossed helical pairs.
//!
//! A helicoid `z = g(ρ) + p χ` turns about z and advances by its lead parameter p a radian, p > 0 for a right hand. Its flank bounds a
//! thread space whose metal lies at larger z; the normal is `N = −g′ e_ρ − (p/ρ) e_χ + k`. Lengths have the unit of the input.

/// Points of axial profiles.
pub mod profile_point;

/// Wheels of a stated profile and the helicoids that they grind.
pub mod grinding_wheel;

/// Axial profiles of helicoids and their sections.
pub mod axial_profile;

/// Flank types of worms: ZA, ZI, ZN, ZK, ZC.
pub mod worm_thread;

/// Profile of the disk tool that cuts a helicoid.
pub mod disk_tool;

/// Cylindrical worms with their wheels.
pub mod worm_pair;

/// Pairs of involute helical gears on crossed axes.
pub mod crossed_pair;
