//! Pages in Markdown, and the pictures on them.

use super::super::compare;
use super::Laboratory;
use crate::error::Error;
use crate::image::{Background, Frame, write_whole};
use crate::viewport::Viewport;
use std::path::{Path, PathBuf};

/// Pixels between pictures of a sheet.
const GAP: u32 = 4;

/// A page that is being written.
pub(super) struct Page<'a> {
    out: &'a Path,
    text: String,
}

impl<'a> Page<'a> {
    /// A page that begins with what it was made on.
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
        page.paragraph(&format!("Seen: {}.", laboratory.seen.join(", ")));
        let library = &laboratory.library;
        if library.found.iter().all(|set| set.paper.is_none()) {
            page.paragraph("None of the paper's data sets was at hand: built-in volumes stand in.");
        } else if !library.missing.is_empty() {
            page.paragraph(&format!("Missing data sets: {}.", library.missing.join(", ")));
        }
        page
    }

    /// A line of its own.
    pub fn line(&mut self, text: &str) {
        self.text += &format!("\n{text}");
    }

    /// A paragraph.
    pub fn paragraph(&mut self, text: &str) {
        self.text += &format!("\n{text}\n");
    }

    /// A table: its head, and rows of as many cells.
    pub fn table(&mut self, head: &[&str], rows: &[Vec<String>]) {
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        self.text += &format!("\n| {} |\n|{}\n", head.join(" | "), "---|".repeat(head.len()));
        for row in rows {
            self.text += &line(row);
        }
    }

    /// Frames side by side, `columns` to a row, as a picture on the page and a file of its own.
    pub fn sheet(&mut self, file: &str, caption: &str, frames: &[Frame], columns: usize) -> Result<(), Error> {
        let sheet = contact_sheet(frames, columns)?;
        sheet.save(self.out.join(file), Some(Background::BLACK))?;
        self.paragraph(&format!("![{caption}]({file})\n\n*{caption}*"));
        Ok(())
    }

    /// A drawing, in a file of its own.
    pub fn drawing(&mut self, file: &str, caption: &str, svg: &str) -> Result<(), Error> {
        write_whole(&self.out.join(file), |out| out.write_all(svg.as_bytes()))?;
        self.paragraph(&format!("![{caption}]({file})\n\n*{caption}*"));
        Ok(())
    }

    /// Writes `NAME.md`, and tells where it is.
    pub fn write(self, name: &str) -> Result<PathBuf, Error> {
        let path = self.out.join(format!("{name}.md"));
        write_whole(&path, |out| out.write_all(format!("{}\n", self.text.trim_end()).as_bytes()))?;
        Ok(path)
    }
}

/// Most pictures of a sheet, across and down.
const MOST: [u32; 2] = [3, 2];

/// The size of the largest sheet of pictures, or an error where that is no size of a picture.
pub(super) fn sheet_size(size: Viewport) -> Result<Viewport, Error> {
    Viewport::new((size.width + GAP) * MOST[0] - GAP, (size.height + GAP) * MOST[1] - GAP)
}

/// Frames of one size on one picture, with grey gaps.
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

/// The difference of two frames, a number of times enlarged, opaque.
pub(super) fn enlarged_difference(a: &Frame, b: &Frame, times: f32) -> Frame {
    let pixels = a.pixels().iter().zip(b.pixels()).map(|(p, q)| {
        let [r, g, b] = [0, 1, 2].map(|c| ((p[c] - q[c]).abs() * times).min(1.0));
        [r, g, b, 1.0]
    });
    Frame::new(Viewport { width: a.width(), height: a.height() }, pixels.collect())
}

/// PSNR over red, green and blue of two pictures of one size; infinite if they are identical.
pub(super) fn psnr(a: &Frame, b: &Frame) -> f64 {
    a.compare(b).expect("pictures of one size").psnr.unwrap_or(f64::INFINITY)
}

/// A number of dB in a table.
pub(super) fn decibels(psnr: f64) -> String {
    if psnr.is_finite() { compare::decibels(psnr, 1) } else { "identical".into() }
}
