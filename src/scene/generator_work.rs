//! `[work]` of a generator: the gear file of what it cuts, and the nodes of its chain that are cradle and work.

use std::path::Path;
use std::sync::Arc;

use super::bevel_file;
use super::model::GeneratorWork;
use super::shared_keys;
use crate::base::flags::Flags;
use crate::base::load;
use crate::base::table_reader::TableReader;

/// Reads the table; the path of `gear` starts at the folder of the file that has it.
pub fn read(f: &mut TableReader) -> Option<Arc<GeneratorWork>> {
    let cradle = shared_keys::read_node(f, "cradle");
    let work = shared_keys::read_node(f, "work");
    let cutter = f.has("cutter").then(|| shared_keys::read_node(f, "cutter"));
    let member = f.choice("member", &[("pinion", 0), ("gear", 1)]);
    f.require("member");
    f.require("gear");
    let named = f.optional_text("gear")?;
    let span = f.span_of("gear").clone();
    let folder = Path::new(&span.source().path).parent();
    let path = folder.unwrap_or(Path::new("")).join(named);
    let source = match load::load(&path) {
        Ok(source) => source,
        Err(error) => {
            f.push(
                error.with_hint("the path is relative to the folder of the file with [work]"),
                &span,
            );
            return None;
        }
    };
    let bevel = match bevel_file::read(&source, &Flags::default()) {
        Ok(bevel) => bevel,
        Err(errors) => {
            let each = errors.as_slice().iter().cloned();
            each.for_each(|error| f.errors.push(error.with_label("gear file of [work]")));
            return None;
        }
    };
    Some(Arc::new(GeneratorWork {
        bevel,
        member: member?,
        cradle,
        work,
        cutter,
        span,
    }))
}
