//! Append-only storage of samples: in memory while short, then spilled to an anonymous temporary file.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::mem::{size_of, size_of_val};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::base::code::Code;
use crate::base::error::Error;

/// Samples held in memory by all columns together before the longest-growing ones move to files: 256 MB.
const MAX_SAMPLES_IN_MEMORY: usize = 32 << 20;

/// Samples of a column in a file that wait in memory to be written together: 512 kB.
const WRITE_BUFFER_SAMPLES: usize = 64 << 10;

/// Samples in the memory of all columns of the process.
static SAMPLES_IN_MEMORY: AtomicUsize = AtomicUsize::new(0);

/// Samples, appended at the end and read in blocks. Several threads may read at once.
#[derive(Debug, Default)]
pub struct SampleColumn {
    /// Samples `written..len`; all of them while there is no file.
    memory: Vec<f64>,
    /// Part of `memory` that is counted in `SAMPLES_IN_MEMORY`.
    counted: usize,
    /// The first `written` samples, once there were too many for memory.
    file: Option<Mutex<File>>,
    written: usize,
}

impl SampleColumn {
    /// The samples of a slice.
    pub fn from_slice(samples: &[f64]) -> SampleColumn {
        let mut column = SampleColumn::default();
        column.memory.extend_from_slice(samples);
        column.update_memory_count();
        column
    }

    /// Appends samples.
    ///
    /// # Errors
    /// The temporary file cannot be written.
    pub fn push(&mut self, samples: &[f64]) -> Result<(), Error> {
        self.memory.extend_from_slice(samples);
        if self.file.is_none() {
            self.update_memory_count();
            let crowded = SAMPLES_IN_MEMORY.load(Ordering::Relaxed) > MAX_SAMPLES_IN_MEMORY;
            if !crowded || self.memory.len() < WRITE_BUFFER_SAMPLES {
                return Ok(());
            }
        }
        if self.memory.len() >= WRITE_BUFFER_SAMPLES {
            self.spill().map_err(|e| io_error("written", &e))?;
        }
        Ok(())
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.written + self.memory.len()
    }

    /// No sample.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Fills `block` with the samples from `start` on.
    ///
    /// # Errors
    /// The temporary file cannot be read, or the block reaches beyond the end.
    pub fn read(&self, start: usize, block: &mut [f64]) -> Result<(), Error> {
        let filed = self.written.saturating_sub(start).min(block.len());
        let (from_file, from_memory) = block.split_at_mut(filed);
        let held = (start + filed).saturating_sub(self.written);
        let held = self.memory.get(held..held + from_memory.len());
        from_memory.copy_from_slice(held.ok_or_else(|| io_error("read", &out_of_bounds_error()))?);
        match &self.file {
            Some(file) if filed > 0 => {
                read_from_file(file, start, from_file).map_err(|e| io_error("read", &e))
            }
            _ => Ok(()),
        }
    }

    /// Drops the samples from `len` on.
    ///
    /// # Errors
    /// The temporary file cannot be read.
    pub fn truncate(&mut self, len: usize) -> Result<(), Error> {
        if len < self.written {
            let kept = len - len % WRITE_BUFFER_SAMPLES;
            let mut tail = vec![0.0; len - kept];
            self.read(kept, &mut tail)?;
            (self.written, self.memory) = (kept, tail);
        } else {
            self.memory.truncate(len - self.written);
        }
        Ok(())
    }

    /// Brings what is counted of this column up to date.
    fn update_memory_count(&mut self) {
        SAMPLES_IN_MEMORY.fetch_add(self.memory.len(), Ordering::Relaxed);
        SAMPLES_IN_MEMORY.fetch_sub(self.counted, Ordering::Relaxed);
        self.counted = self.memory.len();
    }

    /// Moves what is in memory to the end of the file.
    fn spill(&mut self) -> io::Result<()> {
        let file = match &mut self.file {
            Some(file) => file,
            none => none.insert(Mutex::new(tempfile::tempfile()?)),
        };
        let file = file.get_mut().unwrap_or_else(PoisonError::into_inner);
        file.seek(SeekFrom::Start(position(self.written)))?;
        let mut bytes = Vec::with_capacity(WRITE_BUFFER_SAMPLES * size_of::<f64>());
        for part in self.memory.chunks(WRITE_BUFFER_SAMPLES) {
            bytes.clear();
            bytes.extend(part.iter().flat_map(|x| x.to_le_bytes()));
            file.write_all(&bytes)?;
        }
        self.written += self.memory.len();
        self.memory.clear();
        self.memory.shrink_to(WRITE_BUFFER_SAMPLES);
        self.update_memory_count();
        Ok(())
    }
}

impl Drop for SampleColumn {
    fn drop(&mut self) {
        SAMPLES_IN_MEMORY.fetch_sub(self.counted, Ordering::Relaxed);
    }
}

/// Byte offset of sample `index` in the file.
fn position(index: usize) -> u64 {
    index as u64 * size_of::<f64>() as u64
}

/// Reads samples of the file from `start` on.
fn read_from_file(file: &Mutex<File>, start: usize, block: &mut [f64]) -> io::Result<()> {
    let mut bytes = vec![0; size_of_val(block)];
    {
        let mut file = file.lock().unwrap_or_else(PoisonError::into_inner);
        file.seek(SeekFrom::Start(position(start)))?;
        file.read_exact(&mut bytes)?;
    }
    for (sample, bytes) in block.iter_mut().zip(bytes.chunks_exact(size_of::<f64>())) {
        *sample = bytes.try_into().map_or(f64::NAN, f64::from_le_bytes);
    }
    Ok(())
}

fn out_of_bounds_error() -> io::Error {
    io::Error::new(io::ErrorKind::UnexpectedEof, "beyond the last sample")
}

fn io_error(done: &str, why: &io::Error) -> Error {
    /// Too many open files, of the process and of the system (errno of POSIX systems).
    const TOO_MANY_OPEN: [i32; 2] = [24, 23];
    let folder = std::env::temp_dir();
    let is_crowded = why
        .raw_os_error()
        .is_some_and(|n| TOO_MANY_OPEN.contains(&n));
    let hint = match cfg!(unix) && is_crowded {
        true => "every channel of a long log takes one open file: raise their limit (ulimit -n 4096), or take fewer channels".to_string(),
        false => format!(
            "make room in {}, or set TMPDIR to a folder with room",
            folder.display()
        ),
    };
    Error::new(
        Code::OutputFailed,
        format!("samples cannot be {done} in a temporary file: {why}"),
    )
    .with_hint(hint)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples come back from file and memory alike, over the seam and from several threads.
    #[test]
    fn exact_samples_come_back_from_the_file() {
        let mut column = SampleColumn::default();
        let n = 3 * WRITE_BUFFER_SAMPLES + 17;
        for first in (0..n).step_by(1000) {
            let part: Vec<f64> = (first..n.min(first + 1000)).map(|i| i as f64).collect();
            column.push(&part).unwrap();
            if first == 100_000 {
                column.spill().unwrap();
            }
        }
        assert!(column.file.is_some());
        assert_eq!(column.len(), n);
        std::thread::scope(|scope| {
            for offset in 0..4 {
                let column = &column;
                scope.spawn(move || {
                    let mut block = vec![0.0; 777];
                    for start in (offset..n - 777).step_by(5003) {
                        column.read(start, &mut block).unwrap();
                        let right = |(i, x): (usize, &f64)| *x == (start + i) as f64;
                        assert!(block.iter().enumerate().all(right));
                    }
                });
            }
        });
        let mut tail = [0.0; 2];
        column.read(n - 2, &mut tail).unwrap();
        assert_eq!(tail, [(n - 2) as f64, (n - 1) as f64]);
        assert!(column.read(n - 1, &mut tail).is_err());
        column.truncate(WRITE_BUFFER_SAMPLES + 5).unwrap();
        assert_eq!(column.len(), WRITE_BUFFER_SAMPLES + 5);
        column.push(&[-1.0]).unwrap();
        column.read(WRITE_BUFFER_SAMPLES + 4, &mut tail).unwrap();
        assert_eq!(tail, [(WRITE_BUFFER_SAMPLES + 4) as f64, -1.0]);
    }
}
