//! The order of attributes in the header of an EXR file.
//!
//! The encoder keeps custom attributes in a hash map whose order differs from run to run, while equal pictures are to
//! give equal bytes. The format leaves the order free and the length of a header does not depend on it, so the
//! attributes are sorted in place once the file is encoded, and every offset in it stays true.

/// Magic number and version, four bytes each.
const PREAMBLE: usize = 8;

/// Sorts the attributes of the one header of an encoded single-part EXR file by name; `None` if it does not parse.
///
/// An attribute is `name NUL type NUL size value`, with a little-endian 32-bit `size`; a lone NUL ends the header.
pub(super) fn sort_attributes(file: &mut [u8]) -> Option<()> {
    let mut attributes = Vec::new();
    let mut end = PREAMBLE;
    while *file.get(end)? != 0 {
        let start = end;
        end += attribute_length(file.get(start..)?)?;
        attributes.push(file.get(start..end)?.to_vec());
    }
    attributes.sort_unstable();
    file.get_mut(PREAMBLE..end)?.copy_from_slice(&attributes.concat());
    Some(())
}

fn attribute_length(bytes: &[u8]) -> Option<usize> {
    let name = text_length(bytes)?;
    let size_at = name + text_length(bytes.get(name..)?)?;
    let size = bytes.get(size_at..size_at + 4)?.try_into().map(u32::from_le_bytes).ok()?;
    (size_at + 4).checked_add(size as usize)
}

/// Length of the leading text with its NUL.
fn text_length(bytes: &[u8]) -> Option<usize> {
    bytes.iter().position(|&byte| byte == 0).map(|nul| nul + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    const Z: &[u8] = b"z\0int\0\x04\0\0\0\0\0\0\0";
    const AB: &[u8] = b"ab\0string\0\x03\0\0\0xyz";
    const A: &[u8] = b"a\0string\0\0\0\0\0";

    #[test]
    fn attributes_are_sorted_by_name_and_the_rest_stays() {
        let mut file = [b"MAGIVERS", Z, AB, A, b"\0z\0a\0"].concat();
        sort_attributes(&mut file).unwrap();
        assert_eq!(file, [b"MAGIVERS", A, AB, Z, b"\0z\0a\0"].concat());
    }

    #[test]
    fn a_header_cut_short_is_refused_untouched() {
        let whole = [b"MAGIVERS", Z, AB, b"\0"].concat();
        for length in 0..whole.len() {
            let mut cut = whole[..length].to_vec();
            assert_eq!(sort_attributes(&mut cut), None, "{length} bytes");
            assert_eq!(cut, whole[..length]);
        }
    }
}
