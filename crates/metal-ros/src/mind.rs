//! A mind that drives, and tells the graph what it attends to.
//!
//! `attention` holds the members of the mind that were consulted in a step, in their order; `attention/decision` what each
//! of them said and what the looks cost, as JSON. Pictures and ranges are told when the mind took them, and not otherwise.

use crate::messages::{Image, MultiArrayDimension, MultiArrayLayout, Range, Text, UInt8MultiArray};
use crate::node::{Node, Outlet};
use crate::sense;
use metal_rl::environment::{Environment, EnvironmentError, EnvironmentSpec, Outcome};
use metal_rl::observe::{Observer, Step};
use metal_robots::RobotEnvironment;
use metal_robots::body::INFRARED;
use serde_json::{Value, json};

/// Index of the infra-red ring among the sensors.
const RING: usize = 6;

/// Tells what a mind attends to and decides.
pub struct Attention {
    order: Outlet<UInt8MultiArray>,
    decision: Outlet<Text>,
    spec: EnvironmentSpec,
    members: Vec<String>,
}

impl Attention {
    /// Opens the topics. `members` are the mind's, by name.
    ///
    /// # Errors
    /// If the network refuses.
    pub fn open(node: &mut Node, spec: &EnvironmentSpec, members: Vec<String>) -> anyhow::Result<Self> {
        let (order, decision) = (node.outlet("attention")?, node.outlet("attention/decision")?);
        Ok(Self { order, decision, spec: spec.clone(), members })
    }

    fn told(&self, step: &Step<'_>) -> Value {
        let consulted = step.state.order().iter().map(|&member| {
            let opinion = step.state.opinion(member);
            json!({
                "member": self.members.get(member),
                "reading": opinion.map(|o| o.reading),
                "values": opinion.map(|o| o.values),
                "support": opinion.map(|o| o.support),
            })
        });
        let measures = self.spec.measures.iter().zip(step.measures);
        json!({
            "episode": step.episode,
            "step": step.index,
            "consulted": consulted.collect::<Vec<_>>(),
            "action": self.spec.actions.get(step.action),
            "motor_reward": step.motor_reward,
            "look_price": step.look_price,
            "measures": measures.map(|(n, v)| (n.clone(), json!(v))).collect::<serde_json::Map<_, _>>(),
        })
    }
}

impl Observer for Attention {
    fn on_step(&mut self, step: &Step<'_>) {
        let data: Vec<u8> = step.state.order().iter().map(|&m| u8::try_from(m).unwrap_or(u8::MAX)).collect();
        let size = data.len() as u32;
        let dim = vec![MultiArrayDimension { label: "consulted".to_owned(), size, stride: size }];
        self.order.say(UInt8MultiArray { layout: MultiArrayLayout { dim, data_offset: 0 }, data });
        self.decision.say(Text { data: self.told(step).to_string() });
    }
}

/// An environment that tells what was looked at.
pub struct Told {
    inner: RobotEnvironment,
    image: Outlet<Image>,
    ring: Vec<Outlet<Range>>,
}

impl Told {
    /// Opens the topics.
    ///
    /// # Errors
    /// If the network refuses.
    pub fn open(node: &mut Node, inner: RobotEnvironment) -> anyhow::Result<Self> {
        let ring = (0..INFRARED).map(|i| node.outlet(&format!("ps{i}"))).collect::<anyhow::Result<_>>()?;
        Ok(Self { inner, image: node.outlet("image_raw")?, ring })
    }
}

impl Environment for Told {
    fn spec(&self) -> &EnvironmentSpec {
        self.inner.spec()
    }

    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        self.inner.reset(seed)
    }

    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        self.inner.sense(sensor, out)?;
        if sensor == RING {
            for (i, (outlet, reading)) in self.ring.iter().zip(out).enumerate() {
                outlet.say(sense::range(&format!("ps{i}"), *reading));
            }
        }
        Ok(())
    }

    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        if let Some(picture) = self.inner.seen() {
            self.image.say(sense::image(picture));
        }
        self.inner.step(action)
    }

    fn measures(&self) -> &[f64] {
        self.inner.measures()
    }

    fn advise(&mut self) -> Option<usize> {
        self.inner.advise()
    }
}
