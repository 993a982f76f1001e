//! How much a page may send.

use std::time::Instant;

/// Messages per second. A hand on a fast mouse causes a view and an acknowledgement 60 to 240 times a second.
const MESSAGES: f64 = 1000.0;
/// Bytes per second.
const BYTES: f64 = (4 << 20) as f64;
/// Seconds whose share may be used at once.
const BURST: f64 = 2.0;

/// What a page may still send now: a share that grows with time.
#[derive(Debug)]
pub(super) struct Rate {
    messages: f64,
    bytes: f64,
    at: Instant,
}

impl Rate {
    pub fn new(now: Instant) -> Self {
        Self { messages: MESSAGES * BURST, bytes: BYTES * BURST, at: now }
    }

    /// Counts a message; false if it is too much.
    pub fn allows(&mut self, now: Instant, bytes: usize) -> bool {
        let seconds = now.saturating_duration_since(self.at).as_secs_f64();
        self.at = now;
        self.messages = (self.messages + seconds * MESSAGES).min(MESSAGES * BURST) - 1.0;
        self.bytes = (self.bytes + seconds * BYTES).min(BYTES * BURST) - bytes as f64;
        self.messages >= 0.0 && self.bytes >= 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn a_hand_is_slow_and_a_flood_is_not() {
        let start = Instant::now();
        let mut rate = Rate::new(start);
        // Ten minutes of a mouse with 240 reports a second, each a view and an acknowledgement.
        let mut now = start;
        for _ in 0..600 * 240 {
            now += Duration::from_micros(4167);
            assert!(rate.allows(now, 300) && rate.allows(now, 20));
        }
        assert!((0..10_000).any(|_| !rate.allows(now, 10)), "a flood of messages");
        let mut rate = Rate::new(start);
        assert!((0..20).any(|_| !rate.allows(start, 1 << 20)), "a flood of bytes");
    }
}
