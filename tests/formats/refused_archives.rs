//! Invalid archives of arrays.

use crate::refused::{changed, refused};
use std::io::Write;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// An archive with an array header in a member called `name`, followed by `behind`.
fn archive(name: &str, header: &str, behind: &[u8], method: CompressionMethod) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("archive.npz");
    let mut writer = ZipWriter::new(std::fs::File::create(&path).unwrap());
    writer.start_file(name, SimpleFileOptions::default().compression_method(method)).unwrap();
    let header = format!("{header:<117}\n");
    writer.write_all(&[b"\x93NUMPY\x01\x00\x76\x00", header.as_bytes(), behind].concat()).unwrap();
    writer.finish().unwrap();
    (folder, path)
}

fn of_shape(descr: &str, shape: &str) -> String {
    format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}")
}

#[test]
fn wrong_arrays_are_named() {
    let large = of_shape("|u1", "(1000, 100000, 1000)");
    let cases = [
        ("first.npy", of_shape("|O", "(2, 2, 2)"), "|O"),
        ("first.npy", of_shape("<i2", "(2, 2, 9)"), "truncated or damaged"),
        ("first.npy", large.clone(), "100000000128 bytes"),
        ("first.npy", of_shape("|u1", "(18446744073709551615, 2, 2)"), "archive.npz"),
        ("first.npy", "no dictionary".into(), "archive.npz"),
        ("first.txt", of_shape("|u1", "(2, 2, 2)"), "no arrays"),
    ];
    for (name, header, word) in cases {
        for method in [CompressionMethod::Stored, CompressionMethod::Deflated] {
            let (_folder, path) = archive(name, &header, &[0; 16], method);
            refused(&path, &format!("{method} {header}"), word);
        }
    }
}

/// Data that decompress by a factor of a thousand, while twice as much is declared.
#[test]
fn bombs_are_refused() {
    let (_folder, path) = archive("a.npy", &of_shape("|u1", "(4, 1024, 2048)"), &[0; 4 << 20], CompressionMethod::Deflated);
    refused(&path, "zeros", "truncated or damaged");
}

#[test]
fn archives_that_cannot_be_unpacked_are_refused() {
    /// Sets a byte in the local headers of all members, and one in the central directory.
    fn set(bytes: &mut [u8], [local, central]: [usize; 2], value: u8) {
        for at in 0..bytes.len() - 4 {
            match &bytes[at..at + 4] {
                b"PK\x03\x04" => bytes[at + local] = value,
                b"PK\x01\x02" => bytes[at + central] = value,
                _ => {}
            }
        }
    }
    let (_temporary, path) = changed("numpy/packed.npz", |bytes| set(bytes, [6, 8], 1));
    refused(&path, "with a password", "without a password");
    let (_temporary, path) = changed("numpy/packed.npz", |bytes| set(bytes, [8, 10], 12));
    refused(&path, "packed otherwise", "write it with savez_compressed");
    for length in [10, 60, 300] {
        let (_temporary, path) = changed("numpy/packed.npz", |bytes| bytes.truncate(bytes.len() - length));
        refused(&path, "cut short", "the archive is truncated");
    }
}
