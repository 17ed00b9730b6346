//! The paper's experiment from end to end, with budgets of a few episodes: everything it writes can be read back, and
//! the minds it wrote drive exactly as those it tested.
#![allow(clippy::unwrap_used)]

use metal_lab::plan::{self, Plan};
use metal_lab::progress::Silent;
use metal_lab::registry::Roads;
use metal_lab::reproduce::{Options, Outcome, execute, quick};
use metal_lab::results::Results;
use metal_lab::store::Store;
use metal_lab::{experiments, finish, reevaluate};

const SEEDS: usize = 2;
const RUNS_PER_SEED: usize = 2;

fn outcome() -> Outcome {
    let mut file = plan::parse(experiments::PAPER, &[]).unwrap().file;
    quick::cut(&mut file, 4, 60);
    file.evaluation.runs = SEEDS * RUNS_PER_SEED;
    if let Some(rows) = &mut file.subsets {
        rows.among = vec!["RN".into(), "RN/2".into()];
        (rows.screening_seeds, rows.screening_runs, rows.confirmed) = (1, 2, 2);
    }
    let options = Options { seeds: SEEDS, seed: 7, quick: true, all_subsets: false };
    execute(Plan::check(file).unwrap(), options, &Silent).unwrap()
}

/// A folder of this test's own, removed at its end.
struct Folder(std::path::PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn what_a_run_writes_can_be_read_drawn_and_driven_again() {
    let folder = Folder(std::env::temp_dir().join(format!("metal-whole-run-{}", std::process::id())));
    let store = Store::create(&folder.0).unwrap();
    let results = finish::write(&outcome(), &store, "metal run tiny.toml").unwrap();

    let text = std::fs::read_to_string(store.path("results.json")).unwrap();
    let back: Results = serde_json::from_str(&text).unwrap();
    assert_eq!(back, results);

    let page = std::fs::read_to_string(store.path("report.html")).unwrap();
    for figure in ["fig6", "fig8", "fig9", "fig11", "look-map", "sensitivity"] {
        assert!(page.contains(&format!("id=\"figure-{figure}\"")), "{figure} is not in the report");
    }
    assert_driven_parts(&back);

    let (plan, card) = store.read_run().unwrap();
    for (seed, phase) in (0..card.seeds).flat_map(|seed| plan.order.iter().map(move |p| (seed, p))) {
        store.read_mind(&plan, seed, phase).unwrap();
    }
    let titles: Vec<String> =
        store.rivals().unwrap().iter().map(|rival| rival.read_run().unwrap().0.file.title).collect();
    assert_eq!(titles.len(), 3, "two that were named, and all sensors: {titles:?}");
    assert!(titles.iter().all(|title| results.policies.contains_key(title)), "{titles:?}");
    let again = reevaluate::on(&store, Some(&Roads::Training), RUNS_PER_SEED).unwrap();
    let mut policies = results.policies;
    policies.remove("best_fixed").expect("one of the fixed choices under a second name");
    assert_eq!(again.policies, policies);
    let same = |name: &str| again.ratios[name] == results.ratios[name];
    assert!(same("acl/foa") && same("acl/fusion"), "the same runs, the same ratios");
    let best = results.best_fixed.as_ref().unwrap();
    assert_eq!(again.ratios[&format!("acl/{best}")], results.ratios["acl/best_fixed"]);
    let each =
        ["free_road", "approaching", "from_behind"].map(|s| again.ratios[&format!("acl/foa in {s}")].mean);
    assert!((each.iter().sum::<f64>() / 3.0 - again.ratios["acl/foa"].mean).abs() < 1e-9, "{each:?}");
    store.retire_rivals().unwrap();
    assert_eq!(store.rivals().unwrap().len(), 0, "a run that is begun anew does not take over old rivals");
}

/// The figures that needed a driver.
fn assert_driven_parts(results: &Results) {
    let figures = &results.figures;
    assert_eq!(figures.table1.len(), 6);
    assert!(figures.table1.iter().all(|row| row.agreement >= 1.0 / SEEDS as f64 && row.action.is_some()));
    assert_eq!(figures.camera_regions.len(), 6);
    let drive = figures.fig11.as_ref().unwrap();
    assert!((drive.accumulated.last().unwrap() - drive.reward.iter().sum::<f64>()).abs() < 1e-9);
    assert!(figures.look_map.as_ref().unwrap().points.iter().all(|p| (p.looks == 0) == p.first.is_none()));
    let cars_seen = figures.fig6.as_ref().unwrap().image.iter().any(|row| row.contains('2'));
    assert!(cars_seen, "no car is in the picture of Fig. 6");
    let levels: Vec<u32> = figures.aliasing_empirical.iter().map(|row| row.q).collect();
    assert_eq!(levels, [4, 10, 4, 10]);
    assert!(figures.aliasing_empirical.iter().all(|row| (0.0..=1.0).contains(&row.rate.mean)));
}
