//! Answers that are kept on disk. Each is used again only if the server says, asked for this file once more, that it is still that: who may
//! not read it there does not read it here.
//!
//! Only what anybody may read is kept: files whose address has user info or a query are not. Neither a secret nor anything that leads to one is
//! in the cache then, and two addresses that differ in their queries never share what is kept.

use super::super::store::{Found, Span};
use super::address::{Address, origin};
use crate::cache::Cache;
use crate::url::Secrets;
use std::collections::HashMap;
use ureq::http::{HeaderMap, HeaderName, header};

/// Where an answer is kept.
pub(super) struct Place<'a> {
    cache: &'a Cache,
    key: String,
}

impl<'a> Place<'a> {
    /// The place of bytes of a file, if it may be kept.
    pub fn new(cache: &'a Cache, address: &Address, span: &Span) -> Option<Self> {
        let target = address.target(&HashMap::new());
        // `AWS_ENDPOINT_URL` may have user info.
        let is_public = address.secrets == Secrets::default() && !origin(&target).contains('@');
        is_public.then(|| Self { cache, key: format!("{target} {span:?}") })
    }

    /// What is kept, of this version if one is given.
    pub fn read(&self, version: Option<&str>) -> Option<Found> {
        let all = self.cache.read(&self.key)?;
        let mut parts = all.splitn(3, |&byte| byte == b'\n');
        let mut text = || std::str::from_utf8(parts.next()?).ok();
        let (found, first) = (text()?.to_owned(), text()?.parse().ok()?);
        let bytes = parts.next()?.to_vec();
        version.is_none_or(|version| found == version).then_some(Found { bytes, first, version: Some(found) })
    }

    /// Keeps an answer that the server can be asked about again.
    pub fn write(&self, found: &Found) {
        let Some(version) = &found.version else { return };
        let start = format!("{version}\n{}\n", found.first);
        if let Err(e) = self.cache.write(&self.key, &[start.as_bytes(), &found.bytes]) {
            tracing::debug!("{}: nothing is kept: {e}", self.cache.folder().display());
        }
    }
}

/// Whether an answer may be kept: servers may forbid it, and dates tell versions apart only from a second after the last change on.
pub(super) fn may_be_kept(headers: &HeaderMap) -> bool {
    let control = headers.get_all(header::CACHE_CONTROL).iter().filter_map(|value| value.to_str().ok());
    let mut words = control.flat_map(|value| value.split(','));
    let dates = [header::LAST_MODIFIED, header::DATE].map(|name| headers.get(name));
    !words.any(|word| word.trim().eq_ignore_ascii_case("no-store"))
        && (headers.contains_key(header::ETAG) || dates[0].is_some() && dates[1].is_some() && dates[0] != dates[1])
}

/// The header that asks for a file if it is no longer of this version.
pub(super) fn condition(version: &str) -> HeaderName {
    if version.ends_with('"') { header::IF_NONE_MATCH } else { header::IF_MODIFIED_SINCE }
}
