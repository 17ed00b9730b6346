//! Tasks from anywhere, learned after a recipe: what is learned, saved, thawed and compared.
#![allow(clippy::unwrap_used)]

use metal_lab::bench::{BenchOptions, bench};
use metal_lab::progress::Silent;
use metal_lab::task::{AttentionMethod, Driver, NamedTask, Recipe, Task, learn, load, save, trial};
use metal_rl::observe::Unobserved;
use metal_rl::random::Streams;
use std::path::PathBuf;

fn brief() -> Recipe {
    Recipe { demonstration: 50, fusion: Some(300), attention: 600, ..Recipe::default() }
}

fn temporary(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name)
}

#[test]
fn a_saved_mind_is_the_same_mind() {
    let task = NamedTask::with("maze", "{}").unwrap();
    let mind = learn(&task, &brief(), &Streams::new(3), &mut Unobserved).unwrap();
    let path = temporary("mind.safetensors");
    save(&mind, &path, 3, [("remark".to_owned(), "none".to_owned())].into()).unwrap();
    let (thawed, card) = load(&path).unwrap();
    assert_eq!((card.seed, card.notes["remark"].as_str()), (3, "none"));
    for driver in [Driver::Attention, Driver::Observer, Driver::Fusion] {
        let runs = (8, &Streams::new(9));
        let (one, other) = (trial(&task, &mind, driver, runs), trial(&task, &thawed, driver, runs));
        assert_eq!(one.unwrap(), other.unwrap(), "{driver:?}");
    }
}

#[test]
fn damaged_files_are_refused() {
    let path = temporary("damaged.safetensors");
    for bytes in [&b""[..], b"12345678", &[255; 64]] {
        std::fs::write(&path, bytes).unwrap();
        let error = load(&path).err().expect("no mind in it").to_string();
        assert!(error.contains("damaged.safetensors"), "{error}");
    }
    assert!(load(&temporary("nowhere")).is_err());
}

#[test]
fn experts_of_the_toy_are_worth_being_asked() {
    let task = NamedTask::new("toy").unwrap();
    let recipe = Recipe { fusion: Some(0), attention: 4000, demonstration: 0, ..Recipe::default() };
    let mind = learn(&task, &recipe, &Streams::new(1), &mut Unobserved).unwrap();
    let total = |driver| trial(&task, &mind, driver, (500, &Streams::new(2))).unwrap().total();
    let (attention, fusion) = (total(Driver::Attention), total(Driver::Fusion));
    let blind = (0..5).map(|a| total(Driver::Blind(a))).fold(f64::NEG_INFINITY, f64::max);
    assert!(attention > fusion && attention > blind, "{attention} against {fusion} and {blind}");
}

#[test]
fn a_comparison_is_the_same_every_time_and_spends_the_same_on_everybody() {
    let task = NamedTask::with("maze", "{}").unwrap();
    let options = BenchOptions { seeds: 2, episodes: 5, price_factors: vec![2.0], ..BenchOptions::default() };
    let run = || {
        let done = bench(&task, &brief(), &options, &Silent).unwrap();
        (done.rows.values().map(|r| r.scores.clone()).collect::<Vec<_>>(), done.statics, done.front)
    };
    assert!(run() == run());
}

#[test]
fn impossible_recipes_are_refused_by_field() {
    let task = NamedTask::new("maze").unwrap();
    let refused = |recipe: &Recipe| {
        learn(&task, recipe, &Streams::new(1), &mut Unobserved).err().expect("impossible").to_string()
    };
    assert!(refused(&Recipe { attention: 0, ..brief() }).starts_with("attention"));
    assert!(refused(&Recipe { fusion: Some(usize::MAX), ..brief() }).starts_with("fusion"));
    let credit = metal_rl::returns::Credit { gamma: 1.0, lambda: 0.5 };
    assert!(refused(&Recipe { credit, ..brief() }).starts_with("credit.gamma"));
}

#[test]
fn members_learn_before_attention_only_where_attention_asks_them() {
    let task = NamedTask::new("maze").unwrap();
    let budgets = |method: &str| {
        let method = serde_json::from_str(method).unwrap();
        let recipe = Recipe { demonstration: 0, method, ..Recipe::of_steps(300) };
        let learned = learn(&task, &recipe, &Streams::new(1), &mut Unobserved).unwrap().recipe;
        assert_eq!(learned.steps(), 300);
        (learned.fusion, learned.attention)
    };
    let values = |content: &str| {
        format!(r#"{{"values": {{"settings": {{"encoding": {{"content": "{content}"}}}}}}}}"#)
    };
    assert_eq!(budgets(r#""critic""#), (Some(0), 300));
    assert_eq!(budgets(&values("readings")), (Some(0), 300));
    assert_eq!(budgets(&values("support")), (Some(100), 200));
}

/// Counterfactual policy iteration, briefly: enough to beat blindness, far too little to be good.
fn counterfactual(belief: bool) -> Recipe {
    let AttentionMethod::Counterfactual(mut config) = AttentionMethod::one_step() else { panic!("its name") };
    (config.iterations, config.price_ramp, config.fit.batches) = (3, 1, 300);
    config.network.belief = belief;
    let method = AttentionMethod::Counterfactual(config);
    Recipe { fusion: Some(0), attention: 1500, method, ..Recipe::default() }
}

/// What a mind of `recipe` earns on test rows of the cube, and the best that anybody earns there without a look.
fn against_blind(recipe: &Recipe) -> (f64, f64) {
    let task = NamedTask::with("cube", r#"{"rows": 200}"#).unwrap();
    let mind = learn(&task, recipe, &Streams::new(3), &mut Unobserved).unwrap();
    let path = temporary("counterfactual.safetensors");
    save(&mind, &path, 3, std::collections::BTreeMap::new()).unwrap();
    let (thawed, _) = load(&path).unwrap();
    let drive = |mind, driver| trial(&task, mind, driver, (300, &Streams::new(9))).unwrap();
    let attention = drive(&mind, Driver::Attention);
    assert_eq!(attention, drive(&thawed, Driver::Attention));
    let blind = (0..8).map(|c| drive(&mind, Driver::Blind(c)).total()).fold(f64::NEG_INFINITY, f64::max);
    (attention.total(), blind)
}

#[test]
fn a_counterfactual_mind_beats_every_blind_one_and_is_saved_like_any_other() {
    let (unaided, blind) = against_blind(&counterfactual(false));
    assert!(unaided > blind, "{unaided} against {blind}");
    let (told, _) = against_blind(&counterfactual(true));
    assert!(
        told > unaided + 0.1,
        "who is told what the model believes needs not learn it: {told}, {unaided}"
    );
}

/// The experiment, the library and every binding learn attention in the same way, unless they are told otherwise.
#[test]
fn the_default_is_the_recipe_of_the_experiment() {
    let AttentionMethod::Counterfactual(best) = AttentionMethod::by_roll_outs(180_000) else {
        panic!("its name")
    };
    for text in [metal_lab::experiments::PAPER, metal_lab::experiments::ATTENTION] {
        let plan = metal_lab::plan::parse(text, &[]).unwrap();
        assert_eq!(plan.file.attention["acl"].counterfactual.as_ref(), Some(&*best), "{}", plan.file.title);
    }
    let stages = |steps| match AttentionMethod::by_roll_outs(steps) {
        AttentionMethod::Counterfactual(c) => (c.iterations, c.wide_eyed, c.price_ramp),
        other => panic!("{other:?}"),
    };
    assert_eq!(stages(60_000), (36, 6, 15), "for as many motor steps as there");
    assert_eq!(stages(4_000), (8, 1, 3), "but not for ever");
    assert_eq!(stages(10_000_000), (36, 1, 1));
}

#[test]
fn worlds_that_can_be_copied_are_learned_by_roll_outs() {
    let method = |task: &dyn Task| {
        let world = task.training().unwrap();
        Recipe { attention: 4000, ..Recipe::default() }.for_task(task, world.as_ref()).method
    };
    for name in ["maze", "puddle", "highway"] {
        assert_eq!(method(&NamedTask::new(name).unwrap()), AttentionMethod::by_roll_outs(4000), "{name}");
    }
}

#[test]
fn a_critic_learns_a_task_of_many_steps_and_is_saved_like_any_other() {
    let task = NamedTask::with("maze", r#"{"side": 3, "goal": {"x": 2, "y": 2}}"#).unwrap();
    let method = serde_json::from_str(r#""critic""#).unwrap();
    let recipe = Recipe { fusion: Some(0), attention: 4000, method, ..Recipe::default() };
    let mind = learn(&task, &recipe, &Streams::new(3), &mut Unobserved).unwrap();
    assert_eq!(mind.recipe.method, AttentionMethod::by_critic(4000, mind.spec.horizon));
    let path = temporary("critic.safetensors");
    save(&mind, &path, 3, std::collections::BTreeMap::new()).unwrap();
    let (thawed, _) = load(&path).unwrap();
    let drive = |mind, driver| trial(&task, mind, driver, (100, &Streams::new(9))).unwrap();
    let attention = drive(&mind, Driver::Attention);
    assert_eq!(attention, drive(&thawed, Driver::Attention));
    let blind = (0..4).map(|a| drive(&mind, Driver::Blind(a)).total()).fold(f64::NEG_INFINITY, f64::max);
    assert!(attention.total() > blind / 2.0, "{} against {blind}", attention.total());
}
