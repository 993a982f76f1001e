//! Opening the browser.

use crate::files::Scratch;
use std::io::Write;
use std::process::{Command, Stdio};

/// The page that leads the browser to the viewer; removed when this is dropped.
pub(super) struct Opened {
    _folder: Scratch,
}

/// Opens an address in the user's browser. `None` where there is no screen or no browser; the address is printed in any case.
///
/// The browser is started with a file that only the user can read, because other users can see the arguments of programs, and the address has
/// the token.
pub(super) fn in_browser(address: &str) -> Option<Opened> {
    if !has_screen() {
        return None;
    }
    /// The file's name.
    const NAME: &str = "layersplat.html";
    // It has the token, and is removed even after a kill.
    let folder = Scratch::new().ok()?;
    let mut file = folder.create(NAME).ok()?;
    let page = format!(
        "<!doctype html><meta charset=utf-8><meta name=referrer content=no-referrer>\
         <meta http-equiv=refresh content=\"0;url={address}\"><title>layersplat</title><a href=\"{address}\">Open the viewer</a>"
    );
    file.write_all(page.as_bytes()).and_then(|()| file.flush()).ok()?;
    let program = match std::env::consts::OS {
        "macos" => "open",
        "windows" => "explorer",
        _ => "xdg-open",
    };
    let mut command = Command::new(program);
    command.arg(folder.path().join(NAME)).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = command.spawn().ok()?;
    std::thread::spawn(move || child.wait());
    Some(Opened { _folder: folder })
}

fn has_screen() -> bool {
    let is_set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    cfg!(any(target_os = "macos", windows)) || is_set("DISPLAY") || is_set("WAYLAND_DISPLAY")
}

/// The name of this machine for the command of an SSH tunnel, as the user called it if that is known.
pub(super) fn this_machine() -> String {
    let user = std::env::var("USER").ok().filter(|user| !user.is_empty());
    // SSH_CONNECTION: the client's address and port, then the server's.
    let server = std::env::var("SSH_CONNECTION").ok().and_then(|text| text.split(' ').nth(2).map(str::to_owned));
    let host = server.unwrap_or_else(|| "HOST".into());
    user.map_or(host.clone(), |user| format!("{user}@{host}"))
}
