//! What a supervisor may ask and change: nodes by name, their fields, poses, physics.

use super::Release;
pub use super::value::{Field, Value};
use crate::bytes::{Reader, Writer};
use crate::error::ProtocolError;

/// The supervisor's own node.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Me {
    /// Its number.
    pub uid: i32,
    /// Its parent's number.
    pub parent: i32,
    /// Whether it is an instance of a PROTO, and whether it lies inside one.
    pub proto_internal: [bool; 2],
    /// Ancestor among the PROTOs (R2025a only, else −1 or 0).
    pub ancestor: i32,
    /// Model.
    pub model: String,
    /// DEF name.
    pub def: String,
}

/// The number that R2025a puts where R2023b has none.
fn read_ancestor(release: Release, r: &mut Reader) -> Result<i32, ProtocolError> {
    if release >= Release::R2025a { r.i32() } else { Ok(0) }
}

fn write_ancestor(value: i32, release: Release, w: &mut Writer) {
    if release >= Release::R2025a {
        w.i32(value);
    }
}

pub(super) fn read_me(release: Release, r: &mut Reader) -> Result<Me, ProtocolError> {
    Ok(Me {
        uid: r.i32()?,
        parent: r.i32()?,
        proto_internal: [r.u8()? != 0, r.u8()? != 0],
        ancestor: read_ancestor(release, r)?,
        model: r.text()?,
        def: r.text()?,
    })
}

pub(super) fn write_me(me: &Me, release: Release, w: &mut Writer) {
    w.i32(me.uid).i32(me.parent).flag(me.proto_internal[0]).flag(me.proto_internal[1]);
    write_ancestor(me.ancestor, release, w);
    w.text(&me.model).text(&me.def);
}

/// What a supervisor wants.
#[derive(Clone, Debug, PartialEq)]
pub enum Wish {
    /// The node with this DEF name.
    NodeByDef(String),
    /// The node with this number.
    NodeById(i32),
    /// A node's field by its name.
    FieldByName(u32, String),
    /// A field's value.
    Get(Field),
    /// A new value for a field (of one value, not a list).
    Set(Field, Value),
    /// A node's place.
    Position(u32),
    /// A node's orientation.
    Orientation(u32),
    /// A node's pose, seen from another (0: the world).
    Pose([u32; 2]),
    /// A node's velocity.
    Velocity(u32),
    /// A new velocity: three numbers for the motion, three for the rotation.
    SetVelocity(u32, [f64; 6]),
    /// Forget all forces and velocities of a node.
    ResetPhysics(u32),
    /// The controller of this robot shall start anew.
    RestartController(u32),
    /// A node's pose after every step (period in milliseconds; none: no longer).
    Track([u32; 2], Option<i32>),
    /// The whole simulation from its beginning.
    Reset,
    /// 0: pause, 1: real time, 2: fast.
    Mode(i32),
    /// Webots shall quit with this status.
    Quit(i32),
}

impl Wish {
    /// Appends the wish to the robot's orders.
    pub fn write(&self, release: Release, w: &mut Writer) {
        match self {
            Self::NodeByDef(def) => w.u8(84).text(def).i32(-1),
            Self::NodeById(id) => w.u8(83).i32(*id),
            Self::FieldByName(node, name) => {
                w.u8(87).u32(*node);
                write_ancestor(-1, release, w);
                w.text(name).u8(0)
            }
            Self::Get(f) => w.u8(88).u32(f.node).u32(f.field).flag(f.internal),
            Self::Set(f, value) => {
                w.u8(62).u32(f.node).u32(f.field).i32(value.type_number()).i32(-1);
                value.write(w);
                w
            }
            Self::Position(node) => w.u8(90).u32(*node),
            Self::Orientation(node) => w.u8(91).u32(*node),
            Self::Pose([from, to]) => w.u8(92).u32(*from).u32(*to),
            Self::Velocity(node) => w.u8(96).u32(*node),
            Self::SetVelocity(node, velocity) => w.u8(66).u32(*node).f64s(velocity),
            Self::ResetPhysics(node) => w.u8(67).u32(*node),
            Self::RestartController(node) => w.u8(68).u32(*node),
            Self::Track([from, to], period) => {
                w.u8(102).u32(*from).u32(*to).flag(period.is_some());
                if let Some(ms) = period {
                    w.i32(*ms);
                }
                w
            }
            Self::Reset => w.u8(55),
            Self::Mode(mode) => w.u8(56).i32(*mode),
            Self::Quit(status) => w.u8(54).i32(*status),
        };
    }

    /// The wish of operation `op`, or nothing if `op` is none of them.
    ///
    /// # Errors
    /// If the bytes end too early or mean nothing.
    pub fn read(op: u8, release: Release, r: &mut Reader) -> Result<Option<Self>, ProtocolError> {
        Ok(Some(match op {
            84 => {
                let def = r.text()?;
                r.i32()?;
                Self::NodeByDef(def)
            }
            83 => Self::NodeById(r.i32()?),
            87 => {
                let node = r.u32()?;
                read_ancestor(release, r)?;
                let name = r.text()?;
                r.u8()?;
                Self::FieldByName(node, name)
            }
            88 => Self::Get(Field::read(r)?),
            62 => {
                let (node, field, type_number, index) = (r.u32()?, r.u32()?, r.i32()?, r.i32()?);
                if index != -1 {
                    return Err(ProtocolError::Unexpected(format!("item {index} of a list to be set")));
                }
                Self::Set(Field { node, field, internal: false }, Value::read(type_number, r)?)
            }
            90 => Self::Position(r.u32()?),
            91 => Self::Orientation(r.u32()?),
            92 => Self::Pose(r.many(Reader::u32)?),
            96 => Self::Velocity(r.u32()?),
            66 => Self::SetVelocity(r.u32()?, r.many(Reader::f64)?),
            67 => Self::ResetPhysics(r.u32()?),
            68 => Self::RestartController(r.u32()?),
            102 => {
                let nodes = r.many(Reader::u32)?;
                Self::Track(nodes, if r.u8()? != 0 { Some(r.i32()?) } else { None })
            }
            55 => Self::Reset,
            56 => Self::Mode(r.i32()?),
            54 => Self::Quit(r.i32()?),
            _ => return Ok(None),
        }))
    }
}

/// A node, as Webots describes it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Node {
    /// Its number; 0: there is no such node.
    pub uid: i32,
    /// Its type.
    pub node_type: i32,
    /// Its tag, if it is a device.
    pub tag: i32,
    /// Its parent's number.
    pub parent: i32,
    /// Whether it is an instance of a PROTO.
    pub proto: bool,
    /// Ancestor among the PROTOs (R2025a only).
    pub ancestor: i32,
    /// Model.
    pub model: String,
}

/// What a supervisor is told.
#[derive(Clone, Debug, PartialEq)]
pub enum Fact {
    /// The node with the DEF name that was asked for.
    NodeByDef(Node),
    /// The node with the number that was asked for, whether it lies inside a PROTO, and its DEF name.
    NodeById(Node, bool, String),
    /// A field: its number (−1: no such field), type, whether internal, number of its items, name.
    Field(i32, i32, bool, i32, String),
    /// A field's value: node, field, value; none if the node is gone.
    Value(Option<(i32, i32, Value)>),
    /// A place in metres.
    Position([f64; 3]),
    /// A rotation matrix, row by row.
    Orientation([f64; 9]),
    /// A pose: from, to, matrix of 4×4, row by row.
    Pose([i32; 2], [f64; 16]),
    /// Motion and rotation.
    Velocity([f64; 6]),
    /// The simulation begins anew (R2025a).
    Reset,
}

impl Fact {
    /// Appends the fact (without the robot's tag) to the news.
    pub fn write(&self, release: Release, w: &mut Writer) {
        match self {
            Self::NodeByDef(node) => {
                write_node(84, node, w);
                write_ancestor(node.ancestor, release, w);
                w.text(&node.model)
            }
            Self::NodeById(node, internal, def) => {
                write_node(83, node, w);
                w.flag(*internal).text(&node.model).text(def);
                write_ancestor(node.ancestor, release, w);
                w
            }
            Self::Field(field, type_number, internal, count, name) => {
                w.u8(87).i32(*field).i32(*type_number).flag(*internal).i32(*count).text(name)
            }
            Self::Value(None) => w.u8(88).i32(0),
            Self::Value(Some((node, field, value))) => {
                w.u8(88).i32(value.type_number()).i32(*node).i32(*field);
                value.write(w);
                w
            }
            Self::Position(place) => w.u8(90).f64s(place),
            Self::Orientation(matrix) => w.u8(91).f64s(matrix),
            Self::Pose([from, to], matrix) => w.u8(92).i32(*from).i32(*to).f64s(matrix),
            Self::Velocity(velocity) => w.u8(96).f64s(velocity),
            Self::Reset => w.u8(55),
        };
    }

    /// The fact of operation `op`, or nothing if `op` is none of them.
    ///
    /// # Errors
    /// If the bytes end too early or mean nothing.
    pub fn read(op: u8, release: Release, r: &mut Reader) -> Result<Option<Self>, ProtocolError> {
        Ok(Some(match op {
            84 => {
                let mut node = read_node(r)?;
                node.ancestor = read_ancestor(release, r)?;
                node.model = r.text()?;
                Self::NodeByDef(node)
            }
            83 | 85 | 86 => {
                let mut node = read_node(r)?;
                let internal = r.u8()? != 0;
                node.model = r.text()?;
                let def = r.text()?;
                node.ancestor = read_ancestor(release, r)?;
                Self::NodeById(node, internal, def)
            }
            64 | 87 => Self::Field(r.i32()?, r.i32()?, r.u8()? != 0, r.i32()?, r.text()?),
            88 => match r.i32()? {
                0 => Self::Value(None),
                type_number => Self::Value(Some((r.i32()?, r.i32()?, Value::read(type_number, r)?))),
            },
            90 => Self::Position(r.many(Reader::f64)?),
            91 => Self::Orientation(r.many(Reader::f64)?),
            92 => Self::Pose(r.many(Reader::i32)?, r.many(Reader::f64)?),
            96 => Self::Velocity(r.many(Reader::f64)?),
            55 if release >= Release::R2025a => Self::Reset,
            _ => return Ok(None),
        }))
    }
}

fn write_node(op: u8, node: &Node, w: &mut Writer) {
    w.u8(op).i32(node.uid).i32(node.node_type).i32(node.tag).i32(node.parent).flag(node.proto);
}

fn read_node(r: &mut Reader) -> Result<Node, ProtocolError> {
    let [uid, node_type, tag, parent] = r.many(Reader::i32)?;
    Ok(Node { uid, node_type, tag, parent, proto: r.u8()? != 0, ..Node::default() })
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOTH: [Release; 2] = [Release::R2023b, Release::R2025a];

    fn values() -> Vec<Value> {
        vec![
            Value::Bool(true),
            Value::Int(-3),
            Value::Float(0.5),
            Value::Vec2([1.0, 2.0]),
            Value::Vec3([1.0, 2.0, 3.0]),
            Value::Rotation([0.0, 0.0, 1.0, 1.5]),
            Value::Colour([0.8, 0.0, 0.1]),
            Value::Text("learner".to_owned()),
        ]
    }

    #[test]
    fn wishes_survive_the_wire() {
        let field = Field { node: 7, field: 1, internal: false };
        let mut wishes = vec![
            Wish::NodeByDef("RED1".to_owned()),
            Wish::NodeById(7),
            Wish::FieldByName(7, "translation".to_owned()),
            Wish::Get(field),
            Wish::Position(7),
            Wish::Orientation(7),
            Wish::Pose([0, 7]),
            Wish::Velocity(7),
            Wish::SetVelocity(7, [0.0; 6]),
            Wish::ResetPhysics(7),
            Wish::RestartController(7),
            Wish::Track([0, 7], Some(32)),
            Wish::Track([0, 7], None),
            Wish::Reset,
            Wish::Mode(2),
            Wish::Quit(0),
        ];
        wishes.extend(values().into_iter().map(|value| Wish::Set(field, value)));
        for release in BOTH {
            for wish in &wishes {
                let mut w = Writer::new();
                wish.write(release, &mut w);
                let bytes = w.into_bytes();
                let mut r = Reader::new(&bytes[1..]);
                assert_eq!(Wish::read(bytes[0], release, &mut r).unwrap().as_ref(), Some(wish));
                assert_eq!(r.remaining(), 0, "{wish:?}");
            }
        }
    }

    #[test]
    fn facts_survive_the_wire() {
        let node = Node { uid: 7, node_type: 34, tag: 0, parent: 1, proto: true, ..Node::default() };
        let mut facts = vec![
            Fact::NodeByDef(node.clone()),
            Fact::NodeById(node, false, "LEARNER".to_owned()),
            Fact::Field(0, 5, false, -1, "translation".to_owned()),
            Fact::Value(None),
            Fact::Position([1.0, 2.0, 3.0]),
            Fact::Orientation([0.5; 9]),
            Fact::Pose([0, 7], [0.25; 16]),
            Fact::Velocity([0.1; 6]),
        ];
        facts.extend(values().into_iter().map(|value| Fact::Value(Some((7, 1, value)))));
        for release in BOTH {
            for fact in &facts {
                let mut w = Writer::new();
                fact.write(release, &mut w);
                let bytes = w.into_bytes();
                let mut r = Reader::new(&bytes[1..]);
                assert_eq!(Fact::read(bytes[0], release, &mut r).unwrap().as_ref(), Some(fact));
                assert_eq!(r.remaining(), 0, "{fact:?}");
            }
        }
        assert_eq!(Fact::read(55, Release::R2023b, &mut Reader::new(&[])).unwrap(), None);
        assert_eq!(Fact::read(55, Release::R2025a, &mut Reader::new(&[])).unwrap(), Some(Fact::Reset));
    }

    #[test]
    fn the_second_release_asks_for_a_field_with_one_more_number() {
        let bytes = BOTH.map(|release| {
            let mut w = Writer::new();
            Wish::FieldByName(7, "size".to_owned()).write(release, &mut w);
            w.into_bytes()
        });
        assert_eq!(bytes[0], b"\x57\x07\0\0\0size\0\0");
        assert_eq!(bytes[1], b"\x57\x07\0\0\0\xFF\xFF\xFF\xFFsize\0\0");
    }
}
