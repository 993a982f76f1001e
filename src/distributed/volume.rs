//! Volumes distributed over several processes.

use super::group::Group;
use crate::error::Error;
use crate::memory;
use crate::volume::Collective;
use crate::volume::{Grid, Layers, Level, OpenOptions, Storage, Unseen, Volume, VoxelBox};
use std::path::Path;
use std::sync::Arc;

/// Ghost layers that each process reads on either side, for framing, kernels and gradients.
const GHOST_LAYERS: usize = 4;

/// The part of a volume on one process.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brick {
    /// Owned voxels. Every voxel of the volume has exactly one owner.
    pub own: VoxelBox,
    /// Held voxels: the owned ones and ghost layers around them, which other processes own. If the bricks are whole slabs along
    /// the layer axis of the view, rendering sends no voxels, provided that there are enough ghost layers: two, or as many as the
    /// kernel needs ([`PartRenderer::around`](crate::renderer::PartRenderer::around)).
    pub held: VoxelBox,
}

/// Bytes of all voxels of a volume, if [`Group::open`] can open it.
pub(crate) fn bytes_in_parts(source: impl AsRef<Path>, options: &OpenOptions) -> Option<u64> {
    let first = Unseen::open(source.as_ref(), options, &|_| Layers { own: 0..1, held: 0..1 }).ok()?;
    Some(first.bytes() * first.layers_of_all() as u64)
}

impl Group {
    /// A distributed volume from one brick per process. `voxels` are those of `brick.held`, x fastest unless the storage says
    /// otherwise. Calls that need all voxels are collective: range, statistics, automatic transfer functions, percentiles,
    /// framing.
    ///
    /// # Errors
    /// As [`Volume::new`]. An error of one process is returned on all of them.
    pub fn volume<'a>(
        &self,
        name: impl Into<String>,
        grid: Grid,
        brick: Brick,
        voxels: impl Into<Storage<'a>>,
    ) -> Result<Volume<'a>, Error> {
        self.shared(Unseen::new(name, grid, brick.held, brick.own, voxels), |_| 0)
    }

    /// Opens a volume as [`Volume::open`]. Each process reads its own layers along z and a few ghost layers. If the file has
    /// several resolutions and `options` selects none, the finest one that fits into half of the free memory of all processes is
    /// opened.
    ///
    /// # Errors
    /// As [`Volume::open`]; files that can only be read from the beginning. An error of one process is returned on all of them.
    pub fn open(&self, source: impl AsRef<Path>, options: &OpenOptions) -> Result<Volume<'static>, Error> {
        let choose = |[_, _, layers]: [usize; 3]| {
            let own = self.rank() * layers / self.size()..(self.rank() + 1) * layers / self.size();
            // A process that owns no layers still holds some, since boxes must not be empty.
            let first = own.start.saturating_sub(GHOST_LAYERS).min(layers - 1);
            let held = first..(own.end + GHOST_LAYERS).clamp(first + 1, layers);
            Layers { own, held }
        };
        let mut free = [memory::available() / self.on_this_machine() as u64];
        self.count(&mut free);
        let level = options.level.or(Some(Level::Bytes(free[0] / 2)));
        let options = OpenOptions { level, ..options.clone() };
        self.shared(Unseen::open(source.as_ref(), &options, &choose), Unseen::bytes)
    }

    fn shared<'a>(&self, unseen: Result<Unseen<'a>, Error>, read: impl Fn(&Unseen<'a>) -> u64) -> Result<Volume<'a>, Error> {
        let unseen = self.agree(unseen)?;
        let bytes = read(&unseen);
        let converted = self.agree(unseen.converted(self))?;
        self.agree(converted.shared(Arc::new(self.clone()), bytes))
    }
}
