//! Fig. 6: the road from above, the robot's view at the same moment, and the camera's regions.

use super::picture;
use crate::results::{CameraRegion, RoadView};
use crate::train::RunError;
use metal_rl::environment::Environment;
use metal_worlds::highway::camera::{Region, Window};
use metal_worlds::highway::{Class, Highway};

/// Red pixels from which on a car is plainly in the picture.
const PLAIN: usize = 60;
/// Starts among which a telling one is looked for.
const STARTS: u64 = 300;

/// The first start of the mix at which two red cars are on the road and one of them is plainly seen; the last start
/// tried if there is none.
pub fn draw(world: &mut Highway) -> Result<RoadView, RunError> {
    for seed in 0..STARTS {
        world.reset(seed)?;
        let red = world.class_image().iter().filter(|&&class| class == Class::Red).count();
        if world.cars().len() > 1 && red >= PLAIN {
            break;
        }
    }
    Ok(RoadView {
        road: picture::outline(world.road()),
        image: picture::image(world),
        learner: picture::pose(&world.learner()),
        cars: world.cars().iter().map(picture::pose).collect(),
    })
}

/// The six regions, each seen by one tiny agent.
pub fn regions() -> Vec<CameraRegion> {
    let named = |region: &Region| {
        let Window { top, bottom, left, right } = region.window();
        CameraRegion { name: region.name().to_owned(), top, bottom, left, right }
    };
    Region::ALL.iter().map(named).collect()
}
