//! Arrays: memory of the application or of the device.

use crate::handle::Handle;
use crate::status::Problem;
use crate::types::{self, DataType};
use anari_sys::*;
use std::ffi::c_void;
use std::sync::Arc;

/// The application's function that frees memory that it gave away.
pub type Deleter = unsafe extern "C" fn(user: *const c_void, memory: *const c_void);

/// An array of one to three dimensions, x fastest, without gaps.
pub struct Array {
    pub element: DataType,
    /// Number of elements per dimension; 1 beyond those that it has.
    pub dims: [usize; 3],
    pub memory: Arc<Memory>,
    /// When the elements last changed.
    pub version: u64,
    /// How often it is mapped now.
    pub maps: u32,
    /// The objects that the elements are, if they are. Each counts as a use.
    pub elements: Vec<Handle>,
}

/// Bytes of an array.
pub struct Memory {
    first: *mut u8,
    bytes: usize,
    owner: Owner,
}

enum Owner {
    /// The application keeps the memory until it releases the array.
    Application,
    /// The application gave the memory away.
    Given { deleter: Deleter, user: usize },
    /// Words that are aligned for every type of elements.
    Device { _words: Vec<u64> },
}

// SAFETY: the application neither changes nor frees the memory while the device reads it: it maps arrays to change them, for which the
// device waits until no frame is being drawn.
unsafe impl Send for Memory {}
// SAFETY: as above.
unsafe impl Sync for Memory {}

impl AsRef<[u8]> for Memory {
    fn as_ref(&self) -> &[u8] {
        // SAFETY: there are this many bytes, and they do not change while they are read (as above).
        unsafe { std::slice::from_raw_parts(self.first, self.bytes) }
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        if let Owner::Given { deleter, user } = self.owner {
            // SAFETY: the application gave the function for this memory, and it is called once.
            unsafe { deleter(user as *const c_void, self.first.cast()) }
        }
    }
}

impl Memory {
    /// Zeroed memory of the device.
    fn zeroed(bytes: usize) -> Result<Self, Problem> {
        let count = bytes.div_ceil(size_of::<u64>()).max(1);
        let mut words = Vec::new();
        words.try_reserve_exact(count).map_err(|_| Problem::memory(format!("no memory for an array of {bytes} bytes")))?;
        words.resize(count, 0u64);
        Ok(Self { first: words.as_mut_ptr().cast(), bytes, owner: Owner::Device { _words: words } })
    }

    /// Whether the application owns it, and frees it after releasing the array.
    pub fn is_of_the_application(&self) -> bool {
        matches!(self.owner, Owner::Application)
    }

    /// A copy that the device owns.
    pub fn copied(&self) -> Result<Self, Problem> {
        let copy = Self::zeroed(self.bytes)?;
        // SAFETY: both have this many bytes, and do not overlap.
        unsafe { self.first.copy_to_nonoverlapping(copy.first, self.bytes) };
        Ok(copy)
    }

    /// The first byte, for the application to write.
    pub fn first(&self) -> *mut u8 {
        self.first
    }
}

/// Memory that the application brings, if any.
pub struct ApplicationMemory {
    pub memory: *const c_void,
    pub deleter: Option<Deleter>,
    pub user: *const c_void,
}

impl Array {
    /// An array in the memory of the application, or zeroed in that of the device.
    ///
    /// # Errors
    /// Types of elements that arrays cannot have, no elements, and insufficient memory.
    ///
    /// # Safety
    /// Memory of the application has the elements.
    pub unsafe fn new(given: ApplicationMemory, element: DataType, dims: [u64; 3]) -> Result<Self, Problem> {
        let size = size_of_element(element).inspect_err(|_| given.give_back())?;
        let lengths = dims.map(|n| usize::try_from(n).unwrap_or(0));
        let bytes =
            lengths.iter().try_fold(size, |bytes, &n| bytes.checked_mul(n)).filter(|&b| b > 0 && b <= isize::MAX as usize);
        let Some(bytes) = bytes else {
            given.give_back();
            let [x, y, z] = dims;
            return Err(Problem::argument(format!("an array of {x} x {y} x {z} elements cannot be made")));
        };
        let memory = if given.memory.is_null() {
            Memory::zeroed(bytes)?
        } else {
            let user = given.user as usize;
            let owner = given.deleter.map_or(Owner::Application, |deleter| Owner::Given { deleter, user });
            Memory { first: given.memory.cast_mut().cast(), bytes, owner }
        };
        Ok(Self { element, dims: lengths, memory: Arc::new(memory), version: 0, maps: 0, elements: Vec::new() })
    }

    /// The handles in the memory of an array of objects.
    pub fn handles(&self) -> Vec<Handle> {
        if !types::is_object(self.element) {
            return Vec::new();
        }
        let words = (*self.memory).as_ref().as_chunks::<{ size_of::<usize>() }>().0;
        words.iter().map(|&word| Handle(usize::from_ne_bytes(word))).collect()
    }

    /// Bytes from one element to the next.
    pub fn stride(&self) -> u64 {
        types::bytes(self.element).unwrap_or(0) as u64
    }
}

impl ApplicationMemory {
    /// Frees memory that was given away for an array that could not be made.
    fn give_back(&self) {
        if let (Some(deleter), false) = (self.deleter, self.memory.is_null()) {
            // SAFETY: the application gave the function for this memory, and it is called once.
            unsafe { deleter(self.user, self.memory) }
        }
    }
}

/// Types of objects that arrays can have: none of them can refer to an array that contains it. An array of OBJECT becomes one of the type of
/// its first element.
pub const OBJECTS: [DataType; 9] = [
    ANARI_SURFACE,
    ANARI_VOLUME,
    ANARI_LIGHT,
    ANARI_INSTANCE,
    ANARI_GROUP,
    ANARI_GEOMETRY,
    ANARI_MATERIAL,
    ANARI_SAMPLER,
    ANARI_SPATIAL_FIELD,
];

/// Bytes of an element.
///
/// # Errors
/// Types that arrays cannot have.
fn size_of_element(element: DataType) -> Result<usize, Problem> {
    let is_possible = element >= ANARI_INT8 || element == ANARI_OBJECT || OBJECTS.contains(&element);
    let size = types::bytes(element).filter(|_| is_possible);
    size.ok_or_else(|| Problem::argument(format!("arrays cannot have elements of {}", types::name(element))))
}
