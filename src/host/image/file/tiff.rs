//! TIFF.

use super::{Samples, failed};
use crate::error::Error;
use crate::files::write_whole;
use crate::viewport::Viewport;
use std::io::Cursor;
use std::num::NonZeroU16;
use std::path::Path;
use tiff::TiffResult;
use tiff::encoder::colortype::{ColorType, RGB8, RGB16, RGBA8, RGBA16};
use tiff::encoder::{Compression, Predictor, Rational, TiffEncoder, TiffValue};
use tiff::tags::{ExtraSamples, ResolutionUnit, Tag};

/// Writes RGBA with straight alpha, or RGB without alpha.
pub(super) fn write(path: &Path, viewport: Viewport, samples: &Samples, dpi: Option<NonZeroU16>) -> Result<(), Error> {
    let encoded = match samples {
        Samples::Rgb8(values) => encoded::<RGB8>(viewport, values, dpi),
        Samples::Rgba8(values) => encoded::<RGBA8>(viewport, values, dpi),
        Samples::Rgb16(values) => encoded::<RGB16>(viewport, values, dpi),
        Samples::Rgba16(values) => encoded::<RGBA16>(viewport, values, dpi),
    };
    let encoded = encoded.map_err(|e| Error::write(path, failed(e)))?;
    write_whole(path, |out| out.write_all(&encoded))
}

/// The bytes of a file. The encoder seeks back to write its directory.
fn encoded<C: ColorType>(viewport: Viewport, values: &[C::Inner], dpi: Option<NonZeroU16>) -> TiffResult<Vec<u8>>
where
    [C::Inner]: TiffValue,
{
    let mut file = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut file)?.with_compression(Compression::Lzw).with_predictor(Predictor::Horizontal);
    let mut image = encoder.new_image::<C>(viewport.width, viewport.height)?;
    if C::BITS_PER_SAMPLE.len() == 4 {
        image.encoder().write_tag(Tag::ExtraSamples, ExtraSamples::UnassociatedAlpha.to_u16())?;
    }
    if let Some(dpi) = dpi {
        image.resolution(ResolutionUnit::Inch, Rational { n: dpi.get().into(), d: 1 });
    }
    image.write_data(values)?;
    Ok(file.into_inner())
}
