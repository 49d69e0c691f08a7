//! Adds a description of the colours to an H.264 video. Without it, players have to guess, and results differ.

/// Type of the unit with the parameters of a sequence (SPS).
const SEQUENCE_PARAMETERS: u8 = 7;
/// The bits of the usability information (ITU-T H.264, annex E): present, with only sRGB's primaries (1) and transfer (13) and the matrix
/// of ITU-R BT.601 (6), in limited range, like the encoder's pictures.
const DESCRIPTION: &str = "1 001 101 0 1 00000001 00001101 00000110 000000";

/// Adds the description to the sequence parameters in an access unit (with start codes). A unit without them is unchanged.
pub(super) fn add_to(unit: Vec<u8>) -> Vec<u8> {
    let begins = |at: usize| unit[at..].starts_with(&[0, 0, 1]);
    let is_it = |&at: &usize| begins(at) && unit.get(at + 3).is_some_and(|header| header & 31 == SEQUENCE_PARAMETERS);
    let Some(start) = (0..unit.len()).find(is_it) else { return unit };
    let start = start + 3;
    let next = (start..unit.len()).find(|&at| begins(at)).unwrap_or(unit.len());
    // Zeros before a start code belong to the start code.
    let end = (start..next).rev().find(|&at| unit[at] != 0).map_or(start, |last| last + 1);
    let Some(parameters) = described(&unit[start..end]) else { return unit };
    [&unit[..start], &parameters, &unit[end..]].concat()
}

/// Returns sequence parameters with the description. `rusty_h264` writes no usability information: its parameters end with a bit that says
/// so, and the bit that ends all parameters.
fn described(parameters: &[u8]) -> Option<Vec<u8>> {
    let mut bits: Vec<bool> =
        parameters.iter().flat_map(|byte| (0..8).rev().map(move |bit| (byte >> bit) & 1 == 1)).collect();
    let end = bits.iter().rposition(|bit| *bit)?.checked_sub(1).filter(|end| !bits[*end])?;
    bits.truncate(end);
    bits.extend(DESCRIPTION.bytes().filter(|letter| *letter != b' ').map(|letter| letter == b'1').chain([true]));
    let byte =
        |bits: &[bool]| bits.iter().enumerate().fold(0, |byte, (index, &bit)| byte | u8::from(bit) << (7 - index));
    Some(bits.chunks(8).map(byte).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Converts a text of bits to bytes.
    fn bytes(bits: &str) -> Vec<u8> {
        let mut bits: String = bits.chars().filter(|letter| *letter != ' ').collect();
        while !bits.len().is_multiple_of(8) {
            bits.push('0');
        }
        (0..bits.len() / 8).map(|index| u8::from_str_radix(&bits[8 * index..8 * index + 8], 2).unwrap()).collect()
    }

    #[test]
    fn parameters_are_described_and_nothing_else_changes() {
        // High profile, level 3.1; 83 x 34 macroblocks, with 8 columns and 4 rows of samples cropped.
        let sequence = "01100111 01100100 01000000 00011111 1 010 1 1 0 0 1 1 00101 00100 0 0000001010011 00000100010 1 1 1 \
                        1 00101 1 011";
        let unit =
            |end: &str| [&[0, 0, 0, 1][..], &bytes(&format!("{sequence}{end}")), &[0, 0, 0, 1, 0x68, 5]].concat();
        let described = add_to(unit("0 1"));
        assert_eq!(described, unit("1 0 0 1 101 0 1 00000001 00001101 00000110 0 0 0 0 0 0 1"));
        // A unit without parameters is unchanged.
        let slice = vec![0, 0, 0, 1, 0x41, 7, 0, 0, 3];
        assert_eq!(add_to(slice.clone()), slice);
    }
}
