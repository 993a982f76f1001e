//! VTK image data: XML (`.vti`, with the feature `vtk`) and legacy structured points (`.vtk`).

pub(super) mod arrays;
#[cfg(feature = "vtk")]
mod blocks;
#[cfg(feature = "vtk")]
mod collection;
#[cfg(feature = "vtk")]
mod encoded;
mod legacy;
#[cfg(feature = "vtk")]
mod pieces;
#[cfg(feature = "vtk")]
mod xml;

#[cfg(feature = "vtk")]
pub(super) use collection::steps as collected;
pub(super) use legacy::Legacy;
#[cfg(feature = "vtk")]
pub(super) use xml::Xml;
