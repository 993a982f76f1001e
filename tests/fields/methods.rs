//! The table of methods, fields and blend modes (`FieldKind::check_method`): frames draw what it allows and refuse the rest in its words, and
//! the guide shows it.

use crate::common::*;
use glam::DVec3;
use layersplat::layers::{Correction, Density, Kernel};
use layersplat::renderer::{Channel, ColorOpacity, LabelColors, UploadedColors, UploadedVolume};
use layersplat::settings::{Algorithm, Blend, Evaluation, FieldKind, LayerAxis, Layered, Method};
use layersplat::settings::{AmbientOcclusion, Classification, Shadows};
use layersplat::slice::{Slice, SliceAxis, SliceColors};
use layersplat::volume::LabelSurfaces;
use layersplat::{Error, Renderer, Settings, TransferFunction, Viewport, Volume};

const SIZE: Viewport = Viewport { width: 8, height: 8 };
const GUIDE: &str = include_str!("../../docs/guide/channels.md");
/// No label, and a red one.
const ENTRIES: [[f64; 4]; 2] = [[0.0; 4], [1.0, 0.0, 0.0, 1.0]];

fn algorithm(method: Method) -> Algorithm {
    let layered = |classification, evaluation| Layered { classification, evaluation, ..Layered::default() }.into();
    let (points, splats) = (
        Classification::Preintegrated { kernel: Kernel::Cubic, samples_per_layer: 1 },
        Classification::Post(Correction::SubLayers(2)),
    );
    let lattice = Evaluation::Lattice(Density::Relaxed);
    match method {
        Method::Preintegrated | Method::Depths | Method::Slices => layered(points, lattice),
        Method::Splats => layered(splats, lattice),
        Method::PreintegratedPixels => layered(points, Evaluation::Direct),
        Method::SplatPixels => layered(splats, Evaluation::Direct),
        Method::Rays => Algorithm::Raycast { kernel: Kernel::Linear, step: 0.5 },
        Method::Slicing => Algorithm::Slicing { step: 0.5 },
        Method::AxisSheets => Algorithm::AxisSheets { layer_axis: LayerAxis::Auto },
        Method::ViewSheets => Algorithm::ViewSheets { sheet_distance: 1.0 },
    }
}

fn draw(renderer: &mut Renderer, volume: &Volume, method: Method, settings: &Settings) -> Result<bool, Error> {
    let camera = parallel(volume, SIZE, 20.0, 10.0);
    match method {
        Method::Depths => Ok(renderer.depths(&camera, SIZE, settings)?.first().iter().any(|depth| depth.is_finite())),
        Method::Slices => {
            let slice = Slice::at(volume.grid(), SliceAxis::Z, 3.5, SIZE)?;
            let colors = SliceColors::Window { level: 100.0, width: 200.0 };
            Ok(largest_opacity(&renderer.slice(&slice, SIZE, Kernel::Linear, colors)?) > 0.0)
        }
        _ => Ok(largest_opacity(&renderer.render(&camera, SIZE, settings)?.0) > 0.0),
    }
}

/// Asserts that the renderer draws exactly what the table allows, and refuses the rest in its words.
#[track_caller]
fn assert_drawn(renderer: &mut Renderer, volume: &Volume, kind: FieldKind) {
    for method in Method::ALL {
        for blend in Blend::ALL.map(|blend| blend.at(120.0)) {
            let settings = Settings { blend, ..algorithm(method).into() };
            let case = format!("{} by {}, {}", kind.name(), method.name(), blend.name());
            let drawn = draw(renderer, volume, method, &settings);
            match kind.check_method(method, blend) {
                Ok(()) => assert!(drawn.unwrap_or_else(|error| panic!("{case}: {error}")), "{case}: nothing is seen"),
                Err(refusal) => assert_eq!(drawn.expect_err(&case).to_string(), refusal.to_string(), "{case}"),
            }
            if !matches!(method, Method::Depths | Method::Slices) {
                assert_eq!(kind.check(&settings).is_ok(), kind.check_method(method, blend).is_ok(), "{case}");
            }
        }
    }
    let shadows = Settings { shadows: Some(Shadows::default()), ..Settings::default() };
    let occlusion = Settings { ambient_occlusion: Some(AmbientOcclusion::default()), ..Settings::default() };
    for settings in [shadows, occlusion] {
        kind.check(&settings).unwrap();
        assert!(draw(renderer, volume, Method::Preintegrated, &settings).unwrap(), "{settings:?}");
    }
}

/// A noisy block, and a transfer function with which most of it is seen.
fn block() -> (UploadedVolume, Volume<'static>, TransferFunction) {
    let volume = random_volume([8; 3], DVec3::ONE, 5);
    (UploadedVolume::new(&device(), &volume).unwrap(), volume, smooth_transfer())
}

fn ids() -> Volume<'static> {
    Volume::new("ids", block().1.grid().clone(), vec![1u8; 512]).unwrap()
}

#[test]
fn one_field() {
    let (uploaded, volume, transfer) = block();
    assert_drawn(&mut Renderer::from_uploaded(&uploaded, &transfer).unwrap(), &volume, FieldKind::One);
}

#[test]
fn several_fields() {
    let (uploaded, volume, transfer) = block();
    let channel = Channel::new(&uploaded, &transfer);
    assert_drawn(&mut Renderer::from_channels(&[channel.clone(), channel]).unwrap(), &volume, FieldKind::Several);
}

#[test]
fn colors_among_fields() {
    let (uploaded, volume, transfer) = block();
    let components = [(); 4].map(|()| uploaded.clone());
    let colors = UploadedColors::from_components(&components, ColorOpacity::Alpha, &transfer).unwrap();
    let channels = [Channel::new(&uploaded, &transfer), Channel::from_colors(&colors).unwrap()];
    assert_drawn(&mut Renderer::from_channels(&channels).unwrap(), &volume, FieldKind::Mixed);
}

#[test]
fn colors_of_labels() {
    let (uploaded, volume, transfer) = block();
    let mut renderer = Renderer::from_uploaded(&uploaded, &transfer).unwrap();
    let colors = LabelColors::new(renderer.device(), &[(&ids(), &ENTRIES)]).unwrap();
    renderer.set_label_colors(Some(&colors)).unwrap();
    assert_drawn(&mut renderer, &volume, FieldKind::LabelColors);
}

#[test]
fn colors_and_labels() {
    let labels = UploadedVolume::new(&device(), &ids()).unwrap();
    let colors = UploadedColors::from_labels(&[(&labels, &ENTRIES)], LabelSurfaces::Smooth).unwrap();
    assert_drawn(&mut Renderer::from_colors(&colors).unwrap(), &block().1, FieldKind::Labels);
    let component = || UploadedVolume::new(&device(), &block().1).unwrap();
    let components = [component(), component(), component(), component()];
    let colors = UploadedColors::from_components(&components, ColorOpacity::Alpha, &block().2).unwrap();
    assert_drawn(&mut Renderer::from_colors(&colors).unwrap(), &block().1, FieldKind::Colors);
}

/// The blend modes with which a method draws a field, as a cell of a table.
fn cell(kind: FieldKind, method: Method) -> String {
    let (drawn, refused): (Vec<Blend>, Vec<Blend>) =
        Blend::ALL.iter().partition(|&&blend| kind.check_method(method, blend).is_ok());
    let names = |blends: &[Blend]| blends.iter().map(|blend| format!("`{}`", blend.name())).collect::<Vec<_>>().join(", ");
    match (drawn.len(), refused.len()) {
        (0, _) => "no".into(),
        (_, 0) if method == Method::Slices => "yes".into(),
        (_, 0) => "all".into(),
        (_, 1) => format!("all but {}", names(&refused)),
        _ => names(&drawn),
    }
}

#[test]
fn the_guide_shows_the_table() {
    let row = |first: &str, cells: Vec<String>| format!("| {first} | {} |\n", cells.join(" | "));
    let mut table = row("", FieldKind::ALL.map(|kind| kind.name().to_owned()).to_vec());
    table += &format!("|---{}|\n", "|---".repeat(FieldKind::ALL.len()));
    for method in Method::ALL {
        table += &row(method.name(), FieldKind::ALL.map(|kind| cell(kind, method)).to_vec());
    }
    assert!(GUIDE.contains(&table), "docs/guide/channels.md should have this table:\n{table}");
}
