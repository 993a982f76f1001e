//! A picture as a program in Python, for the package `layersplat`.

use super::arguments::Source;
use super::first_fields::FirstFields;
use super::given::{GivenOption, GivenOptions};
use crate::camera::{Camera, Projection};
use crate::image::Background;
use crate::settings::Settings;
use crate::viewer::{Look, SavedFormat, Wanted};
use glam::DVec3;
use std::fmt::Display;

/// Options of how a volume is read that the program has, too. The camera is in the world, whatever is up.
const READING: [&str; 3] = ["dims", "up", "voxel_type"];
/// Options of layers that no argument of `Settings` stands for.
const WITHOUT_ARGUMENT: [&str; 3] = ["classification", "correction", "footprints"];

/// The program. What it cannot do is said in a comment.
pub(super) fn program(
    given: &GivenOptions,
    fields: &FirstFields,
    source: &Source,
    wanted: &Wanted,
    settings: &Settings,
) -> String {
    let &Wanted { look, view, size, samples, format, transfer, .. } = wanted;
    let (width, height) = (size.width, size.height);
    let mut lines = vec!["import layersplat".to_owned()];
    let is_averaged = samples > 1 || format == SavedFormat::Exr;
    lines.push(if is_averaged { "import numpy as np" } else { "from PIL import Image" }.into());
    if is_averaged && format == SavedFormat::Png {
        lines.push("from PIL import Image".into());
    }
    lines.push(String::new());
    let fields = fields.missing_in_python().map(str::to_owned);
    let is_curved = settings.curve() != Settings::default().curve() && is_averaged && format == SavedFormat::Png;
    let curve = is_curved.then(|| "gamma, exposure and tone curve, which are those of one sample per pixel".to_owned());
    lines.extend(fields.into_iter().chain(missing(given, look)).chain(curve).map(|what| format!("# Not included: {what}.")));
    lines.push(format!(
        "volume = layersplat.Volume.open({})",
        arguments(vec![string(&source.volume)], reading(given, source.frame))
    ));
    lines.push(format!("transfer = layersplat.TransferFunction.open({}, volume)", string(transfer)));
    lines.push(format!("settings = layersplat.Settings({})", arguments(Vec::new(), settings.arguments())));
    lines.push(format!("camera = layersplat.Camera({})", camera(&view)));
    lines.push("renderer = layersplat.Renderer(volume, transfer)".into());
    lines.extend(label_colors(given, look));
    let background = string(&look.background);
    if !is_averaged {
        lines.push(format!("picture = renderer.render(camera, ({width}, {height}), settings, background={background})"));
    } else {
        let rendered = (width * samples, height * samples);
        lines.push(format!("n = {samples}"));
        lines.push(format!("frame = renderer.render_float(camera, {rendered:?}, settings).astype(np.float64)"));
        lines.push("frame = sum(frame[y::n, x::n] for y in range(n) for x in range(n)) / (n * n)".into());
        lines.push("frame = frame.astype(np.float32)".into());
        lines.extend(displayed(look, format));
    }
    lines.push(match format {
        SavedFormat::Png => r#"Image.fromarray(picture).save("layersplat.png")"#.into(),
        SavedFormat::Exr => r#"np.save("layersplat.npy", picture)  # the numbers of the .exr file"#.into(),
    });
    lines.join("\n") + "\n"
}

/// The line that draws the volume in the colours of labels.
fn label_colors(given: &GivenOptions, look: &Look) -> Option<String> {
    let file = value(&given.reading, "label_colors")?;
    let table = given.reading.iter().find(|option| option.id == "labels").and_then(|option| option.words[0].split_once('='));
    let options = given.reading.iter().filter(|option| option.id == "label").flat_map(|option| &option.words);
    let changes: Vec<String> = options.skip(1).step_by(2).cloned().chain(look.labels.words()).map(|word| string(&word)).collect();
    let mut named = Vec::new();
    named.extend(table.map(|(_, table)| ("table", string(table))));
    named.extend((!changes.is_empty()).then(|| ("changes", format!("[{}]", changes.join(", ")))));
    let labels = format!("layersplat.Labels.open({})", arguments(vec![string(file)], named));
    Some(format!("renderer.set_label_colors({labels})"))
}

/// Lines that put a frame over the background, and make 8 bits of it.
fn displayed(look: &Look, format: SavedFormat) -> Vec<String> {
    let mut lines = Vec::new();
    match look.background() {
        Ok(Background::Color(color)) => {
            lines.push(format!("below = np.array({} + (1.0,), np.float32)", tuple(color.map(f64::from))));
            lines.push("through = (1 - frame[..., 3:]).astype(np.float64)".into());
            lines.push("picture = (through * below + frame).astype(np.float32)".into());
            lines.push("picture[..., 3] = 1".into());
        }
        _ if format == SavedFormat::Exr => lines.push("picture = frame".into()),
        _ => {
            lines.push("alpha = frame[..., 3:]".into());
            lines.push("picture = np.divide(frame, alpha, out=np.zeros_like(frame), where=alpha > 0)".into());
            lines.push("picture[..., 3:] = alpha".into());
        }
    }
    if format == SavedFormat::Png {
        let bytes = "picture = np.clip(picture.astype(np.float64) * 255 + 0.5, 0, 255).astype(np.float32).astype(np.uint8)";
        lines.push(bytes.into());
    }
    lines
}

/// What the program leaves out.
fn missing(given: &GivenOptions, look: &Look) -> Vec<String> {
    let colors_labels = |option: &&GivenOption| {
        value(&given.reading, "label_colors").is_some() && ["label_colors", "labels", "label"].contains(&option.id.as_str())
    };
    let reading = given.reading.iter().filter(|option| !READING.contains(&option.id.as_str()) && !colors_labels(option));
    let is_missing =
        |option: &&GivenOption| WITHOUT_ARGUMENT.contains(&option.id.as_str()) || option.words == ["--lattice", "direct"];
    let options = reading.chain(given.drawing.iter().filter(is_missing));
    let mut all: Vec<String> = options.map(|option| option.words.join(" ")).collect();
    if look.legend || look.bounding_box || look.axes {
        all.push("legend, box and axes, which the command draws".into());
    }
    all
}

/// Arguments of a call.
fn arguments(mut first: Vec<String>, named: Vec<(&str, impl Display)>) -> String {
    first.extend(named.into_iter().map(|(name, value)| format!("{name}={value}")));
    first.join(", ")
}

fn reading(given: &GivenOptions, frame: Option<usize>) -> Vec<(&'static str, String)> {
    let mut named = Vec::new();
    if let Some(dims) = value(&given.reading, "dims") {
        named.push(("dims", format!("({})", dims.replace(['x', 'X'], ", "))));
    }
    if let Some(voxel_type) = value(&given.reading, "voxel_type") {
        named.push(("voxel_type", string(voxel_type)));
    }
    named.extend(frame.map(|frame| ("frame", frame.to_string())));
    named
}

fn camera(camera: &Camera) -> String {
    let vector = |v: DVec3| tuple(v.to_array());
    let projection = match camera.projection {
        Projection::Parallel { scale } => format!("scale={scale}"),
        Projection::Perspective { field_of_view } => format!("field_of_view={field_of_view}"),
    };
    let [position, focal_point, view_up] = [camera.position, camera.focal_point, camera.view_up].map(vector);
    format!("{position}, {focal_point}, {view_up}, {projection}")
}

/// The value of a given option.
fn value<'a>(options: &'a [GivenOption], id: &str) -> Option<&'a str> {
    options.iter().find(|option| option.id == id).and_then(|option| option.words.get(1)).map(String::as_str)
}

fn tuple([x, y, z]: [f64; 3]) -> String {
    format!("({x}, {y}, {z})")
}

/// A string literal.
fn string(text: &str) -> String {
    let escaped = text.chars().flat_map(|c| match c {
        '"' | '\\' => vec!['\\', c],
        c if c.is_control() => vec![' '],
        c => vec![c],
    });
    format!("\"{}\"", escaped.collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Orbit;
    use crate::cli::browser::arguments;
    use crate::settings::FieldKind;
    use crate::settings::{Blend, Quality};
    use crate::viewer::{PageCamera, PageLight};
    use crate::viewport::Viewport;

    fn text(given: &GivenOptions, look: &Look, samples: u32, format: SavedFormat) -> String {
        let view = Camera::orbit(DVec3::new(1.5, 2.0, 3.0), 10.0, Orbit::default(), Projection::Parallel { scale: 4.25 });
        let camera = PageCamera::new(&view, Orbit::default());
        let size = Viewport { width: 30, height: 20 };
        let transfer = "layersplat.json";
        let source = Source { volume: given.volume.clone(), frame: Some(2) };
        program(
            given,
            &FirstFields::new(FieldKind::One, look),
            &source,
            &Wanted { look, camera: &camera, view, size, samples, format, transfer, others: &[], length_units: None },
            &arguments::settings(given, look, look.quality, true).unwrap(),
        )
    }

    /// The package itself draws the same bits: tests/viewer/python.
    #[test]
    fn every_part_of_a_look_is_an_argument() {
        let option =
            |id: &str, word: &str| GivenOption { id: id.into(), words: vec![format!("--{}", id.replace('_', "-")), word.into()] };
        let drawing = vec![
            option("sublayers", "2"),
            option("shadow_forgiveness", "3"),
            option("gradient_opacity", "5:0,20:1"),
            option("unit_distance", "0.5"),
        ];
        let reading = vec![option("dims", "4x5x6"), option("device", "1")];
        let given = GivenOptions { volume: r#"a "name".raw"#.into(), reading, drawing, ..GivenOptions::default() };
        let light = PageLight { direction: Some([1.0, 0.5, 0.0]), strength: 0.7, angle: 3.0, color: [1.0, 0.5, 0.0] };
        let look = Look {
            quality: Some(Quality::High),
            blend: Blend::Iso(0.0),
            iso: 61.5,
            lights: vec![light, PageLight { direction: None, color: [1.0; 3], ..light }],
            lights_follow: true,
            shadows: true,
            gradient: Some("sobel".into()),
            crop: Some([[0.0; 3], [1.0, 2.0, 3.0]]),
            clips: vec![[1.0, 2.0, 3.0, 0.0, 0.0, -1.0]],
            axes: true,
            ..Look::of(&Settings::default(), Background::BLACK, 0.0, [4; 3])
        };
        let made = text(&given, &look, 1, SavedFormat::Png);
        assert!(!made.contains("set_label_colors"));
        for part in [
            r#"Volume.open("a \"name\".raw", dims=(4, 5, 6), frame=2)"#,
            "# Not included: --device 1.",
            "# Not included: legend, box and axes",
            r#"quality="high", samples_per_layer=2, blend=("iso", 61.5), shading="#,
            r#"shading={"light": [((1, 0.5, 0), 0.7, 3, (1, 0.5, 0)), (None, 0.7)]}, light_space="camera""#,
            r#"shadows={"strength": 1, "forgiveness": 3}, gradient="sobel", gradient_opacity=[(5, 0), (20, 1)]"#,
            "crop=((0, 0, 0), (1, 2, 3)), planes=[((1, 2, 3), (0, 0, -1))], unit_distance=0.5)",
            "Camera((1.5, 2, 13), (1.5, 2, 3), (0, 1, 0), scale=4.25)",
            r##"(30, 20), settings, background="#000000")"##,
        ] {
            assert!(made.contains(part), "{part} in {made}");
        }
        assert!(text(&given, &look, 3, SavedFormat::Exr).contains("camera, (90, 60), settings"));
    }

    #[test]
    fn labels_that_color_the_volume_are_given_to_the_renderer() {
        let option = |id: &str, words: &[&str]| GivenOption { id: id.into(), words: words.iter().map(|&w| w.into()).collect() };
        let reading = vec![
            option("label_colors", &["--label-colors", "ids.nrrd"]),
            option("labels", &["--labels=table.txt"]),
            option("label", &["--label", "3:hide", "--label", "liver:0.5"]),
        ];
        let given = GivenOptions { volume: "ct.nii".into(), reading, ..GivenOptions::default() };
        let mut look = Look::of(&Settings::default(), Background::BLACK, 0.0, [4; 3]);
        look.labels.hidden.push("7".into());
        let made = text(&given, &look, 1, SavedFormat::Png);
        let line = r#"renderer.set_label_colors(layersplat.Labels.open("ids.nrrd", table="table.txt", changes=["3:hide", "liver:0.5", "7:hide"]))"#;
        assert!(made.contains(line) && !made.contains("Not included"), "{made}");
    }
}
