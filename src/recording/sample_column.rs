//! Append-only storage of samples: short columns in memory, long ones in an anonymous temporary file.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::mem::{size_of, size_of_val};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::base::code::Code;
use crate::base::error::Error;

/// Number of samples of all columns in memory above which growing columns are written to files: 256 MB.
const MAX_SAMPLES_IN_MEMORY: usize = 32 << 20;

/// Write buffer of a column with a file, samples: 512 kB.
const WRITE_BUFFER_SAMPLES: usize = 64 << 10;

/// Number of samples in memory of all columns of the process.
static SAMPLES_IN_MEMORY: AtomicUsize = AtomicUsize::new(0);

/// Column of samples, appended at the end and read in blocks; several threads may read concurrently.
#[derive(Debug, Default)]
pub struct SampleColumn {
    /// Samples `written..len`; all samples of a column without file.
    memory: Vec<f64>,
    /// Number of samples of this column included in `SAMPLES_IN_MEMORY`.
    counted: usize,
    /// File of the first `written` samples; `None` while all samples are in memory.
    file: Option<Mutex<File>>,
    written: usize,
}

impl SampleColumn {
    /// Column with the samples of a slice.
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
            let is_over_limit = SAMPLES_IN_MEMORY.load(Ordering::Relaxed) > MAX_SAMPLES_IN_MEMORY;
            if !is_over_limit || self.memory.len() < WRITE_BUFFER_SAMPLES {
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

    /// True if the column has no sample.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Fills `block` with the samples from `start` on.
    ///
    /// # Errors
    /// The temporary file cannot be read, or the block reaches beyond the end.
    pub fn read(&self, start: usize, block: &mut [f64]) -> Result<(), Error> {
        let n_from_file = self.written.saturating_sub(start).min(block.len());
        let (from_file, from_memory) = block.split_at_mut(n_from_file);
        let offset = (start + n_from_file).saturating_sub(self.written);
        let tail = self.memory.get(offset..offset + from_memory.len());
        from_memory.copy_from_slice(tail.ok_or_else(|| io_error("read", &out_of_bounds_error()))?);
        match &self.file {
            Some(file) if n_from_file > 0 => {
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
            let n_on_disk = len - len % WRITE_BUFFER_SAMPLES;
            let mut tail = vec![0.0; len - n_on_disk];
            self.read(n_on_disk, &mut tail)?;
            (self.written, self.memory) = (n_on_disk, tail);
        } else {
            self.memory.truncate(len - self.written);
        }
        Ok(())
    }

    /// Updates the contribution of this column to `SAMPLES_IN_MEMORY`.
    fn update_memory_count(&mut self) {
        SAMPLES_IN_MEMORY.fetch_add(self.memory.len(), Ordering::Relaxed);
        SAMPLES_IN_MEMORY.fetch_sub(self.counted, Ordering::Relaxed);
        self.counted = self.memory.len();
    }

    /// Moves the samples in memory to the end of the file.
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
    /// POSIX errno of too many open files: of the process (EMFILE), of the system (ENFILE).
    const TOO_MANY_OPEN: [i32; 2] = [24, 23];
    let folder = std::env::temp_dir();
    let is_file_limit = why
        .raw_os_error()
        .is_some_and(|n| TOO_MANY_OPEN.contains(&n));
    let hint = match cfg!(unix) && is_file_limit {
        true => "raise the limit of open files, one per channel of a long log (ulimit -n 4096), or choose fewer channels".to_string(),
        false => format!(
            "free space in {}, or set TMPDIR to a folder with space",
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

    /// Samples are read back unchanged from file, memory and across their boundary, by several threads.
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
                        let is_equal = |(i, x): (usize, &f64)| *x == (start + i) as f64;
                        assert!(block.iter().enumerate().all(is_equal));
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
