//! MATLAB files of level 5: elements of tag and data.
//!
//! The MathWorks, MAT-File Format (R2023), chapter 1, “Level 5 MAT-File Format”. The same elements serve answers that
//! are written for MATLAB and recordings that are read from it.

/// Data types, table 1-1.
mod types {
    pub const INT8: u32 = 1;
    pub const UINT16: u32 = 4;
    pub const INT32: u32 = 5;
    pub const UINT32: u32 = 6;
    pub const DOUBLE: u32 = 9;
    pub const MATRIX: u32 = 14;
}

/// Array classes, table 1-3.
mod classes {
    pub const CELL: u32 = 1;
    pub const CHAR: u32 = 4;
    pub const DOUBLE: u32 = 6;
}

/// Arrays to bytes: little-endian, uncompressed.
pub mod write;
