//! An ANARI device that draws volumes with layersplat: `libanari_library_layersplat.so`.
//!
//! `shim/device.cpp` has the C++ classes of the API; each of their functions calls one of `boundary.rs`. The library is called directly,
//! not through its C functions, which would need a second set of handles and copies of arrays.
//!
//! `device.rs` has the calls and the lock, `objects.rs` the table of objects with their references, `schema.rs` what parameters there are,
//! `frame.rs` makes a picture from a scene, and `painter.rs` draws it, on the thread of `worker.rs`, with the renderers that `kept.rs` has.

mod arrays;
mod boundary;
mod camera;
mod colors;
mod device;
mod field;
mod frame;
mod handle;
mod introspection;
mod kept;
mod light;
mod objects;
mod on_device;
mod painter;
mod parameters;
mod properties;
mod renderer;
mod schema;
mod status;
mod types;
mod value;
mod volume;
mod warnings;
mod worker;
mod world;

pub use boundary::anari_library_layersplat_new_library;
