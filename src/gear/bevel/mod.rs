//! Bevel and hypoid flanks from the settings of the generator that cuts them.

pub mod frames;

pub mod cutter;

pub mod settings;

pub mod tooth_section;

pub mod blank_fault;

pub mod blank;

pub mod cone_gap;

pub mod rough_settings;

pub mod pitch_point;

pub mod face_hob;

pub mod pitch_cones;

pub mod flank_theory;

pub mod iso23509;

pub mod edge_radii;

pub mod slots;

pub mod virtual_gears;

pub mod flank;

pub mod straight;

pub mod flank_grid;

pub mod zero_curves;

pub mod flank_lines;

pub mod structure_elements;

pub mod tooth;

pub mod solid;
