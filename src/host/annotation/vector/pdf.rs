//! A colour bar or a list in PDF 1.4 (ISO 32000): one page with a gradient and paths.

use super::{Bar, PARTS, Page, SOFTWARE, number};
use crate::annotation::legend::PROFILE_OPACITY;
use crate::image::text::Step;
use glam::DVec2;
use std::fmt::Write;

pub(super) fn document(page: &Page) -> Vec<u8> {
    let points = page.points();
    let [width, height] = [points.x, points.y].map(number);
    let opacity = |name: &str, opacity: f64| {
        let opacity = number(opacity);
        format!("/{name} << /ca {opacity} /CA {opacity} >>")
    };
    let halo = page.halo.map_or(1.0, |(_, opacity, _)| opacity);
    let states = [opacity("Solid", 1.0), opacity("Profile", PROFILE_OPACITY), opacity("Halo", halo)].join(" ");
    let pattern = if page.bar.is_some() { "/Pattern << /Colours 5 0 R >> " } else { "" };
    let mut file = File::new();
    file.object("<< /Type /Catalog /Pages 2 0 R >>".into());
    file.object("<< /Type /Pages /Kids [3 0 R] /Count 1 >>".into());
    file.object(format!(
        "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {width} {height}] /Contents 4 0 R \
         /Resources << {pattern}/ExtGState << {states} >> >> >>"
    ));
    file.stream("", content(page).as_bytes());
    if let Some(bar) = &page.bar {
        gradient(&mut file, bar, &to_points(page));
    }
    let subject = page.description.map_or(String::new(), |text| format!(" /Subject {}", wide(text)));
    file.object(format!("<< /Title ({}) /Producer ({SOFTWARE}){subject} >>", page.title));
    file.finish()
}

/// Objects 5 and 6: the colours of the bar.
fn gradient(file: &mut File, bar: &Bar, matrix: &str) {
    let [first, last] = bar.gradient().map(number);
    let colors: Vec<u8> = bar.parts.iter().flat_map(|part| part.color).collect();
    file.object(format!(
        "<< /Type /Pattern /PatternType 2 /Matrix [{matrix}] /Shading << /ShadingType 2 /ColorSpace /DeviceRGB \
         /Coords [0 {first} 0 {last}] /Extend [true true] /Function 6 0 R >> >>"
    ));
    let sampled = format!("/FunctionType 0 /Domain [0 1] /Range [0 1 0 1 0 1] /Size [{PARTS}] /BitsPerSample 8");
    file.stream(&sampled, &colors);
}

/// Transform from pixels, which count downwards, to points, which count upwards.
fn to_points(page: &Page) -> String {
    let scale = page.points_per_pixel;
    // Scales need more digits than places.
    format!("{scale:.6} 0 0 {:.6} 0 {}", -scale, number(page.corners[1].y * scale))
}

fn content(page: &Page) -> String {
    let mut text = format!("{} cm\n", to_points(page));
    let mut add = |line: String| text.extend([line.as_str(), "\n"]);
    if let Some(background) = page.background {
        add(format!("{} rg {} f", color(background), area(page.corners)));
    }
    if let Some(bar) = &page.bar {
        add(format!("/Pattern cs /Colours scn {} f", area(bar.corners)));
        let profile = bar.profile();
        if let [first, rest @ ..] = &profile[..] {
            let rest: Vec<String> = rest.iter().map(|&corner| format!("{} l", point(corner))).collect();
            add(format!("/Profile gs {} m {} h f /Solid gs", point(*first), rest.join(" ")));
        }
    }
    for &(swatch, fill) in &page.swatches {
        add(format!("{} rg {} f", color(fill), area(swatch)));
    }
    let ink = color(page.ink);
    add(format!("{ink} rg"));
    for &line in &page.lines {
        add(format!("{} f", area(line)));
    }
    // Paths must not be empty, as those of spaces would be.
    for (_, _, steps) in page.labels.iter().filter(|(_, _, steps)| !steps.is_empty()) {
        let path = path(steps);
        if let Some((halo, _, width)) = page.halo {
            add(format!("/Halo gs 1 j {} w {} RG {path} S /Solid gs", number(width), color(halo)));
        }
        add(format!("{path} f"));
    }
    text
}

fn area([from, to]: [DVec2; 2]) -> String {
    let size = to - from;
    format!("{} {} re", point(from), point(size))
}

fn path(steps: &[Step]) -> String {
    let mut text = String::new();
    for (n, step) in steps.iter().enumerate() {
        let _ = match *step {
            Step::Move(to) => write!(text, "{}{} m ", if n > 0 { "h " } else { "" }, point(to)),
            Step::Line(to) => write!(text, "{} l ", point(to)),
            Step::Curve([a, b, c]) => write!(text, "{} {} {} c ", point(a), point(b), point(c)),
        };
    }
    text + "h"
}

fn point(at: DVec2) -> String {
    format!("{} {}", number(at.x), number(at.y))
}

fn color(color: [u8; 3]) -> String {
    color.map(|c| number(f64::from(c) / 255.0)).join(" ")
}

/// A text string in UTF-16.
fn wide(text: &str) -> String {
    let mut hex = String::from("<FEFF");
    for unit in text.encode_utf16() {
        let _ = write!(hex, "{unit:04X}");
    }
    hex + ">"
}

/// Objects of a file, numbered from 1, and their first bytes.
struct File {
    bytes: Vec<u8>,
    starts: Vec<usize>,
}

impl File {
    fn new() -> Self {
        // A comment of four bytes above 127 marks the file as binary.
        Self { bytes: b"%PDF-1.4\n%\xe2\xe3\xcf\xd3\n".to_vec(), starts: Vec::new() }
    }

    fn begin(&mut self) {
        self.starts.push(self.bytes.len());
        self.bytes.extend(format!("{} 0 obj\n", self.starts.len()).bytes());
    }

    fn object(&mut self, dictionary: String) {
        self.begin();
        self.bytes.extend(format!("{dictionary}\nendobj\n").bytes());
    }

    fn stream(&mut self, entries: &str, content: &[u8]) {
        self.begin();
        self.bytes.extend(format!("<< {entries} /Length {} >>\nstream\n", content.len()).bytes());
        self.bytes.extend(content);
        self.bytes.extend(b"\nendstream\nendobj\n");
    }

    /// Appends the cross-reference table, whose entries have 20 bytes. The last object holds the metadata, the first is the catalogue.
    fn finish(mut self) -> Vec<u8> {
        let (count, table) = (self.starts.len(), self.bytes.len());
        let entries: String = self.starts.iter().map(|start| format!("{start:010} 00000 n \n")).collect();
        let table = format!(
            "xref\n0 {size}\n0000000000 65535 f \n{entries}trailer\n<< /Size {size} /Root 1 0 R /Info {count} 0 R >>\n\
             startxref\n{table}\n%%EOF\n",
            size = count + 1
        );
        self.bytes.extend(table.bytes());
        self.bytes
    }
}
