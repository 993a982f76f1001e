//! Web addresses: of files, of S3's buckets, and where redirects lead.

use crate::url::{self, Secrets};
use std::borrow::Cow;
use std::collections::HashMap;
use std::io;
use std::path::Path;

/// A file of a server.
pub(super) struct Address {
    /// Scheme and host, and the path from `/` on, without secrets.
    origin: String,
    path: String,
    /// Of S3.
    pub bucket: Option<String>,
    pub secrets: Secrets,
}

impl Address {
    pub fn new(file: &Path) -> io::Result<Self> {
        let wrong = || io::Error::new(io::ErrorKind::InvalidInput, "it is no web address");
        let text = file.to_str().ok_or_else(wrong)?;
        let (text, secrets) = url::sent(text);
        let (scheme, rest) = text.split_once("://").ok_or_else(wrong)?;
        let (host, path) = rest.split_at(rest.find('/').unwrap_or(rest.len()));
        let bucket = scheme.eq_ignore_ascii_case("s3").then(|| host.to_owned());
        let origin = format!("{}://{host}", scheme.to_ascii_lowercase());
        Ok(Self { origin, path: escaped(path), bucket, secrets })
    }

    /// The web address, of S3 in the region that is known: named by the server, else by `AWS_REGION`. `AWS_ENDPOINT_URL` names other servers
    /// of that kind.
    pub fn target(&self, regions: &HashMap<String, String>) -> String {
        let Some(bucket) = &self.bucket else { return format!("{}{}", self.origin, self.path) };
        let named = |name: &str| std::env::var(name).ok().filter(|value| !value.is_empty());
        if let Some(endpoint) = named("AWS_ENDPOINT_URL") {
            return format!("{}/{bucket}{}", endpoint.trim_end_matches('/'), self.path);
        }
        let region = regions.get(bucket).cloned().or_else(|| named("AWS_REGION"));
        let server = region.map_or("s3".to_owned(), |region| format!("s3.{region}"));
        // Certificates hold for one name before the server's.
        if bucket.contains('.') {
            format!("https://{server}.amazonaws.com/{bucket}{}", self.path)
        } else {
            format!("https://{bucket}.{server}.amazonaws.com{}", self.path)
        }
    }
}

/// A path with what may not stand in a web address replaced. What is escaped already stays.
fn escaped(path: &str) -> String {
    let mut all = String::new();
    for byte in path.bytes() {
        match byte {
            b'!' | b'$'..=b';' | b'=' | b'@'..=b'Z' | b'_' | b'a'..=b'z' | b'~' => all.push(char::from(byte)),
            _ => all.push_str(&format!("%{byte:02X}")),
        }
    }
    all
}

/// Replaces `%XX` by bytes.
pub(super) fn unescaped(text: &str) -> Vec<u8> {
    let mut all = Vec::new();
    let mut rest = text.as_bytes();
    while let [byte, more @ ..] = rest {
        let number = |digits: &[u8]| u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok();
        let coded = (*byte == b'%').then(|| more.get(..2).and_then(number)).flatten();
        all.push(coded.unwrap_or(*byte));
        rest = if coded.is_some() { &more[2..] } else { more };
    }
    all
}

pub(super) fn with_query<'a>(target: &'a str, secrets: &Secrets) -> Cow<'a, str> {
    let separator = if target.contains('?') { '&' } else { '?' };
    secrets.query.as_ref().map_or(Cow::Borrowed(target), |query| format!("{target}{separator}{query}").into())
}

/// Scheme, host and port.
pub(super) fn origin(target: &str) -> &str {
    let host = target.find("://").map_or(0, |at| at + 3);
    target[host..].find(['/', '?', '#']).map_or(target, |at| &target[..host + at])
}

/// Where a redirect leads; `None` if it is no web address.
pub(super) fn redirected(from: &str, location: &str) -> Option<String> {
    let location = location.split('#').next().unwrap_or_default();
    let next = match location {
        _ if location.starts_with("https://") || location.starts_with("http://") => location.into(),
        _ if location.starts_with("//") => format!("{}{location}", from.split_inclusive(':').next()?),
        _ if location.starts_with('/') => format!("{}{location}", origin(from)),
        _ if location.is_empty() || location.contains(':') => return None,
        _ => format!("{}/{location}", from.split('?').next()?.rsplit_once('/')?.0),
    };
    Some(next)
}
