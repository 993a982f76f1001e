//! Pictures in OpenGL textures.

use super::{FrameReport, Renderer};
use crate::camera::Camera;
use crate::device::{Device, SharedTexture};
use crate::error::{Error, GlError};
use crate::gl::GlFunctions;
use crate::image::Background;
use crate::settings::Settings;
use crate::viewport::Viewport;
use std::num::NonZeroU32;

/// The caller's 2D texture of format `GL_RGBA8` that receives pictures: level 0, first row at the top of the picture.
///
/// This does not own the texture. Drop it before the texture is deleted, and create it anew when the storage of the texture is.
///
/// ```no_run
/// # use layersplat::{Background, Camera, Device, DeviceChoice, Error, Settings, TransferFunction, Volume};
/// # fn f(
/// #     find: impl FnMut(&std::ffi::CStr) -> *const std::ffi::c_void,
/// #     (volume, transfer, camera, name): (&Volume, &TransferFunction, &Camera, std::num::NonZeroU32),
/// # ) -> Result<(), Error> {
/// use layersplat::{Renderer, gl::GlFunctions, renderer::GlTexture};
///
/// // SAFETY: `find` is the loader of the context, which is current.
/// let functions = unsafe { GlFunctions::load(find) }?;
/// let device = Device::open_with_gl(&DeviceChoice::Default)?;
/// let mut renderer = Renderer::new(&device, volume, transfer)?;
/// let texture = GlTexture::new(&device, &functions, name)?;
/// renderer.render_into_texture(camera, &Settings::default(), Background::Transparent, &texture)?;
/// # Ok(())
/// # }
/// ```
pub struct GlTexture {
    functions: GlFunctions,
    name: NonZeroU32,
    size: Viewport,
    shared: Option<SharedTexture>,
}

impl GlTexture {
    /// Registers a texture for pictures of a device. The texture's context must be current in the calling thread. If the device
    /// does not [share with the context](Device::open_with_gl), pictures go through the host; this is logged once per device.
    ///
    /// # Errors
    /// If no context is current, or if the name is not a 2D texture of format `GL_RGBA8`.
    pub fn new(device: &Device, functions: &GlFunctions, name: NonZeroU32) -> Result<Self, Error> {
        let size = functions.size(name)?;
        Ok(Self { functions: functions.clone(), name, size, shared: device.share_texture(name) })
    }

    /// Size of the texture and of its pictures.
    pub fn size(&self) -> Viewport {
        self.size
    }

    /// Whether pictures are written to the texture on the device; otherwise they go through the host.
    pub fn is_shared(&self) -> bool {
        self.shared.is_some()
    }

    /// Rejects a texture whose size has changed.
    fn check(&self) -> Result<(), Error> {
        let size = self.functions.size(self.name)?;
        if size == self.size {
            return Ok(());
        }
        let [expected, found] = [self.size, size].map(|size| format!("{}x{}", size.width, size.height));
        Err(GlError::Changed { texture: self.name, expected, found }.into())
    }
}

impl Renderer {
    /// Renders a finished 8-bit picture into a texture, identical to that of [`render_rgba8`](Self::render_rgba8). It is written
    /// on the device if that shares the texture, otherwise through the host. The picture is complete when this returns. The
    /// texture's context must be current in the calling thread; its state is preserved.
    ///
    /// # Errors
    /// If no context is current, if the texture has changed or is shared by another device, and everything that
    /// [`render`](Self::render) rejects.
    pub fn render_into_texture(
        &mut self,
        camera: &Camera,
        settings: &Settings,
        background: Background,
        texture: &GlTexture,
    ) -> Result<FrameReport, Error> {
        texture.check()?;
        let GlTexture { functions, name, size, .. } = texture;
        let Some(shared) = &texture.shared else {
            let (picture, report) = self.render_rgba8(camera, *size, settings, background)?;
            functions.write(*name, *size, &picture)?;
            return Ok(report);
        };
        let (_, report) = self.render_displayed(camera, *size, settings, background, |device, picture| {
            // OpenGL and OpenCL wait for each other only with extensions that both must support.
            functions.finish()?;
            shared.receive(device, picture, *size)?;
            device.finish()
        })?;
        Ok(report)
    }
}
