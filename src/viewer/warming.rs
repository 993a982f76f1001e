//! Programs of the frames that a page will ask for, built in the background before they are needed.

use super::painter::Painter;
use super::scene::Scene;
use crate::renderer::ExpectedFrames;
use crate::settings::Quality;
use crate::viewport::Viewport;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Size of the expected pictures. Programs hardly depend on it.
const SIZE: Viewport = Viewport { width: 768, height: 768 };

/// Begins the builds with the first page of a run.
pub(super) fn begin(scene: &Arc<Scene>, painter: &mut Painter) {
    if scene.warming.swap(true, Ordering::SeqCst) {
        return;
    }
    if !scene.host.builds_ahead() {
        scene.ready.set();
        return;
    }
    let settings =
        [Quality::Standard, Quality::Draft, Quality::High].map(|quality| scene.host.settings(&painter.look, Some(quality)));
    let settings: Vec<_> = settings.into_iter().flatten().collect();
    let Some(renderer) = painter.renderer.whole() else {
        scene.ready.set();
        return;
    };
    let expected = ExpectedFrames::new(&settings, SIZE).with_parallel_views();
    let scene = scene.clone();
    renderer.warm_up(&expected, move |built| {
        if let Err(error) = built {
            tracing::info!("programs could not be built ahead: {error}");
        }
        scene.ready.set();
    });
}
