//! Long launches in bands of work-items, between which others can use the device.

use super::Device;
use crate::error::Error;
use opencl3::kernel::Kernel;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Time that a band is meant to take. At most two are enqueued at once.
const BAND: Duration = Duration::from_millis(8);
/// Share by which the known time of a work-item falls per band: the next frame may be cheaper. Slow enough that a few
/// bands of cheap tiles do not make the next one, with expensive ones, much longer.
const DECAY: f64 = 0.98;
/// Work-groups per compute unit in the first band of a kernel, whose time is unknown.
const FIRST_GROUPS: usize = 2;

/// Renders frames in bands: the kernels of a frame are launched in parts of about 8 ms, at most two of them enqueued at once. So frames
/// of other renderers on the device wait a short time only, and a frame that is [cancelled](crate::Cancel) ends soon. The picture is the
/// same, bit for bit. Another thread can pause the frames. Clones share one state: pass one to
/// [`Renderer::set_bands`](crate::Renderer::set_bands) and keep another.
///
/// ```
/// use layersplat::device::Bands;
/// use std::time::Duration;
///
/// let bands = Bands::new();
/// // Frames in bands wait while a hand moves, for at most this time after its last movement.
/// bands.pause(Duration::from_millis(300));
/// bands.resume();
/// ```
#[derive(Clone, Debug, Default)]
pub struct Bands(Arc<Pause>);

#[derive(Debug, Default)]
struct Pause {
    until: Mutex<Option<Instant>>,
    changed: Condvar,
}

impl Bands {
    /// Bands that are not paused.
    pub fn new() -> Self {
        Self::default()
    }

    /// Pauses frames before their next band, until [`resume`](Self::resume) or for this time from now.
    pub fn pause(&self, longest: Duration) {
        self.set(Some(Instant::now() + longest));
    }

    /// Ends a pause.
    pub fn resume(&self) {
        self.set(None);
    }

    fn set(&self, until: Option<Instant>) {
        *self.0.until.lock().unwrap_or_else(PoisonError::into_inner) = until;
        self.0.changed.notify_all();
    }

    /// Waits while paused, or until `ended`, which is asked every few milliseconds. Returns the time waited: exactly 0 if not paused.
    pub(super) fn wait(&self, ended: impl Fn() -> bool) -> Duration {
        const STEP: Duration = Duration::from_millis(10);
        let mut begun = None;
        let mut until = self.0.until.lock().unwrap_or_else(PoisonError::into_inner);
        while let Some(left) = until.and_then(|until| until.checked_duration_since(Instant::now())) {
            if left.is_zero() || ended() {
                break;
            }
            begun.get_or_insert_with(Instant::now);
            until = self.0.changed.wait_timeout(until, left.min(STEP)).unwrap_or_else(PoisonError::into_inner).0;
        }
        begun.map_or(Duration::ZERO, |begun| begun.elapsed())
    }
}

/// How many work-items of a kernel fit into a band, from the times of earlier bands.
#[derive(Debug, Default)]
pub(super) struct BandSize {
    /// Time of the slowest recent band; 0 if unknown.
    seconds_per_item: f64,
    /// Most work-items of the next band: twice those of the largest that was timed.
    most: usize,
}

impl BandSize {
    /// Work-items of the next band: whole groups, at least `least`.
    fn next(&self, least: usize, group: usize, compute_units: usize) -> usize {
        let first = FIRST_GROUPS * compute_units.max(1) * group;
        let fitting = match self.seconds_per_item {
            0.0 => first,
            seconds => ((BAND.as_secs_f64() / seconds) as usize).min(self.most.max(first)),
        };
        fitting.max(least).max(group).next_multiple_of(group)
    }

    /// Takes the time of a band.
    fn record(&mut self, items: usize, took: Duration) {
        self.seconds_per_item = (self.seconds_per_item * DECAY).max(took.as_secs_f64() / items as f64);
        self.most = self.most.max(2 * items);
    }
}

/// Work-items of a launch, of a work-group, and of a band at least.
#[derive(Clone, Copy)]
pub(super) struct Items {
    pub all: usize,
    pub group: usize,
    pub least: usize,
}

impl Device {
    /// Whether frames of this handle are rendered in bands.
    pub(super) fn has_bands(&self) -> bool {
        self.begun.as_ref().is_some_and(|begun| begun.limits.bands.is_some())
    }

    /// Enqueues `kernel`, whose arguments are set, in bands. `begin_at` sets the first work-item of a band.
    pub(super) fn start_in_bands(
        &self,
        stage: &'static str,
        kernel: &Kernel,
        items: Items,
        size: &mut BandSize,
        begin_at: impl Fn(u64) -> opencl3::Result<()>,
    ) -> Result<(), Error> {
        let Items { all, group, least } = items;
        let compute_units = self.info().compute_units as usize;
        let mut first = 0;
        // Work-items of the last two bands, and when the one before them had ended.
        let (mut enqueued, mut since) = ([0; 2], None);
        while first < all {
            let paused = self.check_limits(stage)?;
            let now = Instant::now();
            // All commands but the last have ended, so the earlier of the two bands ended now.
            if let Some(since) = since.filter(|_| enqueued[0] > 0) {
                size.record(enqueued[0], now.duration_since(since));
            }
            since = paused.is_zero().then_some(now);
            let count = size.next(least, group, compute_units).min(all - first);
            begin_at(first as u64).map_err(|e| self.error("clSetKernelArg", e))?;
            self.enqueue(stage, kernel, count, group)?;
            enqueued = [enqueued[1], count];
            first += count;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::launch::picture::{Present, PresentArguments};
    use crate::device::launch::structs::Float4;
    use crate::device::launch::{Argument, Launch};
    use crate::device::{Buffer, DeviceChoice};

    const GROUP: usize = 4;

    /// Sizes of `bands` bands whose work-items take `seconds` each.
    fn sizes(size: &mut BandSize, seconds: f64, bands: usize) -> Vec<usize> {
        let mut all = Vec::new();
        for _ in 0..bands {
            let items = size.next(1, GROUP, 2);
            all.push(items);
            size.record(items, Duration::from_secs_f64(seconds * items as f64));
        }
        all
    }

    #[test]
    fn bands_grow_to_their_time_and_shrink_at_once() {
        let mut size = BandSize::default();
        let all = sizes(&mut size, 1e-6, 20);
        assert_eq!(all[0], FIRST_GROUPS * 2 * GROUP);
        assert!(all.windows(2).all(|pair| pair[1] <= 2 * pair[0].next_multiple_of(GROUP)), "{all:?}");
        assert!(all[19].abs_diff(8000) <= GROUP && all.iter().all(|items| items % GROUP == 0), "{all:?}");
        sizes(&mut size, 1e-4, 1);
        assert!(sizes(&mut size, 1e-4, 1)[0] <= 80 + GROUP);
        // A few cheap bands do not make the next one much longer.
        sizes(&mut size, 1e-8, 10);
        assert!(sizes(&mut size, 1e-4, 1)[0] < 110);
        assert_eq!(size.next(1 << 16, 64, 2), 1 << 16, "no band is shorter than its kernel allows");
    }

    /// Opaque pixels of a picture that is presented in bands. Without `begin_at`, all bands begin at the first work-item.
    fn presented(pixels: usize, begins: bool) -> (usize, usize) {
        let device = Device::open(&DeviceChoice::Default).unwrap();
        let frame = Buffer::from_slice(&device, &vec![Float4([1.0; 4]); pixels], "the frame").unwrap();
        let rgba = Buffer::from_slice(&device, &vec![[0u8; 4]; pixels], "the picture").unwrap();
        let kernel = device.kernel(Present::FILE, Present::NAME, &Present::defines(device.tuning(), false).0).unwrap();
        let [background, curve] = [Float4([0.0; 4]); 2];
        let arguments = PresentArguments { frame: &frame, background, curve, pixels: pixels as i32, rgba: &rgba };
        let first_item = arguments.set(&kernel, 0).unwrap();
        0u64.set(&kernel, first_item).unwrap();
        let timed = device.timed();
        let items = Items { all: pixels, group: 64, least: 1 };
        let begin_at = |first: u64| if begins { first.set(&kernel, first_item).map(drop) } else { Ok(()) };
        timed.start_in_bands("bands", &kernel, items, &mut BandSize::default(), begin_at).unwrap();
        let bands = timed.stopwatch.as_ref().unwrap().count();
        let mut picture = vec![[0u8; 4]; pixels];
        rgba.read(&device, &mut picture).unwrap();
        (bands, picture.iter().filter(|&&pixel| pixel == [255; 4]).count())
    }

    #[test]
    fn every_band_has_its_own_work_items() {
        let (bands, filled) = presented(100_000, true);
        assert!(bands > 3 && filled == 100_000, "{bands} bands, {filled} pixels");
        assert!(presented(100_000, false).1 < 100_000, "the test would notice bands in the wrong place");
    }

    #[test]
    fn pauses_end_by_themselves_by_resuming_and_by_cancelling() {
        let bands = Bands::new();
        assert_eq!(bands.wait(|| false), Duration::ZERO, "bands are timed unless a pause was among them");
        bands.pause(Duration::from_millis(30));
        assert!(bands.wait(|| false) >= Duration::from_millis(25));
        bands.pause(Duration::from_secs(3600));
        assert!(bands.wait(|| true) < Duration::from_secs(60));
        std::thread::scope(|threads| {
            let waiting = threads.spawn(|| bands.wait(|| false));
            std::thread::sleep(Duration::from_millis(20));
            bands.resume();
            assert!(waiting.join().unwrap() < Duration::from_secs(60));
        });
    }
}
