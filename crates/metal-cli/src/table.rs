//! The headline table on the terminal.

use metal_lab::results::{Estimate, Measures, Policies};

/// Total, motor cost, looks and accidents of every policy in `scenario`, the best total first.
pub fn text(policies: &Policies, scenario: &str) -> String {
    let mut rows: Vec<_> =
        policies.iter().filter_map(|(name, s)| s.get(scenario).map(|m| (name, m))).collect();
    rows.sort_by(|a, b| b.1["total"].mean.total_cmp(&a.1["total"].mean));
    let width = rows.iter().map(|(name, _)| name.len()).max().unwrap_or(6).max(6);
    let head = format!(
        "{:width$}  {:>24}  {:>24}  {:>6}  {:>9}\n",
        "policy", "total", "motor", "looks", "accidents"
    );
    let what = "mean per motor step [95 % interval over trainings]; negative is worse";
    let rows: String = rows.iter().map(|(name, m)| format!("{name:width$}  {}\n", row(m))).collect();
    format!("{scenario}: {what}\n\n{head}{rows}")
}

fn row(m: &Measures) -> String {
    let (total, motor) = (interval(&m["total"]), interval(&m["motor"]));
    let (looks, accidents) = (m["looks"].mean, 100.0 * m["accident_rate"].mean);
    format!("{total:>24}  {motor:>24}  {looks:>6.2}  {accidents:>7.0} %")
}

fn interval(e: &Estimate) -> String {
    match (e.lo, e.hi) {
        (Some(lo), Some(hi)) => format!("{:.2} [{lo:.2}, {hi:.2}]", e.mean),
        _ => format!("{:.2}", e.mean),
    }
}
