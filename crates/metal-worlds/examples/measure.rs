//! Measures the highway: speed, the expert advisor on every road set, and each action driven blindly.
//!
//! `cargo run --release -p metal-worlds --example measure -- 300`

use metal_rl::environment::{End, Environment, EnvironmentError};
use metal_worlds::highway::{Highway, HighwayConfig, MotorAction, RoadSet, Scenario, Steering};
use std::io::Write;
use std::time::Instant;

type Policy<'a> = &'a mut dyn FnMut(&mut Highway) -> usize;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let runs: u64 = std::env::args().nth(1).map_or(Ok(300), |text| text.parse())?;
    let mut out = std::io::stdout().lock();
    speed(&mut out)?;
    for (name, roads) in
        [("training", RoadSet::Training), ("validation", RoadSet::Validation), ("test", RoadSet::Test)]
    {
        let world = Highway::new(HighwayConfig::new(roads.clone(), Scenario::Mix), Steering::Scripted);
        for scenario in Scenario::ALL {
            let config = HighwayConfig::new(roads.clone(), scenario);
            let mut world = Highway::on_roads(config, world.grounds(), Steering::Scripted);
            let expert = drive(&mut world, runs, &mut |w| w.advise().expect("the highway has an expert"))?;
            writeln!(out, "{name:10} {scenario:?} expert {expert}")?;
            for action in MotorAction::ALL.into_iter().filter(|_| name == "training") {
                let blind = drive(&mut world, runs, &mut |_| action as usize)?;
                writeln!(out, "{name:10} {scenario:?} {} {blind}", action.name())?;
            }
        }
    }
    Ok(())
}

/// Mean motor reward per step and share of runs with an accident (and with one of the learner's own fault).
fn drive(world: &mut Highway, runs: u64, policy: Policy) -> Result<String, EnvironmentError> {
    let column = |name: &str| world.spec().measure(name).expect("a measure of the highway");
    let (accident, fault, off) = (column("accident"), column("fault"), column("off_road"));
    let (mut sum, mut steps, mut accidents, mut faults, mut offs) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for seed in 0..runs {
        world.reset(1_000_000 + seed)?;
        let (mut hit, mut own) = (0.0_f64, 0.0_f64);
        loop {
            let action = policy(world);
            let outcome = world.step(action)?;
            sum += outcome.motor_reward;
            steps += 1.0;
            offs += world.measures()[off];
            hit = hit.max(world.measures()[accident]);
            own = own.max(world.measures()[fault]);
            if outcome.end != End::Running {
                break;
            }
        }
        accidents += hit;
        faults += own;
    }
    let runs = runs as f64;
    Ok(format!(
        "motor {:.2} accident {:.3} own fault {:.3} off-road {:.3}",
        sum / steps,
        accidents / runs,
        faults / runs,
        offs / steps
    ))
}

/// Steps per second with no sensor read, with each vision region read, and with the expert asked.
fn speed(out: &mut impl Write) -> Result<(), Box<dyn std::error::Error>> {
    let mut world = Highway::new(HighwayConfig::default(), Steering::Scripted);
    for (name, sensors, advised) in
        [("no look", 0, false), ("six regions", 6, false), ("all seven", 7, false), ("expert", 0, true)]
    {
        let begin = Instant::now();
        let steps = 100_000_u64;
        for step in 0..steps {
            if step % 50 == 0 {
                world.reset(step)?;
            }
            let mut reading = [0.0; 8];
            for sensor in 0..sensors {
                let features = world.spec().sensors[sensor].features.len();
                world.sense(sensor, &mut reading[..features])?;
            }
            let action = if advised { world.advise().unwrap_or(0) } else { (step % 5) as usize };
            world.step(action)?;
        }
        writeln!(out, "{name}: {:.0} steps/s", steps as f64 / begin.elapsed().as_secs_f64())?;
    }
    Ok(())
}
