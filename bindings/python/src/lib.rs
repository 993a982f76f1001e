//! The Python package layersplat's native part: thin classes over the library's own, which hold no state that these do not have.
//!
//! What only Python knows (image objects, colour maps, notebooks) is written in Python, in `layersplat/`. Everything that takes long runs
//! with the interpreter's lock released.

mod arrays;
mod calls;
mod camera;
mod device;
mod device_volume;
mod errors;
mod event;
mod exclusive;
mod given;
mod handles;
mod names;
mod pickled;
mod renderer;
mod settings;
mod transfer;
mod volume;
mod warned;

#[pyo3::pymodule]
mod _layersplat {
    #[pymodule_export]
    use super::calls::wait_for_interrupted_calls;
    #[pymodule_export]
    use super::camera::{Camera, Framing};
    #[pymodule_export]
    use super::device::Device;
    #[pymodule_export]
    use super::device_volume::DeviceVolume;
    #[pymodule_export]
    use super::event::Event;
    #[pymodule_export]
    use super::renderer::Renderer;
    #[pymodule_export]
    use super::settings::Settings;
    #[pymodule_export]
    use super::transfer::TransferFunction;
    #[pymodule_export]
    use super::volume::Volume;

    #[pymodule_export]
    #[allow(non_upper_case_globals)] // Python's name.
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
