//! The one loop. It names no phase, no learner and no world: demonstration, the full observer alone, fusion, attention
//! control, evaluation and every baseline run through here.

use crate::decision::DecisionState;
use crate::environment::{End, Environment, EnvironmentError, Outcome};
use crate::member::{Member, decision_dims};
use crate::observe::{Observer, Step};
use crate::phase::{Budget, Phase, Sensing};
use crate::policy::{Choice, Experience, Policy, Situation};
use crate::random::{Rng, Streams};
use crate::set::IndexSet;
use crate::teach::Episode;
use crate::view::{Percept, Scaling};
use serde::{Deserialize, Serialize};

/// Who is where: a world, the members of a mind, and who is at the wheel.
pub struct Stage<'a> {
    /// The world.
    pub environment: &'a mut dyn Environment,
    /// The mind's members.
    pub members: &'a mut [Member],
    /// Who chooses looks and moves.
    pub policy: &'a mut dyn Policy,
    /// How readings are scaled for every member.
    pub scaling: Scaling,
}

/// Where a phase stands between two of its episodes: with the minds, all there is to know to go on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Position {
    /// Finished episodes.
    pub episodes: usize,
    /// Their motor steps.
    pub steps: usize,
}

impl Position {
    /// Share of `budget` that is spent, in [0, 1].
    #[must_use]
    pub fn progress(&self, budget: Budget) -> f64 {
        let share = |done: usize, all: usize| if all == 0 { 1.0 } else { done as f64 / all as f64 };
        match budget {
            Budget::Episodes(n) => share(self.episodes, n),
            Budget::Steps(n) => share(self.steps, n),
        }
    }
}

/// A part of a phase: from where, and until when.
pub struct Leg<'a> {
    /// Where the phase stands.
    pub at: Position,
    /// Asked after every episode whether to pause.
    pub pause: &'a mut dyn FnMut() -> bool,
}

/// Runs one phase to the end of its budget. All randomness comes from `streams`; episode k is the same whatever came
/// before it, so policies are compared on the same starts, traffic and noise.
///
/// # Errors
/// If the environment fails; what was learned until then stays learned.
pub fn run(
    stage: &mut Stage<'_>,
    phase: &Phase,
    streams: &Streams,
    observer: &mut dyn Observer,
) -> Result<(), EnvironmentError> {
    let mut leg = Leg { at: Position::default(), pause: &mut || false };
    run_leg(stage, phase, streams, &mut leg, observer)?;
    Ok(())
}

/// As [`run`], from `leg.at` until the budget is spent (then true) or somebody wants a pause. Legs one after the other
/// give the same bits as one run, if the world forgets everything between episodes.
///
/// # Errors
/// If the environment fails; what was learned until then stays learned.
pub fn run_leg(
    stage: &mut Stage<'_>,
    phase: &Phase,
    streams: &Streams,
    leg: &mut Leg<'_>,
    observer: &mut dyn Observer,
) -> Result<bool, EnvironmentError> {
    let mut desk = Desk::new(stage);
    loop {
        let Position { episodes: episode, steps } = leg.at;
        let progress = leg.at.progress(phase.budget);
        if progress >= 1.0 {
            return Ok(true);
        }
        let left = match phase.budget {
            Budget::Episodes(_) => usize::MAX,
            Budget::Steps(n) => n - steps,
        };
        let clock = Clock { episode, progress, steps_left: left };
        leg.at.steps += desk.episode(stage, phase, &streams.nth(episode as u64), (clock, observer))?;
        leg.at.episodes += 1;
        observer.on_episode(episode, leg.at.progress(phase.budget));
        observer.on_members(stage.members);
        if leg.at.progress(phase.budget) < 1.0 && (leg.pause)() {
            return Ok(false);
        }
    }
}

/// A decision that was not carried out.
#[derive(Clone, Debug, PartialEq)]
pub struct Decided {
    /// Members consulted, in order.
    pub order: Vec<usize>,
    /// The motor action.
    pub action: usize,
    /// Price of the looks (≥ 0).
    pub look_price: f64,
}

/// One decision where the world stands now, made as [`run`] makes it at the end of `phase`: looks, one at a time,
/// until the policy moves. Nothing is carried out and nobody learns, so the world stays as it is. Table 1.
///
/// # Errors
/// If a sensor does not answer.
pub fn decide(stage: &mut Stage<'_>, phase: &Phase, streams: &Streams) -> Result<Decided, EnvironmentError> {
    let mut desk = Desk::new(stage);
    desk.rng = streams.stream("policy");
    stage.policy.begin(false);
    let (action, look_price) = desk.decide(stage, phase, 1.0)?;
    Ok(Decided { order: desk.state.order().to_vec(), action, look_price })
}

/// Where in the phase an episode stands.
#[derive(Clone, Copy)]
struct Clock {
    episode: usize,
    progress: f64,
    steps_left: usize,
}

/// The loop's working memory, kept from step to step so that nothing is allocated.
struct Desk {
    percept: Percept,
    state: DecisionState,
    episode: Episode,
    rng: Rng,
}

impl Desk {
    fn new(stage: &Stage<'_>) -> Self {
        let spec = stage.environment.spec();
        Self {
            percept: Percept::new(spec, stage.scaling),
            state: DecisionState::new(&decision_dims(stage.members, spec)),
            episode: Episode::new(stage.members),
            rng: Rng::new(0),
        }
    }

    /// One episode; returns its number of motor steps.
    fn episode(
        &mut self,
        stage: &mut Stage<'_>,
        phase: &Phase,
        streams: &Streams,
        (clock, observer): (Clock, &mut dyn Observer),
    ) -> Result<usize, EnvironmentError> {
        stage.environment.reset(streams.child("world").seed())?;
        self.rng = streams.stream("policy");
        self.episode.clear();
        stage.policy.begin(phase.policy_learns);
        let mut index = 0;
        let end = loop {
            let (action, look_price) = self.decide(stage, phase, clock.progress)?;
            let outcome = stage.environment.step(action)?;
            refuse_nonsense(&outcome, action, stage.environment)?;
            index += 1;
            let end = if outcome.end == End::Running && index == clock.steps_left {
                End::TimeLimit
            } else {
                outcome.end
            };
            self.episode.record_state(&self.state);
            self.episode.record_move(action, outcome.motor_reward, end == End::Terminal);
            if phase.policy_learns {
                stage.policy.experience(Experience {
                    motor_reward: outcome.motor_reward,
                    terminal: end == End::Terminal,
                });
            }
            observer.on_step(&Step {
                episode: clock.episode,
                index: index - 1,
                percept: &self.percept,
                state: &self.state,
                action,
                motor_reward: outcome.motor_reward,
                look_price,
                measures: stage.environment.measures(),
                end,
            });
            if end != End::Running {
                break end;
            }
        };
        if phase.learns() {
            self.learn(stage, phase, clock.progress, end)?;
        }
        Ok(index)
    }

    /// Everybody learns. Behind a time limit there is a future: one more decision, not carried out, tells its value
    /// (reading R6).
    fn learn(
        &mut self,
        stage: &mut Stage<'_>,
        phase: &Phase,
        progress: f64,
        end: End,
    ) -> Result<(), EnvironmentError> {
        if end == End::TimeLimit {
            self.decide(stage, phase, progress)?;
            self.episode.record_state(&self.state);
        }
        self.episode.teach(stage.members, phase.roster, &phase.lessons);
        if phase.policy_learns {
            stage.policy.learn();
        }
        Ok(())
    }

    /// Looks, one at a time, until the policy moves: the move, and the price of the looks.
    fn decide(
        &mut self,
        stage: &mut Stage<'_>,
        phase: &Phase,
        progress: f64,
    ) -> Result<(usize, f64), EnvironmentError> {
        self.percept.clear();
        self.state.clear();
        let mut price = 0.0;
        if phase.sensing == Sensing::Everyone {
            for m in phase.roster.iter() {
                price += self.consult(stage, m)?;
            }
        }
        let advice = if stage.policy.wants_advice() { stage.environment.advise() } else { None };
        let exploration = phase.exploration.at(progress);
        loop {
            let situation = Situation { state: &self.state, advice, exploration, progress };
            match stage.policy.choose(&situation, &mut self.rng) {
                Choice::Move(action) => return Ok((action, price)),
                Choice::Consult(m) => {
                    assert_may_consult(m, phase.roster, &self.state);
                    price += self.consult(stage, m)?;
                }
            }
        }
    }

    fn consult(&mut self, stage: &mut Stage<'_>, member: usize) -> Result<f64, EnvironmentError> {
        stage.members[member].consult(member, stage.environment, &mut self.percept, &mut self.state)
    }
}

/// A sensor may fail, a reward may not: what is no number cannot be learned from.
fn refuse_nonsense(
    outcome: &Outcome,
    action: usize,
    environment: &dyn Environment,
) -> Result<(), EnvironmentError> {
    if outcome.motor_reward.is_finite() {
        return Ok(());
    }
    let spec = environment.spec();
    Err(EnvironmentError::Motor {
        environment: spec.id.clone(),
        action: spec.actions[action].clone(),
        reason: format!("its reward is {}, not a finite number", outcome.motor_reward),
    })
}

/// A policy that asks twice would loop for ever; one that asks outsiders would use benched members.
fn assert_may_consult(member: usize, roster: IndexSet, state: &DecisionState) {
    assert!(roster.contains(member), "the policy consulted member {member}, who is not on the roster");
    assert!(
        !state.attended().contains(member),
        "the policy consulted member {member} twice in one motor step"
    );
}
