//! What the body does as a supervisor: it finds everybody, says where they are, and puts them elsewhere.

use super::{CAR, LEARNER, MOST_CARS, Webots};
use crate::error::{BodyError, ProtocolError};
use crate::webots::ROBOT;
use crate::webots::order::Order;
use crate::webots::supervisor::{Fact, Field, Value, Wish};
use metal_rl::num;
use metal_worlds::highway::Pose;

/// A node that can be found and moved.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    node: u32,
    translation: Field,
    rotation: Field,
}

impl Webots {
    /// Finds the learner, and the cars by their numbers until one is missing.
    pub(super) fn find_everybody(&mut self) -> Result<(), BodyError> {
        let cars = (1..=MOST_CARS).map(|i| format!("{CAR}{i}"));
        for def in std::iter::once(LEARNER.to_owned()).chain(cars) {
            let Some(placed) = self.find(&def)? else { break };
            self.placed.push(placed);
        }
        Ok(())
    }

    fn find(&mut self, def: &str) -> Result<Option<Placed>, BodyError> {
        let Fact::NodeByDef(node) = self.wish(Wish::NodeByDef(def.to_owned()))? else {
            return Err(ProtocolError::Unexpected("an answer that is no node".to_owned()).into());
        };
        let Some(node) = u32::try_from(node.uid).ok().filter(|&uid| uid > 0) else { return Ok(None) };
        let translation = self.field(node, "translation")?;
        Ok(Some(Placed { node, translation, rotation: self.field(node, "rotation")? }))
    }

    fn field(&mut self, node: u32, name: &str) -> Result<Field, BodyError> {
        match self.wish(Wish::FieldByName(node, name.to_owned()))? {
            Fact::Field(field, _, internal, _, _) if field >= 0 => {
                Ok(Field { node, field: field as u32, internal })
            }
            _ => Err(BodyError::Unsupported(format!("a node without the field `{name}`"))),
        }
    }

    /// Asks for one fact, at once.
    fn wish(&mut self, wish: Wish) -> Result<Fact, BodyError> {
        self.waiting.push((ROBOT, Order::Wish(wish)));
        let heard = self.exchange(0)?;
        let nothing = || ProtocolError::Unexpected("no answer to a supervisor's question".to_owned());
        Ok(heard.facts.into_iter().next_back().ok_or_else(nothing)?)
    }

    /// Where everybody is, the learner first.
    pub(super) fn everybodys_poses(&mut self) -> Result<Vec<Pose>, BodyError> {
        let nodes: Vec<u32> = self.placed.iter().map(|p| p.node).collect();
        nodes.into_iter().map(|node| self.pose(node)).collect()
    }

    fn pose(&mut self, node: u32) -> Result<Pose, BodyError> {
        match self.wish(Wish::Pose([0, node]))? {
            // The matrix is that of the node in the world, row by row.
            Fact::Pose(_, m) => Ok(Pose { x_m: m[3], y_m: m[7], heading_rad: num::atan2(m[4], m[0]) }),
            _ => Err(ProtocolError::Unexpected("an answer that is no pose".to_owned()).into()),
        }
    }

    /// Orders everybody elsewhere with whatever is said next.
    pub(super) fn order_places(&mut self, poses: &[Pose]) {
        // All in one packet, and physics last: libController would reset physics before the new poses arrive.
        for (placed, pose) in self.placed.iter().zip(poses) {
            let wishes = [
                Wish::Set(placed.translation, Value::Vec3([pose.x_m, pose.y_m, 0.0])),
                Wish::Set(placed.rotation, Value::Rotation([0.0, 0.0, 1.0, pose.heading_rad])),
                Wish::SetVelocity(placed.node, [0.0; 6]),
                Wish::ResetPhysics(placed.node),
            ];
            self.waiting.extend(wishes.map(|wish| (ROBOT, Order::Wish(wish))));
        }
    }
}
