//! Selection of one of several volumes in a file.

use super::OpenOptions;
use crate::error::Error;
use crate::volume::Contents;
use std::path::Path;

impl Contents {
    /// Selects one of several frames.
    pub(super) fn choose_frame(&mut self, path: &Path, options: &OpenOptions, several: usize) -> Result<usize, Error> {
        self.frames = several;
        self.frame = chosen(path, "frame", options.frame, several)?;
        Ok(self.frame)
    }

    /// Selects one of several channels.
    pub(super) fn choose_channel(&mut self, path: &Path, options: &OpenOptions, several: usize) -> Result<usize, Error> {
        self.channels = several;
        self.channel = chosen(path, "channel", options.channel, several)?;
        Ok(self.channel)
    }
}

impl Contents {
    /// As [`choose_channel`](Self::choose_channel), or the magnitude of all channels: if it is asked for, or by default for those that are
    /// declared as a vector. The index is then that of the first.
    pub(super) fn choose_component(
        &mut self,
        path: &Path,
        options: &OpenOptions,
        several: usize,
        is_vector: bool,
    ) -> Result<usize, Error> {
        self.is_vector = is_vector && several > 1;
        if several < 2 || !(options.magnitude || is_vector && options.channel.is_none()) {
            return self.choose_channel(path, options, several);
        }
        (self.channels, self.magnitude) = (several, true);
        Ok(0)
    }
}

/// Rejects frames and channels that a file does not have. Formats that have one of each choose none.
pub(super) fn check(path: &Path, options: &OpenOptions, contents: &Contents) -> Result<(), Error> {
    for (field, wanted, several) in [("frame", options.frame, contents.frames), ("channel", options.channel, contents.channels)] {
        if wanted.is_some() {
            chosen(path, field, wanted, several)?;
        }
    }
    Ok(())
}

/// Index of the selected one of `several` volumes. Without a selection it is the first, with a warning if there are more. `field` is
/// `frame` or `channel`.
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
                tracing::warn!("{}: using {field} 0 of {several}; select another with {field}", path.display());
            }
            Ok(0)
        }
    }
}

/// Index of the selected array in `names`. Without a selection it is `None`, with a warning that names `default` if there are more.
pub(super) fn named(path: &Path, wanted: Option<&str>, names: &[&str], default: &str) -> Result<Option<usize>, Error> {
    let Some(wanted) = wanted else {
        if names.len() > 1 {
            let all = names.join(", ");
            tracing::warn!("{}: using the array {default} of {all}; select another with array", path.display());
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
