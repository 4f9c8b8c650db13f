//! Limits the nesting depth of TOML text before it is parsed recursively.

/// Tables and lists inside each other, and parts of a dotted key; a model needs three.
pub(super) const MAX_DEPTH: usize = 32;

/// Position at which brackets or dotted keys nest deeper than any model needs, found before anything recurses over them.
pub(super) fn find_excess_depth(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let (mut at, mut open, mut dots) = (0, 0_usize, 0);
    // A quote inside a bare word belongs to the word, as in the parser.
    let mut word = false;
    while let Some(&byte) = bytes.get(at) {
        let quoted = matches!(byte, b'"' | b'\'') && !word;
        word = !(quoted || b".=,[]{} \t#\r\n".contains(&byte));
        match byte {
            b'#' => at += line_length(&bytes[at..]),
            _ if quoted => at += string_length(&bytes[at..], byte),
            b'[' | b'{' => (open, dots) = (open + 1, 0),
            b']' | b'}' => (open, dots) = (open.saturating_sub(1), 0),
            b'.' => dots += 1,
            b'\n' | b'=' | b',' => dots = 0,
            _ => {}
        }
        if open > MAX_DEPTH || dots > MAX_DEPTH {
            return Some(at);
        }
        at += 1;
    }
    None
}

/// Bytes up to the last of a line.
fn line_length(bytes: &[u8]) -> usize {
    bytes
        .iter()
        .position(|&b| b == b'\n' || b == b'\r')
        .unwrap_or(bytes.len())
        .saturating_sub(1)
}

/// Bytes up to the closing quote of a text, or up to where it breaks off.
fn string_length(bytes: &[u8], quote: u8) -> usize {
    let long = bytes.starts_with(&[quote; 3]);
    let mut at = if long { 3 } else { 1 };
    while let Some(&byte) = bytes.get(at) {
        let rest = &bytes[at..];
        match byte {
            b'\\' if quote == b'"' && rest.get(1) != Some(&b'\n') => at += 1,
            b'\n' if !long => return at - 1,
            _ if byte == quote && !long => return at,
            _ if long && rest.starts_with(&[quote; 3]) => {
                // Two more quotes may belong to the text.
                let more = rest[3..]
                    .iter()
                    .take(2)
                    .take_while(|&&b| b == quote)
                    .count();
                return at + 2 + more;
            }
            _ => {}
        }
        at += 1;
    }
    bytes.len()
}
