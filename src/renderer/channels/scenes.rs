//! The scene that a frame draws of the fields of a renderer.

use super::super::classification::{PreparationKernels, TableSizes};
use super::super::colors::color_settings;
use super::super::field::{Field, FieldShape};
use super::super::label_colors::LabelColors;
use super::super::light::LightVolumes;
use super::super::scene::{OtherField, Scene, View};
use super::super::world::World;
use super::classified::ClassifiedField;
use super::fields::Fields;
use crate::error::Error;
use crate::settings::{self, Algorithm, Blend, CropBox, FieldKind, Settings};
use glam::DVec3;

/// Farther away than any voxel of a grid.
const FAR: DVec3 = DVec3::splat(1e12);

/// Fields in a scene with others.
fn others_of<'a>(fields: Vec<&'a mut ClassifiedField>, settings: &Settings, world: World) -> Vec<OtherField<'a>> {
    let other = |ClassifiedField { field, classification, look, colors }: &'a mut ClassifiedField| OtherField {
        field,
        classification,
        settings: look.settings(settings, world),
        voxel_colors: colors.as_ref(),
    };
    fields.into_iter().map(other).collect()
}

/// The fields that can change a picture, or the first if none can.
fn shown(fields: Vec<&mut ClassifiedField>, blend: Blend) -> Vec<&mut ClassifiedField> {
    let none = !fields.iter().any(|field| field.shows(blend));
    fields.into_iter().enumerate().filter(|(n, field)| field.shows(blend) || (none && *n == 0)).map(|(_, field)| field).collect()
}

/// Whether voxels are splatted, or treated one by one in another way: they are those of the frame then.
fn is_splatted(settings: &Settings) -> bool {
    match settings.algorithm {
        Algorithm::Layered(layered) => matches!(layered.classification, settings::Classification::Post(_)),
        Algorithm::Raycast { .. } => false,
        _ => true,
    }
}

impl Fields {
    fn visible(&self) -> impl Iterator<Item = &ClassifiedField> {
        self.all().filter(|field| field.look.visible)
    }

    /// A field with the grid of frames: the first visible one, or the first if none is.
    pub fn base(&self) -> &Field {
        &self.visible().next().unwrap_or(&self.first).field
    }

    /// Largest steepness of the transfer functions of visible fields.
    pub fn steepness(&self) -> f64 {
        self.visible().map(ClassifiedField::steepness).fold(0.0, f64::max)
    }

    /// The settings of a frame. Crop boxes count voxels of the first field; where all fields are hidden, nothing is within the box.
    ///
    /// # Errors
    /// For a crop box in a field that is rotated against the common grid.
    pub fn settings(&self, settings: Settings) -> Result<Settings, Error> {
        let mut clipping = settings.clipping;
        let common = self.base().description().grid();
        if self.visible().next().is_none() {
            clipping.crop = Some(CropBox { lowest: DVec3::ONE, highest: DVec3::ZERO });
        } else if let Some(crop) = clipping.crop.as_mut().filter(|_| *common != self.first_grid) {
            if common.direction() != self.first_grid.direction() {
                let problem = "counts voxels of the first channel, whose axes are not those of the finest one: use clip planes";
                return Err(Error::Settings { field: "crop", problem: problem.into() });
            }
            let place = |voxel: DVec3| {
                // An infinite bound stays one.
                let moved = common.world_to_voxel(self.first_grid.index_to_world().transform_point3(voxel.clamp(-FAR, FAR)));
                DVec3::select(voxel.is_finite_mask(), moved, voxel)
            };
            (crop.lowest, crop.highest) = (place(crop.lowest), place(crop.highest));
        }
        let settings = Settings { clipping, ..settings };
        if let Some(labels) = &self.label_colors {
            self.check_label_colors(labels)?;
        }
        self.kind(settings.blend).check(&settings)?;
        Ok(self.colors.as_ref().map_or(settings, |colors| color_settings(settings, colors)))
    }

    fn check_label_colors(&self, labels: &LabelColors) -> Result<(), Error> {
        if self.colors.is_some() || self.visible().count() > 1 {
            let problem =
                "are those of one volume of values, and the renderer draws several, or colours: omit one of both".into();
            return Err(Error::Settings { field: "label_colors", problem });
        }
        labels.grid_over(self.base().description()).map(drop)
    }

    /// What frames of a blend mode draw.
    pub fn kind(&self, blend: Blend) -> FieldKind {
        let is_colored = || self.all().any(|field| field.shows(blend) && field.colors.is_some());
        match (&self.colors, &self.label_colors) {
            (Some(colors), _) => colors.kind,
            _ if self.all().any(|field| field.shows_colors(blend)) => FieldKind::Mixed,
            _ if self.base().is_framed() || is_colored() || self.all().filter(|field| field.shows(blend)).count() > 1 => {
                FieldKind::Several
            }
            (_, Some(_)) => FieldKind::LabelColors,
            _ => FieldKind::One,
        }
    }

    /// Whether frames are of several fields or of colours.
    pub fn are_tiled(&self, blend: Blend) -> bool {
        matches!(self.kind(blend), FieldKind::Colors | FieldKind::Labels | FieldKind::Several | FieldKind::Mixed)
    }

    /// The shapes and the tables of the visible fields, beginning with the one that scenes begin with.
    pub fn sizes(&self) -> Vec<(FieldShape, TableSizes<'_>)> {
        let visible: Vec<_> = self.visible().map(ClassifiedField::sizes).collect();
        if visible.is_empty() { vec![self.first.sizes()] } else { visible }
    }

    /// Runs `work` on the scene of the visible fields.
    ///
    /// # Errors
    /// Those of `work`, and of resampling fields that algorithms need at the voxels of the frame.
    pub fn with_scene<T>(
        &mut self,
        view: View,
        kernels: &mut PreparationKernels,
        light: &mut LightVolumes,
        work: impl FnOnce(&mut Scene) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let (splats, sweeps) = (is_splatted(view.settings), view.settings.sweeps_light());
        let is_framed = self.base().is_framed();
        if is_framed && (splats || sweeps) {
            let visible = std::iter::once(&self.first).chain(&self.others).filter(|field| field.look.visible);
            self.on_frame.update(visible, kernels, view.device)?;
        }
        let Self { first, others, colors, label_colors, on_frame, .. } = self;
        let (own, on_frame): (Vec<_>, Vec<_>) = (std::iter::once(first).chain(others).collect(), on_frame.fields().collect());
        let (mut drawn, absorbers) = match (is_framed, splats) {
            (true, true) => (shown(on_frame, view.settings.blend), Vec::new()),
            (true, false) if sweeps => (shown(own, view.settings.blend), shown(on_frame, view.settings.blend)),
            _ => (shown(own, view.settings.blend), Vec::new()),
        };
        let base = drawn.remove(0);
        let world = base.field.world();
        let settings = base.look.settings(view.settings, world);
        let [others, absorbers] = [drawn, absorbers].map(|fields| others_of(fields, view.settings, world));
        let view = View { settings: &settings, ..view };
        let scene = Scene::new(view, &base.field, &mut base.classification, kernels, light);
        let scene = scene.with_others(others).with_absorbers(absorbers);
        let scene = scene.with_voxel_colors(base.colors.as_ref()).with_colors(colors.as_ref());
        work(&mut scene.with_label_colors(label_colors.as_ref()))
    }
}
