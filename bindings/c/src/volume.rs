//! Volumes in host memory and in files.

use crate::boundary::{Failure, Out, borrowed, free, guard, text, values};
use crate::{Grid, Status, VoxelType};
use layersplat::OpenOptions;
use layersplat::volume::{self, Storage, VoxelBox};
use std::ffi::{c_char, c_void};

/// A volume in host memory or in a file. It is immutable, and several threads may use it at the same time.
pub struct Volume(pub(crate) layersplat::Volume<'static>);

/// Borrowed voxels of the caller.
#[derive(Clone, Copy)]
pub(crate) struct BorrowedBytes {
    first: *const u8,
    bytes: usize,
}

// SAFETY: the lender guarantees that the voxels are neither changed nor freed.
unsafe impl Send for BorrowedBytes {}
// SAFETY: as above.
unsafe impl Sync for BorrowedBytes {}

impl AsRef<[u8]> for BorrowedBytes {
    fn as_ref(&self) -> &[u8] {
        // SAFETY: the lender guarantees that there are `bytes` bytes.
        unsafe { std::slice::from_raw_parts(self.first, self.bytes) }
    }
}

/// Checks the arguments that describe the caller's voxels, each of which has `components` values.
///
/// # Errors
/// Null pointers, an invalid type or grid, and a size that does not match them.
pub(crate) unsafe fn checked(
    voxels: *const c_void,
    bytes: usize,
    voxel_type: i32,
    components: usize,
    grid: *const Grid,
) -> Result<(BorrowedBytes, volume::VoxelType, volume::Grid), Failure> {
    // SAFETY: upheld by the caller.
    let grid = unsafe { borrowed(grid, "grid") }?.checked()?;
    let voxel_type = volume::VoxelType::from(VoxelType::from_number(voxel_type)?);
    if voxels.is_null() {
        return Err(Failure::new(Status::NullArgument, "voxels is null"));
    }
    let expected = grid.voxel_count() as u128 * (components * voxel_type.bytes()) as u128;
    if bytes as u128 != expected {
        let [x, y, z] = grid.dims();
        return Err(Failure::invalid(format!(
            "{x}x{y}x{z} voxels of {components} {voxel_type} are {expected} bytes, found {bytes}"
        )));
    }
    Ok((BorrowedBytes { first: voxels.cast(), bytes }, voxel_type, grid))
}

fn from_storage(voxels: Storage<'static>, grid: volume::Grid) -> Result<Volume, Failure> {
    Ok(Volume(layersplat::Volume::new("voxels in memory", grid, voxels)?))
}

/// Creates a volume from a copy of voxels. `voxel_type` is a layersplat_voxel_type and `bytes` is the total size. Voxels are
/// contiguous, x fastest, in native byte order. To be freed by layersplat_volume_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_volume_copy(
    voxels: *const c_void,
    bytes: usize,
    voxel_type: i32,
    grid: *const Grid,
    volume: *mut *mut Volume,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(volume, "volume") }?;
        let (borrowed, voxel_type, grid) = unsafe { checked(voxels, bytes, voxel_type, 1, grid) }?;
        out.set_handle(from_storage(Storage::from_bytes(borrowed.as_ref().to_vec(), voxel_type), grid)?);
        Ok(())
    })
}

/// Creates a volume like layersplat_volume_copy(), but without a copy. The voxels must stay valid and unchanged until the volume is
/// freed. A renderer normally keeps a copy on the device. A renderer that streams the volume (layersplat_renderer_new()) reads the
/// voxels in every frame: they must also stay until that renderer is freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_volume_borrow(
    voxels: *const c_void,
    bytes: usize,
    voxel_type: i32,
    grid: *const Grid,
    volume: *mut *mut Volume,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(volume, "volume") }?;
        let (borrowed, voxel_type, grid) = unsafe { checked(voxels, bytes, voxel_type, 1, grid) }?;
        out.set_handle(from_storage(Storage::from_bytes(borrowed, voxel_type), grid)?);
        Ok(())
    })
}

/// Opens builtin:NAME, builtin:NAME@SIZE (voxels along each side) or a volume file. Uncompressed files are memory-mapped: they must
/// not be truncated before the volume and all renderers that stream it are freed. To be freed by layersplat_volume_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_volume_open(source: *const c_char, volume: *mut *mut Volume) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(volume, "volume") }?;
        let source = unsafe { text(source, "source") }?;
        out.set_handle(Volume(layersplat::Volume::open(source, &OpenOptions::default())?));
        Ok(())
    })
}

/// Opens a Zarr like layersplat_volume_open(), or a part of it as if it were all: `region` is x0, x1, y0, y1, z0, z1 in voxels of level 0,
/// without the last ones, or null for all. Of URLs, `download` is the most bytes of voxels, 0 for 2 GB, and chunks that the server refuses are
/// an error unless `fills_refused` is 1: then they count as not stored. To be freed by layersplat_volume_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_volume_open_part(
    source: *const c_char,
    region: *const usize,
    download: u64,
    fills_refused: i32,
    volume: *mut *mut Volume,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(volume, "volume") }?;
        let source = unsafe { text(source, "source") }?;
        let region = match region.is_null() {
            true => None,
            false => {
                let sides = unsafe { values(region, 6, "region") }?;
                let first = [0, 2, 4].map(|i| sides[i]);
                Some(VoxelBox { first, dims: [0, 2, 4].map(|i| sides[i + 1].saturating_sub(sides[i])) })
            }
        };
        let download = Some(download).filter(|&most| most > 0);
        let options = OpenOptions { region, download, fills_refused: fills_refused == 1, ..OpenOptions::default() };
        out.set_handle(Volume(layersplat::Volume::open(source, &options)?));
        Ok(())
    })
}

/// The grid of a volume.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_volume_grid(volume: *const Volume, grid: *mut Grid) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let volume = unsafe { borrowed(volume, "volume") }?;
        unsafe { Out::new(grid, "grid") }?.set(Grid::from_library(volume.0.grid()));
        Ok(())
    })
}

/// The smallest and the largest value of all valid voxels.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_volume_range(volume: *const Volume, smallest: *mut f64, largest: *mut f64) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let range = unsafe { borrowed(volume, "volume") }?.0.range();
        let (smallest, largest) = unsafe { (Out::new(smallest, "smallest")?, Out::new(largest, "largest")?) };
        smallest.set(range.0);
        largest.set(range.1);
        Ok(())
    })
}

/// Frees a volume. Renderers that were made from it stay usable. Null is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_volume_free(volume: *mut Volume) {
    // SAFETY: upheld by the caller.
    unsafe { free(volume) }
}
