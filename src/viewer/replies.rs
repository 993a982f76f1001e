//! Messages to a page: JSON, and pictures as bytes after a header.

use super::look::Look;
use super::page_camera::PageCamera;
use crate::transfer::{ControlPoint, TransferFunction};
use crate::viewport::Viewport;
use serde::Serialize;

/// A message to the page, as JSON.
#[derive(Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub(super) enum Reply<'a> {
    /// What the program shows from now on; the page asks for it.
    Given { camera: PageCamera, look: &'a Look, transfer: NamedTransfer<'a>, others: Vec<NamedTransfer<'a>> },
    /// A camera that fits.
    Fitted { camera: PageCamera },
    /// A transfer function that was asked for.
    Transfer { field: usize, name: &'a str, colors: &'a [ControlPoint<[f64; 3]>], opacities: &'a [ControlPoint<f64>] },
    /// The text of a file that was asked for.
    Written { name: &'a str, text: &'a str },
    /// The command that makes the picture. `more`: further files that it reads.
    Command { line: &'a str, python: &'a str, transfer_name: &'a str, transfer_text: &'a str, more: &'a [NamedText] },
    /// The command that makes a film, if the program has one, and its files.
    FilmCommand {
        id: u32,
        line: Option<&'a str>,
        keys_name: &'a str,
        keys_text: &'a str,
        transfer_name: &'a str,
        transfer_text: &'a str,
        more: &'a [NamedText],
    },
    /// How far a film is: pictures done, of how many.
    Film { id: u32, state: FilmState, done: u32, of: u32 },
    /// What is seen at a place. `None`: nothing.
    Picked { id: u32, point: Option<Picked> },
    /// The slices whose picture follows: their places, and the value at their point, if it lies in the volume.
    Slices { id: u32, value: Option<f32>, placed: &'a [PlacedSlice] },
    /// Whether all programs of usual frames are built.
    Ready { ready: bool },
    /// What is done before the next picture, and how far that is: `of` is 0 if that is not known.
    Work { what: Work, done: usize, of: usize },
    /// How far a volume is that is being opened, from 0 to 1 if that is known.
    #[cfg(feature = "viewer")]
    Opening { stage: Stage, done: Option<f64> },
    /// No better picture of this view follows the last one.
    Refined { id: u32 },
    /// A view that could not be drawn. The problem was sent.
    Failed { id: u32 },
    /// A request that failed: what is wrong and what can be done. `undo`: a change was refused, so pictures are those from before it.
    Problem { sentence: &'a str, undo: bool },
}

/// What is done before a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Work {
    /// The device is checked, once per kind of picture.
    Check,
    /// Programs of the device are built.
    Programs,
}

/// What is done with a volume that is being opened.
#[cfg(feature = "viewer")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Stage {
    /// Its file is read, and unpacked.
    Reading,
    /// A pass over its voxels.
    Looking,
    Cancelled,
    /// The problem follows.
    Failed,
}

/// What has become of a film.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum FilmState {
    Drawing,
    /// All parts were sent.
    Complete,
    Cancelled,
    /// The problem was sent.
    Failed,
}

/// A text file beside a command.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct NamedText {
    pub name: String,
    pub text: String,
}

/// A transfer function, and its name.
#[derive(Serialize)]
pub(super) struct NamedTransfer<'a> {
    name: &'a str,
    colors: &'a [ControlPoint<[f64; 3]>],
    opacities: &'a [ControlPoint<f64>],
}

impl<'a> From<&'a TransferFunction> for NamedTransfer<'a> {
    fn from(transfer: &'a TransferFunction) -> Self {
        Self { name: transfer.name(), colors: transfer.colors(), opacities: transfer.opacities() }
    }
}

/// What a picture is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Step {
    Moving = 0,
    Standard = 1,
    High = 2,
    /// 2 × 2 samples per pixel.
    Half = 3,
    /// The last one: 4 × 4 samples per pixel, or the chosen quality.
    Last = 4,
    /// A picture to save.
    Saved = 5,
    /// Three slices below each other.
    Slices = 6,
    /// Part of a film's file.
    Part = 7,
}

/// Format of a picture's bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Format {
    Jpeg = 0,
    Png = 1,
    Exr = 2,
    Gif = 3,
    Apng = 4,
    Mp4 = 5,
}

/// A picture, with what the page needs to know about it.
pub(super) struct Picture {
    pub step: Step,
    pub format: Format,
    /// Number of the request.
    pub id: u32,
    pub size: Viewport,
    /// Time from the request to the encoded picture.
    pub milliseconds: f32,
    pub bytes: Vec<u8>,
}

/// Bytes before a picture: step, format, two of zero, then id, width and height, then milliseconds; four each, little-endian.
pub(super) const HEADER: usize = 20;

impl Picture {
    /// The message: header and picture.
    pub fn message(&self) -> Vec<u8> {
        let mut message = Vec::with_capacity(HEADER + self.bytes.len());
        message.extend([self.step as u8, self.format as u8, 0, 0]);
        for number in [self.id, self.size.width, self.size.height] {
            message.extend(number.to_le_bytes());
        }
        message.extend(self.milliseconds.to_le_bytes());
        message.extend(&self.bytes);
        message
    }
}

/// A point of the volume that is seen.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Picked {
    /// World position.
    pub position: [f64; 3],
    /// Position in voxels.
    pub voxel: [f64; 3],
    /// Value of the field, of the first of several; `None` for labels alone.
    pub value: Option<f64>,
    /// Values of several fields, or of the components of colours.
    pub values: Vec<f64>,
    /// Labels that are seen there, of each layer that has one.
    pub labels: Vec<PickedLabel>,
}

/// A label that is seen.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct PickedLabel {
    pub id: u32,
    pub name: String,
}

/// Where the pixels of a slice lie: world vectors.
#[derive(Serialize)]
pub(super) struct PlacedSlice {
    /// Upper left corner.
    pub corner: [f64; 3],
    /// Steps to the next pixel on the right, and to the next below.
    pub right: [f64; 3],
    pub down: [f64; 3],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_begins_with_its_header() {
        let size = Viewport { width: 3, height: 2 };
        let picture = Picture { step: Step::High, format: Format::Png, id: 258, size, milliseconds: 1.5, bytes: vec![7, 8] };
        let message = picture.message();
        assert_eq!(message[..HEADER], [2, 1, 0, 0, 2, 1, 0, 0, 3, 0, 0, 0, 2, 0, 0, 0, 0, 0, 192, 63]);
        assert_eq!(message[HEADER..], [7, 8]);
    }
}
