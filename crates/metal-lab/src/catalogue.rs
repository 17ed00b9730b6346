//! What there is to choose from: `metal list`.

use std::fmt::Write;

/// Kind, name in an experiment file, what it is.
const ENTRIES: &[(&str, &str, &str)] = &[
    (
        "environment",
        "highway",
        "Highway-v0: the miniature two-lane highway of the paper, seven priced sensors",
    ),
    (
        "environment",
        "miniature",
        "Miniature-v0: another road with red objects that stand, another renderer and body (Sec. 5)",
    ),
    ("environment", "maze", "Maze-v0: the n x n maze of Eq. (14), two sensors, X and Y"),
    ("environment", "puddle", "Puddle-v0: the usual proving ground of continuous reinforcement learning"),
    ("environment", "toy", "Toy-v0: seven experts and one move; the optimum is known exactly"),
    ("environment", "cube", "Cube-v0: classification with 20 features that cost"),
    ("environment", "cube_nm", "CubeNM-v0: the same in five contexts; which one, must be bought, too"),
    ("environment", "faulty", "any of these behind sensors that fail (`faults`), e.g. { dead, rate = 0.25 }"),
    ("environment", "priced", "any of these with looks at `factor` times their price"),
    ("environment", "replay", "a recording (`file`), of a simulation or a robot; it goes its own way"),
    (
        "learner",
        "absp",
        "Bayesian continuous Q-learning, action-based soft partition by Gaussians (the paper's family)",
    ),
    ("learner", "bayes_mix", "the same partition with Normal-Gamma values: knows how unsure it is"),
    ("learner", "igmn", "incremental Gaussian network over state and value, corrected"),
    ("learner", "tile", "tile coding"),
    ("learner", "mlp", "a small neural network with replay"),
    (
        "learner",
        "calibrated",
        "another learner (`of`); a support is the probability that the action turns out best",
    ),
    ("learner", "given", "no learning: the sensor's reading is the expert's opinion"),
    ("acting", "\"advisor\"", "the environment's expert advisor (Phase I; the oracle)"),
    (
        "acting",
        "{ demonstrations = FILE }",
        "what a person or a robot showed: `metal studio`, `metal drive --demonstrate` (Phase I)",
    ),
    ("acting", "{ solo = MEMBER }", "one member alone: the full observer, a fixed subset of sensors"),
    ("acting", "{ fusion = FUSER }", "the whole roster through a fuser (Phase II)"),
    ("acting", "{ attention = NAME }", "an attention controller (Phase III)"),
    ("acting", "{ random_looks = MEAN }", "as many looks on average, at nobody in particular"),
    ("acting", "\"blind\"", "the best constant action"),
    ("fuser", "max_confidence", "the most confident agent decides, Eq. (7)"),
    ("fuser", "log_opinion_pool", "independent evidence multiplies"),
    ("fuser", "weighted_log_opinion_pool", "the same with a weight per agent"),
    ("fuser", "sum", "mean support"),
    ("fuser", "product", "product of supports"),
    ("fuser", "borda", "rank points"),
    ("fuser", "majority", "one vote per agent"),
    ("fuser", "owa", "ordered weighted average"),
    (
        "experiment",
        "experiments/paper.toml",
        "every phase, figure and table of the paper (`metal reproduce`)",
    ),
    (
        "experiment",
        "experiments/attention.toml",
        "attention against the best fixed choice of sensors, all by counterfactual policy iteration",
    ),
    (
        "experiment",
        "experiments/partition.toml",
        "the eye in raw cells, for tiny agents to be proposed (`metal partition`)",
    ),
    (
        "experiment",
        "experiments/transfer.toml",
        "trained minds on another road, through another eye and body (`metal transfer`)",
    ),
    (
        "experiment",
        "experiments/truth.toml",
        "looks at a sensor that hides nothing: what their timing alone can earn",
    ),
    ("experiment", "experiments/toy.toml", "attention control against its exact optimum"),
    ("experiment", "experiments/toy_counterfactual.toml", "the same, learned from what would have happened"),
];

/// The list as text, grouped by kind.
#[must_use]
pub fn text() -> String {
    let width = ENTRIES.iter().map(|(_, name, _)| name.len()).max().unwrap_or(0);
    let mut text = String::new();
    let mut last = "";
    for (kind, name, what) in ENTRIES.iter().copied() {
        if kind != last {
            let _ = writeln!(text, "{}{kind}s", if last.is_empty() { "" } else { "\n" });
            last = kind;
        }
        let _ = writeln!(text, "  {name:width$}  {what}");
    }
    text
}
