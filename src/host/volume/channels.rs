//! Names, colours and windows of the channels of a file.

use super::OpenOptions;
use super::{Contents, colors, format};
use crate::error::Error;
use std::path::Path;

/// Names of fluorophores and stains, as they occur in names of channels in lower case without separators, and the colours in which they
/// are usually shown: about that of their light. Longer names come before those that they contain.
const FLUOROPHORES: [(&str, [f64; 3]); 46] = [
    ("alexa350", BLUE),
    ("alexa405", BLUE),
    ("alexa488", GREEN),
    ("alexa532", YELLOW),
    ("alexa546", ORANGE),
    ("alexa555", ORANGE),
    ("alexa568", RED),
    ("alexa594", RED),
    ("alexa633", MAGENTA),
    ("alexa647", MAGENTA),
    ("alexa660", MAGENTA),
    ("alexa680", MAGENTA),
    ("af488", GREEN),
    ("af546", ORANGE),
    ("af555", ORANGE),
    ("af568", RED),
    ("af594", RED),
    ("af647", MAGENTA),
    ("atto488", GREEN),
    ("atto550", ORANGE),
    ("atto594", RED),
    ("atto647", MAGENTA),
    ("dapi", BLUE),
    ("hoechst", BLUE),
    ("draq5", MAGENTA),
    ("fitc", GREEN),
    ("egfp", GREEN),
    ("gcamp", GREEN),
    ("gfp", GREEN),
    ("ecfp", CYAN),
    ("cfp", CYAN),
    ("bfp", BLUE),
    ("yfp", YELLOW),
    ("venus", YELLOW),
    ("tritc", ORANGE),
    ("rhodamine", ORANGE),
    ("texasred", RED),
    ("mcherry", RED),
    ("tdtomato", RED),
    ("dsred", RED),
    ("mkate", RED),
    ("rfp", RED),
    ("cy2", GREEN),
    ("cy3", ORANGE),
    ("cy5", MAGENTA),
    ("cy7", MAGENTA),
];
/// Limit of channels that are described.
const MOST: usize = 1 << 16;
const BLUE: [f64; 3] = [0.1, 0.3, 1.0];
const CYAN: [f64; 3] = [0.0, 1.0, 1.0];
const GREEN: [f64; 3] = [0.0, 1.0, 0.0];
const YELLOW: [f64; 3] = [1.0, 1.0, 0.0];
const ORANGE: [f64; 3] = [1.0, 0.55, 0.0];
const RED: [f64; 3] = [1.0, 0.1, 0.0];
/// Far red light is shown as magenta, which differs from red.
const MAGENTA: [f64; 3] = [1.0, 0.0, 1.0];

/// What a file states about a channel.
///
/// ```
/// use layersplat::volume::{ChannelDescription, OpenOptions};
///
/// let channels = ChannelDescription::of_file("builtin:cube@8", &OpenOptions::default())?;
/// assert_eq!(channels, [ChannelDescription::default()]);
/// let named = |name: &str| ChannelDescription { name: Some(name.into()), ..ChannelDescription::default() };
/// let colors = ChannelDescription::colors(&[named("c1: Alexa Fluor 488"), named("DAPI"), named("other")]);
/// assert_eq!(colors, [[0.0, 1.0, 0.0], [0.1, 0.3, 1.0], [1.0, 0.0, 1.0]]);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelDescription {
    /// Name.
    pub name: Option<String>,
    /// Red, green and blue of the brightest value, 0 to 1.
    pub color: Option<[f64; 3]>,
    /// Data values that are shown black and in full colour, ascending.
    pub window: Option<(f64, f64)>,
    /// Whether it is shown at first.
    pub active: bool,
}

impl Default for ChannelDescription {
    fn default() -> Self {
        Self { name: None, color: None, window: None, active: true }
    }
}

impl ChannelDescription {
    /// Name of an opacity by which colours are multiplied in a file.
    #[doc(hidden)]
    pub const ASSOCIATED_ALPHA: &str = "associated alpha";

    /// What a file states about each of its channels: OME-Zarr's `omero`, OME-XML in TIFF, and ImageJ's TIFF. Components of colours are
    /// named red, green, blue and alpha. No voxels are read.
    ///
    /// # Errors
    /// As [`Volume::open`](super::Volume::open), as far as headers show; [`Error::Volume`] if the metadata of channels are malformed.
    pub fn of_file(source: impl AsRef<Path>, options: &OpenOptions) -> Result<Vec<Self>, Error> {
        let path = source.as_ref();
        if path.to_str().is_some_and(|name| name.starts_with("builtin:")) {
            return Ok(vec![Self::default()]);
        }
        let contents = Contents::of_file(path, options)?;
        let count = contents.channels;
        let (frame, channel) = (options.frame.or(Some(0)), options.channel.or(Some(0)));
        let options = OpenOptions { frame, channel, channel_name: None, ..options.clone() };
        if count > MOST {
            return Err(Error::volume(path, format!("it has {count} channels: more than {MOST} cannot be described")));
        }
        let mut found = format::channels(path, &options, &contents)?;
        found.resize(count, Self::default());
        Ok(found)
    }

    /// A color for each channel: the declared one; else by the name of a fluorophore in its name; else one that is well separated from those
    /// before it, also for the colour-blind, in the order green, magenta, cyan, yellow, red, blue. A single channel is white.
    pub fn colors(channels: &[Self]) -> Vec<[f64; 3]> {
        if let [Self { name, color, .. }] = channels {
            return vec![color.or(name.as_deref().and_then(of_fluorophore)).unwrap_or([1.0; 3])];
        }
        let known = |channel: &Self| channel.color.or_else(|| channel.name.as_deref().and_then(of_fluorophore));
        let taken: Vec<[f64; 3]> = channels.iter().filter_map(known).collect();
        // Each of the candidates is a different colour, so one of them is left for each channel.
        let mut free = (0..=channels.len() + taken.len()).map(colors::of_channel).filter(|candidate| !taken.contains(candidate));
        channels.iter().map(|channel| known(channel).or_else(|| free.next()).unwrap_or([1.0; 3])).collect()
    }

    /// Number of the channel of a file that has a name, by upper and lower case only if several differ in nothing else.
    ///
    /// # Errors
    /// [`Error::Settings`], which lists the names that there are.
    #[doc(hidden)]
    pub fn named(channels: &[Self], name: &str, path: &Path) -> Result<usize, Error> {
        let find = |is_same: &dyn Fn(&str) -> bool| {
            let found = channels.iter().enumerate().filter(|(_, channel)| channel.name.as_deref().is_some_and(is_same));
            found.map(|(number, _)| number).collect::<Vec<_>>()
        };
        let exact = find(&|other| other == name);
        let found = if exact.is_empty() { find(&|other| other.to_lowercase() == name.to_lowercase()) } else { exact };
        let names: Vec<&str> = channels.iter().filter_map(|channel| channel.name.as_deref()).collect();
        let problem = match found[..] {
            [number] => return Ok(number),
            [] if names.is_empty() => {
                format!("'{name}' is no channel of {}, which names none: use a number from 0", path.display())
            }
            [] => format!("'{name}' is not in {}, whose channels are {}", path.display(), names.join(", ")),
            _ => format!("several channels of {} are called '{name}': use a number from 0", path.display()),
        };
        Err(Error::Settings { field: "channel", problem })
    }

    /// Components of colours, which have no names in files.
    pub(super) fn of_components(count: usize) -> Vec<Self> {
        let named = |name: &str, color: Option<[f64; 3]>| Self { name: Some(name.into()), color, ..Self::default() };
        let colors = [named("red", Some([1.0, 0.0, 0.0])), named("green", Some(GREEN)), named("blue", Some([0.0, 0.0, 1.0]))];
        let alpha = Self { active: false, ..named("alpha", None) };
        match count {
            3 => colors.into(),
            4 => colors.into_iter().chain([alpha]).collect(),
            _ => Vec::new(),
        }
    }
}

/// The colour of a fluorophore whose name a text contains.
fn of_fluorophore(text: &str) -> Option<[f64; 3]> {
    let letters: String = text.to_lowercase().chars().filter(|c| c.is_alphanumeric()).collect();
    let letters = letters.replace("alexafluor", "alexa");
    FLUOROPHORES.iter().find(|(name, _)| letters.contains(name)).map(|(_, color)| *color)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(name: &str) -> ChannelDescription {
        ChannelDescription { name: Some(name.into()), ..ChannelDescription::default() }
    }

    #[test]
    fn fluorophores_have_their_colours() {
        for (name, color) in [
            ("DAPI", BLUE),
            ("Hoechst 33342", BLUE),
            ("EGFP", GREEN),
            ("anti-GFP (FITC)", GREEN),
            ("AlexaFluor-488", GREEN),
            ("Alexa 546", ORANGE),
            ("Alexa Fluor 594", RED),
            ("ALEXA647", MAGENTA),
            ("Cy3", ORANGE),
            ("Cy-5", MAGENTA),
            ("TRITC", ORANGE),
            ("Texas Red", RED),
            ("mCherry", RED),
            ("H2B-RFP", RED),
        ] {
            assert_eq!(of_fluorophore(name), Some(color), "{name}");
        }
        assert_eq!((of_fluorophore("brightfield"), of_fluorophore("")), (None, None));
    }

    #[test]
    fn channels_without_a_colour_get_one_that_is_left() {
        let none = ChannelDescription::default();
        let all = ChannelDescription::colors(&[none.clone(), named("GFP"), none.clone(), named("Cy5"), none.clone()]);
        assert_eq!(all, [CYAN, GREEN, YELLOW, MAGENTA, colors::of_channel(4)]);
        let many = ChannelDescription::colors(&vec![none.clone(); 20]);
        assert!((0..20).all(|n| !many[..n].contains(&many[n])));
        assert_eq!(ChannelDescription::colors(&[none]), [[1.0; 3]]);
        let declared = ChannelDescription { color: Some([0.5; 3]), ..named("GFP") };
        assert_eq!(ChannelDescription::colors(&[declared, named("GFP")]), [[0.5; 3], GREEN]);
    }
}
