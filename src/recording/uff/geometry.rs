//! Geometry of a UFF file: data sets 15 and 2411 (nodes), 82 (trace lines).
//!
//! Structural Dynamics Research Corporation, “Universal File Datasets Summary”: data set 15, format 4I10, 1P3E13.5; 2411, 4I10 and
//! 1P3D25.16; 82, 3I10, 80A1 and 8I10, where node 0 lifts the pen.

use std::collections::HashMap;

use super::cursor::{UffCursor, is_delimiter};
use super::header::DofLabel;
use crate::base::error::{Diagnostic, Error};
use crate::recording::geometry::{ChannelPlace, Geometry, GeometryPoint};
use crate::recording::raw::RawLog;

/// Data sets that hold geometry.
pub(super) const DATA_SETS: [i64; 3] = [15, 82, 2411];

/// Largest number of a coordinate system that is the global one.
const GLOBAL_SYSTEM: i64 = 1;

/// Nodes and trace lines read so far.
#[derive(Default)]
pub(super) struct UffGeometry {
    nodes: Vec<Node>,
    /// Nodes of each line, with the line of the file that begins it.
    traces: Vec<(usize, Vec<i64>)>,
}

struct Node {
    label: i64,
    /// Coordinate systems of its coordinates and of its motion.
    systems: [i64; 2],
    /// In the length unit of the file.
    at: [f64; 3],
}

impl UffGeometry {
    /// Reads a data set from the line after its number to its closing mark.
    pub fn read(
        &mut self,
        number: i64,
        first_line: usize,
        cursor: &mut UffCursor<'_>,
    ) -> Result<(), Error> {
        while !is_delimiter(cursor.peek()) {
            if cursor.rest.is_empty() {
                let message =
                    format!("the data set {number} at line {first_line} has no end mark -1");
                return Err(cursor
                    .error_here(message)
                    .with_hint("the file was cut off: copy it again"));
            }
            if cursor.peek().is_empty() {
                cursor.next_line();
                continue;
            }
            match number {
                15 => self.read_node(cursor, 7)?,
                2411 => self.read_node(cursor, 4)?,
                _ => self.read_traces(cursor)?,
            }
        }
        cursor.next_line();
        Ok(())
    }

    /// A node: `n_first` numbers on its first line, the others on the next.
    fn read_node(&mut self, cursor: &mut UffCursor<'_>, n_first: usize) -> Result<(), Error> {
        let mut numbers = numbers(cursor, n_first)?;
        if n_first < 7 {
            numbers.extend(self::numbers(cursor, 7 - n_first)?);
        }
        let node = Node {
            label: numbers[0] as i64,
            systems: [numbers[1] as i64, numbers[2] as i64],
            at: [numbers[4], numbers[5], numbers[6]],
        };
        // A later definition replaces an earlier one.
        match self.nodes.iter_mut().find(|n| n.label == node.label) {
            Some(known) => *known = node,
            None => self.nodes.push(node),
        }
        Ok(())
    }

    fn read_traces(&mut self, cursor: &mut UffCursor<'_>) -> Result<(), Error> {
        let at = cursor.line;
        let count = numbers(cursor, 3)?[1].max(0.0) as usize;
        cursor.next_line();
        let mut trace = Vec::new();
        while trace.len() < count {
            let in_row = (count - trace.len()).min(8);
            trace.extend(numbers(cursor, in_row)?.into_iter().map(|x| x as i64));
        }
        let runs = trace.split(|node| *node == 0).filter(|run| run.len() > 1);
        self.traces.extend(runs.map(|run| (at, run.to_vec())));
        Ok(())
    }

    /// Puts the geometry into the log: points named by the numbers of their nodes, in m, and channels at known nodes.
    ///
    /// # Errors
    /// `broken-file` with the line of a trace line through a node that is not there.
    pub fn finish(
        self,
        length_unit: f64,
        channels: Vec<(String, DofLabel)>,
        log: &mut RawLog,
    ) -> Result<(), Error> {
        let index: HashMap<i64, usize> = (self.nodes.iter().enumerate())
            .map(|(k, node)| (node.label, k))
            .collect();
        let mut lines = Vec::new();
        for (line, trace) in self.traces {
            let missing = trace.iter().find(|node| !index.contains_key(node));
            if let Some(node) = missing {
                let message = format!(
                    "a trace line refers to node {node}, which is in no data set 15 or 2411"
                );
                return Err(UffCursor::new(&log.path, b"")
                    .error(line, "", message)
                    .with_hint("export the nodes as well"));
            }
            lines.push(trace.iter().map(|node| index[node]).collect());
        }
        let is_local = |system: &i64| *system > GLOBAL_SYSTEM;
        if let Some(node) = self.nodes.iter().find(|n| n.systems.iter().any(is_local)) {
            log.diagnostics.push(Diagnostic {
                code: "local-axes",
                message: format!(
                    "node {} lies or moves in coordinate system {}, which is not read; its numbers are taken as global and Cartesian",
                    node.label,
                    node.systems.iter().max().unwrap_or(&0)
                ),
                hint: Some("export nodes and measurements in the global Cartesian system".into()),
            });
        }
        let place = |(channel, dof): (String, DofLabel)| {
            Some(ChannelPlace {
                channel,
                point: Some(*index.get(&dof.node)?),
                direction: axis(dof.direction)?,
            })
        };
        log.geometry = Geometry {
            channels: channels.into_iter().filter_map(place).collect(),
            points: (self.nodes.iter())
                .map(|node| GeometryPoint {
                    name: node.label.to_string(),
                    at: node.at.map(|x| x * length_unit),
                })
                .collect(),
            lines,
        };
        Ok(())
    }
}

/// The unit vector of a direction code from ±1 (x) to ±3 (z); `None` of a scalar or a rotation.
fn axis(code: i64) -> Option<[f64; 3]> {
    let at = usize::try_from(code.abs() - 1).ok().filter(|at| *at < 3)?;
    let sign = code.signum() as f64;
    Some(std::array::from_fn(|k| if k == at { sign } else { 0.0 }))
}

/// So many numbers of the next line; an exponent may begin with `D`.
fn numbers(cursor: &mut UffCursor<'_>, count: usize) -> Result<Vec<f64>, Error> {
    let text = String::from_utf8_lossy(cursor.peek()).replace(['D', 'd'], "E");
    let all: Option<Vec<f64>> = (text.split_whitespace())
        .take(count)
        .map(|field| field.parse().ok().filter(|x: &f64| x.is_finite()))
        .collect();
    match all.filter(|all| all.len() == count) {
        Some(all) => {
            cursor.next_line();
            Ok(all)
        }
        None => {
            Err(cursor.error_here(format!("{count} numbers of the geometry are required here")))
        }
    }
}
