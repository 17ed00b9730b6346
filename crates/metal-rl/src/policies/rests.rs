//! Members that gave no answer are left alone for a while, and asked again now and then (reading R116): whoever is broken
//! costs little, and comes back as soon as it is mended.

use crate::set::IndexSet;
use serde::{Deserialize, Serialize};

/// When silent members rest, and for how long.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RestConfig {
    /// Looks in a row without an answer after which a member rests; 0: nobody ever does.
    pub after: usize,
    /// Motor steps of its first rest; each silent look after a rest doubles it.
    pub first: usize,
    /// Motor steps of the longest rest.
    pub longest: usize,
}

impl Default for RestConfig {
    fn default() -> Self {
        Self { after: 2, first: 8, longest: 64 }
    }
}

impl RestConfig {
    /// Whoever is silent is asked on.
    pub const NEVER: Self = Self { after: 0, first: 0, longest: 0 };
}

/// The slots whose members are among `of`.
pub(super) fn slots_of(members: &[usize], of: IndexSet) -> IndexSet {
    let among = members.iter().enumerate().filter(|(_, member)| of.contains(**member));
    among.fold(IndexSet::EMPTY, |slots, (slot, _)| slots.with(slot))
}

/// Who rests, within an episode.
#[derive(Clone, Debug)]
pub(super) struct Rests {
    config: RestConfig,
    members: Vec<Member>,
    step: usize,
}

#[derive(Clone, Copy, Debug, Default)]
struct Member {
    silent_looks: usize,
    length: usize,
    until: usize,
}

impl Rests {
    /// Nobody rests; there are `slots` members.
    pub fn new(config: RestConfig, slots: usize) -> Self {
        Self { config, members: vec![Member::default(); slots], step: 0 }
    }

    /// A new episode: what was broken may be mended.
    pub fn begin(&mut self) {
        self.members.fill(Member::default());
        self.step = 0;
    }

    /// Slots that are not asked in this motor step.
    pub fn resting(&self) -> IndexSet {
        let rests = self.members.iter().enumerate().filter(|(_, member)| member.until > self.step);
        rests.fold(IndexSet::EMPTY, |all, (slot, _)| all.with(slot))
    }

    /// The motor step is over; of the slots, some were `asked` and some of these `heard`.
    pub fn end_step(&mut self, asked: IndexSet, heard: IndexSet) {
        self.step += 1;
        for slot in asked.iter() {
            let member = &mut self.members[slot];
            if heard.contains(slot) {
                *member = Member::default();
                continue;
            }
            member.silent_looks += 1;
            if self.config.after > 0 && member.silent_looks >= self.config.after {
                member.length =
                    member.length.saturating_mul(2).max(self.config.first).min(self.config.longest);
                member.until = self.step.saturating_add(member.length);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Motor steps, out of `steps`, in which slot 0 is asked as often as it does not rest and answers as `sound` says.
    fn asked(config: RestConfig, steps: usize, sound: impl Fn(usize) -> bool) -> Vec<usize> {
        let (mut rests, only) = (Rests::new(config, 2), IndexSet::EMPTY.with(0));
        let mut asked = Vec::new();
        for step in 0..steps {
            let now = only.minus(rests.resting());
            asked.extend(now.iter().map(|_| step));
            rests.end_step(now, if sound(step) { now } else { IndexSet::EMPTY });
        }
        asked
    }

    #[test]
    fn rests_double_until_an_answer_comes() {
        let config = RestConfig { after: 2, first: 3, longest: 10 };
        assert_eq!(asked(config, 40, |_| false), [0, 1, 5, 12, 23, 34]);
        let mended = asked(config, 20, |step| step >= 4);
        assert_eq!(mended[..3], [0, 1, 5]);
        assert_eq!(mended.len(), 2 + 15, "asked at every step again");
    }

    #[test]
    fn one_answer_forgives_and_nobody_rests_who_need_not() {
        let config = RestConfig { after: 3, ..RestConfig::default() };
        assert_eq!(asked(config, 30, |step| step % 3 == 2).len(), 30);
        assert_eq!(asked(RestConfig::NEVER, 30, |_| false).len(), 30);
    }

    #[test]
    fn a_new_episode_begins_without_grudges() {
        let mut rests = Rests::new(RestConfig { after: 1, first: 5, longest: 5 }, 1);
        rests.end_step(IndexSet::first(1), IndexSet::EMPTY);
        assert_eq!(rests.resting(), IndexSet::first(1));
        rests.begin();
        assert_eq!(rests.resting(), IndexSet::EMPTY);
    }
}
