//! Cache of values on the device. Each has a key, the versions of its inputs, and the commands that wrote it.

use crate::device::launch::MAX_CHANNELS;
use crate::device::{Device, Produced, Usability};
use crate::error::Error;
use std::any::Any;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Version of an input of cached values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Version {
    id: u64,
    changes: u64,
}

/// Next version id.
static NEXT_ID: AtomicU64 = AtomicU64::new(1);

impl Version {
    /// A unique new version.
    pub fn new() -> Self {
        Self { id: NEXT_ID.fetch_add(1, Ordering::Relaxed), changes: 0 }
    }

    /// The version after `changes` changes. Equal counts mean equal states for all owners.
    pub fn after(self, changes: u64) -> Self {
        Self { changes, ..self }
    }
}

/// Versions of the inputs of a value; `None` if the value does not depend on that input.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Inputs {
    pub field: Option<Version>,
    pub classification: Option<Version>,
    /// Of the fields that are drawn together with that one: field and classification.
    pub others: [Option<[Version; 2]>; MAX_CHANNELS - 1],
}

/// A value that a store can keep.
pub(super) trait Stored: Send + Sync + 'static {
    /// Size on the device in bytes.
    fn bytes(&self) -> usize;
}

/// Identity of a value, apart from the versions of its inputs.
pub(super) trait Key: PartialEq + Send + 'static {
    /// The type of the value.
    type Value: Stored;
}

/// Keeps the most recently used values within a budget in bytes.
pub(super) struct Store {
    /// Ordered from least to most recently used.
    entries: Vec<Entry>,
    budget: usize,
    /// Number of values made so far.
    #[cfg(test)]
    pub made: usize,
}

struct Entry {
    key: Box<dyn Any + Send>,
    inputs: Inputs,
    value: Arc<dyn Any + Send + Sync>,
    bytes: usize,
    produced: Produced,
    /// Whether another command sequence also uses the value; it must not be overwritten then.
    shared: bool,
}

impl Entry {
    fn has<K: Key>(&self, key: &K) -> bool {
        self.key.downcast_ref() == Some(key)
    }
}

impl Store {
    /// `budget` is in bytes. The newest value is kept even if it is larger.
    pub fn new(budget: usize) -> Self {
        Self {
            entries: Vec::new(),
            budget,
            #[cfg(test)]
            made: 0,
        }
    }

    /// The value of a key for these inputs, if commands of this device handle may use it.
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

    /// Removes the value of a key for older inputs and returns it for overwriting, if it has this size and nothing else uses it.
    pub fn reuse<K: Key>(&mut self, device: &Device, key: &K, inputs: Inputs, bytes: usize) -> Option<Arc<K::Value>> {
        let found = self.entries.iter().position(|entry| entry.inputs != inputs && entry.has(key))?;
        let entry = self.entries.remove(found);
        let fits = entry.bytes == bytes && !entry.shared && entry.produced.is_from(device);
        entry.value.downcast().ok().filter(|_| fits)
    }

    /// Keeps a value and drops values of the same key with older inputs. There may be another value with the same inputs, which
    /// depends on events that have not completed.
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

    /// Sets the budget for values that are kept from now on.
    pub fn limit(&mut self, budget: usize) {
        self.budget = budget;
    }

    /// Drops all values to free memory.
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

    fn field_inputs(version: Version) -> Inputs {
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
        assert_eq!(get(&mut store, 1).unwrap()[0], 1, "keys of different types differ");
        keep(&mut store, 2, 10);
        assert!(store.get(&device, &Name(1), inputs).unwrap().is_none(), "it was least recently used");
        assert!(get(&mut store, 1).is_some() && get(&mut store, 2).is_some());
        keep(&mut store, 3, 100);
        assert!(get(&mut store, 2).is_none() && get(&mut store, 3).is_some(), "the newest stays");
        store.clear();
        assert!(get(&mut store, 3).is_none());
    }

    #[test]
    fn values_of_older_inputs_are_written_again() {
        let (device, first) = (device(), Version::new());
        let [old, new] = [first, first.after(1)].map(field_inputs);
        assert_ne!(Version::new(), first);
        let mut store = Store::new(100);
        let value = store.keep(Number(1), old, device.produced().unwrap(), vec![1; 10]);
        assert!(store.reuse(&device, &Number(1), old, 10).is_none(), "its inputs are unchanged");
        assert!(store.get(&device, &Number(1), new).unwrap().is_none());
        let reused = store.reuse(&device, &Number(1), new, 10).unwrap();
        assert!(Arc::ptr_eq(&value, &reused) && store.get(&device, &Number(1), old).unwrap().is_none());
        store.keep(Number(1), new, device.produced().unwrap(), reused);
        assert!(Arc::ptr_eq(&value, &store.get(&device, &Number(1), new).unwrap().unwrap()));
        assert!(store.reuse(&device, &Number(1), old, 11).is_none(), "a different size needs another buffer");
    }

    #[test]
    fn a_value_that_another_sequence_uses_is_not_written_again() {
        let (device, first) = (device(), Version::new());
        let [old, new] = [first, first.after(1)].map(field_inputs);
        let mut store = Store::new(100);
        store.keep(Number(1), old, device.produced().unwrap(), vec![1; 10]);
        let other = device.with_own_sequence();
        assert!(store.get(&other, &Number(1), old).unwrap().is_some());
        assert!(store.reuse(&device, &Number(1), new, 10).is_none());
    }
}
