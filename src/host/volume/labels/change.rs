//! Changes of chosen labels: `3,7-9:#ff0000:0.4`.

use super::{Label, LabelTable};
use crate::error::Error;
use crate::volume::colors;
use std::collections::BTreeSet;
use std::str::FromStr;

/// Share of their opacity that labels keep while others are highlighted.
const FAINT: f64 = 0.1;
/// Least Jaro–Winkler similarity of names that are suggested.
const SIMILAR: f64 = 0.8;
/// Names that a message lists.
const LISTED: usize = 8;

/// A change of chosen labels. The text form is `WHICH[:COLOR][:OPACITY][:show|hide|only|highlight]`, with at least one change. `WHICH` is a
/// list of ids, ranges of ids and names, separated by commas; case does not matter. `COLOR` is `#rrggbb`, `OPACITY` 0 to 1.
///
/// ```
/// use layersplat::volume::{Label, LabelChange, LabelTable};
///
/// let mut table = LabelTable::new([3, 7, 8, 40].map(Label::new))?;
/// let change: LabelChange = "3,7-9:#ff0000:0.4:only".parse()?;
/// table.change(&change)?;
/// let drawn: Vec<u32> = table.labels().iter().filter(|label| label.visible).map(|label| label.id).collect();
/// assert_eq!(drawn, [3, 7, 8]);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LabelChange {
    /// Ids, ranges of ids and names, separated by commas. A name that has commas itself stands alone.
    pub which: String,
    /// New colour, 0 to 1.
    pub color: Option<[f64; 3]>,
    /// New opacity, 0 to 1.
    pub opacity: Option<f64>,
    /// New visibility, which may concern other labels too.
    pub visibility: Option<LabelVisibility>,
}

/// Visibility of chosen labels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LabelVisibility {
    /// Draw them.
    Show,
    /// Do not draw them.
    Hide,
    /// Draw them, and no others.
    Only,
    /// Draw them, and all others at a tenth of their opacity.
    Highlight,
}

impl LabelVisibility {
    fn from_word(word: &str) -> Option<Self> {
        match word {
            "show" => Some(Self::Show),
            "hide" => Some(Self::Hide),
            "only" => Some(Self::Only),
            "highlight" => Some(Self::Highlight),
            _ => None,
        }
    }
}

impl FromStr for LabelChange {
    type Err = Error;

    /// # Errors
    /// [`Error::Settings`] if the text has no labels, no change, or an invalid or repeated one.
    fn from_str(text: &str) -> Result<Self, Error> {
        let wrong = |why: &str| {
            let problem = format!(
                "invalid change '{text}', {why}; use IDS[:COLOR][:OPACITY][:show|hide|only|highlight], e.g. 3,7-9:#ff0000:0.4, liver:hide"
            );
            Error::Settings { field: "label", problem }
        };
        let mut change = Self { which: String::new(), color: None, opacity: None, visibility: None };
        let mut rest = text;
        while let Some((before, word)) = rest.rsplit_once(':') {
            let word = word.trim();
            let is_repeated = if word.starts_with('#') {
                let color = colors::from_hex(word).ok_or_else(|| wrong("whose colour is not #rrggbb"))?;
                change.color.replace(color).is_some()
            } else if let Ok(opacity) = word.parse::<f64>() {
                if !(0.0..=1.0).contains(&opacity) {
                    return Err(wrong("whose opacity is not 0 to 1"));
                }
                change.opacity.replace(opacity).is_some()
            } else if let Some(visibility) = LabelVisibility::from_word(word) {
                change.visibility.replace(visibility).is_some()
            } else {
                // Names may have colons.
                break;
            };
            if is_repeated {
                return Err(wrong("which says one thing twice"));
            }
            rest = before;
        }
        change.which = rest.trim().into();
        if change.which.is_empty() {
            return Err(wrong("which names no labels"));
        }
        if change.color.is_none() && change.opacity.is_none() && change.visibility.is_none() {
            return Err(wrong("which changes nothing"));
        }
        Ok(change)
    }
}

impl LabelTable {
    /// Changes the chosen labels.
    ///
    /// # Errors
    /// [`Error::UnknownName`] or [`Error::Settings`] if the table lacks a chosen name or id, or has none of a range;
    /// [`Error::OutOfRange`] for colours and opacities outside 0 to 1.
    pub fn change(&mut self, change: &LabelChange) -> Result<(), Error> {
        change_all(&mut [self], change)
    }
}

/// Changes the chosen labels of several tables, each of which may lack some of them.
pub(super) fn change_all(tables: &mut [&mut LabelTable], change: &LabelChange) -> Result<(), Error> {
    let numbers = change.color.iter().flatten().chain(&change.opacity);
    if let Some(bad) = numbers.into_iter().find(|n| !(0.0..=1.0).contains(*n)) {
        return Err(Error::OutOfRange { name: "label", value: bad.to_string(), expected: "colours and opacities from 0 to 1" });
    }
    let chosen = chosen(tables, &change.which)?;
    for label in tables.iter_mut().flat_map(|table| table.labels.iter_mut()) {
        let is_chosen = chosen.iter().any(|item| item.matches(label));
        if is_chosen {
            label.color = change.color.unwrap_or(label.color);
            label.opacity = change.opacity.unwrap_or(label.opacity);
        }
        match change.visibility {
            None => {}
            Some(LabelVisibility::Show) => label.visible |= is_chosen,
            Some(LabelVisibility::Hide) => label.visible &= !is_chosen,
            Some(LabelVisibility::Only) => label.visible = is_chosen,
            Some(LabelVisibility::Highlight) if is_chosen => label.visible = true,
            Some(LabelVisibility::Highlight) => label.opacity *= FAINT,
        }
    }
    Ok(())
}

/// An item of a list of labels.
#[derive(Debug, PartialEq)]
enum Item {
    Ids(u32, u32),
    /// A name in lower case.
    Name(String),
}

impl Item {
    fn new(text: &str) -> Self {
        let id = |word: &str| word.trim().parse::<u32>().ok();
        let range = text.split_once('-').and_then(|(from, to)| Some((id(from)?, id(to)?)));
        match (id(text), range) {
            (Some(id), _) => Item::Ids(id, id),
            (_, Some((from, to))) => Item::Ids(from, to),
            _ => Item::Name(text.trim().to_lowercase()),
        }
    }

    fn matches(&self, label: &Label) -> bool {
        match self {
            Item::Ids(from, to) => (*from..=*to).contains(&label.id),
            Item::Name(name) => label.name.as_ref().is_some_and(|other| other.to_lowercase() == *name),
        }
    }
}

/// The items of a list, each of which matches a label.
fn chosen(tables: &[&mut LabelTable], which: &str) -> Result<Vec<Item>, Error> {
    let labels = || tables.iter().flat_map(|table| &table.labels);
    let whole = Item::Name(which.trim().to_lowercase());
    if labels().any(|label| whole.matches(label)) {
        return Ok(vec![whole]);
    }
    let items: Vec<Item> = which.split(',').map(Item::new).collect();
    for (item, text) in items.iter().zip(which.split(',')) {
        if labels().any(|label| item.matches(label)) {
            continue;
        }
        return Err(match item {
            Item::Name(name) => unknown(name, labels().filter_map(|label| label.name.as_deref())),
            Item::Ids(..) => {
                let ids: BTreeSet<u32> = labels().map(|label| label.id).collect();
                Error::Settings { field: "label", problem: format!("no label has the id {}: {}", text.trim(), described(&ids)) }
            }
        });
    }
    Ok(items)
}

/// Which ids there are.
fn described(ids: &BTreeSet<u32>) -> String {
    match (ids.first(), ids.last()) {
        (Some(least), Some(most)) if least == most => format!("the only id is {least}"),
        (Some(least), Some(most)) => {
            let gaps = if ids.len() <= (most - least) as usize { ", with gaps" } else { "" };
            format!("ids are {least} to {most}{gaps}")
        }
        _ => "there are no labels".into(),
    }
}

/// The error for an unknown name, with the most similar one and some others.
fn unknown<'a>(name: &str, names: impl Iterator<Item = &'a str> + Clone) -> Error {
    let similarity = |other: &str| strsim::jaro_winkler(name, &other.to_lowercase());
    let nearest =
        names.clone().max_by(|a, b| similarity(a).total_cmp(&similarity(b))).filter(|other| similarity(other) >= SIMILAR);
    let mut listed: Vec<&str> = names.clone().take(LISTED).collect();
    if names.count() > LISTED {
        listed.push("…");
    }
    let known = match (nearest, &listed[..]) {
        (_, []) => "ids, since no label has a name".into(),
        (Some(nearest), _) => format!("{nearest} (the nearest name), or one of {}", listed.join(", ")),
        (None, _) => listed.join(", "),
    };
    Error::UnknownName { what: "label", name: name.into(), known }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> LabelTable {
        let named = |id, name: &str| Label { name: Some(name.into()), ..Label::new(id) };
        LabelTable::new([named(3, "Liver"), named(7, "Rib, left"), named(8, "ctx:lh"), Label::new(40)]).unwrap()
    }

    fn changed(text: &str) -> Result<Vec<(u32, f64)>, String> {
        let mut table = table();
        table.change(&text.parse().map_err(|e: Error| e.to_string())?).map_err(|e| e.to_string())?;
        Ok(table.labels().iter().map(|label| (label.id, label.drawn_opacity())).collect())
    }

    #[test]
    fn changes_say_what_of_which() {
        let change: LabelChange = "3, 7-9:#ff0000:0.4".parse().unwrap();
        let expected = LabelChange { which: "3, 7-9".into(), color: Some([1.0, 0.0, 0.0]), opacity: Some(0.4), visibility: None };
        assert_eq!(change, expected);
        let mut table = table();
        table.change(&change).unwrap();
        assert_eq!(table.labels().iter().map(|l| l.color == [1.0, 0.0, 0.0]).collect::<Vec<_>>(), [true, true, true, false]);
        assert_eq!("ctx:lh:hide".parse::<LabelChange>().unwrap().which, "ctx:lh");
    }

    #[test]
    fn labels_are_chosen_by_ids_ranges_and_names() {
        for (text, expected) in [
            ("3,7-9:0.5", [0.5, 0.5, 0.5, 1.0]),
            ("LIVER,40:0.5", [0.5, 1.0, 1.0, 0.5]),
            ("rib, left:0.5", [1.0, 0.5, 1.0, 1.0]),
            ("ctx:lh:0.5", [1.0, 1.0, 0.5, 1.0]),
            ("7-3000000000:hide", [1.0, 0.0, 0.0, 0.0]),
            ("3:only", [1.0, 0.0, 0.0, 0.0]),
            ("3,40:highlight", [1.0, FAINT, FAINT, 1.0]),
            ("3:show", [1.0; 4]),
        ] {
            let found = changed(text).unwrap();
            assert_eq!(found.iter().map(|(_, opacity)| *opacity).collect::<Vec<_>>(), expected, "{text}");
        }
    }

    #[test]
    fn changes_of_several_tables_hide_the_others_in_all() {
        let (mut one, mut two) = (table(), LabelTable::new([Label::new(3), Label::new(99)]).unwrap());
        change_all(&mut [&mut one, &mut two], &"99:only".parse().unwrap()).unwrap();
        assert!(one.labels().iter().all(|label| !label.visible));
        assert_eq!(two.labels().iter().map(|label| label.visible).collect::<Vec<_>>(), [false, true]);
    }

    #[test]
    fn messages_tell_which_ids_there_are() {
        for (ids, expected) in [
            (vec![], "there are no labels"),
            (vec![7], "the only id is 7"),
            (vec![3, 1, 4, 2], "ids are 1 to 4"),
            (vec![1, 2, 4], "ids are 1 to 4, with gaps"),
            (vec![1, u32::MAX], "ids are 1 to 4294967295, with gaps"),
        ] {
            let mut table = LabelTable::new(ids.into_iter().map(Label::new)).unwrap();
            let message = table.change(&"9:hide".parse().unwrap()).unwrap_err().to_string();
            assert!(message.ends_with(&format!("no label has the id 9: {expected}")), "{message}");
        }
    }

    #[test]
    fn wrong_changes_are_refused() {
        for (text, expected) in [
            ("", "which names no labels"),
            (":0.4", "which names no labels"),
            ("3", "which changes nothing"),
            ("liver:hid", "which changes nothing"),
            ("3:#ff00", "whose colour is not #rrggbb"),
            ("3:1.5", "whose opacity is not 0 to 1"),
            ("3:NaN", "whose opacity is not 0 to 1"),
            ("3:0.5:0.4", "which says one thing twice"),
            ("12:0.5", "label: no label has the id 12: ids are 3 to 40, with gaps"),
            ("9-20:0.5", "no label has the id 9-20"),
            ("9-7:0.5", "no label has the id 9-7"),
            ("livr:hide", "unknown label 'livr': use Liver (the nearest name), or one of Liver, Rib, left"),
        ] {
            let message = changed(text).unwrap_err();
            assert!(message.contains(expected), "{text}: {message}");
        }
    }
}
