//! Scenes of `layersplat render`, rendered with the library alone.

use crate::common::*;
use glam::DVec3;
use layersplat::annotation::{AnnotatedView, Annotations};
use layersplat::camera::{OrbitFrame, Up};
use layersplat::framing::{Fixed, Framing};
use layersplat::settings::{Blend, Layered};
use layersplat::surface::{Spheres, Surface};
use layersplat::{
    Background, Camera, Frame, OpenOptions, Orbit, Projection, Renderer, Settings, TransferFunction, Viewport, Volume,
};
use std::path::Path;

/// Source of the transfer function.
#[derive(Clone, Copy)]
pub enum Transfer {
    /// Derived from the histogram.
    Automatic,
    /// The same in the colours of a palette.
    Palette(&'static str),
    /// A preset for a kind of data.
    Preset(&'static str),
    /// A built-in one, stretched over the volume's range.
    Named(&'static str),
    /// Defined in code.
    Made(fn() -> TransferFunction),
}

/// All inputs of a picture. `Scene::default()` has the command's defaults, except for a small picture, a small volume and a transfer function
/// that shows part of it.
#[derive(Clone)]
pub struct Scene {
    /// A file, or `builtin:NAME`.
    pub source: &'static str,
    pub raw: OpenOptions,
    pub background_value: Option<f64>,
    pub transfer: Transfer,
    pub transfer_range: Option<(f64, f64)>,
    /// Modification of the transfer function.
    pub shaped: fn(TransferFunction) -> TransferFunction,
    /// Direction that is up.
    pub up: Up,
    pub orbit: Orbit,
    /// Whether the whole volume is framed, from any side, instead of its visible part.
    pub whole: bool,
    pub fixed: Fixed,
    pub field_of_view: Option<f64>,
    pub size: Viewport,
    pub settings: Settings,
    /// A sphere, given by its centre and radius.
    pub sphere: Option<(DVec3, f64)>,
    pub background: Option<Background>,
    /// Rays along each side of a pixel.
    pub samples: u32,
    pub annotations: Annotations,
    /// Whether legend and axes lie over the volume.
    pub over: bool,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            source: super::VOLUME,
            raw: OpenOptions::default(),
            background_value: None,
            transfer: Transfer::Named("fire"),
            transfer_range: None,
            shaped: |transfer| transfer,
            up: Up::Y,
            orbit: Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 },
            whole: false,
            fixed: Fixed::default(),
            field_of_view: None,
            size: viewport(36, 28),
            settings: Settings::default(),
            sphere: None,
            background: None,
            samples: 1,
            annotations: Annotations::default(),
            over: false,
        }
    }
}

impl Scene {
    /// Changes the options of layered rendering.
    pub fn layered(&mut self, change: impl FnOnce(&mut Layered)) {
        let mut own = layered(self.settings);
        change(&mut own);
        self.settings.algorithm = own.into();
    }

    /// Renders the picture; `folder` contains the files.
    pub fn frame(&self, folder: &Path) -> Frame {
        let place = if self.source.starts_with("builtin:") { self.source.into() } else { folder.join(self.source) };
        let mut volume = Volume::open(place, &self.raw).unwrap();
        if let Some(value) = self.background_value {
            volume = volume.with_background(value).unwrap();
        }
        let mut transfer = match self.transfer {
            Transfer::Automatic => TransferFunction::automatic(&volume),
            Transfer::Palette(name) => TransferFunction::automatic_in(&volume, name).unwrap(),
            Transfer::Preset(name) => TransferFunction::preset(name, &volume).unwrap(),
            Transfer::Named(name) => TransferFunction::builtin(name, &volume).unwrap(),
            Transfer::Made(make) => make(),
        };
        if let Some((lo, hi)) = self.transfer_range {
            transfer = transfer.stretched(lo, hi).unwrap();
        }
        let transfer = (self.shaped)(transfer);
        let inner = if self.over { self.size } else { self.annotations.inner(self.size, &transfer, self.settings.blend) };
        let camera = Scene { size: inner, ..self.clone() }.camera(&volume, &transfer);
        let mut renderer = Renderer::new(&device(), &volume, &transfer).unwrap();
        renderer.set_surfaces(&self.surfaces()).unwrap();
        let larger = viewport(inner.width * self.samples, inner.height * self.samples);
        let (frame, _) = renderer.render(&camera, larger, &self.settings).unwrap();
        let background = self.background.unwrap_or(Background::BLACK);
        let shown =
            AnnotatedView { camera: &camera, grid: volume.grid(), transfer: &transfer, blend: self.settings.blend, background };
        let frame = self.annotations.drawn_beside(frame.averaged(self.samples).unwrap(), self.size, shown).unwrap();
        match self.background {
            Some(background) => frame.over(background),
            None => frame,
        }
    }

    fn surfaces(&self) -> Vec<Surface> {
        let sphere = |(centre, radius)| Surface::new("sphere", Spheres::new(vec![centre], vec![radius]).unwrap());
        self.sphere.map(sphere).into_iter().collect()
    }

    /// The same view as an orbit about y.
    fn orbit(&self) -> Orbit {
        OrbitFrame::about(self.up).orbit(self.orbit)
    }

    fn camera(&self, volume: &Volume, transfer: &TransferFunction) -> Camera {
        if self.whole {
            return self.camera_of_all(volume);
        }
        let mut framing = match self.settings.blend {
            _ if self.annotations.bounding_box => Framing::whole(volume),
            Blend::Composite => Framing::visible(volume, transfer, self.settings.unit_distance),
            Blend::Iso(value) => Framing::iso(volume, value),
            _ => Framing::whole(volume),
        };
        if let Some((centre, radius)) = self.sphere {
            framing = framing.joined(Framing::of_box(centre - radius, centre + radius));
        }
        if let Some(crop) = self.settings.clipping.crop {
            framing = framing.cropped(volume.grid(), crop.lowest, crop.highest);
        }
        match self.field_of_view {
            Some(field_of_view) => framing.perspective(self.orbit(), self.size, field_of_view, self.fixed),
            None => framing.parallel(self.orbit(), self.size, self.fixed),
        }
    }

    fn camera_of_all(&self, volume: &Volume) -> Camera {
        let grid = volume.grid();
        let centre: DVec3 = self.fixed.centre.unwrap_or_else(|| grid.centre());
        match (self.field_of_view, self.fixed) {
            (Some(field_of_view), Fixed { distance: Some(distance), .. }) => {
                Camera::orbit(centre, distance, self.orbit(), Projection::Perspective { field_of_view })
            }
            (Some(field_of_view), _) => Camera::fit_perspective(centre, grid.diagonal(), field_of_view, self.size, self.orbit()),
            (None, Fixed { scale: Some(scale), .. }) => {
                Camera::orbit(centre, grid.diagonal(), self.orbit(), Projection::Parallel { scale })
            }
            (None, _) => Camera::fit_parallel(centre, grid.diagonal(), self.size, self.orbit()),
        }
    }
}
