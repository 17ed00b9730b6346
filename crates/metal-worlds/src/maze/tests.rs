use super::*;
use proptest::prelude::*;

fn cell(x: usize, y: usize) -> Cell {
    Cell { x, y }
}

/// A wall with a door in the east: x = 0 … 2 of row 1.
fn with_walls() -> MazeConfig {
    MazeConfig { walls: vec![cell(0, 1), cell(1, 1), cell(2, 1)], goal: cell(0, 3), ..MazeConfig::default() }
}

#[test]
fn an_open_maze_is_worth_its_distance() {
    let config = MazeConfig::default();
    let values = optimal_values(&config, 1.0);
    for y in 0..4 {
        for x in 0..4 {
            assert_eq!(values[config.index(cell(x, y))..][..1], [-((3 - x + 3 - y) as f64)]);
        }
    }
}

#[test]
fn a_wall_makes_a_detour() {
    let config = with_walls();
    assert_eq!(optimal_values(&config, 1.0)[..1], [-9.0]);
    let discounted = optimal_values(&config, 0.5)[0];
    assert!((discounted + 2.0 * (1.0 - 0.5_f64.powi(9))).abs() < 1e-12);
}

#[test]
fn the_advisor_earns_the_optimal_value_from_everywhere() {
    let mut maze = Maze::new(with_walls()).unwrap();
    for seed in 0..50 {
        maze.reset(seed).unwrap();
        let (start, mut total) = (maze.at, 0.0);
        loop {
            let action = maze.advise().unwrap();
            let outcome = maze.step(action).unwrap();
            total += outcome.motor_reward;
            if outcome.end != End::Running {
                assert_eq!(outcome.end, End::Terminal);
                break;
            }
        }
        assert!((total - maze.values[maze.config.index(start)]).abs() < 1e-12);
    }
}

#[test]
fn two_states_of_one_column_differ_only_in_y() {
    // Fig. 12: aliased for who sees X, distinct for who sees Y.
    let mut maze = Maze::new(MazeConfig::default()).unwrap();
    let mut read = |at: Cell, sensor: usize| {
        maze.at = at;
        let mut out = [f64::NAN];
        maze.sense(sensor, &mut out).unwrap();
        out.to_vec()
    };
    assert_eq!(read(cell(1, 0), 0), read(cell(1, 2), 0));
    assert_ne!(read(cell(1, 0), 1), read(cell(1, 2), 1));
}

#[test]
fn bumping_costs_and_leads_nowhere() {
    let mut maze = Maze::new(MazeConfig::default()).unwrap();
    maze.at = cell(0, 0);
    let outcome = maze.step(3).unwrap();
    assert_eq!(outcome, Outcome { motor_reward: -2.0, end: End::Running });
    assert_eq!((maze.at, maze.measures()), (cell(0, 0), &[0.0, 0.0, 1.0][..]));
}

#[test]
fn the_clock_stops_who_wanders() {
    let mut maze = Maze::new(MazeConfig::default()).unwrap();
    maze.at = cell(0, 0);
    let ends: Vec<End> = (0..64).map(|_| maze.step(3).unwrap().end).collect();
    assert_eq!((ends[62], ends[63]), (End::Running, End::TimeLimit));
}

#[test]
fn impossible_mazes_are_refused() {
    let error = |config: MazeConfig| Maze::new(config).unwrap_err();
    let base = MazeConfig::default;
    assert_eq!(error(MazeConfig { side: 1, ..base() }), MazeError::TooSmall(1));
    assert_eq!(
        error(MazeConfig { goal: cell(4, 0), ..base() }),
        MazeError::Outside { cell: cell(4, 0), side: 4 }
    );
    assert_eq!(error(MazeConfig { walls: vec![cell(3, 3)], ..base() }), MazeError::NoWay);
    let cut = MazeConfig { walls: vec![cell(1, 0), cell(0, 1)], ..base() };
    assert_eq!(error(cut), MazeError::CutOff(cell(0, 0)));
    assert!(matches!(error(MazeConfig { step_reward: 0.0, ..base() }), MazeError::Number { .. }));
    assert!(matches!(error(MazeConfig { look_price: f64::NAN, ..base() }), MazeError::Number { .. }));
}

proptest! {
    #[test]
    fn values_obey_the_optimality_equation(
        side in 2..7_usize, raw in prop::collection::vec((0..7_usize, 0..7_usize), 0..8), discount in 0.5..1.0_f64
    ) {
        let walls = raw.into_iter().filter(|&(x, y)| x < side && y < side).map(|(x, y)| cell(x, y)).collect();
        let config = MazeConfig { side, walls, goal: cell(0, 0), ..MazeConfig::default() };
        prop_assume!(config.check().is_ok());
        let values = optimal_values(&config, discount);
        for at in config.starts() {
            let best = (0..4)
                .map(|a| {
                    let next = config.next(at, a);
                    config.reward(next.is_none()) + discount * values[config.index(next.unwrap_or(at))]
                })
                .fold(f64::MIN, f64::max);
            prop_assert!((values[config.index(at)] - best).abs() < 1e-9);
        }
    }
}
