//! How a volume is shown first, and what a page begins with.

use super::drawn::Drawn;
use super::look::Look;
use super::page_camera::PageCamera;
use crate::device::Device;
use crate::framing::Orientation;
use crate::transfer::TransferFunction;
use crate::volume::{Sequence, Volume};
use std::time::Duration;

/// How a volume is shown first.
pub struct Opening {
    /// The volume, or the first step of a sequence. Its name is that of the file, without folders.
    pub volume: Volume<'static>,
    /// The sequence, if the volume is one.
    pub time: Option<Time>,
    /// The first transfer function.
    pub transfer: TransferFunction,
    /// What is drawn besides the volume, or instead of it.
    pub drawn: Drawn,
    /// The device.
    pub device: Device,
    /// Which way is up.
    pub orientation: Orientation,
    /// The first camera.
    pub camera: PageCamera,
    /// Whether the camera is as the user gave it; otherwise it is fitted to each page.
    pub camera_is_given: bool,
    /// The first look.
    pub look: Look,
    /// Time limit per frame on the device.
    pub time_limit: Option<Duration>,
    /// Sentences that a page says first.
    pub notes: Vec<String>,
}

/// What a page begins with.
#[derive(Clone, Debug, PartialEq)]
pub struct First {
    /// The camera.
    pub camera: PageCamera,
    /// Whether it stays as it is; otherwise it is fitted to the page.
    pub camera_is_given: bool,
    /// The look.
    pub look: Look,
    /// The transfer function.
    pub transfer: TransferFunction,
    /// Those of the other fields.
    pub others: Vec<TransferFunction>,
}

impl First {
    /// The transfer functions of all fields.
    pub(super) fn transfers(&self) -> Vec<TransferFunction> {
        std::iter::once(&self.transfer).chain(&self.others).cloned().collect()
    }
}

impl Opening {
    /// What the first page begins with.
    pub fn first(&self) -> First {
        let Self { camera, camera_is_given, look, transfer, .. } = self;
        let others = self.drawn.fields().iter().skip(1).map(|field| field.transfer.clone()).collect();
        First { camera: *camera, camera_is_given: *camera_is_given, look: look.clone(), transfer: transfer.clone(), others }
    }
}

/// The sequence of a scene.
pub struct Time {
    /// Its steps.
    pub sequence: Sequence,
    /// A sample of all of them ([`Sequence::overview`]).
    pub overview: Volume<'static>,
}
