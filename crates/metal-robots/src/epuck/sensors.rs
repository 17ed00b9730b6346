//! The block of 104 bytes that holds every sensor of an e-puck2 except the camera.

use crate::bytes::{Reader, Writer};
use crate::error::ProtocolError;

/// Length of the block, in bytes.
pub const BYTES: usize = 104;

/// Every sensor of an e-puck2 except the camera, in the units of the wire.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sensors {
    /// Acceleration along x, y and z; ±1500 is ±2 g.
    pub acceleration_raw: [i16; 3],
    /// Length of the acceleration.
    pub acceleration: f32,
    /// Direction of the inclination, 0 to 360 degrees.
    pub orientation_deg: f32,
    /// Inclination, in degrees.
    pub inclination_deg: f32,
    /// Turning rates; the full range is ±250 degrees per second.
    pub gyro_raw: [i16; 3],
    /// Magnetic field, in microtesla.
    pub magnetic_ut: [f32; 3],
    /// Temperature, in degrees Celsius.
    pub temperature_c: i8,
    /// Infra-red reflection of ps0 … ps7, 0 to 4095.
    pub proximity: [u16; 8],
    /// Ambient light of ps0 … ps7, 0 to 4095.
    pub ambient: [u16; 8],
    /// Distance of the time-of-flight sensor, in millimetres.
    pub distance_mm: u16,
    /// Loudness of the four microphones.
    pub microphones: [u16; 4],
    /// Steps the left and the right wheel made (1000 a turn).
    pub steps: [i16; 2],
    /// Battery, in units of its converter.
    pub battery_raw: u16,
    /// 1 if the memory card answers.
    pub memory_card: u8,
    /// Check, address and data byte of the infra-red remote control.
    pub remote: [u8; 3],
    /// Position of the selector, 0 to 15.
    pub selector: u8,
    /// Reflection of the three ground sensors, 0 to 1023.
    pub ground: [u16; 3],
    /// Ambient light at the three ground sensors.
    pub ground_ambient: [u16; 3],
    /// 1 while the button is pressed.
    pub button: u8,
}

impl Sensors {
    /// The 104 bytes.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let mut w = Writer::new();
        let put_u16 = |w: &mut Writer, values: &[u16]| values.iter().for_each(|&v| drop_ref(w.u16(v)));
        self.acceleration_raw.iter().for_each(|&v| drop_ref(w.i16(v)));
        w.f32(self.acceleration).f32(self.orientation_deg).f32(self.inclination_deg);
        self.gyro_raw.iter().for_each(|&v| drop_ref(w.i16(v)));
        self.magnetic_ut.iter().for_each(|&v| drop_ref(w.f32(v)));
        w.raw(&self.temperature_c.to_le_bytes());
        put_u16(&mut w, &self.proximity);
        put_u16(&mut w, &self.ambient);
        w.u16(self.distance_mm);
        put_u16(&mut w, &self.microphones);
        w.i16(self.steps[0]).i16(self.steps[1]).u16(self.battery_raw).u8(self.memory_card);
        w.raw(&self.remote).u8(self.selector);
        put_u16(&mut w, &self.ground);
        put_u16(&mut w, &self.ground_ambient);
        w.u8(self.button).u8(0);
        w.into_bytes()
    }

    /// The meaning of 104 bytes (the last one is reserved).
    ///
    /// # Errors
    /// If there are fewer.
    pub fn decode(bytes: &[u8]) -> Result<Self, ProtocolError> {
        let mut r = Reader::new(bytes);
        let sensors = Self {
            acceleration_raw: r.many(Reader::i16)?,
            acceleration: r.f32()?,
            orientation_deg: r.f32()?,
            inclination_deg: r.f32()?,
            gyro_raw: r.many(Reader::i16)?,
            magnetic_ut: r.many(Reader::f32)?,
            temperature_c: i8::from_le_bytes([r.u8()?]),
            proximity: r.many(Reader::u16)?,
            ambient: r.many(Reader::u16)?,
            distance_mm: r.u16()?,
            microphones: r.many(Reader::u16)?,
            steps: r.many(Reader::i16)?,
            battery_raw: r.u16()?,
            memory_card: r.u8()?,
            remote: r.many(Reader::u8)?,
            selector: r.u8()?,
            ground: r.many(Reader::u16)?,
            ground_ambient: r.many(Reader::u16)?,
            button: r.u8()?,
        };
        r.u8()?;
        Ok(sensors)
    }
}

/// Ends a chain of writes inside a closure that must give nothing back.
fn drop_ref(_: &mut Writer) {}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn every_sensor_is_at_its_offset() {
        let sensors = Sensors {
            proximity: [0x0102; 8],
            ambient: [0x0304; 8],
            distance_mm: 0x0506,
            steps: [-2, 258],
            battery_raw: 0x0708,
            selector: 15,
            ground: [0x090A; 3],
            button: 1,
            ..Sensors::default()
        };
        let bytes = sensors.encode();
        assert_eq!(bytes.len(), BYTES);
        assert_eq!(bytes[37..39], [2, 1]);
        assert_eq!(bytes[53..55], [4, 3]);
        assert_eq!(bytes[69..71], [6, 5]);
        assert_eq!(bytes[79..83], [0xFE, 0xFF, 2, 1]);
        assert_eq!(bytes[83..85], [8, 7]);
        assert_eq!((bytes[89], bytes[90], bytes[91], bytes[102]), (15, 0x0A, 0x09, 1));
        assert!(Sensors::decode(&bytes[..103]).is_err());
    }

    proptest! {
        #[test]
        fn any_bytes_keep_their_meaning(mut bytes in proptest::collection::vec(any::<u8>(), BYTES)) {
            let sensors = Sensors::decode(&bytes).unwrap();
            bytes[BYTES - 1] = 0;
            // Bits, not floats: a sensor may send any NaN.
            prop_assert_eq!(sensors.encode(), bytes);
        }
    }
}
