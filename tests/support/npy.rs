//! Numbers out of a numpy file of pickled arrays, as far as a test needs them: every array's bytes, in order.

/// Little-endian doubles of every array in a pickle of protocol 2, where bytes stand as Latin-1 text in UTF-8 after `X` and a length.
pub fn arrays(file: &[u8], fewest: usize) -> Vec<Vec<f64>> {
    let mut found = Vec::new();
    let mut at = 0;
    while at + 5 <= file.len() {
        let length =
            u32::from_le_bytes([file[at + 1], file[at + 2], file[at + 3], file[at + 4]]) as usize;
        let end = at + 5 + length;
        let is_array = file[at] == b'X' && length >= 8 * fewest && end <= file.len();
        match is_array.then(|| std::str::from_utf8(&file[at + 5..end])) {
            Some(Ok(text)) => {
                let bytes: Vec<u8> = text.chars().map(|c| c as u8).collect();
                let numbers = bytes.chunks_exact(8);
                found.push(
                    numbers
                        .map(|b| {
                            f64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]])
                        })
                        .collect(),
                );
                at = end;
            }
            _ => at += 1,
        }
    }
    found
}
