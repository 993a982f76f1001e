//! Values on the device that are kept between frames: each has a key, the versions of its inputs, and the commands that wrote it.

use crate::device::{Device, Produced, Usability};
use crate::error::Error;
use std::any::Any;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// A state of something that values are made from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Version {
    id: u64,
    changes: u64,
}

/// Ids of versions.
static NEXT_ID: AtomicU64 = AtomicU64::new(1);

impl Version {
    /// A version that nothing had before.
    pub fn new() -> Self {
        Self { id: NEXT_ID.fetch_add(1, Ordering::Relaxed), changes: 0 }
    }

    /// The same after so many changes. All owners that counted as many changes mean the same state.
    pub fn after(self, changes: u64) -> Self {
        Self { changes, ..self }
    }
}

/// The versions of what a value is made from; `None` where it does not depend on that.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Inputs {
    pub field: Option<Version>,
    pub classification: Option<Version>,
}

/// A value that a store can keep.
pub(super) trait Stored: Send + Sync + 'static {
    /// Bytes on the device.
    fn bytes(&self) -> usize;
}

/// What a value is: everything but the versions of its inputs.
pub(super) trait Key: PartialEq + Send + 'static {
    /// The type of the value.
    type Value: Stored;
}

/// Keeps the values that were used last, within a budget of bytes.
pub(super) struct Store {
    /// The last one was used last.
    entries: Vec<Entry>,
    budget: usize,
    /// Values made so far.
    #[cfg(test)]
    pub made: usize,
}

struct Entry {
    key: Box<dyn Any + Send>,
    inputs: Inputs,
    value: Arc<dyn Any + Send + Sync>,
    bytes: usize,
    produced: Produced,
    /// Whether another sequence of commands uses the value, too: it must not be written again.
    shared: bool,
}

impl Entry {
    fn has<K: Key>(&self, key: &K) -> bool {
        self.key.downcast_ref() == Some(key)
    }
}

impl Store {
    /// `budget` in bytes. The newest value stays even if it is larger.
    pub fn new(budget: usize) -> Self {
        Self {
            entries: Vec::new(),
            budget,
            #[cfg(test)]
            made: 0,
        }
    }

    /// The value of a key for these inputs, if the frame of this device handle may use it.
    pub fn get<K: Key>(&mut self, device: &Device, key: &K, inputs: Inputs) -> Result<Option<Arc<K::Value>>, Error> {
        let mut n = 0;
        while n < self.entries.len() {
            let entry = &mut self.entries[n];
            if entry.inputs != inputs || !entry.has(key) {
                n += 1;
                continue;
            }
            match device.usability(&mut entry.produced)? {
                Usability::Failed => drop(self.entries.remove(n)),
                Usability::Uncertain => n += 1,
                Usability::Usable => {
                    let mut entry = self.entries.remove(n);
                    entry.shared |= !entry.produced.is_from(device);
                    let value = entry.value.clone();
                    self.entries.push(entry);
                    return Ok(value.downcast().ok());
                }
            }
        }
        Ok(None)
    }

    /// The value of a key for older inputs, of as many bytes, to be written again; it is no longer kept.
    pub fn reuse<K: Key>(&mut self, device: &Device, key: &K, inputs: Inputs, bytes: usize) -> Option<Arc<K::Value>> {
        let found = self.entries.iter().position(|entry| entry.inputs != inputs && entry.has(key))?;
        let entry = self.entries.remove(found);
        let fits = entry.bytes == bytes && !entry.shared && entry.produced.is_from(device);
        entry.value.downcast().ok().filter(|_| fits)
    }

    /// Keeps a value, in place of those of the same key and older inputs. Of the same inputs there may be another one, which depends on
    /// events that have not completed.
    pub fn keep<K: Key>(&mut self, key: K, inputs: Inputs, produced: Produced, value: impl Into<Arc<K::Value>>) -> Arc<K::Value> {
        #[cfg(test)]
        {
            self.made += 1;
        }
        let value = value.into();
        let bytes = value.bytes();
        self.entries.retain(|entry| entry.inputs == inputs || !entry.has(&key));
        self.entries.push(Entry { key: Box::new(key), inputs, value: value.clone(), bytes, produced, shared: false });
        let mut sum = 0;
        let kept = self.entries.iter().rev().take_while(|entry| {
            sum += entry.bytes;
            sum <= self.budget
        });
        let dropped = self.entries.len() - kept.count().max(1);
        self.entries.drain(..dropped);
        value
    }

    /// Drops all values, to make room for others.
    pub fn clear(&mut self) {
        self.entries.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::DeviceChoice;

    #[derive(PartialEq)]
    struct Number(u32);

    #[derive(PartialEq)]
    struct Name(u32);

    impl Stored for Vec<u8> {
        fn bytes(&self) -> usize {
            self.len()
        }
    }

    impl Key for Number {
        type Value = Vec<u8>;
    }

    impl Key for Name {
        type Value = Vec<u8>;
    }

    fn device() -> Device {
        Device::open(&DeviceChoice::Default)
            .expect("the tests need an OpenCL device: scripts/test installs PoCL")
            .with_own_sequence()
    }

    fn of_field(version: Version) -> Inputs {
        Inputs { field: Some(version), ..Inputs::default() }
    }

    #[test]
    fn the_least_recently_used_values_make_room() {
        let (device, inputs, mut store) = (device(), Inputs::default(), Store::new(25));
        let keep =
            |store: &mut Store, n, len: usize| drop(store.keep(Number(n), inputs, Produced::by_host(), vec![n as u8; len]));
        let get = |store: &mut Store, n| store.get(&device, &Number(n), inputs).unwrap();
        keep(&mut store, 1, 10);
        store.keep(Name(1), inputs, Produced::by_host(), vec![9; 10]);
        assert_eq!(get(&mut store, 1).unwrap()[0], 1, "keys of another type are other keys");
        keep(&mut store, 2, 10);
        assert!(store.get(&device, &Name(1), inputs).unwrap().is_none(), "it was used before the others");
        assert!(get(&mut store, 1).is_some() && get(&mut store, 2).is_some());
        keep(&mut store, 3, 100);
        assert!(get(&mut store, 2).is_none() && get(&mut store, 3).is_some(), "the newest stays");
        store.clear();
        assert!(get(&mut store, 3).is_none());
    }

    #[test]
    fn values_of_older_inputs_are_written_again() {
        let (device, first) = (device(), Version::new());
        let [old, new] = [first, first.after(1)].map(of_field);
        assert_ne!(Version::new(), first);
        let mut store = Store::new(100);
        let value = store.keep(Number(1), old, device.produced().unwrap(), vec![1; 10]);
        assert!(store.reuse(&device, &Number(1), old, 10).is_none(), "its inputs are what they were");
        assert!(store.get(&device, &Number(1), new).unwrap().is_none());
        let reused = store.reuse(&device, &Number(1), new, 10).unwrap();
        assert!(Arc::ptr_eq(&value, &reused) && store.get(&device, &Number(1), old).unwrap().is_none());
        store.keep(Number(1), new, device.produced().unwrap(), reused);
        assert!(Arc::ptr_eq(&value, &store.get(&device, &Number(1), new).unwrap().unwrap()));
        assert!(store.reuse(&device, &Number(1), old, 11).is_none(), "another size is another buffer");
    }

    #[test]
    fn a_value_that_another_sequence_uses_is_not_written_again() {
        let (device, first) = (device(), Version::new());
        let [old, new] = [first, first.after(1)].map(of_field);
        let mut store = Store::new(100);
        store.keep(Number(1), old, device.produced().unwrap(), vec![1; 10]);
        let other = device.with_own_sequence();
        assert!(store.get(&other, &Number(1), old).unwrap().is_some());
        assert!(store.reuse(&device, &Number(1), new, 10).is_none());
    }
}
