//! Archives of arrays. An uncompressed member is mapped like a separate file.

use super::array;
use crate::error::Error;
use crate::volume::format::bytes::{Bytes, Deflate, Packed, Plain};
use crate::volume::format::load::Opened;
use crate::volume::format::{Format, Found, OpenOptions, choice};
use std::fs::File;
use std::io::BufReader;
use zip::{CompressionMethod, ZipArchive};

/// NumPy archive.
pub(in crate::volume::format) struct Npz;

impl Format for Npz {
    fn recognises(&self, file: &Found, _options: &OpenOptions) -> bool {
        file.start.starts_with(b"PK\x03\x04") && (file.ends_with(&[".npz"]) || file.start.windows(4).any(|name| name == b".npy"))
    }

    fn chooses(&self) -> &'static [&'static str] {
        &["array"]
    }

    fn open(&self, file: &Found, options: &OpenOptions) -> Result<Opened, Error> {
        let path = file.path;
        let failed = |e| Error::read(path, e);
        let damaged = |e: zip::result::ZipError| Error::volume(path, format!("the archive is truncated or damaged: {e}"));
        let open = || File::open(path).map_err(failed);
        let mut archive = ZipArchive::new(BufReader::new(open()?)).map_err(damaged)?;
        let mut members = Vec::new();
        for index in 0..archive.len() {
            let member = archive.by_index_raw(index).map_err(damaged)?;
            let name = member.name().map_err(damaged)?.into_owned();
            members.extend(name.strip_suffix(".npy").map(|name| (index, name.to_owned())));
        }
        let names: Vec<&str> = members.iter().map(|(_, name)| name.as_str()).collect();
        let first = names.first().ok_or_else(|| Error::volume(path, "it has no arrays"))?;
        let chosen = choice::named(path, options.array.as_deref(), &names, first)?.unwrap_or(0);
        let member = archive.by_index_raw(members[chosen].0).map_err(damaged)?;
        let start = member.data_start().filter(|_| !member.encrypted());
        let start =
            start.ok_or_else(|| Error::volume(path, "its array is encrypted or unreadable: write it without a password"))?;
        let bytes: Box<dyn Bytes> = match member.compression() {
            CompressionMethod::Stored => Box::new(Plain::part(open()?, start, member.compressed_size()).map_err(failed)?),
            CompressionMethod::Deflated => Box::new(Packed::<Deflate>::new(path, start, 0).map_err(failed)?),
            other => {
                return Err(Error::volume(
                    path,
                    format!(
                        "its array is compressed with {other}: write it with \
                                                             savez_compressed"
                    ),
                ));
            }
        };
        array(path, bytes, options)
    }
}
