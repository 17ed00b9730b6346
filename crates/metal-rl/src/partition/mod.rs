//! Which raw sensors should make one tiny agent: partitions of the perceptual space proposed from a demonstration.
//!
//! Sec. 4.2 opts for "a simple heuristic hand-design" of the regions and leaves two other ways open, both of which are
//! here: agglomerative clustering (its reference \[30\]; [`linkage`] over the distances of [`alike`]) and optimisation
//! (its reference \[22\]; [`growth`] by the worth that [`telling`] measures). They want different things:
//!
//! * **Clustering** puts together what says *the same*. A tiny agent then sees a homogeneous part of the world with few
//!   degrees of freedom, which is easy to learn from; but whoever looks at it pays several times for one piece of news.
//! * **Growth** puts together what *tells the expert's action* and is worth its price, and leaves to later groups, or
//!   to the rest, what adds too little to those who are there. Redundant sensors end up in different groups, of which attention
//!   can ask one.
//!
//! All functions are pure; the same demonstration gives the same groups. Reading R132.

pub mod alike;
pub mod growth;
pub mod linkage;
pub mod shown;
pub mod telling;
#[cfg(test)]
mod tests;

pub use shown::Shown;

use crate::random::Rng;

/// Groups of sensors: every sensor in exactly one, sensors and groups in increasing order.
pub type Groups = Vec<Vec<usize>>;

/// `groups` in the order of their first members, members in order, empty ones left out.
#[must_use]
pub fn in_order(mut groups: Groups) -> Groups {
    groups.retain(|group| !group.is_empty());
    groups.iter_mut().for_each(|group| group.sort_unstable());
    groups.sort_unstable();
    groups
}

/// `sensors` dealt at random into `count` groups of nearly the same size: what any proposal has to beat.
///
/// # Panics
/// If `count` is 0.
#[must_use]
pub fn dealt(sensors: usize, count: usize, rng: &mut Rng) -> Groups {
    let mut deck: Vec<usize> = (0..sensors).collect();
    rng.shuffle(&mut deck);
    in_order((0..count).map(|g| deck.iter().copied().skip(g).step_by(count).collect()).collect())
}
