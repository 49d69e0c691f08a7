//! What the colours of a video mean, written into its H.264: players guess otherwise, each in its own way.

/// The type of a unit that holds the parameters of a sequence.
const SEQUENCE_PARAMETERS: u8 = 7;
/// Profiles whose parameters say how the chroma is sampled.
const HIGH_PROFILES: [u32; 4] = [100, 110, 122, 244];
/// That there is usability information (ITU-T H.264, annex E), and in it, of all that it might say: sRGB's primaries (1) and
/// transfer (13) and the matrix of ITU-R BT.601 (6), in limited range, as the encoder's pictures are.
const DESCRIPTION: &str = "1 001 101 0 1 00000001 00001101 00000110 000000";

/// Adds it to the parameters of the sequence, if they are in this access unit (with start codes) and say nothing of it yet.
pub(super) fn add_to(unit: Vec<u8>) -> Vec<u8> {
    let begins = |at: usize| unit[at..].starts_with(&[0, 0, 1]);
    let is_it = |&at: &usize| begins(at) && unit.get(at + 3).is_some_and(|header| header & 31 == SEQUENCE_PARAMETERS);
    let Some(start) = (0..unit.len()).find(is_it) else { return unit };
    let start = start + 3;
    let next = (start..unit.len()).find(|&at| begins(at)).unwrap_or(unit.len());
    // Zeros before a start code belong to that.
    let end = (start..next).rev().find(|&at| unit[at] != 0).map_or(start, |last| last + 1);
    let Some(parameters) = described(&unit[start..end]) else { return unit };
    [&unit[..start], &parameters, &unit[end..]].concat()
}

/// The parameters of a sequence with the description, if they have no usability information.
fn described(parameters: &[u8]) -> Option<Vec<u8>> {
    if parameters.windows(3).any(|bytes| bytes == [0, 0, 3]) {
        // Bytes are inserted that are no parameters; an encoder of pictures of common sizes needs none.
        return None;
    }
    let bits: Vec<bool> =
        parameters.iter().flat_map(|byte| (0..8).rev().map(move |bit| byte >> bit & 1 == 1)).collect();
    let mut reader = Reader { bits: &bits, at: 8 };
    let end = reader.before_usability()?;
    if bits.get(end) != Some(&false) {
        return None;
    }
    let description = DESCRIPTION.bytes().filter(|letter| *letter != b' ').map(|letter| letter == b'1');
    // A bit that is set ends them.
    let all: Vec<bool> = bits[..end].iter().copied().chain(description).chain([true]).collect();
    let byte =
        |bits: &[bool]| bits.iter().enumerate().fold(0, |byte, (index, &bit)| byte | u8::from(bit) << (7 - index));
    Some(all.chunks(8).map(byte).collect())
}

/// Reads parameters bit by bit.
struct Reader<'a> {
    bits: &'a [bool],
    at: usize,
}

impl Reader<'_> {
    /// Reads all up to the bit that says whether there is usability information, and returns where that is (section 7.3.2.1).
    fn before_usability(&mut self) -> Option<usize> {
        let profile = self.fixed(8)?;
        self.fixed(16)?;
        self.number()?;
        if HIGH_PROFILES.contains(&profile) {
            let chroma = self.number()?;
            self.number()?;
            self.number()?;
            self.fixed(1)?;
            // Other samplings, and matrices of the quantiser, which have parameters of their own.
            if chroma == 3 || self.fixed(1)? == 1 {
                return None;
            }
        }
        self.number()?;
        match self.number()? {
            0 => drop(self.number()?),
            1 => return None,
            _ => {}
        }
        self.number()?;
        self.fixed(1)?;
        self.number()?;
        self.number()?;
        let are_frames = self.fixed(1)? == 1;
        self.fixed(if are_frames { 1 } else { 2 })?;
        if self.fixed(1)? == 1 {
            for _edge in 0..4 {
                self.number()?;
            }
        }
        Some(self.at)
    }

    fn fixed(&mut self, count: usize) -> Option<u32> {
        let bits = self.bits.get(self.at..self.at + count)?;
        self.at += count;
        Some(bits.iter().fold(0, |number, &bit| number << 1 | u32::from(bit)))
    }

    /// A number of variable length: as many zeros as it has digits after its first one, which counts from one.
    fn number(&mut self) -> Option<u32> {
        let zeros = self.bits.get(self.at..)?.iter().take_while(|bit| !**bit).count();
        self.at += zeros;
        if zeros > 30 { None } else { self.fixed(zeros + 1).map(|number| number - 1) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes of these bits.
    fn bytes(bits: &str) -> Vec<u8> {
        let mut bits: String = bits.chars().filter(|letter| *letter != ' ').collect();
        while !bits.len().is_multiple_of(8) {
            bits.push('0');
        }
        (0..bits.len() / 8).map(|index| u8::from_str_radix(&bits[8 * index..8 * index + 8], 2).unwrap()).collect()
    }

    #[test]
    fn parameters_are_described_and_nothing_else_changes() {
        // High profile, level 3.1; 83 x 34 macroblocks, of which 8 columns and 4 rows of samples are cut off.
        let sequence = "01100111 01100100 01000000 00011111 1 010 1 1 0 0 1 1 00101 00100 0 0000001010011 00000100010 1 1 1 \
                        1 00101 1 011";
        let unit =
            |end: &str| [&[0, 0, 0, 1][..], &bytes(&format!("{sequence}{end}")), &[0, 0, 0, 1, 0x68, 5]].concat();
        let described = add_to(unit("0 1"));
        assert_eq!(described, unit("1 0 0 1 101 0 1 00000001 00001101 00000110 0 0 0 0 0 0 1"));
        // What is described already stays, and so does what has no parameters.
        assert_eq!(add_to(described.clone()), described);
        let slice = vec![0, 0, 0, 1, 0x41, 7, 0, 0, 3];
        assert_eq!(add_to(slice.clone()), slice);
        // Parameters that break off are left alone.
        let broken = vec![0, 0, 0, 1, 0x67, 0x64, 0x40];
        assert_eq!(add_to(broken.clone()), broken);
    }
}
