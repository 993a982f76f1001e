//! The lights of a frame that cast shadows, and where samples look their light up.

use super::cells::{CellGrid, ScatterGrids};
use super::grid::ValueGrid;
use crate::device::launch::structs::LightVolumeParams;
use crate::layers::{AxisFrame, Rays};
use crate::settings::{Blend, LightGrid, LightSpace, Settings, Shading, Studio};
use crate::volume::Grid;
use glam::DVec3;

/// Distance towards the light at which its transmittance is looked up, in smallest spacings. Interpolation mixes in what lies behind the
/// sample. Measured (docs/dev/light.md): at full resolution 0 to 0.1 is best, and 0 saves half of the look-ups in the planes of layers; at half
/// resolution 1 is best.
fn shift_to_light(grid: LightGrid) -> f64 {
    if grid == LightGrid::Full { 0.0 } else { 1.0 }
}

/// Distances from an iso-surface at which light is looked up, in smallest spacings: along its normal, and towards the light. A voxel's
/// diagonal is 1.73, so no value of the look-up lies behind the surface.
const LIFT: f64 = 1.75;
const LIFT_TO_LIGHT: f64 = 0.5;

/// Distance from a surface, along its normal, at which scattered light is looked up, in edges of a cell.
const LIFT_OF_CELLS: f64 = 0.25;
/// The same for iso-surfaces and labels, whose cells are opaque: a ball has the light of its surroundings within 2 % (tests/fields/studio.rs), and at
/// 0.25 a third of it less.
const LIFT_OF_SURFACE: f64 = 1.25;

/// What scattered light depends on, besides the medium. Directions are along grid axes.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::renderer) struct StudioLight {
    pub studio: Studio,
    /// Where up is in the sky.
    pub up: DVec3,
    swept: Vec<Source>,
    /// Of each swept light: its irradiance over π, in red, green and blue.
    strengths: Vec<[f64; 3]>,
    /// The resolution.
    pub grid: LightGrid,
}

/// A light that is swept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::renderer) struct Source {
    /// Unit vector towards the light, in grid axes (world scale).
    pub to_light: DVec3,
    /// Angular diameter in degrees.
    pub angle: f64,
}

/// The light volumes of a frame.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::renderer) struct LightSources {
    /// Lights that are swept, each once.
    pub swept: Vec<Source>,
    /// Of each light: its index in `swept`.
    volumes: Vec<Option<usize>>,
    has_sky: bool,
    strength: f64,
    is_surface: bool,
    shadows: ValueGrid,
    sky: ValueGrid,
    shift: f64,
    spacing: DVec3,
    studio: Option<(StudioLight, ScatterGrids)>,
}

impl StudioLight {
    /// The cells in which samples look light up.
    pub fn cells(&self, grids: &ScatterGrids) -> CellGrid {
        if self.grid == LightGrid::Quarter { grids.coarse } else { grids.fine }
    }

    /// Of each light that is swept: the radiance with which all of its light arrives from all sides on average.
    pub fn arriving(&self) -> [[f32; 3]; 4] {
        let of_light = |n: usize| self.strengths.get(n).map_or([0.0; 3], |strength| strength.map(|s| (s / 4.0) as f32));
        std::array::from_fn(of_light)
    }
}

impl LightSources {
    /// The light volumes for lights in these directions (unit vectors in grid axes); `None` without shadows and ambient occlusion.
    pub fn new(settings: &Settings, grid: &Grid, directions: impl Iterator<Item = DVec3>, rays: &Rays) -> Option<Self> {
        if !settings.sweeps_light() {
            return None;
        }
        let lights = settings.shading.map_or(Vec::new(), |shading| shading.lights.as_slice().to_vec());
        let mut swept = Vec::new();
        let volumes = lights.iter().zip(directions).map(|(light, to_light)| {
            // A light at the camera lights what the camera sees.
            let has_shadow = match settings.studio {
                Some(_) => true,
                None => settings.shadows.is_some_and(|shadows| shadows.strength > 0.0) && to_light != rays.to_eye,
            };
            if light.strength == 0.0 || !has_shadow {
                return None;
            }
            let source = Source { to_light, angle: light.angle };
            Some(swept.iter().position(|&other| other == source).unwrap_or_else(|| {
                swept.push(source);
                swept.len() - 1
            }))
        });
        let volumes: Vec<_> = volumes.collect();
        let studio = settings.studio.map(|studio| {
            let up = studio.sky.up.normalize();
            let up = match studio.sky.space {
                LightSpace::World => grid.world_to_grid_axes() * up,
                LightSpace::Camera => rays.from_camera_axes(up),
            };
            // The tone and the exposure belong to the picture.
            let studio = Studio { sky: studio.sky, scattering: studio.scattering, ..Studio::default() };
            let mut strengths = vec![[0.0; 3]; swept.len()];
            for (light, volume) in lights.iter().zip(&volumes) {
                let of_light = |c: usize| light.strength * light.color[c];
                volume.iter().for_each(|&n| (0..3).for_each(|c| strengths[n][c] += of_light(c)));
            }
            let light = StudioLight { studio, up, swept: swept.clone(), strengths, grid: settings.light_grid };
            (light, ScatterGrids::new(grid, settings.light_grid))
        });
        let (dims, spacing, grid) = (grid.dims(), grid.spacing(), settings.swept_grid());
        Some(Self {
            swept,
            volumes,
            has_sky: settings.ambient_occlusion.is_some(),
            strength: if studio.is_some() { 1.0 } else { settings.shadows.map_or(0.0, |shadows| shadows.strength) },
            is_surface: matches!(settings.blend, Blend::Iso(_)),
            shadows: ValueGrid::new(dims, grid.voxels().min(2)),
            sky: ValueGrid::new(dims, grid.voxels()),
            shift: shift_to_light(grid),
            spacing,
            studio,
        })
    }

    /// What scattered light depends on, and the cells in which it is computed.
    pub fn studio(&self) -> Option<&(StudioLight, ScatterGrids)> {
        self.studio.as_ref()
    }

    /// Of each light that is swept: the distance along its rays from a layer of values to the next one, across the axis on which they are
    /// longest, in units of `length`; the distance in memory of the next value towards it along this axis, and along the others; and the shears
    /// along these.
    pub fn ways(&self, length: f64, strides: [i32; 3]) -> ([f32; 4], [[i32; 3]; 4], [[f32; 2]; 4]) {
        let way = |source: &Source| {
            let along = source.to_light / self.spacing;
            let axis = along.abs().max_position();
            let axes = [axis, (axis + 1) % 3, (axis + 2) % 3];
            let crossing = 1.0 / (along[axis].abs() * self.shadows.values_per_voxel() * length);
            let towards = axes.map(|i| if along[i] < 0.0 { -strides[i] } else { strides[i] });
            let shears = [axes[1], axes[2]].map(|i| (along[i] / along[axis]).abs() as f32);
            (crossing as f32, towards, shears)
        };
        let ways: [_; 4] = std::array::from_fn(|n| self.swept.get(n).map_or((1.0, [0; 3], [0.0; 2]), way));
        (ways.map(|way| way.0), ways.map(|way| way.1), ways.map(|way| way.2))
    }

    /// The values of the volumes of the lights, and of that of the ambient light.
    pub fn grids(&self) -> [ValueGrid; 2] {
        [self.shadows, self.sky]
    }

    /// Matter has the surfaces of labels: in the studio they are lit like iso-surfaces. Opaque matter has no light within.
    pub fn set_surfaces(&mut self) {
        self.is_surface |= self.studio.is_some();
    }

    /// All samples lie on surfaces.
    pub fn set_solid(&mut self) {
        self.is_surface = true;
    }

    /// Replaces the grids by those of the layers that are held.
    pub fn set_grids(&mut self, [shadows, sky]: [Option<ValueGrid>; 2]) {
        (self.shadows, self.sky) = (shadows.unwrap_or(self.shadows), sky.unwrap_or(self.sky));
    }

    fn lift_of_cells(&self) -> f64 {
        if self.is_surface { LIFT_OF_SURFACE } else { LIFT_OF_CELLS }
    }

    /// Kernel argument, in the axes of `frame`.
    pub fn params(&self, shading: &Shading, frame: AxisFrame, to_eye: DVec3) -> LightVolumeParams {
        let narrow = |v: DVec3| frame.local(v).as_vec3().to_array();
        let shift = if self.is_surface { self.shift.max(LIFT_TO_LIGHT) } else { self.shift };
        let of_light = |n: usize| self.volumes.get(n).copied().flatten();
        let origin = |n: usize| {
            let towards = of_light(n).map_or(DVec3::ZERO, |i| self.swept[i].to_light * shift / self.spacing);
            narrow(self.shadows.position(towards))
        };
        let shares = shading.shares();
        let cells = self.studio.as_ref().map(|(light, grids)| light.cells(grids));
        let all = DVec3::splat;
        let (sky_scale, sky_origin, sky_last, sky_stride) = match cells {
            Some(cells) => (cells.scale(), cells.origin(), cells.last(), cells.strides(frame)),
            None => (all(self.sky.values_per_voxel()), self.sky.position(DVec3::ZERO), self.sky.last(), self.sky.strides(frame)),
        };
        let lift = match cells {
            Some(cells) => narrow(self.lift_of_cells() * cells.edge / self.spacing),
            None if self.is_surface => narrow(LIFT / self.spacing),
            None => [0.0; 3],
        };
        LightVolumeParams {
            shadow_scale: narrow(all(self.shadows.values_per_voxel())),
            sky_scale: narrow(sky_scale),
            origins: std::array::from_fn(origin),
            sky_origin: narrow(sky_origin),
            shadow_stride: self.shadows.strides(frame),
            sky_stride,
            shadow_last: narrow(self.shadows.last()),
            sky_last: narrow(sky_last),
            volumes: std::array::from_fn(|n| of_light(n).map_or(-1, |i| i as i32)),
            volume_bytes: self.shadows.values() as i32,
            first_layers: [self.shadows, self.sky].map(|grid| grid.held().first[frame.a] as f32),
            strength: self.strength as f32,
            sky: i32::from(self.has_sky),
            sky_axes: (frame.u | frame.v << 2 | frame.a << 4) as i32,
            unshaded: if shares.is_some() { 0.0 } else { 1.0 },
            unshaded_ambient: shares.map_or(0.0, |(ambient, _)| ambient as f32),
            unshaded_lights: shares.map_or([0.0; 4], |(_, lights)| lights.map(|share| share as f32)),
            lift,
            eye: narrow(to_eye),
            shadow_lift: cells
                .filter(|_| self.is_surface)
                .map_or(0.0, |cells| (LIFT / (self.lift_of_cells() * cells.edge)) as f32),
        }
    }
}

impl LightVolumeParams {
    /// Parameters of frames without light volumes.
    pub(in crate::renderer) const NONE: Self = Self {
        shadow_scale: [0.0; 3],
        sky_scale: [0.0; 3],
        origins: [[0.0; 3]; 4],
        sky_origin: [0.0; 3],
        shadow_stride: [0; 3],
        sky_stride: [0; 3],
        shadow_last: [0.0; 3],
        sky_last: [0.0; 3],
        volumes: [-1; 4],
        volume_bytes: 0,
        first_layers: [0.0; 2],
        strength: 0.0,
        sky: 0,
        sky_axes: 0,
        unshaded: 1.0,
        unshaded_ambient: 0.0,
        unshaded_lights: [0.0; 4],
        lift: [0.0; 3],
        eye: [0.0; 3],
        shadow_lift: 0.0,
    };
}
