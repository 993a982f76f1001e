//! OME-XML (<https://docs.openmicroscopy.org/ome-model/latest/>): sizes, channels, and which pages hold which planes.

use super::layout::{Axis, Kind, Layout};
use crate::volume::{ChannelDescription, FrameSpacing};
use glam::DVec3;
use quick_xml::events::{BytesStart, Event};
use std::collections::BTreeMap;

/// Most planes that a description may assign to pages.
const MOST_PLANES: usize = 1 << 24;

type Attributes = BTreeMap<String, String>;

/// An image of a description.
#[derive(Debug, Default)]
pub(super) struct Image {
    pub name: String,
    /// Attributes of its pixels and of their channels.
    pixels: Attributes,
    channels: Vec<Attributes>,
    data: Vec<Data>,
}

/// Pages that hold consecutive planes.
#[derive(Debug, Default)]
struct Data {
    attributes: Attributes,
    /// Identifier and name of the file that has them.
    file: Option<(String, String)>,
}

/// A description.
#[derive(Debug, Default)]
pub(super) struct Ome {
    /// Identifier of the file.
    pub uuid: String,
    pub images: Vec<Image>,
    /// Name of the file that has the description.
    pub elsewhere: Option<String>,
}

/// The page of a plane: name of its file if that is another one, and its index among all pages of the file.
pub(super) type PlanePage = (Option<String>, usize);

impl Ome {
    /// Whether a text is a description.
    pub fn is_one(text: &str) -> bool {
        text.trim_start().starts_with('<') && text.contains("<OME") || text.contains("<OME:OME")
    }

    pub fn parse(text: &str) -> Result<Self, String> {
        let mut found = Self::default();
        let mut reader = quick_xml::Reader::from_str(text);
        // Whether text is the identifier of a file.
        let mut in_uuid = false;
        loop {
            match reader.read_event().map_err(|e| format!("its OME-XML is damaged: {e}"))? {
                Event::Start(tag) => {
                    in_uuid = tag.local_name().as_ref() == b"UUID";
                    found.tag(&tag);
                }
                Event::Empty(tag) => found.tag(&tag),
                Event::Text(text) if in_uuid => {
                    let data = found.images.last_mut().and_then(|image| image.data.last_mut());
                    if let (Some((uuid, _)), Ok(text)) = (data.and_then(|data| data.file.as_mut()), text.decode()) {
                        *uuid = text.trim().into();
                    }
                }
                Event::End(_) => in_uuid = false,
                Event::Eof => break,
                _ => {}
            }
        }
        found.images.retain(|image| !image.pixels.is_empty());
        Ok(found)
    }

    fn tag(&mut self, tag: &BytesStart) {
        let mut attributes = attributes(tag);
        let image = self.images.last_mut();
        match tag.local_name().as_ref() {
            b"OME" => self.uuid = attributes.remove("UUID").unwrap_or_default(),
            b"BinaryOnly" => self.elsewhere = attributes.remove("MetadataFile"),
            b"Image" => {
                let name = attributes.remove("Name").or_else(|| attributes.remove("ID")).unwrap_or_default();
                self.images.push(Image { name, ..Image::default() });
            }
            b"Pixels" => image.into_iter().for_each(|image| image.pixels = attributes.clone()),
            b"Channel" => image.into_iter().for_each(|image| image.channels.push(attributes.clone())),
            b"TiffData" => image.into_iter().for_each(|image| {
                image.data.push(Data { attributes: attributes.clone(), file: None });
            }),
            b"UUID" => {
                if let Some(data) = image.and_then(|image| image.data.last_mut()) {
                    data.file = Some((String::new(), attributes.remove("FileName").unwrap_or_default()));
                }
            }
            _ => {}
        }
    }

    /// The page of each plane of an image, in the order of its layout. Planes without a page are `None`. `own`: name of the file that has
    /// the description, which has `pages` pages.
    pub fn planes(&self, image: &Image, layout: &Layout, own: &str, pages: usize) -> Result<Vec<Option<PlanePage>>, String> {
        let count = layout.pages();
        if count > MOST_PLANES {
            return Err(format!("its OME-XML declares {count} planes: more than {MOST_PLANES} are not supported"));
        }
        let mut planes: Vec<Option<PlanePage>> = vec![None; count];
        let everything = [Data::default()];
        let data = if image.data.is_empty() { &everything[..] } else { &image.data };
        for Data { attributes, file } in data {
            let number = |key: &str| attributes.get(key).and_then(|text| text.trim().parse::<usize>().ok());
            let [z, t, c] = ["FirstZ", "FirstT", "FirstC"].map(|key| number(key).unwrap_or(0));
            let ifd = number("IFD");
            let file = file.as_ref().filter(|(uuid, name)| {
                let is_own = (!uuid.is_empty() && *uuid == self.uuid) || name.eq_ignore_ascii_case(own);
                !is_own && !name.is_empty()
            });
            let declared = number("PlaneCount").or_else(|| number("NumPlanes")).filter(|&n| n > 0);
            let declared = declared.or(ifd.map(|_| 1));
            // Of another file it is known only when that is opened; it has the planes up to the next one.
            let several = declared.unwrap_or(if file.is_some() { count } else { pages });
            if z >= layout.slices || t >= layout.frames || c >= layout.channels {
                return Err(format!("its OME-XML places pages at z {z}, time {t}, channel {c}, beyond its sizes: it is damaged"));
            }
            let first = layout.page(z, t, c);
            for n in 0..several.min(count - first) {
                planes[first + n] = Some((file.map(|(_, name)| name.clone()), ifd.unwrap_or(0) + n));
            }
        }
        Ok(planes)
    }
}

/// Attributes of a tag.
fn attributes(tag: &BytesStart) -> Attributes {
    let pair = |attribute: quick_xml::events::attributes::Attribute| {
        let key = String::from_utf8_lossy(attribute.key.local_name().as_ref()).into_owned();
        let raw = String::from_utf8_lossy(&attribute.value).into_owned();
        let value = quick_xml::escape::unescape(&raw).map_or_else(|_| raw.clone(), |value| value.into_owned());
        (key, value)
    };
    tag.attributes().flatten().map(pair).collect()
}

impl Image {
    /// Sizes, order and spacing. `samples`: numbers per pixel of its pages.
    pub fn layout(&self, samples: usize) -> Layout {
        let value = |key: &str| self.pixels.get(key).map(String::as_str);
        let count = |key: &str| value(key).and_then(|text| text.parse::<usize>().ok()).filter(|&n| n > 0).unwrap_or(1);
        // Micrometres by default.
        let size = |axis: &str| {
            let unit = match value(&format!("PhysicalSize{axis}Unit")) {
                Some("nm") => 1e-3,
                Some("mm") => 1e3,
                Some("cm") => 1e4,
                Some("m") => 1e6,
                _ => 1.0,
            };
            let size: f64 = value(&format!("PhysicalSize{axis}"))?.parse().ok()?;
            Some(size * unit).filter(|h| h.is_finite() && *h > 0.0)
        };
        let declared = self.channels.first().and_then(|channel| channel.get("SamplesPerPixel")?.parse().ok());
        let inside = declared.filter(|&n: &usize| n > 0).unwrap_or(samples);
        let (slices, frames, channels) = (count("SizeZ"), count("SizeT"), (count("SizeC") / inside).max(1));
        let order = value("DimensionOrder").and_then(|order| order.strip_prefix("XY")).unwrap_or_default();
        let order = Axis::order(order).unwrap_or([Axis::Channel, Axis::Slice, Axis::Frame]);
        let x = size("X").unwrap_or(1.0);
        Layout {
            kind: Kind::Ome,
            spacing: DVec3::new(x, size("Y").unwrap_or(x), size("Z").unwrap_or(x)),
            states_spacing: size("X").is_some(),
            length_unit: size("X").map(|_| "µm".into()),
            frame_spacing: value("TimeIncrement")
                .and_then(|interval| FrameSpacing::new(interval.parse().ok()?, Some(value("TimeIncrementUnit").unwrap_or("s")))),
            ..Layout::ordered(order, slices, frames, channels)
        }
    }

    /// Names and colours of the channels.
    pub fn descriptions(&self, count: usize) -> Vec<ChannelDescription> {
        self.channels.iter().take(count).map(channel).collect()
    }
}

fn channel(attributes: &Attributes) -> ChannelDescription {
    let name = ["Name", "Fluor"].iter().filter_map(|key| attributes.get(*key)).find(|name| !name.trim().is_empty()).cloned();
    // Red, green, blue and alpha in the bytes of a signed number. -1, white, is the default that many writers state.
    let color = attributes.get("Color").and_then(|text| text.parse::<i32>().ok()).filter(|&color| color != -1);
    let color = color.map(|color| [24, 16, 8].map(|shift| f64::from(color as u32 >> shift & 255) / 255.0));
    ChannelDescription { name, color, ..ChannelDescription::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(pixels: &str, inside: &str) -> Ome {
        Ome::parse(&format!("<OME UUID='urn:1'><Image Name='a'><Pixels ID='p' {pixels}>{inside}</Pixels></Image></OME>")).unwrap()
    }

    #[test]
    fn sizes_and_spacing_have_units() {
        let layout = |attributes: &str| one(attributes, "").images[0].layout(1);
        let sized = layout(
            "DimensionOrder=\"XYCZT\" SizeC='2' SizeT='3' SizeZ='5' PhysicalSizeX='0.5' PhysicalSizeZ='2000' PhysicalSizeZUnit='nm'",
        );
        assert_eq!((sized.pages(), sized.spacing), (30, DVec3::new(0.5, 0.5, 2.0)));
        // Times are in seconds by default.
        let every = |attributes: &str| layout(&format!("SizeT='3' {attributes}")).frame_spacing;
        assert_eq!(every("TimeIncrement='0.5'"), FrameSpacing::new(0.5, Some("s")));
        assert_eq!(every("TimeIncrement='20' TimeIncrementUnit='ms'"), FrameSpacing::new(20.0, Some("ms")));
        assert_eq!((every(""), every("TimeIncrement='x'")), (None, None));
        assert!(sized.states_spacing && !layout("SizeT='3'").states_spacing);
    }

    #[test]
    fn planes_have_the_pages_that_are_told() {
        let pages = |inside: &str, pages: usize| {
            let ome = one("DimensionOrder='XYZCT' SizeC='2' SizeT='1' SizeZ='2'", inside);
            let image = &ome.images[0];
            let planes = ome.planes(image, &image.layout(1), "own.tif", pages)?;
            Ok::<_, String>(planes.into_iter().map(|plane| plane.map_or(99, |(_, index)| index)).collect::<Vec<_>>())
        };
        assert_eq!(pages("", 4).unwrap(), [0, 1, 2, 3]);
        assert_eq!(pages("<TiffData/>", 4).unwrap(), [0, 1, 2, 3]);
        assert_eq!(pages("<TiffData/>", 3).unwrap(), [0, 1, 2, 99]);
        assert_eq!(pages("<TiffData IFD='3'/><TiffData FirstC='1' IFD='0' PlaneCount='2'/>", 4).unwrap(), [3, 99, 0, 1]);
        assert_eq!(pages("<TiffData FirstZ='1' PlaneCount='2'/>", 4).unwrap(), [99, 0, 1, 99]);
        assert!(pages("<TiffData FirstZ='2'/>", 4).unwrap_err().contains("beyond its sizes"));
        let ome = one(
            "SizeC='3'",
            "<TiffData IFD='0'><UUID FileName='own.tif'>urn:1</UUID></TiffData>\
             <TiffData IFD='1' FirstC='1'><UUID FileName='b.tif'>urn:2</UUID></TiffData>\
             <TiffData IFD='2' FirstC='2'><UUID FileName='renamed.tif'>urn:1</UUID></TiffData>",
        );
        let planes = ome.planes(&ome.images[0], &ome.images[0].layout(1), "own.tif", 3).unwrap();
        assert_eq!(planes, [Some((None, 0)), Some((Some("b.tif".into()), 1)), Some((None, 2))]);
    }

    #[test]
    fn channels_have_names_and_colours() {
        let ome = one(
            "SizeC='3'",
            "<Channel ID=\"c0\" Name=\"DAPI &amp; &lt;x&gt;\" Color=\"16711935\"/>\
             <OME:Channel ID='c1' Color='-1' Fluor='GFP'><LightPath/></OME:Channel><Channel ID='c2' Color='-16776961'/>",
        );
        let found = ome.images[0].descriptions(3);
        let names: Vec<_> = found.iter().map(|channel| channel.name.as_deref()).collect();
        assert_eq!(names, [Some("DAPI & <x>"), Some("GFP"), None]);
        let colors: Vec<_> = found.iter().map(|channel| channel.color).collect();
        assert_eq!(colors, [Some([0.0, 1.0, 0.0]), None, Some([1.0, 0.0, 0.0])]);
        assert_eq!(ome.images[0].descriptions(2).len(), 2);
        assert!(Ome::parse("<OME><Image>").unwrap().images.is_empty() && Ome::parse("<OME></Image>").is_err());
    }
}
