//! A colour bar or a list in SVG (<https://www.w3.org/TR/SVG11/>).

use super::{Bar, PARTS, Page, SOFTWARE, number};
use crate::annotation::legend::PROFILE_OPACITY;
use crate::image::text::Step;
use glam::DVec2;
use std::fmt::Write;

pub(super) fn document(page: &Page) -> String {
    let [from, to] = page.corners;
    let (size, points) = (to - from, page.points());
    let [width, height, points_x, points_y, top] = [size.x, size.y, points.x, points.y, from.y].map(number);
    let mut lines = vec![
        r#"<?xml version="1.0" encoding="UTF-8"?>"#.to_owned(),
        format!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" width="{points_x}pt" height="{points_y}pt" viewBox="0 {top} {width} {height}">"#
        ),
        format!("<title>{}</title>", page.title),
    ];
    if let Some(description) = page.description {
        lines.push(format!("<desc>{}: {}</desc>", SOFTWARE, escaped(description)));
    }
    lines.extend(page.bar.as_ref().map(gradient));
    if let Some(color) = page.background {
        lines.push(format!(r#"<rect y="{top}" width="{width}" height="{height}" fill="{}"/>"#, hex(color)));
    }
    if let Some(bar) = &page.bar {
        lines.push(format!("<rect {} fill=\"url(#colours)\"/>", area(bar.corners)));
        let profile: Vec<String> = bar.profile().iter().map(|&corner| point(corner)).collect();
        if !profile.is_empty() {
            let corners = profile.join(" ");
            lines.push(format!(r#"<polygon points="{corners}" fill="url(#colours)" fill-opacity="{PROFILE_OPACITY}"/>"#));
        }
    }
    lines.extend(page.swatches.iter().map(|&(swatch, color)| format!(r#"<rect {} fill="{}"/>"#, area(swatch), hex(color))));
    lines.push(format!(r#"<g fill="{}">"#, hex(page.ink)));
    lines.extend(page.lines.iter().map(|&line| format!("<rect {}/>", area(line))));
    for (_, text, steps) in &page.labels {
        let path = path(steps);
        if let Some((color, opacity, width)) = page.halo {
            let (color, opacity, width) = (hex(color), number(opacity), number(width));
            let stroke = format!(r#"stroke="{color}" stroke-opacity="{opacity}" stroke-width="{width}" stroke-linejoin="round""#);
            lines.push(format!(r#"<path {stroke} fill="none" d="{path}"/>"#));
        }
        lines.push(format!(r#"<path role="img" aria-label="{}" d="{path}"/>"#, escaped(text)));
    }
    lines.push("</g>\n</svg>\n".into());
    lines.join("\n")
}

/// The colours of the bar. Stops between equal neighbours are left out.
fn gradient(bar: &Bar) -> String {
    let [first, last] = bar.gradient().map(number);
    let colors: Vec<[u8; 3]> = bar.parts.iter().map(|part| part.color).collect();
    let is_needed = |n: usize| n == 0 || n + 1 == colors.len() || colors[n - 1] != colors[n] || colors[n] != colors[n + 1];
    let mut text =
        format!(r#"<defs><linearGradient id="colours" gradientUnits="userSpaceOnUse" x1="0" x2="0" y1="{first}" y2="{last}">"#);
    for n in (0..colors.len()).filter(|&n| is_needed(n)) {
        let offset = n as f64 / f64::from(PARTS - 1);
        let _ = write!(text, r#"<stop offset="{offset:.5}" stop-color="{}"/>"#, hex(colors[n]));
    }
    text + "</linearGradient></defs>"
}

fn area([from, to]: [DVec2; 2]) -> String {
    let [x, y, width, height] = [from.x, from.y, to.x - from.x, to.y - from.y].map(number);
    format!(r#"x="{x}" y="{y}" width="{width}" height="{height}""#)
}

fn path(steps: &[Step]) -> String {
    let mut text = String::new();
    for (n, step) in steps.iter().enumerate() {
        let _ = match *step {
            Step::Move(to) => write!(text, "{}M{}", if n > 0 { "Z" } else { "" }, point(to)),
            Step::Line(to) => write!(text, "L{}", point(to)),
            Step::Curve([a, b, c]) => write!(text, "C{} {} {}", point(a), point(b), point(c)),
        };
    }
    text + if steps.is_empty() { "" } else { "Z" }
}

fn point(at: DVec2) -> String {
    format!("{},{}", number(at.x), number(at.y))
}

fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Text of an element or an attribute. XML has no control characters.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for letter in text.chars() {
        match letter {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            letter if letter.is_control() => escaped.push(' '),
            letter => escaped.push(letter),
        }
    }
    escaped
}
