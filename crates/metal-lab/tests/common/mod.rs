//! Made-up results that fill every part of the report. The numbers are invented; only their shape is like a real run.

mod drawings;

use std::collections::BTreeMap;

use metal_lab::paper;
use metal_lab::results::{
    AliasingRow, Costs, CurvePoint, Estimate, Figures, FrontPoint, LooksBlock, Policies, Results, SCHEMA,
    SeedPoint, Stage, Table2Cell, Table3Row,
};

const SENSORS: [(&str, f64); 7] =
    [("MN", 1.5), ("LN", 2.0), ("RN", 2.0), ("MF", 1.5), ("LF", 2.0), ("RF", 2.0), ("IR", 1.0)];

/// Policy, motor cost, perceptual cost, looks, accident rate.
const POLICIES: [(&str, f64, f64, f64, f64); 10] = [
    ("acl", -8.7, -3.1, 1.98, 0.21),
    ("acl_paper", -11.9, -5.2, 3.10, 0.33),
    ("best_fixed", -8.2, -3.0, 2.0, 0.19),
    ("blind", -21.4, 0.0, 0.0, 0.71),
    ("fixed:MN+MF", -8.2, -3.0, 2.0, 0.19),
    ("foa", -7.1, -11.0, 6.0, 0.36),
    ("fusion", -10.3, -12.0, 7.0, 0.41),
    ("fusion_log_pool", -9.0, -12.0, 7.0, 0.37),
    ("oracle", -1.2, 0.0, 0.0, 0.01),
    ("random", -13.4, -4.6, 2.8, 0.52),
];

fn names(list: &[&str]) -> Vec<String> {
    list.iter().map(|&s| s.to_owned()).collect()
}

fn around(mean: f64, half: f64) -> Estimate {
    Estimate::interval(mean, mean - half, mean + half, 5)
}

/// A full run.
pub fn results() -> Results {
    let ten = |runs: u64| -> BTreeMap<_, _> {
        ["foa", "fusion", "acl"].iter().map(|p| ((*p).to_owned(), table2_row(p, runs))).collect()
    };
    Results {
        schema: SCHEMA,
        quick: false,
        seeds: 5,
        roads: "training".to_owned(),
        policies: policies(0.0),
        table3: table3(),
        figures: figures(),
        other_roads: BTreeMap::from([
            ("test".to_owned(), policies(-1.3)),
            ("validation".to_owned(), policies(-0.6)),
        ]),
        table2: BTreeMap::from([("full".to_owned(), ten(500)), ("ten_runs".to_owned(), ten(10))]),
        ratios: BTreeMap::from([("acl/foa".to_owned(), around(0.65, 0.04))]),
        best_fixed: Some("fixed:MN+MF".to_owned()),
        paper: Some(paper::numbers()),
        cpu_seconds: BTreeMap::from([
            ("attention_control".to_owned(), 71.2),
            ("evaluation".to_owned(), 12.5),
        ]),
        versions: BTreeMap::from([
            ("git".to_owned(), "0123456789abcdef".to_owned()),
            ("world".to_owned(), "Highway-v0".to_owned()),
        ]),
        config: serde_json::json!({"seeds": 5, "attention": {"null": "<own type>", "price": [1.5, 2.0]}}),
    }
}

fn policies(worse: f64) -> Policies {
    let scenarios = [("mix", 0.0), ("free_road", 2.8), ("approaching", -2.1), ("from_behind", -0.7)];
    let row = |&(name, motor, perceptual, looks, accidents): &(&str, f64, f64, f64, f64)| {
        let cells = scenarios.iter().map(|&(scenario, shift)| {
            let motor = (motor + (shift + worse) * motor / -10.0).min(0.0);
            let costs = (motor, perceptual, looks);
            (scenario.to_owned(), measures(costs, accidents))
        });
        (name.to_owned(), cells.collect())
    };
    POLICIES.iter().map(row).collect()
}

fn measures((motor, perceptual, looks): (f64, f64, f64), accidents: f64) -> BTreeMap<String, Estimate> {
    let list = [
        ("total", around(motor + perceptual, 0.6)),
        ("motor", around(motor, 0.5)),
        ("perceptual", around(perceptual, 0.2)),
        ("looks", around(looks, 0.15)),
        ("accident_rate", around(accidents, 0.01)),
        ("fault_rate", around(accidents / 2.0, 0.01)),
        ("off_road_rate", around(accidents / 9.0, 0.001)),
        ("contact_steps", around(accidents * 1.7, 0.1)),
        ("path_smoothness", around(0.123, 0.02)),
        ("speed_smoothness", around(0.173, 0.02)),
        ("lane_offset", around(0.0317, 0.002)),
        ("speed", around(0.0912, 0.003)),
    ];
    list.into_iter().map(|(name, estimate)| (name.to_owned(), estimate)).collect()
}

fn table2_row(policy: &str, runs: u64) -> BTreeMap<String, Table2Cell> {
    let price = if policy == "acl" { -3.1 } else { -11.5 };
    let costs = |motor: f64| Costs {
        motor: around(motor, 0.8),
        perceptual: around(price, 0.1),
        total: around(motor + price, 0.9),
    };
    let risky = Table2Cell {
        runs,
        accidents: runs * 3 / 10,
        all: costs(-10.0),
        accident: Some(costs(-19.5)),
        no_accident: Some(costs(-7.4)),
    };
    let free = Table2Cell {
        accidents: 0,
        accident: None,
        no_accident: Some(costs(-5.2)),
        all: costs(-5.2),
        ..risky.clone()
    };
    [("approaching", risky.clone()), ("free_road", free), ("from_behind", risky)]
        .into_iter()
        .map(|(scenario, cell)| (scenario.to_owned(), cell))
        .collect()
}

fn table3() -> Vec<Table3Row> {
    let row = |r: paper::PaperTable3Row| Table3Row { k: r.k, q: r.q, actions: r.actions, p0: r.p0, p: r.p };
    paper::numbers().table3.into_iter().map(row).collect()
}

fn figures() -> Figures {
    Figures {
        learning_curves: [("foa", -7.1, -11.0), ("fusion", -10.3, -12.0), ("acl", -8.7, -3.1)]
            .into_iter()
            .map(|(policy, motor, price)| (policy.to_owned(), curve(motor, price)))
            .collect(),
        looks_histograms: (0..20).map(looks_block).collect(),
        table1: drawings::scenes(),
        camera_regions: drawings::regions(),
        fig6: Some(drawings::road_view()),
        fig11: Some(drawings::test_drive()),
        look_map: Some(drawings::look_map()),
        subset_front: subsets(),
        sensitivity: POLICIES.iter().map(|p| (p.0.to_owned(), seeds(p.1, p.2))).collect(),
        aliasing_empirical: vec![AliasingRow {
            space: "decision space".to_owned(),
            q: 10,
            rate: Estimate::interval(2.3e-5, 1.1e-5, 4.0e-5, 5),
        }],
    }
}

fn curve(motor: f64, price: f64) -> Vec<CurvePoint> {
    let mut sum = 0.0;
    let point = |block: u32| {
        let left = 1.0 / (1.0 + f64::from(block) / 6.0);
        let wiggle = f64::from(block * 7 % 5) * 0.15;
        let motor_now = motor - 14.0 * left - wiggle;
        let price_now = if price > -5.0 { price - 6.0 * left } else { price };
        sum += (motor_now + price_now) * 30.0 * 50.0;
        CurvePoint {
            block,
            episodes: (block + 1) * 30,
            motor: around(motor_now, 0.5 + 2.0 * left),
            perceptual: around(price_now, 0.2),
            total: around(motor_now + price_now, 0.6 + 2.0 * left),
            accumulated: around(sum, -sum * 0.05),
        }
    };
    (0..40).map(point).collect()
}

fn looks_block(block: u32) -> LooksBlock {
    let late = f64::from(block) / 19.0;
    let early = [0.02, 0.06, 0.10, 0.14, 0.18, 0.18, 0.17, 0.15];
    let end = [0.06, 0.34, 0.33, 0.15, 0.07, 0.03, 0.01, 0.01];
    let share = early.iter().zip(end).map(|(a, b)| a * (1.0 - late) + b * late).collect();
    LooksBlock { block, episodes: (block + 1) * 60, share }
}

fn subsets() -> Vec<FrontPoint> {
    let mut found = Vec::new();
    for (i, &first) in SENSORS.iter().enumerate() {
        for (j, &second) in SENSORS.iter().enumerate().skip(i) {
            let pair = if i == j { vec![first] } else { vec![first, second] };
            let price: f64 = pair.iter().map(|s| s.1).sum();
            let motor = -9.0 - 1.3 * ((i * 5 + j * 3) % 7) as f64 + 0.8 * price;
            let is_confirmed = (i, j) == (0, 3) || (i, j) == (0, 0) || (i, j) == (0, 6);
            found.push(FrontPoint {
                sensors: pair.iter().map(|s| s.0.to_owned()).collect(),
                every: 1,
                price,
                motor: around(motor, 0.4),
                total: around(motor - price, 0.4),
                stage: if is_confirmed { Stage::Confirmed } else { Stage::Screened },
            });
        }
    }
    found
}

fn seeds(motor: f64, perceptual: f64) -> Vec<SeedPoint> {
    let point = |seed: u64| {
        let shift = (seed * 37 % 11) as f64 * 0.12 - 0.6;
        SeedPoint { seed, motor: motor + shift, perceptual, total: motor + perceptual + shift, looks: 2.0 }
    };
    (1..=5).map(point).collect()
}
