//! Scenes of the benches: built-in volumes, and the paper's data sets if available.
#![allow(dead_code, reason = "each bench uses a part only")]

use layersplat::{Camera, Device, DeviceChoice, OpenOptions, Orbit, Renderer, TransferFunction, Viewport, Volume};
use std::path::PathBuf;

pub const BUILT_IN: [&str; 2] = ["builtin:hydrogen@128", "builtin:marschner-lobb@64"];
const DATA_SETS: [&str; 5] = ["fuel", "neghip", "lobster", "engine", "aneurism"];

/// A volume with its transfer function.
pub struct Scene {
    pub name: String,
    pub volume: Volume<'static>,
    pub transfer: TransferFunction,
}

impl Scene {
    pub fn built_in(name: &str) -> Self {
        let volume = Volume::open(name, &OpenOptions::default()).expect("a built-in volume");
        // Not the automatic one, which may change and thereby the timings.
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/hydrogen.json");
        let transfer = TransferFunction::from_file(file.as_ref(), None).expect("a transfer function");
        Self { name: name.replace("builtin:", ""), volume, transfer }
    }

    /// Data sets in `LAYERSPLAT_VOLUMES`, default ../shared/volumes, that have a transfer function.
    pub fn data_sets() -> Vec<Self> {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/volumes");
        let folder = std::env::var_os("LAYERSPLAT_VOLUMES").map_or(folder.into(), PathBuf::from);
        DATA_SETS.into_iter().filter_map(|name| Self::data_set(&folder, name)).collect()
    }

    fn data_set(folder: &PathBuf, name: &str) -> Option<Self> {
        let mut files = std::fs::read_dir(folder).ok()?.flatten().filter_map(|e| e.file_name().into_string().ok());
        let file = files.find(|f| f.starts_with(&format!("{name}_")) && f.contains("uint8"))?;
        let volume = Volume::open(folder.join(file).to_str()?, &OpenOptions::default()).ok()?;
        let transfer = TransferFunction::from_file(&folder.join(format!("../transfer/{name}.json")), None).ok()?;
        Some(Self { name: name.into(), volume, transfer })
    }

    pub fn renderer(&self) -> Renderer {
        Renderer::new(&device(), &self.volume, &self.transfer).expect("a renderer")
    }

    /// The view of docs/dev/fidelity.md: oblique, fits any orientation.
    pub fn camera(&self, azimuth: f64) -> Camera {
        let grid = self.volume.grid();
        Camera::fit_parallel(grid.centre(), grid.diagonal(), viewport(), Orbit { azimuth, elevation: 20.0, roll: 0.0 })
    }
}

pub fn device() -> Device {
    Device::open(&DeviceChoice::Default).expect("the benches need an OpenCL device: scripts/test installs PoCL")
}

pub fn viewport() -> Viewport {
    Viewport::new(512, 512).expect("a valid size")
}
