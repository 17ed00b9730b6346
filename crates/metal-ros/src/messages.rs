//! The ROS messages that are said and understood, field by field in their order on the wire.
#![allow(missing_docs, reason = "the fields are those of the ROS interfaces of the same names")]

use serde::{Deserialize, Serialize};

/// A message with its name in ROS: package and type.
pub trait Named {
    /// Package and type.
    const NAME: [&'static str; 2];
}

macro_rules! message {
    ($package:literal, $name:ident { $($field:ident: $kind:ty),* $(,)? }) => {
        #[doc = concat!("`", $package, "/", stringify!($name), "`")]
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        pub struct $name { $(pub $field: $kind),* }

        impl Named for $name {
            const NAME: [&'static str; 2] = [$package, stringify!($name)];
        }

        impl ros2_client::Message for $name {}
    };
}

/// A covariance of 3 by 3.
pub type Covariance3 = [f64; 9];
/// A covariance of 6 by 6, in rows.
pub type Covariance6 = [[f64; 6]; 6];

message!("builtin_interfaces", Time { sec: i32, nanosec: u32 });
message!("std_msgs", Header { stamp: Time, frame_id: String });
message!("std_msgs", Bool { data: bool });
message!("std_msgs", Int32 { data: i32 });
message!("std_msgs", MultiArrayDimension { label: String, size: u32, stride: u32 });
message!("std_msgs", MultiArrayLayout { dim: Vec<MultiArrayDimension>, data_offset: u32 });
message!("std_msgs", UInt8MultiArray { layout: MultiArrayLayout, data: Vec<u8> });
message!("geometry_msgs", Vector3 { x: f64, y: f64, z: f64 });
message!("geometry_msgs", Quaternion { x: f64, y: f64, z: f64, w: f64 });
message!("geometry_msgs", Twist { linear: Vector3, angular: Vector3 });
message!("geometry_msgs", Pose { position: Vector3, orientation: Quaternion });
message!("geometry_msgs", PoseWithCovariance { pose: Pose, covariance: Covariance6 });
message!("geometry_msgs", TwistWithCovariance { twist: Twist, covariance: Covariance6 });
message!("geometry_msgs", Transform { translation: Vector3, rotation: Quaternion });
message!("geometry_msgs", TransformStamped { header: Header, child_frame_id: String, transform: Transform });
message!("tf2_msgs", TFMessage { transforms: Vec<TransformStamped> });
message!(
    "nav_msgs",
    Odometry { header: Header, child_frame_id: String, pose: PoseWithCovariance, twist: TwistWithCovariance }
);
message!("sensor_msgs", Image {
    header: Header,
    height: u32,
    width: u32,
    encoding: String,
    is_bigendian: u8,
    step: u32,
    data: Vec<u8>,
});
message!("sensor_msgs", CompressedImage { header: Header, format: String, data: Vec<u8> });
message!(
    "sensor_msgs",
    RegionOfInterest { x_offset: u32, y_offset: u32, height: u32, width: u32, do_rectify: bool }
);
message!("sensor_msgs", CameraInfo {
    header: Header,
    height: u32,
    width: u32,
    distortion_model: String,
    d: Vec<f64>,
    k: [f64; 9],
    r: [f64; 9],
    p: [f64; 12],
    binning_x: u32,
    binning_y: u32,
    roi: RegionOfInterest,
});
// `variance` is the last field, and new in Jazzy: older readers leave it unread.
message!(
    "sensor_msgs",
    Range {
        header: Header,
        radiation_type: u8,
        field_of_view: f32,
        min_range: f32,
        max_range: f32,
        range: f32,
        variance: f32,
    }
);
message!("sensor_msgs", LaserScan {
    header: Header,
    angle_min: f32,
    angle_max: f32,
    angle_increment: f32,
    time_increment: f32,
    scan_time: f32,
    range_min: f32,
    range_max: f32,
    ranges: Vec<f32>,
    intensities: Vec<f32>,
});
message!("sensor_msgs", Illuminance { header: Header, illuminance: f64, variance: f64 });
message!(
    "sensor_msgs",
    Imu {
        header: Header,
        orientation: Quaternion,
        orientation_covariance: Covariance3,
        angular_velocity: Vector3,
        angular_velocity_covariance: Covariance3,
        linear_acceleration: Vector3,
        linear_acceleration_covariance: Covariance3,
    }
);

/// `std_msgs/String`
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Text {
    pub data: String,
}

impl Named for Text {
    const NAME: [&'static str; 2] = ["std_msgs", "String"];
}

impl ros2_client::Message for Text {}

/// The question of `std_srvs/Trigger`; an empty one has one byte on the wire.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TriggerRequest {
    pub structure_needs_at_least_one_member: u8,
}

/// The answer of `std_srvs/Trigger`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TriggerResponse {
    pub success: bool,
    pub message: String,
}

impl ros2_client::Message for TriggerRequest {}
impl ros2_client::Message for TriggerResponse {}
