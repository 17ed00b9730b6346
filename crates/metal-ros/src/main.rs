//! `metal-ros`: METAL bodies and minds in ROS 2.

use anyhow::{Context, bail, ensure};
use clap::{Parser, Subcommand, ValueEnum};
use metal_lab::evaluate::{Candidate, drive};
use metal_lab::store::Store;
use metal_rl::environment::Environment;
use metal_rl::random::Streams;
use metal_robots::link::Patience;
use metal_robots::{Address, Body, Calibration, Emergency, Guard, Limits, RobotConfig, RobotEnvironment};
use metal_ros::body::BodyNode;
use metal_ros::mind::{Attention, Told};
use metal_ros::node::{Node, Place};
use metal_worlds::highway::{HighwayConfig, RoadSet, Scenario};
use ros2_client::ServiceMapping;
use std::path::PathBuf;

/// METAL bodies and minds in ROS 2: no ROS needs to be installed here.
#[derive(Debug, Parser)]
#[command(version, about)]
struct Arguments {
    #[command(subcommand)]
    what: What,
    /// epuck:///dev/rfcomm0, epuck2://HOST:PORT or webots://HOST:PORT/NAME
    #[arg(long, global = true, default_value = "epuck2://127.0.0.1:11000", value_name = "ADDRESS")]
    robot: Address,
    /// A file that `metal calibrate` wrote
    #[arg(long, global = true, value_name = "FILE")]
    calibration: Option<PathBuf>,
    /// Namespace of the topics
    #[arg(long, global = true, default_value = "/")]
    namespace: String,
    /// DDS domain
    #[arg(long, global = true, env = "ROS_DOMAIN_ID", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=232))]
    domain: u16,
    /// Whose services: they are spoken differently
    #[arg(long, global = true, value_enum, default_value_t = Services::Fast)]
    services: Services,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Services {
    /// Fast DDS (the default of ROS 2) and Connext
    Fast,
    /// Cyclone DDS
    Cyclone,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Give the body to ROS: cmd_vel, led0..7 and reset in; pictures, ranges, odometry … out
    Body,
    /// Let a trained mind drive it, and tell what it attends to
    Mind {
        /// A folder that `metal reproduce` or `metal run` wrote
        #[arg(long)]
        run: PathBuf,
        /// Who drives, as the run's plan names it
        #[arg(long, default_value = "acl")]
        policy: String,
        /// Episodes
        #[arg(long, default_value_t = 1, value_name = "N")]
        episodes: usize,
        /// Motor steps of an episode
        #[arg(long, default_value_t = 50, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
        steps: u32,
    },
}

fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    let emergency = Emergency::default();
    let button = emergency.clone();
    ctrlc::set_handler(move || button.press()).context("cannot listen to Ctrl-C")?;
    let body = arguments.robot.connect(Patience::default())?;
    let calibration = calibration(&arguments, body.as_ref())?;
    let guard = Guard::new(body, Limits::default(), emergency.clone())?;
    let services = match arguments.services {
        Services::Fast => ServiceMapping::Enhanced,
        Services::Cyclone => ServiceMapping::Cyclone,
    };
    let place = Place { namespace: arguments.namespace, domain: arguments.domain, services };
    match &arguments.what {
        What::Body => give(Node::enter("epuck_driver", place)?, (guard, calibration), &emergency),
        What::Mind { .. } => let_drive(Node::enter("metal", place)?, (guard, calibration), &arguments.what),
    }
}

fn calibration(arguments: &Arguments, body: &dyn Body) -> anyhow::Result<Calibration> {
    let Some(file) = &arguments.calibration else { return Ok(Calibration::of(body.infrared_scale())) };
    let text = std::fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))?;
    Calibration::from_toml(&text).with_context(|| file.display().to_string())
}

fn give(node: Node, (guard, calibration): (Guard, Calibration), end: &Emergency) -> anyhow::Result<()> {
    let mut node = BodyNode::new(node, guard, calibration)?;
    loop {
        match node.round() {
            // Ctrl-C is a good end.
            _ if end.pressed() => return Ok(()),
            outcome => outcome?,
        }
    }
}

fn let_drive(mut node: Node, (guard, calibration): (Guard, Calibration), what: &What) -> anyhow::Result<()> {
    let What::Mind { run, policy, episodes, steps } = what else { bail!("nobody shall drive") };
    let store = Store::open(run)?;
    let (plan, card) = store.read_run()?;
    let row = plan.file.policy.get(policy).with_context(|| format!("--policy {policy}: not in the plan"))?;
    let phase = row.after.as_ref().with_context(|| format!("--policy {policy}: it learned in no phase"))?;
    let mind = store.read_mind(&plan, 0, phase)?;
    let roads = RoadSet::Seeds(vec![1]);
    let highway = HighwayConfig { horizon: *steps as usize, ..HighwayConfig::new(roads, Scenario::Mix) };
    let world = RobotEnvironment::new(guard, RobotConfig { highway, calibration, grounds: None })?;
    let spec = world.spec().clone();
    ensure!(plan.spec.sensors == spec.sensors, "the mind of {} has other sensors than a body", run.display());
    let (acting, roster) = (&row.acting, plan.roster(&row.roster));
    let candidate = Candidate { plan: &plan, mind: &mind, acting, roster, blind: card.blind };
    let members = mind.members.iter().map(|member| member.name.clone()).collect();
    let mut attention = Attention::open(&mut node, &spec, members)?;
    let mut world = Told::open(&mut node, world)?;
    drive(&candidate, &mut world, (*episodes, &Streams::new(card.seed).child("drive")), &mut attention)?;
    Ok(())
}
