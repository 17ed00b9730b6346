//! Records two episodes in which the expert drives on the highway: `demonstration FILE.mcap`.

use metal_recording::{Recorder, Tape};
use metal_rl::environment::{End, Environment};
use metal_worlds::highway::{Highway, HighwayConfig, RoadSet, Scenario, Steering};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: demonstration FILE.mcap")?;
    let world = Highway::new(HighwayConfig::new(RoadSet::Seeds(vec![1]), Scenario::Mix), Steering::Scripted);
    let tape = Tape::create(path.as_ref(), world.spec())?;
    let mut world = Recorder::new(world, tape.clone());
    for seed in 0..2 {
        world.reset(seed)?;
        loop {
            for sensor in 0..world.spec().sensors.len() {
                let mut out = vec![0.0; world.spec().sensors[sensor].features.len()];
                world.sense(sensor, &mut out)?;
            }
            let action = world.advise().ok_or("the highway has an expert")?;
            if world.step(action)?.end != End::Running {
                break;
            }
        }
    }
    tape.finish()?;
    Ok(())
}
