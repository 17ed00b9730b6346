//! What each command does: call the lab, print.

use crate::args::{Aliasing, Arguments, Command, Comparing, Eval, Keeping, Reproduce, Run, Studio, Training};
use crate::bar::{Bar, INTERRUPTED};
use crate::{robots, table, transfer};
use anyhow::{Context, bail, ensure};
use clap::CommandFactory;
use metal_lab::bench::{self, BenchOptions};
use metal_lab::checkpoint::{self, Begun, Checkpoint, Job, Ledger};
use metal_lab::demonstrations::Demonstrations;
use metal_lab::figures::markdown::banded;
use metal_lab::plan::{self, Plan};
use metal_lab::registry::Roads;
use metal_lab::reproduce::{Options, execute_kept, planned_steps, quick};
use metal_lab::results::Results;
use metal_lab::store::Store;
use metal_lab::task::{NamedTask, Prices, Recipe, TableTask, Task};
use metal_lab::{catalogue, experiments, finish, recorded, reevaluate, traffic};
use metal_robots::Emergency;
use metal_studio::server;
use metal_studio::subject::Subject;
use std::io::Write;
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Duration;

/// Carries out a command.
pub fn run(arguments: Arguments) -> anyhow::Result<()> {
    match arguments.command {
        Command::Reproduce(Reproduce { out, training }) => {
            let plan = plan::parse(experiments::PAPER, &training.set)?;
            learn(plan, &training, &out)
        }
        Command::Run(Run { file, demonstrations, out, training }) => {
            let plan = plan::load(&file, &training.set)?;
            learn(taught_by(plan, demonstrations.as_deref())?, &training, &out)
        }
        Command::Eval(eval) => evaluate(&eval),
        Command::Transfer(request) => transfer::run(&request),
        Command::Studio(studio) => open_studio(&studio),
        Command::Check(request) => crate::check::run(&request),
        Command::Bench(request) => {
            compare(&NamedTask::with(&request.task, &request.settings)?, &request.comparing)
        }
        Command::Tabular(request) => {
            let table = csv_task(&request.file, &request.target, request.prices.as_deref())?;
            compare(&table, &request.comparing)
        }
        Command::Ceiling(request) => crate::ceiling::run(&request),
        Command::Prices(request) => crate::prices::run(&request),
        Command::Partition(request) => crate::partition::run(&request),
        Command::Faults(request) => crate::faults::run(&request),
        Command::Aliasing(aliasing) => bound(&aliasing),
        Command::Serve(request) => robots::serve(&request),
        Command::Doctor(request) => robots::examine(&request),
        Command::Calibrate(request) => robots::calibrate(&request),
        Command::World(request) => robots::write_world(&request),
        Command::Replay(request) => robots::replay(&request),
        Command::Drive(request) => robots::go(&request),
        Command::List => say(&catalogue::text()),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Arguments::command(), "metal", &mut script);
            say(&String::from_utf8(script)?)
        }
        Command::TrainTraffic { out, force } => train_traffic(&out, force),
    }
}

/// Prints to standard output; whoever reads it may have heard enough (`metal list | head`).
pub fn say(text: &str) -> anyhow::Result<()> {
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(e).context("cannot print"),
        _ => Ok(()),
    }
}

/// Refuses to write where something is, unless that is wanted.
pub fn keep_clear(path: &Path, force: bool) -> anyhow::Result<()> {
    ensure!(force || !path.exists(), "{}: exists; replace it with --force", path.display());
    Ok(())
}

pub fn say_json(value: &impl serde::Serialize) -> anyhow::Result<()> {
    say(&format!("{}\n", serde_json::to_string_pretty(value)?))
}

/// Ctrl-C asks politely first: episodes and tests that run are finished, then everything stops.
pub fn listen_to_ctrl_c() -> anyhow::Result<()> {
    ctrlc::set_handler(|| {
        if INTERRUPTED.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        eprintln!("\nmetal: stopping as soon as what runs is saved; press Ctrl-C again to stop at once");
    })
    .context("cannot listen to Ctrl-C")
}

/// The command as it was typed, for the report.
pub fn typed() -> String {
    let words: Vec<String> = std::env::args().skip(1).collect();
    format!("metal {}", words.join(" "))
}

pub fn use_threads(threads: u16) -> anyhow::Result<()> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads.into())
        .build_global()
        .context("cannot start the threads")
}

fn learn(plan: Plan, training: &Training, out: &Path) -> anyhow::Result<()> {
    use_threads(training.threads)?;
    listen_to_ctrl_c()?;
    let plan = if training.quick { Plan::check(quick::shrink(plan.file))? } else { plan };
    let seeds = if training.quick { training.seeds.min(2) } else { training.seeds };
    let options = Options {
        seeds: seeds as usize,
        seed: training.seed,
        quick: training.quick,
        all_subsets: training.all_subsets,
    };
    check_recordings(&plan, options.seeds, training)?;
    let store = Store::create(out)?;
    let results = match begin(&store, &Job::new(&plan, &options)?, &training.keeping)? {
        Begun::Finished => store.read_results()?,
        Begun::Work(checkpoint) => work((plan.clone(), options), &store, checkpoint)?,
    };
    record(&store, training)?;
    if training.printing.json {
        return say_json(&results);
    }
    let scenario = plan.file.environment.training_scenario();
    let mut text = table::text(&results.policies, &scenario);
    if results.quick {
        text += "\nquick run: budgets were cut, these numbers only show that everything works\n";
    }
    let (report, numbers) = (store.path("report.html"), store.path("results.json"));
    say(&format!("{text}\nreport:  {}\nnumbers: {}\n", report.display(), numbers.display()))
}

/// Before anything is learned: whether there is what shall be recorded, and room for it.
fn check_recordings(plan: &Plan, trainings: usize, training: &Training) -> anyhow::Result<()> {
    for wish in &training.record {
        wish.check(plan, trainings).map_err(anyhow::Error::msg).context("--record")?;
        keep_clear(&wish.file, training.keeping.force)?;
    }
    Ok(())
}

fn record(store: &Store, training: &Training) -> anyhow::Result<()> {
    if training.record.is_empty() {
        return Ok(());
    }
    let bar = Bar::new(0);
    let done = recorded::record(store, &training.record, training.record_episodes as usize, &bar);
    bar.finish();
    Ok(done?)
}

fn begin(store: &Store, job: &Job, keeping: &Keeping) -> anyhow::Result<Begun> {
    let every = Duration::from_secs(keeping.save_every.into());
    let warn = |what: &str| eprintln!("metal: warning: {what}");
    Ok(checkpoint::begin(store, job, (keeping.start(), every), &warn)?)
}

/// Does what there is to do, writes it, and forgets the checkpoint.
fn work((plan, options): (Plan, Options), store: &Store, checkpoint: Checkpoint) -> anyhow::Result<Results> {
    let bar = Bar::new(planned_steps(&plan, &options) as u64);
    let outcome = execute_kept(plan, options, &Ledger::new(&checkpoint, &bar));
    bar.finish();
    let kept = || format!("not finished: --resume goes on from {}", checkpoint.folder().display());
    let results = finish::write(&outcome.with_context(kept)?, store, &typed()).with_context(kept)?;
    checkpoint.finish()?;
    Ok(results)
}

/// The plan with what somebody showed in Phase I, if there is anything.
fn taught_by(plan: Plan, demonstrations: Option<&Path>) -> anyhow::Result<Plan> {
    let Some(path) = demonstrations else { return Ok(plan) };
    let set = Demonstrations::read(path, &plan.spec)?;
    let quality = set.quality();
    eprintln!(
        "metal: learning from {} steps that were shown, {} with an accident, {:.0} % unlike the expert",
        quality.steps,
        quality.accidents,
        100.0 * quality.disagreement
    );
    let mut file = plan.file;
    file.watch_demonstrations(path);
    Ok(Plan::check(file)?)
}

fn open_studio(wishes: &Studio) -> anyhow::Result<()> {
    let mut subject = match (&wishes.run, &wishes.experiment) {
        (Some(folder), _) => Subject::run(folder)?,
        (None, Some(file)) => Subject::experiment(plan::load(file, &wishes.set)?, &wishes.out)?,
        (None, None) => Subject::experiment(plan::parse(experiments::PAPER, &wishes.set)?, &wishes.out)?,
    };
    let robot = robots::watched(wishes)?;
    let emergency = robot.as_ref().map(|robot| robot.emergency.clone());
    robot.map_or(Ok(()), |robot| subject.embody(robot))?;
    wishes.record.as_ref().map_or(Ok(()), |path| subject.record(path))?;
    let options = server::Options {
        address: wishes.bind,
        port: wishes.port,
        seed: wishes.seed,
        keep_token: wishes.keep_token,
    };
    let studio = server::Studio::open(subject, options)?;
    if !wishes.bind.is_loopback() {
        eprintln!(
            "metal: warning: listening on {}: whoever can reach this address and knows the token can drive; \
             the connection is not encrypted (safer: ssh -L PORT:localhost:PORT)",
            wishes.bind
        );
    }
    say(&format!("studio: {}\n", studio.url()))?;
    if let Some(button) = emergency.clone() {
        let quit = studio.quitter();
        robots::on_termination(move || {
            button.press();
            quit();
        })?;
    }
    let quit = studio.quitter();
    ctrlc::set_handler(move || {
        // The wheels first: the stage may be in the middle of a step.
        emergency.iter().for_each(Emergency::press);
        quit();
    })
    .context("cannot listen to Ctrl-C")?;
    if wishes.open {
        show(&studio.url())?;
    }
    Ok(studio.serve()?)
}

/// Opens a page in the browser of this desktop.
fn show(url: &str) -> anyhow::Result<()> {
    let opener = if cfg!(target_os = "macos") { "open" } else { "xdg-open" };
    std::process::Command::new(opener).arg(url).spawn().with_context(|| format!("cannot start {opener}"))?;
    Ok(())
}

fn evaluate(eval: &Eval) -> anyhow::Result<()> {
    use_threads(0)?;
    let store = Store::open(&eval.run)?;
    let results = reevaluate::on(&store, roads(eval)?.as_ref(), eval.runs as usize)?;
    if eval.json {
        return say_json(&results);
    }
    let scenarios = results.policies.values().next().into_iter().flat_map(|s| s.keys());
    let tables: Vec<String> = scenarios.map(|scenario| table::text(&results.policies, scenario)).collect();
    say(&format!("roads: {}\n\n{}{}", results.roads, tables.join("\n"), ratios(&results)))
}

/// How many times the cost of everybody else attention costs, a line each; nothing if nobody attends.
fn ratios(results: &Results) -> String {
    let whole = results.ratios.iter().filter(|(name, _)| !name.contains(" in "));
    let lines: Vec<String> = whole.map(|(name, ratio)| format!("{name:40} {}\n", banded(ratio))).collect();
    if lines.is_empty() {
        return String::new();
    }
    format!("\ntotal cost by that of others, mean of the scenarios, paired by training\n{}", lines.concat())
}

fn roads(eval: &Eval) -> anyhow::Result<Option<Roads>> {
    if !eval.road_seed.is_empty() {
        return Ok(Some(Roads::Seeds(eval.road_seed.clone())));
    }
    Ok(match eval.roads.as_deref() {
        None => None,
        Some("training") => Some(Roads::Training),
        Some("validation") => Some(Roads::Validation),
        Some("test") => Some(Roads::Test),
        Some(other) => bail!("--roads {other}: training, validation or test (or --road-seed N …)"),
    })
}

fn read_prices(path: &Path) -> anyhow::Result<Prices> {
    let text = std::fs::read_to_string(path).with_context(|| format!("{}", path.display()))?;
    Ok(toml::from_str(&text).map_err(|e| plan::error::from_toml(&e, &text).located(path, &text))?)
}

/// The task of a CSV file.
pub fn csv_task(file: &Path, target: &str, prices: Option<&Path>) -> anyhow::Result<TableTask> {
    let prices = prices.map(read_prices).transpose()?.unwrap_or_default();
    Ok(TableTask::from_csv(file, target, &prices)?)
}

/// The default recipe with the fields that were given.
fn recipe(request: &Comparing) -> anyhow::Result<Recipe> {
    let mut whole = serde_json::to_value(Recipe::of_steps(request.steps as usize))?;
    let given: serde_json::Map<String, serde_json::Value> =
        serde_json::from_str(&request.recipe).context("--recipe")?;
    for (field, value) in given {
        whole[field] = value;
    }
    serde_json::from_value(whole).context("--recipe")
}

fn compare(task: &dyn Task, request: &Comparing) -> anyhow::Result<()> {
    use_threads(request.threads)?;
    listen_to_ctrl_c()?;
    let recipe = recipe(request)?;
    let options = BenchOptions {
        seeds: request.seeds as usize,
        seed: request.seed,
        episodes: request.episodes as usize,
        exhaustive: request.exhaustive.into(),
        ..BenchOptions::default()
    };
    let sensors = task.training()?.spec().sensors.len();
    let bar = Bar::new(bench::planned_steps(&recipe, &options, sensors) as u64);
    let done = bench::bench(task, &recipe, &options, &bar);
    bar.finish();
    let done = done?;
    if request.json { say_json(&done) } else { say(&bench::text(&done)) }
}

fn bound(request: &Aliasing) -> anyhow::Result<()> {
    let bound = metal_lab::aliasing_bound(request.q, request.k, request.actions)?;
    if request.json {
        return say_json(&bound);
    }
    say(&format!(
        "q = {}, k = {}, |A| = {}\n\
         p0            {:.6e}   equal supports of one action, Eq. (22)\n\
         p0^|A|        {:.6e}   all actions, Eq. (26): the paper's figure\n\
         p0^(|A|-1)    {:.6e}   supports sum to 1, so one action is not free\n",
        request.q, request.k, request.actions, bound.collision, bound.all_actions, bound.free_actions
    ))
}

fn train_traffic(out: &Path, force: bool) -> anyhow::Result<()> {
    keep_clear(out, force)?;
    listen_to_ctrl_c()?;
    let bar = Bar::new(traffic::planned_steps()? as u64);
    let bytes = traffic::train(&bar);
    bar.finish();
    std::fs::write(out, bytes?).with_context(|| format!("cannot write {}", out.display()))
}
