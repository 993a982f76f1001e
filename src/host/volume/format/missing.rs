//! Formats that this build does not support; errors name the required feature.

use super::load::Opened;
use super::{Format, Found, OpenOptions};
use crate::error::Error;

/// A recognised format whose feature is disabled.
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
        &["array", "level", "region", "series"]
    }

    fn open(&self, file: &Found, _options: &OpenOptions) -> Result<Opened, Error> {
        let Self { name, feature, .. } = self;
        Err(Error::volume(file.path, format!("it is {name}, which needs a build with the feature {feature}")))
    }
}
