//! Colour bars and lists of names as vector graphics.
//!
//! Text is written as outlines of the embedded font: it looks the same on machines that lack the font, and the layout, which is measured with
//! this font, holds.

mod pdf;
mod svg;

use super::Annotations;
use super::canvas::inks;
use super::extent::Extent;
use super::key::Key;
use super::legend::{self, Layout, Part};
use super::list;
use crate::error::Error;
use crate::image::text::{Step, outlines};
use crate::image::{Background, Encoding};
use crate::settings::Blend;
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use glam::DVec2;
use std::path::Path;

/// Parts of the bar: colours of its gradient, and points of the profile.
const PARTS: u32 = 512;
/// Points per pixel without a resolution: a pixel of CSS is 1/96 inch.
const POINTS_PER_PIXEL: f64 = 0.75;
const POINTS_PER_INCH: f64 = 72.0;
/// The program, in the metadata of files.
const SOFTWARE: &str = concat!("layersplat ", env!("CARGO_PKG_VERSION"));

/// File formats of vector graphics.
///
/// ```
/// use layersplat::annotation::VectorFormat;
/// use std::path::Path;
///
/// assert_eq!(VectorFormat::from_path(Path::new("bar.svg")), Some(VectorFormat::Svg));
/// assert_eq!(VectorFormat::from_path(Path::new("bar.png")), None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum VectorFormat {
    /// Scalable Vector Graphics, version 1.1.
    Svg,
    /// Portable Document Format, version 1.4.
    Pdf,
}

impl VectorFormat {
    /// The format of a file extension; `None` if it is not one of vector graphics.
    pub fn from_path(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "svg" => Some(VectorFormat::Svg),
            "pdf" => Some(VectorFormat::Pdf),
            _ => None,
        }
    }

    /// Rejects encodings of pixels.
    ///
    /// # Errors
    /// [`Error::Settings`] for bits per channel and dithering.
    pub fn check(self, encoding: &Encoding) -> Result<(), Error> {
        let field = match encoding {
            Encoding { bits: Some(_), .. } => "bits",
            Encoding { dither: true, .. } => "dither",
            _ => return Ok(()),
        };
        let name = if self == VectorFormat::Svg { "SVG" } else { "PDF" };
        Err(Error::Settings { field, problem: format!("{name} files hold shapes, not pixels: omit it, or write .png") })
    }
}

/// A colour bar or a list on a page.
struct Page<'a> {
    title: &'static str,
    /// Upper left and lower right corner of the page, in pixels of the picture.
    corners: [DVec2; 2],
    points_per_pixel: f64,
    /// `None` if the page is transparent.
    background: Option<[u8; 3]>,
    ink: [u8; 3],
    /// Colour, opacity and width of a line around letters, on a transparent page.
    halo: Option<([u8; 3], f64, f64)>,
    /// The colour bar, if it is none of names.
    bar: Option<Bar>,
    /// Corners and colours of swatches.
    swatches: Vec<([DVec2; 2], [u8; 3])>,
    lines: Vec<[DVec2; 2]>,
    /// Texts, their places and their outlines.
    labels: Vec<(DVec2, String, Vec<Step>)>,
    description: Option<&'a str>,
}

/// A colour bar with its opacities.
struct Bar {
    /// Upper left and lower right corner.
    corners: [DVec2; 2],
    parts: Vec<Part>,
}

impl Annotations {
    /// The colour bar or the list alone as a file of vector graphics, with the shapes and the size of [`legend_alone`](Self::legend_alone). A pixel is
    /// 1/96 inch large, or that of the resolution of `encoding`. Letters are outlines; in SVG their text is in `aria-label`.
    ///
    /// ```
    /// use layersplat::annotation::{Annotations, VectorFormat};
    /// use layersplat::image::Encoding;
    /// use layersplat::settings::Blend;
    /// use layersplat::{Background, TransferFunction, Viewport};
    ///
    /// let transfer = TransferFunction::new("t", vec![(0.0, [1.0; 3])], vec![(0.0, 0.0), (9.0, 1.0)])?;
    /// let (size, background) = (Viewport::new(300, 200)?, Background::Color([1.0; 3]));
    /// let (annotations, encoding) = (Annotations::default(), Encoding::default());
    /// let bar = annotations.legend_document(size, &transfer, Blend::Composite, background, VectorFormat::Pdf, &encoding)?;
    /// assert!(bar.starts_with(b"%PDF"));
    /// # Ok::<(), layersplat::Error>(())
    /// ```
    ///
    /// # Errors
    /// If the font size or the encoding is invalid.
    pub fn legend_document(
        &self,
        size: Viewport,
        transfer: &TransferFunction,
        blend: Blend,
        background: Background,
        format: VectorFormat,
        encoding: &Encoding,
    ) -> Result<Vec<u8>, Error> {
        self.check()?;
        format.check(encoding)?;
        let extent = self.extent(size);
        let key = Key::new(self, extent, transfer, blend);
        let width = key.room(extent).ceil() as u32;
        let extent = Extent { viewport: Viewport::new(width, size.height)?, ..extent };
        let page = Page::new(&key, extent, background, encoding);
        Ok(match format {
            VectorFormat::Svg => svg::document(&page).into_bytes(),
            VectorFormat::Pdf => pdf::document(&page),
        })
    }
}

impl<'a> Page<'a> {
    fn new(key: &Key, extent: Extent, background: Background, encoding: &'a Encoding) -> Self {
        let rows = key.rows(extent);
        let (title, bar, swatches, lines, labels) = match key {
            Key::Bar { transfer, blend, units } => {
                let Layout { bar, lines, labels } = Layout::new(transfer, *blend, *units, extent);
                let parts = legend::parts(transfer, *blend, extent, PARTS);
                ("Colour bar", Some(Bar { corners: bar, parts }), Vec::new(), lines, labels)
            }
            Key::List(rows) => {
                let list::Layout { swatches, lines, labels } = rows.layout(extent);
                ("Legend", None, swatches, lines, labels)
            }
        };
        let (ink, halo) = inks(background);
        let (background, halo) = match background {
            Background::Color(color) => (Some(color.map(|c| (c * 255.0 + 0.5) as u8)), None),
            Background::Transparent => (None, Some((halo, f64::from(super::canvas::HALO) / 255.0, 2.0 * extent.scale))),
        };
        let outlined = |(at, text): (DVec2, String)| {
            let steps = outlines(&text, extent.scale as f32);
            (at, text, steps.into_iter().map(|step| moved(step, at)).collect())
        };
        Self {
            title,
            corners: [DVec2::new(0.0, rows.start.into()), DVec2::new(extent.viewport.width.into(), rows.end.into())],
            points_per_pixel: encoding.dpi.map_or(POINTS_PER_PIXEL, |dpi| POINTS_PER_INCH / f64::from(dpi.get())),
            background,
            ink,
            halo,
            bar,
            swatches,
            lines,
            labels: labels.into_iter().map(outlined).collect(),
            description: encoding.description.as_deref(),
        }
    }

    /// Width and height in points.
    fn points(&self) -> DVec2 {
        (self.corners[1] - self.corners[0]) * self.points_per_pixel
    }
}

impl Bar {
    /// Ends of the gradient: centres of the first and of the last part.
    fn gradient(&self) -> [f64; 2] {
        let [from, to] = self.corners;
        let half = (to.y - from.y) / f64::from(2 * PARTS);
        [from.y + half, to.y - half]
    }

    /// Corners of the opacity profile; none if there are no opacities.
    fn profile(&self) -> Vec<DVec2> {
        let [from, to] = [self.corners[0], DVec2::new(self.corners[0].x, self.corners[1].y)];
        if self.parts.iter().all(|part| part.reach == 0.0) {
            return Vec::new();
        }
        let each = (to.y - from.y) / f64::from(PARTS);
        let at = |(n, part): (usize, &Part)| DVec2::new(from.x - part.reach, from.y + each * (n as f64 + 0.5));
        [from].into_iter().chain(self.parts.iter().enumerate().map(at)).chain([to]).collect()
    }
}

fn moved(step: Step, by: DVec2) -> Step {
    match step {
        Step::Move(to) => Step::Move(to + by),
        Step::Line(to) => Step::Line(to + by),
        Step::Curve(points) => Step::Curve(points.map(|point| point + by)),
    }
}

/// A number to a thousandth, without trailing zeros.
fn number(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

#[cfg(test)]
mod tests;
