//! The level of a data set that pictures show, and the part of it that they see.

use super::scene::{OpenedScene, SceneOptions};
use crate::camera::Camera;
use crate::error::Error;
use crate::framing::{HalfSpace, Sight};
use crate::memory;
use crate::settings::Settings;
use crate::viewport::Viewport;
use crate::volume::{Level, LevelLattice, OpenOptions, VoxelBox};
use glam::DVec3;

/// Voxels around those in view that are read with them: kernels, gradients and prefilters reach them.
const MARGIN: f64 = 16.0;
/// Share by which spacings may exceed a pixel: they are rounded.
const ROUNDING: f64 = 1e-6;
/// Most of the available memory that the voxels may take: rendering needs as much again.
const SHARE: u64 = 2;

/// The level and the part that views need.
struct Needed {
    level: usize,
    /// Whether a coarser level than pixels need is read because of limits.
    is_limited: bool,
    /// Voxels of the level.
    part: VoxelBox,
}

impl OpenedScene {
    /// Reads the level and the part of it that views show, if the options leave both to the pictures: until then the scene has the level that
    /// stands for all.
    ///
    /// # Errors
    /// Those of cameras and of [`Volume::open`](crate::Volume::open).
    pub fn read_seen(&mut self, options: &SceneOptions, cameras: &[Camera], size: Viewport) -> Result<(), Error> {
        let contents = self.volume.contents();
        if !std::mem::take(&mut self.is_overview) || contents.levels.len() < 2 {
            return Ok(());
        }
        let needed = self.needed(options, cameras, size)?;
        let Needed { level, part, .. } = needed;
        let (finest, dims) = (contents.levels[0], contents.levels[level]);
        let name = self.volume.name();
        let [x, y, z] = part.dims;
        tracing::info!(
            "{name}: level {level} of {}, {x}x{y}x{z} of its {}x{}x{} voxels",
            contents.levels.len(),
            dims[0],
            dims[1],
            dims[2]
        );
        if needed.is_limited && self.processes.leads() {
            tracing::warn!(
                "{name}: using level {level} of {}: finer ones, of which pixels show more, do not fit into memory or into download",
                contents.levels.len()
            );
        }
        if (level, part) == (contents.level, VoxelBox::whole(self.volume.grid().dims())) {
            return Ok(());
        }
        let region = of_finest(part, dims, finest);
        let opening = OpenOptions {
            level: Some(Level::Number(level)),
            region: Some(region).filter(|_| part != VoxelBox::whole(dims)),
            memory: options.bounds.memory,
            ..options.volume.of_level()?
        };
        let volume = self.volume.other_level(&options.volume.volume, &opening)?;
        self.volume = options.volume.with_background(volume)?;
        self.settings.clipping.crop = options.blend.crop_of(&self.volume);
        Ok(())
    }

    fn needed(&self, options: &SceneOptions, cameras: &[Camera], size: Viewport) -> Result<Needed, Error> {
        let volume = &self.volume;
        let (grid, contents) = (volume.grid(), volume.contents());
        let own = volume.lattice();
        let count = contents.levels.len();
        let settings = &self.settings;
        // Sizes of levels are rounded, so the finest may reach farther than that which stands for all.
        let LevelLattice { first, step } = contents.lattices[0];
        let of_finest = ends(contents.levels[0]).map(|voxel| (first + step * voxel - own.first) / own.step);
        let corners = [ends(grid.dims()), of_finest].concat();
        let mut lowest = corners.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let mut highest = corners.into_iter().fold(DVec3::NEG_INFINITY, DVec3::max);
        if let Some(crop) = settings.clipping.crop {
            (lowest, highest) = (lowest.max(crop.lowest), highest.min(crop.highest));
        }
        let point = |voxel| grid.index_to_world().transform_point3(voxel);
        let of_axis = |i: usize| [(point(lowest), grid.direction().col(i)), (point(highest), -grid.direction().col(i))];
        let planes = settings.clipping.planes.iter().flatten().map(|plane| (plane.point, plane.normal));
        let sides: Vec<HalfSpace> = (0..3).flat_map(of_axis).chain(planes).collect();
        let (mut pixel, mut seen) = (f64::INFINITY, [DVec3::INFINITY, DVec3::NEG_INFINITY]);
        for camera in cameras {
            if let Some(sight) = Sight::new(camera, size, settings.pixel_aspect, &sides)? {
                pixel = pixel.min(sight.pixel);
                let places = sight.corners.iter().map(|&corner| own.first + own.step * grid.world_to_voxel(corner));
                seen = places.fold(seen, |[from, to], place| [from.min(place), to.max(place)]);
            }
        }
        if pixel == f64::INFINITY {
            return Ok(Needed { level: contents.level, is_limited: false, part: VoxelBox::whole(grid.dims()) });
        }
        if !is_local(settings) {
            seen = [DVec3::NEG_INFINITY, DVec3::INFINITY];
        }
        let spacing = |n: usize| grid.spacing() * contents.lattices[n].step / own.step;
        let length = DVec3::splat(pixel / options.volume.oversampling()).max(spacing(0)) * (1.0 + ROUNDING);
        let wanted = (0..count).rev().find(|&n| spacing(n).cmple(length).all()).unwrap_or(0);
        let most = options.volume.most_downloaded().unwrap_or(u64::MAX).min(memory::available() / SHARE);
        let part = |n: usize| around(seen, contents.lattices[n], contents.levels[n]);
        let bytes = |n: usize| part(n).dims.iter().fold(volume.voxel_type().bytes() as u64, |b, &d| b.saturating_mul(d as u64));
        let level = (wanted..count).find(|&n| bytes(n) <= most).unwrap_or(count - 1);
        Ok(Needed { level, is_limited: level > wanted, part: part(level) })
    }
}

/// Whether nothing beside a view changes it: shadows come from there, and depths are measured from the volume's front.
fn is_local(settings: &Settings) -> bool {
    let Settings { shadows, ambient_occlusion, depth_cue, studio, .. } = settings;
    shadows.is_none() && ambient_occlusion.is_none() && depth_cue.is_none() && studio.is_none()
}

/// Between which voxels a volume reaches.
fn ends(dims: [usize; 3]) -> [DVec3; 2] {
    [DVec3::NEG_ONE, dims.map(|n| n as f64).into()]
}

/// The voxels of a level within bounds in voxels of the finest, and those around them.
fn around([from, to]: [DVec3; 2], lattice: LevelLattice, dims: [usize; 3]) -> VoxelBox {
    let voxel = |place: DVec3| (place - lattice.first) / lattice.step;
    let (a, b) = (voxel(from), voxel(to));
    let side = |i: usize| {
        let last = dims[i] as f64 - 1.0;
        let first = (a[i].min(b[i]) - MARGIN).floor().clamp(0.0, last);
        let end = (a[i].max(b[i]) + MARGIN).ceil().clamp(first, last) + 1.0;
        (first as usize, (end - first) as usize)
    };
    let sides = [0, 1, 2].map(side);
    VoxelBox { first: sides.map(|side| side.0), dims: sides.map(|side| side.1) }
}

/// The voxels of the finest level that a part of another covers.
fn of_finest(part: VoxelBox, dims: [usize; 3], finest: [usize; 3]) -> VoxelBox {
    let scaled = |n: usize, i: usize| n as u128 * finest[i] as u128;
    let first = [0, 1, 2].map(|i| scaled(part.first[i], i).div_ceil(dims[i] as u128) as usize);
    let end = [0, 1, 2].map(|i| (scaled(part.end(i), i) / dims[i] as u128) as usize);
    VoxelBox { first, dims: [0, 1, 2].map(|i| (end[i] - first[i]).max(1)) }
}
