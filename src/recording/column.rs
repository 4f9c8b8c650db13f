//! A long sequence of samples in bounded memory: in memory while it is short, beyond that in a temporary file without a name.

use crate::base::error::Error;

/// Samples, appended at the end and read in blocks.
#[derive(Debug, Default)]
pub struct Column {
    memory: Vec<f64>,
}

impl Column {
    /// The samples of a slice.
    pub fn from_slice(samples: &[f64]) -> Column {
        Column {
            memory: samples.to_vec(),
        }
    }

    /// Appends samples.
    ///
    /// # Errors
    /// The temporary file cannot be written.
    pub fn push(&mut self, samples: &[f64]) -> Result<(), Error> {
        self.memory.extend_from_slice(samples);
        Ok(())
    }

    /// How many samples.
    pub fn len(&self) -> usize {
        self.memory.len()
    }

    /// No sample.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Fills `block` with the samples from `start` on.
    ///
    /// # Errors
    /// The temporary file cannot be read.
    ///
    /// # Panics
    /// A block that reaches beyond the end.
    pub fn read(&self, start: usize, block: &mut [f64]) -> Result<(), Error> {
        block.copy_from_slice(&self.memory[start..start + block.len()]);
        Ok(())
    }
}
