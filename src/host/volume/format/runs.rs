//! Run lengths of bytes, which DICOM and TIFF (PackBits) share.

/// Passes decoded bytes to `take` until it returns false.
pub(super) fn unpack(mut runs: &[u8], mut take: impl FnMut(u8) -> bool) {
    while let [count, rest @ ..] = runs {
        let count = *count as i8;
        let (used, repeat) = match count {
            0.. => (count as usize + 1, 1),
            i8::MIN => (0, 0),
            _ => (1, 1 - isize::from(count)),
        };
        let used = used.min(rest.len());
        for &value in &rest[..used] {
            if !(0..repeat).all(|_| take(value)) {
                return;
            }
        }
        runs = &rest[used..];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_and_literals_are_unpacked() {
        let mut found = Vec::new();
        unpack(&[2, 1, 2, 3, 0xfe, 9, 0x80, 0, 7], |value| {
            found.push(value);
            true
        });
        assert_eq!(found, [1, 2, 3, 9, 9, 9, 7]);
    }
}
