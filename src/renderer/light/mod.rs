//! Light volumes: the share of each light and of the ambient light that reaches every voxel. They are swept once, then looked up by all
//! passes, until the field, the transfer function, a light or something else changes that they depend on.

mod blocks;
mod cells;
mod coarse;
mod grid;
mod host;
mod medium;
#[cfg(feature = "mpi")]
mod ranks;
mod scatter;
mod slabs;
mod sources;
mod sweeps;
#[cfg(test)]
mod tests;

pub(crate) use blocks::{BlockSlabs, HostField, WantedField};
pub(super) use cells::ScatterGrids;
pub(super) use grid::ValueGrid;
pub(super) use host::HostVolumes;
pub(crate) use host::Wanted;
#[cfg(feature = "mpi")]
pub(crate) use ranks::behind;
#[cfg(feature = "mpi")]
pub(crate) use slabs::Target;
pub(crate) use slabs::{LightOfParts, SweepGroup};
pub(super) use sources::LightSources;

use super::channels::{PackedColors, VOXEL_COLORS};
use super::classification::TableSizes;
use super::frame::{Declaring, Resources, Slot};
use super::scene::Scene;
use super::store::{Key, Store, Version};
use crate::device::Buffer;
use crate::device::launch::light::{CoarseTransmittance, FinishLight, LightRays, LightSweep, LightTable};
use crate::device::launch::scatter::ScatterMedium;
use crate::device::launch::structs::ChannelParams;
use crate::device::launch::volume::Transpose;
use crate::device::launch::{Launcher, LightBuffers};
use crate::error::Error;
use crate::layers::{Axis, GradientEstimator, Kernel};
use crate::settings::{Blend, Clipping, GradientOpacity, LightGrid, Settings};
use crate::transfer::Extinction;
use crate::volume::VoxelBox;
use scatter::ScatterKernels;
use sources::Source;
use std::ops::Range;
use std::sync::Arc;
use sweeps::Finish;

/// Largest cache budget in bytes. The newest volume is kept even if it is larger.
const BUDGET: usize = 512 << 20;
/// Part of the budget that does not depend on the size of the volume.
const LEAST: usize = 16 << 20;

/// Light is swept through the field of the paper's cubic, whatever the kernel of the frame, so that frames of all qualities share it.
const KERNEL: Kernel = Kernel::Cubic;

const SHADOWS: &str = "the light of the lights";
const SKY: &str = "the ambient light";

/// Kernel arguments of the fields that absorb light.
const ABSORBERS: Slot<ChannelParams> = Slot::new("the parameters of fields that absorb light");

/// Bytes behind the last value, since look-ups read words.
const PADDING: usize = 4;

/// Light volumes of a renderer, and the kernels that fill them.
pub(super) struct LightVolumes {
    store: Store,
    table: Launcher<LightTable>,
    sweep: Launcher<LightSweep>,
    rays: Launcher<LightRays>,
    finish: Launcher<FinishLight>,
    coarse: Launcher<CoarseTransmittance>,
    transpose: Launcher<Transpose>,
    scatter: ScatterKernels,
    medium: Launcher<ScatterMedium>,
    /// The light volumes of the part that is on the device; `None` if the volume is there as a whole.
    given: Option<UploadedLight>,
}

/// Light volumes that are uploaded with a part of a volume.
#[derive(Default)]
struct UploadedLight {
    /// The light, and the layers of voxels of the part.
    of: Option<(Version, Axis, Range<usize>)>,
    illumination: Illumination,
    /// The values that are held, of the lights and of the ambient light.
    grids: [Option<ValueGrid>; 2],
}

impl Default for LightVolumes {
    fn default() -> Self {
        let (table, sweep, rays, finish) = Default::default();
        let (coarse, transpose, scatter, medium) = Default::default();
        Self { store: Store::new(BUDGET), table, sweep, rays, finish, coarse, transpose, scatter, medium, given: None }
    }
}

/// The light volumes of a frame: of the lights, one after another, and of the ambient light.
#[derive(Clone, Default)]
pub(super) struct Illumination {
    pub lights: Option<Arc<Buffer<u8>>>,
    pub sky: Option<Arc<Buffer<u8>>>,
}

impl Illumination {
    /// Kernel arguments. `unused` stands for volumes that programs do not read.
    pub fn arguments<'a>(&'a self, unused: &'a Buffer<u8>) -> LightBuffers<'a> {
        let [light, sky] = [&self.lights, &self.sky].map(|volume| volume.as_deref().unwrap_or(unused));
        LightBuffers { light, sky }
    }
}

/// What changes the extinction of a field along rays from a light, besides the field and the transfer function.
#[derive(Clone, Copy, PartialEq)]
struct Medium {
    grid: LightGrid,
    extinction: Extinction,
    unit_distance: Option<f64>,
    clipping: Clipping,
    gradient_opacity: Option<(GradientOpacity, GradientEstimator)>,
    blend: Blend,
    culling: bool,
}

impl Medium {
    fn new(settings: &Settings) -> Self {
        Self {
            grid: settings.swept_grid(),
            extinction: settings.extinction,
            unit_distance: settings.unit_distance,
            clipping: settings.clipping,
            gradient_opacity: settings.gradient_opacity.zip(extinction_estimator(settings)),
            blend: settings.blend,
            culling: settings.culling,
        }
    }
}

/// Factor of the light in shadows. The studio has none.
fn forgiveness(settings: &Settings) -> f64 {
    settings.shadows.map_or(1.0, |shadows| shadows.forgiveness)
}

/// The estimator of the gradients that change the opacity along rays from a light, with gradient opacity: the frame's, if the kernel of the
/// light supports it.
pub(super) fn extinction_estimator(settings: &Settings) -> Option<GradientEstimator> {
    let own = settings.gradient_estimator();
    let estimator = if own.supports(KERNEL) { own } else { GradientEstimator::Sobel };
    settings.gradient_opacity.map(|_| estimator)
}

#[derive(PartialEq)]
struct ShadowsKey(Vec<Source>, f64, Vec<Medium>);

impl Key for ShadowsKey {
    type Value = Buffer<u8>;
}

/// Key: reach, gain, media.
#[derive(PartialEq)]
struct SkyKey(Option<f64>, f64, Vec<Medium>);

impl Key for SkyKey {
    type Value = Buffer<u8>;
}

impl LightVolumes {
    /// Drops all volumes.
    pub fn drop_cached(&mut self) {
        self.store.clear();
        self.given = None;
    }

    /// The values that a part of a volume holds, of the lights and of the ambient light.
    pub fn given_grids(&self) -> Option<[Option<ValueGrid>; 2]> {
        self.given.as_ref().map(|given| given.grids)
    }

    /// Number of volumes made so far.
    #[cfg(test)]
    pub fn made(&self) -> usize {
        self.store.made
    }
}

impl Scene<'_> {
    /// The light volumes that samples of this view look up, swept on first use.
    pub fn illumination(&mut self) -> Result<Illumination, Error> {
        if let Some(given) = &self.light.given {
            return Ok(given.illumination.clone());
        }
        let Some(sources) = self.light_sources() else { return Ok(Illumination::default()) };
        // Those of two frames, as while a hand moves and at rest. Lights that move with the camera never come back to a direction.
        let each = self.field.grid().voxel_count().saturating_mul(sources.swept.len() + 1);
        self.light.store.limit(each.saturating_mul(2).saturating_add(LEAST).min(BUDGET));
        let lights = match &sources.swept[..] {
            [] => None,
            swept => Some(self.shadows(swept.to_vec(), forgiveness(self.settings))?),
        };
        let sky = match (sources.studio(), self.settings.ambient_occlusion) {
            (Some((light, grids)), _) => Some(self.scattered(light, *grids, &sources, lights.as_deref())?),
            (None, Some(occlusion)) => Some(self.sky(occlusion.reach, occlusion.gain)?),
            (None, None) => None,
        };
        Ok(Illumination { lights, sky })
    }

    /// The medium of each field.
    fn media(&mut self) -> Result<Vec<Medium>, Error> {
        self.for_each_channel(|scene| Ok(Medium::new(scene.settings)))
    }

    fn shadows(&mut self, swept: Vec<Source>, gain: f64) -> Result<Arc<Buffer<u8>>, Error> {
        let (key, inputs) = (ShadowsKey(swept.clone(), gain, self.media()?), self.inputs());
        if let Some(kept) = self.light.store.get(self.device, &key, inputs)? {
            return Ok(kept);
        }
        let values = ValueGrid::new(self.field.grid().dims(), self.settings.swept_grid().voxels().min(2));
        let volume = self.volume(&key, swept.len(), values, SHADOWS)?;
        let coarse = self.coarse(values, VoxelBox::whole(values.inner()))?;
        let finish = Finish { gain, coded: true };
        for (n, source) in swept.iter().enumerate() {
            let sweeps = sweeps::of_light(source, self.field.grid().spacing());
            self.sweep_all(&sweeps, coarse.as_ref(), values, (&volume, n), finish, None)?;
        }
        Ok(self.light.store.keep(key, inputs, self.device.produced()?, volume))
    }

    fn sky(&mut self, reach: Option<f64>, gain: f64) -> Result<Arc<Buffer<u8>>, Error> {
        let (key, inputs) = (SkyKey(reach, gain, self.media()?), self.inputs());
        if let Some(kept) = self.light.store.get(self.device, &key, inputs)? {
            return Ok(kept);
        }
        let values = ValueGrid::new(self.field.grid().dims(), self.settings.swept_grid().voxels());
        let volume = self.volume(&key, 1, values, SKY)?;
        let coarse = self.coarse(values, VoxelBox::whole(values.inner()))?;
        let finish = Finish { gain, coded: false };
        self.sweep_all(&sweeps::of_sky(self.field.grid().spacing()), coarse.as_ref(), values, (&volume, 0), finish, reach)?;
        Ok(self.light.store.keep(key, inputs, self.device.produced()?, volume))
    }

    /// A buffer for some volumes: that of older inputs, if there is one.
    fn volume<K: Key<Value = Buffer<u8>>>(
        &mut self,
        key: &K,
        volumes: usize,
        values: ValueGrid,
        what: &str,
    ) -> Result<Arc<Buffer<u8>>, Error> {
        let bytes = volumes * values.values() + PADDING;
        check_addressable(values.values())?;
        match self.light.store.reuse(self.device, key, self.inputs(), bytes) {
            Some(reused) => Ok(reused),
            None => Ok(Arc::new(Buffer::new(self.device, bytes, what)?)),
        }
    }
}

/// Rejects volumes that look-ups cannot address.
fn check_addressable(values: usize) -> Result<(), Error> {
    if values <= i32::MAX as usize - PADDING {
        return Ok(());
    }
    let problem = format!("a light volume of {values} bytes is too large: use half or quarter");
    Err(Error::Settings { field: "light_grid", problem })
}

/// Declares the light volumes of a frame, and what they are made from.
pub(super) fn declare(declaring: &Declaring, resources: &mut Resources) {
    let Some(light) = &declaring.light else { return };
    let grid = |voxels: usize| match light.part {
        Some(part) => ValueGrid::new(part.whole, voxels).around_any_part(part.axis, part.layers),
        None => ValueGrid::new(declaring.shape.dims, voxels),
    };
    let voxels = light.grid.voxels();
    let volumes = [(SHADOWS, light.volumes, grid(voxels.min(2))), (SKY, usize::from(light.sky), grid(voxels))];
    let volumes = volumes.into_iter().filter(|(_, count, _)| *count > 0);
    let bytes = |count: usize, values: ValueGrid| count * values.values() + PADDING;
    if light.part.is_some() {
        volumes.for_each(|(name, count, values)| resources.kept((name, None, None, 0), [(name, bytes(count, values))]));
        if let Some(grids) = &light.studio {
            let field = [(scatter::LIGHT_FIELD, scatter::packed_bytes(grids.coarse))];
            resources.kept((scatter::LIGHT_FIELD, None, None, 0), field);
        }
        return;
    }
    declaring.for_each_channel(|declaring| {
        for axis in Axis::ALL {
            declaring.visibility(axis, KERNEL, resources);
            declaring.gradients(axis, KERNEL, resources);
        }
        // Those of the frame may be for shorter segments.
        let (entries, channel) = (declaring.tables.entries(KERNEL), declaring.channel);
        resources.kept(("integrals of light", None, Some(KERNEL), channel), [TableSizes::integrals(entries)]);
        declaring.table(KERNEL, resources);
        if light.grid.voxels() > 1 {
            resources.kept((coarse::TRANSMITTANCE, None, None, channel), [coarse::table(entries)]);
        }
    });
    resources.host(&ABSORBERS, 1 + declaring.others.len());
    resources.kept((sweeps::RAYS, None, None, 0), [(sweeps::RAYS, size_of::<f32>())]);
    if let Some(grids) = &light.studio {
        resources.kept((scatter::LIGHT_FIELD, None, None, 0), scatter::declared(grids, light.grid, declaring.tuning));
        if light.of_colors {
            resources.kept((VOXEL_COLORS, None, None, 0), [(VOXEL_COLORS, PackedColors::size(declaring.shape.dims))]);
        }
    }
    for (name, count, values) in volumes {
        let offsets = sweeps::offsets(declaring.shape.dims);
        resources.kept((name, None, None, 0), [(name, bytes(count, values)), sweeps::sums(values), offsets]);
        if values.voxels() > 1 {
            resources.kept((coarse::COARSE, None, None, 0), coarse::buffers(values.inner().iter().product()));
        }
    }
}
