//! The headline table on the terminal.

use metal_lab::results::{Estimate, Policies};

/// Prints total, motor cost, looks and accidents of every policy in `scenario`, the best total first.
pub fn print(policies: &Policies, scenario: &str) {
    let mut rows: Vec<_> =
        policies.iter().filter_map(|(name, s)| s.get(scenario).map(|m| (name, m))).collect();
    rows.sort_by(|a, b| b.1["total"].mean.total_cmp(&a.1["total"].mean));
    let width = rows.iter().map(|(name, _)| name.len()).max().unwrap_or(6).max(6);
    println!("{scenario}: mean per motor step [95 % interval over trainings]; negative is worse\n");
    println!("{:width$}  {:>24}  {:>24}  {:>6}  {:>9}", "policy", "total", "motor", "looks", "accidents");
    for (name, m) in rows {
        let (total, motor) = (interval(&m["total"]), interval(&m["motor"]));
        let (looks, accidents) = (m["looks"].mean, 100.0 * m["accident_rate"].mean);
        println!("{name:width$}  {total:>24}  {motor:>24}  {looks:>6.2}  {accidents:>7.0} %");
    }
}

fn interval(e: &Estimate) -> String {
    match (e.lo, e.hi) {
        (Some(lo), Some(hi)) => format!("{:.2} [{lo:.2}, {hi:.2}]", e.mean),
        _ => format!("{:.2}", e.mean),
    }
}
