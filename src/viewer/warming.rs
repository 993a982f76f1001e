//! Programs of the frames that a page will ask for, built in the background before they are needed.

use super::painter::Painter;
use crate::renderer::ExpectedFrames;
use crate::settings::{LightGrid, Quality, Settings};
use crate::viewport::Viewport;
use std::sync::atomic::Ordering;

/// Size of the expected pictures. Programs hardly depend on it.
const SIZE: Viewport = Viewport { width: 768, height: 768 };

/// Begins the builds for the look of a page, unless they were begun before. Looks differ by the light volume; other programs are built when
/// they are needed.
pub(super) fn begin(painter: &mut Painter) {
    let scene = painter.scene.clone();
    let settings =
        [Quality::Standard, Quality::Draft, Quality::High].map(|quality| scene.host.settings(&painter.look, Some(quality)));
    let mut settings: Vec<_> = settings.into_iter().flatten().collect();
    let has_light = settings.iter().any(Settings::sweeps_light);
    if scene.warming[usize::from(has_light)].swap(true, Ordering::SeqCst) {
        return;
    }
    let Some(renderer) = painter.renderer.whole().filter(|_| scene.host.builds_ahead()) else {
        scene.ready.skip();
        return;
    };
    if has_light {
        // Pictures that follow the hand. They come first: beside a finer light volume, none of half the resolution is made.
        let moving = |settings: &Settings| Settings { light_grid: LightGrid::Half, ..*settings };
        settings = settings.iter().map(moving).chain(settings.clone()).collect();
    }
    let expected = ExpectedFrames::new(&settings, SIZE).with_parallel_views();
    scene.ready.begin();
    renderer.warm_up(&expected, move |built| {
        if let Err(error) = built {
            tracing::info!("programs could not be built ahead: {error}");
        }
        scene.ready.end();
    });
}
