//! VTK files: XML (`.vti`, `.vtp`, with the feature `vtk`) and legacy ones (`.vtk`). Readers of surfaces use the parsers, too.

pub(crate) mod arrays;
#[cfg(feature = "vtk")]
mod blocks;
#[cfg(feature = "vtk")]
mod collection;
#[cfg(feature = "vtk")]
pub(crate) mod document;
#[cfg(feature = "vtk")]
pub(crate) mod encoded;
mod legacy;
#[cfg(feature = "vtk")]
mod pieces;
pub(crate) mod scanner;
#[cfg(feature = "vtk")]
mod xml;

#[cfg(feature = "vtk")]
pub(super) use collection::steps as collected;
pub(super) use legacy::Legacy;
#[cfg(feature = "vtk")]
pub(super) use xml::Xml;
