//! Volumes whose voxels are with several processes.

use super::group::Group;
use crate::error::Error;
use crate::memory;
use crate::volume::Together;
use crate::volume::{Grid, Layers, Level, OpenOptions, Storage, Unseen, Volume, VoxelBox};
use std::path::Path;
use std::sync::Arc;

/// Layers around its own that each process reads: what framing, kernels and gradients look at.
const AROUND: usize = 4;

/// The voxels that a process has of a volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brick {
    /// Those that no other process has as its own.
    pub own: VoxelBox,
    /// These and ghost layers around them, which others have, too. With two, or as many as a kernel needs
    /// ([`PartRenderer::around`](crate::renderer::PartRenderer::around)), views along an axis across which bricks are whole slabs are
    /// drawn without sending a voxel.
    pub held: VoxelBox,
}

/// Bytes of all voxels of a volume that [`Group::open`] can open; `None` if it cannot.
pub(crate) fn bytes_in_parts(source: impl AsRef<Path>, options: &OpenOptions) -> Option<u64> {
    let first = Unseen::open(source.as_ref(), options, &|_| Layers { own: 0..1, held: 0..1 }).ok()?;
    Some(first.bytes() * first.layers_of_all() as u64)
}

impl Group {
    /// A volume of which every process has a brick: what is found by looking at all voxels (range, statistics, automatic transfer
    /// functions, percentiles, framing) is found together, and such calls are collective. Voxels are those of `held`, x fastest unless
    /// the storage says otherwise.
    ///
    /// # Errors
    /// As [`Volume::new`], on all processes what fails on one.
    pub fn volume<'a>(
        &self,
        name: impl Into<String>,
        grid: Grid,
        brick: Brick,
        voxels: impl Into<Storage<'a>>,
    ) -> Result<Volume<'a>, Error> {
        self.shared(Unseen::new(name, grid, brick.held, brick.own, voxels), |_| 0)
    }

    /// Opens a volume as [`Volume::open`] does, of which every process reads its own layers along z and a few around them. Of
    /// several resolutions, where none is chosen, it is the finest that fits into half of the free memory of all.
    ///
    /// # Errors
    /// As [`Volume::open`], and files of which no part can be read without all before it; on all processes what fails on one.
    pub fn open(&self, source: impl AsRef<Path>, options: &OpenOptions) -> Result<Volume<'static>, Error> {
        let choose = |[_, _, layers]: [usize; 3]| {
            let own = self.rank() * layers / self.size()..(self.rank() + 1) * layers / self.size();
            // Who has none holds some all the same: there is no empty box.
            let first = own.start.saturating_sub(AROUND).min(layers - 1);
            let held = first..(own.end + AROUND).clamp(first + 1, layers);
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
