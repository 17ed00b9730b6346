//! A critic at rest, as bytes: its log and its networks.

use super::{Critic, Networks};
use crate::counterfactual::judge::log::Moment;
use crate::counterfactual::student::Student;
use crate::learner::LearnerError;
use crate::learners::frozen;
use crate::set::IndexSet;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::VecDeque;

/// What a critic is sealed as.
const NAME: &str = "critic";

#[derive(Serialize, Deserialize)]
struct Notes<'a> {
    moments: Cow<'a, VecDeque<Moment>>,
    networks: Cow<'a, Option<Networks>>,
    drives: u64,
}

/// All that `critic` has seen and learned.
pub(super) fn freeze(critic: &Critic) -> Vec<u8> {
    let Critic { moments, networks, drives, .. } = critic;
    let notes = Notes { moments: Cow::Borrowed(moments), networks: Cow::Borrowed(networks), drives: *drives };
    frozen::seal(NAME, &notes)
}

/// Gives `critic` what was frozen in `bytes`.
///
/// # Errors
/// If they are damaged or of a critic with other settings or for a student of another shape.
pub(super) fn thaw(critic: &mut Critic, student: &Student, bytes: &[u8]) -> Result<(), LearnerError> {
    let notes: Notes<'_> = frozen::open(NAME, bytes)?;
    let widths = |outputs: usize| -> Vec<usize> {
        let hidden = critic.config.hidden.iter().copied();
        std::iter::once(student.layout().width()).chain(hidden).chain([outputs]).collect()
    };
    let fit = |n: &Networks| n.value.fits(&widths(1)) && n.advantage.fits(&widths(student.actions()));
    let sound = notes.networks.iter().all(fit)
        && notes.moments.len() <= critic.config.capacity
        && notes.moments.iter().all(|moment| fits(moment, student));
    if !sound {
        return Err(frozen::foreign(NAME));
    }
    critic.drives = notes.drives;
    (critic.moments, critic.networks) = (notes.moments.into_owned(), notes.networks.into_owned());
    Ok(())
}

/// Whether a moment is one of such a student's.
fn fits(moment: &Moment, student: &Student) -> bool {
    let layout = student.layout();
    moment.gaze.fits(layout)
        && moment.gaze.attended().minus(IndexSet::first(layout.slots())).is_empty()
        && moment.full.len() == layout.width()
        && moment.action < student.actions()
        && moment.after.iter().all(|after| after.len() == layout.readings_of(&moment.full).len())
}
