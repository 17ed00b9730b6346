//! The maze of Eq. (14) as an experiment in which attention learns by counterfactual policy iteration.

/// The experiment with this text in its table of counterfactual policy iteration, with a budget of so many motor steps.
pub fn maze(recipe: &str, steps: usize) -> String {
    format!(
        "title = \"Maze\"
[environment.maze]
[learner.plain.tile]
[member.X]
sensors = [\"X\"]
learner = \"plain\"
[member.Y]
sensors = [\"Y\"]
learner = \"plain\"
[attention.acl.counterfactual]
{recipe}
looks = {{ adaptive = {{ max_looks = 2 }} }}
[phase.attention]
roster = [\"X\", \"Y\"]
acting = {{ attention = \"acl\" }}
teaching = \"nobody\"
rate = \"full\"
exploration = {{ random = {{ from = 1.0, to = 0.2, until = 1.0 }} }}
budget = {{ steps = {steps} }}
[policy.acl]
after = \"attention\"
roster = [\"X\", \"Y\"]
acting = {{ attention = \"acl\" }}"
    )
}
