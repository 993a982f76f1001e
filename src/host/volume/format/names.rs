//! Channels and times that the names of slices number, as microscopes write them: `_c1`, `_ch00`, `_w1DAPI`, `_z000_c1_t2`.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Words before the numbers of channels and of times, longer ones before those that begin them.
const CHANNEL: [&str; 4] = ["channel", "ch", "c", "w"];
const TIME: [&str; 3] = ["time", "tp", "t"];

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Axis {
    Channel,
    Time,
}

/// A number in a name.
#[derive(Debug, PartialEq)]
struct Token {
    axis: Axis,
    number: u64,
    /// What follows the number, as `DAPI` in `w1DAPI`.
    text: String,
    /// Its bytes in the name.
    range: Range<usize>,
}

/// Slices of channels and times.
#[derive(Debug, PartialEq)]
pub(super) struct Numbered {
    /// Names of the channels.
    pub channels: Vec<Option<String>>,
    pub times: usize,
    /// The slices of each time and channel: those of all channels of the first time, then those of the second.
    slices: Vec<Vec<PathBuf>>,
}

impl Numbered {
    /// Sorts slices, whose order is that of their other numbers, by channels and times. `None` if their names number neither.
    ///
    /// # Errors
    /// If a slice of some channel or time is missing.
    pub fn new(files: &[PathBuf]) -> Result<Option<Self>, String> {
        let names: Vec<String> = files.iter().map(|file| name(file)).collect();
        let tokens: Vec<Vec<Token>> = names.iter().map(|name| tokens(name)).collect();
        let [channel, time] = [varying(&tokens, Axis::Channel)?, varying(&tokens, Axis::Time)?];
        if channel.is_none() && time.is_none() {
            return Ok(None);
        }
        let mut found: BTreeMap<(u64, u64), BTreeMap<String, PathBuf>> = BTreeMap::new();
        let (mut texts, mut order, mut seen) = (BTreeMap::<u64, String>::new(), Vec::new(), BTreeSet::new());
        for ((file, name), tokens) in files.iter().zip(&names).zip(&tokens) {
            let of =
                |axis, place: Option<usize>| place.and_then(|place| tokens.iter().filter(|token| token.axis == axis).nth(place));
            let (channel, time) = (of(Axis::Channel, channel), of(Axis::Time, time));
            let number = |token: Option<&Token>| token.map_or(0, |token| token.number);
            let mut rest = name.clone();
            let mut ranges: Vec<&Range<usize>> = [channel, time].into_iter().flatten().map(|token| &token.range).collect();
            ranges.sort_by_key(|range| range.start);
            ranges.into_iter().rev().for_each(|range| rest.replace_range(range.clone(), ""));
            channel.into_iter().for_each(|token| drop(texts.insert(token.number, token.text.clone())));
            if seen.insert(rest.clone()) {
                order.push(rest.clone());
            }
            let slices = found.entry((number(time), number(channel))).or_default();
            if let Some(other) = slices.insert(rest, file.clone()) {
                return Err(format!("{} and {} number the same slice, channel and time", other.display(), file.display()));
            }
        }
        let numbers = |of: fn(&(u64, u64)) -> u64| found.keys().map(of).collect::<BTreeSet<u64>>();
        let (times, channels) = (numbers(|key| key.0), numbers(|key| key.1));
        let mut slices = Vec::new();
        for time in &times {
            for channel in &channels {
                let of = found.get_mut(&(*time, *channel));
                let all: Option<Vec<PathBuf>> = of.and_then(|of| order.iter().map(|rest| of.remove(rest)).collect());
                slices.push(all.ok_or_else(|| {
                    format!(
                        "the names of its slices number channels and times, and some of channel {channel} and time {time} are missing: \
                         add them, or select slices with NAME%d.EXTENSION"
                    )
                })?);
            }
        }
        let channels = channels.iter().map(|n| texts.get(n).filter(|text| !text.is_empty()).cloned()).collect();
        Ok(Some(Self { channels, times: times.len(), slices }))
    }

    /// The slices of a time and a channel.
    pub fn slices(&self, time: usize, channel: usize) -> &[PathBuf] {
        &self.slices[time * self.channels.len() + channel]
    }
}

/// Name without its extension.
fn name(file: &Path) -> String {
    file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Which of the numbers of an axis differs between names; `None` if none does.
fn varying(tokens: &[Vec<Token>], axis: Axis) -> Result<Option<usize>, String> {
    let of = |tokens: &[Token]| tokens.iter().filter(|token| token.axis == axis).map(|token| token.number).collect::<Vec<_>>();
    let numbers: Vec<Vec<u64>> = tokens.iter().map(|tokens| of(tokens)).collect();
    let Some(first) = numbers.first().filter(|first| numbers.iter().all(|other| other.len() == first.len())) else {
        return Ok(None);
    };
    let differs = |place: &usize| numbers.iter().any(|other| other[*place] != first[*place]);
    let differing: Vec<usize> = (0..first.len()).filter(differs).collect();
    match differing[..] {
        [] => Ok(None),
        [place] => Ok(Some(place)),
        _ => Err("the names of its slices have several numbers of channels or times: select slices with NAME%d.EXTENSION".into()),
    }
}

/// Numbers of channels and times: after a separator or a digit.
fn tokens(name: &str) -> Vec<Token> {
    let bytes = name.as_bytes();
    let (mut found, mut at) = (Vec::new(), 0);
    while at < bytes.len() {
        let begins = at == 0 || matches!(bytes[at - 1], b'_' | b'-' | b'.' | b' ' | b'0'..=b'9');
        let token = if begins { token(name, at) } else { None };
        at = token.as_ref().map_or(at + 1, |token| token.range.end);
        found.extend(token);
    }
    found
}

fn token(name: &str, at: usize) -> Option<Token> {
    let words = CHANNEL.map(|word| (word, Axis::Channel)).into_iter().chain(TIME.map(|word| (word, Axis::Time)));
    for (word, axis) in words {
        let Some(behind) = name.get(at..at + word.len()).filter(|text| text.eq_ignore_ascii_case(word)).map(|_| at + word.len())
        else {
            continue;
        };
        let digits = name[behind..].bytes().take_while(u8::is_ascii_digit).count();
        let Some(number) = name[behind..behind + digits].parse().ok() else { continue };
        let mut end = behind + digits;
        // Only wavelengths are followed by names.
        let text = if word == "w" { name[end..].split('_').next().unwrap_or_default() } else { "" };
        end += text.len();
        return Some(Token { axis, number, text: text.into(), range: at..end });
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sorted(names: &[&str]) -> Result<Option<Numbered>, String> {
        Numbered::new(&names.iter().map(PathBuf::from).collect::<Vec<_>>())
    }

    #[test]
    fn names_number_channels_and_times() {
        let numbers =
            |name: &str| tokens(name).into_iter().map(|token| (token.axis, token.number, token.text)).collect::<Vec<_>>();
        let channel = |n, text: &str| (Axis::Channel, n, text.to_owned());
        let time = |n| (Axis::Time, n, String::new());
        assert_eq!(numbers("a_z000_c1_t2"), [channel(1, ""), time(2)]);
        assert_eq!(numbers("img_channel001_position000_time000000002_z003"), [channel(1, ""), time(2)]);
        assert_eq!(numbers("exp_w1DAPI_s1_t3"), [channel(1, "DAPI"), time(3)]);
        assert_eq!(numbers("Series 1 z07ch02"), [channel(2, "")]);
        assert_eq!(numbers("t3c4"), [time(3), channel(4, "")]);
        for other in ["scan0001", "rec_ct001", "slice_12", "c", "cat1", "microct1", "é_ç1", ""] {
            assert_eq!(numbers(other), [], "{other}");
        }
    }

    #[test]
    fn slices_are_sorted_by_channel_and_time() {
        let mut names = Vec::new();
        for z in 8..11 {
            for (c, t) in [(1, 0), (2, 0), (1, 5), (2, 5)] {
                names.push(format!("a_z{z}_c{c}_t{t}.tif"));
            }
        }
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let found = sorted(&names).unwrap().unwrap();
        assert_eq!((found.channels.len(), found.times), (2, 2));
        let expected = ["a_z8_c2_t5.tif", "a_z9_c2_t5.tif", "a_z10_c2_t5.tif"].map(PathBuf::from);
        assert_eq!(found.slices(1, 1), expected);
        assert!(sorted(&names[1..]).unwrap_err().contains("some of channel 1 and time 0 are missing"));
        let named = sorted(&["a_w1DAPI_1.tif", "a_w2GFP_1.tif"]).unwrap().unwrap();
        assert_eq!(named.channels, [Some("DAPI".into()), Some("GFP".into())]);
        assert_eq!((sorted(&["a_c1_1.png", "a_c1_2.png"]), sorted(&["s1.png", "s2.png"])), (Ok(None), Ok(None)));
        assert!(sorted(&["r01c01ch1.tif", "r01c02ch2.tif"]).unwrap_err().contains("several numbers of channels"));
    }
}
