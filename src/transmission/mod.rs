//! Transmission error of a gear chain: quasi-static, under load, dynamic.

pub mod chain;

pub mod order_lines;

pub mod dynamic;

pub mod loaded;

pub mod eccentric_pair;

pub mod range_distribution;

pub mod budget;

pub mod indexing;

pub mod record;

pub mod coincidence;

pub mod speed_map;
