//! The library's surface: models, machines, recordings, and what their analyses return by name.

pub mod model;

pub mod builder;

pub mod machine;

pub mod modes;

pub mod response;

pub mod motion;

pub mod transmission;

pub mod recording;
