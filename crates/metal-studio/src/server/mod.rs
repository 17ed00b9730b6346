//! The server: a page, a few drawings, one WebSocket. It reads no file and writes none.

mod assets;
mod guard;
mod socket;

pub use guard::{Guard, Refusal};

use crate::drawings::{self, Studio as Drawable};
use crate::hub::{Hub, Order, PULSE};
use crate::stage::{Stage, StageError};
use crate::subject::Subject;
use axum::Router;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{Path, Query, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Redirect, Response};
use axum::routing::get;
use std::collections::BTreeMap;
use std::net::{IpAddr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::mpsc::sync_channel;

/// Requests that may wait for the stage.
const WAITING: usize = 64;
/// Most pages at once.
const MOST_PAGES: usize = 16;

/// Where the studio listens.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Address; loopback unless somebody insists.
    pub address: IpAddr,
    /// Port; 0 lets the system choose.
    pub port: u16,
    /// The one number all randomness of the stage comes from.
    pub seed: u64,
    /// Whether the token is kept in the run folder, so that open pages find a studio that was started again.
    pub keep_token: bool,
}

/// Why the studio does not open.
#[derive(Debug, thiserror::Error)]
pub enum StudioError {
    /// The address.
    #[error("cannot listen on {address}: {source}")]
    Listen {
        /// Where.
        address: SocketAddr,
        /// Why not.
        source: std::io::Error,
    },
    /// The token.
    #[error("token: {0}")]
    Token(#[from] guard::TokenError),
    /// The stage.
    #[error(transparent)]
    Stage(#[from] StageError),
    /// A thread or the network.
    #[error(transparent)]
    Io(#[from] std::io::Error),
}

/// A studio that listens; [`Studio::serve`] lets it work.
pub struct Studio {
    listener: TcpListener,
    address: SocketAddr,
    token: String,
    stage: Stage,
    orders: std::sync::mpsc::Receiver<Order>,
    shop: Arc<Shop>,
}

/// What every request is served from.
pub(crate) struct Shop {
    pub(crate) hub: Arc<Hub>,
    drawable: Drawable,
    world: String,
    theme: String,
}

impl Studio {
    /// Opens the studio on `subject`.
    ///
    /// # Errors
    /// If the address is taken or the first driver's mind cannot be read.
    pub fn open(mut subject: Subject, options: Options) -> Result<Self, StudioError> {
        let wanted = SocketAddr::new(options.address, options.port);
        let listen = |e| StudioError::Listen { address: wanted, source: e };
        let listener = TcpListener::bind(wanted).map_err(listen)?;
        listener.set_nonblocking(true)?;
        let (sender, orders) = sync_channel(WAITING);
        let hub = Arc::new(Hub::new(sender));
        let token = if options.keep_token { guard::kept(&subject.store)? } else { guard::token()? };
        let (plan, results) = (subject.plan.clone(), subject.results.take());
        let stage = Stage::new(hub.clone(), subject, options.seed)?;
        let roads = stage.roads();
        let drawable = Drawable { plan, hub: hub.clone(), training: stage.shared(), roads, results };
        let world = drawings::world_json(&drawable);
        let theme = metal_lab::figures::chart::variables(":root");
        let shop = Arc::new(Shop { hub, drawable, world, theme });
        let address = listener.local_addr()?;
        Ok(Self { listener, address, token, stage, orders, shop })
    }

    /// The address to open in a browser, token and all.
    #[must_use]
    pub fn url(&self) -> String {
        format!("http://{}/{}/", self.address, self.token)
    }

    /// Something that ends the studio when it is called.
    pub fn quitter(&self) -> impl Fn() + Send + 'static {
        let hub = self.shop.hub.clone();
        move || {
            hub.order(Order::Quit);
        }
    }

    /// Works until somebody calls the quitter.
    ///
    /// # Errors
    /// If the system gives no thread or the network fails.
    pub fn serve(self) -> Result<(), StudioError> {
        let Self { listener, address, token, stage, orders, shop } = self;
        let (done, finished) = tokio::sync::oneshot::channel::<()>();
        let worker = std::thread::Builder::new().name("stage".to_owned()).spawn(move || {
            stage.run(&orders);
            let _ = done.send(());
        })?;
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let served = runtime.block_on(async {
            let listener = tokio::net::TcpListener::from_std(listener)?;
            let router = router(&shop, Guard::new(&token, address.ip()));
            tokio::select! {
                served = axum::serve(listener, router) => served,
                () = pulse(&shop.hub) => Ok(()),
                _ = finished => Ok(()),
            }
        });
        shop.hub.order(Order::Quit);
        let _ = worker.join();
        Ok(served?)
    }
}

/// Thirty times a second somebody wants to see something, if there is somebody.
async fn pulse(hub: &Hub) {
    let mut ticks = tokio::time::interval(PULSE);
    ticks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Skip);
    loop {
        ticks.tick().await;
        hub.want();
    }
}

fn router(shop: &Arc<Shop>, guard: Guard) -> Router {
    Router::new()
        .route(
            "/{token}",
            get(|Path(token): Path<String>| async move { Redirect::to(&format!("/{token}/")) }),
        )
        .route("/{token}/", get(|| async { assets::page() }))
        .route("/{token}/live", get(live))
        .route("/{token}/world.json", get(world))
        .route("/{token}/theme.css", get(theme))
        .route("/{token}/draw/{name}", get(draw))
        .route(
            "/{token}/{file}",
            get(|Path((_, file)): Path<(String, String)>| async move { assets::file(&file) }),
        )
        .fallback(|| async { StatusCode::NOT_FOUND })
        .with_state(shop.clone())
        .layer(axum::middleware::from_fn_with_state(guard, guard::watch))
}

async fn live(State(shop): State<Arc<Shop>>, upgrade: WebSocketUpgrade) -> Response {
    if shop.hub.pages() >= MOST_PAGES {
        return (StatusCode::SERVICE_UNAVAILABLE, "too many pages are open\n").into_response();
    }
    let upgrade = upgrade.max_message_size(socket::LONGEST).max_frame_size(socket::LONGEST);
    upgrade.on_upgrade(move |socket| socket::serve(socket, shop))
}

async fn world(State(shop): State<Arc<Shop>>) -> Response {
    ([(header::CONTENT_TYPE, "application/json")], shop.world.clone()).into_response()
}

async fn theme(State(shop): State<Arc<Shop>>) -> Response {
    ([(header::CONTENT_TYPE, "text/css; charset=utf-8")], shop.theme.clone()).into_response()
}

async fn draw(
    State(shop): State<Arc<Shop>>,
    Path((_, name)): Path<(String, String)>,
    Query(wishes): Query<BTreeMap<String, String>>,
) -> Response {
    match drawings::draw(&shop.drawable, &name, &wishes) {
        Some(svg) => ([(header::CONTENT_TYPE, "image/svg+xml; charset=utf-8")], svg).into_response(),
        None => (StatusCode::NOT_FOUND, "there is nothing to draw yet\n").into_response(),
    }
}
