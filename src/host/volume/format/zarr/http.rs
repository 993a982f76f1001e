//! Files of web servers, over HTTP and HTTPS, and of S3's public buckets.

use super::store::{Store, room};
use crate::memory;
use crate::url::{self, Secrets};
use crate::volume::format::bytes;
use base64::Engine;
use std::borrow::Cow;
use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant, SystemTime};
use ureq::http::{HeaderMap, StatusCode, header};
use ureq::tls::{Certificate, PemItem, RootCerts, TlsConfig};
use ureq::{Agent, Timeout};

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
    metadata: Mutex<HashMap<PathBuf, Kept>>,
    /// Of the answers so far.
    slowest: Mutex<Duration>,
    /// Regions of buckets, as far as S3 has named them.
    regions: Mutex<HashMap<String, String>>,
}

/// The client of this process: its connections and metadata serve all volumes.
pub(super) fn shared() -> Arc<Http> {
    static SHARED: LazyLock<Arc<Http>> = LazyLock::new(|| Arc::new(Http::new(PATIENCE)));
    SHARED.clone()
}

/// Why an attempt failed.
enum Failure {
    /// Another attempt may succeed, after this time.
    Passing(String, Option<Duration>),
    Final(io::Error),
}

impl Failure {
    fn last(kind: io::ErrorKind, problem: impl Into<String>) -> Self {
        Self::Final(io::Error::new(kind, problem.into()))
    }
}

impl Http {
    fn new(patience: Patience) -> Self {
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
        Self { agent: config.new_agent(), patience, metadata, slowest, regions }
    }

    /// One attempt to read a file of at most `most` bytes, through redirects.
    fn attempt(&self, address: &Address, number: u32, most: u64) -> Result<Option<Vec<u8>>, Failure> {
        let mut target = address.target(&lock(&self.regions));
        let mut secrets = Cow::Borrowed(&address.secrets);
        for _ in 0..=MOST_REDIRECTS {
            let mut request = self.agent.get(&*with_query(&target, &secrets));
            if let Some(user) = &secrets.user {
                let user = base64::engine::general_purpose::STANDARD.encode(unescaped(user));
                request = request.header(header::AUTHORIZATION, format!("Basic {user}"));
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
                StatusCode::OK => return body(&mut response, most).map(Some),
                StatusCode::NOT_FOUND | StatusCode::GONE => return Ok(None),
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

impl Store for Http {
    fn get(&self, file: &Path, most: u64) -> io::Result<Option<Vec<u8>>> {
        let address = Address::new(file)?;
        let mut problem = String::new();
        for number in 0..self.patience.attempts {
            match self.attempt(&address, number, most) {
                Ok(found) => return Ok(found),
                Err(Failure::Final(e)) => return Err(e),
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
        let found: Option<Arc<[u8]>> = self.get(file, most)?.map(Into::into);
        lock(&self.metadata).insert(file.into(), (Instant::now(), found.clone()));
        Ok(found)
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

/// A file of a server.
struct Address {
    /// Scheme and host, and the path from `/` on, without secrets.
    origin: String,
    path: String,
    /// Of S3.
    bucket: Option<String>,
    secrets: Secrets,
}

impl Address {
    fn new(file: &Path) -> io::Result<Self> {
        let wrong = || io::Error::new(io::ErrorKind::InvalidInput, "it is no web address");
        let text = file.to_str().ok_or_else(wrong)?;
        let (scheme, rest) = text.split_once("://").ok_or_else(wrong)?;
        let (host, path) = rest.split_at(rest.find('/').unwrap_or(rest.len()));
        let bucket = scheme.eq_ignore_ascii_case("s3").then(|| host.to_owned());
        let origin = format!("{}://{host}", scheme.to_ascii_lowercase());
        Ok(Self { origin, path: escaped(path), bucket, secrets: url::secrets(text) })
    }

    /// The web address, of S3 in the region that is known: named by the server, else by `AWS_REGION`. `AWS_ENDPOINT_URL` names other servers
    /// of that kind.
    fn target(&self, regions: &HashMap<String, String>) -> String {
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
fn unescaped(text: &str) -> Vec<u8> {
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

fn with_query<'a>(target: &'a str, secrets: &Secrets) -> Cow<'a, str> {
    let separator = if target.contains('?') { '&' } else { '?' };
    secrets.query.as_ref().map_or(Cow::Borrowed(target), |query| format!("{target}{separator}{query}").into())
}

/// Scheme, host and port.
fn origin(target: &str) -> &str {
    let host = target.find("://").map_or(0, |at| at + 3);
    target[host..].find(['/', '?', '#']).map_or(target, |at| &target[..host + at])
}

/// Where a redirect leads; `None` if it is no web address.
fn redirected(from: &str, location: &str) -> Option<String> {
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

/// What an error of the connection means. Its own text may have the address.
fn failure(error: &ureq::Error) -> Failure {
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
fn passing(status: StatusCode, headers: &HeaderMap) -> Failure {
    let seconds = headers.get(header::RETRY_AFTER).and_then(|after| after.to_str().ok()?.parse().ok());
    Failure::Passing(format!("the server answers with {}", status.as_u16()), seconds.map(Duration::from_secs))
}

/// The whole body of an answer.
fn body(response: &mut ureq::http::Response<ureq::Body>, most: u64) -> Result<Vec<u8>, Failure> {
    let coding = response.headers().get(header::CONTENT_ENCODING).filter(|coding| *coding != "identity");
    if let Some(coding) = coding {
        let problem = format!("the server sends it in the encoding {coding:?}, which was not asked for");
        return Err(Failure::last(io::ErrorKind::Other, problem));
    }
    let len = response.body().content_length();
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
                return Ok(all);
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
