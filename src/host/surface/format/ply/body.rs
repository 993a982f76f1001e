//! Numbers of PLY files.

use super::Columns;
use super::header::{Coding, Element, Property};
use crate::volume::{Numbers, ScalarType};

/// The numbers behind a header.
pub(super) struct Body<'a> {
    rest: &'a [u8],
    coding: Coding,
}

impl<'a> Body<'a> {
    pub fn new(rest: &'a [u8], coding: Coding) -> Self {
        Self { rest, coding }
    }

    /// Refuses more entries than the rest of the file can hold, before anything is allocated.
    pub fn check(&self, element: &Element) -> Result<(), String> {
        let least = |property: &Property| match self.coding {
            // A digit and a blank.
            Coding::Text => 2,
            Coding::Binary(_) => property.list.unwrap_or(property.scalar).bytes() as u64,
        };
        let needed = element.count.saturating_mul(element.properties.iter().map(least).sum());
        let found = self.rest.len() as u64;
        // The last number of a text needs no blank behind it.
        if needed <= found + u64::from(self.coding == Coding::Text) {
            return Ok(());
        }
        Err(format!(
            "{} are declared, which need {needed} bytes or more, and {found} are left: it is truncated or damaged",
            element.count
        ))
    }

    /// Reads an element: the values of its scalar properties, and each list of indices of points as it comes.
    pub fn columns<'e>(
        &mut self,
        element: &'e Element,
        cell: &mut dyn FnMut(&[f64]) -> Result<(), String>,
    ) -> Result<Columns<'e>, String> {
        // Nothing is there for entries without properties.
        let count = if element.properties.is_empty() { 0 } else { element.count };
        let scalars = element.properties.iter().filter(|property| property.list.is_none());
        let mut columns: Columns = scalars.map(|p| (p.name.as_str(), p.scalar, Vec::with_capacity(count as usize))).collect();
        let mut list = Vec::new();
        for n in 0..count {
            let mut values = columns.iter_mut().map(|(.., values)| values);
            let ends = |_| format!("its entry {n} of {count} is incomplete or no number: it is truncated or damaged");
            for property in &element.properties {
                let Some(kind) = property.list else {
                    let value = self.number(property.scalar).ok_or(()).map_err(ends)?;
                    values.next().into_iter().for_each(|values| values.push(value));
                    continue;
                };
                let length = self.number(kind).ok_or(()).map_err(ends)?;
                if !(length >= 0.0 && length.fract() == 0.0 && length <= self.rest.len() as f64) {
                    return Err(format!(
                        "its entry {n} of {count} has a list of {length} numbers, more than there are: it is damaged"
                    ));
                }
                list.clear();
                for _ in 0..length as u64 {
                    list.push(self.number(property.scalar).ok_or(()).map_err(ends)?);
                }
                if matches!(property.name.as_str(), "vertex_indices" | "vertex_index") {
                    cell(&list)?;
                }
            }
        }
        Ok(columns)
    }

    fn number(&mut self, scalar: ScalarType) -> Option<f64> {
        match self.coding {
            Coding::Binary(endian) => {
                let (number, rest) = self.rest.split_at_checked(scalar.bytes())?;
                self.rest = rest;
                Some(Numbers::new(number, scalar, endian).stored(0))
            }
            Coding::Text => {
                let text = self.rest.trim_ascii_start();
                let (word, rest) = text.split_at(text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len()));
                self.rest = rest;
                std::str::from_utf8(word).ok()?.parse().ok()
            }
        }
    }
}
