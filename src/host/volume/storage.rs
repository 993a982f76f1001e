//! Voxel storage: owned, borrowed, shared, mapped or computed.

use super::placed::Placed;
use super::voxels::{Endian, Voxel, VoxelType, Voxels};
use std::fmt;
use std::marker::PhantomData;
use std::sync::Arc;

/// Voxels of one type that are owned, borrowed, shared or mapped. They are stored x fastest, then y, then z, without gaps, unless strides
/// specify another layout. Clones share the voxels.
///
/// Converts from a vector, a slice, an `Arc` of either, or [`Voxels`]. [`Storage::shared`] and [`Storage::from_bytes`] accept any type
/// that dereferences to a slice, such as a mapped file or a foreign array.
///
/// ```
/// use layersplat::glam::DVec3;
/// use layersplat::volume::{Grid, Storage, Volume};
/// use std::sync::Arc;
///
/// // A box inside a larger shared array, without a copy.
/// let array: Arc<Vec<f32>> = Arc::new((0..1000).map(|n| n as f32).collect());
/// let storage = Storage::from(array).with_first(222 * 4).with_strides([4, 40, 400]);
/// let volume = Volume::new("inner", Grid::new([6; 3], DVec3::ONE)?, storage)?;
/// assert_eq!(volume.range(), (222.0, 777.0));
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone)]
pub struct Storage<'a> {
    owner: Owner<'a>,
    voxel_type: VoxelType,
    endian: Endian,
    /// Byte of the first voxel.
    first: usize,
    /// Strides in bytes along x, y, z.
    strides: Option<[isize; 3]>,
}

/// Source of the bytes.
#[derive(Clone)]
enum Owner<'a> {
    Held(Arc<dyn AsRef<[u8]> + Send + Sync + 'a>),
    Made(Arc<dyn Made>),
}

/// A generator of voxel bytes, which are computed on access: x fastest, then y, then z.
pub(super) trait Made: Send + Sync {
    /// Number of bytes.
    fn len(&self) -> usize;

    /// Computes the bytes from byte `first` on.
    fn make(&self, first: usize, bytes: &mut [u8]);
}

/// A view of values as bytes.
struct Bytes<T, O>(O, PhantomData<fn() -> T>);

impl<T: Voxel, O: AsRef<[T]>> AsRef<[u8]> for Bytes<T, O> {
    fn as_ref(&self) -> &[u8] {
        bytemuck::cast_slice(self.0.as_ref())
    }
}

impl<'a> Storage<'a> {
    /// Voxels of an owner that lends them as a slice.
    pub fn shared<T: Voxel>(owner: impl AsRef<[T]> + Send + Sync + 'a) -> Self {
        Self::from_bytes(Bytes(owner, PhantomData), T::TYPE)
    }

    /// Voxels in bytes, possibly unaligned, in native byte order.
    pub fn from_bytes(owner: impl AsRef<[u8]> + Send + Sync + 'a, voxel_type: VoxelType) -> Self {
        Self::from_shared_bytes(Arc::new(owner), voxel_type)
    }

    /// As [`from_bytes`](Self::from_bytes), of an owner whose type is not known.
    pub(super) fn from_shared_bytes(owner: Arc<dyn AsRef<[u8]> + Send + Sync + 'a>, voxel_type: VoxelType) -> Self {
        Self { owner: Owner::Held(owner), voxel_type, endian: Endian::NATIVE, first: 0, strides: None }
    }

    /// Voxels that are computed on access.
    pub(super) fn made(owner: Arc<dyn Made>, voxel_type: VoxelType) -> Self {
        Self { owner: Owner::Made(owner), voxel_type, endian: Endian::NATIVE, first: 0, strides: None }
    }

    /// Sets the byte order.
    pub fn with_endian(self, endian: Endian) -> Self {
        Self { endian, ..self }
    }

    /// Sets the byte offset of the first voxel, for example after a header.
    pub fn with_first(self, first: usize) -> Self {
        Self { first, ..self }
    }

    /// Sets the strides in bytes along x, y, z: any axis order, gaps, or negative for reversed axes.
    /// [`first`](Self::with_first) is always the offset of voxel (0, 0, 0).
    pub fn with_strides(self, strides: [isize; 3]) -> Self {
        Self { strides: Some(strides), ..self }
    }

    /// Type of the voxels.
    pub fn voxel_type(&self) -> VoxelType {
        self.voxel_type
    }

    /// All bytes, unless they are computed.
    pub(super) fn bytes(&self) -> Option<&[u8]> {
        match &self.owner {
            Owner::Held(owner) => Some((**owner).as_ref()),
            Owner::Made(_) => None,
        }
    }

    /// Copies or computes the bytes from byte `at` on.
    pub(super) fn copy(&self, at: usize, bytes: &mut [u8]) {
        match &self.owner {
            Owner::Held(owner) => bytes.copy_from_slice(&(**owner).as_ref()[at..at + bytes.len()]),
            Owner::Made(owner) => owner.make(at, bytes),
        }
    }

    fn len(&self) -> usize {
        match &self.owner {
            Owner::Held(owner) => (**owner).as_ref().len(),
            Owner::Made(owner) => owner.len(),
        }
    }

    /// Moves the first voxel by `bytes`.
    pub(super) fn moved(&self, bytes: isize) -> Self {
        Self { first: self.first.wrapping_add_signed(bytes), ..self.clone() }
    }

    /// Byte of the first voxel.
    pub(super) fn first(&self) -> usize {
        self.first
    }

    /// Number of voxels, if there are no strides.
    pub(super) fn count(&self) -> Option<u64> {
        let bytes = self.len().saturating_sub(self.first);
        self.strides.is_none().then(|| bytes as u64 / self.voxel_type.bytes() as u64)
    }

    /// The voxels of a grid of `dims`; `None` if some lie outside the bytes.
    pub(super) fn placed(self, dims: [usize; 3]) -> Option<Placed<'a>> {
        let size = self.voxel_type.bytes();
        let along = |i: usize| dims[..i].iter().try_fold(size as isize, |step, &n| step.checked_mul(isize::try_from(n).ok()?));
        let without_gaps = [along(0)?, along(1)?, along(2)?];
        let strides = self.strides.unwrap_or(without_gaps);
        let steps = || strides.into_iter().zip(dims).map(|(stride, n)| stride as i128 * (n as i128 - 1));
        let least = self.first as i128 + steps().map(|s| s.min(0)).sum::<i128>();
        let most = self.first as i128 + steps().map(|s| s.max(0)).sum::<i128>() + size as i128;
        let fits = least >= 0 && most <= self.len() as i128;
        let swapped = self.endian != Endian::NATIVE && size > 1;
        fits.then(|| Placed::new(self, dims, strides, swapped))
    }
}

impl fmt::Debug for Storage<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} bytes of {}", self.len(), self.voxel_type)
    }
}

impl<T: Voxel> From<Vec<T>> for Storage<'static> {
    fn from(values: Vec<T>) -> Self {
        Self::shared::<T>(values)
    }
}

impl<T: Voxel> From<Arc<[T]>> for Storage<'static> {
    fn from(values: Arc<[T]>) -> Self {
        Self::shared::<T>(values)
    }
}

impl<T: Voxel> From<Arc<Vec<T>>> for Storage<'static> {
    fn from(values: Arc<Vec<T>>) -> Self {
        Self::shared::<T>(Owned(values))
    }
}

/// Borrows the elements of a shared vector.
struct Owned<T>(Arc<Vec<T>>);

impl<T> AsRef<[T]> for Owned<T> {
    fn as_ref(&self) -> &[T] {
        &self.0
    }
}

impl<'a, T: Voxel> From<&'a [T]> for Storage<'a> {
    fn from(values: &'a [T]) -> Self {
        Self::shared::<T>(values)
    }
}

impl<'a, T: Voxel> From<&'a Vec<T>> for Storage<'a> {
    fn from(values: &'a Vec<T>) -> Self {
        Self::shared::<T>(values.as_slice())
    }
}

impl From<Voxels> for Storage<'static> {
    fn from(voxels: Voxels) -> Self {
        match voxels {
            Voxels::Uint8(values) => values.into(),
            Voxels::Int8(values) => values.into(),
            Voxels::Uint16(values) => values.into(),
            Voxels::Int16(values) => values.into(),
            Voxels::Float32(values) => values.into(),
        }
    }
}
