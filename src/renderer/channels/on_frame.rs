//! Fields at the voxels of the frame, for splats and for sweeps of light, which take voxels one by one.

use super::super::classification::{Classification, PreparationKernels};
use super::super::store::Version;
use super::classified::ClassifiedField;
use crate::device::Device;
use crate::error::Error;

/// The visible fields of a scene, resampled on demand.
#[derive(Default)]
pub(super) struct OnFrame(Vec<Resampled>);

/// A field at the voxels of the frame.
struct Resampled {
    source: Version,
    ends: bool,
    field: ClassifiedField,
}

impl OnFrame {
    /// Copies for rehearsals, with empty caches.
    pub fn for_rehearsal(&self, dimmed: Option<bool>) -> Self {
        let copy = |kept: &Resampled| Resampled { field: kept.field.for_rehearsal(dimmed), ..*kept };
        Self(self.0.iter().map(copy).collect())
    }

    /// Resamples fields that have changed, and gives all the classification of their sources.
    ///
    /// # Errors
    /// If there is not enough memory.
    pub fn update<'a>(
        &mut self,
        fields: impl Iterator<Item = &'a ClassifiedField>,
        kernels: &mut PreparationKernels,
        device: &Device,
    ) -> Result<(), Error> {
        let mut kept = std::mem::take(&mut self.0);
        for field in fields {
            let known = kept.iter().position(|kept| kept.is_of(field)).map(|n| kept.swap_remove(n));
            self.0.push(match known {
                Some(mut known) => {
                    known.classify_as(field);
                    known
                }
                None => Resampled::new(field, kernels, device)?,
            });
        }
        Ok(())
    }

    pub fn fields(&mut self) -> impl Iterator<Item = &mut ClassifiedField> {
        self.0.iter_mut().map(|resampled| &mut resampled.field)
    }
}

/// Whether the background of a field is visible, which ends with its own grid then.
fn ends(field: &ClassifiedField) -> bool {
    field.classification.transfer_function().opacity(field.field.description().background()) > 0.0
}

impl Resampled {
    fn new(source: &ClassifiedField, kernels: &mut PreparationKernels, device: &Device) -> Result<Self, Error> {
        let ends = ends(source);
        let field = source.field.on_frame(&mut kernels.field, device, ends)?;
        let classification = Classification::new(source.classification.transfer_function(), &field);
        let field = ClassifiedField { field, classification, look: source.look, colors: None };
        let mut resampled = Self { source: source.field.version(), ends, field };
        resampled.classify_as(source);
        Ok(resampled)
    }

    /// Takes over the classification and the colours of the source, whose voxels keep their places.
    fn classify_as(&mut self, source: &ClassifiedField) {
        self.field.classify_as(source);
        self.field.colors = source.colors.as_ref().map(|colors| colors.for_field(source.field.of_frame()));
    }

    fn is_of(&self, source: &ClassifiedField) -> bool {
        let same_grid = self.field.field.description().grid() == source.field.description().grid();
        same_grid && self.source == source.field.version() && self.ends == ends(source)
    }
}
