//! Volumes that the page opens: the built-in ones and those of the folder, if the command names none, and files dropped onto the page.

use super::Arguments;
use super::given::GivenOptions;
use super::host::PageHost;
use crate::cli::options::VolumeOptions;
use crate::cli::processes::Processes;
use crate::cli::scene::OpenedScene;
use crate::cli::{Cli, Command};
use crate::device::Device;
use crate::error::Error;
use crate::viewer::{Offered, Opening, RawLayout, Source, reorders};
use crate::volume::BUILTIN;
use clap::Parser;
use std::ffi::OsString;
use std::path::Path;

/// Most files of the folder that are offered.
const MOST_FILES: usize = 500;
/// Ends of the names of volumes. Other files may be volumes, too, but a list of all files would hide them.
const ENDINGS: [&str; 26] = [
    ".raw", ".raw.gz", ".bov", ".dcm", ".h5", ".hdf5", ".mha", ".mhd", ".nhdr", ".nii", ".nii.gz", ".npy", ".npz", ".nrrd",
    ".tif", ".tiff", ".vti", ".vtk", ".zarr", ".nc", ".hdr", ".pvd", ".series", ".mgh", ".mgz", ".mnc",
];

/// Built-in volumes, and those of the folder in which the command runs.
pub(super) fn offered() -> Vec<Offered> {
    let builtin = BUILTIN.iter().map(|name| Offered { name: format!("builtin:{name}"), is_builtin: true });
    let entries = std::fs::read_dir(".").into_iter().flatten().flatten();
    let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
    let is_volume = |name: &String| {
        ENDINGS.iter().any(|ending| name.to_lowercase().ends_with(ending)) && !name.starts_with('.') && !reorders(name)
    };
    let mut files: Vec<Offered> =
        names.filter(is_volume).take(MOST_FILES).map(|name| Offered { name, is_builtin: false }).collect();
    files.sort_by(|a, b| a.name.cmp(&b.name));
    builtin.chain(files).collect()
}

/// Opens a volume with those options of the command that go with any volume.
pub(super) fn open(
    given: &GivenOptions,
    offered: &[Offered],
    source: &Source,
    device: &Device,
) -> Result<(Opening, PageHost), Error> {
    let volume = match *source {
        Source::Offered(name) => {
            let known = offered.iter().find(|known| known.name == name);
            let known = known.ok_or_else(|| Error::UnknownName {
                what: "offered volume",
                name: name.into(),
                known: "those of the list: reload the page".into(),
            })?;
            if known.is_builtin { known.name.clone() } else { Path::new(".").join(&known.name).to_string_lossy().into_owned() }
        }
        Source::File(path, _) => path.to_string_lossy().into_owned(),
    };
    let options = given.running.iter().chain(&given.drawing).flat_map(|option| option.words.clone());
    let words = ["layersplat".into(), "view".into(), volume].into_iter().chain(layout_words(source)).chain(options);
    let words: Vec<OsString> = words.map(Into::into).collect();
    let is_confined = matches!(source, Source::File(..));
    // A run that began with channels shows the components of vectors, too.
    let even_vectors = given.reading.iter().any(|option| option.id == "channels");
    let (arguments, words) = with_all_channels(parsed(&words, is_confined)?, words, even_vectors)?;
    let (scene, sequence) = arguments.open(&Processes::alone())?;
    let scene = OpenedScene { device: device.clone(), ..scene };
    let opening = super::opening_of(&arguments.scene, scene, sequence)?;
    let host = PageHost::new(GivenOptions::of(words), arguments.scene.device, &opening);
    Ok((opening, host.offering(offered)))
}

/// Options for raw voxels whose layout is not the usual one.
fn layout_words(source: &Source) -> Vec<String> {
    let Source::File(_, RawLayout { big_endian, header_bytes }) = *source else { return Vec::new() };
    let order = big_endian.then(|| ["--endian".into(), "big".into()]);
    let header = (header_bytes > 0).then(|| ["--header-bytes".into(), header_bytes.to_string()]);
    order.into_iter().chain(header).flatten().collect()
}

/// The arguments and words of a command: with all channels, if its file has several and no option chooses.
pub(super) fn with_all_channels(
    arguments: Arguments,
    mut words: Vec<OsString>,
    even_vectors: bool,
) -> Result<(Arguments, Vec<OsString>), Error> {
    if !arguments.takes_all_channels(even_vectors) {
        return Ok((arguments, words));
    }
    words.extend(["--channels".into(), "all".into()]);
    let arguments = parsed(&words, arguments.scene.volume.confined)?;
    Ok((arguments, words))
}

/// The arguments of a command that this program makes.
fn parsed(words: &[OsString], is_confined: bool) -> Result<Arguments, Error> {
    let refused = |e: clap::Error| {
        let problem = e.to_string().lines().next().unwrap_or_default().trim_start_matches("error: ").to_owned();
        Error::Settings { field: "page", problem }
    };
    let Command::View(mut arguments) = Cli::try_parse_from(words).map_err(refused)?.command else {
        unreachable!("the words name the command")
    };
    arguments.scene.volume.confined = is_confined;
    Ok(arguments)
}

/// What a command offers: nothing if it names a volume.
pub(super) fn offered_by(options: &VolumeOptions) -> Vec<Offered> {
    if options.is_default() { offered() } else { Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn builtin_volumes_are_offered_first() {
        let all = offered();
        assert!(all[0].is_builtin && all.iter().any(|offered| offered.name == "builtin:hydrogen"));
        assert!(all.iter().all(|offered| !offered.name.contains('/')));
    }
}
