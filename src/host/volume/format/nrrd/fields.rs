//! Fields of an NRRD header.

use crate::error::Error;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// Largest header in bytes, enough for a thousand file names.
const LARGEST: u64 = 1 << 20;

/// Fields by lower-case name, in file order.
#[derive(Clone)]
pub(super) struct Fields {
    path: PathBuf,
    fields: Vec<(String, String)>,
    /// Application-specific values (`key:=value`) by key, which is case-sensitive.
    values: Vec<(String, String)>,
    /// Lines after `data file: LIST`.
    pub listed: Vec<String>,
    /// Byte after the empty line that ends the header.
    pub end: u64,
}

impl Fields {
    pub fn read(path: &Path) -> Result<Self, Error> {
        let failed = |e| Error::read(path, e);
        let mut lines = BufReader::new(File::open(path).map_err(failed)?.take(LARGEST));
        let mut found = Self { path: path.into(), fields: Vec::new(), values: Vec::new(), listed: Vec::new(), end: 0 };
        loop {
            let mut line = Vec::new();
            let read = lines.read_until(b'\n', &mut line).map_err(failed)? as u64;
            found.end += read;
            let line = String::from_utf8_lossy(&line);
            let line = line.trim_end();
            if found.end >= LARGEST {
                return Err(found.wrong(format!("its header has no end within {LARGEST} bytes")));
            }
            // A detached header may end without an empty line.
            if read == 0 || line.is_empty() {
                return Ok(found);
            }
            found.take(line);
        }
    }

    fn take(&mut self, line: &str) {
        if line.starts_with('#') || line.starts_with("NRRD000") {
            return;
        }
        if self.get("data file").is_some_and(|value| value.starts_with("LIST")) {
            self.listed.push(line.into());
            return;
        }
        let Some((name, value)) = line.split_once(':') else { return };
        if let Some(value) = value.strip_prefix('=') {
            self.values.push((unescaped(name), unescaped(value)));
            return;
        }
        let name = match name.trim().to_ascii_lowercase().as_str() {
            "datafile" => "data file".into(),
            "lineskip" => "line skip".into(),
            "byteskip" => "byte skip".into(),
            "axismins" => "axis mins".into(),
            other => other.to_owned(),
        };
        self.fields.push((name, value.trim().into()));
    }

    pub fn get(&self, name: &str) -> Option<&str> {
        self.fields.iter().rfind(|(n, _)| n == name).map(|(_, value)| value.as_str())
    }

    /// An application-specific value.
    pub fn value(&self, key: &str) -> Option<&str> {
        self.values.iter().rfind(|(k, _)| k == key).map(|(_, value)| value.as_str())
    }

    /// Keys of the application-specific values, in file order.
    pub fn keys(&self) -> impl Iterator<Item = &str> {
        self.values.iter().map(|(key, _)| key.as_str())
    }

    pub fn need(&self, name: &str) -> Result<&str, Error> {
        self.get(name).ok_or_else(|| self.wrong(format!("its header has no '{name}'")))
    }

    /// One number of a field per axis.
    pub fn numbers<T: std::str::FromStr>(&self, name: &str, axes: usize) -> Result<Option<Vec<T>>, Error> {
        let Some(value) = self.get(name) else { return Ok(None) };
        let numbers: Option<Vec<T>> = value.split_whitespace().map(|word| word.parse().ok()).collect();
        match numbers {
            Some(numbers) if numbers.len() == axes => Ok(Some(numbers)),
            _ => Err(self.wrong(format!("its field {name} is '{value}': expected {axes} numbers"))),
        }
    }

    /// An integer field; 0 if it is missing.
    pub fn whole(&self, name: &str) -> Result<i64, Error> {
        let Some(value) = self.get(name) else { return Ok(0) };
        value.parse().map_err(|_| self.wrong(format!("its field {name} is '{value}': expected an integer")))
    }

    pub fn encoding(&self) -> &str {
        self.get("encoding").unwrap_or_default()
    }

    /// Whether the data are text, which has no byte order.
    pub fn is_text(&self) -> bool {
        matches!(self.encoding().to_ascii_lowercase().as_str(), "txt" | "text" | "ascii")
    }

    pub fn is_binary(&self) -> bool {
        !self.is_text()
    }

    pub fn wrong(&self, problem: impl Into<String>) -> Error {
        Error::volume(&self.path, problem)
    }
}

/// Application-specific keys and values have `\\n` for a line break and `\\\\` for a backslash.
fn unescaped(text: &str) -> String {
    let mut found = String::with_capacity(text.len());
    let mut characters = text.chars();
    while let Some(c) = characters.next() {
        match (c, characters.as_str().chars().next()) {
            ('\\', Some('n')) => found.push('\n'),
            ('\\', Some('\\')) => found.push('\\'),
            _ => {
                found.push(c);
                continue;
            }
        }
        characters.next();
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn backslashes_are_escapes_of_two_characters() {
        for (text, expected) in [("a\\nb", "a\nb"), ("a\\\\n", "a\\n"), ("a\\b\\", "a\\b\\"), ("", "")] {
            assert_eq!(unescaped(text), expected);
        }
    }
}
