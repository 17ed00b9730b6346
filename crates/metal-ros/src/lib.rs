//! METAL bodies and minds in ROS 2, over pure-Rust DDS: no installation of ROS is needed on this side.
//!
//! [`body`] gives any body to ROS users with the topics that the E-puck's own drivers have; [`mind`] lets a trained mind
//! drive and tells what it attends to. Names and types are those of `epuck_ros2` and `webots_ros2_epuck`.

pub mod body;
pub mod messages;
pub mod mind;
pub mod node;
pub mod sense;
