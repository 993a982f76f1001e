//! Tables of a line per label: `id name R G B A` (FreeSurfer, 3D Slicer), `id R G B A visible mesh "name"` (ITK-SNAP), and `id name` or
//! `id name code` (MRIcron's atlases).

use super::{Lines, wrong};
use crate::error::Error;
use crate::volume::labels::{Label, LabelTable};
use std::path::Path;

/// Begins the comment of 3D Slicer's colour tables, whose alpha is opacity. FreeSurfer's is transparency.
const SLICER: &str = "# Color table file";

#[derive(Clone, Copy, PartialEq)]
enum Layout {
    FreeSurfer,
    Slicer,
    Snap,
    Names,
}

impl Layout {
    fn expected(self) -> &'static str {
        match self {
            Layout::FreeSurfer | Layout::Slicer => "id, name, red, green, blue and alpha from 0 to 255, as '3 Liver 200 60 30 0'",
            Layout::Names => "id and name, as '3 Liver', or these and a code",
            Layout::Snap => {
                "id, red, green, blue from 0 to 255, opacity from 0 to 1, two numbers 0 or 1 and a name in quotes, as '3 200 60 30 1 1 1 \
                 \"Liver\"'"
            }
        }
    }

    fn label(self, line: &str) -> Option<Label> {
        match self {
            Layout::Snap => snap(line),
            Layout::Names => only_named(line),
            Layout::FreeSurfer | Layout::Slicer => named(line, self == Layout::Slicer),
        }
    }
}

/// Reads a table of lines.
pub(super) fn read(path: &Path, text: &str) -> Result<LabelTable, Error> {
    let is_data = |line: &&str| !line.is_empty() && !line.starts_with('#');
    let layout = match text.lines().map(str::trim).find(is_data) {
        None => return Err(Error::volume(path, "it has no labels: a table of labels has a line for each")),
        Some(line) if line.contains('"') => Layout::Snap,
        Some(line) if (2..=3).contains(&line.split_whitespace().count()) => Layout::Names,
        Some(_) if text.lines().any(|line| line.starts_with(SLICER)) => Layout::Slicer,
        Some(_) => Layout::FreeSurfer,
    };
    let mut lines = Lines::new(path);
    for (line, number) in text.lines().map(str::trim).zip(1..) {
        if !is_data(&line) {
            continue;
        }
        let shortened: String = line.chars().take(80).collect();
        let label = layout.label(line);
        let label =
            label.ok_or_else(|| wrong(path, number, format!("'{shortened}' is no label: expected {}", layout.expected())))?;
        lines.add(number, label)?;
    }
    let mut labels = lines.labels;
    if layout == Layout::FreeSurfer && labels.iter().all(|label| label.opacity == 0.0) {
        // Some programs write 255 for opaque into this format (SimNIBS). A table of nothing but transparent labels has no other use.
        labels.iter_mut().for_each(|label| label.opacity = 1.0);
    }
    LabelTable::new(labels)
}

/// A byte as a fraction of 255.
fn share(word: &str) -> Option<f64> {
    word.parse::<u8>().ok().map(|byte| f64::from(byte) / 255.0)
}

/// `id name R G B A`.
fn named(line: &str, alpha_is_opacity: bool) -> Option<Label> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let &[id, name, r, g, b, a] = &words[..] else { return None };
    let color = [share(r)?, share(g)?, share(b)?];
    let alpha = share(a)?;
    let opacity = if alpha_is_opacity { alpha } else { 1.0 - alpha };
    Some(Label { id: id.parse().ok()?, name: Some(name.into()), color, opacity, visible: true })
}

/// `id name` or `id name code`.
fn only_named(line: &str) -> Option<Label> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let (&[id, name] | &[id, name, _]) = &words[..] else { return None };
    Some(Label { name: Some(name.into()), ..Label::new(id.parse().ok()?) })
}

/// `id R G B A visible mesh "name"`.
fn snap(line: &str) -> Option<Label> {
    let (numbers, name) = line.split_once('"')?;
    let (name, rest) = name.rsplit_once('"')?;
    let words: Vec<&str> = numbers.split_whitespace().collect();
    let &[id, r, g, b, a, visible, mesh] = &words[..] else { return None };
    let flag = |word: &str| ["0", "1"].iter().position(|flag| *flag == word).map(|n| n == 1);
    flag(mesh)?;
    let opacity = a.parse().ok().filter(|a| (0.0..=1.0).contains(a))?;
    let color = [share(r)?, share(g)?, share(b)?];
    let named = Some(name.trim()).filter(|name| !name.is_empty()).map(Into::into);
    rest.trim().is_empty().then_some(())?;
    Some(Label { id: id.parse().ok()?, name: named, color, opacity, visible: flag(visible)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Result<LabelTable, String> {
        read(Path::new("t.txt"), text).map_err(|e| e.to_string())
    }

    #[test]
    fn lines_of_each_program_are_labels() {
        let free_surfer =
            table("#$Id: x\n\n0 Unknown 0 0 0 0\n2  Left-White-Matter 245 245 245 0\r\n17 1 220 216 20 255\n").unwrap();
        assert_eq!(free_surfer.labels().len(), 2);
        let white = free_surfer.get(2).unwrap();
        assert_eq!((white.name.as_deref(), white.color, white.opacity), (Some("Left-White-Matter"), [245.0 / 255.0; 3], 1.0));
        assert_eq!(free_surfer.get(17).map(|label| (label.opacity, label.name.as_deref())), Some((0.0, Some("1"))));
        // Where all would be transparent, alpha is opacity.
        let opaque = table("2 White 245 245 245 255\n3 Grey 205 62 78 255\n").unwrap();
        assert!(opaque.labels().iter().all(|label| label.opacity == 1.0));
        // In a table of Slicer, alpha is opacity.
        let slicer = table("# Color table file /a.ctbl\n# 2 values\n1 tissue 128 174 128 255\n").unwrap();
        assert_eq!(slicer.get(1).unwrap().opacity, 1.0);
        let snap = table(
            "################\n# ITK-SnAP Label Description File\n    0     0    0    0        0  0  0    \"Clear Label\"\n    \
             7   255    0  127        0.4  0  1    \"Left \"big\" one\"\n",
        )
        .unwrap();
        let atlas = table("1 Precentral_L 2001\n2 Precentral_R 2002\n").unwrap();
        assert_eq!(atlas.get(2), Some(&Label { name: Some("Precentral_R".into()), ..Label::new(2) }));
        let one = snap.get(7).unwrap();
        assert_eq!((one.name.as_deref(), one.opacity, one.visible), (Some("Left \"big\" one"), 0.4, false));
        assert_eq!((one.color, snap.labels().len()), ([1.0, 0.0, 127.0 / 255.0], 1));
    }

    #[test]
    fn malformed_lines_are_named() {
        for (text, expected) in [
            ("# nothing\n", "t.txt: it has no labels"),
            ("1 A 1 2 3 0\n1 B 1 2 3 0\n", "t.txt, line 2: label 1 is in line 1, too"),
            ("1 A 1 2 3 0\n\n2 B 1 2 256 0\n", "t.txt, line 3: '2 B 1 2 256 0' is no label: expected id, name"),
            ("-1 A 1 2 3 0\n", "line 1: '-1 A 1 2 3 0'"),
            ("4294967296 A 1 2 3 0\n", "line 1"),
            ("1 A 1 2 3\n", "line 1"),
            ("1 A B 1 2 3 0\n", "line 1"),
            ("1 1 2 3 0.5 1 1 \"A\"\n2 1 2 3 1.5 1 1 \"B\"\n", "line 2: '2 1 2 3 1.5 1 1 \"B\"' is no label: expected id, red"),
            ("1 1 2 3 1 2 1 \"A\"\n", "line 1"),
            ("1 1 2 3 1 1 1 \"A\n", "line 1"),
            ("1 1 2 3 1 1 1 \"A\" x\n", "line 1"),
        ] {
            let message = table(text).unwrap_err();
            assert!(message.contains(expected), "{text}: {message}");
        }
    }
}
