//! What servers answer, and why an attempt failed.

use super::super::store::{Span, room};
use super::STEP;
use crate::memory;
use crate::volume::format::bytes;
use std::io;
use std::ops::Range;
use std::path::Path;
use std::time::Duration;
use ureq::http::{HeaderMap, HeaderValue, Response, StatusCode, header};
use ureq::{Body, Timeout};

/// Why an attempt failed.
pub(super) enum Failure {
    /// Another attempt may succeed, after this time.
    Passing(String, Option<Duration>),
    Final(io::Error),
}

impl Failure {
    pub fn last(kind: io::ErrorKind, problem: impl Into<String>) -> Self {
        Self::Final(io::Error::new(kind, problem.into()))
    }
}

/// What an error of the connection means. Its own text may have the address.
pub(super) fn failure(error: &ureq::Error) -> Failure {
    let passing = |problem: &str| Failure::Passing(problem.into(), None);
    let unsafe_connection = |e: &dyn std::error::Error| {
        let problem = format!("no safe connection to the server ({e}): SSL_CERT_FILE names the certificates that are trusted");
        Failure::last(io::ErrorKind::Other, problem)
    };
    match error {
        ureq::Error::Timeout(Timeout::Connect | Timeout::Resolve) => passing("no connection to the server"),
        ureq::Error::Timeout(_) => passing("the server does not answer in time"),
        // Of the system's resolver, which may be disturbed for a time.
        ureq::Error::Io(e) if e.to_string().starts_with("failed to lookup address") => {
            passing("its server is not found: correct its name, or check the network")
        }
        // Of certificates.
        ureq::Error::Io(e) if e.kind() == io::ErrorKind::InvalidData => unsafe_connection(e),
        ureq::Error::Io(e) => Failure::Passing(format!("the connection failed ({e})"), None),
        ureq::Error::Protocol(_) | ureq::Error::ConnectionFailed => passing("the connection failed"),
        ureq::Error::HostNotFound => Failure::last(io::ErrorKind::NotFound, "its server is not found: correct its name"),
        ureq::Error::Rustls(e) => unsafe_connection(e),
        ureq::Error::BadUri(_) | ureq::Error::Http(_) => Failure::last(io::ErrorKind::InvalidInput, "it is no web address"),
        ureq::Error::LargeResponseHeader(..) => Failure::last(io::ErrorKind::Other, "the server's answer has too long a header"),
        _ => Failure::last(io::ErrorKind::Other, "the server cannot be asked"),
    }
}

/// A status after which another attempt may succeed.
pub(super) fn passing(status: StatusCode, headers: &HeaderMap) -> Failure {
    let seconds = headers.get(header::RETRY_AFTER).and_then(|after| after.to_str().ok()?.parse().ok());
    Failure::Passing(format!("the server answers with {}", status.as_u16()), seconds.map(Duration::from_secs))
}

/// The version of the file of an answer.
pub(super) fn version(headers: &HeaderMap) -> Option<String> {
    let named = |name| headers.get(name).and_then(|value: &HeaderValue| value.to_str().ok()).map(String::from);
    named(header::ETAG).or_else(|| named(header::LAST_MODIFIED))
}

/// The bytes of the file that an answer with a part of it has. What differs from what was asked for is no answer, unless the file ends there.
pub(super) fn part(headers: &HeaderMap, span: &Span) -> Result<Range<u64>, Failure> {
    let text = headers.get(header::CONTENT_RANGE).and_then(|range| range.to_str().ok());
    let numbers = text.and_then(|text| {
        let (range, len) = text.strip_prefix("bytes ")?.split_once('/')?;
        let (first, last) = range.split_once('-')?;
        let (first, last): (u64, u64) = (first.trim().parse().ok()?, last.trim().parse().ok()?);
        let len = len.trim().parse().ok();
        (first <= last && len.is_none_or(|len| last < len)).then_some((first..last + 1, len))
    });
    let expected = numbers.filter(|(found, len)| match span {
        Span::All => false,
        Span::Part(part) => {
            found.start == part.start && (found.end == part.end || *len == Some(found.end) && found.end < part.end)
        }
        Span::Last(last) => *len == Some(found.end) && found.start == found.end.saturating_sub(*last),
    });
    let problem = || format!("the server answers with other bytes than it was asked for ({})", text.unwrap_or("not said which"));
    expected.map(|(found, _)| found).ok_or_else(|| Failure::Passing(problem(), None))
}

/// The body of an answer, of so many bytes if that is known.
pub(super) fn body(response: &mut Response<Body>, expected: Option<u64>, most: u64) -> Result<Vec<u8>, Failure> {
    let coding = response.headers().get(header::CONTENT_ENCODING).filter(|coding| *coding != "identity");
    if let Some(coding) = coding {
        let problem = format!("the server sends it in the encoding {coding:?}, which was not asked for");
        return Err(Failure::last(io::ErrorKind::Other, problem));
    }
    let len = response.body().content_length();
    if let (Some(len), Some(expected)) = (len, expected.filter(|&expected| len != Some(expected))) {
        return Err(Failure::Passing(format!("the server announces {len} bytes, where it has {expected}"), None));
    }
    let mut all = room(Path::new("a file of a server"), len.unwrap_or(0), most).map_err(Failure::Final)?;
    let mut from = response.body_mut().with_config().limit(u64::MAX).reader();
    let broken = |e: io::Error| match e.kind() {
        io::ErrorKind::OutOfMemory => Failure::Final(e),
        _ => Failure::Passing(format!("the connection ended within the file ({e})"), None),
    };
    let Some(len) = len else {
        loop {
            // Memory for it may double.
            let required = memory::require("a file of a server", all.len() as u64);
            required.map_err(|e| Failure::last(io::ErrorKind::OutOfMemory, e.to_string()))?;
            let step = STEP.min(most.saturating_add(1).saturating_sub(all.len() as u64));
            let found = io::Read::read_to_end(&mut io::Read::take(&mut from, step), &mut all).map_err(broken)?;
            if all.len() as u64 > most {
                let problem = format!("it has more bytes than the {most} that it may have at most");
                return Err(Failure::last(io::ErrorKind::InvalidData, problem));
            }
            if (found as u64) < step {
                return match expected {
                    Some(expected) if expected != all.len() as u64 => {
                        Err(Failure::Passing(format!("the connection ended after {} of {expected} bytes", all.len()), None))
                    }
                    _ => Ok(all),
                };
            }
        }
    };
    let found = bytes::fill(&mut from, &mut all).map_err(broken)?;
    if found as u64 != len {
        return Err(Failure::Passing(format!("the connection ended after {found} of {len} bytes"), None));
    }
    // To its end, so that the connection serves the next request.
    bytes::fill(&mut from, &mut [0]).map_err(broken)?;
    Ok(all)
}
