//! Volumes of which only the voxels within labels are left.

use super::Labels;
use crate::error::Error;
use crate::memory;
use crate::volume::{Grid, Storage, Volume, VoxelType};
use bytemuck::Zeroable;
use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use std::fmt;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

impl Volume<'_> {
    /// A copy in which voxels outside the visible labels have the background's value. A voxel takes the label of the nearest voxel of the
    /// mask; their grids may differ.
    ///
    /// # Errors
    /// [`Error::Volume`] if no voxel of the volume lies within a visible label, and if memory is too small.
    pub fn masked(&self, mask: &Labels) -> Result<Volume<'static>, Error> {
        Mask::new(mask)?.applied_to(self)
    }

    /// A copy in which voxels with 0 in `kept` have the background's value.
    fn with_voxels_where(&self, kept: &[u8]) -> Result<Volume<'static>, Error> {
        let rescale = self.description().rescale();
        let background = self.background();
        let stored = |n: usize| rescale.stored(if kept[n] == 0 { background } else { self.value(n) });
        let count = kept.len();
        let voxels: Storage<'static> = match self.voxel_type() {
            VoxelType::Uint8 => filled(self.name(), count, |n| stored(n).round() as u8)?.into(),
            VoxelType::Int8 => filled(self.name(), count, |n| stored(n).round() as i8)?.into(),
            VoxelType::Uint16 => filled(self.name(), count, |n| stored(n).round() as u16)?.into(),
            VoxelType::Int16 => filled(self.name(), count, |n| stored(n).round() as i16)?.into(),
            VoxelType::Float32 => filled(self.name(), count, |n| stored(n) as f32)?.into(),
        };
        let masked = Volume::new(self.name(), self.grid().clone(), voxels)?.with_rescale(rescale).with_background(background)?;
        Ok(masked.with_contents(self.contents().clone()))
    }
}

/// Numbers by index, if there is memory for them.
fn filled<T: Zeroable + Clone + Send>(name: &str, count: usize, number: impl Fn(usize) -> T + Sync) -> Result<Vec<T>, Error> {
    let mut numbers = memory::zeroed(name, count)?;
    numbers.par_iter_mut().enumerate().for_each(|(n, slot)| *slot = number(n));
    Ok(numbers)
}

/// Labels within which volumes show.
pub(in crate::volume) struct Mask {
    name: String,
    layers: Vec<Layer>,
    /// The voxels that it keeps of the last volume's grid: volumes of a sequence have one.
    last: Mutex<Option<(Grid, Arc<Vec<u8>>)>>,
}

impl Mask {
    /// # Errors
    /// If memory is too small.
    pub fn new(labels: &Labels) -> Result<Self, Error> {
        let layers = labels.layers().iter().map(|layer| {
            let shown = layer.palette().iter().map(|entry| entry[3] > 0.0).collect();
            Ok(Layer { indices: layer.indices(None)?, shown })
        });
        Ok(Self { name: labels.name(), layers: layers.collect::<Result<_, Error>>()?, last: Mutex::default() })
    }

    /// What of a volume lies within the labels.
    ///
    /// # Errors
    /// As [`Volume::masked`].
    pub fn applied_to(&self, volume: &Volume) -> Result<Volume<'static>, Error> {
        volume.with_voxels_where(&self.kept_of(volume)?)
    }

    /// 1 for voxels that are kept, otherwise 0.
    fn kept_of(&self, volume: &Volume) -> Result<Arc<Vec<u8>>, Error> {
        let grid = volume.grid();
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, kept)) = last.as_ref().filter(|(of, _)| of == grid) {
            return Ok(kept.clone());
        }
        let [x, y, z] = grid.dims();
        let mut kept: Vec<u8> = memory::zeroed(volume.name(), grid.voxel_count())?;
        let moves: Vec<DAffine3> = self.layers.iter().map(|layer| layer.transform_from(grid)).collect();
        kept.par_chunks_mut(x).enumerate().for_each(|(row, kept)| {
            for (i, kept) in kept.iter_mut().enumerate() {
                let place = DVec3::new(i as f64, (row % y) as f64, (row / y) as f64);
                let is_inside = self.layers.iter().zip(&moves).any(|(layer, moved)| layer.shows(moved.transform_point3(place)));
                *kept = u8::from(is_inside);
            }
        });
        if kept.iter().all(|&kept| kept == 0) {
            let problem = format!(
                "none of its {x}x{y}x{z} voxels lies within a visible label of the mask {}: check the placement of both, or choose \
                 other labels",
                self.name
            );
            return Err(Error::volume(Path::new(volume.name()), problem));
        }
        let kept = Arc::new(kept);
        *last = Some((grid.clone(), kept.clone()));
        Ok(kept)
    }
}

impl fmt::Debug for Mask {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "labels of {}", self.name)
    }
}

/// A layer of labels, and which of them show.
struct Layer {
    indices: Volume<'static>,
    shown: Vec<bool>,
}

impl Layer {
    /// Transform from voxels of a grid to those of the layer.
    fn transform_from(&self, grid: &Grid) -> DAffine3 {
        self.indices.grid().index_to_world().inverse() * grid.index_to_world()
    }

    /// Whether the voxel nearest to a place, in voxels, has a label that shows.
    fn shows(&self, place: DVec3) -> bool {
        self.indices.grid().nearest_voxel(place).is_some_and(|n| self.shown[self.indices.value(n) as usize])
    }
}
