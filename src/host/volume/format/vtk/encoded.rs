//! Base64 arrays: counts, then data.

use super::blocks::number;
use crate::error::Error;
use crate::memory;
use crate::volume::Endian;
use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// Some writers pad incorrectly, so padding is not checked.
pub(crate) const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent).with_decode_allow_trailing_bits(true),
);

/// Location of a base64 array.
pub(super) struct Coded<'a> {
    pub path: &'a Path,
    /// Its first byte in the file, or white space before it.
    pub at: u64,
    /// Bytes per count.
    pub count: usize,
    pub endian: Endian,
}

/// Number of base64 characters for `bytes` bytes, including padding.
fn characters(bytes: u64) -> u64 {
    bytes.div_ceil(3).saturating_mul(4)
}

impl Coded<'_> {
    /// Declared size and data of an uncompressed array.
    pub fn plain(&self) -> Result<(u64, Vec<u8>), Error> {
        let count = self.count as u64;
        let start = self.decoded(0, characters(count))?;
        let declared = number(start.get(..self.count).unwrap_or_default(), self.endian);
        let mut all = self.decoded(0, characters(declared.saturating_add(count)))?;
        all.drain(..self.count.min(all.len()));
        all.truncate(usize::try_from(declared).unwrap_or(usize::MAX));
        Ok((declared, all))
    }

    /// Table and blocks of a compressed array.
    pub fn blocks(&self) -> Result<Vec<u8>, Error> {
        let count = self.count as u64;
        let start = self.decoded(0, characters(3 * count))?;
        let blocks = number(start.get(..self.count).unwrap_or_default(), self.endian);
        let table = blocks.saturating_add(3).saturating_mul(count);
        let mut all = self.decoded(0, characters(table))?;
        let sizes = all.get(3 * self.count..).unwrap_or_default().chunks_exact(self.count);
        let packed = sizes.map(|size| number(size, self.endian)).fold(0, u64::saturating_add);
        all.extend(self.decoded(characters(table), characters(packed))?);
        Ok(all)
    }

    /// Decodes `take` characters after `skip` characters, ignoring white space.
    fn decoded(&self, skip: u64, take: u64) -> Result<Vec<u8>, Error> {
        let failed = |e| Error::read(self.path, e);
        let mut file = File::open(self.path).map_err(failed)?;
        let len = file.metadata().map_err(failed)?.len();
        if take > len {
            let problem = format!("{take} characters of base64 are declared, but it has {len} bytes: it is truncated or damaged");
            return Err(Error::volume(self.path, problem));
        }
        memory::require(&self.path.display().to_string(), take.saturating_mul(2))?;
        file.seek(SeekFrom::Start(self.at)).map_err(failed)?;
        let mut found = Vec::new();
        let letters = BufReader::new(file).bytes().filter(|byte| byte.as_ref().map_or(true, |byte| !byte.is_ascii_whitespace()));
        let skip = usize::try_from(skip).unwrap_or(usize::MAX);
        for byte in letters.skip(skip).take(usize::try_from(take).unwrap_or(usize::MAX)) {
            match byte.map_err(failed)? {
                b'<' => break,
                byte => found.push(byte),
            }
        }
        BASE64.decode(&found).map_err(|e| Error::volume(self.path, format!("its base64 is damaged: {e}")))
    }
}
