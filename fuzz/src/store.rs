//! A Zarr store for the inputs. An input is a header, a zero byte, and a chunk.

use crate::opened;
use layersplat::volume::OpenOptions;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// Maximum number of values in an array or a chunk. Missing chunks take the fill value, so that a short header could validly declare as
/// many values as fit in memory.
const MOST: u64 = 1 << 22;
/// The input's chunk under the keys of both versions and both separators. The array has no other chunks.
const PIECES: [&str; 4] = ["0.0.0", "0/0/0", "c/0/0/0", "c.0.0.0"];

/// A folder for an array or an image, with the resolutions of a fixture as subfolders.
pub struct Store {
    folder: PathBuf,
}

impl Default for Store {
    fn default() -> Self {
        Self::new()
    }
}

impl Store {
    pub fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder").keep();
        copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/formats/files/zarr/ome_05.zarr"), &folder);
        for piece in PIECES {
            fs::create_dir_all(folder.join(piece).parent().expect("a folder")).expect("a folder in memory");
        }
        Self { folder }
    }

    /// Opens it as a volume. Returns false if the header declares more than `MOST` values.
    pub fn volume(&self, bytes: &[u8]) -> bool {
        let (header, piece) = bytes.split_at(bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len()));
        let told: Option<Value> = serde_json::from_slice(header).ok();
        if told.as_ref().is_some_and(declares_too_much) {
            return false;
        }
        let third = told.is_some_and(|told| told["zarr_format"] == 3);
        let [name, other] = if third { ["zarr.json", ".zarray"] } else { [".zarray", "zarr.json"] };
        fs::write(self.folder.join(name), header).expect("a file in memory");
        let _ = fs::remove_file(self.folder.join(other));
        for name in PIECES {
            fs::write(self.folder.join(name), piece.get(1..).unwrap_or_default()).expect("a file in memory");
        }
        opened(&self.folder, &OpenOptions::default());
        true
    }
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder in memory");
    for entry in fs::read_dir(from).expect("a fixture") {
        let path = entry.expect("a name").path();
        let to = to.join(path.file_name().expect("a name"));
        if path.is_dir() { copy(&path, &to) } else { fs::copy(&path, &to).map(drop).expect("a copy") }
    }
}

/// Whether any list of positive integers in the header has a product above `MOST`.
fn declares_too_much(told: &Value) -> bool {
    match told {
        Value::Array(all) => {
            let sizes = all.iter().filter_map(Value::as_u64).filter(|&n| n > 0);
            sizes.fold(1u64, u64::saturating_mul) > MOST || all.iter().any(declares_too_much)
        }
        Value::Object(all) => all.values().any(declares_too_much),
        _ => false,
    }
}
