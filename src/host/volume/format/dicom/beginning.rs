//! The beginning of a file: where its elements are, and how they are encoded. Many files lack the preamble, the file meta information or the
//! transfer syntax, or state another encoding than they have.

use dicom_core::dictionary::DataDictionary;
use dicom_core::{Tag, VR};
use dicom_dictionary_std::StandardDataDictionary;
use std::io::{self, Read, Seek, SeekFrom};

/// Bytes before the magic number.
const PREAMBLE: usize = 128;
const MARK: &[u8] = b"DICM";
/// Elements that tell an encoding. Files begin with short ones.
const TELLING: usize = 3;
/// Bytes in which these are looked for.
pub(super) const START: usize = 512;
/// Length of a sequence that a delimiter ends.
const UNDEFINED: u32 = u32::MAX;

/// Encoding of elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Encoding {
    Explicit,
    Implicit,
    ExplicitBigEndian,
}

impl Encoding {
    const ALL: [Self; 3] = [Self::Explicit, Self::Implicit, Self::ExplicitBigEndian];

    /// UID of the transfer syntax of uncompressed pixels.
    pub fn syntax(self) -> &'static str {
        match self {
            Self::Explicit => "1.2.840.10008.1.2.1",
            Self::Implicit => "1.2.840.10008.1.2",
            Self::ExplicitBigEndian => "1.2.840.10008.1.2.2",
        }
    }

    /// The encoding of a transfer syntax; those of compressed pixels are explicit.
    pub fn of_syntax(syntax: &str) -> Self {
        Self::ALL.into_iter().find(|encoding| encoding.syntax() == syntax).unwrap_or(Self::Explicit)
    }

    fn numbers<const N: usize>(self, mut bytes: [u8; N]) -> [u8; N] {
        if self == Self::ExplicitBigEndian {
            bytes.reverse();
        }
        bytes
    }

    /// The first element of `bytes`: tag, length, and first byte of the value.
    fn element(self, bytes: &[u8]) -> Option<(Tag, u32, usize)> {
        let two = |at: usize| Some(u16::from_le_bytes(self.numbers([*bytes.get(at)?, *bytes.get(at + 1)?])));
        let four = |at: usize| Some(u32::from_le_bytes(self.numbers(<[u8; 4]>::try_from(bytes.get(at..at + 4)?).ok()?)));
        let tag = Tag(two(0)?, two(2)?);
        if self == Self::Implicit {
            return Some((tag, four(4)?, 8));
        }
        let vr = VR::from_binary([*bytes.get(4)?, *bytes.get(5)?])?;
        if has_long_length(vr) {
            return Some((tag, four(8).filter(|_| bytes[6..8] == [0, 0])?, 12));
        }
        Some((tag, two(6)?.into(), 8))
    }

    /// Whether elements of the standard, in ascending order, are enough to tell, or at least `least` of them fill `bytes`.
    fn fits(self, mut bytes: &[u8], least: usize) -> bool {
        let mut before = None;
        for found in 0..TELLING {
            let Some((tag, len, value)) = self.element(bytes) else { return found >= least && bytes.len() < 12 };
            let is_known = tag.0 % 2 == 1 || StandardDataDictionary.by_tag(tag).is_some();
            if !is_known || before.is_some_and(|before| tag <= before) {
                return false;
            }
            before = Some(tag);
            match bytes.get(value..).and_then(|rest| rest.get(len as usize..)) {
                Some(rest) => bytes = rest,
                // A long value, of which the first bytes do not have the end.
                None => return found > 0 && found + 1 >= least && (len == UNDEFINED || len < 1 << 31),
            }
        }
        true
    }

    /// The encoding that elements at the beginning of `bytes` have.
    pub fn of_elements(bytes: &[u8], declared: Option<Self>) -> Option<Self> {
        declared.into_iter().chain(Self::ALL).find(|encoding| encoding.fits(bytes, 1)).or(declared)
    }
}

/// Whether the length of an explicit element has four bytes.
fn has_long_length(vr: VR) -> bool {
    use VR::*;
    matches!(vr, OB | OD | OF | OL | OV | OW | SQ | SV | UC | UN | UR | UT | UV)
}

/// Whether the first bytes of a file are those of a DICOM file.
pub(super) fn is_start(start: &[u8]) -> bool {
    if start.get(PREAMBLE..).is_some_and(|rest| rest.starts_with(MARK)) {
        return true;
    }
    // Behind file meta information, if there is some, comes an identifying group.
    let Ok((_, at)) = meta(&mut io::Cursor::new(start)) else { return false };
    let elements = start.get(at as usize..).unwrap_or_default();
    let least = if at > 0 { 1 } else { TELLING };
    let begins = |encoding: &Encoding| {
        let found = encoding.element(elements).is_some_and(|(tag, ..)| matches!(tag, Tag(8, 0..=0x18)));
        found && encoding.fits(elements, least)
    };
    Encoding::ALL.iter().any(begins)
}

/// Transfer syntax, if the file states one, and the byte at which its elements begin.
pub(super) fn meta(from: &mut (impl Read + Seek)) -> io::Result<(Option<String>, u64)> {
    let mut start = Vec::new();
    from.by_ref().take((PREAMBLE + MARK.len()) as u64).read_to_end(&mut start)?;
    let mut at = [PREAMBLE, 0].into_iter().find(|&at| start.get(at..).is_some_and(|rest| rest.starts_with(MARK)));
    let mut at = at.take().map_or(0, |at| (at + MARK.len()) as u64);
    let mut syntax = None;
    loop {
        let mut head = Vec::new();
        from.seek(SeekFrom::Start(at))?;
        from.by_ref().take(12).read_to_end(&mut head)?;
        // Explicit by the standard; some files are implicit throughout.
        let element = Encoding::Explicit.element(&head).or_else(|| Encoding::Implicit.element(&head));
        let Some((Tag(2, number), len, value)) = element else { return Ok((syntax, at)) };
        at += value as u64;
        if number == 0x10 {
            let mut text = vec![0; len.min(64) as usize];
            from.seek(SeekFrom::Start(at))?;
            from.read_exact(&mut text)?;
            let text = String::from_utf8_lossy(&text).trim_matches(['\0', ' ']).to_owned();
            syntax = Some(text).filter(|text| !text.is_empty());
        }
        at += u64::from(len);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three elements: explicit, implicit and big-endian.
    const EXPLICIT: &[u8] = b"\x08\0\x05\0CS\x04\0abcd\x08\0\x08\0CS\x02\0ef\x08\0\x16\0UI\x02\x001\0";
    const IMPLICIT: &[u8] = b"\x08\0\x05\0\x04\0\0\0abcd\x08\0\x08\0\x02\0\0\0ef\x08\0\x16\0\x02\0\0\x001\0";
    const BIG: &[u8] = b"\0\x08\0\x05CS\0\x04abcd\0\x08\0\x08CS\0\x02ef\0\x08\0\x16UI\0\x021\0";

    #[test]
    fn elements_tell_their_encoding() {
        for (bytes, expected) in
            [(EXPLICIT, Encoding::Explicit), (IMPLICIT, Encoding::Implicit), (BIG, Encoding::ExplicitBigEndian)]
        {
            for declared in Encoding::ALL.map(Some).into_iter().chain([None]) {
                assert_eq!(Encoding::of_elements(bytes, declared), Some(expected), "{declared:?}");
            }
            assert!(is_start(bytes) && is_start(&[MARK, bytes].concat()));
            assert!(!is_start(&bytes[..24]) && !is_start(&bytes[2..]));
        }
        assert_eq!(Encoding::of_elements(&[7; 100], None), None);
        assert_eq!(Encoding::of_elements(&[7; 100], Some(Encoding::Implicit)), Some(Encoding::Implicit));
        // Numbers of a raw file.
        assert!(!is_start(&[8, 0].repeat(256)) && !is_start(&[0; 512]) && !is_start(b""));
    }

    #[test]
    fn the_transfer_syntax_may_be_anywhere_or_missing() {
        let uid = b"\x02\0\x10\0UI\x12\x001.2.840.10008.1.2\0".as_slice();
        let implicit = b"\x02\0\x10\0\x12\0\0\x001.2.840.10008.1.2\0".as_slice();
        let preamble = [[0; PREAMBLE].as_slice(), MARK].concat();
        for before in [&preamble[..], MARK, &[]] {
            for (stated, expected) in [(uid, Some("1.2.840.10008.1.2")), (implicit, Some("1.2.840.10008.1.2")), (&[], None)] {
                let bytes = [before, stated, IMPLICIT].concat();
                let at = bytes.len() - IMPLICIT.len();
                let found = meta(&mut io::Cursor::new(&bytes)).unwrap();
                assert_eq!(found, (expected.map(String::from), at as u64));
            }
        }
    }
}
