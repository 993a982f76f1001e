//! The server: connections, routes and the headers of every answer.

use super::access::{Access, Refusal};
use super::assets::{ASSETS, Asset, PAGE};
use super::first::Opening;
use super::host::Host;
use super::opening;
use super::places::{Place, Places};
use super::requests::MAX_MESSAGE;
use super::scene::SharedScene;
use super::served::Served;
use super::socket;
use crate::error::Error;
use crate::memory;
use axum::Router;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{Extension, Request, State};
use axum::http::header::{CONTENT_TYPE, SET_COOKIE};
use axum::http::{HeaderValue, Method, StatusCode, Uri};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use std::future::Future;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::net::{TcpListener, TcpStream};
use tokio::runtime::{Builder, Runtime};
use tokio::sync::watch;

/// Time until a connection has sent the headers of a request.
const HEADER_TIME: Duration = Duration::from_secs(10);
/// Most bytes of the headers of a request.
const HEADER_BYTES: usize = 32 << 10;
/// Pause after the system refused a connection, for example because too many files are open.
const PAUSE: Duration = Duration::from_millis(100);
/// Time for drawing threads to end after the server has.
const LONGEST_END: Duration = Duration::from_secs(3);
/// Path of the WebSocket.
const SOCKET: &str = "/socket";
/// Path that dropped files are sent to.
const DROP: &str = "/drop";

/// Headers of every answer. The page may load its own files, and show pictures that it received.
const HEADERS: [(&str, &str); 7] = [
    (
        "content-security-policy",
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'; base-uri 'none'; \
         form-action 'none'; frame-ancestors 'none'",
    ),
    ("x-content-type-options", "nosniff"),
    ("referrer-policy", "no-referrer"),
    ("cache-control", "no-store"),
    ("cross-origin-opener-policy", "same-origin"),
    ("cross-origin-resource-policy", "same-origin"),
    ("x-frame-options", "DENY"),
];

/// The page that the right token is answered with. It goes on to the page without the token: a redirect would be followed without the cookie
/// where another site's link led here. Both replace the address in the history; the script keeps the view after `#`.
const LET_IN: &str = "<!doctype html><meta charset=utf-8><script src=/enter.js></script>\
                      <noscript><meta http-equiv=refresh content=\"0;url=/\"></noscript><title>layersplat</title>\
                      <link rel=icon href=/icon.svg><a href=\"/\">Continue to the viewer</a>";
/// The script of that page.
const ENTER: Asset =
    Asset { path: "/enter.js", kind: "text/javascript; charset=utf-8", text: "location.replace(`/${location.hash}`);" };

/// Ends a server from another thread. Clones end the same one.
#[derive(Clone, Debug)]
pub struct Stop(watch::Sender<bool>);

impl Default for Stop {
    fn default() -> Self {
        Self(watch::Sender::new(false))
    }
}

impl Stop {
    /// Ends the server, now or as soon as it begins.
    pub fn stop(&self) {
        self.0.send_replace(true);
    }

    async fn stopped(&self) {
        // The sender is this one: it is not dropped before.
        let _ = self.0.subscribe().wait_for(|stopped| *stopped).await;
    }
}

/// A server that has a volume on the device and is ready to answer.
pub struct Server {
    runtime: Runtime,
    listener: std::net::TcpListener,
    served: Arc<Served>,
}

impl Server {
    /// Uploads the volume. `listener` is bound already, so that its address can be printed.
    ///
    /// # Errors
    /// Insufficient memory of the device, and failures of the system.
    pub fn new(opening: Opening, host: Box<dyn Host>, access: Access, listener: std::net::TcpListener) -> Result<Self, Error> {
        memory::return_large_blocks();
        let failed = |e| Error::read(Path::new("the viewer's address"), e);
        let runtime = Builder::new_current_thread().enable_all().build().map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        Ok(Self { runtime, listener, served: Arc::new(Served::new(access, SharedScene::new(opening, host)?)) })
    }

    /// Answers requests until `stop`.
    ///
    /// # Errors
    /// Failures of the system.
    pub fn run(self, stop: &Stop) -> Result<(), Error> {
        let Self { runtime, listener, served } = self;
        let scenes = served.scenes.clone();
        let ended: std::io::Result<()> = runtime.block_on(async {
            run(TcpListener::from_std(listener)?, served, stop.stopped()).await;
            Ok(())
        });
        // Ends all sessions, which cancel the frames of their threads. Work aside is not waited for.
        runtime.shutdown_background();
        let since = Instant::now();
        while scenes.are_in_use() && since.elapsed() < LONGEST_END {
            std::thread::sleep(Duration::from_millis(5));
        }
        ended.map_err(|e| Error::read(Path::new("the viewer's address"), e))
    }
}

/// Serves pages until `stop`.
async fn run(listener: TcpListener, served: Arc<Served>, stop: impl Future<Output = ()>) {
    let routes = router(served);
    let places = Arc::new(Places::default());
    tokio::pin!(stop);
    loop {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            () = &mut stop => return,
        };
        let Ok((stream, _)) = accepted else {
            tokio::time::sleep(PAUSE).await;
            continue;
        };
        let Some((place, ended)) = places.take() else { continue };
        // The guard tells the place that a request came with a cookie or a token.
        let routes = routes.clone().layer(Extension(place.clone()));
        tokio::spawn(async move {
            let _place = place;
            tokio::select! {
                served = connection(stream, routes) => if let Err(error) = served {
                    tracing::debug!("a connection ended: {error}");
                },
                () = ended.notified() => tracing::debug!("a connection without a cookie made place for another"),
            }
        });
    }
}

async fn connection(stream: TcpStream, routes: Router) -> Result<(), hyper::Error> {
    // Pictures and answers are written at once.
    let _ = stream.set_nodelay(true);
    let mut protocol = http1::Builder::new();
    protocol.timer(TokioTimer::new()).header_read_timeout(HEADER_TIME).max_buf_size(HEADER_BYTES);
    protocol.serve_connection(TokioIo::new(stream), TowerToHyperService::new(routes)).with_upgrades().await
}

fn router(served: Arc<Served>) -> Router {
    Router::new()
        .route(SOCKET, get(socket))
        .route(DROP, post(opening::receive))
        .fallback(file)
        .layer(middleware::from_fn_with_state(served.clone(), guard))
        .with_state(served)
}

/// Checks every request before anything else, and adds the headers of every answer.
async fn guard(State(served): State<Arc<Served>>, request: Request, next: Next) -> Response {
    let admitted = admit(&served.access, &request);
    if let (Ok(_), Some(place)) = (&admitted, request.extensions().get::<Arc<Place>>()) {
        place.admit();
    }
    let mut response = match admitted {
        Ok(Admitted::ByCookie) => next.run(request).await,
        Ok(Admitted::ByToken) => let_in(&served.access),
        Err(refusal) => refuse(refusal),
    };
    for (name, value) in HEADERS {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    response
}

enum Admitted {
    ByCookie,
    ByToken,
}

fn admit(access: &Access, request: &Request) -> Result<Admitted, Refusal> {
    let requires_origin = [SOCKET, DROP].contains(&request.uri().path());
    access.check_site(request.headers(), requires_origin)?;
    match token(request.uri()) {
        Some(token) if request.uri().path() == "/" => access.check_token(token).map(|()| Admitted::ByToken),
        _ => access.check_cookie(request.headers()).map(|()| Admitted::ByCookie),
    }
}

/// The token of an address `/?token=…`.
fn token(uri: &Uri) -> Option<&str> {
    uri.query()?.split('&').find_map(|pair| pair.strip_prefix("token="))
}

fn let_in(access: &Access) -> Response {
    let mut response = ([(CONTENT_TYPE, PAGE.kind)], LET_IN).into_response();
    let cookie = HeaderValue::from_str(&access.set_cookie()).expect("a cookie is plain text");
    response.headers_mut().insert(SET_COOKIE, cookie);
    response
}

fn refuse(refusal: Refusal) -> Response {
    let status = if refusal == Refusal::Host { StatusCode::MISDIRECTED_REQUEST } else { StatusCode::FORBIDDEN };
    (status, refusal.sentence()).into_response()
}

async fn file(method: Method, uri: Uri) -> Response {
    if method != Method::GET && method != Method::HEAD {
        return StatusCode::METHOD_NOT_ALLOWED.into_response();
    }
    let answer = |asset: &Asset| ([(CONTENT_TYPE, asset.kind)], asset.text).into_response();
    match uri.path() {
        "/" => answer(&PAGE),
        path => ASSETS
            .iter()
            .chain([&ENTER])
            .find(|asset| asset.path == path)
            .map_or_else(|| StatusCode::NOT_FOUND.into_response(), answer),
    }
}

async fn socket(State(served): State<Arc<Served>>, upgrade: WebSocketUpgrade) -> Response {
    upgrade.max_message_size(MAX_MESSAGE).max_frame_size(MAX_MESSAGE).on_upgrade(move |socket| socket::serve(socket, served))
}
