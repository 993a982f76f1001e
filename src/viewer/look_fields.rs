//! The part of a look that several fields and labels have.

use super::look::Look;
use crate::error::Error;
use crate::image::Background;
use crate::renderer::Channel;
use crate::volume::LabelChange;
use serde::{Deserialize, Serialize};

/// Most labels in a list of a page.
const MOST_LABELS: usize = 4096;
/// Longest name of a label in bytes.
const LONGEST_NAME: usize = 200;
/// Largest factor of an extinction.
const LARGEST_FACTOR: f64 = 1e6;

/// How one of several fields is shown.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct PageChannel {
    /// Whether it is drawn.
    pub visible: bool,
    /// Factor of its extinction, 0 … 1e6.
    pub factor: f64,
    /// Its colour in lists and legends, `#rrggbb`. The colours of the picture are those of the transfer function.
    pub color: String,
}

/// What a page has changed of the looks of labels. They are named as options of the command name them: by their ids, or, where layers have
/// the same id, by their names.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct PageLabels {
    /// If it is not empty: the labels that are drawn, and no others.
    pub only: Vec<String>,
    /// Labels that are not drawn.
    pub hidden: Vec<String>,
    /// Labels with another colour, `#rrggbb`.
    pub colors: Vec<(String, String)>,
}

impl Look {
    /// How each of several fields is shown.
    ///
    /// # Errors
    /// If the look is that of another number of fields.
    pub(super) fn channels_of(&self, count: usize) -> Result<&[PageChannel], Error> {
        if self.channels.len() == count {
            return Ok(&self.channels);
        }
        let value = format!("{} channels", self.channels.len());
        Err(Error::OutOfRange { name: "channels", value, expected: "as many as the page was told" })
    }

    /// Checks channels and labels.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for too many, factors that are none, and unknown colours.
    pub(super) fn check_fields(&self) -> Result<(), Error> {
        let refuse = |name, value: String, expected| Err(Error::OutOfRange { name, value, expected });
        if self.channels.len() > Channel::MOST {
            return refuse("channels", self.channels.len().to_string(), "at most 8 channels");
        }
        for channel in &self.channels {
            channel.color()?;
            if !(0.0..=LARGEST_FACTOR).contains(&channel.factor) {
                return refuse("factor", channel.factor.to_string(), "a number from 0 to 1000000");
            }
        }
        let PageLabels { only, hidden, colors } = &self.labels;
        if only.len().max(hidden.len()).max(colors.len()) > MOST_LABELS {
            return refuse("labels", "a list of more".into(), "at most 4096 labels in a list");
        }
        let named = colors.iter().map(|(label, _)| label).chain(only).chain(hidden);
        if let Some(label) = named.into_iter().find(|label| !is_name(label)) {
            return refuse("labels", label.chars().take(20).collect(), "ids and names without commas and colons");
        }
        colors.iter().try_for_each(|(_, color)| color_of(color).map(drop))
    }
}

impl PageChannel {
    /// Red, green and blue, 0 … 1.
    ///
    /// # Errors
    /// If it is no colour.
    pub fn color(&self) -> Result<[f64; 3], Error> {
        color_of(&self.color)
    }
}

impl PageLabels {
    /// The changes as options of the command write them.
    pub fn words(&self) -> Vec<String> {
        let colors = self.colors.iter().map(|(label, color)| format!("{label}:{color}"));
        let only = (!self.only.is_empty()).then(|| format!("{}:only", self.only.join(",")));
        let hidden = (!self.hidden.is_empty()).then(|| format!("{}:hide", self.hidden.join(",")));
        colors.chain(only).chain(hidden).collect()
    }

    /// The changes of labels.
    ///
    /// # Errors
    /// For colours that are none.
    pub(super) fn changes(&self) -> Result<Vec<LabelChange>, Error> {
        self.words().iter().map(|word| word.parse()).collect()
    }
}

/// Whether a list of labels can have this name between others.
pub(super) fn is_name(text: &str) -> bool {
    let is_plain = |c: char| !c.is_control() && c != ',' && c != ':';
    !text.is_empty() && text.len() <= LONGEST_NAME && text.trim() == text && text.chars().all(is_plain)
}

/// Components of `#rrggbb`, 0 … 1.
fn color_of(text: &str) -> Result<[f64; 3], Error> {
    match text.parse() {
        Ok(Background::Color(color)) if text.len() == 7 && text.starts_with('#') => Ok(color.map(f64::from)),
        _ => {
            let value = text.chars().take(20).collect();
            Err(Error::OutOfRange { name: "color", value, expected: "#rrggbb" })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;
    use crate::volume::LabelVisibility;

    fn look(factor: f64, color: &str) -> Look {
        let channel = PageChannel { visible: true, factor, color: color.into() };
        Look { channels: vec![channel; 2], ..Look::of(&Settings::default(), Background::BLACK, 0.0, [4; 3]) }
    }

    #[test]
    fn channels_and_labels_are_checked() {
        assert!(look(2.0, "#ff8000").check().is_ok() && look(2.0, "#ff8000").channels_of(3).is_err());
        for bad in [look(-1.0, "#ff8000"), look(f64::NAN, "#ff8000"), look(f64::INFINITY, "#ff8000"), look(1.0, "red")] {
            assert!(bad.check().is_err(), "{bad:?}");
        }
        let many = PageLabels { hidden: vec!["1".into(); MOST_LABELS + 1], ..PageLabels::default() };
        assert!(Look { labels: many, ..look(1.0, "#000000") }.check().is_err());
        let pink = PageLabels { colors: vec![("3".into(), "pink".into())], ..PageLabels::default() };
        assert!(Look { labels: pink, ..look(1.0, "#000000") }.check().is_err());
        for name in ["a,b", "a:hide", " a", "", &"a".repeat(999)] {
            let named = PageLabels { hidden: vec![name.into()], ..PageLabels::default() };
            assert!(Look { labels: named, ..look(1.0, "#000000") }.check().is_err(), "{name}");
        }
    }

    #[test]
    fn changes_of_labels_are_those_of_the_command() {
        let labels = PageLabels {
            only: vec!["3".into(), "rib".into()],
            hidden: vec!["rib".into()],
            colors: vec![("3".into(), "#ff0000".into())],
        };
        assert_eq!(labels.words(), ["3:#ff0000", "3,rib:only", "rib:hide"]);
        let changes = labels.changes().unwrap();
        assert_eq!(changes[0].color, Some([1.0, 0.0, 0.0]));
        assert_eq!(changes[1].visibility, Some(LabelVisibility::Only));
        assert!(PageLabels::default().words().is_empty());
    }
}
