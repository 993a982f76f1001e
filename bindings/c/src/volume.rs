//! Volumes in the host's memory and in files.

use crate::border::{Failure, Out, borrowed, free, guard, text};
use crate::{Grid, Status, VoxelType};
use layersplat::OpenOptions;
use layersplat::volume::{self, Storage};
use std::ffi::{c_char, c_void};

/// A volume in the host's memory or in a file. Nothing changes it: any thread may use it, several at a time.
pub struct Volume(pub(crate) layersplat::Volume<'static>);

/// Voxels of the caller's.
struct Lent {
    first: *const u8,
    bytes: usize,
}

// SAFETY: whoever lends voxels promises that nothing changes or frees them.
unsafe impl Send for Lent {}
// SAFETY: as above.
unsafe impl Sync for Lent {}

impl AsRef<[u8]> for Lent {
    fn as_ref(&self) -> &[u8] {
        // SAFETY: whoever lends voxels promises that there are so many bytes.
        unsafe { std::slice::from_raw_parts(self.first, self.bytes) }
    }
}

/// What the caller shows, and the grid that it fills.
unsafe fn lent(
    voxels: *const c_void,
    bytes: usize,
    voxel_type: i32,
    grid: *const Grid,
) -> Result<(Lent, volume::VoxelType, volume::Grid), Failure> {
    // SAFETY: the caller's promise.
    let grid = unsafe { borrowed(grid, "grid") }?.checked()?;
    let voxel_type = volume::VoxelType::from(VoxelType::chosen(voxel_type)?);
    if voxels.is_null() {
        return Err(Failure::new(Status::NullArgument, "voxels is null"));
    }
    let expected = grid.voxel_count() as u128 * voxel_type.bytes() as u128;
    if bytes as u128 != expected {
        let [x, y, z] = grid.dims();
        return Err(Failure::invalid(format!("{x}x{y}x{z} voxels of {voxel_type} are {expected} bytes, found {bytes}")));
    }
    Ok((Lent { first: voxels.cast(), bytes }, voxel_type, grid))
}

fn of_storage(voxels: Storage<'static>, grid: volume::Grid) -> Result<Volume, Failure> {
    Ok(Volume(layersplat::Volume::new("voxels in memory", grid, voxels)?))
}

/// A volume of a copy of voxels: `bytes` of them in all, of a layersplat_voxel_type, x fastest, without gaps, of this machine's byte
/// order. To be freed by layersplat_volume_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_volume_copy(
    voxels: *const c_void,
    bytes: usize,
    voxel_type: i32,
    grid: *const Grid,
    volume: *mut *mut Volume,
) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let out = unsafe { Out::handle(volume, "volume") }?;
        let (lent, voxel_type, grid) = unsafe { lent(voxels, bytes, voxel_type, grid) }?;
        out.give(of_storage(Storage::from_bytes(lent.as_ref().to_vec(), voxel_type), grid)?);
        Ok(())
    })
}

/// The same without a copy: the voxels must stay there unchanged until the volume is freed. Renderers have a copy on the device, but one
/// that streams the volume (layersplat_renderer_new()) reads the voxels in every frame: they must stay until it is freed, too.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_volume_borrow(
    voxels: *const c_void,
    bytes: usize,
    voxel_type: i32,
    grid: *const Grid,
    volume: *mut *mut Volume,
) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let out = unsafe { Out::handle(volume, "volume") }?;
        let (lent, voxel_type, grid) = unsafe { lent(voxels, bytes, voxel_type, grid) }?;
        out.give(of_storage(Storage::from_bytes(lent, voxel_type), grid)?);
        Ok(())
    })
}

/// Opens builtin:NAME, builtin:NAME@SIZE (voxels along each side) or a file of a format that layersplat reads. Files that hold voxels as
/// they are get mapped: they must not be cut short before the volume and all renderers that stream it are freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_volume_open(source: *const c_char, volume: *mut *mut Volume) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let out = unsafe { Out::handle(volume, "volume") }?;
        let source = unsafe { text(source, "source") }?;
        out.give(Volume(layersplat::Volume::open(source, &OpenOptions::default())?));
        Ok(())
    })
}

/// Where the voxels lie.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_volume_grid(volume: *const Volume, grid: *mut Grid) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let volume = unsafe { borrowed(volume, "volume") }?;
        unsafe { Out::new(grid, "grid") }?.set(Grid::of(volume.0.grid()));
        Ok(())
    })
}

/// The smallest and the largest value of a valid voxel.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_volume_range(volume: *const Volume, smallest: *mut f64, largest: *mut f64) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let range = unsafe { borrowed(volume, "volume") }?.0.range();
        let (smallest, largest) = unsafe { (Out::new(smallest, "smallest")?, Out::new(largest, "largest")?) };
        smallest.set(range.0);
        largest.set(range.1);
        Ok(())
    })
}

/// Frees a volume. Renderers that were made from it go on. Null is left alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_volume_free(volume: *mut Volume) {
    // SAFETY: the caller's promise.
    unsafe { free(volume) }
}
