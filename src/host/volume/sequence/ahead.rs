//! Reading ahead on another thread.

use crate::progress;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::JoinHandle;

/// Items that another thread reads in order. While the caller uses one item, the next is read, and no further one.
pub(super) struct Ahead<T> {
    /// `None` once the iterator is dropped.
    receiver: Option<Receiver<T>>,
    thread: Option<JoinHandle<()>>,
}

impl<T: Send + 'static> Ahead<T> {
    /// Starts to read the first of `keys`.
    pub fn new<K: Send + 'static>(keys: Vec<K>, mut read: impl FnMut(K) -> T + Send + 'static) -> Self {
        // Without a queue, the thread holds one item until the caller takes it.
        let (sender, receiver) = sync_channel(0);
        let observer = progress::observer();
        let work = move || {
            let all = || {
                for key in keys {
                    if sender.send(read(key)).is_err() {
                        break;
                    }
                }
            };
            match observer {
                Some(observer) => progress::observed(observer, all),
                None => all(),
            }
        };
        Self { receiver: Some(receiver), thread: Some(std::thread::spawn(work)) }
    }
}

impl<T> Iterator for Ahead<T> {
    type Item = T;

    fn next(&mut self) -> Option<T> {
        self.receiver.as_ref()?.recv().ok()
    }
}

/// Waits for the item that is being read.
impl<T> Drop for Ahead<T> {
    fn drop(&mut self) {
        self.receiver = None;
        if let Some(Err(panic)) = self.thread.take().map(JoinHandle::join)
            && !std::thread::panicking()
        {
            std::panic::resume_unwind(panic);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
    use std::sync::mpsc::channel;

    /// An item counts itself while it exists.
    struct Item(usize, Arc<AtomicUsize>);

    impl Item {
        fn new(key: usize, alive: &Arc<AtomicUsize>) -> Self {
            alive.fetch_add(1, SeqCst);
            Self(key, alive.clone())
        }
    }

    impl Drop for Item {
        fn drop(&mut self) {
            self.1.fetch_sub(1, SeqCst);
        }
    }

    /// Each item is read while the caller has the one before it: `use_item` returns only after the reader has begun.
    #[test]
    fn the_next_item_is_read_while_one_is_used() {
        const ITEMS: usize = 6;
        let (begun, begins) = channel();
        let (alive, most) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicUsize::new(0)));
        let (counted, largest, caller) = (alive.clone(), most.clone(), std::thread::current().id());
        let mut ahead = Ahead::new((0..ITEMS).collect(), move |key| {
            assert_ne!(std::thread::current().id(), caller);
            let item = Item::new(key, &counted);
            largest.fetch_max(counted.load(SeqCst), SeqCst);
            begun.send(key).unwrap();
            item
        });
        assert_eq!(begins.recv().unwrap(), 0);
        for key in 0..ITEMS {
            let item = ahead.next().unwrap();
            assert_eq!(item.0, key);
            if key + 1 < ITEMS {
                // A reader that waits for the caller to finish would never send this.
                assert_eq!(begins.recv().unwrap(), key + 1);
            }
            assert!(begins.try_recv().is_err(), "no item after the next is read");
        }
        assert!(ahead.next().is_none());
        assert_eq!((most.load(SeqCst), alive.load(SeqCst)), (2, 0));
    }

    #[test]
    fn a_dropped_reader_ends() {
        let reads = Arc::new(AtomicUsize::new(0));
        let counted = reads.clone();
        let mut ahead = Ahead::new((0..1000).collect::<Vec<_>>(), move |key| {
            counted.fetch_add(1, SeqCst);
            key
        });
        assert_eq!(ahead.next(), Some(0));
        drop(ahead);
        let read = reads.load(SeqCst);
        assert!((1..=3).contains(&read), "{read}");
    }
}
