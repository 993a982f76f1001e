//! Saved pictures, and the commands that make the same ones.

use super::keeper::{Maker, Order, PageRenderer};
use super::look::{Look, PageQuality};
use super::painter::Painter;
use super::protocol::{Format, PageCamera, Picture, Reply, Step};
use super::scene::Scene;
use super::session::Outgoing;
use crate::error::Error;
use crate::image::Encoding;
use crate::transfer::{FileFormat, TransferFunction};
use crate::viewport::Viewport;
use std::io;
use std::path::Path;

/// Name of the transfer function's file beside a command.
pub(super) const TRANSFER_NAME: &str = "layersplat.json";

/// The look of what is saved: of the chosen quality, `high` if none is chosen.
pub(super) fn saved_look(look: &Look) -> Look {
    Look { quality: look.quality.or(Some(PageQuality::High)), ..look.clone() }
}

impl Maker {
    /// Renders a picture as the command does, and sends it as the command writes it.
    pub(super) fn save(
        &self,
        order: &Order,
        renderer: &mut PageRenderer,
        camera: &PageCamera,
        (size, samples): (Viewport, u32),
    ) -> Result<(), Error> {
        let look = saved_look(&order.look);
        let settings = self.scene.host.settings(&look, None)?;
        let view = self.scene.camera(camera)?;
        let rendered = Viewport::new(size.width * samples, size.height * samples)?;
        self.scene.host.require_checked(&view, rendered, &settings)?;
        let (Some(frame), _) = renderer.render(&view, rendered, &settings)? else { return Ok(()) };
        let frame = if samples > 1 { frame.averaged(samples)? } else { frame };
        let failed = |e: io::Error| Error::write(Path::new("the picture"), e);
        let folder = tempfile::tempdir().map_err(failed)?;
        let path = folder.path().join("picture.png");
        let line = self.scene.host.command_line(&look, camera, size, samples, TRANSFER_NAME);
        let encoding = Encoding { description: Some(line), ..Encoding::default() };
        frame.save_encoded(&path, Some(look.background()?), &encoding, None)?;
        let bytes = std::fs::read(&path).map_err(failed)?;
        say_command(&self.scene, &self.outgoing, (&order.look, &order.transfer), camera, (size, samples));
        self.outgoing.picture(&Picture { step: Step::Saved, format: Format::Png, id: 0, size, milliseconds: 0.0, bytes });
        Ok(())
    }
}

impl Painter {
    /// Sends the command that makes a picture of the current look.
    pub(super) fn say_command(&self, camera: &PageCamera, size: Viewport, samples: u32) {
        let shown = (&self.look, self.renderer.transfer_function());
        say_command(&self.scene, &self.outgoing, shown, camera, (size, samples));
    }
}

/// Sends the command that makes a picture, with its transfer function as a file.
fn say_command(
    scene: &Scene,
    outgoing: &Outgoing,
    (look, transfer): (&Look, &TransferFunction),
    camera: &PageCamera,
    (size, samples): (Viewport, u32),
) {
    let line = scene.host.command_line(&saved_look(look), camera, size, samples, TRANSFER_NAME);
    let transfer_text = transfer.to_text(FileFormat::ParaView);
    outgoing.reply(&Reply::Command { line: &line, transfer_name: TRANSFER_NAME, transfer_text: &transfer_text });
}
