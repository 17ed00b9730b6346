//! Fields of nodes, and what may be in them.

use crate::bytes::{Reader, Writer};
use crate::error::ProtocolError;

/// The value of a field.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A yes or no.
    Bool(bool),
    /// A whole number.
    Int(i32),
    /// A number.
    Float(f64),
    /// Two numbers.
    Vec2([f64; 2]),
    /// Three numbers; a place in metres.
    Vec3([f64; 3]),
    /// Axis and angle in radians.
    Rotation([f64; 4]),
    /// Red, green, blue.
    Colour([f64; 3]),
    /// A text.
    Text(String),
}

impl Value {
    /// The number of its type in Webots; a list of such has 16 more.
    #[must_use]
    pub fn type_number(&self) -> i32 {
        match self {
            Self::Bool(_) => 1,
            Self::Int(_) => 2,
            Self::Float(_) => 3,
            Self::Vec2(_) => 4,
            Self::Vec3(_) => 5,
            Self::Rotation(_) => 6,
            Self::Colour(_) => 7,
            Self::Text(_) => 8,
        }
    }

    pub(super) fn read(type_number: i32, r: &mut Reader) -> Result<Self, ProtocolError> {
        Ok(match type_number & 15 {
            1 => Self::Bool(r.u8()? != 0),
            2 => Self::Int(r.i32()?),
            3 => Self::Float(r.f64()?),
            4 => Self::Vec2(r.many(Reader::f64)?),
            5 => Self::Vec3(r.many(Reader::f64)?),
            6 => Self::Rotation(r.many(Reader::f64)?),
            7 => Self::Colour(r.many(Reader::f64)?),
            8 => Self::Text(r.text()?),
            _ => return Err(ProtocolError::Unexpected(format!("a field of type {type_number}"))),
        })
    }

    pub(super) fn write(&self, w: &mut Writer) {
        match self {
            Self::Bool(v) => w.flag(*v),
            Self::Int(v) => w.i32(*v),
            Self::Float(v) => w.f64(*v),
            Self::Vec2(v) => w.f64s(v),
            Self::Vec3(v) | Self::Colour(v) => w.f64s(v),
            Self::Rotation(v) => w.f64s(v),
            Self::Text(v) => w.text(v),
        };
    }
}

/// A field of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Field {
    /// Number of the node.
    pub node: u32,
    /// Number of the field.
    pub field: u32,
    /// Whether it lies inside a PROTO.
    pub internal: bool,
}

impl Field {
    pub(super) fn read(r: &mut Reader) -> Result<Self, ProtocolError> {
        Ok(Self { node: r.u32()?, field: r.u32()?, internal: r.u8()? != 0 })
    }
}
