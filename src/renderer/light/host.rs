//! Light volumes on the host, for volumes of which the device holds a part at a time.

use super::grid::ValueGrid;
use super::sources::{LightSources, Source};
use super::sweeps::{self, Finish, Sweep};
use super::{Medium, SHADOWS, SKY, forgiveness};
use crate::error::Error;
use crate::layers::Axis;
use crate::settings::Settings;
use crate::volume::{MappedBytes, VoxelBox};
use glam::DVec3;
use std::ops::Range;

/// Light volumes that a view needs, and all that they depend on besides the field and the transfer function.
#[derive(Clone, PartialEq)]
pub(crate) struct Wanted {
    light: WantedLight,
    pub(super) gain: f64,
    medium: Medium,
    /// All values, or those that are wanted.
    pub(super) grid: ValueGrid,
}

#[derive(Clone, PartialEq)]
enum WantedLight {
    Lights(Vec<Source>),
    Sky { reach: Option<f64> },
}

impl Wanted {
    /// The light volumes of a view: of its lights that are swept, and of the ambient light.
    pub(in crate::renderer) fn all(sources: &LightSources, settings: &Settings) -> Vec<Self> {
        let (medium, [shadows, sky]) = (Medium::new(settings), sources.grids());
        let lights = (!sources.swept.is_empty()).then(|| Self {
            light: WantedLight::Lights(sources.swept.clone()),
            gain: forgiveness(settings),
            medium,
            grid: shadows,
        });
        let sky = settings.ambient_occlusion.map(|of| Self {
            light: WantedLight::Sky { reach: of.reach },
            gain: of.gain,
            medium,
            grid: sky,
        });
        lights.into_iter().chain(sky).collect()
    }

    /// The same volumes in the layers that a part of a view looks up, which holds these layers of voxels along an axis.
    #[cfg(feature = "mpi")]
    pub(crate) fn around_part(&self, axis: Axis, voxels: &Range<usize>) -> Self {
        Self { grid: self.grid.around_part(axis, voxels), ..self.clone() }
    }

    /// The same volumes with the values of another grid.
    #[cfg(feature = "mpi")]
    pub(super) fn with_grid(&self, grid: ValueGrid) -> Self {
        Self { grid, ..self.clone() }
    }

    /// The sweeps of each volume.
    pub(super) fn sweeps(&self, spacing: DVec3) -> Vec<Vec<Sweep>> {
        match &self.light {
            WantedLight::Lights(lights) => lights.iter().map(|light| sweeps::of_light(light, spacing)).collect(),
            WantedLight::Sky { .. } => vec![sweeps::of_sky(spacing)],
        }
    }

    pub(super) fn reach(&self) -> Option<f64> {
        if let WantedLight::Sky { reach } = self.light { reach } else { None }
    }

    pub fn is_sky(&self) -> bool {
        matches!(self.light, WantedLight::Sky { .. })
    }

    pub(super) fn finish(&self) -> Finish {
        Finish { gain: self.gain, coded: !self.is_sky() }
    }

    /// Number of volumes.
    pub fn volumes(&self) -> usize {
        if let WantedLight::Lights(lights) = &self.light { lights.len() } else { 1 }
    }

    /// Name for messages.
    pub(super) fn name(&self) -> &'static str {
        if self.is_sky() { SKY } else { SHADOWS }
    }
}

/// Light volumes on the host: their bytes and, until all sweeps are in, the sums of those that have several.
pub(crate) struct HostVolumes {
    pub wanted: Wanted,
    bytes: Vec<MappedBytes>,
    sums: Vec<Option<MappedBytes>>,
    /// Whether all light is in.
    pub is_complete: bool,
}

impl HostVolumes {
    /// Volumes without light, in temporary files.
    pub fn new(wanted: &Wanted, spacing: DVec3) -> Result<Self, Error> {
        let values = wanted.grid.values();
        let bytes = (0..wanted.volumes()).map(|_| MappedBytes::zeroed(values));
        let sums = wanted.sweeps(spacing).into_iter().map(|sweeps| {
            let several = sweeps.len() > 1;
            several.then(|| MappedBytes::zeroed(size_of::<u16>() * values)).transpose()
        });
        let (bytes, sums) = (bytes.collect::<Result<_, _>>()?, sums.collect::<Result<_, _>>()?);
        Ok(Self { wanted: wanted.clone(), bytes, sums, is_complete: false })
    }

    /// Stores the bytes of a box in volume `n`; if that has several sweeps, they are sums, which are added.
    pub(super) fn merge(&mut self, n: usize, from: VoxelBox, bytes: &[u8]) {
        let held = self.wanted.grid.held();
        let Some(sums) = &mut self.sums[n] else {
            for Row { at, to, len } in rows(&from, &held) {
                self.bytes[n][to..to + len].copy_from_slice(&bytes[at..at + len]);
            }
            return;
        };
        const SUM: usize = size_of::<u16>();
        let sums: &mut [u16] = bytemuck::cast_slice_mut(sums);
        for Row { at, to, len } in rows(&from, &held) {
            // The bytes need not be aligned.
            let added = bytes[SUM * at..SUM * (at + len)].chunks_exact(SUM).map(|bytes| u16::from_ne_bytes([bytes[0], bytes[1]]));
            sums[to..to + len].iter_mut().zip(added).for_each(|(sum, value)| *sum += value);
        }
    }

    /// Copies of the bytes of a box, which must be held, from volume `n`; of its sums, if it has several sweeps.
    #[cfg(feature = "mpi")]
    pub(super) fn values_of(&self, n: usize, wanted: VoxelBox) -> Vec<u8> {
        let (bytes, size): (&[u8], usize) = match &self.sums[n] {
            Some(sums) => (sums, size_of::<u16>()),
            None => (&self.bytes[n], 1),
        };
        rows(&self.wanted.grid.held(), &wanted)
            .flat_map(|Row { at, len, .. }| &bytes[size * at..size * (at + len)])
            .copied()
            .collect()
    }

    /// Calls `finish` with pieces of the sums of each volume and the bytes that they become. All light is in then.
    pub(super) fn finish(
        &mut self,
        most: usize,
        mut finish: impl FnMut(&[u16], &mut [u8]) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let values = self.wanted.grid.values();
        for (bytes, sums) in self.bytes.iter_mut().zip(&mut self.sums) {
            if let Some(sums) = sums {
                let sums: &[u16] = &bytemuck::cast_slice(sums)[..values];
                sums.chunks(most).zip(bytes.chunks_mut(most)).try_for_each(|(sums, bytes)| finish(sums, bytes))?;
            }
            *sums = None;
        }
        self.is_complete = true;
        Ok(())
    }

    /// The layers of each volume that a part of a view looks up. `voxels`: the layers of voxels that it holds.
    pub(super) fn around_part(&self, axis: Axis, voxels: &Range<usize>) -> (ValueGrid, Vec<Vec<u8>>) {
        let grid = self.wanted.grid.around_part(axis, voxels);
        let gathered = self.bytes.iter().map(|bytes| {
            let mut values = vec![0; grid.values()];
            for Row { at, to, len } in rows(&self.wanted.grid.held(), &grid.held()) {
                values[to..to + len].copy_from_slice(&bytes[at..at + len]);
            }
            values
        });
        (grid, gathered.collect())
    }
}

/// A row of values that two boxes have in common: its place in either, and its length.
struct Row {
    at: usize,
    to: usize,
    len: usize,
}

/// The rows that two boxes have in common, x fastest.
fn rows(from: &VoxelBox, to: &VoxelBox) -> impl Iterator<Item = Row> + use<> {
    let common = from.common(to).unwrap_or(VoxelBox { first: from.first, dims: [0; 3] });
    let index = |of: VoxelBox, [x, y, z]: [usize; 3]| {
        let [i, j, k] = [x - of.first[0], y - of.first[1], z - of.first[2]];
        i + of.dims[0] * (j + of.dims[1] * k)
    };
    let (from, to, [x, y, z]) = (*from, *to, common.first);
    (0..common.dims[1] * common.dims[2]).map(move |n| {
        let place = [x, y + n % common.dims[1], z + n / common.dims[1]];
        Row { at: index(from, place), to: index(to, place), len: common.dims[0] }
    })
}
