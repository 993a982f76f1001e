//! Text headers with one key and value per line.

use crate::error::Error;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Largest header in bytes, enough for a thousand file names.
const LARGEST: u64 = 1 << 20;

/// Keys and values, in file order.
#[derive(Clone)]
pub(super) struct Keyed {
    path: PathBuf,
    fields: Vec<(String, String)>,
    /// Lines after `LIST`.
    pub listed: Vec<String>,
    /// Byte after the header.
    pub end: u64,
}

impl Keyed {
    /// Reads lines of `key separator value` up to and including the key `last`, or to the end of the file. If the last value begins
    /// with LIST, also reads the lines after it.
    pub fn read(path: &Path, separator: char, last: &str) -> Result<Self, Error> {
        let failed = |e| Error::read(path, e);
        let mut lines = BufReader::new(File::open(path).map_err(failed)?.take(LARGEST));
        let mut found = Self { path: path.into(), fields: Vec::new(), listed: Vec::new(), end: 0 };
        let mut listing = false;
        loop {
            let mut line = Vec::new();
            let read = lines.read_until(b'\n', &mut line).map_err(failed)? as u64;
            found.end += read;
            if found.end >= LARGEST {
                return Err(found.wrong(format!("its header has no end within {LARGEST} bytes")));
            }
            if read == 0 {
                return Ok(found);
            }
            let line = String::from_utf8_lossy(&line);
            let line = line.trim();
            if listing {
                found.listed.extend((!line.is_empty()).then(|| line.to_owned()));
            } else if let Some((key, value)) = line.split_once(separator).filter(|_| !line.starts_with('#')) {
                let (key, value) = (key.trim().to_owned(), value.trim().to_owned());
                let (is_last, is_list) = (key.eq_ignore_ascii_case(last), value.starts_with("LIST"));
                found.fields.push((key, value));
                if is_last && !is_list {
                    return Ok(found);
                }
                listing = is_last;
            }
        }
    }

    /// Value of the first of these keys that exists, ignoring case.
    pub fn get(&self, keys: &[&str]) -> Option<&str> {
        let of = |key: &&str| self.fields.iter().rfind(|(k, _)| k.eq_ignore_ascii_case(key));
        keys.iter().find_map(of).map(|(_, value)| value.as_str())
    }

    pub fn need(&self, key: &str) -> Result<&str, Error> {
        self.get(&[key]).ok_or_else(|| self.wrong(format!("its header has no {key}")))
    }

    /// Numbers of the first of these keys that exists, at least `least` of them.
    pub fn numbers<T: FromStr>(&self, keys: &[&str], least: usize) -> Result<Option<Vec<T>>, Error> {
        let Some(value) = self.get(keys) else { return Ok(None) };
        let words = value.split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty());
        let numbers: Option<Vec<T>> = words.map(|word| word.parse().ok()).collect();
        let numbers = numbers.filter(|numbers| numbers.len() >= least);
        let wrong = || self.wrong(format!("its {} is '{value}': expected {least} numbers", keys[0]));
        numbers.map(Some).ok_or_else(wrong)
    }

    /// The first number of a key.
    pub fn number<T: FromStr>(&self, key: &str) -> Result<Option<T>, Error> {
        Ok(self.numbers(&[key], 1)?.and_then(|numbers| numbers.into_iter().next()))
    }

    /// Whether the value of the first of these keys that exists is True.
    pub fn is_true(&self, keys: &[&str]) -> bool {
        self.get(keys).is_some_and(|value| value.starts_with(['T', 't', '1']))
    }

    pub fn wrong(&self, problem: impl Into<String>) -> Error {
        Error::volume(&self.path, problem)
    }
}
