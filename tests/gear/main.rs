//! Gears: the kernel of meshing, plane meshing, cylindrical gears, tooth stiffness and loaded transmission error.

#[path = "../support/verification.rs"]
mod verification;

mod bevel_blank;
mod bevel_extremes;
mod bevel_flank;
mod bevel_undercut;
mod blade_profile;
mod cases;
mod complementarity;
mod contact;
mod correction;
mod cut_blades;
mod cut_chips;
mod cylindrical_laws;
mod cylindrical_outline;
mod cylindrical_pair;
mod cylindrical_reverse;
mod helicoids;
mod hobbing;
mod hypoid_theory;
mod kernel;
mod kernel_bevel;
mod kernel_space;
mod kernel_worm;
mod load_laws;
mod load_mesh;
mod load_planet;
mod load_random;
mod load_space;
mod load_spur;
mod load_stiffness;
mod plane_centrodes;
mod plane_conjugates;
mod plane_outlines;
mod plane_rolling_curves;
mod plane_worm;
mod random_files;
mod rough_settings;
mod straight_bevel;
mod turning_pairs;
mod worm_interference;
