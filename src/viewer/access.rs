//! Who may use the viewer: the token of the run, its cookie, and the checks of `Host` and `Origin`.
//!
//! Any page that the user has open can send requests to a loopback address. Three checks keep them out: the cookie, which only the printed
//! address gives (`SameSite=Strict`); `Origin`, which a page cannot choose; and `Host`, because a foreign name that was rebound to the
//! loopback address has an equal `Origin` and `Host`.

use crate::error::Error;
use axum::http::header::{COOKIE, HOST, ORIGIN};
use axum::http::{HeaderMap, HeaderName};
use std::hint::black_box;
use std::io;
#[cfg(unix)]
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

/// Names of the loopback interface, which no name server can rebind.
const LOOPBACK: [&str; 3] = ["localhost", "127.0.0.1", "[::1]"];
/// Random bytes of a token: 256 bits.
const TOKEN_BYTES: usize = 32;
/// Random bytes of the run in the cookie's name. Cookies do not know ports, so each run needs a name of its own.
const RUN_BYTES: usize = 8;
/// Fewest characters of a token from a file: 128 bits in hexadecimal digits.
const LEAST_TOKEN: usize = 32;
/// Permissions of a file for others than its owner.
#[cfg(unix)]
const OTHERS: u32 = 0o077;
/// Most characters of a token from a file.
const MOST_TOKEN: usize = 256;

/// What a request is refused for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refusal {
    /// `Host` is missing, given twice, or no name of this server.
    Host,
    /// `Origin` is another site, or missing where it is required.
    Origin,
    /// The cookie of this run is missing or wrong.
    Cookie,
    /// The token of the address is wrong.
    Token,
}

impl Refusal {
    /// A sentence for the user.
    pub fn sentence(self) -> &'static str {
        match self {
            Refusal::Host => "This name does not belong to the viewer. Use the address that layersplat printed.",
            Refusal::Origin => "Another site asked for this. Open the address that layersplat printed.",
            Refusal::Cookie => "This browser has no access yet. Open the address that layersplat printed, with its token.",
            Refusal::Token => "This token is wrong or belongs to an earlier run. Open the address that layersplat printed last.",
        }
    }
}

/// The secrets and names of one run.
pub struct Access {
    token: String,
    cookie_name: String,
    cookie: String,
    /// Names other than those of the loopback interface.
    names: Vec<String>,
}

impl Access {
    /// Random secrets, and the loopback names.
    ///
    /// # Errors
    /// If the system has no random numbers.
    pub fn new() -> Result<Self, Error> {
        let [token, cookie] = [random_hex(TOKEN_BYTES)?, random_hex(TOKEN_BYTES)?];
        Ok(Self { token, cookie_name: format!("layersplat-{}", random_hex(RUN_BYTES)?), cookie, names: Vec::new() })
    }

    /// Takes the token from a file, without the white space around it.
    ///
    /// # Errors
    /// If the file cannot be read, or its token is short, long or has characters that an address cannot hold.
    pub fn with_token_file(mut self, path: &Path) -> Result<Self, Error> {
        let text = std::fs::read_to_string(path).map_err(|e| Error::read(path, e))?;
        #[cfg(unix)]
        if std::fs::metadata(path).is_ok_and(|found| found.permissions().mode() & OTHERS != 0) {
            tracing::warn!("other users can read the token in {0}: keep it to yourself by chmod 600 {0}", path.display());
        }
        let token = text.trim();
        let is_plain = token.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"-_.~".contains(&byte));
        if !((LEAST_TOKEN..=MOST_TOKEN).contains(&token.len()) && is_plain) {
            let problem = format!("its token needs {LEAST_TOKEN} to {MOST_TOKEN} letters, digits, '-', '_', '.' or '~'");
            return Err(Error::read(path, io::Error::new(io::ErrorKind::InvalidData, problem)));
        }
        self.token = token.to_owned();
        Ok(self)
    }

    /// Accepts another name of this machine, without a port.
    pub fn with_name(mut self, name: &str) -> Self {
        self.names.push(name.to_ascii_lowercase());
        self
    }

    /// The token of the printed address.
    pub fn token(&self) -> &str {
        &self.token
    }

    /// The `Set-Cookie` header that a right token is exchanged for.
    pub(super) fn set_cookie(&self) -> String {
        format!("{}={}; HttpOnly; SameSite=Strict; Path=/", self.cookie_name, self.cookie)
    }

    /// Checks `Host`, and `Origin`: if present, and wherever `requires_origin`.
    pub(super) fn check_site(&self, headers: &HeaderMap, requires_origin: bool) -> Result<(), Refusal> {
        let host = only(headers, HOST).map_err(|_| Refusal::Host)?.ok_or(Refusal::Host)?;
        if !self.is_own_name(host) {
            return Err(Refusal::Host);
        }
        match only(headers, ORIGIN).map_err(|_| Refusal::Origin)? {
            Some(origin) if origin.strip_prefix("http://") == Some(host) => Ok(()),
            None if !requires_origin => Ok(()),
            _ => Err(Refusal::Origin),
        }
    }

    /// Checks the cookie.
    pub(super) fn check_cookie(&self, headers: &HeaderMap) -> Result<(), Refusal> {
        let all = headers.get_all(COOKIE).iter().filter_map(|value| value.to_str().ok());
        let pairs = all.flat_map(|cookies| cookies.split(';')).filter_map(|pair| pair.trim().split_once('='));
        let mut own = pairs.filter(|(name, _)| *name == self.cookie_name);
        if own.any(|(_, value)| is_equal(value, &self.cookie)) { Ok(()) } else { Err(Refusal::Cookie) }
    }

    /// Checks a token.
    pub(super) fn check_token(&self, token: &str) -> Result<(), Refusal> {
        if is_equal(token, &self.token) { Ok(()) } else { Err(Refusal::Token) }
    }

    /// Whether a `Host` names this server. Any port is accepted: `ssh -L` and containers change it.
    fn is_own_name(&self, host: &str) -> bool {
        let name = match host.rsplit_once(':') {
            // The colons of an address in brackets are no port.
            Some((name, port)) if !port.ends_with(']') => {
                if port.is_empty() || port.len() > 5 || !port.bytes().all(|byte| byte.is_ascii_digit()) {
                    return false;
                }
                name
            }
            _ => host,
        };
        let name = name.to_ascii_lowercase();
        LOOPBACK.contains(&name.as_str()) || self.names.contains(&name)
    }
}

/// The value of a header that may be given once. `Err` if it is given more often, or is no text.
fn only(headers: &HeaderMap, name: HeaderName) -> Result<Option<&str>, ()> {
    let mut values = headers.get_all(name).iter();
    match (values.next(), values.next()) {
        (None, _) => Ok(None),
        (Some(value), None) => value.to_str().map(Some).map_err(|_| ()),
        (Some(_), Some(_)) => Err(()),
    }
}

/// Compares in a time that does not depend on where the texts differ.
fn is_equal(given: &str, secret: &str) -> bool {
    let differing = given.bytes().zip(secret.bytes()).fold(0u8, |all, (a, b)| black_box(all | (a ^ b)));
    given.len() == secret.len() && differing == 0
}

fn random_hex(bytes: usize) -> Result<String, Error> {
    let mut random = vec![0u8; bytes];
    getrandom::fill(&mut random)
        .map_err(|e| Error::read(Path::new("the system's random numbers"), io::Error::other(e.to_string())))?;
    Ok(random.iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::HeaderValue;

    fn headers(pairs: &[(&'static str, &str)]) -> HeaderMap {
        let mut headers = HeaderMap::new();
        for (name, value) in pairs {
            headers.append(*name, HeaderValue::from_str(value).unwrap());
        }
        headers
    }

    #[test]
    fn only_names_of_the_loopback_interface_are_own() {
        let access = Access::new().unwrap();
        for host in ["localhost", "localhost:1", "LOCALHOST:80", "127.0.0.1:65535", "[::1]", "[::1]:8000"] {
            assert_eq!(access.check_site(&headers(&[("host", host)]), false), Ok(()), "{host}");
        }
        for host in [
            "",
            "evil.example",
            "localhost.evil.example",
            "127.0.0.1.evil.example:80",
            "127.0.0.2",
            "[::2]",
            "localhost:",
            "localhost:x",
            "localhost:123456",
            "::1",
            "0.0.0.0:80",
            "localhost@evil.example",
        ] {
            assert_eq!(access.check_site(&headers(&[("host", host)]), false), Err(Refusal::Host), "{host}");
        }
        assert_eq!(access.check_site(&headers(&[]), false), Err(Refusal::Host));
        assert_eq!(access.check_site(&headers(&[("host", "localhost"), ("host", "localhost")]), false), Err(Refusal::Host));
        let named = Access::new().unwrap().with_name("Viz.Example");
        assert_eq!(named.check_site(&headers(&[("host", "viz.example:9")]), false), Ok(()));
    }

    #[test]
    fn origins_are_the_host() {
        let access = Access::new().unwrap();
        let check = |host, origin, required| access.check_site(&headers(&[("host", host), ("origin", origin)]), required);
        assert_eq!(check("localhost:5", "http://localhost:5", true), Ok(()));
        for origin in ["http://localhost:6", "http://127.0.0.1:5", "https://localhost:5", "null", "http://evil.example", ""] {
            assert_eq!(check("localhost:5", origin, false), Err(Refusal::Origin), "{origin}");
        }
        // DNS rebinding: equal, and foreign.
        assert_eq!(check("evil.example:5", "http://evil.example:5", true), Err(Refusal::Host));
        assert_eq!(access.check_site(&headers(&[("host", "localhost")]), true), Err(Refusal::Origin));
    }

    #[test]
    fn cookies_and_tokens_are_those_of_the_run() {
        let (access, other) = (Access::new().unwrap(), Access::new().unwrap());
        let pair = access.set_cookie();
        let pair = pair.split(';').next().unwrap();
        assert_eq!(access.check_cookie(&headers(&[("cookie", &format!("a=b; {pair}"))])), Ok(()));
        assert_eq!(other.check_cookie(&headers(&[("cookie", pair)])), Err(Refusal::Cookie));
        let mut wrong = pair.to_owned();
        let last = if wrong.pop() == Some('0') { '1' } else { '0' };
        wrong.push(last);
        for cookie in [wrong.as_str(), &pair[..pair.len() - 1], "", "=", ";;"] {
            assert_eq!(access.check_cookie(&headers(&[("cookie", cookie)])), Err(Refusal::Cookie), "{cookie}");
        }
        assert_eq!(access.check_token(access.token()), Ok(()));
        for token in ["", &access.token()[1..], other.token(), &format!("{}0", access.token())] {
            assert_eq!(access.check_token(token), Err(Refusal::Token));
        }
        assert!(access.token().len() == 2 * TOKEN_BYTES && access.token() != access.cookie);
    }

    #[test]
    fn tokens_of_files_are_long_and_plain() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("token");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            Access::new().unwrap().with_token_file(&path)
        };
        let good = "0123456789abcdef0123456789abcdef";
        assert_eq!(read(&format!("{good}\n")).unwrap().token(), good);
        for bad in ["", "short", &format!("{good}&x=1"), &"a".repeat(257)] {
            assert!(read(bad).err().unwrap().to_string().contains("32 to 256"), "{bad}");
        }
    }
}
