//! The address on which the viewer listens, and how it is reported.

use super::open::{self, Opened};
use crate::error::Error;
use crate::viewer::Access;
use std::io::ErrorKind;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, TcpListener};
use std::path::{Path, PathBuf};

/// Whether it names a machine as `Host` does, without a port: a name, an IPv4 address, or an IPv6 address in brackets.
fn is_name(name: &str) -> bool {
    if let Some(address) = name.strip_prefix('[').and_then(|name| name.strip_suffix(']')) {
        return address.parse::<Ipv6Addr>().is_ok();
    }
    !name.is_empty() && name.len() <= 253 && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"-._".contains(&byte))
}

/// Address and browser.
#[derive(clap::Args)]
#[command(next_help_heading = "Viewer")]
pub(super) struct AddressOptions {
    /// Port to listen on [default: a free one]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    port: u16,
    /// Print the address, but do not open it
    #[arg(long)]
    no_browser: bool,
    /// Address to listen on. Other than loopback addresses need --token-file and --host; the line is not encrypted
    #[arg(long, value_name = "ADDR", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    listen: IpAddr,
    /// Another name by which browsers may call this machine, without a port. Repeatable
    #[arg(long, value_name = "NAME")]
    host: Vec<String>,
    /// File with a token of 32 or more characters [default: a random token]
    #[arg(long, value_name = "FILE")]
    token_file: Option<PathBuf>,
}

/// Who may come in, and the address to print.
pub(super) struct Admission {
    pub access: Access,
    pub address: Address,
}

/// Where the page is.
pub(super) struct Address {
    page: String,
    token: String,
    port: u16,
}

impl AddressOptions {
    fn is_local(&self) -> bool {
        self.listen.is_loopback()
    }

    /// Checks the options.
    pub fn check(&self) -> Result<(), Error> {
        let refuse = |problem: &str| Err(Error::Settings { field: "listen", problem: problem.into() });
        if !self.is_local() && self.token_file.is_none() {
            return refuse("other machines could read a printed token: add --token-file FILE, or use an SSH tunnel");
        }
        if !self.is_local() && self.host.is_empty() {
            return refuse("browsers of other machines need a name of this one: add --host NAME, or use an SSH tunnel");
        }
        match self.host.iter().find(|name| !is_name(name.as_str())) {
            Some(name) => {
                let problem = format!(
                    "{name} is no name of a machine: omit scheme, port and path, and write an IPv6 address in brackets, e.g. [fe80::1]"
                );
                Err(Error::Settings { field: "host", problem })
            }
            None => Ok(()),
        }
    }

    /// The address as browsers write it.
    fn listened(&self) -> String {
        match self.listen {
            IpAddr::V4(address) => address.to_string(),
            IpAddr::V6(address) => format!("[{address}]"),
        }
    }

    /// Opens the port.
    pub fn bind(&self) -> Result<TcpListener, Error> {
        let address = SocketAddr::new(self.listen, self.port);
        TcpListener::bind(address).map_err(|e| {
            let (field, problem) = match e.kind() {
                ErrorKind::AddrInUse => {
                    ("port", format!("another program listens on {address}: choose another --port N, or omit it for a free one"))
                }
                ErrorKind::PermissionDenied => {
                    ("port", format!("{address} is not permitted to this user: choose --port 1024 or higher, or omit it"))
                }
                _ => (
                    "listen",
                    format!("{address} cannot be listened on ({e}): choose an address of this machine with --listen ADDR"),
                ),
            };
            Error::Settings { field, problem }
        })
    }

    /// The secrets of this run, and its address.
    pub fn admission(&self, listener: &TcpListener) -> Result<Admission, Error> {
        let mut access = Access::new()?;
        if let Some(file) = &self.token_file {
            access = access.with_token_file(file)?;
        }
        for name in &self.host {
            access = access.with_name(name);
        }
        if self.is_local() {
            // Any address of the loopback interface, such as 127.0.0.2.
            access = access.with_name(&self.listened());
        }
        let port = listener.local_addr().map_err(|e| Error::read(Path::new("the viewer's address"), e))?.port();
        let host = match (self.is_local(), self.host.first()) {
            (false, Some(name)) => name.clone(),
            _ => self.listened(),
        };
        let address = Address { page: format!("http://{host}:{port}/"), token: access.token().to_owned(), port };
        Ok(Admission { access, address })
    }

    /// Prints the address as one line on standard output, and opens it unless that is not wanted. The token of a file is not printed.
    pub fn announce(&self, address: &Address) -> Result<Option<Opened>, Error> {
        let Address { page, token, port } = address;
        let with_token = format!("{page}?token={token}");
        if !self.is_local() {
            eprintln!("layersplat: other machines can connect, and the line is NOT encrypted; an SSH tunnel is");
        }
        let is_remote = std::env::var_os("SSH_CONNECTION").is_some();
        if is_remote && self.is_local() {
            eprintln!("layersplat: on your own machine run  ssh -L {port}:{}:{port} {}", self.listened(), open::this_machine());
        }
        let printed = if self.token_file.is_some() { format!("{page}?token=") } else { with_token.clone() };
        if self.token_file.is_some() {
            eprintln!("layersplat: complete the address with the token of the file");
        }
        crate::cli::report(false, &(), || printed)?;
        if self.no_browser || is_remote { Ok(None) } else { Ok(open::in_browser(&with_token)) }
    }
}
