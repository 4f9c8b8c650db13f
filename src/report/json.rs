//! Parts of JSON documents: units in the names, complex numbers as `{re, im}`, nonexistent values as null. See docs/json.md.

use std::sync::Arc;

use serde_json::{Value, json};

use crate::base::error::Diagnostic;
use crate::base::source_span::SourceFile;
use crate::numeric::Complex;

/// Warnings as a list.
pub fn warnings(list: &[Diagnostic]) -> Value {
    list.iter()
        .map(|w| json!({ "code": w.code, "message": w.message, "hint": w.hint }))
        .collect()
}

/// `{re, im}`.
pub fn complex(z: Complex) -> Value {
    json!({ "re": z.re, "im": z.im })
}

/// FNV-1a, 64 bits (Fowler, Noll & Vo), of every text read: the same input has the same hash on every machine.
pub fn hash(sources: &[Arc<SourceFile>]) -> String {
    let bytes = sources.iter().flat_map(|source| source.text.bytes());
    let hash = bytes.fold(0xcbf2_9ce4_8422_2325_u64, |h, b| {
        (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3)
    });
    format!("{hash:016x}")
}
