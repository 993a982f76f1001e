//! Files of web servers, over HTTP and HTTPS, and of S3's public buckets.

use super::store::{Found, Span, Store, changed};
use crate::cache::{self, Cache};
use crate::url::Secrets;
use crate::volume::format::CHANGED;
use address::{Address, origin, redirected, unescaped, with_query};
use answer::{Failure, failure, passing};
use base64::Engine;
use kept::Place;
use serde_json::Value;
use std::borrow::Cow;
use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant, SystemTime};
use ureq::Agent;
use ureq::http::{StatusCode, header};
use ureq::tls::{Certificate, PemItem, RootCerts, TlsConfig};

mod address;
mod answer;
mod kept;
#[cfg(test)]
mod server;
#[cfg(test)]
mod tests;

/// Requests at once: of one file after the other, each would wait for the network.
const AT_ONCE: usize = 16;
/// Redirects that a request follows.
const MOST_REDIRECTS: usize = 5;
/// How much longer than the slowest answer another may take before its file is asked for again.
const SLOWER: u32 = 4;
/// Time for which metadata are kept: opening a volume asks for them several times.
const KEPT_FOR: Duration = Duration::from_secs(60);
/// Bytes of a file of unknown length that are read before the available memory is looked at again.
const STEP: u64 = 16 << 20;
/// Where S3 says in which region a bucket is.
const REGION: &str = "x-amz-bucket-region";

/// How long servers are waited for.
#[derive(Clone, Copy)]
struct Patience {
    /// Times that a file is asked for.
    attempts: u32,
    /// For a connection, and for more of an answer that has begun.
    pause: Duration,
    /// For an answer. The first two attempts wait not much longer than the slowest has taken so far; each further one twice as long.
    answer: Duration,
    /// Before the second attempt; each further one waits twice as long. Servers may name a longer time.
    backoff: Duration,
    longest_backoff: Duration,
}

#[cfg(not(test))]
const PATIENCE: Patience = Patience {
    attempts: 6,
    pause: Duration::from_secs(15),
    answer: Duration::from_secs(2),
    backoff: Duration::from_millis(100),
    longest_backoff: Duration::from_secs(30),
};

/// Tests do not wait.
#[cfg(test)]
const PATIENCE: Patience = Patience {
    attempts: 6,
    pause: Duration::from_millis(500),
    answer: Duration::from_millis(100),
    backoff: Duration::from_micros(100),
    longest_backoff: Duration::from_millis(1),
};

/// A metadata file, or that there is none, and since when that is known.
type Kept = (Instant, Option<Arc<[u8]>>);

/// A client.
pub(super) struct Http {
    agent: Agent,
    patience: Patience,
    /// Of files, on disk.
    cache: Option<&'static Cache>,
    metadata: Mutex<HashMap<PathBuf, Kept>>,
    /// Of the answers so far.
    slowest: Mutex<Duration>,
    /// Regions of buckets, as far as S3 has named them.
    regions: Mutex<HashMap<String, String>>,
}

/// The client of this process: its connections and metadata serve all volumes.
pub(super) fn shared() -> Arc<Http> {
    static SHARED: LazyLock<Arc<Http>> =
        LazyLock::new(|| Arc::new(Http::new(PATIENCE, if cfg!(test) { None } else { cache::downloads() })));
    SHARED.clone()
}

impl Http {
    fn new(patience: Patience, cache: Option<&'static Cache>) -> Self {
        let config = Agent::config_builder()
            .http_status_as_error(false)
            .max_redirects(0)
            .max_idle_connections(2 * AT_ONCE)
            .max_idle_connections_per_host(AT_ONCE)
            .accept_encoding("identity")
            .user_agent(concat!("layersplat/", env!("CARGO_PKG_VERSION")))
            .timeout_connect(Some(patience.pause))
            .timeout_per_read(Some(patience.pause))
            .tls_config(TlsConfig::builder().root_certs(roots()).build())
            .build();
        let (metadata, slowest, regions) = Default::default();
        Self { agent: config.new_agent(), patience, cache, metadata, slowest, regions }
    }

    /// One attempt to read bytes of a file of at most `most`, through redirects.
    fn attempt(&self, asked: &Asked, number: u32, most: u64) -> Result<Answer, Failure> {
        let Asked { address, span, version, place, kept } = *asked;
        let mut target = address.target(&lock(&self.regions));
        let mut secrets = Cow::Borrowed(&address.secrets);
        for _ in 0..=MOST_REDIRECTS {
            let mut request = self.agent.get(&*with_query(&target, &secrets));
            if let Some(user) = &secrets.user {
                let user = base64::engine::general_purpose::STANDARD.encode(unescaped(user));
                request = request.header(header::AUTHORIZATION, format!("Basic {user}"));
            }
            match span {
                Span::All => {}
                Span::Part(part) => request = request.header(header::RANGE, format!("bytes={}-{}", part.start, part.end - 1)),
                Span::Last(last) => request = request.header(header::RANGE, format!("bytes=-{last}")),
            }
            // Weak tags and dates do not identify bytes to servers.
            if let Some(tag) = version.filter(|version| version.starts_with('"')) {
                request = request.header(header::IF_MATCH, tag);
            }
            if let Some(kept) = kept {
                request = request.header(kept::condition(kept), kept);
            }
            let (begun, answer) = (Instant::now(), self.longest_answer(number));
            let sent = request.config().timeout_recv_response(Some(answer)).build().call();
            let mut response = sent.map_err(|e| failure(&e))?;
            let mut slowest = lock(&self.slowest);
            *slowest = begun.elapsed().max(*slowest);
            drop(slowest);
            let (status, headers) = (response.status(), response.headers());
            let region = headers.get(REGION).and_then(|region| region.to_str().ok());
            match status {
                StatusCode::OK | StatusCode::PARTIAL_CONTENT => {
                    let found = answer::version(headers);
                    if version.is_some() && found.is_some() && found.as_deref() != version {
                        return Err(Failure::Final(changed()));
                    }
                    // Servers may send all of the file, whatever they are asked for.
                    let part = if status == StatusCode::OK { None } else { Some(answer::part(headers, span)?) };
                    let (first, len) = part.map_or((0, None), |part| (part.start, Some(part.end - part.start)));
                    let place = place.filter(|_| kept::may_be_kept(headers) && (*span == Span::All || len.is_some()));
                    let found = Found { bytes: answer::body(&mut response, len, most)?, first, version: found };
                    place.inspect(|place| place.write(&found));
                    return Ok(Answer::Found(found));
                }
                StatusCode::PRECONDITION_FAILED if version.is_some() => return Err(Failure::Final(changed())),
                StatusCode::RANGE_NOT_SATISFIABLE if *span != Span::All => {
                    let problem = "the file has fewer bytes than its index says";
                    return Err(Failure::last(io::ErrorKind::InvalidData, problem));
                }
                StatusCode::NOT_MODIFIED if kept.is_some() => return Ok(Answer::Unchanged),
                StatusCode::NOT_FOUND | StatusCode::GONE => return Ok(Answer::Missing),
                StatusCode::UNAUTHORIZED | StatusCode::FORBIDDEN => {
                    let problem = format!("the server refuses it ({})", status.as_u16());
                    // Only 403 may mean that it is not there.
                    let is_forbidden = status == StatusCode::FORBIDDEN;
                    let kind = if is_forbidden { io::ErrorKind::PermissionDenied } else { io::ErrorKind::Other };
                    return Err(Failure::last(kind, problem));
                }
                StatusCode::REQUEST_TIMEOUT | StatusCode::TOO_MANY_REQUESTS => return Err(passing(status, headers)),
                _ if status.is_server_error() => return Err(passing(status, headers)),
                _ if status.is_redirection()
                    && let (Some(bucket), Some(region)) = (&address.bucket, region) =>
                {
                    lock(&self.regions).insert(bucket.clone(), region.to_owned());
                    target = address.target(&lock(&self.regions));
                }
                _ if status.is_redirection() => {
                    let next = headers.get(header::LOCATION).and_then(|location| location.to_str().ok());
                    let next = next.and_then(|location| redirected(&target, location)).ok_or_else(|| {
                        let problem = format!("the server redirects it ({}) to no web address", status.as_u16());
                        Failure::last(io::ErrorKind::Other, problem)
                    })?;
                    if target.starts_with("https:") && !next.starts_with("https:") {
                        let problem = "the server redirects it from https to http, where others could change it";
                        return Err(Failure::last(io::ErrorKind::Other, problem));
                    }
                    // Other servers get no secrets of this one; a redirect on it has a query of its own.
                    let user = secrets.user.clone().filter(|_| origin(&next) == origin(&target));
                    secrets = Cow::Owned(Secrets { user, query: None });
                    target = next;
                }
                _ => return Err(Failure::last(io::ErrorKind::Other, format!("the server answers with {}", status.as_u16()))),
            }
        }
        Err(Failure::last(io::ErrorKind::Other, format!("the server redirects it more than {MOST_REDIRECTS} times")))
    }

    /// Time that attempt `number` waits for an answer.
    fn longest_answer(&self, number: u32) -> Duration {
        let Patience { answer, attempts, .. } = self.patience;
        let doubled = |number: u32| answer * 2u32.saturating_pow(number.saturating_sub(1));
        let slowest = *lock(&self.slowest);
        // Metadata may come fast and chunks slowly: what they took says nothing of the later attempts.
        let first = if slowest.is_zero() { answer } else { (SLOWER * slowest).clamp(answer / SLOWER, doubled(attempts)) };
        if number < 2 { first } else { first.max(doubled(number)) }
    }

    /// Time before attempt `number`, or longer if the server says so. Requests that failed together do not come back together.
    fn wait(&self, number: u32, named: Option<Duration>) -> Duration {
        let Patience { backoff, longest_backoff, .. } = self.patience;
        let spread = SystemTime::UNIX_EPOCH.elapsed().map_or(0, |since| since.subsec_micros() % 1000);
        let own = backoff * 2u32.saturating_pow(number.saturating_sub(1)) * (500 + spread) / 1000;
        own.max(named.unwrap_or_default()).min(longest_backoff)
    }
}

/// What is asked for: bytes of a file, of the version that it had before.
struct Asked<'a> {
    address: &'a Address,
    span: &'a Span,
    version: Option<&'a str>,
    /// Where the answer is kept, and the version of what is there.
    place: Option<&'a Place<'a>>,
    kept: Option<&'a str>,
}

enum Answer {
    Found(Found),
    Missing,
    /// What is kept.
    Unchanged,
}

impl Store for Http {
    fn get(&self, file: &Path, span: &Span, version: Option<&str>, most: u64) -> io::Result<Option<Found>> {
        let address = &Address::new(file)?;
        let place = self.cache.and_then(|cache| Place::new(cache, address, span));
        let before = place.as_ref().and_then(|place| place.read(version)).filter(|found| found.bytes.len() as u64 <= most);
        let kept = before.as_ref().and_then(|found| found.version.as_deref());
        let asked = Asked { address, span, version, place: place.as_ref(), kept };
        let mut problem = String::new();
        for number in 0..self.patience.attempts {
            match self.attempt(&asked, number, most) {
                Ok(Answer::Found(found)) => return Ok(Some(found)),
                Ok(Answer::Unchanged) => return Ok(before),
                Ok(Answer::Missing) => return Ok(None),
                Err(Failure::Final(e)) => {
                    if e.kind() == CHANGED {
                        // So may have others of the server.
                        let server = address.target(&lock(&self.regions));
                        lock(&self.metadata).retain(|known, _| !known.starts_with(origin(&server)));
                    }
                    return Err(e);
                }
                Err(Failure::Passing(why, named)) => {
                    tracing::debug!("{}: attempt {number}: {why}", file.display());
                    problem = why;
                    if number + 1 < self.patience.attempts {
                        std::thread::sleep(self.wait(number + 1, named));
                    }
                }
            }
        }
        Err(io::Error::other(format!("{problem} ({} attempts)", self.patience.attempts)))
    }

    fn metadata(&self, file: &Path, most: u64) -> io::Result<Option<Arc<[u8]>>> {
        if let Some((_, kept)) = lock(&self.metadata).get(file).filter(|(since, _)| since.elapsed() < KEPT_FOR) {
            return Ok(kept.clone());
        }
        let found: Option<Arc<[u8]>> = self.get(file, &Span::All, None, most)?.map(|found| found.bytes.into());
        let mut all = lock(&self.metadata);
        all.retain(|_, (since, _)| since.elapsed() < KEPT_FOR);
        all.insert(file.into(), (Instant::now(), found.clone()));
        Ok(found)
    }

    fn keep(&self, file: PathBuf, metadata: &Value) {
        let bytes = || metadata.to_string().into_bytes().into();
        lock(&self.metadata).entry(file).or_insert_with(|| (Instant::now(), Some(bytes())));
    }

    fn folders(&self, _: &Path) -> io::Result<Option<Vec<String>>> {
        Ok(None)
    }

    fn at_once(&self) -> usize {
        AT_ONCE
    }
}

fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Certificates that are trusted: those of the file that `SSL_CERT_FILE` names, else those of browsers.
fn roots() -> RootCerts {
    let Some(file) = std::env::var_os("SSL_CERT_FILE").filter(|file| !file.is_empty()) else { return RootCerts::WebPki };
    let text = std::fs::read(&file).unwrap_or_else(|e| {
        tracing::warn!("SSL_CERT_FILE: cannot read {}: {e}", Path::new(&file).display());
        Vec::new()
    });
    let certificate = |item| if let Ok(PemItem::Certificate(found)) = item { Some(found) } else { None };
    ureq::tls::parse_pem(&text).filter_map(certificate).collect::<Vec<Certificate<'static>>>().into()
}
