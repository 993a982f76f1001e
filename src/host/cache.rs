//! Files that are kept from command to command, in the user's cache folder.

use foldhash::quality::FixedState;
use std::env;
use std::fs::{self, DirEntry, File};
use std::hash::{BuildHasher, Hasher};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::SystemTime;

/// Most bytes of files from servers.
const MOST: u64 = 10_000_000_000;
/// All files are counted again when 1/`COUNTED` of their most bytes were written: other processes write, too.
const COUNTED: u64 = 16;
/// Begin of each file; then the checksum of the rest: the length of the key, the key and the content.
const MAGIC: &[u8; 8] = b"lsplat01";
const HEADER: usize = MAGIC.len() + 8;

static IS_OFF: AtomicBool = AtomicBool::new(false);

/// The user's cache folder by the XDG base directory specification, which ignores relative ones, or that of Windows.
pub fn user_folder() -> Option<PathBuf> {
    let set = |name: &str| env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    set("XDG_CACHE_HOME")
        .filter(|folder| folder.is_absolute())
        .or_else(|| set("HOME").map(|home| home.join(".cache")))
        .or_else(|| set("LOCALAPPDATA"))
}

/// Files from servers. `None` if there is no place for them, or after [`turn_off`].
pub fn downloads() -> Option<&'static Cache> {
    static CACHE: LazyLock<Option<Cache>> = LazyLock::new(|| Some(Cache::new(user_folder()?.join("layersplat/downloads"), MOST)));
    if IS_OFF.load(Ordering::Relaxed) { None } else { CACHE.as_ref() }
}

/// From now on, this process neither reads nor keeps files from servers.
pub fn turn_off() {
    IS_OFF.store(true, Ordering::Relaxed);
}

/// Contents by their keys, in files that only this user can read. Any number of processes may use it at once.
pub struct Cache {
    folder: PathBuf,
    most: u64,
    /// Bytes written since all files were counted.
    written: AtomicU64,
}

/// What a cache holds.
#[derive(Clone, Copy, Default, PartialEq, Eq, Debug)]
pub struct Size {
    /// Number of files.
    pub files: u64,
    /// Number of their bytes.
    pub bytes: u64,
}

impl Cache {
    /// A cache of at most so many bytes. Its folder is made when something is written.
    pub fn new(folder: PathBuf, most: u64) -> Self {
        Self { folder, most, written: AtomicU64::new(u64::MAX / 2) }
    }

    /// Its folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Most bytes that it keeps. Processes that write at once may exceed it by a sixteenth each.
    pub fn most(&self) -> u64 {
        self.most
    }

    /// The content that was written with this key; `None` if there is none, or it is damaged.
    pub fn read(&self, key: &str) -> Option<Vec<u8>> {
        let path = self.file(key);
        let mut all = fs::read(&path).ok()?;
        let (start, rest) = all.split_at_checked(HEADER)?;
        let (len, rest_of_it) = rest.split_first_chunk()?;
        let is_of_key = rest_of_it.get(..u32::from_le_bytes(*len) as usize) == Some(key.as_bytes());
        if !start.starts_with(MAGIC) || start[MAGIC.len()..] != checksum(rest) || !is_of_key {
            return None;
        }
        // What was used last is removed last.
        let _ = File::open(&path).and_then(|file| file.set_modified(SystemTime::now()));
        all.drain(..HEADER + 4 + key.len());
        Some(all)
    }

    /// Keeps a content, which replaces that of the same key. Others see all of it or nothing.
    ///
    /// # Errors
    /// If the folder is not this user's alone, or cannot be written.
    pub fn write(&self, key: &str, content: &[&[u8]]) -> io::Result<()> {
        let len: usize = content.iter().map(|part| part.len()).sum();
        if len as u64 > self.most / COUNTED {
            return Ok(());
        }
        self.make_folder()?;
        let key_len = (key.len() as u32).to_le_bytes();
        let rest = [&[&key_len[..], key.as_bytes()], content].concat().concat();
        let mut file = tempfile::NamedTempFile::new_in(&self.folder)?;
        file.write_all(MAGIC)?;
        file.write_all(&checksum(&rest))?;
        file.write_all(&rest)?;
        file.persist(self.file(key)).map_err(|e| e.error)?;
        let len = (HEADER + rest.len()) as u64;
        if self.written.fetch_add(len, Ordering::Relaxed) > self.most / COUNTED {
            self.written.store(0, Ordering::Relaxed);
            self.remove_oldest()?;
        }
        Ok(())
    }

    /// What it holds.
    ///
    /// # Errors
    /// If the folder cannot be read.
    pub fn size(&self) -> io::Result<Size> {
        let files = self.files()?;
        Ok(Size { files: files.len() as u64, bytes: files.iter().map(|(_, len, _)| len).sum() })
    }

    /// Removes all that it holds.
    ///
    /// # Errors
    /// If a file cannot be removed.
    pub fn clear(&self) -> io::Result<Size> {
        let mut removed = Size::default();
        for (_, len, path) in self.files()? {
            removed.bytes += remove(&path)? * len;
            removed.files += 1;
        }
        Ok(removed)
    }

    fn file(&self, key: &str) -> PathBuf {
        let hash = u64::from_le_bytes(checksum(key.as_bytes()));
        self.folder.join(format!("{hash:016x}"))
    }

    /// Time of last use, bytes and path of each file.
    fn files(&self) -> io::Result<Vec<(SystemTime, u64, PathBuf)>> {
        let entries = match fs::read_dir(&self.folder) {
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            entries => entries?,
        };
        let stated = |entry: DirEntry| {
            let metadata = entry.metadata().ok().filter(fs::Metadata::is_file)?;
            Some((metadata.modified().ok()?, metadata.len(), entry.path()))
        };
        Ok(entries.flatten().filter_map(stated).collect())
    }

    /// Removes what was not used for the longest time, if there is too much. So go files that killed processes did not complete.
    fn remove_oldest(&self) -> io::Result<()> {
        let mut files = self.files()?;
        let mut bytes: u64 = files.iter().map(|(_, len, _)| len).sum();
        if bytes <= self.most {
            return Ok(());
        }
        files.sort();
        for (_, len, path) in files {
            if bytes <= self.most - self.most / COUNTED {
                break;
            }
            remove(&path)?;
            bytes -= len;
        }
        Ok(())
    }

    /// Makes the folder, which other users can neither read nor write.
    fn make_folder(&self) -> io::Result<()> {
        #[cfg(unix)]
        {
            use std::os::unix::fs::{DirBuilderExt, PermissionsExt};
            const OWNER_ALONE: u32 = 0o700;
            fs::DirBuilder::new().recursive(true).mode(OWNER_ALONE).create(&self.folder)?;
            if fs::metadata(&self.folder)?.permissions().mode() & 0o077 != 0 {
                // Only its owner can do so.
                fs::set_permissions(&self.folder, fs::Permissions::from_mode(OWNER_ALONE))?;
            }
            Ok(())
        }
        #[cfg(not(unix))]
        fs::create_dir_all(&self.folder)
    }
}

/// Removes a file, which another process may have done. Returns 1 if it was there.
fn remove(path: &Path) -> io::Result<u64> {
    match fs::remove_file(path) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(0),
        removed => removed.map(|()| 1),
    }
}

/// Files of which the last bytes are missing after a power cut do not have it.
fn checksum(bytes: &[u8]) -> [u8; 8] {
    let mut hasher = FixedState::with_seed(0).build_hasher();
    hasher.write(bytes);
    hasher.finish().to_le_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cache(most: u64) -> (tempfile::TempDir, Cache) {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::new(folder.path().join("a/b"), most);
        (folder, cache)
    }

    #[test]
    fn contents_come_back_whole_or_not_at_all() {
        let (_folder, cache) = cache(1 << 20);
        assert_eq!((cache.read("x"), cache.size().unwrap(), cache.clear().unwrap()), (None, Size::default(), Size::default()));
        cache.write("x", &[b"one", b"two"]).unwrap();
        cache.write("y", &[b""]).unwrap();
        assert_eq!((cache.read("x").unwrap(), cache.read("y").unwrap(), cache.read("z")), (b"onetwo".to_vec(), vec![], None));
        cache.write("x", &[b"three"]).unwrap();
        assert_eq!(cache.read("x").unwrap(), b"three");
        // Any change of any byte, or a file that ends too early, is no content.
        let whole = fs::read(cache.file("x")).unwrap();
        for n in 0..whole.len() {
            fs::write(cache.file("x"), &whole[..n]).unwrap();
            assert_eq!(cache.read("x"), None, "{n}");
            let mut changed = whole.clone();
            changed[n] ^= 16;
            fs::write(cache.file("x"), &changed).unwrap();
            assert_eq!(cache.read("x"), None, "{n}");
        }
        // Nor is that of another key.
        fs::rename(cache.file("y"), cache.file("x")).unwrap();
        assert_eq!(cache.read("x"), None);
        assert_eq!(cache.clear().unwrap().files, 1);
    }

    #[test]
    fn what_was_used_last_is_kept() {
        let (_folder, cache) = cache(20_000);
        let content = [7; 1000];
        for n in 0..100 {
            cache.write(&n.to_string(), &[&content]).unwrap();
            // Files of the same time are of any order.
            let file = File::open(cache.file(&n.to_string())).unwrap();
            file.set_modified(SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(n)).unwrap();
            assert_eq!(cache.read("0").as_deref(), Some(&content[..]), "{n}");
            let bytes = cache.size().unwrap().bytes;
            assert!(bytes <= 20_000 + 20_000 / COUNTED + 1100, "{bytes}");
        }
        assert!(cache.read("1").is_none() && cache.read("99").is_some());
        cache.write("large", &[&[0; 2000]]).unwrap();
        assert!(cache.read("large").is_none());
    }

    #[test]
    fn several_may_write_at_once() {
        let (_folder, cache) = cache(1 << 20);
        let other = Cache::new(cache.folder.clone(), cache.most);
        std::thread::scope(|scope| {
            for cache in [&cache, &other, &cache, &other] {
                scope.spawn(|| {
                    for n in 0..200u8 {
                        cache.write("x", &[&vec![n; 5000]]).unwrap();
                        let found = cache.read("x").unwrap();
                        assert!(found.len() == 5000 && found.iter().all(|&byte| byte == found[0]));
                    }
                });
            }
        });
        assert_eq!(cache.size().unwrap().files, 1);
    }

    #[cfg(unix)]
    #[test]
    fn no_other_user_reads_it() {
        use std::os::unix::fs::PermissionsExt;
        let (_folder, cache) = cache(1 << 20);
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
        for _ in 0..2 {
            cache.write("x", &[b"one"]).unwrap();
            assert_eq!((mode(&cache.folder), mode(&cache.file("x"))), (0o700, 0o600));
            fs::set_permissions(&cache.folder, fs::Permissions::from_mode(0o755)).unwrap();
        }
    }
}
