//! MATLAB files of level 5: elements of tag and data.
//!
//! The MathWorks, MAT-File Format (R2023), chapter 1, “Level 5 MAT-File Format”. The same elements serve answers that
//! are written for MATLAB and recordings that are read from it.

/// Data types, table 1-1.
mod types {
    pub const INT8: u32 = 1;
    pub const UINT8: u32 = 2;
    pub const INT16: u32 = 3;
    pub const UINT16: u32 = 4;
    pub const INT32: u32 = 5;
    pub const UINT32: u32 = 6;
    pub const SINGLE: u32 = 7;
    pub const DOUBLE: u32 = 9;
    pub const INT64: u32 = 12;
    pub const UINT64: u32 = 13;
    pub const MATRIX: u32 = 14;
    pub const COMPRESSED: u32 = 15;
    pub const UTF8: u32 = 16;
    pub const UTF16: u32 = 17;
    pub const UTF32: u32 = 18;
}

/// Array classes, table 1-3, and that of objects of newer classes, which the table leaves out.
mod classes {
    pub const CELL: u32 = 1;
    pub const STRUCT: u32 = 2;
    pub const OBJECT: u32 = 3;
    pub const CHAR: u32 = 4;
    pub const SPARSE: u32 = 5;
    pub const DOUBLE: u32 = 6;
    pub const SINGLE: u32 = 7;
    pub const UINT64: u32 = 15;
    pub const FUNCTION: u32 = 16;
    pub const OPAQUE: u32 = 17;
}

pub mod write;

mod number_format;

mod element;

pub mod read;
