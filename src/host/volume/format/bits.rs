//! Numbers of fewer bits than a byte, or of some more.

/// Numbers of `bits` bits, up to 16, as little-endian numbers of `size` bytes. The highest bit of each comes first.
pub(super) fn spread(row: &[u8], bits: usize, size: usize) -> Vec<u8> {
    let mut numbers = Vec::new();
    let bit = |at: usize| u16::from(row[at / 8] >> (7 - at % 8) & 1);
    for n in 0..8 * row.len() / bits {
        let number = (n * bits..(n + 1) * bits).fold(0u16, |number, at| number << 1 | bit(at));
        numbers.extend_from_slice(&number.to_le_bytes()[..size]);
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_numbers() {
        assert_eq!(spread(&[0b1010_0000], 1, 1), [1, 0, 1, 0, 0, 0, 0, 0]);
        assert_eq!(spread(&[0xab, 0xcd], 4, 1), [0xa, 0xb, 0xc, 0xd]);
        assert_eq!(spread(&[0xab, 0xcd, 0xef], 12, 2), [0xbc, 0x0a, 0xef, 0x0d]);
    }
}
