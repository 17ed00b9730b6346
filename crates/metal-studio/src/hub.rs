//! Where the stage, the training run and the pages meet. Whoever publishes never waits: a page that is slow misses
//! frames, nobody else notices.

use crate::command::Request;
use crate::frame::Frame;
use metal_robots::Emergency;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{SyncSender, TrySendError};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::sync::watch;

/// How often a frame is wanted while there are pages: thirty times a second.
pub const PULSE: Duration = Duration::from_micros(33_333);
/// Decisions that can be recalled.
pub const REMEMBERED: usize = 2000;

/// What reaches the stage.
pub enum Order {
    /// A page asks for something.
    Ask(Request),
    /// Somebody came, went, or passed the wheel on: tell everybody how things stand.
    Refresh,
    /// The program ends.
    Quit,
}

/// What pages are sent, each kind only in its latest form.
pub struct Hub {
    frame: watch::Sender<Arc<str>>,
    status: watch::Sender<Arc<str>>,
    orders: SyncSender<Order>,
    past: Mutex<VecDeque<Arc<Frame>>>,
    numbered: AtomicU64,
    wheel: AtomicU64,
    pages: AtomicUsize,
    names: AtomicU64,
    wanted: AtomicBool,
    training_shown: AtomicBool,
    brake: Mutex<Option<Emergency>>,
}

/// A lock that outlives a thread's panic: what is inside is always whole.
pub fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Hub {
    /// A hub whose requests go to `orders`.
    #[must_use]
    pub fn new(orders: SyncSender<Order>) -> Self {
        Self {
            frame: watch::Sender::new(Arc::from("")),
            status: watch::Sender::new(Arc::from("")),
            orders,
            past: Mutex::new(VecDeque::new()),
            numbered: AtomicU64::new(0),
            wheel: AtomicU64::new(0),
            pages: AtomicUsize::new(0),
            names: AtomicU64::new(0),
            wanted: AtomicBool::new(false),
            training_shown: AtomicBool::new(false),
            brake: Mutex::new(None),
        }
    }

    /// Hands an order to the stage; false if the stage has too much to do already.
    pub fn order(&self, order: Order) -> bool {
        !matches!(self.orders.try_send(order), Err(TrySendError::Full(_)))
    }

    /// Numbers a frame, remembers it and shows it to whoever is ready.
    pub fn publish(&self, frame: Frame) {
        let frame = if frame.done { self.remember(frame) } else { Arc::new(frame) };
        // A frame nobody is ready for is not even written down as text, unless it may be the last for a while.
        if self.wanted.swap(false, Ordering::Relaxed) || !frame.done || frame.secs >= PULSE.as_secs_f64() {
            self.show(&frame);
        }
    }

    fn remember(&self, mut frame: Frame) -> Arc<Frame> {
        let mut past = lock(&self.past);
        frame.n = self.numbered.fetch_add(1, Ordering::Relaxed) + 1;
        let frame = Arc::new(frame);
        if past.len() == REMEMBERED {
            past.pop_front();
        }
        past.push_back(frame.clone());
        frame
    }

    fn show(&self, frame: &Frame) {
        if let Ok(text) = serde_json::to_string(frame) {
            self.frame.send_replace(Arc::from(format!("{{\"frame\":{text}}}")));
        }
    }

    /// Shows the last decision, which may have been skipped: for when the clock stops.
    pub fn show_last(&self) {
        let last = lock(&self.past).back().cloned();
        if let Some(frame) = last {
            self.show(&frame);
        }
    }

    /// Whether some page waits for a frame.
    #[must_use]
    pub fn is_wanted(&self) -> bool {
        self.wanted.load(Ordering::Relaxed)
    }

    /// Somebody waits for a frame: called thirty times a second while there are pages.
    pub fn want(&self) {
        self.wanted.store(self.pages() > 0, Ordering::Relaxed);
    }

    /// Whether the stage shows the training run.
    #[must_use]
    pub fn shows_training(&self) -> bool {
        self.training_shown.load(Ordering::Relaxed)
    }

    /// Shows the training run, or the studio's own drive.
    pub fn show_training(&self, on: bool) {
        self.training_shown.store(on, Ordering::Relaxed);
    }

    /// What [`Self::brake`] presses.
    pub fn hold_ready(&self, emergency: Emergency) {
        *lock(&self.brake) = Some(emergency);
    }

    /// Stops the body at once, without waiting for the stage; false if there is none.
    pub fn brake(&self) -> bool {
        lock(&self.brake).as_ref().map(Emergency::press).is_some()
    }

    /// Whether the body was stopped for good.
    #[must_use]
    pub fn braked(&self) -> bool {
        lock(&self.brake).as_ref().is_some_and(Emergency::pressed)
    }

    /// Tells every page how things stand.
    pub fn tell(&self, status: &str) {
        self.status.send_replace(Arc::from(format!("{{\"status\":{status}}}")));
    }

    /// What pages listen to: frames, and how things stand.
    #[must_use]
    pub fn listen(&self) -> (watch::Receiver<Arc<str>>, watch::Receiver<Arc<str>>) {
        (self.frame.subscribe(), self.status.subscribe())
    }

    /// Decision `n`, if it is remembered.
    #[must_use]
    pub fn recall(&self, n: u64) -> Option<Arc<Frame>> {
        let past = lock(&self.past);
        let first = past.front()?.n;
        past.get(usize::try_from(n.checked_sub(first)?).ok()?).cloned()
    }

    /// The last `count` decisions, the oldest first.
    #[must_use]
    pub fn lately(&self, count: usize) -> Vec<Arc<Frame>> {
        let past = lock(&self.past);
        past.iter().skip(past.len().saturating_sub(count)).cloned().collect()
    }

    /// First and last decision that are remembered.
    #[must_use]
    pub fn span(&self) -> (u64, u64) {
        let past = lock(&self.past);
        (past.front().map_or(0, |f| f.n), past.back().map_or(0, |f| f.n))
    }

    /// Forgets the last decision, because it was taken back.
    pub fn forget_last(&self) {
        if let Some(last) = lock(&self.past).pop_back() {
            self.numbered.store(last.n - 1, Ordering::Relaxed);
        }
    }

    /// A page comes: its name. The first one gets the wheel.
    pub fn enter(&self) -> u64 {
        let name = self.names.fetch_add(1, Ordering::Relaxed) + 1;
        self.pages.fetch_add(1, Ordering::Relaxed);
        self.take_wheel(name);
        name
    }

    /// A page goes; its wheel is free.
    pub fn leave(&self, name: u64) {
        self.pages.fetch_sub(1, Ordering::Relaxed);
        self.release_wheel(name);
    }

    /// Takes the wheel, if it is free.
    pub fn take_wheel(&self, name: u64) -> bool {
        let taken = self.wheel.compare_exchange(0, name, Ordering::Relaxed, Ordering::Relaxed);
        self.order(Order::Refresh);
        taken.is_ok()
    }

    /// Lets go of the wheel, if `name` holds it.
    pub fn release_wheel(&self, name: u64) {
        let _ = self.wheel.compare_exchange(name, 0, Ordering::Relaxed, Ordering::Relaxed);
        self.order(Order::Refresh);
    }

    /// Who holds the wheel; 0 means nobody.
    #[must_use]
    pub fn wheel(&self) -> u64 {
        self.wheel.load(Ordering::Relaxed)
    }

    /// Pages that are open.
    #[must_use]
    pub fn pages(&self) -> usize {
        self.pages.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Source;
    use std::sync::mpsc::sync_channel;

    fn hub() -> (Hub, std::sync::mpsc::Receiver<Order>) {
        let (orders, stage) = sync_channel(64);
        (Hub::new(orders), stage)
    }

    fn frame(step: usize) -> Frame {
        let (source, lanes) = (Source::Drive, Vec::new());
        Frame { n: 0, source, phase: None, episode: 0, step, secs: 0.5, done: true, scene: None, lanes }
    }

    #[test]
    fn a_slow_page_sees_the_latest_frame_and_nobody_waits() {
        let (hub, _stage) = hub();
        hub.enter();
        let (mut frames, _) = hub.listen();
        for step in 0..10_000 {
            hub.want();
            hub.publish(frame(step));
        }
        hub.show_last();
        assert!(frames.borrow_and_update().contains("\"step\":9999"));
        assert!(!frames.has_changed().unwrap(), "only the latest is kept");
        assert_eq!((hub.span(), hub.lately(3).len()), ((10_000 - REMEMBERED as u64 + 1, 10_000), 3));
        assert_eq!(hub.recall(9000).unwrap().step, 8999);
        assert!(hub.recall(1).is_none() && hub.recall(10_001).is_none());
        hub.forget_last();
        assert_eq!(hub.span().1, 9999);
    }

    #[test]
    fn without_pages_no_frame_is_wanted() {
        let (hub, _stage) = hub();
        hub.want();
        assert!(!hub.is_wanted());
        let name = hub.enter();
        hub.want();
        assert!(hub.is_wanted());
        hub.leave(name);
        hub.want();
        assert!(!hub.is_wanted());
    }

    #[test]
    fn one_page_holds_the_wheel() {
        let (hub, _stage) = hub();
        let (first, second) = (hub.enter(), hub.enter());
        assert_eq!(hub.wheel(), first);
        assert!(!hub.take_wheel(second));
        hub.release_wheel(second);
        assert_eq!(hub.wheel(), first, "nobody can throw out another");
        hub.leave(first);
        assert!(hub.take_wheel(second) && hub.wheel() == second);
    }

    #[test]
    fn a_busy_stage_refuses_instead_of_piling_up() {
        let (orders, _stage) = sync_channel(2);
        let hub = Hub::new(orders);
        assert!(hub.order(Order::Refresh) && hub.order(Order::Refresh));
        assert!(!hub.order(Order::Refresh));
    }
}
