//! Files of other programs (scripts in make) are read correctly; damaged files are rejected.

mod anatomy;
mod channels;
mod damage;
#[cfg(feature = "dicom")]
mod dicom_encodings;
#[cfg(feature = "dicom")]
mod dicom_segments;
mod files;
mod labels;
mod magnitudes;
mod nrrd_axes;
mod refused;
#[cfg(feature = "npz")]
mod refused_archives;
mod refused_pictures;
mod slices;
mod surfaces;
#[cfg(feature = "tiff")]
mod tiff_pages;
mod unusual;
mod vectors;
mod written;
