//! Examples and formats at the end of each `--help`.

/// Supported volumes.
macro_rules! volumes {
    () => {
        "

Volumes:
  NRRD, NIfTI, MetaImage, VTK image data, NumPy, BOV, TIFF, DICOM, HDF5 and NetCDF files.
  Raw files (.raw, .raw.gz); dimensions and type come from a name NAME_XxYxZ_TYPE.raw, or from --dims and --type.
  Folders of Zarr, of DICOM images or of numbered slices; NAME%d.EXT for slices.
  URLs of Zarr and OME-Zarr: https://, http://, or s3://BUCKET/KEY of a public bucket (region: AWS_REGION).
  Steps in time: frames of a file, the files of ParaView's .pvd, or NAME%d.EXT of files that hold volumes; --frame N chooses one.
  Built-in volumes: marschner-lobb, hydrogen, shepp-logan, gyroid, torus-knot and cube, sized as in builtin:hydrogen@64 or builtin:cube@3x4x5."
    };
}

/// Supported transfer functions.
macro_rules! transfer_functions {
    () => {
        "

Transfer functions:
  Names from `layersplat transfer --list`; append _r to reverse.
  Files: ParaView (FILE.json or FILE.json#PRESET), 3D Slicer (.vp, .vp.json), or lines of value,r,g,b,a (.csv).
  Data values are numbers, or percentiles of the voxels such as p99.5."
    };
}

#[cfg(feature = "viewer")]
macro_rules! view_first {
    () => {
        "\n  layersplat view FILE                    # in the browser, to turn it by hand"
    };
}
#[cfg(not(feature = "viewer"))]
macro_rules! view_first {
    () => {
        ""
    };
}

pub(super) const FIRST: &str = concat!(
    "\
Start with:
  layersplat render FILE -o picture.png   # or without FILE: a built-in volume",
    view_first!(),
    "
  layersplat rotate FILE -o turn.gif
  layersplat render -h                    # the most common options"
);
pub(super) const RENDER: &str = concat!(
    "\
Examples:
  layersplat render                                          # a built-in volume
  layersplat render engine_256x256x128_uint8.raw.gz --azimuth 30 --elevation 20 -o engine.png
  layersplat render head.raw --dims 256x256x109 --type uint16 --endian big --spacing 1,1,1.5
  layersplat render builtin:hydrogen --blend maximum --transfer viridis --size 1024x768
  layersplat render builtin:shepp-logan --legend --axes --samples 2 -o phantom.jpg
  layersplat render builtin:hydrogen --cameras views.ndjson  # one picture per line of the file
  curl -s https://host/head.nrrd | layersplat render - -o - > head.png

Cameras (--cameras FILE): one JSON object per line, for example
  {\"output\": \"a.png\", \"azimuth\": 30, \"elevation\": 20}
  {\"output\": \"b.png\", \"position\": [0, 0, 90], \"focal_point\": [9, 9, 9], \"view_up\": [0, 1, 0], \"perspective\": 30}
  Other fields: roll, center, distance, parallel_scale, size, show and hide with names of surfaces, and the options of light (shadows …).
  The command line sets the fields that a line omits.
  For each picture, one line of JSON is printed.",
    volumes!(),
    transfer_functions!()
);
#[cfg(feature = "viewer")]
pub(super) const VIEW: &str = concat!(
    "\
Examples:
  layersplat view engine_256x256x128_uint8.raw.gz            # opens the browser; Ctrl-C ends it
  layersplat view step_*.vti                                 # a sequence in time, with a slider
  layersplat view head.nii.gz --preset ct-bone --shadows on
  layersplat view big.nrrd --port 8000 --no-browser          # over SSH: prints the command for the tunnel

Safety:
  Only this machine can connect, and only with the token in the printed address. --listen accepts other machines: it needs --token-file
  and --host, and the line is not encrypted. An SSH tunnel is safer. Keys and details: docs/dev/viewer.md.",
    volumes!(),
    transfer_functions!()
);
pub(super) const ROTATE: &str = concat!(
    "\
Examples:
  layersplat rotate --frames 90 --output turn                # turn/frame_0000.png and so on
  layersplat rotate foot_256x256x256_uint8.raw --quality high --perspective 30 -o foot.mp4
  layersplat rotate --keys path.json --output path.gif
  layersplat rotate bold.nii.gz --time --turn 0 -o beats.gif # a picture per step; the camera stands
  layersplat rotate step_*.vti --time --frames 200 -o run.mp4

Key cameras (--keys FILE): a JSON list, for example
  [{\"time\": 0, \"azimuth\": 0}, {\"time\": 2.5, \"azimuth\": 180, \"elevation\": 40}]
  Times are in seconds. The other fields are those of `layersplat render --cameras`.

Time (--time): the steps are the frames of a file, as --frame counts them, or several files, one after the other,
  or those that a .pvd names or that match NAME%d.EXT.
  By default a picture is drawn per step. With --frames or --keys, picture n shows the step nearest to its place between the first and the
  last, so steps repeat or are left out. Instead of --time, keys may have a \"frame\": it is interpolated between keys and rounded.
  All steps must have one size and voxel type. Percentiles, the range of values, the automatic transfer function and the fit are those of
  all steps, or of 16 from the first to the last; --transfer-range and --fit volume depend on no sample.",
    volumes!(),
    transfer_functions!()
);
pub(super) const VIEWS: &str = concat!(
    "\
Examples:
  layersplat views builtin:shepp-logan --output phantom.png
  layersplat views engine_256x256x128_uint8.raw.gz --size 256x256",
    volumes!(),
    transfer_functions!()
);
pub(super) const SLICE: &str = concat!(
    "\
Examples:
  layersplat slice engine_256x256x128_uint8.raw.gz --axis z --at 40 -o slice.png
  layersplat slice head.nii.gz --axis coronal --window 40,400 -o coronal.png
  layersplat slice builtin:hydrogen --plane 15.5,15.5,15.5,1,1,0.5 --transfer viridis --kernel bspline
  layersplat slice tooth_103x94x161_uint8.raw.gz --axis x --at 25% --values -o values.npy",
    volumes!(),
    transfer_functions!()
);
pub(super) const INFO: &str = concat!(
    "\
Examples:
  layersplat info engine_256x256x128_uint8.raw.gz
  layersplat info builtin:hydrogen --json
  layersplat info brain.nii.gz --labels=FreeSurferColorLUT.txt --label 'Left-Thalamus:only'",
    volumes!(),
    transfer_functions!()
);
pub(super) const TRANSFER: &str = concat!(
    "\
Examples:
  layersplat transfer --list
  layersplat transfer engine_256x256x128_uint8.raw.gz --transfer inferno --tent p99,30 -o curve.png
  layersplat transfer builtin:hydrogen --transfer preset.vp -o preset.json",
    volumes!(),
    transfer_functions!()
);
pub(super) const CONVERT: &str = concat!(
    "\
Examples:
  layersplat convert head.nii.gz head.nrrd
  layersplat convert density.npy density.vti --spacing 1,1,2
  layersplat convert - nrrd:- < head.nii.gz | xz > head.nrrd.xz",
    volumes!()
);
pub(super) const DEVICES: &str = "\
Examples:
  layersplat devices
  layersplat devices --check

The check takes about half a minute on PoCL if no kernels are cached, and seconds later. Devices that fail it are not used.";
pub(super) const CACHE: &str = "\
Examples:
  layersplat cache
  layersplat cache --clear";
pub(super) const COMPARE: &str = "\
Examples:
  layersplat compare before.png after.png
  layersplat compare --json a.npy b.npy";
pub(super) const BENCH: &str = concat!(
    "\
Examples:
  layersplat bench engine_256x256x128_uint8.raw.gz --quality draft
  layersplat bench --algorithm raycast --json",
    volumes!(),
    transfer_functions!()
);
pub(super) const TUNE: &str = "\
Examples:
  layersplat tune --device 1";
pub(super) const PAPER: &str = "\
Examples:
  layersplat paper all --out results
  layersplat paper table1 --volumes volumes";
pub(super) const COMPLETIONS: &str = "\
Examples:
  layersplat completions bash > ~/.local/share/bash-completion/completions/layersplat
  layersplat completions zsh > ~/.zfunc/_layersplat";
pub(super) const MAN: &str = "\
Examples:
  layersplat man --output ~/.local/share/man/man1";
