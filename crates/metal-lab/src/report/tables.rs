//! The tables of the report.

use std::collections::BTreeSet;

use super::measure;
use super::table::{Cell, Table};
use crate::figures::{number, policy};
use crate::paper::{self, PaperCosts};
use crate::results::{Costs, Estimate, Policies, Results, Table2, Table2Cell, lookup};

/// The total cost in every scenario: ours beside the paper's.
#[must_use]
pub fn headline(results: &Results) -> Table {
    let compared = ["foa", "fusion", "acl"];
    let alone = ["best_fixed", "oracle"];
    let mut columns = vec!["Total cost per motor step".to_owned()];
    columns.extend(compared.iter().flat_map(|p| {
        let name = policy::short_label(p);
        [format!("{name}, ours"), format!("{name}, paper")]
    }));
    columns.extend(alone.iter().map(|p| policy::label(p, results)));
    let rows = lookup::SCENARIOS.into_iter().chain(["mix"]).map(|scenario| {
        let total = |p: &str| results.estimate(p, scenario, "total");
        let ours = |p: &str| total(p).map_or_else(Cell::missing, |e| total_cell(&e));
        let mut row = vec![Cell::name(policy::scenario_label(scenario))];
        row.extend(compared.iter().flat_map(|p| [ours(p), printed_total(p, scenario)]));
        row.extend(alone.iter().map(|p| ours(p)));
        row
    });
    Table {
        caption: "Negative is worse; 0 is perfect driving without a look.".into(),
        columns,
        rows: rows.collect(),
    }
}

fn printed_total(policy: &str, scenario: &str) -> Cell {
    paper::cell(policy, scenario)
        .map_or_else(Cell::unprinted, |cell| Cell::paper(number::fixed(cell.total, 1), "n\u{a0}=\u{a0}10"))
}

/// The policies of the paper's Table 2, and the rival that it lacks.
const TABLE2: [&str; 4] = ["acl", "foa", "fusion", "best_fixed"];

/// Table 2 in one style of measuring, each cell beside the paper's.
#[must_use]
pub fn table2(table: &Table2, caption: &str) -> Table {
    let columns =
        ["", "", "Motor + perceptual = total", "Runs with accident", "Total with accident", "Total without"];
    let mut rows = Vec::new();
    for scenario in lookup::SCENARIOS {
        let mut name = Cell::name(policy::scenario_label(scenario));
        for policy in TABLE2 {
            let Some(cell) = table.get(policy).and_then(|cells| cells.get(scenario)) else { continue };
            rows.push(our_row(std::mem::take(&mut name), &policy::short_label(policy), cell));
            rows.extend(paper_row(scenario, policy));
        }
    }
    Table { caption: caption.to_owned(), columns: columns.map(str::to_owned).to_vec(), rows }
}

fn our_row(scenario: Cell, name: &str, cell: &Table2Cell) -> Vec<Cell> {
    let part =
        |costs: &Option<Costs>| costs.as_ref().map_or_else(|| Cell::text("none"), |c| total_cell(&c.total));
    vec![
        scenario,
        Cell::text(name),
        sum_cell(&cell.all),
        Cell::text(format!("{} of {}", cell.accidents, cell.runs)),
        part(&cell.accident),
        part(&cell.no_accident),
    ]
}

/// A total with one decimal, as the paper prints it.
fn total_cell(total: &Estimate) -> Cell {
    let cell = Cell::measured("total", Some(*total));
    let interval = number::interval(total, 1).map(|i| format!("{i} ")).unwrap_or_default();
    Cell { main: number::fixed(total.mean, 1), sub: format!("{interval}n\u{a0}=\u{a0}{}", total.n), ..cell }
}

fn sum_cell(costs: &Costs) -> Cell {
    let [motor, perceptual] = [&costs.motor, &costs.perceptual].map(|e| number::fixed(e.mean, 1));
    let total = total_cell(&costs.total);
    Cell { main: sum_text(&motor, &perceptual, &total.main), ..total }
}

fn sum_text(motor: &str, perceptual: &str, total: &str) -> String {
    let perceptual = match perceptual.strip_prefix('\u{2212}') {
        Some(size) => format!("\u{2212} {size}"),
        None => format!("+ {perceptual}"),
    };
    format!("{motor} {perceptual} = {total}")
}

fn paper_row(scenario: &str, policy: &str) -> Option<Vec<Cell>> {
    let cell = paper::cell(policy, scenario)?;
    let one = |v: f64| number::fixed(v, 1);
    let parts = |c: Option<PaperCosts>| {
        let Some(c) = c else { return Cell::unprinted() };
        let sub = c.motor.zip(c.perceptual).map(|(m, p)| sum_text(&one(m), &one(p), &one(c.total)));
        Cell::paper(one(c.total), sub.unwrap_or_default())
    };
    let total = match cell.motor.zip(cell.perceptual) {
        Some((motor, perceptual)) => sum_text(&one(motor), &one(perceptual), &one(cell.total)),
        None => one(cell.total),
    };
    let accidents = cell.accidents.map_or("–".to_owned(), |a| format!("{a} of 10"));
    Some(vec![
        Cell::paper("", ""),
        Cell::paper("paper", ""),
        Cell::paper(total, "n\u{a0}=\u{a0}10"),
        Cell::paper(accidents, ""),
        parts(cell.accident),
        parts(cell.no_accident),
    ])
}

/// Table 3: ours beside the paper's; nothing here is random.
#[must_use]
pub fn table3(results: &Results) -> Table {
    let columns = ["k", "q", "|A|", "p₀, ours", "p₀, paper", "P(aliasing), ours", "P(aliasing), paper"];
    let rows = results.table3.iter().map(|row| {
        let printed = paper::table3(row.k, row.q, row.actions);
        let paper_cell = |value: Option<f64>| {
            value.map_or_else(Cell::unprinted, |p| Cell::paper(number::probability(p), ""))
        };
        let ours = |p: f64| Cell { class: "ours", ..Cell::text(number::probability(p)) };
        let mut cells = vec![row.k, row.q, row.actions]
            .into_iter()
            .map(|n| Cell::text(n.to_string()))
            .collect::<Vec<_>>();
        cells.extend([
            ours(row.p0),
            paper_cell(printed.as_ref().map(|p| p.p0)),
            ours(row.p),
            paper_cell(printed.as_ref().map(|p| p.p)),
        ]);
        cells
    });
    let caption = "Computed exactly from Eqs (22)-(26); there is nothing to sample, so there is no interval.";
    Table { caption: caption.to_owned(), columns: columns.map(str::to_owned).to_vec(), rows: rows.collect() }
}

/// Aliasing measured on what was learned.
#[must_use]
pub fn aliasing(results: &Results) -> Table {
    let rows = results.figures.aliasing_empirical.iter().map(|row| {
        let interval = row
            .rate
            .band()
            .map(|(lo, hi)| format!("[{}, {}] ", number::probability(lo), number::probability(hi)));
        let sub = format!("{}n\u{a0}=\u{a0}{}", interval.unwrap_or_default(), row.rate.n);
        vec![
            Cell::name(row.space.clone()),
            Cell::text(row.q.to_string()),
            Cell { main: number::probability(row.rate.mean), sub, class: "ours" },
        ]
    });
    Table {
        caption: "Measured on drives of attention control: of all pairs of distinct states in which the full observer \
                  acts differently, the share that falls on one point. “As attended”: only what attention control asked \
                  for.".to_owned(),
        columns: ["Space", "q", "Share of pairs"].map(str::to_owned).to_vec(),
        rows: rows.collect(),
    }
}

/// The behavioural measures (Sec. 3.3) over the mix of scenarios.
#[must_use]
pub fn behaviour(results: &Results) -> Table {
    measures(results, (&named(&results.policies), "mix"), &measure::BEHAVIOUR)
}

/// Every policy with a name over the mix of scenarios: what it costs, of what, and how often it looks.
#[must_use]
pub fn baselines(results: &Results) -> Table {
    measures(
        results,
        (&named(&results.policies), "mix"),
        &["total", "motor", "perceptual", "looks", "accident_rate", "off_road_rate"],
    )
}

/// The policies with a name; of the fixed subsets only the best has one.
fn named(policies: &Policies) -> Policies {
    let named = policies.iter().filter(|(policy, _)| !policy.starts_with("fixed:"));
    named.map(|(policy, scenarios)| (policy.clone(), scenarios.clone())).collect()
}

/// All that was measured in one scenario: policies down, measures across.
#[must_use]
pub fn everything(results: &Results, table: (&Policies, &str)) -> Table {
    let (policies, scenario) = table;
    let measured =
        policies.values().filter_map(|s| s.get(scenario)).flat_map(|m| m.keys().map(String::as_str));
    let present: BTreeSet<&str> = measured.collect();
    let known = measure::ORDER.into_iter().filter(|m| present.contains(m));
    let others = present.iter().copied().filter(|m| !measure::ORDER.contains(m));
    let wanted: Vec<&str> = known.chain(others).collect();
    measures(results, table, &wanted)
}

fn measures(results: &Results, (policies, scenario): (&Policies, &str), wanted: &[&str]) -> Table {
    let find = |policy: &str, measure: &str| lookup::find(policies, policy, scenario, measure);
    let names: Vec<&str> = policy::ordered(policies.keys())
        .into_iter()
        .filter(|p| wanted.iter().any(|m| find(p, m).is_some()))
        .collect();
    let shown: Vec<&str> =
        wanted.iter().copied().filter(|m| names.iter().any(|p| find(p, m).is_some())).collect();
    let row = |&policy: &&str| {
        let mut cells = vec![Cell::name(policy::label(policy, results))];
        cells.extend(shown.iter().map(|m| Cell::measured(m, find(policy, m))));
        cells
    };
    let mut columns = vec!["Policy".to_owned()];
    columns.extend(shown.iter().map(|m| measure::label(m).to_owned()));
    Table { caption: String::new(), columns, rows: names.iter().map(row).collect() }
}

/// Total cost over the mix, on every set of roads.
#[must_use]
pub fn roads(results: &Results) -> Table {
    let mut sets: Vec<(&str, &Policies)> = vec![(results.roads.as_str(), &results.policies)];
    sets.extend(results.other_roads.iter().map(|(name, policies)| (name.as_str(), policies)));
    let keys: BTreeSet<&String> =
        sets.iter().flat_map(|(_, p)| p.keys()).filter(|k| !k.starts_with("fixed:")).collect();
    let row = |policy: &str| {
        let total = |p: &Policies| lookup::find(p, policy, "mix", "total");
        let mut cells = vec![Cell::name(policy::label(policy, results))];
        cells.extend(sets.iter().map(|(_, p)| Cell::measured("total", total(p))));
        cells
    };
    let mut columns = vec!["Total cost, mix of scenarios".to_owned()];
    columns.extend(sets.iter().map(|(name, _)| format!("{name} roads")));
    let rows = policy::ordered(keys.iter().copied()).into_iter().map(row).collect();
    Table { caption: String::new(), columns, rows }
}

/// Every fixed choice that was measured, the cheapest in total first.
#[must_use]
pub fn subsets(results: &Results) -> Table {
    let mut points: Vec<_> = results.figures.subset_front.iter().collect();
    points.sort_by(|a, b| b.total.mean.total_cmp(&a.total.mean));
    let cost = |e: Estimate| Cell::measured("total", Some(e));
    let row = |p: &&crate::results::FrontPoint| {
        let stage = match p.stage {
            crate::results::Stage::Screened => "screened",
            crate::results::Stage::Confirmed => "confirmed",
        };
        let name = Cell::name(p.words(" + "));
        vec![name, Cell::text(stage), cost(p.total), cost(p.motor), Cell::text(number::fixed(p.price, 1))]
    };
    Table {
        caption: "“/2”: looked at only at every second step. “Screened”: few seeds. “Confirmed”: trained again on fresh seeds, so that choosing the winner is \
                  not selection."
            .to_owned(),
        columns: ["Sensors", "", "Total cost", "Motor cost", "Price of looks"].map(str::to_owned).to_vec(),
        rows: points.iter().map(row).collect(),
    }
}
