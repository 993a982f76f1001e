//! Streaming plans as Python dicts.

use layersplat::renderer::StreamPlan;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The dict of `Renderer.stream_plan`.
pub fn stream_plan<'py>(py: Python<'py>, plan: &StreamPlan) -> PyResult<Bound<'py, PyDict>> {
    let lattices = plan.lattices.iter().map(|lattice| {
        let dict = PyDict::new(py);
        dict.set_item("axis", format!("{:?}", lattice.axis).to_lowercase())?;
        dict.set_item("parts", lattice.parts)?;
        dict.set_item("held_layers", lattice.held_layers)?;
        Ok(dict)
    });
    let dict = PyDict::new(py);
    dict.set_item("lattices", lattices.collect::<PyResult<Vec<_>>>()?)?;
    dict.set_item("voxel_bytes", plan.voxel_bytes)?;
    dict.set_item("light_bytes", plan.light_bytes)?;
    dict.set_item("volume_bytes", plan.volume_bytes)?;
    dict.set_item("device_bytes", plan.device_bytes)?;
    dict.set_item("available_bytes", plan.memory)?;
    Ok(dict)
}
