//! Attributes of datasets and groups.

use super::numbers::Value;
use crate::volume::format::conventions::Attributes;
use hdf5_reader::group::Group;
use hdf5_reader::{Attribute, Dataset, Datatype};

/// What has attributes.
pub(super) trait HasAttributes {
    fn find(&self, name: &str) -> Option<Attribute>;
}

impl HasAttributes for Dataset {
    fn find(&self, name: &str) -> Option<Attribute> {
        self.attribute(name).ok()
    }
}

impl HasAttributes for Group {
    fn find(&self, name: &str) -> Option<Attribute> {
        self.attribute(name).ok()
    }
}

impl<T: HasAttributes> Attributes for T {
    fn numbers(&self, name: &str) -> Option<(Vec<f64>, bool)> {
        let attribute = self.find(name)?;
        let is_float = matches!(attribute.datatype, Datatype::FloatingPoint { .. });
        let numbers = attribute.read_1d::<Value>().ok().filter(|numbers| !numbers.is_empty())?;
        Some((numbers.into_iter().map(|Value(number)| number).collect(), is_float))
    }

    fn text(&self, name: &str) -> Option<String> {
        texts(self, name).into_iter().next()
    }
}

/// All texts of an attribute; none if it has no text.
pub(super) fn texts(of: &impl HasAttributes, name: &str) -> Vec<String> {
    let Some(attribute) = of.find(name) else { return Vec::new() };
    let found = attribute.read_strings().or_else(|_| attribute.read_string().map(|text| vec![text]));
    found.unwrap_or_default().iter().map(|text| text.trim_end_matches('\0').trim().to_owned()).collect()
}
