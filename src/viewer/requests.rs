//! Messages of a page, as JSON, and their limits.

use super::host::RawLayout;
use super::look::Look;
use super::page_camera::PageCamera;
use crate::error::Error;
use crate::layers::Kernel;
use crate::transfer::{ControlPoint, TransferFunction};
use crate::viewport::Viewport;
use serde::Deserialize;

/// Longest message of a page in bytes. A transfer function of 4096 points takes about a third.
pub(super) const MAX_MESSAGE: usize = 1 << 20;
/// Most pixels of a picture that a page shows.
const MAX_SHOWN_PIXELS: usize = 1 << 24;
/// Most pixels of a saved picture, samples included.
const MAX_SAVED_PIXELS: usize = 1 << 26;
/// Most control points of a transfer function that a page sends.
const MAX_POINTS: usize = 4096;

/// A message of the page.
#[derive(Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum Request {
    /// Draw this view. The newest one wins.
    View(View),
    /// Draw these slices. The newest ones win.
    Slices(SlicesView),
    /// Use this look from the next view on.
    Look { look: Look },
    /// Use this transfer function of a field from the next view on.
    Transfer {
        #[serde(default)]
        field: usize,
        colors: Vec<ControlPoint<[f64; 3]>>,
        opacities: Vec<ControlPoint<f64>>,
    },
    /// The page has drawn a picture.
    Shown {},
    /// Answer with the camera that fits what is visible.
    Fit { camera: PageCamera, width: u32, height: u32 },
    /// Answer with a transfer function of a field by name.
    Named {
        #[serde(default)]
        field: usize,
        kind: Kind,
        name: String,
    },
    /// Answer with the transfer function in the text of a file.
    Read {
        #[serde(default)]
        field: usize,
        name: String,
        text: String,
    },
    /// Answer with the transfer function of a field as the text of a file, by the name's extension.
    Write {
        #[serde(default)]
        field: usize,
        name: String,
    },
    /// Answer with a picture of the best quality, and the command that makes it.
    Save {
        camera: PageCamera,
        width: u32,
        height: u32,
        samples: u32,
        #[serde(default)]
        format: SavedFormat,
    },
    /// Answer with a film along key cameras, in parts, and the command that makes it.
    Film(Film),
    /// Give up a film.
    CancelFilm { id: u32 },
    /// Show another volume: answered with another first message.
    Open { volume: OpenWanted },
    /// Give up the volume that is being opened.
    CancelOpen {},
    /// Answer with the command alone.
    Command {
        camera: PageCamera,
        width: u32,
        height: u32,
        samples: u32,
        #[serde(default)]
        format: SavedFormat,
    },
    /// Answer with the point that is seen at a place of a picture, and the value there.
    Pick(Pick),
}

/// A volume that a page wants to open.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "snake_case")]
pub enum OpenWanted {
    /// One of the offered volumes, by name.
    Offered(String),
    /// The file that was dropped last, by the number that it was answered with.
    Dropped(u32),
    /// The same, if its raw voxels have another layout than the usual one.
    Raw { dropped: u32, layout: RawLayout },
}

/// A place of a picture.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub(super) struct Pick {
    /// Number of the request; the answer repeats it.
    pub id: u32,
    pub camera: PageCamera,
    /// Height of the picture in pixels: a pixel is as wide as the ray that is followed.
    pub height: u32,
    /// From the middle to the right, in half heights.
    pub x: f64,
    /// From the middle upwards, in half heights.
    pub y: f64,
}

/// Format of a saved picture.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum SavedFormat {
    /// 8 bits per channel.
    #[default]
    Png,
    /// Floating-point numbers.
    Exr,
}

impl SavedFormat {
    /// Name of the file that the browser saves.
    pub fn file_name(self) -> &'static str {
        match self {
            SavedFormat::Png => "layersplat.png",
            SavedFormat::Exr => "layersplat.exr",
        }
    }
}

/// A view to draw.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub(super) struct View {
    /// Number of the request; pictures repeat it.
    pub id: u32,
    pub camera: PageCamera,
    /// Size of the picture on the page, in device pixels.
    pub width: u32,
    pub height: u32,
    /// Whether a hand moves: then speed counts, otherwise quality.
    pub moving: bool,
    /// Whether time runs. Speed counts, too, but what is kept does not wait for it, as it does for a hand.
    #[serde(default)]
    pub playing: bool,
}

/// Where a named transfer function comes from.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "snake_case")]
pub(super) enum Kind {
    /// Made from the voxels, in the colours of a palette.
    Automatic,
    Preset,
    /// A colour map.
    Map,
    /// The one that the command began with.
    Initial,
}

/// Checks the size of a picture on the page.
pub(super) fn shown_size(width: u32, height: u32) -> Result<Viewport, Error> {
    bounded(width, height, 1, MAX_SHOWN_PIXELS, "a picture of at most 16 million pixels")
}

/// Checks the size of a saved picture with N × N samples per pixel.
pub(super) fn saved_size(width: u32, height: u32, samples: u32) -> Result<Viewport, Error> {
    if !(1..=16).contains(&samples) {
        return Err(Error::OutOfRange { name: "samples", value: samples.to_string(), expected: "1 to 16" });
    }
    bounded(width, height, samples, MAX_SAVED_PIXELS, "a picture of at most 64 million samples")
}

fn bounded(width: u32, height: u32, samples: u32, most: usize, expected: &'static str) -> Result<Viewport, Error> {
    let viewport = Viewport::new(width, height)?;
    let rendered = Viewport::new(width.saturating_mul(samples), height.saturating_mul(samples))?;
    if rendered.pixels() <= most {
        return Ok(viewport);
    }
    Err(Error::OutOfRange { name: "viewport", value: format!("{}x{}", rendered.width, rendered.height), expected })
}

/// Makes a transfer function of what a page sent.
pub(super) fn transfer_function(
    colors: Vec<ControlPoint<[f64; 3]>>,
    opacities: Vec<ControlPoint<f64>>,
) -> Result<TransferFunction, Error> {
    if colors.len().max(opacities.len()) > MAX_POINTS {
        let problem =
            format!("it has more than {MAX_POINTS} control points, the limit of the page: begin the command with its file");
        return Err(Error::Transfer { name: "the page's transfer function".into(), problem });
    }
    TransferFunction::new("page", colors, opacities)
}

/// A film that a page asks for.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub(super) struct Film {
    /// Number of the request; answers repeat it.
    pub id: u32,
    pub keys: Vec<FilmKey>,
    pub width: u32,
    pub height: u32,
    pub samples: u32,
    /// Pictures per second.
    pub rate: u32,
    pub format: FilmFormat,
}

/// A camera, its time in seconds, and the step of a sequence that is shown then.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub(super) struct FilmKey {
    pub time: f64,
    pub camera: PageCamera,
    #[serde(default)]
    pub frame: usize,
}

/// Format of a film.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "snake_case")]
pub(super) enum FilmFormat {
    Gif,
    Apng,
    Mp4,
}

/// Slices to draw, all of one size. The newest request wins.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub(super) struct SlicesView {
    /// Number of the request; the answer and the picture repeat it.
    pub id: u32,
    /// World point that all slices pass through.
    pub point: [f64; 3],
    pub planes: [PagePlane; 3],
    /// Size of each slice in device pixels.
    pub width: u32,
    pub height: u32,
    pub kernel: Kernel,
    /// Level and width of a window of grey; `null`: colours of the transfer function.
    pub window: Option<[f64; 2]>,
    /// Thickness of the layer whose opacity colours have; `null`: opaque.
    pub thickness: Option<f64>,
    /// Whether a hand moves.
    pub moving: bool,
}

/// Orientation of a plane: world vectors.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub(super) struct PagePlane {
    pub right: [f64; 3],
    pub up: [f64; 3],
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAMERA: &str = r#"{"azimuth":1,"elevation":2,"roll":3,"center":[4,5,6],"projection":{"parallel_scale":7}}"#;

    fn parse(text: &str) -> Result<Request, serde_json::Error> {
        serde_json::from_str(text)
    }

    #[test]
    fn requests_are_read_and_nothing_else_is() {
        let view = format!(r#"{{"type":"view","id":1,"camera":{CAMERA},"width":8,"height":9,"moving":true}}"#);
        let Ok(Request::View(view)) = parse(&view) else { panic!("{view}") };
        assert_eq!((view.id, view.camera.center, view.moving), (1, [4.0, 5.0, 6.0], true));
        assert!(matches!(
            parse(r#"{"type":"transfer","colors":[[0,[1,1,1]]],"opacities":[[0,0.5]]}"#),
            Ok(Request::Transfer { .. })
        ));
        assert!(matches!(parse(r#"{"type":"shown"}"#), Ok(Request::Shown {})));
        for bad in [
            "",
            "{}",
            "[]",
            "null",
            r#"{"type":"open","path":"/etc/passwd"}"#,
            r#"{"type":"shown","more":1}"#,
            r#"{"type":"view"}"#,
            r#"{"type":"transfer","colors":[[0,[1,1]]],"opacities":[]}"#,
            r#"{"type":"named","kind":"file","name":"/etc/passwd"}"#,
        ] {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn sizes_are_checked() {
        assert!(shown_size(4096, 4096).is_ok() && shown_size(4097, 4096).is_err() && shown_size(0, 1).is_err());
        assert!(saved_size(4096, 4096, 2).is_ok() && saved_size(4096, 4096, 3).is_err() && saved_size(16384, 1, 16).is_err());
        assert!(saved_size(1, 1, 0).is_err() && saved_size(1, 1, 17).is_err() && saved_size(u32::MAX, u32::MAX, 16).is_err());
        let points = vec![(0.0, 0.5); MAX_POINTS + 1];
        assert!(transfer_function(vec![(0.0, [0.0; 3])], points).is_err());
    }
}
