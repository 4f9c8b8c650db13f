//! Plane meshing: from a ratio law to centrodes, from a profile on one body to the conjugate profile on the other.
//!
//! Data flow: `RatioLaw` or `PitchCurve` → `Centrodes` → `Rolling` (tool and work, by
//! arc) → with a `Profile` on the tool → `ConjugateProfile`, a list of `Contact`s with path, sliding
//! and curvature, itself a profile again → `limits`, `second_contact`, `law_of_gearing`; outlines by `rack_cut`.

pub mod pitch_curve;

mod curve_law;

pub mod ratio_law;

pub mod centrodes;

pub mod convexity;

pub mod rolling;

pub mod profile;

pub mod contact;

mod contact_arcs;

pub mod conjugate;

pub mod line_of_action;

pub mod envelope;

pub mod limits;

pub mod second_contact;

pub mod law_of_gearing;

pub mod conjugate_flank;

pub mod given_profiles;

pub mod rack_cutter;

pub mod rack_flank;

mod tooth_space;

pub mod rack_cut;

pub mod rack_remedy;
