//! What explains the colours of a picture: a colour bar, or a list of names.

use super::canvas::Canvas;
use super::extent::Extent;
use super::{Annotations, legend, list};
use crate::settings::Blend;
use crate::transfer::TransferFunction;
use std::ops::Range;

pub(super) enum Key<'a> {
    Bar { transfer: &'a TransferFunction, blend: Blend, units: Option<&'a str> },
    List(list::Rows),
}

impl<'a> Key<'a> {
    /// The key of a picture of this extent.
    pub fn new(annotations: &'a Annotations, extent: Extent, transfer: &'a TransferFunction, blend: Blend) -> Self {
        match &annotations.list {
            Some(list) => Self::List(list::Rows::new(list, extent)),
            None => Self::Bar { transfer, blend, units: annotations.units.as_deref() },
        }
    }

    /// Width of the column at the right edge that it takes.
    pub fn room(&self, extent: Extent) -> f64 {
        match self {
            Self::Bar { transfer, blend, units } => legend::room(transfer, *blend, *units, extent),
            Self::List(rows) => rows.room(extent),
        }
    }

    /// Rows of the picture that it takes, with a margin.
    pub fn rows(&self, extent: Extent) -> Range<u32> {
        match self {
            Self::Bar { .. } => legend::rows(extent),
            Self::List(rows) => rows.rows(extent),
        }
    }

    /// Draws it at the right edge.
    pub fn draw(&self, canvas: &mut Canvas) {
        match self {
            Self::Bar { transfer, blend, units } => legend::draw(transfer, *blend, *units, canvas),
            Self::List(rows) => rows.draw(canvas),
        }
    }
}
