//! A body as ROS users know it: `cmd_vel` and lights in, sensors out.
//!
//! Attention is physical here, too: what nobody subscribes to is not asked of the body. Wheels stop 500 ms after the last
//! `cmd_vel`, as behind every guard.

use crate::messages::{
    Bool, CameraInfo, CompressedImage, Illuminance, Image, Imu, Int32, LaserScan, Odometry, Range, TFMessage,
    TriggerRequest, TriggerResponse, Twist,
};
use crate::node::{Node, Outlet, header, last};
use crate::sense;
use anyhow::Context;
use metal_robots::body::{Feelings, INFRARED};
use metal_robots::{BodyError, Calibration, Guard, Wheels};
use metal_worlds::highway::Pose;
use metal_worlds::highway::camera::Window;
use metal_worlds::highway::kinematics::{AXLE_M, Twist as Motion, advance};
use ros2_client::{Server, Subscription};
use std::time::{Duration, Instant};

/// Time between two rounds, as the robot's driver has it.
pub const PERIOD: Duration = Duration::from_millis(64);
/// A step counter of 16 bits has run over if it seems to jump by more than this, in metres.
const OVERRUN_M: f64 = 4.1;
/// What such a counter counts in all, in metres.
const ROUND_TRIP_M: f64 = 65_536.0 / 1000.0 * 2.0 * std::f64::consts::PI * 0.02;

/// What is said.
struct Outlets {
    image: Outlet<Image>,
    compressed: Outlet<CompressedImage>,
    camera: Outlet<CameraInfo>,
    ring: Vec<Outlet<Range>>,
    light: Vec<Outlet<Illuminance>>,
    ground: Vec<Outlet<Range>>,
    ahead: Outlet<Range>,
    scan: Outlet<LaserScan>,
    odometry: Outlet<Odometry>,
    imu: Outlet<Imu>,
    frames: Outlet<TFMessage>,
    fixed: Outlet<TFMessage>,
}

/// What is heard.
struct Inlets {
    command: Subscription<Twist>,
    plain: Vec<(usize, Subscription<Bool>)>,
    coloured: Vec<(usize, Subscription<Int32>)>,
    reset: Server<TriggerRequest, TriggerResponse>,
}

/// A guarded body in the graph.
pub struct BodyNode {
    node: Node,
    outlets: Outlets,
    inlets: Inlets,
    guard: Guard,
    calibration: Calibration,
    home: Option<Vec<Pose>>,
    pose: Pose,
    rolled_m: Option<[f64; 2]>,
    wheels: Wheels,
    commanded: Instant,
}

fn each<T>(
    names: impl Iterator<Item = usize>,
    make: impl FnMut(usize) -> anyhow::Result<T>,
) -> anyhow::Result<Vec<T>> {
    names.map(make).collect()
}

impl Outlets {
    fn open(node: &mut Node) -> anyhow::Result<Self> {
        Ok(Self {
            image: node.outlet("image_raw")?,
            compressed: node.outlet("image_raw/compressed")?,
            camera: node.outlet("camera_info")?,
            ring: each(0..INFRARED, |i| node.outlet(&format!("ps{i}")))?,
            light: each(0..INFRARED, |i| node.outlet(&format!("ls{i}")))?,
            ground: each(0..3, |i| node.outlet(&format!("gs{i}")))?,
            ahead: node.outlet("tof")?,
            scan: node.outlet("scan")?,
            odometry: node.outlet("odom")?,
            imu: node.outlet("imu")?,
            frames: node.outlet("tf")?,
            fixed: node.latched("tf_static")?,
        })
    }
}

impl Inlets {
    fn open(node: &mut Node) -> anyhow::Result<Self> {
        let name = |i: usize| format!("led{i}");
        Ok(Self {
            command: node.inlet("cmd_vel")?,
            plain: each([0, 2, 4, 6].into_iter(), |i| Ok((i, node.inlet(&name(i))?)))?,
            coloured: each([1, 3, 5, 7].into_iter(), |i| Ok((i, node.inlet(&name(i))?)))?,
            reset: node.trigger("reset")?,
        })
    }
}

impl BodyNode {
    /// Opens all topics. The body stands.
    ///
    /// # Errors
    /// If the network or the body refuses.
    pub fn new(mut node: Node, guard: Guard, calibration: Calibration) -> anyhow::Result<Self> {
        let (outlets, inlets) = (Outlets::open(&mut node)?, Inlets::open(&mut node)?);
        let home = guard.with(|body| body.poses())?;
        outlets.fixed.say(TFMessage { transforms: sense::frames() });
        Ok(Self {
            node,
            outlets,
            inlets,
            guard,
            calibration,
            home,
            pose: Pose::default(),
            rolled_m: None,
            wheels: Wheels::STILL,
            commanded: Instant::now(),
        })
    }

    /// Hears, says, and lets one period pass.
    ///
    /// # Errors
    /// If the body fails; its wheels were told to stop then.
    pub fn round(&mut self) -> anyhow::Result<()> {
        let start = Instant::now();
        self.hear()?;
        self.say_ring()?;
        self.say_picture()?;
        self.say_rest()?;
        // In a simulator time passes only if it is let; a robot that was slow to answer has no time to wait.
        let simulated = self.guard.with(|body| Ok(body.name() == "webots"))?;
        let spent = if simulated { Duration::ZERO } else { start.elapsed() };
        let rest = PERIOD.saturating_sub(spent).as_secs_f64();
        self.guard.with(|body| body.pass(rest))?;
        if simulated {
            std::thread::sleep(PERIOD.saturating_sub(start.elapsed()));
        }
        Ok(())
    }

    fn hear(&mut self) -> anyhow::Result<()> {
        if let Some(Twist { linear, angular }) = last(&self.inlets.command) {
            let motion = Motion { speed_mps: linear.x, turn_radps: angular.z }.within_wheel_limits();
            self.wheels = Wheels::of(motion);
            self.commanded = Instant::now();
            self.guard.command(self.wheels).context("cmd_vel")?;
        }
        if self.commanded.elapsed() >= metal_robots::guard::SILENCE {
            self.wheels = Wheels::STILL;
        }
        for (which, inlet) in &self.inlets.plain {
            if let Some(Bool { data }) = last(inlet) {
                let rgb = if data { [255; 3] } else { [0; 3] };
                self.guard.with(|body| body.light(*which, rgb))?;
            }
        }
        for (which, inlet) in &self.inlets.coloured {
            if let Some(Int32 { data }) = last(inlet) {
                let [_, rgb @ ..] = data.to_be_bytes();
                self.guard.with(|body| body.light(*which, rgb))?;
            }
        }
        self.answer_reset()
    }

    fn answer_reset(&mut self) -> anyhow::Result<()> {
        let Ok(Some((id, _))) = self.inlets.reset.receive_request() else { return Ok(()) };
        self.guard.halt()?;
        self.wheels = Wheels::STILL;
        let placed = match &self.home {
            Some(home) => self.guard.with(|body| body.place(home))?,
            None => false,
        };
        (self.pose, self.rolled_m) = (Pose::default(), None);
        let message = if placed { "everybody is where they began" } else { "this body can only be carried" };
        let answer = TriggerResponse { success: placed, message: message.to_owned() };
        // Whoever asked may be gone.
        let _ = self.inlets.reset.send_response(id, answer);
        Ok(())
    }

    fn say_ring(&self) -> Result<(), BodyError> {
        let (ring, scan) = (&self.outlets.ring, &self.outlets.scan);
        let scanned = self.node.listened(scan);
        if !scanned && !ring.iter().any(|outlet| self.node.listened(outlet)) {
            return Ok(());
        }
        let readings = self.calibration.infrared(self.guard.with(|body| body.proximity())?);
        for (i, (outlet, reading)) in ring.iter().zip(readings).enumerate() {
            outlet.say(sense::range(&format!("ps{i}"), reading));
        }
        if scanned {
            scan.say(sense::scan(&readings, PERIOD.as_secs_f64()));
        }
        Ok(())
    }

    fn say_picture(&self) -> Result<(), BodyError> {
        let Outlets { image, compressed, camera, .. } = &self.outlets;
        let (raw, packed) = (self.node.listened(image), self.node.listened(compressed));
        if self.node.listened(camera) {
            camera.say(sense::camera_info());
        }
        if !raw && !packed {
            return Ok(());
        }
        let picture = self.guard.with(|body| body.picture(Window::WHOLE))?;
        if raw {
            image.say(sense::image(&picture));
        }
        if packed {
            compressed.say(sense::compressed(&picture));
        }
        Ok(())
    }

    fn say_rest(&mut self) -> Result<(), BodyError> {
        let out = &self.outlets;
        let way = self.node.listened(&out.odometry) || self.node.listened(&out.frames);
        let ranges = out.ground.iter().chain([&out.ahead]).any(|outlet| self.node.listened(outlet));
        let lights = out.light.iter().any(|outlet| self.node.listened(outlet));
        if !way && !ranges && !lights && !self.node.listened(&out.imu) {
            return Ok(());
        }
        let felt = self.guard.with(|body| body.feel())?;
        self.say_felt(&felt);
        self.go_on(felt.rolled_m);
        let odometry = sense::odometry(&self.pose, motion(self.wheels));
        let place = [self.pose.x_m, self.pose.y_m, 0.0];
        let frame = sense::transform("odom", "base_link", place, self.pose.heading_rad);
        self.outlets.odometry.say(odometry);
        self.outlets.frames.say(TFMessage { transforms: vec![frame] });
        Ok(())
    }

    fn say_felt(&self, felt: &Feelings) {
        if let Some(imu) = sense::imu(felt) {
            self.outlets.imu.say(imu);
        }
        if let Some(metres) = felt.ahead_m {
            self.outlets.ahead.say(sense::ahead(metres));
        }
        for (i, (outlet, reading)) in self.outlets.light.iter().zip(felt.ambient.iter().flatten()).enumerate()
        {
            let header = header(&format!("ls{i}"));
            outlet.say(Illuminance { header, illuminance: *reading, variance: 0.0 });
        }
        for (i, (outlet, reading)) in self.outlets.ground.iter().zip(felt.ground.iter().flatten()).enumerate()
        {
            // Raw: what a reading means depends on the floor.
            let header = header(&format!("gs{i}"));
            let range = *reading as f32;
            outlet.say(Range { header, radiation_type: 1, max_range: 1023.0, range, ..Range::default() });
        }
    }

    /// Follows the wheels.
    fn go_on(&mut self, rolled_m: Option<[f64; 2]>) {
        let Some(now) = rolled_m else { return };
        let before = self.rolled_m.replace(now).unwrap_or(now);
        let [left, right] = [0, 1].map(|i| unwrapped(now[i] - before[i]));
        // For one second: the ways are the speeds.
        let arc = Motion { speed_mps: 0.5 * (left + right), turn_radps: (right - left) / AXLE_M };
        self.pose = advance(self.pose, arc, 1.0);
    }
}

/// A way that a counter tells, also if it ran over.
fn unwrapped(metres: f64) -> f64 {
    if metres.abs() < OVERRUN_M { metres } else { metres - ROUND_TRIP_M * metres.signum() }
}

/// Speed and turning rate.
fn motion(wheels: Wheels) -> [f64; 2] {
    [0.5 * (wheels.left_mps + wheels.right_mps), (wheels.right_mps - wheels.left_mps) / AXLE_M]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counters_may_run_over() {
        assert_eq!(unwrapped(0.01), 0.01);
        let step = ROUND_TRIP_M / 65_536.0;
        assert!((unwrapped(-65_535.0 * step) - step).abs() < 1e-12);
        assert!((unwrapped(65_000.0 * step) + 536.0 * step).abs() < 1e-12);
    }
}
