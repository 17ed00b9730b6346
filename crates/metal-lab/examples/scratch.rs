//! Scratch.
#![allow(missing_docs, clippy::print_stdout, clippy::unwrap_used)]
use metal_lab::registry::{EnvironmentConfig, Roads};
use metal_rl::counterfactual::*;
use metal_rl::explore::Schedule;
use metal_rl::learner::Dims;
use metal_rl::learners::{GivenConfig, LearnerConfig};
use metal_rl::member::Member;
use metal_rl::observe::Unobserved;
use metal_rl::phase::{Budget, Phase};
use metal_rl::random::Streams;
use metal_rl::set::IndexSet;
use metal_rl::view::{Scaling, View};

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Args {
    #[serde(default)]
    world: String,
    seed: u64,
    steps: usize,
    eps: [f64; 3],
    #[serde(default)]
    c: CounterfactualConfig,
}

fn main() {
    let text = std::env::args().nth(1).unwrap();
    let args: Args = toml::from_str(&text.replace(';', "\n")).unwrap();
    let toy = args.world == "toy";
    let config: EnvironmentConfig = if toy {
        toml::from_str("[toy]").unwrap()
    } else {
        toml::from_str("[highway]\nroads='training'\nscenario='mix'").unwrap()
    };
    let mut environment = config.build().unwrap();
    let spec = environment.spec().clone();
    let mut vconfig = config.clone();
    vconfig.set_roads(&Roads::Validation);
    let mut validation = vconfig.build().unwrap();
    let mut members: Vec<Member> = (0..spec.sensors.len())
        .map(|s| {
            let view = View::new(&spec, &[s]);
            let dims = Dims { inputs: view.dims(), choices: spec.actions.len() };
            let learner = if toy {
                LearnerConfig::Given(GivenConfig::default())
            } else {
                LearnerConfig::Tile(Default::default())
            };
            Member { name: spec.sensors[s].name.clone(), view, learner: learner.build(dims, 1).unwrap() }
        })
        .collect();
    let n = members.len();
    let scaling = if toy { Scaling::Linear } else { Scaling::SquareRoot };
    let judge = RollOuts { workers: &Alone };
    let mut school = School {
        environment: environment.as_mut(),
        validation: validation.as_mut(),
        members: &mut members,
        roster: (0..n).collect(),
        scaling,
        judge: &judge,
        interrupted: &|| false,
    };
    let phase = Phase {
        exploration: Schedule::Random { from: args.eps[0], to: args.eps[1], until: args.eps[2] },
        budget: Budget::Steps(args.steps),
        ..Phase::evaluation("drive", IndexSet::first(n), 0)
    };
    let start = std::time::Instant::now();
    let graduate = iterate(&mut school, &args.c, &phase, &Streams::new(args.seed), &mut Unobserved).unwrap();
    for (i, d) in graduate.diary.iter().enumerate() {
        println!(
            "{i:2} p {:.2} loss {:.3} total {:.3} motor {:.3} looks {:.3} rolled {}{}",
            d.price_share,
            d.loss,
            d.total,
            d.motor,
            d.looks,
            d.rolled_steps,
            if i == graduate.best { " *" } else { "" }
        );
    }
    let best = graduate.diary[graduate.best];
    println!(
        "BEST total {:.3} motor {:.3} looks {:.3} | {:.1} s | own {} rolled {}",
        best.total,
        best.motor,
        best.looks,
        start.elapsed().as_secs_f64(),
        graduate.diary.iter().map(|d| d.own_steps).sum::<usize>(),
        graduate.diary.iter().map(|d| d.rolled_steps).sum::<usize>()
    );
    if !toy {
        let mut members2 = members.clone();
        for scenario in ["mix", "free_road", "approaching", "from_behind"] {
            for roads in [Roads::Training, Roads::Test] {
                let mut config = config.clone();
                config.set_roads(&roads);
                config.set_scenario(scenario);
                let mut env = config.build().unwrap();
                let mut policy = graduate.policy.clone();
                let mut stage = metal_rl::run::Stage {
                    environment: env.as_mut(),
                    members: &mut members2,
                    policy: &mut policy,
                    scaling,
                };
                let mut trace = metal_lab::trace::Trace::new(&spec);
                let test = Phase::evaluation("test", IndexSet::first(n), 100);
                metal_rl::run::run(&mut stage, &test, &Streams::new(12345), &mut trace).unwrap();
                let m = metal_lab::evaluate::measures(&trace.episodes);
                let g = |k: &str| m.iter().find(|x| x.0 == k).unwrap().1;
                println!(
                    "{scenario:12} {:?} total {:.2} motor {:.2} looks {:.2} acc {:.2}",
                    roads,
                    g("total"),
                    g("motor"),
                    g("looks"),
                    g("accident_rate")
                );
            }
        }
    }
}
