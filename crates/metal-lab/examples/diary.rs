//! How a student was taught, iteration by iteration: itself, or a rival with fixed sensors by the same recipe.
//!
//! `cargo run --release -p metal-lab --example diary -- experiments/attention.toml 1 adaptive MF+RF/2`
//!
//! `runs=1000` among the words: tested at the end in so many runs instead of 300. `log=FILE.csv`: every step of these tests, with what was
//! read and where the robot was (`tools/what_looks_tell.py`). Other words with `=` are settings of the experiment.
//! The seed (or `1/3`: training 3, counted from 0, of a run with seed 1) is followed by whom to teach: `adaptive`, or the
//! sensors to look at, with `/k` at every k-th motor step only.
//! Costs are those on validation roads, and so is the anatomy of the best student that follows: what it pays for, and
//! when it looks.
#![allow(clippy::print_stdout)]
#![expect(clippy::print_stdout, reason = "a program that prints")]

use metal_lab::evaluate::{Candidate, Course, watch};
use metal_lab::plan::{self, Plan};
use metal_lab::progress::Silent;
use metal_lab::registry::Roads;
use metal_lab::reproduce::seed_streams;
use metal_lab::reproduce::subsets::{Rival, train_subset};
use metal_lab::train::{Trained, train_up_to};
use metal_rl::environment::EnvironmentSpec;
use metal_rl::observe::{Observer, Step};
use metal_rl::random::Streams;
use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let file = words.next().ok_or("which experiment file?")?;
    let seed = words.next().ok_or("which seed?")?;
    let streams = match seed.split_once('/') {
        Some((run, training)) => seed_streams(run.parse()?, training.parse()?),
        None => Streams::new(seed.parse()?),
    };
    let (settings, pupils): (Vec<String>, Vec<String>) = words.partition(|w| w.contains('='));
    let word = |name: &str| settings.iter().find_map(|w| w.strip_prefix(name)?.strip_prefix('='));
    let exam = Exam { runs: word("runs").map_or(Ok(300), str::parse)?, log: word("log").map(PathBuf::from) };
    let own = |w: &String| w.starts_with("runs=") || w.starts_with("log=");
    let settings: Vec<String> = settings.iter().filter(|w| !own(w)).cloned().collect();
    let plan = plan::load(Path::new(&file), &settings)?;
    for pupil in pupils {
        println!("{pupil}, seed {seed}");
        teach(&plan, &pupil, (&exam, &streams))?;
    }
    Ok(())
}

/// How a student is dissected.
struct Exam {
    runs: usize,
    log: Option<PathBuf>,
}

/// Teaches `pupil`, and shows its diary and its anatomy.
fn teach(plan: &Plan, pupil: &str, (exam, streams): (&Exam, &Streams)) -> Result<(), Box<dyn Error>> {
    if pupil == "adaptive" {
        let phase = plan.file.phase.get("attention").ok_or("the file has no phase `attention`")?;
        let trained = train_up_to(plan, "attention", streams, &Silent)?;
        print(&trained);
        let roster = plan.roster(&phase.roster);
        let candidate = Candidate { plan, mind: &trained.mind, acting: &phase.acting, roster, blind: 0 };
        return dissect(&candidate, (exam, streams));
    }
    let rows = plan.file.subsets.as_ref().ok_or("the file has no [subsets]")?;
    let subset =
        train_subset(plan, rows, (Rival::parse(plan, "whom to teach", pupil)?, 1.0), streams, &Silent)?;
    print(&subset.trained);
    dissect(&subset.candidate(), (exam, streams))
}

fn print(trained: &Trained) {
    println!("   share   idle   loss    total    motor  looks  rolled");
    for i in &trained.diary {
        println!(
            "  {:6.2} {:6.2} {:6.3} {:8.2} {:8.2} {:6.2} {:7}",
            i.price_share, i.idle, i.loss, i.total, i.motor, i.looks, i.rolled_steps
        );
    }
    let best = trained.diary.iter().max_by(|a, b| a.total.total_cmp(&b.total));
    if let Some(best) = best {
        println!("best: {:.2} (motor {:.2}, {:.2} looks)", best.total, best.motor, best.looks);
    }
}

/// Steps since the last look that are told apart; all later ones are one.
const AGES: usize = 6;
/// Gaps to the nearest car that are told apart, in metres; what is farther is one.
const GAPS_M: [f64; 4] = [0.1, 0.25, 0.5, 1.0];
/// Motor steps since the start at which parts of a run begin that are told apart: out of the wrong lane, to the car, past it.
const PARTS: [usize; 4] = [0, 7, 10, 20];

fn dissect(candidate: &Candidate<'_>, (exam, streams): (&Exam, &Streams)) -> Result<(), Box<dyn Error>> {
    let measures = &candidate.plan.spec.measures;
    let column = |name: &str| measures.iter().position(|m| m == name);
    let mut anatomy = Anatomy {
        kinds: ["cost_accident", "cost_road", "cost_lane", "cost_smooth"].map(column),
        gap: column("gap_m"),
        log: exam.log.as_deref().map(|path| Log::new(path, &candidate.plan.spec)).transpose()?,
        ..Anatomy::default()
    };
    let course = Course { scenario: "mix".to_owned(), roads: Roads::Validation, runs: exam.runs };
    watch(candidate, &course, &streams.child("anatomy"), &mut anatomy)?;
    anatomy.print();
    Ok(anatomy.log.map_or(Ok(()), Log::finish)?)
}

/// Every step as a line of a CSV file: what was read (empty where nobody looked), what was done, and all measures after it.
struct Log {
    out: BufWriter<File>,
    features: Vec<usize>,
    written: std::io::Result<()>,
}

impl Log {
    fn new(path: &Path, spec: &EnvironmentSpec) -> std::io::Result<Self> {
        let mut out = BufWriter::new(File::create(path)?);
        let readings = spec
            .sensors
            .iter()
            .flat_map(|s| s.features.iter().map(move |f| format!("{}.{}", s.name, f.name)));
        let names: Vec<String> = readings.chain(spec.measures.iter().cloned()).collect();
        writeln!(out, "episode,step,action,{}", names.join(","))?;
        Ok(Self { out, features: spec.sensors.iter().map(|s| s.features.len()).collect(), written: Ok(()) })
    }

    fn write(&mut self, step: &Step<'_>) -> std::io::Result<()> {
        write!(self.out, "{},{},{}", step.episode, step.index, step.action)?;
        for (sensor, &features) in self.features.iter().enumerate() {
            let reading = step.percept.reading(sensor);
            for at in 0..features {
                write!(self.out, ",{}", reading.map_or_else(String::new, |r| r[at].to_string()))?;
            }
        }
        step.measures.iter().try_for_each(|x| write!(self.out, ",{x}"))?;
        writeln!(self.out)
    }

    fn finish(mut self) -> std::io::Result<()> {
        self.written?;
        self.out.flush()
    }
}

/// Steps, looks and cost of some class of moments.
#[derive(Clone, Copy, Default)]
struct Class {
    steps: f64,
    looks: f64,
    cost: f64,
    paid: f64,
}

impl Class {
    fn add(&mut self, step: &Step<'_>) {
        self.steps += 1.0;
        self.looks += step.percept.read().len() as f64;
        self.cost -= step.motor_reward;
        self.paid += step.look_price;
    }

    fn print(&self, name: &str, all: f64) {
        let per = |sum: f64| sum / self.steps.max(1.0);
        let share = self.steps / all.max(1.0);
        println!(
            "  {name:12} {share:6.3} of steps, {:5.2} looks for {:6.3}, cost {:6.3}",
            per(self.looks),
            per(self.paid),
            per(self.cost)
        );
    }
}

/// A part of all runs: its steps, and what is paid for in it.
#[derive(Clone, Copy, Default)]
struct Part {
    class: Class,
    costs: [f64; 4],
}

/// What a driver pays for, and when it looks.
#[derive(Default)]
struct Anatomy {
    kinds: [Option<usize>; 4],
    gap: Option<usize>,
    costs: [f64; 4],
    paid: f64,
    all: Class,
    ages: [Class; AGES],
    gaps: [Class; GAPS_M.len() + 1],
    parts: [Part; PARTS.len()],
    seen: Vec<f64>,
    age: usize,
    last_gap: f64,
    log: Option<Log>,
}

impl Observer for Anatomy {
    fn on_step(&mut self, step: &Step<'_>) {
        if let Some(log) = self.log.as_mut().filter(|log| log.written.is_ok()) {
            log.written = log.write(step);
        }
        if step.index == 0 {
            (self.age, self.last_gap) = (AGES - 1, f64::INFINITY);
        }
        let part = &mut self.parts[PARTS.partition_point(|&begin| begin <= step.index) - 1];
        part.class.add(step);
        for (kind, column) in self.kinds.into_iter().enumerate() {
            let cost = column.map_or(0.0, |c| step.measures[c]);
            self.costs[kind] += cost;
            part.costs[kind] += cost;
        }
        let read = step.percept.read();
        self.age = if read.is_empty() { (self.age + 1).min(AGES - 1) } else { 0 };
        for sensor in read.iter() {
            self.seen.resize(self.seen.len().max(sensor + 1), 0.0);
            self.seen[sensor] += 1.0;
        }
        self.paid += step.look_price;
        self.all.add(step);
        self.ages[self.age].add(step);
        let bucket = GAPS_M.iter().position(|&gap| self.last_gap < gap).unwrap_or(GAPS_M.len());
        self.gaps[bucket].add(step);
        self.last_gap = self.gap.map_or(f64::INFINITY, |c| step.measures[c]);
    }
}

impl Anatomy {
    fn print(&self) {
        let n = self.all.steps.max(1.0);
        let [accident, road, lane, smooth] = self.costs.map(|cost| cost / n);
        let (motor, looks) = (-self.all.cost / n, self.all.looks / n);
        println!("anew: {:.3} (motor {motor:.3}, {looks:.3} looks)", motor - self.paid / n);
        println!("  accident {accident:.2}, road {road:.2}, lane {lane:.2}, smooth {smooth:.2}");
        self.all.print("all", n);
        for (age, class) in self.ages.iter().enumerate() {
            class.print(&format!("unseen {age}"), n);
        }
        for (i, class) in self.gaps.iter().enumerate() {
            class.print(&GAPS_M.get(i).map_or("far".to_owned(), |gap| format!("gap < {gap}")), n);
        }
        for (begin, part) in PARTS.iter().zip(&self.parts) {
            part.class.print(&format!("from step {begin}"), n);
            let [accident, road, lane, smooth] = part.costs.map(|cost| cost / part.class.steps.max(1.0));
            println!("{:15}accident {accident:.2}, road {road:.2}, lane {lane:.2}, smooth {smooth:.2}", "");
        }
        let seen: Vec<String> = self.seen.iter().map(|looks| format!("{:.2}", looks / n)).collect();
        println!("  looks per sensor: {}", seen.join(" "));
    }
}
