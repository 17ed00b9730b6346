//! Writes the seeds of every corpus: good bytes, from which a fuzzer goes astray. `cargo run --bin seeds`.

use metal_lab::progress::Silent;
use metal_lab::{plan, train};
use metal_recording::{Recorder, Tape};
use metal_rl::environment::Environment;
use metal_rl::random::Streams;
use metal_worlds::highway::{Highway, HighwayConfig, RoadSet, Scenario, Steering};
use std::path::{Path, PathBuf};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let put = |target: &str, name: &str, bytes: &[u8]| -> std::io::Result<()> {
        let folder: PathBuf = here.join("corpus").join(target);
        std::fs::create_dir_all(&folder)?;
        std::fs::write(folder.join(name), bytes)
    };
    for entry in std::fs::read_dir(here.join("../experiments"))? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        put("experiment", &name, &std::fs::read(&path)?)?;
    }
    put("checkpoint", "mind", &mind()?)?;
    for (judge, name) in [(0, "roll-outs"), (1, "critic")] {
        let course = metal_fuzz::targets::course::one_iteration(judge == 1, None)?.unwrap_or_default();
        put("course", name, &[&[judge], &*course].concat())?;
    }
    put("csv", "words.csv", b"a,b,class\n1,red,yes\n2,blue,no\n?,red,yes\n4,,no\n")?;
    put("csv", "numbers.csv", b"x,class\n0.5,1\n-1e300,2\n3,1\n4,2\n5,1\n")?;
    put("demonstration", "maze.jsonl", demonstration()?.as_bytes())?;
    put("recording", "road.mcap", &recording()?)?;
    put("request", "all.jsonl", REQUESTS.as_bytes())?;
    Ok(())
}

const REQUESTS: &str = r#"{"do":"speed","times":4}
{"do":"step"}
{"do":"fault","sensor":2,"fault":"blind"}
{"do":"place","body":1,"x":0.5,"y":-0.2,"heading":1.5}
{"do":"scene","index":2}
{"do":"scenario","name":"approaching"}
{"do":"demonstrate"}
{"do":"press","action":3}
{"do":"undo"}
{"do":"watch","driver":1}
{"do":"compare","driver":2}
{"do":"reset"}
{"do":"recall","decision":3}
{"do":"pace","steps_per_sec":0}
"#;

fn mind() -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let plan = plan::parse(include_str!("../../mind.toml"), &[])?;
    let trained = train::train_seed(&plan, &Streams::new(1), &Silent)?;
    let phase = &trained["attention"];
    let episodes = &phase.trace.episodes[..2];
    Ok(postcard::to_stdvec(&(phase.mind.freeze_for(&plan), episodes))?)
}

fn demonstration() -> Result<String, Box<dyn std::error::Error>> {
    let spec = plan::parse(include_str!("../../mind.toml"), &[])?.spec;
    let header = serde_json::to_string(&metal_lab::demonstrations::Header::new(&spec))?;
    let end = r#""motor_reward":-1.0,"end":"#;
    Ok(format!(
        "{header}\n{{\"episode\":0,\"step\":0,\"readings\":[[1],[2]],\"action\":1,{end}\"Running\"}}\n\
         {{\"episode\":0,\"step\":1,\"readings\":[[1],[3]],\"action\":0,{end}\"Terminal\"}}\n"
    ))
}

fn recording() -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let path = std::env::temp_dir().join(format!("metal-seed-{}.mcap", std::process::id()));
    let world = Highway::new(HighwayConfig::new(RoadSet::Seeds(vec![1]), Scenario::Mix), Steering::Scripted);
    let tape = Tape::create(&path, world.spec())?;
    let mut world = Recorder::new(world, tape.clone());
    world.reset(1)?;
    for _ in 0..2 {
        let mut out = [0.0; 4];
        world.sense(0, &mut out)?;
        world.step(1)?;
    }
    tape.finish()?;
    let bytes = std::fs::read(&path)?;
    std::fs::remove_file(&path)?;
    Ok(bytes)
}
