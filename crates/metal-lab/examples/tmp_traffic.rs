#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]
use metal_lab::registry::highway;
use metal_rl::environment::Environment;
use metal_worlds::highway::*;
fn main() {
    let mut speeds = [0usize; 10];
    let mut off = 0;
    let mut n = 0;
    let mut wrong = 0;
    let s = match std::env::args().nth(1).as_deref() {
        Some("a") => Scenario::Approaching,
        _ => Scenario::FromBehind,
    };
    let mut w = highway(&HighwayConfig::new(RoadSet::Training, s), metal_lab::traffic::steering());
    let mut worst = vec![];
    for e in 0..200 {
        w.reset(e).unwrap();
        let mut cost = 0.0;
        let mut contacts = 0;
        for t in 0..50 {
            let before = w.cars()[0];
            let a = w.advise().unwrap();
            let o = w.step(a).unwrap();
            cost += o.motor_reward;
            contacts += (w.measures()[9] > 0.5) as usize;
            let after = w.cars()[0];
            let v = before.distance_m(&after) / 0.5;
            speeds[((v * 100.0) as usize).min(9)] += 1;
            n += 1;
            let p = w.road().locate(after.x_m, after.y_m);
            off += (p.offset_m.abs() > 0.147) as usize;
            let d = p.direction(after.heading_rad);
            wrong += (p.lane_offset_m(d) > 0.07) as usize;
            if e == 999 {
                println!(
                    "t{t} a{a} learner off {:.3} car v {:.3} car lane off {:.3} gap {:.3} c {:.1}",
                    w.measures()[5],
                    v,
                    p.lane_offset_m(d),
                    w.measures()[8],
                    o.motor_reward
                );
            }
        }
        worst.push((cost as i64, contacts, e));
    }
    worst.sort();
    println!("{:?}", &worst[..20]);
    println!(
        "speeds cm/s {:?} off {:.3} wrong {:.3}",
        speeds.map(|s| s as f64 / n as f64),
        off as f64 / n as f64,
        wrong as f64 / n as f64
    );
}
