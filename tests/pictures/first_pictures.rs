//! First pictures of volumes, under their automatic transfer functions: not burnt out, and not empty.

use crate::common::{device, viewport};
use layersplat::framing::{Fixed, Framing};
use layersplat::{Frame, OpenOptions, Orbit, Renderer, Settings, TransferFunction, Volume};
use std::path::{Path, PathBuf};

/// Opacity above which a pixel counts, and the channel above which it is burnt out if all three are.
const COVERED: f32 = 0.5;
const BURNT: f32 = 0.95;
/// Largest share of the covered pixels that may be burnt out.
const ALLOWED: f64 = 0.01;

/// Head-on, where flat faces reflect the light of the camera, and the default view.
const VIEWS: [Orbit; 2] =
    [Orbit { azimuth: 0.0, elevation: 0.0, roll: 0.0 }, Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 }];

fn pictures(volume: &Volume, transfer: &TransferFunction) -> [Frame; 2] {
    let framing = Framing::visible(volume, transfer, None);
    let mut renderer = Renderer::new(&device(), volume, transfer).unwrap();
    let size = viewport(256, 256);
    VIEWS.map(|orbit| renderer.render(&framing.parallel(orbit, size, Fixed::default()), size, &Settings::default()).unwrap().0)
}

/// Number of covered pixels, and of those that are burnt out.
fn covered_and_burnt(frame: &Frame) -> (usize, usize) {
    let covered = frame.pixels().iter().filter(|pixel| pixel[3] > COVERED);
    covered.fold((0, 0), |(n, burnt), pixel| (n + 1, burnt + usize::from(pixel[..3].iter().all(|&channel| channel > BURNT))))
}

fn assert_good(source: &Path) {
    let volume = Volume::open(source, &OpenOptions::default()).unwrap();
    for (frame, orbit) in pictures(&volume, &TransferFunction::automatic(&volume)).iter().zip(VIEWS) {
        let (covered, burnt) = covered_and_burnt(frame);
        let visible = frame.pixels().iter().filter(|pixel| pixel[3] > 0.05).count();
        let what = format!("{} from {orbit:?}", source.display());
        assert!(visible > frame.pixels().len() / 200, "{what}: {visible} pixels are visible");
        assert!(burnt as f64 <= ALLOWED * covered as f64, "{what}: {burnt} of {covered} pixels are burnt out");
    }
}

#[test]
fn built_in_volumes_are_not_burnt_out() {
    for name in ["marschner-lobb", "hydrogen", "shepp-logan", "gyroid", "torus-knot", "cube"] {
        assert_good(Path::new(&format!("builtin:{name}@48")));
    }
    // The criterion notices white: a cube's faces under a white transfer function.
    let volume = Volume::open("builtin:gyroid@48", &OpenOptions::default()).unwrap();
    let white = TransferFunction::new("white", vec![(0.0, [1.0; 3])], vec![(0.0, 0.0), (128.0, 1.0)]).unwrap();
    let (covered, burnt) = covered_and_burnt(&pictures(&volume, &white)[0]);
    assert!(burnt as f64 > ALLOWED * covered as f64, "{burnt} of {covered}");
}

#[test]
#[cfg_attr(not(real_volumes), ignore = "needs ../shared/volumes or LAYERSPLAT_VOLUMES")]
fn real_volumes_are_not_burnt_out() {
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(crate::common::real_volumes()).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.to_string_lossy().ends_with(".raw.gz"));
    files.sort();
    assert!(!files.is_empty());
    files.iter().for_each(|file| assert_good(file));
}
