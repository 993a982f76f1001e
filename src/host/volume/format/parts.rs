//! Data that are decoded in parts: a page, a slice, or several layers.

use super::bytes::Bytes;
use std::io;

/// Voxel data that are decoded part by part.
pub(super) trait Parts {
    /// Upper bound of the number of bytes, determined without reading them.
    fn most(&self) -> u64;

    /// Bytes of all parts.
    fn whole(&self) -> u64;

    /// Bytes per part; the last one may be shorter.
    fn each(&self) -> u64;

    /// Decodes part `index`.
    fn part(&mut self, index: usize) -> io::Result<Vec<u8>>;
}

/// Caches the most recently decoded part.
pub(super) struct Kept<P> {
    parts: P,
    current: Option<(usize, Vec<u8>)>,
}

impl<P: Parts> Kept<P> {
    pub fn new(parts: P) -> Self {
        Self { parts, current: None }
    }

    fn part(&mut self, index: usize) -> io::Result<&[u8]> {
        let bytes = match self.current.take().filter(|(current, _)| *current == index) {
            Some((_, bytes)) => bytes,
            None => self.parts.part(index)?,
        };
        Ok(&self.current.insert((index, bytes)).1)
    }
}

impl<P: Parts> Bytes for Kept<P> {
    #[cfg(feature = "mpi")]
    fn reads_anywhere(&self) -> bool {
        true
    }

    fn most(&self) -> u64 {
        self.parts.most()
    }

    fn read(&mut self, at: u64, bytes: &mut [u8]) -> io::Result<usize> {
        let (each, whole) = (self.parts.each(), self.parts.whole());
        let mut found = 0;
        while found < bytes.len() && at + (found as u64) < whole {
            let at = at + found as u64;
            let part = self.part((at / each) as usize)?;
            let rest = part.get((at % each) as usize..).unwrap_or(&[]);
            let more = rest.len().min(bytes.len() - found);
            if more == 0 {
                break;
            }
            bytes[found..found + more].copy_from_slice(&rest[..more]);
            found += more;
        }
        Ok(found)
    }

    fn ends_at(&mut self, end: u64) -> io::Result<bool> {
        Ok(end == self.parts.whole())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers 0 to 9 in parts of four; counts the parts that are decoded.
    struct Ten(usize);

    impl Parts for Ten {
        fn most(&self) -> u64 {
            10
        }

        fn whole(&self) -> u64 {
            10
        }

        fn each(&self) -> u64 {
            4
        }

        fn part(&mut self, index: usize) -> io::Result<Vec<u8>> {
            self.0 += 1;
            Ok((4 * index as u8..10).take(4).collect())
        }
    }

    #[test]
    fn bytes_are_found_across_parts_and_none_behind_the_last() {
        let mut kept = Kept::new(Ten(0));
        let mut bytes = [0; 6];
        assert_eq!(kept.read(3, &mut bytes).unwrap(), 6);
        assert_eq!(bytes, [3, 4, 5, 6, 7, 8]);
        assert_eq!(kept.parts.0, 3);
        assert_eq!((kept.read(8, &mut bytes).unwrap(), &bytes[..2]), (2, &[8, 9][..]));
        assert_eq!(kept.parts.0, 3, "the last part was read twice");
        assert_eq!(kept.read(10, &mut bytes).unwrap(), 0);
        assert!(kept.ends_at(10).unwrap() && !kept.ends_at(9).unwrap());
    }
}
