//! Volumes of which only the voxels within labels are left.

use super::{Labels, grid_over};
use crate::error::Error;
use crate::memory;
use crate::volume::covering::linear_shares;
use crate::volume::{Description, Grid, Storage, Volume, VoxelType};
use bytemuck::Zeroable;
use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use std::fmt;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

impl Volume<'_> {
    /// A copy in which voxels outside the visible labels have the background's value. The mask has a grid of its own: between its voxels its
    /// border is smooth, as surfaces of labels are. A mask that states no placement has that of a volume of its size.
    ///
    /// # Errors
    /// [`Error::Volume`] if no voxel of the volume lies within a visible label, for a mask of another size without a placement
    /// ([`Labels::over`]), and if memory is too small.
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
        Ok(masked.with_contents(self.contents().clone()).with_overview(self.overview.clone()))
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
        let layers = self.layers.iter().map(|layer| layer.placed(&self.name, volume.description()));
        let layers = layers.collect::<Result<Vec<_>, Error>>()?;
        kept.par_chunks_mut(x).enumerate().for_each(|(row, kept)| {
            for (i, kept) in kept.iter_mut().enumerate() {
                let place = DVec3::new(i as f64, (row % y) as f64, (row / y) as f64);
                *kept = u8::from(layers.iter().any(|layer| layer.shows(place)));
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

/// A layer over the voxels of a volume.
struct Placed<'a> {
    layer: &'a Layer,
    /// From voxels of the volume to those of the layer.
    moved: DAffine3,
    /// Of each voxel of the layer, its share of labels that show, 0 to 255. `None` if the voxels of the volume are voxels of the layer.
    shares: Option<Vec<u8>>,
}

/// Weights of voxels with labels that show, among the 27 around a voxel, between which the share rises from 0 to 1; 64 together. As in
/// kernels/volume/label_voxels.cl, so that the border of a mask is the surface of its labels.
const SHARED_BETWEEN: [f64; 2] = [10.0, 54.0];
/// Least share of a voxel whose label shows: thin and small labels stay.
const OWN_SHARE: f64 = 0.9;
/// Distance of voxels that coincide.
const SAME: f64 = 1e-3;

impl Layer {
    /// # Errors
    /// As [`grid_over`], and if memory is too small.
    fn placed(&self, name: &str, volume: &Description) -> Result<Placed<'_>, Error> {
        let grid = grid_over(name, (self.indices.grid(), self.indices.contents().states_spacing), volume)?;
        let moved = grid.index_to_world().inverse() * volume.grid().index_to_world();
        let coincide = volume.grid().corner_voxels().into_iter().all(|corner| {
            let place = moved.transform_point3(corner);
            let steps = place - moved.translation;
            place.distance(place.round()) < SAME && steps.distance(corner) < SAME
        });
        let shares = if coincide { None } else { Some(self.shares(name)?) };
        Ok(Placed { layer: self, moved, shares })
    }

    /// Whether the label of a voxel shows.
    fn is_shown(&self, voxel: usize) -> bool {
        self.shown[self.indices.value(voxel) as usize]
    }

    /// Of each voxel, the share of labels that show among those around it, 0 to 255.
    fn shares(&self, name: &str) -> Result<Vec<u8>, Error> {
        let dims = self.indices.grid().dims();
        let [x, y, _] = dims;
        let shown: Vec<u8> = filled(name, dims.iter().product(), |n| u8::from(self.is_shown(n)))?;
        filled(name, shown.len(), |n| {
            let place = [n % x, n / x % y, n / x / y];
            let weight: f64 = (0..27)
                .map(|around| {
                    let offset = [around % 3, around / 3 % 3, around / 9];
                    let near: [usize; 3] = std::array::from_fn(|i| (place[i] + offset[i]).saturating_sub(1).min(dims[i] - 1));
                    let weight: f64 = offset.iter().map(|&i| if i == 1 { 2.0 } else { 1.0 }).product();
                    weight * f64::from(shown[(near[2] * y + near[1]) * x + near[0]])
                })
                .sum();
            let [from, to] = SHARED_BETWEEN;
            let share = ((weight - from) / (to - from)).clamp(if shown[n] > 0 { OWN_SHARE } else { 0.0 }, 1.0);
            (share * 255.0).round() as u8
        })
    }
}

impl Placed<'_> {
    /// Whether a voxel of the volume is kept.
    fn shows(&self, voxel: DVec3) -> bool {
        let place = self.moved.transform_point3(voxel);
        let grid = self.layer.indices.grid();
        let Some(nearest) = grid.nearest_voxel(place) else { return false };
        let Some(shares) = &self.shares else { return self.layer.is_shown(nearest) };
        let [x, y, _] = grid.dims();
        let last = DVec3::from_array(grid.dims().map(|n| n as f64 - 1.0));
        let share: f64 = linear_shares(place.clamp(DVec3::ZERO, last))
            .map(|(voxel, weight)| {
                let [i, j, k] = voxel.min(last).to_array().map(|i| i as usize);
                weight * f64::from(shares[(k * y + j) * x + i])
            })
            .sum();
        share >= 127.5
    }
}
