//! Addresses on web servers. Their secrets, user info and queries with tokens, are kept apart from them: paths, messages, metadata and
//! copied commands have addresses without.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

const SCHEMES: [&str; 3] = ["https://", "http://", "s3://"];

/// The secrets of each address that had some. Addresses below it have them, too. A further one that differs in its secrets only has a mark at
/// its end, `#2` and so on, by which it is known here; servers get it without.
static SECRETS: Mutex<BTreeMap<String, Secrets>> = Mutex::new(BTreeMap::new());

/// What is sent to the server of an address, and shown to nobody.
#[derive(Clone, Default, PartialEq, Eq)]
pub struct Secrets {
    /// `NAME:PASSWORD`, percent-encoded.
    pub user: Option<String>,
    /// What follows `?`.
    pub query: Option<String>,
}

/// Whether a path is an address: `https://`, `http://` or `s3://`.
pub fn is_url(path: &Path) -> bool {
    path.to_str().is_some_and(|text| scheme(text).is_some())
}

/// The scheme that a text begins with, with `://`.
fn scheme(text: &str) -> Option<&'static str> {
    let begins = |scheme: &&str| text.get(..scheme.len()).is_some_and(|start| start.eq_ignore_ascii_case(scheme));
    SCHEMES.into_iter().find(begins)
}

/// The path without secrets, which are kept for [`sent`]. Other paths as they are.
pub fn public(path: &Path) -> Cow<'_, Path> {
    let Some((text, scheme)) = path.to_str().and_then(|text| Some((text, scheme(text)?))) else { return path.into() };
    match split(text, scheme, false) {
        Cow::Borrowed(_) => path.into(),
        Cow::Owned(address) => std::path::PathBuf::from(address).into(),
    }
}

/// An argument of a command without the secrets of the address in it: the address is all of it, or follows `=`. In `URL,KEY=VALUE`, with one of
/// these keys, the query ends at the comma.
pub fn public_argument(argument: OsString, keys: &[&str]) -> OsString {
    let Some(text) = argument.to_str() else { return argument };
    let starts = std::iter::once(0).chain(text.match_indices('=').map(|(at, _)| at + 1));
    let Some((start, scheme)) = starts.into_iter().find_map(|at| Some((at, scheme(&text[at..])?))) else { return argument };
    let url = &text[start..];
    let query = url.find('?').unwrap_or(url.len());
    let is_key =
        |rest: &str| rest.split_once('=').is_some_and(|(key, _)| keys.contains(&&*key.trim().to_lowercase().replace('_', "-")));
    let ends = url[query..].match_indices(',').map(|(comma, _)| query + comma);
    let end = ends.into_iter().find(|comma| is_key(&url[comma + 1..])).unwrap_or(url.len());
    format!("{}{}{}", &text[..start], split(&url[..end], scheme, true), &url[end..]).into()
}

/// What is wrong with the server that an address names, if anything.
pub fn problem(address: &Path) -> Option<&'static str> {
    let (text, _) = sent(address.to_str()?);
    let after = &text[scheme(&text)?.len()..];
    let authority = &after[..after.find('/').unwrap_or(after.len())];
    (!is_server(authority)).then_some(
        "the address has no server, or no port from 0 to 65535; in a user's name and password, / is written %2F, ? %3F and # %23, and \
         after a port, @ is written %40",
    )
}

/// Whether this is a host, with or without a port.
fn is_server(text: &str) -> bool {
    // An address of IPv6 is in brackets.
    let (host, rest) = text.rfind(']').map_or(("", text), |end| text.split_at(end + 1));
    let (name, port) = rest.split_once(':').map_or((rest, None), |(name, port)| (name, Some(port)));
    !(host.is_empty() && name.is_empty()) && port.is_none_or(|port| port.parse::<u16>().is_ok())
}

/// What servers get of an address: without its mark, and its secrets, or those of one above it.
pub fn sent(address: &str) -> (Cow<'_, str>, Secrets) {
    let all = SECRETS.lock().unwrap_or_else(PoisonError::into_inner);
    // The last in order is the longest.
    match all.iter().rev().find(|(base, _)| is_at_or_below(address, base)) {
        Some((base, secrets)) => match base.split_once('#') {
            Some((unmarked, _)) => (format!("{unmarked}{}", &address[base.len()..]).into(), secrets.clone()),
            None => (address.into(), secrets.clone()),
        },
        None => (address.into(), Secrets::default()),
    }
}

/// Whether an address is another one, or below it.
fn is_at_or_below(address: &str, base: &str) -> bool {
    address.strip_prefix(base).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
}

/// Keeps the secrets of an address, and returns it without. `is_given`: as a user wrote it; others may be without their secrets already.
fn split<'a>(url: &'a str, scheme: &str, is_given: bool) -> Cow<'a, str> {
    let mut all = SECRETS.lock().unwrap_or_else(PoisonError::into_inner);
    if all.keys().any(|base| base.contains('#') && is_at_or_below(url, base)) {
        return url.into();
    }
    let (rest, _fragment) = url.split_once('#').unwrap_or((url, ""));
    let (address, query) = rest.split_once('?').map_or((rest, None), |(address, query)| (address, Some(query)));
    let address = address.trim_end_matches('/');
    let after = &address[scheme.len().min(address.len())..];
    let (authority, path) = after.split_at(after.find('/').unwrap_or(after.len()));
    let (user, host) = authority.rsplit_once('@').map_or((None, authority), |(user, host)| (Some(user), host));
    // A password with one of / ? # looks like that, also if what is before is a number: nothing is shown of it, and the rest is refused.
    let has_port = host.rsplit(']').next().is_some_and(|rest| rest.contains(':'));
    if user.is_none() && (!is_server(host) || has_port && after[authority.len()..].contains('@')) {
        return scheme.to_owned().into();
    }
    let mut public = format!("{scheme}{host}{path}");
    if public == url && !is_given {
        return url.into();
    }
    let secrets = Secrets { user: user.map(Into::into), query: query.filter(|query| !query.is_empty()).map(Into::into) };
    // One without secrets gets none of the same address with some.
    let is_known = all.keys().any(|base| *base != public && is_at_or_below(&public, base));
    if secrets != Secrets::default() || is_given && !is_known {
        let (unmarked, mut number) = (public.len(), 1);
        while all.get(&public).is_some_and(|known| *known != secrets) {
            number += 1;
            public.truncate(unmarked);
            public.push_str(&format!("#{number}"));
        }
        all.insert(public.clone(), secrets);
    }
    public.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_known_by_their_scheme() {
        for url in ["https://h/x.zarr", "HTTP://h", "s3://bucket/key"] {
            assert!(is_url(Path::new(url)), "{url}");
        }
        for path in ["file://x", "ftp://h/x", "a/https://h", "https:/h", "x.zarr", "s3:", "builtin:cube"] {
            assert!(!is_url(Path::new(path)), "{path}");
            assert_eq!(public(Path::new(path)), Path::new(path));
        }
    }

    #[test]
    fn secrets_leave_the_address_and_are_found_below_it() {
        let shown = public(Path::new("https://me:pass@Host.org/one/a.zarr/?token=T&x=a/b#part")).into_owned();
        assert_eq!(shown.to_str(), Some("https://Host.org/one/a.zarr"));
        let expected = Secrets { user: Some("me:pass".into()), query: Some("token=T&x=a/b".into()) };
        for below in ["https://Host.org/one/a.zarr", "https://Host.org/one/a.zarr/0/c/1"] {
            assert!(sent(below).1 == expected, "{below}");
        }
        for other in ["https://Host.org/one/a.zarr2", "https://Host.org/one", "http://Host.org/one/a.zarr", "https://Host.org"] {
            assert!(sent(other).1 == Secrets::default(), "{other}");
        }
        // An @ in the path is no user.
        assert_eq!(public(Path::new("https://h/a@b.zarr")), Path::new("https://h/a@b.zarr"));
        assert_eq!(public(Path::new("s3://bucket/a.zarr")), Path::new("s3://bucket/a.zarr"));
    }

    #[test]
    fn addresses_without_secrets_get_none_of_the_same_with_some() {
        let given = |text: &str| public_argument(text.into(), &[]).into_string().unwrap();
        let query = |text: &str| sent(text).1.query;
        let (with, without) = (given("https://one.org/x?t=A"), given("https://one.org/x"));
        assert_eq!((query(&with), query(&without), &*sent(&without).0), (Some("t=A".into()), None, "https://one.org/x"));
        let (without, with) = (given("https://two.org/x"), given("https://two.org/x?t=A"));
        assert_eq!((query(&with), query(&without), &*sent(&with).0), (Some("t=A".into()), None, "https://two.org/x"));
        // What is below an address has its secrets.
        given("https://three.org/x?t=A");
        assert_eq!(query(&given("https://three.org/x/labels")), Some("t=A".into()));
    }

    #[test]
    fn addresses_name_a_server() {
        for right in ["http://h", "https://h:8080/a:b", "http://[::1]/x", "http://[::1]:80", "s3://bucket/key", "x.zarr"] {
            assert_eq!(problem(&public(Path::new(right))), None, "{right}");
        }
        for wrong in
            ["http://", "s3://", "s3:///key", "http://h:99999/x", "http://u:p@h:99999/x", "http://u:p@/x", "http://:80/x"]
        {
            assert!(problem(&public(Path::new(wrong))).is_some(), "{wrong}");
        }
        for mark in ["/", "?", "#"] {
            let address = format!("http://me:se{mark}cret@h/a.zarr");
            assert_eq!(public(Path::new(&address)), Path::new("http://"));
            assert_eq!(public_argument(format!("--mask={address}").into(), &[]), "--mask=http://");
        }
        for hidden in ["http://me:123/45@h/a.zarr", "http://me:123/4?5@h/a.zarr", "http://me:1#5@h/a.zarr"] {
            let shown = public(Path::new(hidden)).into_owned();
            assert!(!shown.to_str().unwrap().contains('5'), "{hidden}: {}", shown.display());
        }
        assert_eq!(public(Path::new("http://h:80/a%40b")), Path::new("http://h:80/a%40b"));
    }

    #[test]
    fn arguments_lose_secrets_wherever_the_address_is() {
        for (argument, expected) in [
            ("https://u:p@two.org/a?t=1", "https://two.org/a"),
            ("--labels=https://two.org/b?t=1", "--labels=https://two.org/b"),
            ("https://two.org/c?t=1,transfer=hot,range=0,1", "https://two.org/c,transfer=hot,range=0,1"),
            ("https://two.org/a,b?t", "https://two.org/a,b"),
            ("https://two.org/d?t=1,2,transfers=3,RANGE=0,1", "https://two.org/d,RANGE=0,1"),
            ("--size=3x4", "--size=3x4"),
            ("what?", "what?"),
        ] {
            assert_eq!(public_argument(argument.into(), &["transfer", "range"]), expected, "{argument}");
        }
    }
}
