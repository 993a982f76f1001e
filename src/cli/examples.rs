//! What `--help` shows as examples.

pub(super) const RENDER: &str = "\
Examples:
  layersplat render                                          a built-in volume
  layersplat render engine_256x256x128_uint8.raw.gz --azimuth 30 --elevation 20 -o engine.png
  layersplat render head.raw --dims 256x256x109 --type uint16 --endian big --spacing 1,1,1.5
  layersplat render builtin:hydrogen --blend maximum --transfer viridis --size 1024x768
  layersplat render builtin:shepp-logan --legend --axes --samples 2 -o phantom.jpg
  layersplat render builtin:hydrogen --cameras views.ndjson  a picture per line of the file
  curl -s https://host/head.nrrd | layersplat render - -o - > head.png";
pub(super) const ROTATE: &str = "\
Examples:
  layersplat rotate --frames 90 --output turn                turn/frame_0000.png and so on
  layersplat rotate foot_256x256x256_uint8.raw --quality high --perspective 30 -o foot.mp4
  layersplat rotate --keys way.json --output way.gif";
pub(super) const INFO: &str = "\
Examples:
  layersplat info engine_256x256x128_uint8.raw.gz
  layersplat info builtin:hydrogen --json";
pub(super) const DEVICES: &str = "\
Examples:
  layersplat devices
  layersplat devices --check                                 draw small pictures on each, and compare them with what is right";
pub(super) const COMPARE: &str = "\
Examples:
  layersplat compare before.png after.png
  layersplat compare --json a.npy b.npy";
pub(super) const BENCH: &str = "\
Examples:
  layersplat bench engine_256x256x128_uint8.raw.gz --quality draft
  layersplat bench --algorithm raycast --json";
pub(super) const TUNE: &str = "\
Examples:
  layersplat tune --device 1";
pub(super) const PAPER: &str = "\
Examples:
  layersplat paper";
pub(super) const COMPLETIONS: &str = "\
Examples:
  layersplat completions bash > ~/.local/share/bash-completion/completions/layersplat
  layersplat completions zsh > ~/.zfunc/_layersplat";
pub(super) const MAN: &str = "\
Examples:
  layersplat man --output ~/.local/share/man/man1";
pub(super) const VIEWS: &str = "\
Examples:
  layersplat views builtin:shepp-logan --output phantom.png
  layersplat views engine_256x256x128_uint8.raw.gz --size 256x256";
pub(super) const TRANSFER: &str = "\
Examples:
  layersplat transfer --list
  layersplat transfer engine_256x256x128_uint8.raw.gz --transfer inferno --tent p99,30 -o curve.png
  layersplat transfer builtin:hydrogen --transfer preset.vp -o preset.json";
pub(super) const CONVERT: &str = "\
Examples:
  layersplat convert head.nii.gz head.nrrd
  layersplat convert density.npy density.vti --spacing 1,1,2
  layersplat convert - nrrd:- < head.nii.gz | xz > head.nrrd.xz";
