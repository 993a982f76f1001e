//! Markdown pages with pictures.

use super::super::compare;
use super::Laboratory;
use crate::error::Error;
use crate::image::{Background, Frame, write_whole};
use crate::viewport::Viewport;
use std::path::{Path, PathBuf};

/// Gap between pictures of a sheet in pixels.
const GAP: u32 = 4;

/// A page under construction.
pub(super) struct Page<'a> {
    out: &'a Path,
    text: String,
}

impl<'a> Page<'a> {
    /// Creates a page that begins with title, device and data sets.
    pub fn new(title: &str, laboratory: &'a Laboratory) -> Self {
        let info = laboratory.device.info();
        let mut page = Self { out: laboratory.out, text: format!("# {title}\n") };
        let size = laboratory.size;
        page.paragraph(&format!(
            "Made by `layersplat paper` {} on {} ({}, {} threads); pictures of {}×{} pixels.",
            env!("CARGO_PKG_VERSION"),
            info.name,
            info.platform,
            std::thread::available_parallelism().map_or(1, usize::from),
            size.width,
            size.height
        ));
        page.paragraph(&format!("Data sets: {}.", laboratory.descriptions.join(", ")));
        let library = &laboratory.library;
        if library.found.iter().all(|set| set.paper.is_none()) {
            page.paragraph("None of the paper's data sets was found; built-in volumes are used instead.");
        } else if !library.missing.is_empty() {
            page.paragraph(&format!("Missing data sets: {}.", library.missing.join(", ")));
        }
        page
    }

    /// Adds a line.
    pub fn line(&mut self, text: &str) {
        self.text += &format!("\n{text}");
    }

    /// Adds a paragraph.
    pub fn paragraph(&mut self, text: &str) {
        self.text += &format!("\n{text}\n");
    }

    /// Adds a table. Rows have as many cells as the head.
    pub fn table(&mut self, head: &[&str], rows: &[Vec<String>]) {
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        self.text += &format!("\n| {} |\n|{}\n", head.join(" | "), "---|".repeat(head.len()));
        for row in rows {
            self.text += &line(row);
        }
    }

    /// Adds a picture of several frames in rows of `columns`, and writes it to `file`.
    pub fn sheet(&mut self, file: &str, caption: &str, frames: &[Frame], columns: usize) -> Result<(), Error> {
        let sheet = contact_sheet(frames, columns)?;
        sheet.save(self.out.join(file), Some(Background::BLACK))?;
        self.paragraph(&format!("![{caption}]({file})\n\n*{caption}*"));
        Ok(())
    }

    /// Adds an SVG drawing, and writes it to `file`.
    pub fn drawing(&mut self, file: &str, caption: &str, svg: &str) -> Result<(), Error> {
        write_whole(&self.out.join(file), |out| out.write_all(svg.as_bytes()))?;
        self.paragraph(&format!("![{caption}]({file})\n\n*{caption}*"));
        Ok(())
    }

    /// Writes `NAME.md` and returns its path.
    pub fn write(self, name: &str) -> Result<PathBuf, Error> {
        let path = self.out.join(format!("{name}.md"));
        write_whole(&path, |out| out.write_all(format!("{}\n", self.text.trim_end()).as_bytes()))?;
        Ok(path)
    }
}

/// Largest number of pictures of a sheet, across and down.
const MAX_PICTURES: [u32; 2] = [3, 2];

/// Size of the largest sheet of pictures.
///
/// # Errors
/// [`Error::OutOfRange`] if a sheet would be larger than a picture may be.
pub(super) fn sheet_size(size: Viewport) -> Result<Viewport, Error> {
    Viewport::new((size.width + GAP) * MAX_PICTURES[0] - GAP, (size.height + GAP) * MAX_PICTURES[1] - GAP)
}

/// Combines frames of equal size into one picture with grey gaps.
fn contact_sheet(frames: &[Frame], columns: usize) -> Result<Frame, Error> {
    let (w, h) = (frames[0].width() + GAP, frames[0].height() + GAP);
    let rows = frames.len().div_ceil(columns) as u32;
    let size = Viewport::new(w * columns as u32 - GAP, h * rows - GAP)?;
    let pixels = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y))).map(|(x, y)| {
        let frame = frames.get((y / h) as usize * columns + (x / w) as usize);
        match frame {
            Some(frame) if x % w < frame.width() && y % h < frame.height() => frame.pixel(x % w, y % h),
            None if x % w < w - GAP && y % h < h - GAP => [0.0, 0.0, 0.0, 1.0],
            _ => [0.3, 0.3, 0.3, 1.0],
        }
    });
    Ok(Frame::new(size, pixels.collect()))
}

/// Absolute difference of two frames, magnified by `times`, opaque.
pub(super) fn enlarged_difference(a: &Frame, b: &Frame, times: f32) -> Frame {
    let pixels = a.pixels().iter().zip(b.pixels()).map(|(p, q)| {
        let [r, g, b] = [0, 1, 2].map(|c| ((p[c] - q[c]).abs() * times).min(1.0));
        [r, g, b, 1.0]
    });
    Frame::new(Viewport { width: a.width(), height: a.height() }, pixels.collect())
}

/// PSNR over red, green and blue of two pictures of equal size; infinite if they are identical.
pub(super) fn psnr(a: &Frame, b: &Frame) -> f64 {
    a.compare(b).expect("pictures of equal size").psnr.unwrap_or(f64::INFINITY)
}

/// Formats decibels for a table.
pub(super) fn decibels(psnr: f64) -> String {
    if psnr.is_finite() { compare::decibels(psnr, 1) } else { "identical".into() }
}
