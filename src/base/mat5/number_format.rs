//! Number formats of MATLAB level-5 files, decoded to `f64`.

use super::types;

/// Which end of a number comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ByteOrder {
    Little,
    Big,
}

impl ByteOrder {
    pub fn u16(self, bytes: [u8; 2]) -> u16 {
        match self {
            ByteOrder::Little => u16::from_le_bytes(bytes),
            ByteOrder::Big => u16::from_be_bytes(bytes),
        }
    }

    pub fn u32(self, bytes: [u8; 4]) -> u32 {
        match self {
            ByteOrder::Little => u32::from_le_bytes(bytes),
            ByteOrder::Big => u32::from_be_bytes(bytes),
        }
    }

    fn u64(self, bytes: [u8; 8]) -> u64 {
        match self {
            ByteOrder::Little => u64::from_le_bytes(bytes),
            ByteOrder::Big => u64::from_be_bytes(bytes),
        }
    }
}

/// Storage format of numbers.
pub(super) struct NumberFormat {
    kind: u32,
    order: ByteOrder,
}

impl NumberFormat {
    /// Those of a data type; `None` where it does not hold numbers.
    pub fn from_type(kind: u32, order: ByteOrder) -> Option<NumberFormat> {
        let numbers = matches!(
            kind,
            types::INT8..=types::SINGLE | types::DOUBLE | types::INT64 | types::UINT64
        );
        numbers.then_some(NumberFormat { kind, order })
    }

    /// Bytes of a number.
    pub fn width(&self) -> usize {
        match self.kind {
            types::INT8 | types::UINT8 => 1,
            types::INT16 | types::UINT16 => 2,
            types::INT32 | types::UINT32 | types::SINGLE => 4,
            _ => 8,
        }
    }

    /// The numbers; integers beyond 2⁵³ are rounded.
    pub fn decode(&self, data: &[u8]) -> Vec<f64> {
        let order = self.order;
        let bytes = || data.iter();
        let halves = || data.as_chunks::<2>().0.iter().map(|&b| order.u16(b));
        let words = || data.as_chunks::<4>().0.iter().map(|&b| order.u32(b));
        let longs = || data.as_chunks::<8>().0.iter().map(|&b| order.u64(b));
        match self.kind {
            types::INT8 => bytes().map(|&b| f64::from(b as i8)).collect(),
            types::UINT8 => bytes().map(|&b| f64::from(b)).collect(),
            types::INT16 => halves().map(|h| f64::from(h as i16)).collect(),
            types::UINT16 => halves().map(f64::from).collect(),
            types::INT32 => words().map(|w| f64::from(w as i32)).collect(),
            types::UINT32 => words().map(f64::from).collect(),
            types::SINGLE => words().map(|w| f64::from(f32::from_bits(w))).collect(),
            types::INT64 => longs().map(|l| l as i64 as f64).collect(),
            types::UINT64 => longs().map(|l| l as f64).collect(),
            _ => longs().map(f64::from_bits).collect(),
        }
    }
}
