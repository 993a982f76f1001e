//! LZF, the fast compression of h5py: runs of literal bytes, and copies of bytes before them.

use hdf5_reader::error::{Error, Result};

/// Its registered number.
pub(super) const FILTER: u16 = 32_000;

/// Decompresses at most `most` bytes.
pub(super) fn unpack(packed: &[u8], most: usize) -> Result<Vec<u8>> {
    let damaged = || Error::DecompressionError("damaged LZF data".into());
    let mut bytes = packed.iter().copied();
    let mut all: Vec<u8> = Vec::new();
    while let Some(control) = bytes.next() {
        let control = usize::from(control);
        let mut next = || bytes.next().map(usize::from).ok_or_else(damaged);
        let (run, low) = (control >> 5, control & 31);
        if run == 0 {
            for _ in 0..=low {
                all.push(next()? as u8);
            }
        } else {
            let count = if run == 7 { next()? + 9 } else { run + 2 };
            let distance = (low << 8) + next()? + 1;
            let start = all.len().checked_sub(distance).ok_or_else(damaged)?;
            // Copies may reach into what they write.
            (start..start + count).for_each(|at| all.push(all[at]));
        }
        if all.len() > most {
            return Err(Error::DecompressionError(format!("LZF data of more than {most} bytes")));
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_and_copies() {
        // "ab", a copy of 5 from 2 before, a copy of 9 + 3 from 1 before.
        let packed = [1, b'a', b'b', 3 << 5, 1, 7 << 5, 3, 0];
        assert_eq!(unpack(&packed, 19).unwrap(), b"abababaaaaaaaaaaaaa");
        assert!(unpack(&packed, 18).is_err(), "too long");
        for bad in [&packed[..1], &packed[..4], &packed[..7], &[3 << 5, 0]] {
            assert!(unpack(bad, 100).is_err(), "{bad:?}");
        }
    }
}
