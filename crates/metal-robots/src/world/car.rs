//! Our own miniature car for Webots, with the sizes of an E-puck.

use super::{CAMERA_RAD, HEADER};
use crate::bodies::webots::{LEFT_MOTOR, RIGHT_MOTOR};
use metal_rl::num;
use metal_worlds::highway::camera::{AHEAD_M, COLUMNS, HEIGHT_M, ROWS};
use metal_worlds::highway::infrared::{ELEVATION_DEG, MOUNTS, TABLE};
use metal_worlds::highway::kinematics::{AXLE_M, BODY_RADIUS_M, WHEEL_LIMIT_MPS};

/// Radius of a wheel, in metres.
const WHEEL_M: f64 = 0.02;
/// Distance of lens and infra-red sensors from the axis: outside of the body, or they would see it.
const OUTSIDE_M: f64 = BODY_RADIUS_M + 0.0015;

/// The PROTO file, with marks where numbers come from the simulator's own code.
const TEMPLATE: &str = include_str!("../../assets/MiniCar.proto");

/// The PROTO file.
#[must_use]
pub fn mini_car() -> String {
    let [view, pitch] = CAMERA_RAD;
    let wheels: String = [("left", LEFT_MOTOR, 0.5), ("right", RIGHT_MOTOR, -0.5)]
        .map(|(side, motor, y)| wheel(side, motor, y * AXLE_M))
        .concat();
    let ring: String = (0..MOUNTS.len()).map(infrared).collect();
    let lens = OUTSIDE_M.max(AHEAD_M);
    let values = [
        ("%HEADER%", HEADER.to_owned()),
        ("%BODY_RADIUS_M%", BODY_RADIUS_M.to_string()),
        ("%HEIGHT_M%", HEIGHT_M.to_string()),
        ("%COLUMNS%", COLUMNS.to_string()),
        ("%ROWS%", ROWS.to_string()),
        ("%LENS%", lens.to_string()),
        ("%PITCH%", pitch.to_string()),
        ("%VIEW%", view.to_string()),
        ("%WHEELS%", wheels),
        ("%RING%", ring),
    ];
    values.into_iter().fold(TEMPLATE.to_owned(), |text, (mark, value)| text.replace(mark, &value))
}

fn wheel(side: &str, motor: &str, y_m: f64) -> String {
    let most = WHEEL_LIMIT_MPS / WHEEL_M;
    format!(
        r#"      HingeJoint {{
        jointParameters HingeJointParameters {{
          axis 0 1 0
          anchor 0 {y_m} {WHEEL_M}
        }}
        device [
          RotationalMotor {{
            name "{motor}"
            maxVelocity {most}
          }}
          PositionSensor {{
            name "{side} wheel sensor"
            resolution 0.00628
          }}
        ]
        endPoint Solid {{
          translation 0 {y_m} {WHEEL_M}
          rotation 1 0 0 1.5707963267948966
          children [
            Shape {{
              appearance PBRAppearance {{
                baseColor 0.1 0.1 0.1
                roughness 1
                metalness 0
              }}
              geometry DEF {upper}_WHEEL Cylinder {{
                height 0.005
                radius {WHEEL_M}
              }}
            }}
          ]
          name "{side} wheel"
          boundingObject USE {upper}_WHEEL
          physics Physics {{
            density -1
            mass 0.005
          }}
        }}
      }}
"#,
        upper = side.to_uppercase()
    )
}

fn infrared(i: usize) -> String {
    let [x, y, azimuth_deg] = MOUNTS[i];
    let out = OUTSIDE_M / num::hypot(x, y);
    let (x_m, y_m) = (x * out, y * out);
    let (turn, rise) = (azimuth_deg.to_radians(), ELEVATION_DEG.to_radians());
    let table: Vec<String> = TABLE.iter().map(|[d, r, n]| format!("{d} {r} {n}")).collect();
    let [ax, ay, az, angle] = turned_then_raised(turn, rise);
    format!(
        r#"      DistanceSensor {{
        translation {x_m} {y_m} 0.033
        rotation {ax} {ay} {az} {angle}
        name "ps{i}"
        type "infra-red"
        aperture 0.1
        lookupTable [ {} ]
      }}
"#,
        table.join(", ")
    )
}

/// Axis and angle of a turn to the left about the vertical after the beam was raised.
fn turned_then_raised(turn: f64, rise: f64) -> [f64; 4] {
    let ((st, ct), (sr, cr)) = (num::sin_cos(0.5 * turn), num::sin_cos(-0.5 * rise));
    // The product of the quaternions of both: turn · raise.
    let (w, x, y, z) = (ct * cr, -st * sr, ct * sr, st * cr);
    let sine = (x * x + y * y + z * z).sqrt();
    [x / sine, y / sine, z / sine, 2.0 * num::atan2(sine, w)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_mark_is_left() {
        assert!(!mini_car().contains('%'));
    }

    #[test]
    fn a_sensor_looks_where_the_simulators_does() {
        for [_, _, azimuth] in MOUNTS {
            let [x, y, z, angle] = turned_then_raised(azimuth.to_radians(), ELEVATION_DEG.to_radians());
            // Rodrigues: what becomes of the x axis.
            let (sin, cos) = num::sin_cos(angle);
            let beam =
                [cos + x * x * (1.0 - cos), z * sin + x * y * (1.0 - cos), -y * sin + x * z * (1.0 - cos)];
            let flat = num::cos(ELEVATION_DEG.to_radians());
            let (st, ct) = num::sin_cos(azimuth.to_radians());
            assert!((beam[0] - flat * ct).abs() < 1e-12 && (beam[1] - flat * st).abs() < 1e-12);
            assert!((beam[2] - num::sin(ELEVATION_DEG.to_radians())).abs() < 1e-12, "it looks up");
        }
    }
}
