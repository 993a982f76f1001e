//! Formats that this build does not read: named, with what would.

use super::load::Opened;
use super::{Format, Found, OpenOptions};
use crate::error::Error;

/// A format of a feature that is off.
pub(super) struct Missing {
    pub name: &'static str,
    pub feature: &'static str,
    pub recognises: fn(&Found) -> bool,
}

impl Format for Missing {
    fn recognises(&self, file: &Found, _options: &OpenOptions) -> bool {
        (self.recognises)(file)
    }

    fn chooses(&self) -> &'static [&'static str] {
        &["array", "level", "series"]
    }

    fn open(&self, file: &Found, _options: &OpenOptions) -> Result<Opened, Error> {
        let Self { name, feature, .. } = self;
        Err(Error::volume(
            file.path,
            format!("it is {name}, which this build does not read: one with the feature {feature} does"),
        ))
    }
}
