//! What the page asks this command for.

use super::arguments::{self, Source as VolumeSource};
use super::first_fields::FirstFields;
use super::given::{GivenOptions, file_name};
use super::opening;
use super::python;
use crate::camera::Camera;
use crate::check::Family;
use crate::cli::check;
use crate::cli::options::DeviceOptions;
use crate::device::Device;
use crate::error::Error;
use crate::settings::{Quality, Settings};
use crate::viewer::{FilmWanted, Host, Look, Offered, Opening, PageLabels, Source, Wanted};
use crate::viewport::Viewport;
use crate::volume::{Grid, Sequence};
use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

/// Remembered settings: a look has one for each quality that pictures of it are drawn in.
const REMEMBERED: usize = 16;

/// The command's options and device.
pub(super) struct PageHost {
    given: GivenOptions,
    is_layered: bool,
    fields: FirstFields,
    device: Device,
    options: DeviceOptions,
    grid: Grid,
    sequence: Option<Sequence>,
    offered: Vec<Offered>,
    checked: Mutex<BTreeSet<Family>>,
    /// The last settings: parsing options takes longer than a page should wait in every frame.
    last: Mutex<Vec<(Look, Option<Quality>, Settings)>>,
}

impl PageHost {
    pub fn new(given: GivenOptions, options: DeviceOptions, opening: &Opening) -> Self {
        // Without a quality, options of any algorithm go together.
        let is_layered =
            arguments::settings(&given, &opening.look, None, false).is_ok_and(|settings| settings.layered().is_some());
        let (device, grid) = (opening.device.clone(), opening.volume.grid().clone());
        let sequence = opening.time.as_ref().map(|time| time.sequence.clone());
        let (offered, checked, last) = (Vec::new(), Mutex::default(), Mutex::default());
        let fields = FirstFields::new(opening.drawn.kind(), &opening.look);
        Self { given, is_layered, fields, device, options, grid, sequence, offered, checked, last }
    }

    /// Offers these volumes to the page.
    pub fn offering(self, offered: &[Offered]) -> Self {
        Self { offered: offered.to_vec(), ..self }
    }

    /// Kernel families of a picture that are not checked yet.
    fn unchecked(&self, camera: &Camera, size: Viewport, settings: &Settings) -> BTreeSet<Family> {
        let families = check::families(&[*camera], size, &self.grid, settings, false);
        families.difference(&self.checked.lock().unwrap_or_else(PoisonError::into_inner)).copied().collect()
    }

    /// How commands name a step.
    fn source(&self, step: usize) -> VolumeSource {
        let several = self.sequence.as_ref().filter(|_| !self.given.more.is_empty());
        match several.and_then(|sequence| sequence.source(step)) {
            Some((file, frame)) => VolumeSource { volume: file_name(file), frame: frame.filter(|&frame| frame > 0) },
            None => VolumeSource { volume: self.given.volume.clone(), frame: self.sequence.as_ref().map(|_| step) },
        }
    }
}

impl Host for PageHost {
    fn settings(&self, look: &Look, quality: Option<Quality>) -> Result<Settings, Error> {
        let quality = quality.or(look.quality);
        // No setting depends on the step, or on how fields are shown.
        let look = &Look { frame: 0, channels: Vec::new(), labels: PageLabels::default(), ..look.clone() };
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((.., settings)) = last.iter().find(|(known, of, _)| *of == quality && known == look) {
            return Ok(*settings);
        }
        let settings = arguments::settings(&self.given, look, quality, self.is_layered)?;
        if last.len() == REMEMBERED {
            last.remove(0);
        }
        last.push((look.clone(), quality, settings));
        Ok(settings)
    }

    fn is_checked(&self, camera: &Camera, size: Viewport, settings: &Settings) -> bool {
        self.unchecked(camera, size, settings).is_empty()
    }

    fn require_checked(&self, camera: &Camera, size: Viewport, settings: &Settings) -> Result<(), Error> {
        let unknown = self.unchecked(camera, size, settings);
        if !unknown.is_empty() {
            // Other pages draw meanwhile.
            check::require(&self.device, &unknown, &self.options)?;
            self.checked.lock().unwrap_or_else(PoisonError::into_inner).extend(unknown);
        }
        Ok(())
    }

    fn opens_volumes(&self) -> bool {
        true
    }

    fn offered(&self) -> Vec<Offered> {
        self.offered.clone()
    }

    fn open(&self, source: &Source) -> Result<(Opening, Box<dyn Host>), Error> {
        let (opening, host) = opening::open(&self.given, &self.offered, source, &self.device)?;
        Ok((opening, Box::new(host)))
    }

    fn film_command_line(&self, wanted: &FilmWanted) -> Option<String> {
        Some(arguments::rotate(&self.given, &self.fields, wanted, self.is_layered))
    }

    fn command_line(&self, wanted: &Wanted) -> String {
        arguments::render(&self.given, &self.fields, self.source(wanted.look.frame), wanted, self.is_layered)
    }

    fn python(&self, wanted: &Wanted) -> String {
        match self.settings(wanted.look, None) {
            Ok(settings) => python::program(&self.given, &self.fields, &self.source(wanted.look.frame), wanted, &settings),
            Err(refused) => format!("# {refused}\n"),
        }
    }
}
