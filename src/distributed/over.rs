//! The MPI reduction that composites the samples of all ranks.

use crate::renderer::combined;
use crate::settings::Blend;
use mpi::collective::UnsafeUserOperation;
use mpi::datatype::{MutView, UserDatatype, View};
use mpi::ffi::MPI_Datatype;
use mpi::topology::SimpleCommunicator;
use mpi::traits::*;
use std::ffi::{c_int, c_void};

/// A reduction of lattice samples. It is declared associative but not commutative, so that MPI keeps the order of the ranks.
pub(super) struct Over {
    operation: UnsafeUserOperation,
    sample: UserDatatype,
}

/// Signature of `MPI_User_function`.
type Function = unsafe extern "C" fn(*mut c_void, *mut c_void, *mut c_int, *mut MPI_Datatype);

impl Over {
    /// For a blend mode, with the lower ranks in front or behind.
    pub fn new(blend: Blend, lower_in_front: bool) -> Self {
        let function: Function = match (blend, lower_in_front) {
            (Blend::Composite | Blend::Iso(_), true) => front_over_back,
            (Blend::Composite | Blend::Iso(_), false) => back_under_front,
            (Blend::Maximum, _) => largest,
            (Blend::Minimum, _) => smallest,
            (Blend::Average, _) => sum,
        };
        // SAFETY: the functions take the samples that `reduce` passes, and do not panic.
        let operation = unsafe { UnsafeUserOperation::associative(function) };
        Self { operation, sample: UserDatatype::contiguous(4, &f32::equivalent_datatype()) }
    }

    /// Combines the samples of all ranks, which must have equal counts. Rank 0 receives the result in `samples`.
    pub fn reduce(&self, group: &SimpleCommunicator, samples: &mut [[f32; 4]]) {
        let root = group.process_at_rank(0);
        let count = c_int::try_from(samples.len()).expect("a lattice has fewer samples than an int counts");
        if group.rank() == 0 {
            let sent = samples.to_vec();
            // SAFETY: the datatype is four floats, as a sample is, and `count` is the number of samples.
            let sent = unsafe { View::with_count_and_datatype(sent.as_flattened(), count, &self.sample) };
            let received = samples.as_flattened_mut();
            // SAFETY: as above.
            let mut received = unsafe { MutView::with_count_and_datatype(received, count, &self.sample) };
            root.reduce_into_root(&sent, &mut received, &self.operation);
        } else {
            // SAFETY: as above.
            let sent = unsafe { View::with_count_and_datatype(samples.as_flattened(), count, &self.sample) };
            root.reduce_into(&sent, &self.operation);
        }
    }
}

/// Combines samples of lower ranks with `others`, in place.
///
/// # Safety
/// Both pointers must refer to `*count` samples.
unsafe fn combine(lower: *mut c_void, others: *mut c_void, count: *mut c_int, combined: impl Fn([f32; 4], [f32; 4]) -> [f32; 4]) {
    // SAFETY: guaranteed by the caller; MPI's buffers are aligned for floats and do not overlap.
    let (lower, others) = unsafe {
        let count = *count as usize;
        (std::slice::from_raw_parts(lower.cast::<[f32; 4]>(), count), std::slice::from_raw_parts_mut(others.cast(), count))
    };
    others.iter_mut().zip(lower).for_each(|(other, &lower)| *other = combined(lower, *other));
}

unsafe extern "C" fn front_over_back(lower: *mut c_void, others: *mut c_void, count: *mut c_int, _: *mut MPI_Datatype) {
    unsafe { combine(lower, others, count, |lower, other| combined(Blend::Composite, lower, other)) }
}

unsafe extern "C" fn back_under_front(lower: *mut c_void, others: *mut c_void, count: *mut c_int, _: *mut MPI_Datatype) {
    unsafe { combine(lower, others, count, |lower, other| combined(Blend::Composite, other, lower)) }
}

unsafe extern "C" fn largest(lower: *mut c_void, others: *mut c_void, count: *mut c_int, _: *mut MPI_Datatype) {
    unsafe { combine(lower, others, count, |lower, other| combined(Blend::Maximum, lower, other)) }
}

unsafe extern "C" fn smallest(lower: *mut c_void, others: *mut c_void, count: *mut c_int, _: *mut MPI_Datatype) {
    unsafe { combine(lower, others, count, |lower, other| combined(Blend::Minimum, lower, other)) }
}

unsafe extern "C" fn sum(lower: *mut c_void, others: *mut c_void, count: *mut c_int, _: *mut MPI_Datatype) {
    unsafe { combine(lower, others, count, |lower, other| combined(Blend::Average, lower, other)) }
}
