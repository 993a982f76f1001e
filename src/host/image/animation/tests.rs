use super::*;
use ::image::AnimationDecoder;
use ::image::codecs::{gif::GifDecoder, png::PngDecoder};
use std::io::BufReader;

/// Few colours, different in every frame, opaque and transparent.
fn frame(n: u32) -> Frame {
    let pixel = |i: u32| {
        let a = [1.0, 0.4, 0.0][(i % 3) as usize];
        [a * n as f32 / 8.0, a * (i / 7) as f32 / 5.0, a * 0.5, a]
    };
    Frame::new(viewport(), (0..35).map(pixel).collect())
}

fn viewport() -> Viewport {
    Viewport::new(7, 5).unwrap()
}

fn written(name: &str, frames: u32, rate: u32, background: Background) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let mut animation = Animation::create(&path, viewport(), frames, rate, background).unwrap();
    for n in 0..frames {
        assert!(!path.exists());
        animation.add(&frame(n)).unwrap();
    }
    animation.finish().unwrap();
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    (folder, path)
}

/// Frames read by another decoder, and their total duration in milliseconds.
fn decoded<'a>(decoder: impl AnimationDecoder<'a>) -> (Vec<Vec<u8>>, f64) {
    let frames = decoder.into_frames().collect_frames().unwrap();
    let time = |frame: &::image::Frame| {
        let (numerator, denominator) = frame.delay().numer_denom_ms();
        f64::from(numerator) / f64::from(denominator)
    };
    let all = frames.iter().map(time).sum();
    (frames.into_iter().map(|frame| frame.into_buffer().into_raw()).collect(), all)
}

fn expected(frames: u32, background: Background) -> Vec<Vec<u8>> {
    (0..frames).map(|n| frame(n).to_rgba8(background)).collect()
}

#[test]
fn gifs_come_back() {
    let background = Background::Color([1.0, 0.5, 0.0]);
    let (_folder, path) = written("a.gif", 7, 30, background);
    let (frames, time) = decoded(GifDecoder::new(BufReader::new(std::fs::File::open(path).unwrap())).unwrap());
    // 35 colours fit the palette exactly. 7/30 s is 23.3 hundredths.
    assert!(frames == expected(7, background));
    assert_eq!(time, 230.0);
}

#[test]
fn animated_pngs_come_back() {
    for background in [Background::Transparent, Background::Color([0.0, 0.5, 1.0])] {
        let (_folder, path) = written("a.apng", 4, 50, background);
        let decoder = PngDecoder::new(BufReader::new(std::fs::File::open(path).unwrap())).unwrap();
        assert!(decoder.is_apng().unwrap());
        let (frames, time) = decoded(decoder.apng().unwrap());
        assert!(frames == expected(4, background), "{background:?}");
        assert_eq!(time, 80.0);
    }
}

#[test]
fn what_is_not_finished_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.gif", "a.apng"] {
        let path = folder.path().join(name);
        std::fs::write(&path, "old").unwrap();
        let mut animation = Animation::create(&path, viewport(), 3, 25, Background::BLACK).unwrap();
        animation.add(&frame(0)).unwrap();
        drop(animation);
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        std::fs::remove_file(path).unwrap();
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn what_formats_do_not_have_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |name: &str, frames, rate, background| {
        let created = Animation::create(&folder.path().join(name), viewport(), frames, rate, background);
        created.err().unwrap().to_string()
    };
    assert!(refused("a.webm", 2, 25, Background::BLACK).contains(".gif, .apng or .mp4"));
    assert!(refused("a.gif", 2, 25, Background::Transparent).contains(".apng"));
    assert!(refused("a.mp4", 2, 25, Background::Transparent).contains(".apng"));
    assert!(refused("a.gif", 2, 60, Background::BLACK).contains("1 to 50"));
    assert!(refused("a.apng", 2, 0, Background::BLACK).contains("1 to 120"));
    assert!(refused("a.apng", 0, 25, Background::BLACK).contains("at least 1"));
    assert!(refused("missing/a.gif", 2, 25, Background::BLACK).contains("missing"));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
