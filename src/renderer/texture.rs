//! Pictures in textures of OpenGL's.

use super::{FrameReport, Renderer};
use crate::camera::Camera;
use crate::device::{Device, SharedTexture};
use crate::error::{Error, GlError};
use crate::gl::GlFunctions;
use crate::image::Background;
use crate::settings::Settings;
use crate::viewport::Viewport;
use std::num::NonZeroU32;

/// A 2D texture of the caller's, of `GL_RGBA8`, that pictures fill: level 0, its first row the picture's top.
///
/// It does not own the texture; drop it before that is deleted, and make it anew when its storage is.
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
    /// For pictures of a device, in a thread that has the texture's context current. Where the device does not
    /// [share with it](Device::open_with_gl), pictures go through the host, which is said once per device.
    ///
    /// # Errors
    /// No context that is current, and what is no 2D texture of `GL_RGBA8`.
    pub fn new(device: &Device, functions: &GlFunctions, name: NonZeroU32) -> Result<Self, Error> {
        let size = functions.size(name)?;
        Ok(Self { functions: functions.clone(), name, size, shared: device.share_texture(name) })
    }

    /// Of the texture, and so of the pictures.
    pub fn size(&self) -> Viewport {
        self.size
    }

    /// Whether pictures go there on the device; else they go through the host.
    pub fn is_shared(&self) -> bool {
        self.shared.is_some()
    }

    /// Refuses a texture that is not any more what was handed over.
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
    /// Renders a finished 8-bit picture that fills a texture, the bits of [`render_rgba8`](Self::render_rgba8): on the device where it
    /// shares the texture, else through the host. When this returns, the picture is there. The thread has the texture's context current,
    /// whose state is as before.
    ///
    /// # Errors
    /// No context that is current; a texture that has changed, or that another device shares; all that [`render`](Self::render) refuses.
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
            // Neither waits for the other by itself, but where both offer extensions for that.
            functions.finish()?;
            shared.receive(device, picture, *size)?;
            device.finish()
        })?;
        Ok(report)
    }
}
