//! A training by counterfactual policy iteration that paused between two iterations, as foreign bytes.

use super::forge;
use metal_rl::counterfactual::{
    Alone, CounterfactualConfig, CounterfactualError, CriticConfig, JudgeConfig, School, Term, iterate_term,
};
use metal_rl::environment::Environment;
use metal_rl::learner::Dims;
use metal_rl::learners::{LearnerConfig, TileConfig};
use metal_rl::member::Member;
use metal_rl::observe::Unobserved;
use metal_rl::phase::{Budget, Phase};
use metal_rl::random::Streams;
use metal_rl::set::IndexSet;
use metal_rl::view::{Scaling, View};
use metal_worlds::maze::{Maze, MazeConfig};

/// Goes on with a training for one more iteration, with the outer checksum made right. The first byte says who judges.
pub fn course(bytes: &[u8]) {
    let Some((judge, course)) = bytes.split_first() else { return };
    let mut course = course.to_vec();
    forge(&mut course);
    let _ = one_iteration(judge % 2 == 1, Some(course));
}

/// One iteration in a maze, from `course` on or from the beginning: where the training stands then.
pub fn one_iteration(critic: bool, course: Option<Vec<u8>>) -> Result<Option<Vec<u8>>, CounterfactualError> {
    let build = || Maze::new(MazeConfig::default()).expect("a maze");
    let (mut environment, mut validation) = (build(), build());
    let spec = environment.spec().clone();
    let member = |sensor: usize| Member {
        name: spec.sensors[sensor].name.clone(),
        view: View::new(&spec, &[sensor]),
        learner: LearnerConfig::Tile(TileConfig::default())
            .build(Dims { inputs: 1, choices: spec.actions.len() }, 1)
            .expect("good settings"),
    };
    let mut members = [member(0), member(1)];
    let mut school = School {
        environment: &mut environment,
        validation: &mut validation,
        members: &mut members,
        roster: vec![0, 1],
        scaling: Scaling::Linear,
        workers: &Alone,
        interrupted: &|| false,
        ear: &mut |_| {},
    };
    let lesson = Phase { budget: Budget::Steps(90), ..Phase::evaluation("attention", IndexSet::first(2), 0) };
    let mut term = Term { course, pause: &mut || true };
    iterate_term(&mut school, (&settings(critic), &lesson, &Streams::new(2)), &mut term, &mut Unobserved)?;
    Ok(term.course)
}

/// Nine iterations, each as short as can be.
fn settings(critic: bool) -> CounterfactualConfig {
    let mut config = CounterfactualConfig { iterations: 9, horizon: 2, ..CounterfactualConfig::default() };
    (config.validation_runs, config.fit.batches, config.network.hidden) = (1, 2, vec![4]);
    if critic {
        let settings = CriticConfig { batches: 2, capacity: 50, labels: 20, ..CriticConfig::default() };
        config.judge = JudgeConfig::Critic(CriticConfig { hidden: vec![4], ..settings });
    }
    config
}
