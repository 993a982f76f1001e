//! Light of volumes of which the device holds a part at a time: slabs of layers are swept one after another, in the direction in which the
//! light shines. Rays continue from their state behind the slab before, so that the light is that of the whole volume, bit for bit.

use super::super::classification::TableSizes;
use super::super::frame::{Declaring, Resources};
use super::super::scene::Scene;
use super::super::store::Version;
use super::blocks::HostField;
use super::grid::ValueGrid;
use super::host::{HostVolumes, Wanted};
use super::sweeps::{self, State, Stored, Sweep, sum_of};
use super::{ABSORBERS, Illumination, KERNEL, PADDING, UploadedLight, check_addressable, coarse, extinction_estimator};
use crate::device::launch::light::LightSweep;
use crate::device::{Buffer, Device, Tuning};
use crate::error::Error;
use crate::layers::Axis;
use crate::settings::Settings;
use crate::volume::VoxelBox;
use glam::DVec3;
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Layers around a slab that estimators of gradients read, besides those that they smooth over.
pub(super) const AROUND_GRADIENTS: usize = 3;

/// Sums that become bytes at once.
const FINISHED: usize = 1 << 16;

/// A light volume to which a sweep contributes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Target {
    /// Index among the wanted volumes, and number of the volume of one of their lights.
    pub(super) wanted: usize,
    pub(super) volume: usize,
    /// Whether the volume has several sweeps, and so has sums.
    pub(super) several: bool,
    gain: f64,
    pub(super) reach: Option<f64>,
}

/// Sweeps through the same layers in the same order, which therefore share the voxels of a slab.
pub(crate) struct SweepGroup {
    pub axis: Axis,
    pub(super) descends: bool,
    /// All values.
    pub(super) grid: ValueGrid,
    voxel_dims: [usize; 3],
    pub(super) spacing: DVec3,
    /// Layers of voxels that gradients need around a slab.
    around: usize,
    pub(super) sweeps: Vec<(Target, Sweep)>,
    /// Layers of values of each slab, without the margin, in the order of the light.
    pub slabs: Vec<Range<usize>>,
    /// The rays of each sweep behind the slabs so far, tile by tile; empty where none are dimmed.
    rays: Mutex<Vec<Vec<f32>>>,
}

impl SweepGroup {
    /// The sweeps of the wanted volumes of a grid of `dims` voxels for which `is_missing` holds, in groups without slabs.
    pub fn all(
        wanted: &[Wanted],
        is_missing: impl Fn(&Wanted) -> bool,
        (voxel_dims, spacing): ([usize; 3], DVec3),
        settings: &Settings,
    ) -> Vec<Self> {
        let around = extinction_estimator(settings).map_or(0, |estimator| AROUND_GRADIENTS + estimator.smoothing_radius());
        let mut groups: Vec<Self> = Vec::new();
        for (n, of) in wanted.iter().enumerate().filter(|(_, of)| is_missing(of)) {
            for (volume, sweeps) in of.sweeps(spacing).into_iter().enumerate() {
                let target = Target { wanted: n, volume, several: sweeps.len() > 1, gain: of.gain, reach: of.reach() };
                for sweep in sweeps {
                    let (axis, descends, grid) = (sweep.axis, sweep.descends(), ValueGrid::new(voxel_dims, of.grid.voxels()));
                    let shares = |group: &&mut Self| (group.axis, group.descends, group.grid) == (axis, descends, grid);
                    match groups.iter_mut().find(shares) {
                        Some(group) => group.sweeps.push((target, sweep)),
                        None => groups.push(Self {
                            axis,
                            descends,
                            grid,
                            voxel_dims,
                            spacing,
                            around,
                            sweeps: vec![(target, sweep)],
                            slabs: Vec::new(),
                            rays: Mutex::default(),
                        }),
                    }
                }
            }
        }
        groups
    }

    /// Number of layers of values, without the margin.
    pub fn layers(&self) -> usize {
        self.grid.inner()[self.axis.index()]
    }

    /// Layers of values of the largest slab.
    pub fn most_layers(&self) -> usize {
        self.slabs.iter().map(Range::len).max().unwrap_or(0)
    }

    /// Divides the layers into this many slabs.
    pub fn divide(&mut self, slabs: usize) {
        let all = self.layers();
        self.slabs = (0..slabs).map(|n| n * all / slabs..(n + 1) * all / slabs).collect();
        if self.descends {
            self.slabs.reverse();
        }
    }

    pub(super) fn rays(&self) -> MutexGuard<'_, Vec<Vec<f32>>> {
        self.rays.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether the light leaves the volume behind a slab.
    fn ends(&self, slab: &Range<usize>) -> bool {
        if self.descends { slab.start == 0 } else { slab.end == self.layers() }
    }

    /// The layers of values whose voxels a slab needs: its own, and the one before it in the order of the light.
    fn sampled(&self, slab: &Range<usize>) -> Range<usize> {
        if self.descends { slab.start..(slab.end + 1).min(self.layers()) } else { slab.start.saturating_sub(1)..slab.end }
    }

    /// The voxels that a slab needs.
    pub fn voxels(&self, slab: &Range<usize>) -> VoxelBox {
        let (a, sampled, per_value) = (self.axis.index(), self.sampled(slab), self.grid.voxels());
        let first = (sampled.start * per_value).saturating_sub(self.around);
        let end = (sampled.end * per_value + self.around).min(self.voxel_dims[a]);
        VoxelBox::layers(self.voxel_dims, a, &(first..end))
    }

    /// Dimensions of the voxels that a slab of this many layers needs at most.
    pub fn most_voxels(&self, layers: usize) -> [usize; 3] {
        let mut dims = self.voxel_dims;
        let own = &mut dims[self.axis.index()];
        *own = ((layers + 1) * self.grid.voxels() + 2 * self.around).min(*own);
        dims
    }

    /// The values of a slab. Those of the margin belong to the first and the last one.
    pub(super) fn values(&self, slab: &Range<usize>) -> ValueGrid {
        let first = if slab.start == 0 { 0 } else { slab.start + 1 };
        let end = if slab.end == self.layers() { slab.end + 2 } else { slab.end + 1 };
        self.grid.with_layers(self.axis, &(first..end))
    }

    /// The values of a slab of this many layers, at most.
    fn most_values(&self, layers: usize) -> ValueGrid {
        self.grid.with_layers(self.axis, &(0..layers + 2))
    }

    /// Declares what sweeps through slabs of at most this many layers need besides the voxels.
    pub(in crate::renderer) fn declare(&self, declaring: &Declaring, layers: usize, resources: &mut Resources) {
        let entries = declaring.tables.entries(KERNEL);
        if self.grid.voxels() == 1 {
            declaring.visibility(self.axis, KERNEL, resources);
            declaring.gradients(self.axis, KERNEL, resources);
        } else {
            declaring.gradients(Axis::Z, KERNEL, resources);
            let mut blocks = self.grid.inner();
            blocks[self.axis.index()] = (layers + 1).min(blocks[self.axis.index()]);
            resources.kept((coarse::COARSE, None, None, 0), coarse::buffers(blocks.iter().product()));
            resources.kept((coarse::TRANSMITTANCE, None, None, 0), [coarse::table(entries)]);
        }
        resources.host(&ABSORBERS, 1);
        declaring.table(KERNEL, resources);
        resources.kept(("integrals of light", None, Some(KERNEL), 0), [TableSizes::integrals(entries)]);
        let values = self.most_values(layers).values();
        let of_bytes = if self.sweeps.iter().any(|(target, _)| !target.several) { values } else { 1 };
        let of_sums = if self.sweeps.iter().any(|(target, _)| target.several) { values } else { 1 };
        let rays = self.sweeps.iter().map(|(_, sweep)| self.states(sweep, declaring.tuning)).max().unwrap_or(0);
        let finished = FINISHED.min(self.grid.values());
        resources.kept(
            ("slabs", None, None, 0),
            [
                (super::SHADOWS, of_bytes),
                (sweeps::SUMS, size_of::<u16>() * of_sums),
                (sweeps::RAYS, size_of::<f32>() * rays),
                sweeps::offsets(self.grid.inner()),
                (sweeps::SUMS, (size_of::<u16>() + 1) * finished),
            ],
        );
    }

    /// Number of states of a sweep's rays.
    pub(super) fn states(&self, sweep: &Sweep, tuning: &Tuning) -> usize {
        LightSweep::states(sweep.rays(&self.grid, self.spacing).size, tuning)
    }
}

/// The light volumes of a frame in parts, which its steps fill and look up.
pub(crate) struct LightOfParts {
    volumes: Mutex<Vec<HostVolumes>>,
    /// In the studio.
    field: Mutex<Option<HostField>>,
    version: Version,
}

impl LightOfParts {
    /// The volumes in the order in which they are wanted.
    pub fn new(volumes: Vec<HostVolumes>, field: Option<HostField>) -> Self {
        Self { volumes: Mutex::new(volumes), field: Mutex::new(field), version: Version::new() }
    }

    pub(super) fn field(&self) -> MutexGuard<'_, Option<HostField>> {
        self.field.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes the light field.
    pub fn take_field(&self) -> Option<HostField> {
        self.field().take()
    }

    pub(super) fn volumes(&self) -> MutexGuard<'_, Vec<HostVolumes>> {
        self.volumes.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts or adds values of boxes to the volumes that sweeps contribute to. Without volumes, they are ignored.
    pub(super) fn merge(&self, found: impl IntoIterator<Item = (Target, VoxelBox, Vec<u8>)>) {
        let mut volumes = self.volumes();
        for (target, from, bytes) in found {
            if let Some(volumes) = volumes.get_mut(target.wanted) {
                volumes.merge(target.volume, from, &bytes);
            }
        }
    }

    pub fn into_volumes(self) -> Vec<HostVolumes> {
        self.volumes.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The sums of several sweeps, or the bytes of one.
fn read_values(device: &Device, from: Result<&Buffer<u16>, &Buffer<u8>>, values: usize) -> Result<Vec<u8>, Error> {
    match from {
        Ok(sums) => {
            let mut found = vec![0u16; values];
            sums.read(device, &mut found)?;
            Ok(bytemuck::cast_slice(&found).to_vec())
        }
        Err(bytes) => {
            let mut found = vec![0; values];
            bytes.read(device, &mut found)?;
            Ok(found)
        }
    }
}

impl Scene<'_> {
    /// Sweeps light through slab number `slab` of a group, whose voxels are on the device. Changes nothing if it fails.
    pub fn sweep_slab(&mut self, light: &LightOfParts, group: &SweepGroup, slab: usize) -> Result<(), Error> {
        let layers = &group.slabs[slab];
        let values = group.values(layers);
        let blocks = VoxelBox::layers(group.grid.inner(), group.axis.index(), &group.sampled(layers));
        let coarse = self.coarse(values, blocks)?;
        let mut rays = group.rays();
        let (mut states, mut found) = (Vec::new(), Vec::new());
        for sweeps in group.sweeps.chunk_by(|(target, _), (other, _)| target == other) {
            let (target, several) = (sweeps[0].0, sweeps[0].0.several);
            let of = |needed: bool| if needed { values.values() } else { 1 };
            let volume = Buffer::new(self.device, of(!several), super::SHADOWS)?;
            let sums = Buffer::new(self.device, of(several), sweeps::SUMS)?;
            for (n, (_, sweep)) in sweeps.iter().enumerate() {
                let mut state = rays.get(states.len()).cloned().unwrap_or_default();
                let continues = !state.is_empty();
                state.resize(group.states(sweep, self.device.tuning()), 1.0);
                let on_device = Buffer::from_slice(self.device, &state, sweeps::RAYS)?;
                let (sum, gain, steps) = sum_of(sweep, several, n, target.gain);
                let stored = Stored { volume: &volume, number: 0, sums: &sums, sum, gain, steps };
                let continued = State { rays: &on_device, continues };
                self.sweep(sweep, coarse.as_ref(), values, &stored, target.reach, continued)?;
                if !group.ends(layers) {
                    on_device.read(self.device, &mut state)?;
                }
                states.push(state);
            }
            found.push((target, read_values(self.device, if several { Ok(&sums) } else { Err(&volume) }, values.values())?));
        }
        *rays = states;
        light.merge(found.into_iter().map(|(target, bytes)| (target, values.held(), bytes)));
        Ok(())
    }

    /// Completes the light volumes: all sweeps are in.
    pub fn finish_light(&mut self, light: &LightOfParts) -> Result<(), Error> {
        for volumes in light.volumes().iter_mut().filter(|volumes| !volumes.is_complete) {
            let finish = volumes.wanted.finish();
            volumes.finish(FINISHED, |sums, bytes| {
                let (sums, found) =
                    (Buffer::from_slice(self.device, sums, sweeps::SUMS)?, Buffer::new(self.device, sums.len(), sweeps::SUMS)?);
                self.finish_sums(&sums, bytes.len(), finish, (&found, 0))?;
                found.read(self.device, bytes)
            })?;
        }
        Ok(())
    }

    /// Uploads the light that a part of a view looks up, which holds these layers of voxels along an axis, unless it is there already.
    pub fn hold_light(&mut self, light: &LightOfParts, axis: Axis, voxels: &Range<usize>) -> Result<(), Error> {
        let of = Some((light.version, axis, voxels.clone()));
        if self.light.given.as_ref().is_some_and(|given| given.of == of) {
            return Ok(());
        }
        // Free its memory first, except that of the light field, which all parts have.
        let last = self.light.given.take().filter(|given| given.of.as_ref().is_some_and(|of| of.0 == light.version));
        let field = light.field();
        let field = field.as_ref().filter(|field| field.is_complete());
        let kept = last.and_then(|given| given.illumination.sky).filter(|_| field.is_some());
        let mut given = UploadedLight { of, ..UploadedLight::default() };
        given.illumination.sky = match (field, kept) {
            (Some(field), None) => Some(field.upload(self.device)?),
            (_, kept) => kept,
        };
        for volumes in light.volumes().iter() {
            let (grid, gathered) = volumes.around_part(axis, voxels);
            check_addressable(grid.values())?;
            let name = volumes.wanted.name();
            let mut buffer = Buffer::new(self.device, gathered.len() * grid.values() + PADDING, name)?;
            for (n, values) in gathered.iter().enumerate() {
                buffer.write_at(self.device, n * grid.values(), values)?;
            }
            let (held, buffer) = (Some(grid), Some(Arc::new(buffer)));
            let Illumination { lights, sky } = &mut given.illumination;
            if volumes.wanted.is_sky() {
                (given.grids[1], *sky) = (held, buffer);
            } else {
                (given.grids[0], *lights) = (held, buffer);
            }
        }
        self.light.given = Some(given);
        Ok(())
    }
}
