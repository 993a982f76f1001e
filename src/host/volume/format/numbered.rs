//! Data files named in headers, including numbered ones.

use super::OpenOptions;
use super::bytes::{Bytes, Joined};
use crate::error::Error;
use crate::url;
use std::path::{Component, Path, PathBuf};

/// Limit of files that a pattern may name.
const MOST: usize = 1 << 16;

/// Expands a pattern with one `%d`, `%3d` or `%03d`.
pub(super) fn names(pattern: &str, first: i64, last: i64, step: i64) -> Result<Vec<String>, String> {
    let wrong = || {
        format!(
            "invalid file name pattern '{pattern}' for the numbers {first} to {last} in steps of {step}: expected \
                            one %d or %03d"
        )
    };
    let (before, rest) = pattern.split_once('%').ok_or_else(wrong)?;
    let (width, after) = rest.split_once('d').ok_or_else(wrong)?;
    let filled = width.starts_with('0');
    let width: usize = if width.is_empty() { 0 } else { width.parse().ok().filter(|&n| n <= 20).ok_or_else(wrong)? };
    let count = if step == 0 { -1 } else { (i128::from(last) - i128::from(first)) / i128::from(step) + 1 };
    let count = usize::try_from(count).ok().filter(|count| (1..=MOST).contains(count)).ok_or_else(wrong)?;
    if after.contains('%') {
        return Err(wrong());
    }
    let number = |n: i64| if filled { format!("{n:0width$}") } else { format!("{n:width$}") };
    Ok((0..count).map(|i| format!("{before}{}{after}", number(first + step * i as i64))).collect())
}

/// Data files, and the number of array axes in each, if specified.
pub(super) type Several = (Vec<PathBuf>, Option<usize>);

/// Whether a relative path stays inside its folder.
pub(super) fn leads_below(name: &str) -> bool {
    Path::new(name).components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
}

/// Path of a file that a header names.
///
/// # Errors
/// If the header is [confined](OpenOptions::confined) to its folder, and the file is not there.
pub(super) fn beside(header: &Path, name: &str, options: &OpenOptions) -> Result<PathBuf, Error> {
    // In a folder without a name, it would be opened as one.
    if url::is_url(Path::new(name)) {
        return Err(Error::volume(
            header,
            format!("its header names {}, which is no file: download it", url::public(Path::new(name)).display()),
        ));
    }
    let file = header.parent().unwrap_or(Path::new("")).join(name);
    if options.confined {
        if !leads_below(name) {
            let problem = format!("its header names {name}: change that to the name of a file beside the header");
            return Err(Error::volume(header, problem));
        }
        if !file.is_file() {
            let problem = format!("its header names the file {name}, which is not beside it: give both together");
            return Err(Error::volume(header, problem));
        }
    }
    Ok(file)
}

/// Concatenation of data files with `each` bytes per file, `whole` bytes in total. `open` opens one of them.
pub(super) fn joined(
    header: &Path,
    files: Vec<PathBuf>,
    whole: u64,
    each: u64,
    open: impl Fn(&Path) -> Result<Box<dyn Bytes>, Error> + 'static,
) -> Result<Box<dyn Bytes>, Error> {
    let (found, expected) = (files.len(), whole.div_ceil(each));
    if found as u64 != expected {
        return Err(Error::volume(header, format!("it names {found} data files, but its sizes require {expected}")));
    }
    Ok(Box::new(Joined::new(files, each, open)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_name_files() {
        assert_eq!(names("a.%03d.raw", 8, 10, 1).unwrap(), ["a.008.raw", "a.009.raw", "a.010.raw"]);
        assert_eq!(names("s%d", 5, 1, -2).unwrap(), ["s5", "s3", "s1"]);
        for (pattern, first, last, step) in
            [("a", 0, 1, 1), ("a%x", 0, 1, 1), ("a%d", 0, 1, 0), ("a%d", 1, 0, 1), ("%d%d", 0, 1, 1), ("%d", 0, i64::MAX, 1)]
        {
            assert!(names(pattern, first, last, step).is_err(), "{pattern} {first} {last} {step}");
        }
    }
}
