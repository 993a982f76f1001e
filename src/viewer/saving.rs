//! Saved pictures, and the commands that make the same ones.

use super::inbox::Saving;
use super::look::{Look, PageQuality};
use super::painter::Painter;
use super::protocol::{Format, Picture, Reply, SavedFormat, Step};
use super::scene::Wanted;
use crate::error::Error;
use crate::image::Encoding;
use crate::settings::Quality;
use crate::transfer::FileFormat;
use crate::viewport::Viewport;
use std::io;
use std::path::Path;

/// Name of the file beside the command.
const TRANSFER_NAME: &str = "layersplat.json";

impl Painter {
    /// Renders a picture of the chosen quality, `high` if none is chosen, as the command does, and sends it as the command writes it.
    pub(super) fn save(&mut self, saving: &Saving) -> Result<(), Error> {
        let &Saving { camera, size, samples, format } = saving;
        let settings = self.scene.host.settings(&self.look, Some(self.saved_quality()))?;
        let view = self.scene.camera(&camera)?;
        let rendered = Viewport::new(size.width * samples, size.height * samples)?;
        self.scene.host.require_checked(&view, rendered, &settings)?;
        self.use_general_programs(false);
        let (Some(frame), _) = self.renderer.render(&view, rendered, &settings)? else { return Ok(()) };
        let frame = if samples > 1 { frame.averaged(samples)? } else { frame };
        let frame = match self.annotations() {
            None => frame,
            Some(annotations) => self.annotated(frame, &annotations, &view, settings.blend)?,
        };
        let failed = |e: io::Error| Error::write(Path::new("the picture"), e);
        let folder = tempfile::tempdir().map_err(failed)?;
        let path = folder.path().join(format.file_name());
        let look = self.saved_look();
        let line = self.scene.host.command_line(&self.wanted(saving, &look)?);
        let encoding = Encoding { description: Some(line), ..Encoding::default() };
        frame.save_encoded(&path, Some(self.look.background()?), &encoding, None)?;
        let bytes = std::fs::read(&path).map_err(failed)?;
        self.say_command(saving)?;
        let format = match format {
            SavedFormat::Png => Format::Png,
            SavedFormat::Exr => Format::Exr,
        };
        self.outgoing.picture(&Picture { step: Step::Saved, format, id: 0, size, milliseconds: 0.0, bytes });
        Ok(())
    }

    /// Sends the command that makes the picture, and the program in Python, with its transfer function as a file.
    pub(super) fn say_command(&self, saving: &Saving) -> Result<(), Error> {
        let look = self.saved_look();
        let wanted = self.wanted(saving, &look)?;
        let (line, python) = (self.scene.host.command_line(&wanted), self.scene.host.python(&wanted));
        let text = self.renderer.transfer_function().to_text(FileFormat::ParaView);
        self.outgoing.reply(&Reply::Command { line: &line, python: &python, transfer_name: TRANSFER_NAME, transfer_text: &text });
        Ok(())
    }

    fn wanted<'a>(&'a self, saving: &'a Saving, look: &'a Look) -> Result<Wanted<'a>, Error> {
        let Saving { camera, size, samples, format } = saving;
        let (view, length_units) = (self.scene.camera(camera)?, self.scene.length_units());
        Ok(Wanted { look, camera, view, size: *size, samples: *samples, format: *format, transfer: TRANSFER_NAME, length_units })
    }

    /// The look with the quality of saved pictures.
    fn saved_look(&self) -> Look {
        let mut look = self.look.clone();
        look.quality = look.quality.or(Some(PageQuality::High));
        look
    }

    fn saved_quality(&self) -> Quality {
        self.look.quality.map_or(Quality::High, Quality::from)
    }
}
