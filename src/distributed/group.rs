//! Processes that render together, and what they tell each other.

use super::DistributedError;
use crate::error::Error;
use crate::volume::Together;
use mpi::Threading;
use mpi::collective::SystemOperation;
use mpi::environment::{is_finalized, threading_support};
use mpi::topology::{Color, SimpleCommunicator};
use mpi::traits::*;
use std::fmt;
use std::ops::Deref;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Bytes that are sent at a time: MPI counts with ints.
const PIECE: usize = 1 << 30;

/// The processes of an MPI communicator, each of which has a *rank*. Cheap to clone.
///
/// Everything that takes a group is *collective*: all of its processes call the same, in the same order, and wait for each other. What
/// fails on one fails on all of them, with that rank's message ([`DistributedError::Rank`]). Groups call MPI from one thread at a time, all
/// together; who calls it beside them from other threads needs `Threading::Multiple`.
#[derive(Clone)]
pub struct Group(Arc<Inner>);

struct Inner {
    communicator: Handle,
    rank: usize,
    size: usize,
    /// Of these on this machine.
    neighbours: usize,
}

/// A communicator of this group's own.
struct Handle(SimpleCommunicator);

// SAFETY: a communicator belongs to no thread. MPI was asked whether several threads may call it, one at a time, which the lock of all
// groups sees to.
unsafe impl Send for Handle {}
unsafe impl Sync for Handle {}

/// Held by who calls MPI: one thread of the process at a time, whatever the group.
static CALLING: Mutex<()> = Mutex::new(());

/// A communicator while nobody else calls MPI.
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
        // With MPI all of its communicators have ended; who gives one back after that is stopped.
        if is_finalized() { std::mem::forget(communicator) } else { drop(communicator) }
    }
}

impl fmt::Debug for Group {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "rank {} of {}", self.rank(), self.size())
    }
}

impl Group {
    /// The processes of a communicator, which is duplicated: nothing that is sent here meets what others send there.
    ///
    /// # Errors
    /// Where MPI was not initialised for calls from more than one thread: `mpi::initialize_with_threading(Threading::Serialized)`.
    pub fn new(communicator: &impl Communicator) -> Result<Self, Error> {
        if threading_support() < Threading::Serialized {
            return Err(DistributedError::Threads { found: format!("{:?}", threading_support()) }.into());
        }
        let calling = calling();
        Ok(Self::of(communicator.duplicate(), &calling))
    }

    fn of(communicator: SimpleCommunicator, _calling: &MutexGuard<()>) -> Self {
        let (rank, size) = (communicator.rank() as usize, communicator.size() as usize);
        let neighbours = communicator.split_shared(rank as i32).size() as usize;
        Self(Arc::new(Inner { communicator: Handle(communicator), rank, size, neighbours }))
    }

    fn lock(&self) -> Locked<'_> {
        Locked { _calling: calling(), communicator: &self.0.communicator.0 }
    }

    /// This process's number, from 0 on.
    pub fn rank(&self) -> usize {
        self.0.rank
    }

    /// How many processes there are.
    pub fn size(&self) -> usize {
        self.0.size
    }

    /// Whether pictures come here: to rank 0.
    pub fn leads(&self) -> bool {
        self.rank() == 0
    }

    /// Waits for all.
    pub fn wait(&self) {
        self.lock().barrier();
    }

    /// Groups of those that name the same part, their ranks in the same order.
    pub(crate) fn split(&self, part: usize) -> Self {
        let color = Color::with_value(i32::try_from(part).expect("no more parts than ranks"));
        let group = self.lock();
        let split = group.split_by_color(color).expect("every rank has a part");
        Self::of(split, &group._calling)
    }

    /// How many of the processes are on this machine.
    pub fn on_this_machine(&self) -> usize {
        self.0.neighbours
    }

    /// What this process has come to, if all have; else the first error, on every rank the same.
    pub fn agree<T>(&self, result: Result<T, Error>) -> Result<T, Error> {
        if self.size() == 1 {
            return result;
        }
        let own = if result.is_err() { self.rank() } else { self.size() };
        let first = self.least(own as u64) as usize;
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

    /// The smallest of all numbers.
    pub(super) fn least(&self, number: u64) -> u64 {
        let mut least = number;
        self.lock().all_reduce_into(&number, &mut least, SystemOperation::min());
        least
    }

    /// The largest of all numbers.
    pub(crate) fn most(&self, number: u64) -> u64 {
        let mut most = number;
        self.lock().all_reduce_into(&number, &mut most, SystemOperation::max());
        most
    }

    /// Gives all what one rank has.
    pub fn broadcast(&self, from: usize, bytes: &mut Vec<u8>) {
        let group = self.lock();
        let process = group.process_at_rank(from as i32);
        let mut len = bytes.len() as u64;
        process.broadcast_into(&mut len);
        bytes.resize(len as usize, 0);
        bytes.chunks_mut(PIECE).for_each(|piece| process.broadcast_into(piece));
    }

    /// Numbers of all ranks, which have as many each, one after the other.
    pub(super) fn gather_counts(&self, numbers: &[u64]) -> Vec<u64> {
        let mut all = vec![0; numbers.len() * self.size()];
        self.lock().all_gather_into(numbers, &mut all[..]);
        all
    }

    /// Sends to one rank, and receives from another, at once: as many bytes as both know of.
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

    /// Receives what a rank sends.
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

    /// Ends all processes that MPI started, wherever they are: where one cannot go on, and the others wait for it.
    pub fn abort(code: u8) -> ! {
        // Without the lock, which whoever cannot go on may hold.
        SimpleCommunicator::world().abort(code.into())
    }

    /// Reduces samples to rank 0, in the order of the ranks.
    pub(super) fn reduce(&self, op: &super::over::Over, samples: &mut [[f32; 4]]) {
        op.reduce(&self.lock(), samples);
    }
}

impl Together for Group {
    fn add(&self, numbers: &mut [f64]) {
        // Summed here, in the order of the ranks: MPI may add in any order.
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
        let group = self.lock();
        let mut counts = vec![0i32; self.size()];
        group.all_gather_into(&(numbers.len() as i32), &mut counts[..]);
        let starts: Vec<i32> = counts.iter().scan(0, |at, &count| Some(std::mem::replace(at, *at + count))).collect();
        let mut all = vec![0.0; counts.iter().map(|&count| count as usize).sum()];
        let mut parts = mpi::datatype::PartitionMut::new(&mut all[..], counts, starts);
        group.all_gather_varcount_into(numbers, &mut parts);
        drop(parts);
        all
    }
}
