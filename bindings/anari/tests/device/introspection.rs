//! What the device tells about itself is complete and true.

use crate::client::Device;
use anari_sys::*;
use std::ffi::{CStr, c_char, c_int, c_void};

/// Strings of a list that ends with null.
unsafe fn strings<'a>(list: *const *const c_char) -> Vec<&'a str> {
    // SAFETY: upheld by the caller.
    unsafe {
        let count = (0..).take_while(|&i| !list.is_null() && !(*list.add(i)).is_null()).count();
        (0..count).map(|i| CStr::from_ptr(*list.add(i)).to_str().unwrap()).collect()
    }
}

/// The types that have subtypes, and those that have none.
const NAMED: [ANARIDataType; 9] = [
    ANARI_CAMERA,
    ANARI_RENDERER,
    ANARI_INSTANCE,
    ANARI_LIGHT,
    ANARI_GEOMETRY,
    ANARI_SAMPLER,
    ANARI_MATERIAL,
    ANARI_VOLUME,
    ANARI_SPATIAL_FIELD,
];
const UNNAMED: [ANARIDataType; 8] =
    [ANARI_DEVICE, ANARI_ARRAY1D, ANARI_ARRAY2D, ANARI_ARRAY3D, ANARI_SURFACE, ANARI_GROUP, ANARI_WORLD, ANARI_FRAME];

#[test]
fn subtypes_are_those_that_can_be_made() {
    let device = Device::new();
    // SAFETY: the device lives.
    let subtypes = |data_type| unsafe { strings(anariGetObjectSubtypes(device.handle, data_type).cast_const()) };
    assert_eq!(subtypes(ANARI_CAMERA), ["perspective", "orthographic"]);
    assert_eq!(subtypes(ANARI_RENDERER), ["default"]);
    assert_eq!(subtypes(ANARI_INSTANCE), ["transform"]);
    assert_eq!(subtypes(ANARI_LIGHT), ["directional"]);
    assert_eq!(subtypes(ANARI_VOLUME), ["transferFunction1D"]);
    assert_eq!(subtypes(ANARI_SPATIAL_FIELD), ["structuredRegular"]);
    for none in [ANARI_GEOMETRY, ANARI_SAMPLER, ANARI_MATERIAL, ANARI_FRAME, ANARI_UNKNOWN, ANARI_FLOAT32] {
        assert_eq!(subtypes(none), [""; 0]);
    }
    for data_type in NAMED {
        for subtype in subtypes(data_type) {
            drop(device.make(data_type, &std::ffi::CString::new(subtype).unwrap()));
        }
    }
    device.expect_nothing();
}

/// A parameter as introspection tells it.
struct Told {
    name: &'static CStr,
    data_type: ANARIDataType,
}

fn parameters(device: &Device, data_type: ANARIDataType, subtype: &CStr) -> Vec<Told> {
    // SAFETY: the device lives, and the list ends with null.
    unsafe {
        let list = anariGetObjectInfo(device.handle, data_type, subtype.as_ptr(), c"parameter".as_ptr(), ANARI_PARAMETER_LIST);
        let list = list.cast::<ANARIParameter>();
        assert!(!list.is_null(), "{data_type} {subtype:?}");
        let count = (0..).take_while(|&i| !(*list.add(i)).name.is_null()).count();
        let told = |parameter: ANARIParameter| Told { name: CStr::from_ptr(parameter.name), data_type: parameter.type_ };
        (0..count).map(|i| told(*list.add(i))).collect()
    }
}

/// Every parameter is described, and accepts its own default and its limits without a message.
#[test]
fn parameters_are_complete() {
    let device = Device::new();
    let named = NAMED.into_iter().flat_map(|data_type| {
        // SAFETY: the device lives.
        let subtypes = unsafe { strings(anariGetObjectSubtypes(device.handle, data_type).cast_const()) };
        subtypes.into_iter().map(move |subtype| (data_type, std::ffi::CString::new(subtype).unwrap()))
    });
    let classes: Vec<_> = named.chain(UNNAMED.map(|data_type| (data_type, c"".into()))).collect();
    let mut count = 0;
    for (data_type, subtype) in classes {
        let is_made = !(ANARI_DEVICE..=ANARI_ARRAY3D).contains(&data_type);
        let object = is_made.then(|| device.make(data_type, &subtype));
        for Told { name, data_type: parameter_type } in parameters(&device, data_type, &subtype) {
            let info = |info: &CStr, info_type| -> *const c_void {
                let (subtype, name) = (subtype.as_ptr(), name.as_ptr());
                // SAFETY: the device lives.
                unsafe {
                    anariGetParameterInfo(device.handle, data_type, subtype, name, parameter_type, info.as_ptr(), info_type)
                }
            };
            assert!(!info(c"description", ANARI_STRING).is_null() && !info(c"required", ANARI_BOOL).is_null(), "{name:?}");
            assert!(info(c"nonsense", ANARI_STRING).is_null() && info(c"description", ANARI_FLOAT32).is_null());
            // SAFETY: it is a truth value.
            let is_required = unsafe { *info(c"required", ANARI_BOOL).cast::<c_int>() } != 0;
            let default = info(c"default", parameter_type);
            assert!(default.is_null() || !is_required, "{name:?}");
            if [ANARI_ARRAY1D, ANARI_ARRAY2D, ANARI_ARRAY3D].contains(&parameter_type) {
                assert!(!info(c"elementType", ANARI_DATA_TYPE_LIST).is_null(), "{name:?}");
            }
            if parameter_type == ANARI_DATA_TYPE {
                assert!(!info(c"value", ANARI_DATA_TYPE_LIST).is_null(), "{name:?}");
            }
            let Some(object) = &object else { continue };
            let limits = [c"minimum", c"maximum"].map(|limit| info(limit, parameter_type));
            for value in [default].into_iter().chain(limits).filter(|value| !value.is_null()) {
                object.set_raw(name, parameter_type, value);
                count += 1;
            }
            // SAFETY: it is a list of strings.
            for value in unsafe { strings(info(c"value", ANARI_STRING_LIST).cast()) } {
                object.set_text(name, &std::ffi::CString::new(value).unwrap());
                count += 1;
            }
            device.expect_nothing();
        }
    }
    assert!(count > 40, "{count}");
}

#[test]
fn extensions_and_properties() {
    let device = Device::new();
    // SAFETY: the device lives, and the list ends with null.
    unsafe {
        let info = |data_type, subtype: &CStr, info: &CStr| {
            anariGetObjectInfo(device.handle, data_type, subtype.as_ptr(), info.as_ptr(), ANARI_STRING_LIST)
        };
        let of_renderer = strings(info(ANARI_RENDERER, c"default", c"extension").cast());
        assert!(of_renderer.contains(&"ANARI_KHR_VOLUME_TRANSFER_FUNCTION1D") && of_renderer.is_sorted(), "{of_renderer:?}");
        let channels = strings(info(ANARI_FRAME, c"", c"channel").cast());
        assert_eq!(channels, ["channel.color", "channel.depth", "channel.objectId"]);
        assert!(info(ANARI_RENDERER, c"other", c"extension").is_null());
        let property = |name: &CStr, data_type, memory: *mut c_void, size| {
            anariGetProperty(device.handle, device.handle, name.as_ptr(), data_type, memory, size, ANARI_NO_WAIT)
        };
        let (mut version, mut length) = (0i32, 0u64);
        assert_eq!(property(c"version", ANARI_INT32, (&raw mut version).cast(), 4), 1);
        assert_eq!(property(c"version.name.size", ANARI_UINT64, (&raw mut length).cast(), 8), 1);
        let mut name = vec![0u8; length as usize];
        assert_eq!(property(c"version.name", ANARI_STRING, name.as_mut_ptr().cast(), length), 1);
        assert_eq!(
            CStr::from_bytes_with_nul(&name).unwrap().to_str().unwrap(),
            concat!("layersplat ", env!("CARGO_PKG_VERSION"))
        );
        let mut list: *const *const c_char = std::ptr::null();
        assert_eq!(property(c"extension", ANARI_STRING_LIST, (&raw mut list).cast(), 8), 1);
        assert_eq!(strings(list), of_renderer);
        // Not more than there is room for.
        let mut short = [7u8; 4];
        assert_eq!(property(c"version.name", ANARI_STRING, short.as_mut_ptr().cast(), 2), 1);
        assert_eq!(short, [b'l', b'a', 7, 7]);
        assert_eq!(property(c"version", ANARI_FLOAT32, short.as_mut_ptr().cast(), 4), 0);
        assert_eq!(property(c"nonsense", ANARI_INT32, short.as_mut_ptr().cast(), 4), 0);
        assert!(!property(c"version", ANARI_INT32, std::ptr::null_mut(), 0) == !0);
    }
    device.expect_nothing();
}
