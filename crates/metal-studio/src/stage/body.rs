//! A body on the stage: it stands until somebody lets it go, and moves as its driver wants.

use super::{Stage, StageError};
use crate::frame::{Frame, LaneFrame, Source};
use crate::lane::Lane;
use crate::robot::BodyLane;

impl Stage {
    /// The subject's body, if it has one, comes onto the stage and stands.
    pub(super) fn take_in_body(&mut self, driver: usize) -> Result<(), StageError> {
        let Some(robot) = self.subject.robot.take() else { return Ok(()) };
        self.hub.hold_ready(robot.emergency.clone());
        self.body = Some(BodyLane::new(&mut self.subject, driver, robot)?);
        self.clock.run(false);
        self.begin_episode()?;
        self.preview_body()
    }

    /// One decision of the driver, carried out.
    pub(super) fn drive_body(&mut self) -> Result<(), StageError> {
        let Some(body) = &mut self.body else { return Ok(()) };
        let mut frame = body.think()?;
        let at = (body.episode, body.step);
        let outcome = body.act(&mut frame)?;
        self.show_body(frame, at, true);
        if Lane::is_over(&outcome) { self.begin_episode() } else { Ok(()) }
    }

    /// What the driver looks at and would do; the body stands.
    pub(super) fn preview_body(&mut self) -> Result<(), StageError> {
        let Some(body) = &mut self.body else { return Ok(()) };
        let frame = body.think()?;
        let at = (body.episode, body.step);
        self.show_body(frame, at, false);
        Ok(())
    }

    fn show_body(&self, lane: LaneFrame, (episode, step): (usize, usize), done: bool) {
        let secs = if self.clock.is_running() { self.clock.step_secs() } else { super::SINGLE_STEP_SECS };
        let lanes = vec![lane];
        let source = Source::Body;
        self.hub.publish(Frame { n: 0, source, phase: None, episode, step, secs, done, scene: None, lanes });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::Request;
    use crate::hub::Hub;
    use crate::robot::Robot;
    use crate::subject::{Driver, Home, Subject, paper};
    use metal_lab::plan::Acting;
    use metal_robots::arena::{Arena, ArenaConfig, Traffic};
    use metal_robots::bodies::{Epuck2, Webots};
    use metal_robots::link::{Patience, tcp};
    use metal_robots::serve::{Shared, epuck2, look_into, webots};
    use metal_robots::{Body, Emergency, Guard, Limits, RobotConfig, RobotEnvironment};
    use metal_worlds::highway::{HighwayConfig, RgbConfig, RoadSet, Scenario};
    use std::net::TcpListener;
    use std::sync::mpsc::sync_channel;
    use std::sync::{Arc, Mutex};

    fn arena() -> Shared {
        let (grounds, rgb) = (RoadSet::Seeds(vec![1]).build(), RgbConfig::default());
        let config =
            ArenaConfig { grounds, scenario: Scenario::Mix, traffic: Traffic::Standing, rgb, seed: 1 };
        Arc::new(Mutex::new(Arena::new(config)))
    }

    /// A stage whose body is `body`, with or without a supervisor.
    fn stage(name: &str, body: Box<dyn Body>, supervised: bool) -> (Stage, Arc<Hub>) {
        let calibration = metal_robots::Calibration::of(body.infrared_scale());
        let emergency = Emergency::default();
        let guard = Guard::new(body, Limits::default(), emergency.clone()).unwrap();
        let highway = HighwayConfig::new(RoadSet::Seeds(vec![1]), Scenario::Mix);
        let grounds = supervised.then(|| RoadSet::Seeds(vec![1]).build());
        let config = RobotConfig { highway, calibration, grounds };
        let environment = RobotEnvironment::new(guard, config).unwrap();
        let out = std::env::temp_dir().join(format!("metal-studio-{name}-{}", std::process::id()));
        let mut subject = Subject::experiment(paper().unwrap(), &out).unwrap();
        subject.embody(Robot { environment, emergency }).unwrap();
        // The receiver is kept nowhere: pages come in another test.
        let hub = Arc::new(Hub::new(sync_channel(64).0));
        assert!(subject.drivers.iter().all(|driver| !driver.acting.is_watched()), "no expert knows a body");
        (Stage::new(hub.clone(), subject, 1).unwrap(), hub)
    }

    #[test]
    fn a_body_in_webots_is_watched_stepped_and_never_steered() {
        let (world, end) = (arena(), Emergency::default());
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let (shared, button) = (world.clone(), end.clone());
        let server = std::thread::spawn(move || webots::serve(&listener, &shared, &button).unwrap());
        let body = Webots::connect(tcp::opener(address), Patience::default(), Some("learner")).unwrap();
        let (mut stage, hub) = stage("webots", Box::new(body), true);
        assert!(hub.lately(1).is_empty() && !stage.clock.is_running(), "it stands until somebody lets it go");
        let stood = look_into(&world).bodies()[0];
        stage.obey(Request::Step).unwrap();
        let frame = hub.lately(1)[0].clone();
        let lane = &frame.lanes[0];
        assert_eq!((frame.source, frame.done, lane.road), (Source::Body, true, stage.subject.road_count()));
        assert!(lane.from[0].x != lane.to[0].x || lane.from[0].y != lane.to[0].y);
        assert!(look_into(&world).bodies()[0].distance_m(&stood) > 0.001 && lane.link.is_some());
        assert!(stage.obey(Request::Press { action: 0 }).is_err());
        assert!(stage.obey(Request::Place { body: 0, x: 0.0, y: 0.0, heading: None }).is_err());
        assert!(hub.brake() && hub.braked());
        let refused = stage.obey(Request::Step).unwrap_err().to_string();
        assert!(refused.contains("emergency stop"), "{refused}");
        drop(stage);
        end.press();
        server.join().unwrap();
    }

    #[test]
    fn an_epuck2_shows_what_was_looked_at_and_nothing_else() {
        let (world, end) = (arena(), Emergency::default());
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let button = end.clone();
        let server = std::thread::spawn(move || epuck2::serve(&listener, &world, &button).unwrap());
        let body = Epuck2::connect(tcp::opener(address), Patience::default()).unwrap();
        let (mut stage, hub) = stage("epuck2", Box::new(body), false);
        let row = stage.subject.plan.file.policy["fusion"].clone();
        let (roster, home) = (stage.subject.plan.roster(&row.roster), Home::Newborn);
        stage.subject.drivers.push(Driver { label: "all".to_owned(), acting: row.acting, roster, home });
        stage.obey(Request::Watch { driver: stage.subject.drivers.len() - 1 }).unwrap();
        stage.obey(Request::Step).unwrap();
        let lane = hub.lately(1)[0].lanes[0].clone();
        assert!(lane.from.is_empty(), "nobody knows where it is");
        assert!(lane.image.concat().contains(|c| c != '0'), "it looked: {:?}", lane.read);
        assert_eq!((lane.infrared.len(), lane.read.len()), (8, 7), "everybody was asked");
        let expert =
            Driver { label: "expert".to_owned(), acting: Acting::Advisor, roster, home: Home::Newborn };
        stage.subject.drivers.push(expert);
        let watched = stage.subject.drivers.len() - 1;
        let refused = stage.obey(Request::Watch { driver: watched }).unwrap_err().to_string();
        assert!(refused.contains("only in simulation"), "{refused}");
        stage.obey(Request::Step).unwrap();
        drop(stage);
        end.press();
        server.join().unwrap();
    }
}
