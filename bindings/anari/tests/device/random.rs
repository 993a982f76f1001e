//! A thousand random sequences of calls, right and wrong ones, end without a crash or a leak.

mod choices;

use crate::client::Device;
use anari_sys::*;
use choices::{ELEMENTS, FLOATS, MADE, NAMES, OF_OBJECTS, SUBTYPES, TEXTS, TYPES};
use std::ffi::{c_char, c_int, c_void};
use std::ptr::null;
use std::rc::Rc;
use std::sync::atomic::{AtomicU32, Ordering};

/// Number of sequences, and of calls in each.
const SEQUENCES: u64 = 1000;
const CALLS: usize = 80;
/// Sequences with one device.
const PER_DEVICE: u64 = 50;

/// Number of sequences: fewer where the environment says so, as under valgrind.
fn sequences() -> u64 {
    std::env::var("LAYERSPLAT_SEQUENCES").ok().and_then(|count| count.parse().ok()).unwrap_or(SEQUENCES)
}

/// Random numbers by xorshift (Marsaglia 2003).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() >> 11) as usize % count
    }

    fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }
}

/// Memory for any value and any small array, which stays.
#[repr(align(8))]
struct Memory([u8; 4096]);

struct Sequence {
    random: Random,
    device: Rc<Device>,
    /// All handles that ever were, with the references of this sequence.
    handles: Vec<(ANARIObject, u32)>,
    /// The frame of a scene, if there was one.
    frame: ANARIObject,
    memory: Box<Memory>,
}

static FREED: AtomicU32 = AtomicU32::new(0);
static GIVEN: AtomicU32 = AtomicU32::new(0);
static MAPPED: AtomicU32 = AtomicU32::new(0);

unsafe extern "C" fn free(user: *const c_void, memory: *const c_void) {
    FREED.fetch_add(1, Ordering::SeqCst);
    assert_eq!(user as usize, 77);
    // SAFETY: it was given away as a box.
    drop(unsafe { Box::from_raw(memory.cast_mut().cast::<Memory>()) });
}

unsafe extern "C" fn completed(_: *const c_void, device: ANARIDevice, frame: ANARIFrame) {
    // SAFETY: both live during the call.
    unsafe { anariFrameReady(device, frame, ANARI_NO_WAIT) };
}

impl Sequence {
    fn any(&mut self) -> ANARIObject {
        match self.random.below(40) {
            0 => std::ptr::null_mut(),
            1 => 0x123_4560 as ANARIObject,
            _ => match self.handles.len() {
                0 => std::ptr::null_mut(),
                count => {
                    // Newer objects more often.
                    let back = self.random.below(count).min(self.random.below(count));
                    self.handles[count - 1 - back].0
                }
            },
        }
    }

    fn fill(&mut self) {
        let step = self.random.pick(&[4, 8]);
        for chunk in self.memory.0.chunks_exact_mut(step) {
            if step == 4 {
                chunk.copy_from_slice(&FLOATS[(self.random.next() >> 20) as usize % FLOATS.len()].to_ne_bytes());
            } else {
                chunk.copy_from_slice(&((self.random.next() >> 20) % 9).to_ne_bytes());
            }
        }
    }

    fn made(&mut self, handle: ANARIObject) {
        assert!(!handle.is_null());
        self.handles.push((handle, 1));
    }

    fn make(&mut self) {
        let (data_type, subtype) = (self.random.pick(&MADE), self.random.pick(&SUBTYPES));
        // Often a subtype that there is.
        let subtype = match data_type {
            ANARI_SPATIAL_FIELD => c"structuredRegular",
            ANARI_VOLUME => c"transferFunction1D",
            ANARI_LIGHT if self.random.below(2) == 0 => c"directional",
            ANARI_CAMERA if self.random.below(2) == 0 => c"perspective",
            _ => subtype,
        };
        let handle = self.device.make(data_type, subtype).into_handle();
        self.made(handle);
    }

    fn make_array(&mut self) {
        let element = self.random.pick(&ELEMENTS);
        let dims: [u64; 3] = std::array::from_fn(|_| self.random.below(5) as u64);
        self.fill();
        if (ANARI_OBJECT..=ANARI_WORLD).contains(&element) {
            self.fill_handles();
        }
        let given = Box::new(Memory(self.memory.0));
        let (memory, deleter): (*const c_void, ANARIMemoryDeleter) = match self.random.below(3) {
            0 => (null(), None),
            // Shared memory of this sequence, which outlives its objects.
            1 => (self.memory.0.as_ptr().cast(), None),
            _ => {
                GIVEN.fetch_add(1, Ordering::SeqCst);
                (Box::into_raw(given).cast(), Some(free))
            }
        };
        let (device, user) = (self.device.handle, 77 as *const c_void);
        // SAFETY: the memory has the elements.
        let array = unsafe {
            match self.random.below(3) {
                0 => anariNewArray1D(device, memory, deleter, user, element, dims[0]),
                1 => anariNewArray2D(device, memory, deleter, user, element, dims[0], dims[1]),
                _ => anariNewArray3D(device, memory, deleter, user, element, dims[0], dims[1], dims[2]),
            }
        };
        self.made(array);
    }

    /// The objects of a scene that can be drawn.
    fn make_scene(&mut self) {
        let device = self.device.clone();
        let data = device.array(ANARI_FLOAT32, &[4; 3], &[0.5f32; 64]);
        let field = device.make(ANARI_SPATIAL_FIELD, c"structuredRegular");
        field.set_object(c"data", &data).commit();
        let volume = device.make(ANARI_VOLUME, c"transferFunction1D");
        volume.set_object(c"value", &field).commit();
        // Often a second volume, of the same field or of another one, somewhere else.
        let other_data = device.array(ANARI_UFIXED8, &[3, 2, 4], &[100u8; 24]);
        let other_field = device.make(ANARI_SPATIAL_FIELD, c"structuredRegular");
        other_field.set_object(c"data", &other_data).set(c"origin", [1.0f32, 0.5, 0.0]).commit();
        let other = device.make(ANARI_VOLUME, c"transferFunction1D");
        other.set_object(c"value", if self.random.below(2) == 0 { &field } else { &other_field }).commit();
        let volumes = match self.random.below(3) {
            0 => device.objects(&[&volume]),
            _ => device.objects(&[&volume, &other]),
        };
        let group = device.make(ANARI_GROUP, c"");
        group.set_object(c"volume", &volumes).commit();
        let instance = device.make(ANARI_INSTANCE, c"transform");
        let turned = [0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 2.0, 0.0, 0.0, 1.0f32];
        instance.set_object(c"group", &group).set(c"transform", turned).commit();
        let world = device.make(ANARI_WORLD, c"");
        world.set_object(c"volume", &volumes);
        if self.random.below(4) == 0 {
            world.set_object(c"instance", &device.objects(&[&instance]));
        }
        world.commit();
        let camera = device.make(ANARI_CAMERA, c"perspective");
        camera.set(c"position", [1.5f32, 1.5, 9.0]).commit();
        let renderer = device.make(ANARI_RENDERER, c"default");
        let frame = device.make(ANARI_FRAME, c"");
        frame.set_object(c"world", &world).set_object(c"camera", &camera).set_object(c"renderer", &renderer);
        frame.set(c"size", [9u32, 7]).set_type(c"channel.color", ANARI_UFIXED8_VEC4);
        if self.random.below(4) == 0 {
            frame.set_type(c"channel.objectId", ANARI_UINT32);
        }
        frame.commit();
        for object in [other_data, other_field, other, group, instance] {
            self.made(object.into_handle());
        }
        for object in [data, field, volume, volumes, world, camera, renderer, frame] {
            self.frame = object.into_handle();
            self.made(self.frame);
        }
    }

    fn fill_handles(&mut self) {
        for i in 0..self.memory.0.len() / 8 {
            let handle = self.any() as usize;
            self.memory.0[8 * i..8 * i + 8].copy_from_slice(&handle.to_ne_bytes());
        }
    }

    fn set(&mut self) {
        let (object, name, data_type) = (self.any(), self.random.pick(&NAMES), self.random.pick(&TYPES));
        // Often what belongs together.
        let data_type = if self.random.below(2) == 0 && OF_OBJECTS.contains(&name) { ANARI_OBJECT } else { data_type };
        self.fill();
        let handle = self.any();
        let small = [1 + self.random.below(12) as u32, 1 + self.random.below(12) as u32];
        let callback: ANARIFrameCompletionCallback = Some(completed);
        let format = self.random.pick(&[ANARI_UFIXED8_VEC4, ANARI_FLOAT32_VEC4, ANARI_FLOAT32, ANARI_UINT32, ANARI_STRING]);
        let flag = self.random.below(2) as c_int;
        let value: *const c_void = match data_type {
            _ if self.random.below(50) == 0 => null(),
            ANARI_STRING => self.random.pick(&TEXTS).as_ptr().cast(),
            ANARI_DATA_TYPE => (&raw const format).cast(),
            ANARI_BOOL => (&raw const flag).cast(),
            ANARI_UINT32_VEC2 => small.as_ptr().cast(),
            ANARI_FRAME_COMPLETION_CALLBACK => (&raw const callback).cast(),
            ANARI_OBJECT..=ANARI_WORLD => (&raw const handle).cast(),
            _ => self.memory.0.as_ptr().cast(),
        };
        // SAFETY: the value is of the type.
        unsafe { anariSetParameter(self.device.handle, object, name.as_ptr(), data_type, value) };
    }

    fn map(&mut self) {
        let (object, name, element) = (self.any(), self.random.pick(&NAMES), self.random.pick(&ELEMENTS));
        let (device, mut stride) = (self.device.handle, 0);
        // SAFETY: nothing is written after the unmapping.
        unsafe {
            if self.random.below(2) == 0 {
                if !anariMapArray(device, object).is_null() && self.random.below(10) > 0 {
                    anariUnmapArray(device, object);
                }
            } else {
                let count = self.random.below(6) as u64;
                let to = anariMapParameterArray1D(device, object, name.as_ptr(), element, count, &raw mut stride);
                if !to.is_null() {
                    assert!(stride > 0 && count > 0);
                    to.cast::<u8>().write_bytes(0, (stride * count) as usize);
                }
                anariUnmapParameterArray(device, object, name.as_ptr());
            }
        }
    }

    fn render(&mut self) {
        let frame = if self.random.below(3) > 0 { self.frame } else { self.any() };
        let device = self.device.handle;
        let mut size = [0u32; 2];
        let mut data_type = 0;
        // SAFETY: the memory of the channel is not read.
        unsafe {
            anariRenderFrame(device, frame);
            if self.random.below(4) == 0 {
                anariDiscardFrame(device, frame);
            }
            if self.random.below(4) > 0 {
                anariFrameReady(device, frame, ANARI_WAIT);
                let channel =
                    self.random.pick(&[c"channel.color", c"channel.color", c"channel.depth", c"channel.objectId"]).as_ptr();
                let [width, height] = &mut size;
                let pixels = anariMapFrame(device, frame, channel, width, height, &raw mut data_type);
                MAPPED.fetch_add(u32::from(!pixels.is_null()), Ordering::SeqCst);
                anariUnmapFrame(device, frame, channel);
            }
        }
    }

    fn query(&mut self) {
        let object = self.any();
        let name = self.random.pick(&[c"bounds", c"duration", c"version", c"extension", c"refinementProgress", c"other"]);
        let data_type = self.random.pick(&[ANARI_FLOAT32_BOX3, ANARI_FLOAT32, ANARI_INT32, ANARI_STRING_LIST]);
        let (memory, size) = (self.memory.0.as_mut_ptr().cast(), self.random.below(64) as u64);
        let info = self.random.pick(&[c"parameter", c"extension", c"default", c"value"]).as_ptr();
        let (kind, subtype) = (self.random.pick(&MADE), self.random.pick(&SUBTYPES).as_ptr());
        // SAFETY: the memory is larger.
        unsafe {
            anariGetProperty(self.device.handle, object, name.as_ptr(), data_type, memory, size, ANARI_WAIT);
            anariGetObjectSubtypes(self.device.handle, kind);
            anariGetObjectInfo(self.device.handle, kind, subtype, info, data_type);
            let parameter: *const c_char = self.random.pick(&NAMES).as_ptr();
            anariGetParameterInfo(self.device.handle, kind, subtype, parameter, data_type, info, data_type);
        }
    }

    /// Adds or removes a reference; sometimes one of an object that is gone.
    fn count_references(&mut self) {
        if self.handles.is_empty() {
            return;
        }
        let place = self.random.below(self.handles.len());
        let (object, references) = &mut self.handles[place];
        // SAFETY: handles are numbers.
        unsafe {
            if self.random.below(3) == 0 {
                anariRetain(self.device.handle, *object);
                // An object without references may still be in use; then it has one again.
                *references += u32::from(*references > 0);
                if *references == 0 {
                    anariRelease(self.device.handle, *object);
                }
            } else {
                anariRelease(self.device.handle, *object);
                *references = references.saturating_sub(1);
            }
        }
    }

    fn run(mut self) {
        if self.random.below(2) == 0 {
            self.make_scene();
        }
        for _ in 0..CALLS {
            let device = self.device.handle;
            let (object, name) = (self.any(), self.random.pick(&NAMES).as_ptr());
            match self.random.below(32) {
                0..=5 => self.make(),
                6..=8 => self.make_array(),
                9..=17 => self.set(),
                // SAFETY: handles are numbers.
                18..=21 => unsafe { anariCommitParameters(device, object) },
                22 => unsafe { anariUnsetParameter(device, object, name) },
                23 if self.random.below(4) == 0 => unsafe { anariUnsetAllParameters(device, object) },
                24..=25 => self.map(),
                26..=27 => self.render(),
                28 => self.query(),
                _ => self.count_references(),
            }
        }
        for (object, references) in std::mem::take(&mut self.handles) {
            for _ in 0..references {
                // SAFETY: it has these references.
                unsafe { anariRelease(self.device.handle, object) };
            }
        }
        self.device.messages();
    }
}

#[test]
fn random_sequences_end_without_crash_or_leak() {
    let mut device = Device::new();
    for seed in 0..sequences() {
        if seed % PER_DEVICE == 0 {
            // The client fails if a device tells of objects that were not released.
            device = Device::new();
        }
        let random = Random((seed + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        Sequence {
            random,
            device: device.clone(),
            handles: Vec::new(),
            frame: std::ptr::null_mut(),
            memory: Box::new(Memory([0; 4096])),
        }
        .run();
    }
    drop(device);
    let (given, freed) = (GIVEN.load(Ordering::SeqCst), FREED.load(Ordering::SeqCst));
    let mapped = MAPPED.load(Ordering::SeqCst);
    assert!(u64::from(mapped) > sequences() / 4, "{mapped} frames were mapped");
    assert!(given > 0 && freed == given, "{freed} of {given} memories were freed");
}
