//! Amounts of memory as people write them.

/// Bytes of `2G`, `500M`, `64K` or `1000000`: powers of 1024.
///
/// # Errors
/// That it is no such number above 0.
pub fn parse_bytes(text: &str) -> Result<u64, String> {
    let trimmed = text.trim().trim_end_matches(['B', 'b']).trim_end_matches('i');
    let (number, shift) = match trimmed.char_indices().next_back() {
        Some((at, 'K' | 'k')) => (&trimmed[..at], 10),
        Some((at, 'M' | 'm')) => (&trimmed[..at], 20),
        Some((at, 'G' | 'g')) => (&trimmed[..at], 30),
        Some((at, 'T' | 't')) => (&trimmed[..at], 40),
        _ => (trimmed, 0),
    };
    let bytes =
        number.trim().parse::<f64>().ok().map(|number| number * f64::from(1u32 << (shift / 2)).powi(2));
    match bytes {
        Some(bytes) if (1.0..=1e18).contains(&bytes) => Ok(bytes as u64),
        _ => Err(format!("`{text}` is no amount of memory; write 2G, 500M or a number of bytes")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_have_units_of_1024() {
        let amounts = [
            ("2G", 2 << 30),
            ("1.5 KiB", 1536),
            ("500M", 500 << 20),
            ("7", 7),
            ("1tb", 1 << 40),
            ("3k", 3072),
        ];
        for (text, bytes) in amounts {
            assert_eq!(parse_bytes(text), Ok(bytes), "{text}");
        }
        for wrong in ["", "G", "-1G", "0", "2X", "nan", "1e300"] {
            assert!(parse_bytes(wrong).is_err(), "{wrong}");
        }
    }
}
