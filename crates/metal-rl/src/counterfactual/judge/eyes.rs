//! Eyes: what the members see of a world, written where the student holds it.

use crate::counterfactual::judge::Pupil;
use crate::counterfactual::student::gaze::Gaze;
use crate::decision::{Content, DecisionDims, DecisionState, Encoding};
use crate::environment::{Environment, EnvironmentError, EnvironmentSpec};
use crate::view::Percept;

/// One moment's looks at a world.
pub(in crate::counterfactual) struct Eyes<'a> {
    pupil: Pupil<'a>,
    encoding: Encoding,
    percept: Percept,
    state: DecisionState,
    block: Vec<f64>,
}

impl<'a> Eyes<'a> {
    pub(in crate::counterfactual) fn new(pupil: Pupil<'a>, spec: &EnvironmentSpec) -> Self {
        let student = pupil.student;
        let inputs = pupil.members.iter().map(|m| m.view.dims()).collect();
        let dims = DecisionDims { member_inputs: inputs, actions: student.actions() };
        Self {
            pupil,
            encoding: Encoding { content: student.config().content, ..Encoding::default() },
            percept: Percept::new(spec, pupil.scaling),
            state: DecisionState::new(&dims),
            block: Vec::new(),
        }
    }

    /// A new moment: nothing is seen yet.
    pub(in crate::counterfactual) fn blink(&mut self) {
        self.percept.clear();
        self.state.clear();
    }

    /// Looks at `slot`, into `gaze`; returns the price of the sensors read just now.
    pub(in crate::counterfactual) fn look(
        &mut self,
        world: &mut dyn Environment,
        slot: usize,
        gaze: &mut Gaze,
    ) -> Result<f64, EnvironmentError> {
        let layout = self.pupil.student.layout();
        let index = self.pupil.roster[slot];
        let member = &self.pupil.members[index];
        self.block.resize(layout.block(slot).len(), 0.0);
        let price = if self.encoding.content == Content::Readings {
            // What the member makes of its reading is not asked for, so it is not computed.
            member.read(world, &mut self.percept, &mut self.block)?
        } else {
            let price = member.consult(index, world, &mut self.percept, &mut self.state)?;
            match self.state.opinion(index) {
                Some(opinion) => self.encoding.write(&opinion, &mut self.block),
                // It was asked and had nothing to say: null, and looked at (reading R109).
                None => self.block.fill(0.0),
            }
            price
        };
        gaze.look(layout, slot, &self.block);
        Ok(price)
    }
}
