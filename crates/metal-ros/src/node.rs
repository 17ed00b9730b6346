//! A node in the graph: topics that are said, topics that are heard, and who listens.

use crate::messages::{Header, Named, Time, TriggerRequest, TriggerResponse};
use anyhow::anyhow;
use ros2_client::qos::{Durability, History, WhenFull};
use ros2_client::{
    Context, ContextOptions, Message, MessageTypeName, Name, NodeName, NodeOptions, Publisher, QosProfile,
    Server, ServiceMapping, ServiceTypeName, Subscription,
};
use std::time::{SystemTime, UNIX_EPOCH};

/// What distinguishes this node from others.
#[derive(Clone, Debug)]
pub struct Place {
    /// Namespace of all its topics, e.g. `/` or `/epuck1`.
    pub namespace: String,
    /// DDS domain, as in `ROS_DOMAIN_ID`.
    pub domain: u16,
    /// How services are spoken: `Enhanced` by Fast DDS and Connext, `Cyclone` by Cyclone DDS.
    pub services: ServiceMapping,
}

/// A node, and the namespace of its topics.
pub struct Node {
    node: ros2_client::Node,
    place: Place,
}

/// A topic that is said.
pub struct Outlet<M: Message>(Publisher<M>);

/// Reliable, the last ten: what ROS tools expect. Whoever is too slow misses messages, the robot never waits.
fn quality() -> QosProfile {
    QosProfile::publisher_default()
        .reliability_reliable(WhenFull::Fail)
        .history(History::KeepLast { depth: 10 })
}

impl Node {
    /// Enters the graph.
    ///
    /// # Errors
    /// If the network cannot be used or the namespace is none.
    pub fn enter(name: &str, place: Place) -> anyhow::Result<Self> {
        let context = Context::with_options(ContextOptions::new().domain_id(place.domain))?;
        let full = NodeName::new(&place.namespace, name).map_err(|e| anyhow!("{}: {e}", place.namespace))?;
        let mut node = context.new_node(full, NodeOptions::new().enable_rosout(false))?;
        let spinner = node.spinner()?;
        // It notices who listens, and ends when the node is dropped.
        std::thread::Builder::new()
            .name("ros graph".to_owned())
            .spawn(move || futures::executor::block_on(spinner.spin()))?;
        Ok(Self { node, place })
    }

    fn topic<M: Named>(&self, name: &str, latched: bool) -> anyhow::Result<ros2_client::dds::rustdds::Topic> {
        let [package, kind] = M::NAME;
        let quality = if latched { quality().durability(Durability::TransientLocal) } else { quality() };
        Ok(self.node.create_topic(&self.name(name)?, MessageTypeName::new(package, kind), &quality)?)
    }

    /// Topics of transforms are the same for all robots; everything else is in the namespace.
    fn name(&self, name: &str) -> anyhow::Result<Name> {
        let namespace = if name.starts_with("tf") { "/" } else { &self.place.namespace };
        // A name with parts belongs to a longer namespace.
        let (folder, base) = name.rsplit_once('/').map_or(("", name), |(f, b)| (f, b));
        let namespace = format!("{}/{folder}", namespace.trim_end_matches('/'));
        let namespace = if namespace == "/" { "/" } else { namespace.trim_end_matches('/') };
        Name::new(namespace, base).map_err(|e| anyhow!("{namespace}/{base}: {e}"))
    }

    /// A topic to say things on.
    ///
    /// # Errors
    /// If the network refuses.
    pub fn outlet<M: Named + Message>(&mut self, name: &str) -> anyhow::Result<Outlet<M>> {
        let topic = self.topic::<M>(name, false)?;
        Ok(Outlet(self.node.create_publisher(&topic, None)?))
    }

    /// A topic whose last message is told to whoever comes later.
    ///
    /// # Errors
    /// If the network refuses.
    pub fn latched<M: Named + Message>(&mut self, name: &str) -> anyhow::Result<Outlet<M>> {
        let topic = self.topic::<M>(name, true)?;
        Ok(Outlet(self.node.create_publisher(&topic, None)?))
    }

    /// A topic to hear.
    ///
    /// # Errors
    /// If the network refuses.
    pub fn inlet<M: Named + Message + 'static>(&mut self, name: &str) -> anyhow::Result<Subscription<M>> {
        let topic = self.topic::<M>(name, false)?;
        Ok(self.node.create_subscription(&topic, None)?)
    }

    /// A button that others may press (`std_srvs/Trigger`).
    ///
    /// # Errors
    /// If the network refuses.
    pub fn trigger(&mut self, name: &str) -> anyhow::Result<Server<TriggerRequest, TriggerResponse>> {
        let kind = ServiceTypeName::new("std_srvs", "Trigger");
        let full = self.name(name)?;
        Ok(self.node.create_server(self.place.services, &full, &kind, quality(), quality())?)
    }

    /// Whether somebody listens: what nobody listens to is not asked of the body.
    #[must_use]
    pub fn listened<M: Message + 'static>(&self, outlet: &Outlet<M>) -> bool {
        outlet.0.get_subscription_count(&self.node) > 0
    }
}

impl<M: Message> Outlet<M> {
    /// Says it. Who is too slow misses it.
    pub fn say(&self, message: M) {
        let _ = self.0.publish(message);
    }
}

/// The last message that waits, if any.
pub fn last<M: Message + 'static>(inlet: &Subscription<M>) -> Option<M> {
    let mut last = None;
    while let Ok(Some((message, _))) = inlet.take() {
        last = Some(message);
    }
    last
}

/// A header of now.
#[must_use]
pub fn header(frame: &str) -> Header {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let sec = i32::try_from(now.as_secs()).unwrap_or(i32::MAX);
    Header { stamp: Time { sec, nanosec: now.subsec_nanos() }, frame_id: frame.to_owned() }
}
