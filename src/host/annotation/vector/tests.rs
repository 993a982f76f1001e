use super::*;
use crate::annotation::{Legend, LegendEntry};
use std::num::NonZeroU16;

const SIZE: Viewport = Viewport { width: 400, height: 300 };
const DESCRIPTION: &str = "command \"a <b> & c\"\nin µm³";
/// Numbers in the files have three places.
const ROUNDING: f64 = 0.001;

fn transfer() -> TransferFunction {
    TransferFunction::new("t", vec![(0.0, [1.0, 0.0, 0.0]), (100.0, [0.0, 0.0, 1.0])], vec![(0.0, 0.0), (100.0, 1.0)]).unwrap()
}

fn document(format: VectorFormat, background: Background, dpi: Option<u16>, font_size: Option<f64>) -> Vec<u8> {
    let annotations = Annotations { units: Some("<HU> m³".into()), font_size, ..Annotations::default() };
    let encoding = Encoding { dpi: dpi.and_then(NonZeroU16::new), description: Some(DESCRIPTION.into()), ..Encoding::default() };
    annotations.legend_document(SIZE, &transfer(), Blend::Composite, background, format, &encoding).unwrap()
}

/// Width and height of the picture of the colour bar.
fn pixels(font_size: Option<f64>) -> [f64; 2] {
    let annotations = Annotations { units: Some("<HU> m³".into()), font_size, ..Annotations::default() };
    let frame = annotations.legend_alone(SIZE, &transfer(), Blend::Composite, Background::BLACK).unwrap();
    [frame.width().into(), frame.height().into()]
}

/// Name of an element, and its attributes.
#[cfg(feature = "vtk")]
type Element = (String, Vec<(String, String)>);

#[cfg(feature = "vtk")]
fn elements(svg: &str) -> Result<Vec<Element>, Box<dyn std::error::Error>> {
    use quick_xml::events::Event;
    let mut reader = quick_xml::Reader::from_str(svg);
    let (mut found, mut depth) = (Vec::new(), 0);
    loop {
        let event = reader.read_event()?;
        match &event {
            Event::Start(element) | Event::Empty(element) => {
                let mut attributes = Vec::new();
                for attribute in element.attributes() {
                    let attribute = attribute?;
                    let key = String::from_utf8(attribute.key.as_ref().to_vec())?;
                    attributes.push((key, attribute.unescape_value()?.into_owned()));
                }
                found.push((String::from_utf8(element.name().as_ref().to_vec())?, attributes));
                depth += i32::from(matches!(event, Event::Start(_)));
            }
            Event::End(_) => depth -= 1,
            Event::Text(text) => drop(text.decode()?),
            Event::Eof if depth == 0 => return Ok(found),
            Event::Eof => return Err("an element is not closed".into()),
            _ => {}
        }
    }
}

#[cfg(feature = "vtk")]
#[test]
fn svg_has_all_shapes_and_labels() {
    let svg = String::from_utf8(document(VectorFormat::Svg, Background::BLACK, None, None)).unwrap();
    let elements = elements(&svg).unwrap();
    let of = |name: &str| elements.iter().filter(|(found, _)| found == name).map(|(_, all)| all.clone()).collect::<Vec<_>>();
    let value = |all: &[(String, String)], key: &str| all.iter().find(|(found, _)| found == key).map(|(_, value)| value.clone());
    let labels: Vec<String> = of("path").iter().filter_map(|path| value(path, "aria-label")).collect();
    assert_eq!(labels, ["0", "20", "40", "60", "80", "100", "<HU> m³"]);
    assert!(of("path").iter().all(|path| value(path, "d").unwrap().starts_with('M')));
    // The page, the bar, four sides of the border and six ticks; the profile.
    assert_eq!((of("rect").len(), of("polygon").len(), of("linearGradient").len()), (12, 1, 1));
    let stops = of("stop");
    let colors: Vec<String> = [stops.first(), stops.last()].map(|stop| value(stop.unwrap(), "stop-color").unwrap()).into();
    assert_eq!(colors, ["#0000ff", "#ff0000"], "values ascend upwards");
    // Letters on transparent pages have a halo, and no rectangle behind them.
    let clear = String::from_utf8(document(VectorFormat::Svg, Background::Transparent, None, None)).unwrap();
    let clear = self::elements(&clear).unwrap();
    assert_eq!(clear.iter().filter(|(name, _)| name == "rect").count(), 11);
    assert_eq!(clear.iter().filter(|(name, _)| name == "path").count(), 14);
    // Damage is noticed.
    assert!(self::elements(&svg.replace("&lt;HU", "\"HU")).is_err() && self::elements(&svg.replace("</g>", "")).is_err());
}

/// The objects that the cross-reference table names, checked against the bytes that they begin with.
fn objects(pdf: &[u8]) -> Result<Vec<&[u8]>, String> {
    let find = |word: &[u8], from: usize| pdf[from..].windows(word.len()).position(|bytes| bytes == word).map(|at| at + from);
    let last = pdf.windows(9).rposition(|bytes| bytes == b"startxref").ok_or("no startxref")?;
    let table = String::from_utf8_lossy(&pdf[last + 10..]).lines().next().and_then(|line| line.parse::<usize>().ok());
    let table = table.ok_or("no place of the table")?;
    let lines = pdf.get(table..).and_then(|bytes| bytes.strip_prefix(b"xref\n0 ")).ok_or("no table at its place")?;
    let count: usize = String::from_utf8_lossy(&lines[..lines.iter().position(|&b| b == b'\n').unwrap()]).parse().unwrap();
    let first = find(b"\n", table + 5).unwrap() + 1;
    let entry = |n: usize| &pdf[first + 20 * n..first + 20 * (n + 1)];
    if entry(0) != b"0000000000 65535 f \n" {
        return Err("no free entry".into());
    }
    let object = |n: usize| {
        let start: usize = String::from_utf8_lossy(&entry(n)[..10]).parse().map_err(|_| format!("entry {n}"))?;
        let head = format!("{n} 0 obj\n");
        let bytes = pdf[start..].strip_prefix(head.as_bytes()).ok_or(format!("object {n} is not at {start}"))?;
        let end = bytes.windows(8).position(|bytes| bytes == b"\nendobj\n").ok_or(format!("object {n} has no end"))?;
        Ok(&bytes[..end])
    };
    (1..count).map(object).collect()
}

#[test]
fn pdf_has_a_right_cross_reference_table_and_right_lengths() {
    for background in [Background::BLACK, Background::Transparent] {
        let pdf = document(VectorFormat::Pdf, background, None, None);
        let objects = objects(&pdf).unwrap();
        assert_eq!(objects.len(), 7);
        for stream in objects.iter().filter(|object| object.ends_with(b"endstream")) {
            let at = stream.windows(7).position(|bytes| bytes == b"stream\n").unwrap();
            let length = String::from_utf8_lossy(&stream[..at]).into_owned();
            let length: usize = length.split("/Length ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
            assert_eq!(&stream[at + 7 + length..], b"\nendstream");
        }
        let content = String::from_utf8(objects[3].to_vec()).unwrap();
        // Bar, profile, border and ticks, and one filled path for each label.
        let page = usize::from(background == Background::BLACK);
        assert_eq!(content.matches(" re f").count(), page + 1 + 4 + 6);
        assert_eq!(content.matches("h f").count(), 1 + 7);
        assert_eq!(content.contains("/Halo gs"), page == 0);
        // The metadata is the description.
        let hex: String = DESCRIPTION.encode_utf16().map(|unit| format!("{unit:04X}")).collect();
        assert!(String::from_utf8_lossy(objects[6]).contains(&hex));
        // A byte more moves objects away from their places.
        let mut moved = pdf.clone();
        moved.insert(9, b' ');
        assert!(self::objects(&moved).is_err());
    }
}

/// A list of names has a swatch for each, and no gradient.
#[test]
fn lists_of_names_have_swatches() {
    let entries = vec![LegendEntry::new("Leber <1>", [1.0, 0.0, 0.0]), LegendEntry::new("Milz", [0.0, 0.4, 1.0])];
    let annotations = Annotations { list: Some(Legend { entries }), ..Annotations::default() };
    let of = |format: VectorFormat| {
        let (background, encoding) = (Background::Color([1.0; 3]), Encoding::default());
        annotations.legend_document(SIZE, &transfer(), Blend::Composite, background, format, &encoding).unwrap()
    };
    let svg = String::from_utf8(of(VectorFormat::Svg)).unwrap();
    // The page, two swatches, and four sides around each.
    assert_eq!((svg.matches("<rect ").count(), svg.matches("linearGradient").count()), (1 + 2 + 8, 0));
    assert!(svg.contains(r##"fill="#ff0000""##) && svg.contains(r##"fill="#0066ff""##), "{svg}");
    assert!(svg.contains(r#"aria-label="Leber &lt;1&gt;""#) && svg.contains("<title>Legend</title>"));
    let pdf = of(VectorFormat::Pdf);
    let objects = objects(&pdf).unwrap();
    assert_eq!(objects.len(), 5);
    let content = String::from_utf8(objects[3].to_vec()).unwrap();
    assert_eq!((content.matches(" re f").count(), content.matches("h f").count()), (1 + 2 + 8, 2));
    assert!(content.contains("0 0.4 1 rg") && !content.contains("/Pattern"), "{content}");
    // The picture has the size of the page.
    let frame = annotations.legend_alone(SIZE, &transfer(), Blend::Composite, Background::BLACK).unwrap();
    assert!(svg.contains(&format!(
        r#"width="{}pt" height="{}pt""#,
        number(f64::from(frame.width()) * 0.75),
        number(f64::from(frame.height()) * 0.75)
    )));
}

/// Sizes in points are those of the picture at its resolution.
#[test]
fn sizes_follow_letters_and_resolution() {
    for (dpi, font_size) in [(None, None), (Some(72), None), (Some(300), Some(33.0)), (Some(600), Some(33.0))] {
        let expected = pixels(font_size).map(|side| side * dpi.map_or(0.75, |dpi| 72.0 / f64::from(dpi)));
        let svg = String::from_utf8(document(VectorFormat::Svg, Background::BLACK, dpi, font_size)).unwrap();
        let side = |key: &str| svg.split(&format!(" {key}=\"")).nth(1).unwrap().split("pt\"").next().unwrap().to_owned();
        let pdf = String::from_utf8_lossy(&document(VectorFormat::Pdf, Background::BLACK, dpi, font_size)).into_owned();
        let media = pdf.split("/MediaBox [0 0 ").nth(1).unwrap().split(']').next().unwrap().to_owned();
        for found in [[side("width"), side("height")], media.split_once(' ').map(|(x, y)| [x.into(), y.into()]).unwrap()] {
            let found = found.map(|number: String| number.parse::<f64>().unwrap());
            assert!(
                (0..2).all(|i| (found[i] - expected[i]).abs() <= ROUNDING),
                "{dpi:?}, {font_size:?}: {found:?}, {expected:?}"
            );
        }
    }
    assert!(pixels(Some(33.0))[0] > pixels(None)[0]);
}

#[test]
fn encodings_of_pixels_are_refused() {
    use crate::image::BitDepth::Sixteen;
    for format in [VectorFormat::Svg, VectorFormat::Pdf] {
        let deep = Encoding { bits: Some(Sixteen), ..Encoding::default() };
        let dithered = Encoding { dither: true, ..Encoding::default() };
        assert_eq!(format.check(&deep).unwrap_err().fields(), ["bits"]);
        assert_eq!(format.check(&dithered).unwrap_err().fields(), ["dither"]);
        assert!(format.check(&Encoding::default()).is_ok());
    }
}
