//! Character encoding of a text log, detected from the first bytes.

use std::io::{self, Read};

use encoding_rs::{CoderResult, Decoder, Encoding, GBK, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252};

use crate::base::code::Code;
use crate::base::error::Error;

/// Character encoding of a file.
#[derive(Debug, Clone, Copy)]
pub struct TextEncoding {
    encoding: &'static Encoding,
    /// Bytes of the byte-order mark.
    pub mark: usize,
}

impl TextEncoding {
    /// The encoding of a file from its first bytes, or the one of a label such as `latin1`.
    ///
    /// # Errors
    /// The label is not one of the encoding standard.
    pub fn detect(head: &[u8], label: Option<&str>) -> Result<TextEncoding, Error> {
        let marked = Encoding::for_bom(head);
        let mark = marked.map_or(0, |(_, length)| length);
        let encoding = match label {
            Some(label) => {
                Encoding::for_label(label.as_bytes()).ok_or_else(|| unknown_label(label))?
            }
            None => marked.map_or_else(|| guess_encoding(head), |(encoding, _)| encoding),
        };
        Ok(TextEncoding { encoding, mark })
    }

    /// Two bytes a character, so that the numbers too must be decoded.
    pub fn is_utf16(&self) -> bool {
        self.encoding == UTF_16LE || self.encoding == UTF_16BE
    }

    /// Display name, if not plain ASCII.
    pub fn name(&self, head: &[u8]) -> Option<&'static str> {
        match self.encoding {
            e if e == WINDOWS_1252 => Some("Latin-1"),
            e if e == UTF_8 && self.mark > 0 => Some("UTF-8 with byte-order mark"),
            e if e == UTF_8 => (!head.is_ascii()).then_some("UTF-8"),
            other => Some(other.name()),
        }
    }

    /// Name in the encoding standard, which [`TextEncoding::detect`] takes.
    pub fn label(&self) -> &'static str {
        self.encoding.name()
    }

    /// Bytes as text; what cannot be decoded becomes `�`.
    pub fn text(&self, bytes: &[u8]) -> String {
        let encoding = if self.is_utf16() {
            UTF_8
        } else {
            self.encoding
        };
        encoding.decode_without_bom_handling(bytes).0.into_owned()
    }

    /// The file as UTF-8 from here on, byte-order mark taken off.
    pub fn to_utf8<'r>(self, reader: impl Read + 'r) -> Box<dyn Read + 'r> {
        Box::new(Transcoder {
            reader,
            decoder: self.encoding.new_decoder_with_bom_removal(),
            raw: vec![0; CHUNK],
            waiting: 0..0,
            text: vec![0; 4 * CHUNK],
            ready: 0..0,
            ended: false,
            done: false,
        })
    }
}

/// Bytes decoded at a time.
const CHUNK: usize = 64 << 10;

/// The encoding of bytes without a mark.
fn guess_encoding(head: &[u8]) -> &'static Encoding {
    let zeros = |odd: usize| {
        head.iter()
            .skip(odd)
            .step_by(2)
            .filter(|&&b| b == 0)
            .count()
    };
    let (high_first, low_first) = (zeros(0), zeros(1));
    // ASCII in UTF-16 has a zero in every pair; two thirds leave room for names in other scripts.
    let enough = head.len() / 3;
    if head.len() >= 8 && low_first >= enough && high_first == 0 {
        return UTF_16LE;
    }
    if head.len() >= 8 && high_first >= enough && low_first == 0 {
        return UTF_16BE;
    }
    match std::str::from_utf8(head) {
        Ok(_) => UTF_8,
        // A character cut in two by the end of the head.
        Err(e) if e.error_len().is_none() => UTF_8,
        Err(_) if looks_chinese(head) => GBK,
        Err(_) => WINDOWS_1252,
    }
}

/// High bytes come in pairs, predominantly pairs of common Chinese characters (leads B0 to D7 of GB 2312) or full-width signs.
fn looks_chinese(head: &[u8]) -> bool {
    let (mut pairs, mut common) = (0, 0);
    for run in head.split(|b| *b < 0x80).filter(|run| !run.is_empty()) {
        if run.len() % 2 != 0 {
            return false;
        }
        for pair in run.chunks_exact(2) {
            pairs += 1;
            let lead = (0xB0..=0xD7).contains(&pair[0]) || (0xA1..=0xA9).contains(&pair[0]);
            common += usize::from(lead && pair[1] >= 0xA1);
        }
    }
    2 * common > pairs
}

fn unknown_label(label: &str) -> Error {
    Error::new(Code::Usage, format!("`{label}` is not a known encoding"))
        .with_hint("labels are those of the web, such as utf-8, latin1, gbk, utf-16le, shift_jis")
}

/// A reader of any encoding, as UTF-8.
struct Transcoder<R> {
    reader: R,
    decoder: Decoder,
    raw: Vec<u8>,
    /// Bytes of `raw` not decoded yet.
    waiting: std::ops::Range<usize>,
    text: Vec<u8>,
    /// Bytes of `text` not handed out yet.
    ready: std::ops::Range<usize>,
    ended: bool,
    done: bool,
}

impl<R: Read> Read for Transcoder<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        while self.ready.is_empty() {
            if self.done || out.is_empty() {
                return Ok(0);
            }
            if self.waiting.is_empty() && !self.ended {
                let n = self.reader.read(&mut self.raw)?;
                self.waiting = 0..n;
                self.ended = n == 0;
            }
            let source = &self.raw[self.waiting.clone()];
            let (result, read, written, _) =
                self.decoder
                    .decode_to_utf8(source, &mut self.text, self.ended);
            self.waiting.start += read;
            self.ready = 0..written;
            self.done = self.ended && result == CoderResult::InputEmpty;
        }
        let n = out.len().min(self.ready.len());
        out[..n].copy_from_slice(&self.text[self.ready.start..self.ready.start + n]);
        self.ready.start += n;
        Ok(n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name_of(bytes: &[u8]) -> Option<&'static str> {
        TextEncoding::detect(bytes, None).unwrap().name(bytes)
    }

    /// The encodings labs write, distinguished by a few names.
    #[test]
    fn exact_encodings_are_told_apart() {
        assert_eq!(name_of(b"time,a\n1,2\n"), None);
        assert_eq!(name_of("Größe [m/s²]".as_bytes()), Some("UTF-8"));
        assert_eq!(name_of(b"Gr\xf6\xdfe [\xb5m]"), Some("Latin-1"));
        assert_eq!(name_of(b"Temp \xb0C;a [m/s\xb2]"), Some("Latin-1"));
        let chinese = GBK.encode("时间,加速度").0.into_owned();
        assert_eq!(name_of(&chinese), Some("GBK"));
        let wide: Vec<u8> = "t,a\n1,2\n"
            .encode_utf16()
            .flat_map(u16::to_le_bytes)
            .collect();
        let coding = TextEncoding::detect(&wide, None).unwrap();
        assert!(coding.is_utf16());
        let mut text = String::new();
        coding.to_utf8(&wide[..]).read_to_string(&mut text).unwrap();
        assert_eq!(text, "t,a\n1,2\n");
    }
}
