//! Process groups and their communication.

use super::DistributedError;
use crate::error::Error;
use crate::volume::Collective;
use mpi::Threading;
use mpi::collective::SystemOperation;
use mpi::environment::{is_finalized, threading_support};
use mpi::topology::{Color, SimpleCommunicator};
use mpi::traits::*;
use std::fmt;
use std::ops::Deref;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Maximum bytes per MPI call, whose counts are ints.
const PIECE: usize = 1 << 30;

/// The processes of an MPI communicator, each with a *rank*. Cheap to clone.
///
/// Every call with a group is *collective*: all of its processes make the same calls in the same order, and wait for each other.
/// An error on one process is returned on all of them, with the message of that rank ([`DistributedError::Rank`]). All groups
/// together call MPI from one thread at a time. Programs that also call MPI from other threads need `Threading::Multiple`.
#[derive(Clone)]
pub struct Group(Arc<Inner>);

struct Inner {
    communicator: Handle,
    rank: usize,
    size: usize,
    /// Processes of the group on this machine.
    local_size: usize,
}

/// A communicator owned by the group.
struct Handle(SimpleCommunicator);

// SAFETY: communicators are not bound to a thread. `Group::new` checks that MPI allows calls from several threads, one at a time,
// and `CALLING` serialises them.
unsafe impl Send for Handle {}
unsafe impl Sync for Handle {}

/// Serialises MPI calls of all groups in the process.
static CALLING: Mutex<()> = Mutex::new(());

/// A communicator with exclusive access to MPI.
struct Locked<'a> {
    communicator: &'a SimpleCommunicator,
    _calling: MutexGuard<'static, ()>,
}

impl Deref for Locked<'_> {
    type Target = SimpleCommunicator;

    fn deref(&self) -> &SimpleCommunicator {
        self.communicator
    }
}

fn calling() -> MutexGuard<'static, ()> {
    CALLING.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Drop for Handle {
    fn drop(&mut self) {
        let _calling = calling();
        let communicator = std::mem::replace(&mut self.0, SimpleCommunicator::self_comm());
        // Freeing a communicator after MPI_Finalize would abort the process.
        if is_finalized() { std::mem::forget(communicator) } else { drop(communicator) }
    }
}

impl fmt::Debug for Group {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "rank {} of {}", self.rank(), self.size())
    }
}

impl Group {
    /// The processes of a communicator. It is duplicated, so that messages cannot interfere with those of the caller.
    ///
    /// # Errors
    /// MPI was initialised without support for several threads; use `mpi::initialize_with_threading(Threading::Serialized)`.
    pub fn new(communicator: &impl Communicator) -> Result<Self, Error> {
        if threading_support() < Threading::Serialized {
            return Err(DistributedError::Threads { found: format!("{:?}", threading_support()) }.into());
        }
        let calling = calling();
        Ok(Self::from_communicator(communicator.duplicate(), &calling))
    }

    fn from_communicator(communicator: SimpleCommunicator, _calling: &MutexGuard<()>) -> Self {
        let (rank, size) = (communicator.rank() as usize, communicator.size() as usize);
        let local_size = communicator.split_shared(rank as i32).size() as usize;
        Self(Arc::new(Inner { communicator: Handle(communicator), rank, size, local_size }))
    }

    fn lock(&self) -> Locked<'_> {
        Locked { _calling: calling(), communicator: &self.0.communicator.0 }
    }

    /// Rank of this process, from 0.
    pub fn rank(&self) -> usize {
        self.0.rank
    }

    /// Number of processes.
    pub fn size(&self) -> usize {
        self.0.size
    }

    /// Whether this is rank 0, which receives the pictures.
    pub fn leads(&self) -> bool {
        self.rank() == 0
    }

    /// Waits until all processes have called this.
    pub fn wait(&self) {
        self.lock().barrier();
    }

    /// Splits the group by `part`, keeping the order of the ranks. Returns the group of this process.
    pub(crate) fn split(&self, part: usize) -> Self {
        let color = Color::with_value(i32::try_from(part).expect("no more parts than ranks"));
        let group = self.lock();
        let split = group.split_by_color(color).expect("every rank has a part");
        Self::from_communicator(split, &group._calling)
    }

    /// Number of processes of the group on this machine.
    pub fn on_this_machine(&self) -> usize {
        self.0.local_size
    }

    /// Returns the result of this process if all processes succeeded, otherwise the error of the lowest failed rank on all
    /// processes.
    ///
    /// # Errors
    /// [`DistributedError::Rank`]; in a group of one process, its own error.
    pub fn agree<T>(&self, result: Result<T, Error>) -> Result<T, Error> {
        if self.size() == 1 {
            return result;
        }
        let own = if result.is_err() { self.rank() } else { self.size() };
        let first = self.min(own as u64) as usize;
        if first == self.size() {
            return result;
        }
        let mut message = match &result {
            Err(error) if own == first => error.to_string().into_bytes(),
            _ => Vec::new(),
        };
        self.broadcast(first, &mut message);
        let message = String::from_utf8_lossy(&message).into_owned();
        let own = result.err().filter(|_| own == first).map(Box::new);
        Err(DistributedError::Rank { rank: first, message, own }.into())
    }

    /// The minimum over all processes.
    pub(super) fn min(&self, number: u64) -> u64 {
        let mut min = number;
        self.lock().all_reduce_into(&number, &mut min, SystemOperation::min());
        min
    }

    /// The maximum over all processes.
    pub(crate) fn max(&self, number: u64) -> u64 {
        let mut max = number;
        self.lock().all_reduce_into(&number, &mut max, SystemOperation::max());
        max
    }

    /// Copies the bytes of one rank to all ranks.
    pub fn broadcast(&self, from: usize, bytes: &mut Vec<u8>) {
        let group = self.lock();
        let process = group.process_at_rank(from as i32);
        let mut len = bytes.len() as u64;
        process.broadcast_into(&mut len);
        bytes.resize(len as usize, 0);
        bytes.chunks_mut(PIECE).for_each(|piece| process.broadcast_into(piece));
    }

    /// Concatenation of the numbers of all ranks, which must have equal counts.
    pub(super) fn gather_counts(&self, numbers: &[u64]) -> Vec<u64> {
        let mut all = vec![0; numbers.len() * self.size()];
        self.lock().all_gather_into(numbers, &mut all[..]);
        all
    }

    /// The elements of each rank, of which each may have another number.
    pub(super) fn gather_parts<T: Equivalence + Clone + Default>(&self, own: &[T]) -> Vec<Vec<T>> {
        let group = self.lock();
        let mut counts = vec![0i32; self.size()];
        group.all_gather_into(&(own.len() as i32), &mut counts[..]);
        let starts: Vec<i32> = counts.iter().scan(0, |at, &count| Some(std::mem::replace(at, *at + count))).collect();
        let mut all = vec![T::default(); counts.iter().map(|&count| count as usize).sum()];
        group.all_gather_varcount_into(own, &mut mpi::datatype::PartitionMut::new(&mut all[..], &counts[..], &starts[..]));
        counts.iter().zip(starts).map(|(&count, start)| all[start as usize..][..count as usize].to_vec()).collect()
    }

    /// Sends to one rank and receives from another concurrently. Both sides must know the sizes.
    pub(super) fn swap(&self, to: usize, sent: &[u8], from: usize, received: &mut [u8]) {
        let group = self.lock();
        let [to, from] = [to, from].map(|rank| group.process_at_rank(rank as i32));
        mpi::request::scope(|scope| {
            let sends: Vec<_> = sent.chunks(PIECE).map(|piece| to.immediate_send(scope, piece)).collect();
            for piece in received.chunks_mut(PIECE) {
                from.receive_into(piece);
            }
            for send in sends {
                send.wait();
            }
        });
    }

    /// Sends bytes to a rank that [receives](Self::receive) them.
    pub(crate) fn send(&self, to: usize, bytes: &[u8]) {
        let group = self.lock();
        let process = group.process_at_rank(to as i32);
        process.send(&(bytes.len() as u64));
        bytes.chunks(PIECE).for_each(|piece| process.send(piece));
    }

    /// Receives the bytes that a rank [sends](Self::send).
    pub(crate) fn receive(&self, from: usize) -> Vec<u8> {
        let group = self.lock();
        let process = group.process_at_rank(from as i32);
        let (len, _) = process.receive::<u64>();
        let mut bytes = vec![0; len as usize];
        for piece in bytes.chunks_mut(PIECE) {
            process.receive_into(piece);
        }
        bytes
    }

    /// Ends all MPI processes on all machines. For a process that cannot continue while the others wait for it.
    pub fn abort(code: u8) -> ! {
        // Does not lock: the failing thread may hold the lock.
        SimpleCommunicator::world().abort(code.into())
    }

    /// Reduces samples to rank 0, in the order of the ranks.
    pub(super) fn reduce(&self, op: &super::over::Over, samples: &mut [[f32; 4]]) {
        op.reduce(&self.lock(), samples);
    }
}

impl Collective for Group {
    fn add(&self, numbers: &mut [f64]) {
        // Summed here in rank order, since MPI may add in any order.
        let all = self.gather(numbers);
        let count = numbers.len();
        for (n, sum) in numbers.iter_mut().enumerate() {
            *sum = all.iter().skip(n).step_by(count).sum();
        }
    }

    fn count(&self, numbers: &mut [u64]) {
        let own = numbers.to_vec();
        self.lock().all_reduce_into(&own[..], numbers, SystemOperation::sum());
    }

    fn gather(&self, numbers: &[f64]) -> Vec<f64> {
        self.gather_parts(numbers).concat()
    }
}
