//! What a controller orders: sampling, motion, lights, and a supervisor's wishes.

use super::Release;
use super::device::Kind;
use super::supervisor::Wish;
use crate::bytes::{Reader, Writer};
use crate::error::ProtocolError;

/// An order to one device, or to the robot.
#[derive(Clone, Debug, PartialEq)]
pub enum Order {
    /// Measure every so many milliseconds; 0: not at all.
    Sample(u16),
    /// Target position of a motor in radians; infinite: turn without end.
    Position(f64),
    /// Velocity of a motor, in radians per second.
    Velocity(f64),
    /// A light's state.
    Light(i32),
    /// A supervisor's wish.
    Wish(Wish),
    /// The controller leaves.
    Leave,
    /// Something that changes nothing here: messages for the console, batteries, keyboards …
    Other(u8),
}

const LEAVE: u8 = 38;

impl Order {
    /// Appends the order to a device's payload. [`Order::Other`] has no payload and is not written.
    pub fn write(&self, release: Release, w: &mut Writer) {
        match self {
            Self::Sample(period_ms) => w.u8(1).u16(*period_ms),
            // A motor's operations have two bytes, everybody else's one.
            Self::Position(position) => w.u16(1).f64(*position),
            Self::Velocity(velocity) => w.u16(2).f64(*velocity),
            Self::Light(state) => w.u8(1).i32(*state),
            Self::Wish(wish) => {
                wish.write(release, w);
                w
            }
            Self::Leave => w.u8(LEAVE),
            Self::Other(_) => w,
        };
    }
}

/// The orders in the payload of a device of `kind` (none: of the robot). Behind an order that nobody knows, the rest of
/// the payload is left out; the payload's own length keeps the others whole.
///
/// # Errors
/// If the payload ends inside an order.
pub fn read_all(kind: Option<Kind>, release: Release, payload: &[u8]) -> Result<Vec<Order>, ProtocolError> {
    let mut r = Reader::new(payload);
    let mut orders = Vec::new();
    while r.remaining() > 0 {
        let order = match kind {
            None => robots(release, &mut r)?,
            Some(kind) => devices(kind, &mut r)?,
        };
        let known = order.is_some();
        orders.push(order.unwrap_or(Order::Other(payload[0])));
        if !known {
            break;
        }
    }
    Ok(orders)
}

fn robots(release: Release, r: &mut Reader) -> Result<Option<Order>, ProtocolError> {
    let op = r.u8()?;
    match op {
        LEAVE => return Ok(Some(Order::Leave)),
        30 => {
            r.u8()?;
            let length = r.u32()? as usize;
            r.take(length)?;
        }
        31 | 34 | 35 | 36 => {
            r.u16()?;
        }
        37 => {
            let length = usize::from(r.u16()?);
            r.take(length)?;
        }
        33 => {}
        39 | 40 => {
            r.u8()?;
        }
        _ => return Ok(Wish::read(op, release, r)?.map(Order::Wish)),
    }
    Ok(Some(Order::Other(op)))
}

fn devices(kind: Kind, r: &mut Reader) -> Result<Option<Order>, ProtocolError> {
    match kind {
        Kind::Motor => motors(r),
        Kind::Led => Ok(if r.u8()? == 1 { Some(Order::Light(r.i32()?)) } else { None }),
        Kind::Speaker | Kind::Emitter => Ok(None),
        _ => {
            let op = r.u8()?;
            match (op, kind) {
                (1, _) => Ok(Some(Order::Sample(r.u16()?))),
                (4..=6, Kind::Camera) => {
                    r.f64()?;
                    Ok(Some(Order::Other(op)))
                }
                _ => Ok(None),
            }
        }
    }
}

fn motors(r: &mut Reader) -> Result<Option<Order>, ProtocolError> {
    let op = r.u16()?;
    Ok(Some(match op {
        1 => Order::Position(r.f64()?),
        2 => Order::Velocity(r.f64()?),
        3 | 4 | 6 => {
            r.f64()?;
            Order::Other(op as u8)
        }
        5 | 8 => {
            r.u16()?;
            Order::Other(op as u8)
        }
        7 => {
            r.many::<_, 3>(Reader::f64)?;
            Order::Other(7)
        }
        _ => return Ok(None),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn payload(orders: &[Order]) -> Vec<u8> {
        let mut w = Writer::new();
        orders.iter().for_each(|order| order.write(Release::R2023b, &mut w));
        w.into_bytes()
    }

    #[test]
    fn a_motors_operations_have_two_bytes() {
        let orders = [Order::Position(f64::INFINITY), Order::Velocity(1.0)];
        let bytes = payload(&orders);
        let golden = [1, 0, 0, 0, 0, 0, 0, 0, 0xF0, 0x7F, 2, 0, 0, 0, 0, 0, 0, 0, 0xF0, 0x3F];
        assert_eq!(bytes, golden);
        assert_eq!(read_all(Some(Kind::Motor), Release::R2023b, &bytes).unwrap(), orders);
    }

    #[test]
    fn several_orders_follow_each_other() {
        let wishes = [Order::Wish(Wish::ResetPhysics(7)), Order::Wish(Wish::Position(7)), Order::Leave];
        assert_eq!(read_all(None, Release::R2023b, &payload(&wishes)).unwrap(), wishes);
        // The joystick's period, which libController sends in its very first request.
        assert_eq!(read_all(None, Release::R2023b, &[35, 0, 0]).unwrap(), [Order::Other(35)]);
        assert_eq!(read_all(Some(Kind::Camera), Release::R2023b, &[1, 32, 0]).unwrap(), [Order::Sample(32)]);
    }

    #[test]
    fn behind_an_unknown_order_the_rest_of_the_payload_is_left_out() {
        assert_eq!(read_all(Some(Kind::Speaker), Release::R2023b, &[9, 1, 2]).unwrap(), [Order::Other(9)]);
        assert!(read_all(Some(Kind::Motor), Release::R2023b, &[1, 0, 0]).is_err());
    }

    proptest! {
        #[test]
        fn no_bytes_make_the_decoder_fall(bytes in proptest::collection::vec(any::<u8>(), 0..50), kind in 0..12_usize) {
            let kind = Kind::ALL.get(kind).map(|(_, kind)| *kind);
            let _ = read_all(kind, Release::R2025a, &bytes);
        }
    }
}
