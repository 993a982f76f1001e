//! Which of several volumes that a file holds.

use crate::error::Error;
use std::path::Path;

/// The one of `several` that is wanted; the first, with a warning, where there are more and none was asked for. `field` is `frame` or
/// `channel`.
pub(super) fn chosen(path: &Path, field: &'static str, wanted: Option<usize>, several: usize) -> Result<usize, Error> {
    match wanted {
        Some(n) if n < several => Ok(n),
        Some(n) => {
            let last = several.saturating_sub(1);
            let problem = format!("{n} is not in {}, whose {field}s are 0 to {last}", path.display());
            Err(Error::Settings { field, problem })
        }
        None => {
            if several > 1 {
                tracing::warn!("{}: of {several} {field}s this is {field} 0; {field} chooses another", path.display());
            }
            Ok(0)
        }
    }
}

/// The number of the array that is wanted among `names`; nothing, with a warning where there are more, if none was asked for and it is to
/// be `default`.
pub(super) fn named(path: &Path, wanted: Option<&str>, names: &[&str], default: &str) -> Result<Option<usize>, Error> {
    let Some(wanted) = wanted else {
        if names.len() > 1 {
            let all = names.join(", ");
            tracing::warn!("{}: of the arrays {all} this is {default}; array chooses another", path.display());
        }
        return Ok(None);
    };
    let found = names.iter().position(|name| *name == wanted);
    let unknown = || {
        let problem = format!("'{wanted}' is not in {}, whose arrays are {}", path.display(), names.join(", "));
        Error::Settings { field: "array", problem }
    };
    found.map(Some).ok_or_else(unknown)
}
