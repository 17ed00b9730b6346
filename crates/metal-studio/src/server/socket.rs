//! One page's connection: frames and how things stand go out, requests come in.

use super::Shop;
use crate::command::Request;
use crate::hub::{Hub, Order, PULSE};
use axum::extract::ws::{Message, Utf8Bytes, WebSocket};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::watch::Receiver;
use tokio::time::{Instant, interval, sleep_until, timeout};

/// How long a page may take to receive something before it is given up.
const PATIENCE: Duration = Duration::from_secs(10);
/// How often a silent page is asked whether it is still there.
const PING_EVERY: Duration = Duration::from_secs(5);
/// How long a page may be silent, pings unanswered, before its wheel is free again.
const SILENCE: Duration = Duration::from_secs(20);
/// Longest request in bytes.
pub const LONGEST: usize = 4096;

/// Serves one page until it goes.
pub async fn serve(mut socket: WebSocket, shop: Arc<Shop>) {
    let hub = &shop.hub;
    let name = hub.enter();
    // Whatever happens, the wheel does not leave with the page.
    let _guest = Guest { hub, name };
    let (frames, statuses) = hub.listen();
    let hello = format!("{{\"hello\":{{\"you\":{name}}}}}");
    if say(&mut socket, hello.into()).await {
        converse(&mut socket, hub, name, (frames, statuses)).await;
    }
}

struct Guest<'a> {
    hub: &'a Hub,
    name: u64,
}

impl Drop for Guest<'_> {
    fn drop(&mut self) {
        self.hub.leave(self.name);
    }
}

type Latest = Receiver<Arc<str>>;

async fn converse(
    socket: &mut WebSocket,
    hub: &Hub,
    name: u64,
    (mut frames, mut statuses): (Latest, Latest),
) {
    statuses.mark_changed();
    frames.mark_changed();
    let mut pings = interval(PING_EVERY);
    let (mut ready, mut heard) = (Instant::now(), Instant::now());
    loop {
        let going = tokio::select! {
            request = socket.recv() => {
                heard = Instant::now();
                match request {
                    Some(Ok(Message::Text(text))) => answer(socket, hub, name, &text).await,
                    Some(Ok(Message::Close(_)) | Err(_)) | None => false,
                    Some(Ok(_)) => true,
                }
            }
            told = statuses.changed() => {
                let text = text_of(&mut statuses);
                told.is_ok() && say(socket, text).await
            }
            shown = async { sleep_until(ready).await; frames.changed().await } => {
                ready = Instant::now() + PULSE;
                let text = text_of(&mut frames);
                shown.is_ok() && say(socket, text).await
            }
            _ = pings.tick() => {
                heard.elapsed() < SILENCE && send(socket, Message::Ping(Vec::new().into())).await
            }
        };
        if !going {
            return;
        }
    }
}

fn text_of(latest: &mut Latest) -> Utf8Bytes {
    Utf8Bytes::from(&**latest.borrow_and_update())
}

/// Sends a text; false if the page is gone or takes too long.
async fn say(socket: &mut WebSocket, text: Utf8Bytes) -> bool {
    text.is_empty() || send(socket, Message::Text(text)).await
}

async fn send(socket: &mut WebSocket, message: Message) -> bool {
    matches!(timeout(PATIENCE, socket.send(message)).await, Ok(Ok(())))
}

async fn answer(socket: &mut WebSocket, hub: &Hub, name: u64, text: &str) -> bool {
    let refuse = |why: String| Utf8Bytes::from(serde_json::json!({ "refused": why }).to_string());
    let request = match serde_json::from_str::<Request>(text) {
        Ok(request) => request,
        Err(error) => return say(socket, refuse(error.to_string())).await,
    };
    match request {
        Request::TakeWheel if !hub.take_wheel(name) => {
            say(socket, refuse("somebody else holds the wheel".to_owned())).await
        }
        Request::TakeWheel => true,
        Request::ReleaseWheel => {
            hub.release_wheel(name);
            true
        }
        Request::Brake => {
            let stopped = hub.brake();
            hub.order(Order::Refresh);
            stopped || say(socket, refuse("there is no body to stop".to_owned())).await
        }
        Request::Recall { decision } => say(socket, past(hub, decision)).await,
        _ if hub.wheel() != name => {
            say(socket, refuse("you are watching: take the wheel first".to_owned())).await
        }
        request => {
            hub.order(Order::Ask(request)) || say(socket, refuse("the studio is busy".to_owned())).await
        }
    }
}

fn past(hub: &Hub, decision: u64) -> Utf8Bytes {
    let frame = hub.recall(decision);
    let text = frame.and_then(|frame| serde_json::to_string(&*frame).ok());
    format!("{{\"past\":{}}}", text.as_deref().unwrap_or("null")).into()
}
