//! Saved pictures, and the commands that make the same ones.

use super::annotated::annotated;
use super::drawn::CurrentLook;
use super::drawn::PageRenderer;
use super::host::Wanted;
use super::inbox::Saving;
use super::keeper::{Maker, Order};
use super::look::Look;
use super::outgoing::Outgoing;
use super::painter::Painter;
use super::replies::{Format, NamedText, Picture, Reply, Step};
use super::requests::SavedFormat;
use super::scene::SharedScene;
use crate::error::Error;
use crate::files::Scratch;
use crate::image::Encoding;
use crate::settings::Quality;
use crate::transfer::{FileFormat, TransferFunction};
use crate::viewport::Viewport;
use std::io;
use std::path::Path;

/// Name of the transfer function's file beside a command.
pub(super) const TRANSFER_NAME: &str = "layersplat.json";

/// The look of what is saved: of the chosen quality, `high` if none is chosen.
pub(super) fn saved_look(look: &Look) -> Look {
    Look { quality: look.quality.or(Some(Quality::High)), ..look.clone() }
}

/// An error that does not name the temporary file.
pub(super) fn without_path(error: Error) -> Error {
    match error {
        Error::Write { source, .. } => Error::write(Path::new("the file for the page"), source),
        error => error,
    }
}

impl Maker {
    /// Renders a picture as the command does, and sends it as the command writes it.
    pub(super) fn save(&self, order: &Order, renderer: &mut PageRenderer, saving: &Saving) -> Result<(), Error> {
        let &Saving { camera, size, samples, format } = saving;
        let (scene, look) = (&self.scene, saved_look(&order.look));
        let settings = scene.host.settings(&look, None)?;
        let view = scene.camera(&camera)?;
        let rendered = Viewport::new(size.width * samples, size.height * samples)?;
        scene.host.require_checked(&view, rendered, &settings)?;
        let (Some(frame), _) = renderer.render(&view, rendered, &settings)? else { return Ok(()) };
        let frame = if samples > 1 { frame.averaged(samples)? } else { frame };
        let frame = annotated(
            frame,
            scene,
            CurrentLook { look: &look, ..order.now() },
            &view,
            settings.blend,
            format == SavedFormat::Exr,
        )?;
        let failed = |e: io::Error| Error::write(Path::new("the picture"), e);
        let folder = Scratch::new()?;
        let path = folder.path().join(format.file_name());
        let others = names_of_others(&order.transfers);
        let line = scene.host.command_line(&wanted(scene, saving, &look, &others)?);
        let encoding = Encoding { description: Some(line), ..Encoding::default() };
        frame.save_encoded(&path, Some(look.background()?), &encoding, None).map_err(without_path)?;
        let bytes = std::fs::read(&path).map_err(failed)?;
        say_command(scene, &self.outgoing, order.now(), saving)?;
        let format = match format {
            SavedFormat::Png => Format::Png,
            SavedFormat::Exr => Format::Exr,
        };
        self.outgoing.picture(&Picture { step: Step::Saved, format, id: 0, size, milliseconds: 0.0, bytes });
        Ok(())
    }
}

impl Painter {
    /// Sends the command that makes a picture of the current look.
    pub(super) fn say_command(&self, saving: &Saving) -> Result<(), Error> {
        say_command(&self.scene, &self.outgoing, self.now(), saving)
    }
}

/// Sends the command that makes a picture, and the program in Python, with the transfer function as a file.
fn say_command(
    scene: &SharedScene,
    outgoing: &Outgoing,
    CurrentLook { look, transfers }: CurrentLook,
    saving: &Saving,
) -> Result<(), Error> {
    let (look, others) = (saved_look(look), names_of_others(transfers));
    let wanted = wanted(scene, saving, &look, &others)?;
    let (line, python) = (scene.host.command_line(&wanted), scene.host.python(&wanted));
    let (text, more) = (transfers[0].to_text(FileFormat::ParaView), files_of_others(transfers));
    outgoing.reply(&Reply::Command {
        line: &line,
        python: &python,
        transfer_name: TRANSFER_NAME,
        transfer_text: &text,
        more: &more,
    });
    Ok(())
}

/// Names of the files with the transfer functions of the other fields.
pub(super) fn names_of_others(transfers: &[TransferFunction]) -> Vec<String> {
    (1..transfers.len()).map(|n| format!("layersplat-{n}.json")).collect()
}

/// These files.
pub(super) fn files_of_others(transfers: &[TransferFunction]) -> Vec<NamedText> {
    let others = names_of_others(transfers).into_iter().zip(&transfers[1..]);
    others.map(|(name, transfer)| NamedText { name, text: transfer.to_text(FileFormat::ParaView) }).collect()
}

fn wanted<'a>(scene: &'a SharedScene, saving: &'a Saving, look: &'a Look, others: &'a [String]) -> Result<Wanted<'a>, Error> {
    let Saving { camera, size, samples, format } = saving;
    let (view, length_units) = (scene.camera(camera)?, scene.length_units());
    let (size, samples, format) = (*size, *samples, *format);
    Ok(Wanted { look, camera, view, size, samples, format, transfer: TRANSFER_NAME, others, length_units })
}
