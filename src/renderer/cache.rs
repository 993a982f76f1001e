//! What is kept from frame to frame, by what it was made for.

use std::any::Any;
use std::sync::Arc;

/// Something that can be kept.
pub(super) trait Kept: Send + Sync + 'static {
    /// Bytes on the device.
    fn bytes(&self) -> usize;
}

/// What a kept thing was made for.
pub(super) trait Key: PartialEq + Send + 'static {
    /// The thing.
    type Value: Kept;
    /// Whether it is made from voxels, which may change.
    const OF_VOXELS: bool = true;
    /// Whether it is made from a transfer function, and of no use with another.
    const OF_TRANSFER: bool = false;
}

/// Keeps what was used last, as long as it all takes no more than a budget.
pub(super) struct Cache {
    /// The last one was used last.
    entries: Vec<Entry>,
    budget: usize,
    /// How many things were made, ever.
    #[cfg(test)]
    pub made: usize,
}

struct Entry {
    key: Box<dyn Any + Send>,
    value: Arc<dyn Any + Send + Sync>,
    bytes: usize,
    of_voxels: bool,
    of_transfer: bool,
    /// The voxels that it was made from have changed.
    stale: bool,
}

impl Cache {
    /// `budget` in bytes. The newest entry stays even if it is larger.
    pub fn new(budget: usize) -> Self {
        Self {
            entries: Vec::new(),
            budget,
            #[cfg(test)]
            made: 0,
        }
    }

    /// Bytes that may be kept.
    pub fn budget(&self) -> usize {
        self.budget
    }

    /// What was made for a key.
    pub fn get<K: Key>(&mut self, key: &K) -> Option<Arc<K::Value>> {
        let found = self.entries.iter().position(|entry| !entry.stale && entry.key.downcast_ref() == Some(key))?;
        let entry = self.entries.remove(found);
        let value = entry.value.clone().downcast().ok();
        self.entries.push(entry);
        value
    }

    /// What was made for a key from voxels that have changed since, to be made again in the same place; it is no longer kept.
    pub fn take_stale<K: Key>(&mut self, key: &K) -> Option<Arc<K::Value>> {
        let found = self.entries.iter().position(|entry| entry.stale && entry.key.downcast_ref() == Some(key))?;
        self.entries.remove(found).value.downcast().ok()
    }

    /// Forgets everything.
    pub fn forget(&mut self) {
        self.entries.clear();
    }

    /// All that is made from voxels has to be made again.
    pub fn voxels_changed(&mut self) {
        self.entries.iter_mut().for_each(|entry| entry.stale |= entry.of_voxels);
    }

    /// Keeps what was made for a key, and forgets what was not used for longest if there is too much.
    pub fn keep<K: Key>(&mut self, key: K, value: impl Into<Arc<K::Value>>) -> Arc<K::Value> {
        #[cfg(test)]
        {
            self.made += 1;
        }
        let value = value.into();
        let bytes = value.bytes();
        self.take_stale(&key);
        let (of_voxels, of_transfer) = (K::OF_VOXELS, K::OF_TRANSFER);
        self.entries.push(Entry { key: Box::new(key), value: value.clone(), bytes, of_voxels, of_transfer, stale: false });
        let mut sum = 0;
        let kept = self.entries.iter().rev().take_while(|entry| {
            sum += entry.bytes;
            sum <= self.budget
        });
        let forgotten = self.entries.len() - kept.count().max(1);
        self.entries.drain(..forgotten);
        value
    }

    /// Forgets what was made from the transfer function.
    pub fn forget_transfer(&mut self) {
        self.entries.retain(|entry| !entry.of_transfer);
    }

    /// Forgets what was made from voxels.
    pub fn forget_voxels(&mut self) {
        self.entries.retain(|entry| !entry.of_voxels);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(PartialEq)]
    struct Number(u32);

    #[derive(PartialEq)]
    struct Name(u32);

    impl Kept for Vec<u8> {
        fn bytes(&self) -> usize {
            self.len()
        }
    }

    impl Key for Number {
        type Value = Vec<u8>;
        const OF_VOXELS: bool = true;
    }

    impl Key for Name {
        type Value = Vec<u8>;
        const OF_VOXELS: bool = false;
        const OF_TRANSFER: bool = true;
    }

    #[test]
    fn what_was_not_used_for_longest_is_forgotten() {
        let mut cache = Cache::new(25);
        cache.keep(Number(1), vec![1; 10]);
        cache.keep(Name(1), vec![2; 10]);
        assert_eq!(cache.get(&Number(1)).unwrap()[0], 1, "keys of other kinds are others");
        cache.keep(Number(2), vec![3; 10]);
        assert!(cache.get(&Name(1)).is_none() && cache.get(&Number(1)).is_some() && cache.get(&Number(2)).is_some());
        cache.keep(Number(3), vec![4; 100]);
        assert!(cache.get(&Number(2)).is_none() && cache.get(&Number(3)).is_some(), "the newest stays");
        let mut cache = Cache::new(25);
        cache.keep(Number(1), vec![1; 10]);
        cache.keep(Name(1), vec![2; 10]);
        cache.forget_voxels();
        assert!(cache.get(&Number(1)).is_none() && cache.get(&Name(1)).is_some(), "what is not of voxels stays");
        cache.keep(Number(1), vec![1; 10]);
        cache.forget_transfer();
        assert!(cache.get(&Number(1)).is_some() && cache.get(&Name(1)).is_none(), "what is not of the transfer function stays");
        cache.forget();
        assert!(cache.get(&Number(1)).is_none());
    }

    #[test]
    fn what_is_made_of_voxels_is_made_again_in_its_place() {
        let mut cache = Cache::new(100);
        let first = cache.keep(Number(1), vec![1; 10]);
        cache.keep(Name(1), vec![2; 10]);
        assert!(cache.take_stale(&Number(1)).is_none(), "the voxels are what they were");
        cache.voxels_changed();
        assert!(cache.get(&Number(1)).is_none() && cache.get(&Name(1)).is_some());
        let stale = cache.take_stale(&Number(1)).unwrap();
        assert!(Arc::ptr_eq(&first, &stale) && cache.take_stale(&Number(1)).is_none());
        cache.keep(Number(1), stale);
        assert!(Arc::ptr_eq(&first, &cache.get(&Number(1)).unwrap()));
        cache.voxels_changed();
        cache.keep(Number(1), vec![3; 10]);
        assert!(cache.take_stale(&Number(1)).is_none(), "what was made anew replaces it");
    }
}
