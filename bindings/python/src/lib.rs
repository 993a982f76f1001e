//! Native module of the Python package layersplat: thin classes without own state over those of the library.
//!
//! Image objects, colour maps and notebook support are written in Python, in `layersplat/`. Long calls release the GIL.

mod argument;
mod arrays;
mod calls;
mod camera;
mod channel;
mod colors;
mod device;
mod device_volume;
mod drawn_fields;
mod errors;
mod event;
mod exclusive;
mod handles;
mod labels;
mod live;
mod names;
mod pickled;
mod renderer;
mod sequence;
mod settings;
mod slice;
mod stream_plan;
mod surface;
mod transfer;
mod uploads;
mod volume;
mod warned;

#[pyo3::pymodule]
mod _layersplat {
    #[pymodule_export]
    use super::calls::wait_for_interrupted_calls;
    #[pymodule_export]
    use super::camera::{Camera, Framing};
    #[pymodule_export]
    use super::channel::{Channel, channel_colors};
    #[pymodule_export]
    use super::colors::Colors;
    #[pymodule_export]
    use super::device::Device;
    #[pymodule_export]
    use super::device_volume::DeviceVolume;
    #[pymodule_export]
    use super::event::Event;
    #[pymodule_export]
    use super::labels::Labels;
    #[pymodule_export]
    use super::live::{LivePage, LiveScene};
    #[pymodule_export]
    use super::renderer::Renderer;
    #[pymodule_export]
    use super::sequence::{Playback, VolumeSequence};
    #[pymodule_export]
    use super::settings::Settings;
    #[pymodule_export]
    use super::slice::Slice;
    #[pymodule_export]
    use super::surface::Surface;
    #[pymodule_export]
    use super::transfer::TransferFunction;
    #[pymodule_export]
    use super::volume::Volume;

    #[pymodule_export]
    #[allow(non_upper_case_globals)] // The name that Python expects.
    const __version__: &str = env!("CARGO_PKG_VERSION");

    /// The viewer's page as one ES module, for `anywidget` (build.rs).
    #[pymodule_export]
    const PAGE_MODULE: &str = include_str!(concat!(env!("OUT_DIR"), "/widget.js"));
}
