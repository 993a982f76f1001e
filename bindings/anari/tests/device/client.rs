//! A client of the API: objects that release themselves, and the messages of a device.

use anari_sys::*;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::PathBuf;
use std::ptr::null;
use std::rc::Rc;
use std::sync::{Mutex, Once};

/// A device, and what it told.
pub struct Device {
    library: ANARILibrary,
    pub handle: ANARIDevice,
    messages: Box<Mutex<Vec<String>>>,
}

/// The folder of the built library: cargo puts it beside the tests.
fn folder() -> PathBuf {
    let executable = std::env::current_exe().expect("a test knows its file");
    executable.parent().expect("it is in a folder").to_owned()
}

unsafe extern "C" fn told(
    user: *const c_void,
    _: ANARIDevice,
    _: ANARIObject,
    _: ANARIDataType,
    _: ANARIStatusSeverity,
    _: ANARIStatusCode,
    message: *const c_char,
) {
    // SAFETY: the device outlives its messages.
    let messages = unsafe { &*user.cast::<Mutex<Vec<String>>>() };
    let message = unsafe { CStr::from_ptr(message) }.to_string_lossy().into_owned();
    messages.lock().unwrap().push(message);
}

/// Opens OpenCL once. The library under test and that of the tests are two copies in one process, and PoCL has no devices for a thread
/// that asks while another thread is the first to do so.
fn open_first() {
    static OPENED: Once = Once::new();
    OPENED.call_once(|| drop(layersplat::Device::open(&layersplat::DeviceChoice::Default).unwrap()));
}

impl Device {
    pub fn new() -> Rc<Self> {
        open_first();
        let name = CString::new(format!("layersplat,{}/", folder().display())).unwrap();
        let messages = Box::new(Mutex::new(Vec::new()));
        // SAFETY: the strings and the messages live long enough.
        let (library, handle) = unsafe {
            let library = anariLoadLibrary(name.as_ptr(), Some(told), (&raw const *messages).cast());
            assert!(!library.is_null(), "{:?}", messages.lock().unwrap());
            (library, anariNewDevice(library, c"default".as_ptr()))
        };
        Rc::new(Self { library, handle, messages })
    }

    /// The messages since the last call.
    pub fn messages(&self) -> Vec<String> {
        std::mem::take(&mut *self.messages.lock().unwrap())
    }

    /// Fails unless exactly one message was told since the last call, which contains a text.
    #[track_caller]
    pub fn expect(&self, text: &str) {
        let messages = self.messages();
        assert!(messages.len() == 1 && messages[0].contains(text), "instead of '{text}': {messages:?}");
    }

    /// Fails if anything was told since the last call.
    #[track_caller]
    pub fn expect_nothing(&self) {
        assert_eq!(self.messages(), [""; 0]);
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: they were made by `new`, and are used no more.
        unsafe {
            anariRelease(self.handle, self.handle);
            anariUnloadLibrary(self.library);
        }
        let messages = self.messages();
        assert!(std::thread::panicking() || messages.is_empty(), "at the end: {messages:?}");
    }
}

/// A reference to an object.
pub struct Object {
    pub device: Rc<Device>,
    pub handle: ANARIObject,
    pub data_type: ANARIDataType,
}

impl Drop for Object {
    fn drop(&mut self) {
        // SAFETY: it is a reference of its own.
        unsafe { anariRelease(self.device.handle, self.handle) }
    }
}

/// Values of parameters whose type the API knows.
pub trait Value {
    const TYPE: ANARIDataType;
}

macro_rules! values {
    ($($rust:ty => $anari:ident),* $(,)?) => { $(impl Value for $rust { const TYPE: ANARIDataType = $anari; })* };
}

values! {
    f32 => ANARI_FLOAT32,
    [f32; 3] => ANARI_FLOAT32_VEC3,
    [f32; 4] => ANARI_FLOAT32_VEC4,
    [f32; 16] => ANARI_FLOAT32_MAT4,
    [f64; 2] => ANARI_FLOAT64_BOX1,
    [[f32; 2]; 2] => ANARI_FLOAT32_BOX2,
    [u32; 2] => ANARI_UINT32_VEC2,
    [u64; 2] => ANARI_UINT64_REGION1,
    u32 => ANARI_UINT32,
    i32 => ANARI_INT32,
    f64 => ANARI_FLOAT64,
    u8 => ANARI_UFIXED8,
    u16 => ANARI_UFIXED16,
    i16 => ANARI_FIXED16,
}

impl Device {
    fn object(self: &Rc<Self>, handle: ANARIObject, data_type: ANARIDataType) -> Object {
        assert!(!handle.is_null());
        Object { device: self.clone(), handle, data_type }
    }

    /// An object of a type, and of a subtype if the type has any.
    pub fn make(self: &Rc<Self>, data_type: ANARIDataType, subtype: &CStr) -> Object {
        let (device, subtype) = (self.handle, subtype.as_ptr());
        // SAFETY: the device lives.
        let handle: ANARIObject = unsafe {
            match data_type {
                ANARI_GEOMETRY => anariNewGeometry(device, subtype),
                ANARI_MATERIAL => anariNewMaterial(device, subtype),
                ANARI_SAMPLER => anariNewSampler(device, subtype),
                ANARI_SURFACE => anariNewSurface(device),
                ANARI_SPATIAL_FIELD => anariNewSpatialField(device, subtype),
                ANARI_VOLUME => anariNewVolume(device, subtype),
                ANARI_LIGHT => anariNewLight(device, subtype),
                ANARI_GROUP => anariNewGroup(device),
                ANARI_INSTANCE => anariNewInstance(device, subtype),
                ANARI_WORLD => anariNewWorld(device),
                ANARI_CAMERA => anariNewCamera(device, subtype),
                ANARI_RENDERER => anariNewRenderer(device, subtype),
                ANARI_FRAME => anariNewFrame(device),
                _ => unreachable!("{data_type}"),
            }
        };
        self.object(handle, data_type)
    }

    /// An array of the device with these elements.
    pub fn array<T: Value + Copy>(self: &Rc<Self>, element: ANARIDataType, dims: &[u64], elements: &[T]) -> Object {
        let array = self.shared(element, dims, null::<T>());
        // SAFETY: it has this many elements.
        unsafe {
            let to = anariMapArray(self.handle, array.handle).cast::<T>();
            to.copy_from_nonoverlapping(elements.as_ptr(), elements.len());
            anariUnmapArray(self.handle, array.handle);
        }
        array
    }

    /// An array of objects.
    pub fn objects(self: &Rc<Self>, objects: &[&Object]) -> Object {
        let handles: Vec<_> = objects.iter().map(|object| object.handle).collect();
        let array = self.shared(objects[0].data_type, &[handles.len() as u64], null::<ANARIObject>());
        // SAFETY: it has this many elements.
        unsafe {
            let to = anariMapArray(self.handle, array.handle).cast::<ANARIObject>();
            to.copy_from_nonoverlapping(handles.as_ptr(), handles.len());
            anariUnmapArray(self.handle, array.handle);
        }
        array
    }

    /// An array in memory of the caller, or of the device for null.
    pub fn shared<T>(self: &Rc<Self>, element: ANARIDataType, dims: &[u64], memory: *const T) -> Object {
        self.given(element, dims, memory, None, null())
    }

    /// An array with a deleter.
    pub fn given<T>(
        self: &Rc<Self>,
        element: ANARIDataType,
        dims: &[u64],
        memory: *const T,
        deleter: ANARIMemoryDeleter,
        user: *const c_void,
    ) -> Object {
        let (device, memory) = (self.handle, memory.cast());
        // SAFETY: upheld by the caller.
        let (handle, data_type) = unsafe {
            match *dims {
                [x] => (anariNewArray1D(device, memory, deleter, user, element, x), ANARI_ARRAY1D),
                [x, y] => (anariNewArray2D(device, memory, deleter, user, element, x, y), ANARI_ARRAY2D),
                [x, y, z] => (anariNewArray3D(device, memory, deleter, user, element, x, y, z), ANARI_ARRAY3D),
                _ => unreachable!(),
            }
        };
        self.object(handle, data_type)
    }
}

impl Object {
    /// The handle and its reference, which the caller releases.
    pub fn into_handle(self) -> ANARIObject {
        // SAFETY: the reference is dropped with the object.
        unsafe { anariRetain(self.device.handle, self.handle) };
        self.handle
    }

    /// Sets a parameter, whatever it is.
    pub fn set_raw(&self, name: &CStr, data_type: ANARIDataType, value: *const c_void) -> &Self {
        // SAFETY: upheld by the caller.
        unsafe { anariSetParameter(self.device.handle, self.handle, name.as_ptr(), data_type, value) };
        self
    }

    pub fn set<T: Value>(&self, name: &CStr, value: T) -> &Self {
        self.set_raw(name, T::TYPE, (&raw const value).cast())
    }

    pub fn set_object(&self, name: &CStr, object: &Object) -> &Self {
        self.set_raw(name, object.data_type, (&raw const object.handle).cast())
    }

    pub fn set_text(&self, name: &CStr, text: &CStr) -> &Self {
        self.set_raw(name, ANARI_STRING, text.as_ptr().cast())
    }

    pub fn set_flag(&self, name: &CStr, flag: bool) -> &Self {
        let flag = c_int::from(flag);
        self.set_raw(name, ANARI_BOOL, (&raw const flag).cast())
    }

    /// Sets a type, such as that of a channel.
    pub fn set_type(&self, name: &CStr, data_type: ANARIDataType) -> &Self {
        self.set_raw(name, ANARI_DATA_TYPE, (&raw const data_type).cast())
    }

    pub fn unset(&self, name: &CStr) -> &Self {
        // SAFETY: the device lives.
        unsafe { anariUnsetParameter(self.device.handle, self.handle, name.as_ptr()) };
        self
    }

    pub fn commit(&self) -> &Self {
        // SAFETY: the device lives.
        unsafe { anariCommitParameters(self.device.handle, self.handle) };
        self
    }

    /// Renders a frame and waits for it.
    pub fn render(&self) -> &Self {
        // SAFETY: the device lives.
        unsafe {
            anariRenderFrame(self.device.handle, self.handle);
            anariFrameReady(self.device.handle, self.handle, ANARI_WAIT);
        }
        self
    }

    /// A channel of a frame, row by row from the top.
    pub fn channel<T: Copy>(&self, name: &CStr, data_type: ANARIDataType) -> Vec<T> {
        let (mut width, mut height, mut found) = (0, 0, 0);
        // SAFETY: the device tells how much there is.
        unsafe {
            let (device, name) = (self.device.handle, name.as_ptr());
            let pixels = anariMapFrame(device, self.handle, name, &raw mut width, &raw mut height, &raw mut found);
            assert!(!pixels.is_null() && found == data_type, "{found}: {:?}", self.device.messages());
            let pixels = std::slice::from_raw_parts(pixels.cast::<T>(), width as usize * height as usize);
            let rows = pixels.chunks_exact(width as usize).rev().flatten().copied().collect();
            anariUnmapFrame(device, self.handle, name);
            rows
        }
    }

    pub fn property<T: Value + Default>(&self, name: &CStr) -> Option<T> {
        self.property_of(name, T::TYPE)
    }

    pub fn property_of<T: Default>(&self, name: &CStr, data_type: ANARIDataType) -> Option<T> {
        let mut value = T::default();
        let (device, memory) = (self.device.handle, (&raw mut value).cast());
        // SAFETY: the memory has this size.
        let found = unsafe {
            anariGetProperty(device, self.handle, name.as_ptr(), data_type, memory, size_of::<T>() as u64, ANARI_NO_WAIT)
        };
        (found == 1).then_some(value)
    }
}
