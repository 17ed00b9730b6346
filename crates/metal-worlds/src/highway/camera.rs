//! The robot's colour camera: true perspective onto the plane and the cars, one region at a time.
//!
//! 52×39 pixels, 0.84 rad across, 28 mm above the road and 30 mm ahead of the body's centre, as on an E-puck. The
//! camera looks [`PITCH_RAD`] down, so that the horizon lies just above the top row: every pixel shows ground or a car (reading R39).
//! The picture is cut into three columns of 17, 18 and 17 pixels, and into far rows (the upper 13: from 0.13 m
//! ahead of the lens to the horizon) and near rows (the lower 26: from 0.04 m to 0.13 m).

use super::blocks::{BLOCK, Blocks, Found, look_at_blocks};
use super::ground::{Ground, Material};
use super::kinematics::{BODY_HEIGHT_M, BODY_RADIUS_M};
use super::pose::Pose;
use super::sight::{Lens, Ray, Rays, Visible, count_classes, put_before};
use metal_rl::num;

/// Pixels in a row of the picture.
pub const COLUMNS: usize = 52;
/// Rows of the picture.
pub const ROWS: usize = 39;
/// Angle of view across, in radians (E-puck).
pub const FIELD_OF_VIEW_RAD: f64 = 0.84;
/// Height of the lens above the road, in metres (E-puck).
pub const HEIGHT_M: f64 = 0.028;
/// Distance of the lens ahead of the body's centre, in metres (E-puck).
pub const AHEAD_M: f64 = 0.03;
/// How far down the camera looks, in radians.
pub const PITCH_RAD: f64 = 0.32;

// No ray rises (see the pitch), so a ray that meets a body's outline meets its side, never passes over its top.
const _: () = assert!(HEIGHT_M < BODY_HEIGHT_M);

/// A spatial area of the picture (Fig. 6c), in the order of the sensors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Region {
    /// Middle, near.
    MiddleNear,
    /// Left, near.
    LeftNear,
    /// Right, near.
    RightNear,
    /// Middle, far.
    MiddleFar,
    /// Left, far.
    LeftFar,
    /// Right, far.
    RightFar,
}

impl Region {
    /// All regions in the order of the sensors.
    pub const ALL: [Self; 6] =
        [Self::MiddleNear, Self::LeftNear, Self::RightNear, Self::MiddleFar, Self::LeftFar, Self::RightFar];

    /// The paper's short name (Sec. 4.2).
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::MiddleNear => "MN",
            Self::LeftNear => "LN",
            Self::RightNear => "RN",
            Self::MiddleFar => "MF",
            Self::LeftFar => "LF",
            Self::RightFar => "RF",
        }
    }

    /// The region's pixels.
    #[must_use]
    pub fn window(self) -> Window {
        let (left, right) = match self {
            Self::LeftNear | Self::LeftFar => (0, 17),
            Self::MiddleNear | Self::MiddleFar => (17, 35),
            Self::RightNear | Self::RightFar => (35, COLUMNS),
        };
        let (top, bottom) = match self {
            Self::MiddleFar | Self::LeftFar | Self::RightFar => (0, 13),
            Self::MiddleNear | Self::LeftNear | Self::RightNear => (13, ROWS),
        };
        Window { top, bottom, left, right }
    }
}

/// A rectangle of pixels: rows `top`..`bottom`, columns `left`..`right`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// First row.
    pub top: usize,
    /// Row after the last.
    pub bottom: usize,
    /// First column.
    pub left: usize,
    /// Column after the last.
    pub right: usize,
}

impl Window {
    /// The whole picture.
    pub const WHOLE: Self = Self { top: 0, bottom: ROWS, left: 0, right: COLUMNS };

    /// Number of pixels.
    #[must_use]
    pub fn pixels(&self) -> usize {
        (self.bottom - self.top) * (self.right - self.left)
    }

    /// The window and one pixel around it, inside the picture.
    #[must_use]
    pub fn widened(&self) -> Self {
        Self {
            top: self.top.saturating_sub(1),
            bottom: (self.bottom + 1).min(ROWS),
            left: self.left.saturating_sub(1),
            right: (self.right + 1).min(COLUMNS),
        }
    }
}

/// A body that hides what is behind it: an upright cylinder of [`BODY_RADIUS_M`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obstacle {
    /// Centre of the body, in metres.
    pub x_m: f64,
    /// Centre of the body, in metres.
    pub y_m: f64,
    /// What it looks like.
    pub material: Material,
}

/// What there is to see, and from where.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// The plane.
    pub ground: &'a Ground,
    /// The body that carries the camera.
    pub eye: Pose,
    /// All other bodies.
    pub obstacles: &'a [Obstacle],
}

/// The camera's geometry, computed once.
#[derive(Clone, Debug)]
pub struct Camera {
    /// All pixels, row by row.
    picture: Vec<Ray>,
    whole: Rays,
    regions: [Patch; 6],
}

/// Pixels of the largest window that can be counted: the middle near region.
pub const LARGEST_PATCH: usize = 18 * 26;

/// A window of the picture whose colours are counted again and again.
#[derive(Clone, Debug)]
pub struct Patch {
    window: Window,
    blocks: Blocks,
    wedge: Wedge,
}

/// Most bodies in a scene besides the one that looks.
const MAX_OBSTACLES: usize = 3;

/// The plane between the outermost rays of a window.
#[derive(Clone, Copy, Debug)]
struct Wedge {
    corners: [Ray; 4],
    /// How far any of its rays reaches, and half a body, in metres.
    reach_m: f64,
}

/// Where the lens is on the plane, in metres, and where it points.
struct Frame {
    x_m: f64,
    y_m: f64,
    sin: f64,
    cos: f64,
}

/// What there is to see as the lens has it: all other bodies, nearest first.
struct Eye {
    lens: Lens,
    bodies: [Visible; MAX_OBSTACLES],
    count: usize,
}

impl Default for Camera {
    fn default() -> Self {
        Self::new()
    }
}

impl Camera {
    /// The E-puck's camera, pitched by [`PITCH_RAD`].
    #[must_use]
    pub fn new() -> Self {
        let picture: Vec<Ray> = (0..ROWS * COLUMNS).map(|i| ray(i / COLUMNS, i % COLUMNS)).collect();
        Self {
            whole: picture.iter().copied().collect(),
            regions: Region::ALL.map(|region| Patch::of(&picture, region.window())),
            picture,
        }
    }

    /// The pixels of `window`, made ready to be counted with [`Self::count_patch`].
    ///
    /// # Panics
    /// If it has more than [`LARGEST_PATCH`] pixels.
    #[must_use]
    pub fn patch(&self, window: Window) -> Patch {
        assert!(window.pixels() <= LARGEST_PATCH, "at most {LARGEST_PATCH} pixels, not {}", window.pixels());
        Patch::of(&self.picture, window)
    }

    /// Where the ray of a pixel meets the ground, in metres ahead of and to the left of the body's centre.
    #[must_use]
    pub fn ground_point_m(&self, row: usize, column: usize) -> [f64; 2] {
        let ray = &self.picture[row * COLUMNS + column];
        [AHEAD_M + ray.direction[0] * ray.reach_m, ray.direction[1] * ray.reach_m]
    }

    /// Paints the pixels of `window`, row by row: `paint` gets the pixel's index in the whole picture and what it shows.
    pub fn render(&self, scene: &Scene, window: Window, mut paint: impl FnMut(usize, Material)) {
        let (eye, wedge) = (Eye::of(scene), Wedge::of(&self.picture, window));
        let mut shown = [Material::Grass; COLUMNS];
        for row in window.top..window.bottom {
            let start = row * COLUMNS;
            self.whole.look(start, &eye.lens, scene.ground.raster(), &mut shown);
            for body in eye.farthest_first(&wedge) {
                put_before(&self.whole, start..start + COLUMNS, body, &mut shown);
            }
            (window.left..window.right).for_each(|column| paint(start + column, shown[column]));
        }
    }

    /// How many pixels of a region show each class: what [`Self::render`] paints, counted.
    #[must_use]
    pub fn count(&self, scene: &Scene, region: Region) -> [u32; 4] {
        self.count_patch(scene, &self.regions[region as usize])
    }

    /// The same of any window.
    #[must_use]
    pub fn count_patch(&self, scene: &Scene, patch: &Patch) -> [u32; 4] {
        patch.count_from(&Eye::of(scene), scene.ground)
    }

    /// The bodies of a scene, in their order, that any region may show; surely none shows one that is `None`.
    pub fn bodies_in_sight<'a>(&self, scene: &Scene<'a>) -> impl Iterator<Item = Option<&'a Obstacle>> {
        let frame = Frame::of(&scene.eye);
        scene.obstacles.iter().map(move |body| {
            let visible = frame.see(body);
            self.regions.iter().any(|region| region.wedge.may_show(&visible)).then_some(body)
        })
    }

    /// The same of all regions, in their order.
    #[must_use]
    pub fn count_all(&self, scene: &Scene) -> [[u32; 4]; 6] {
        let eye = Eye::of(scene);
        Region::ALL.map(|region| self.regions[region as usize].count_from(&eye, scene.ground))
    }
}

impl Patch {
    fn of(picture: &[Ray], window: Window) -> Self {
        let (blocks, wedge) = (Blocks::new(picture, COLUMNS, window), Wedge::of(picture, window));
        Self { window, blocks, wedge }
    }

    /// Its pixels.
    #[must_use]
    pub fn window(&self) -> Window {
        self.window
    }

    fn count_from(&self, eye: &Eye, ground: &Ground) -> [u32; 4] {
        let Self { blocks, wedge, .. } = self;
        let mut found = Found::default();
        look_at_blocks(blocks, &eye.lens, ground, &mut found);
        let shown = found.as_flattened_mut();
        for body in eye.farthest_first(wedge) {
            let near_side_m = body.distance2().sqrt() - BODY_RADIUS_M - 1e-6;
            let rays = blocks.reaching(near_side_m) * BLOCK;
            put_before(&blocks.rays, 0..rays, body, &mut shown[..rays]);
        }
        count_classes(&shown[..blocks.pixels])
    }
}

impl Frame {
    fn of(eye: &Pose) -> Self {
        let (sin, cos) = num::sin_cos(eye.heading_rad);
        Self { x_m: eye.x_m + AHEAD_M * cos, y_m: eye.y_m + AHEAD_M * sin, sin, cos }
    }

    fn see(&self, body: &Obstacle) -> Visible {
        let Self { sin, cos, .. } = self;
        let (dx, dy) = (body.x_m - self.x_m, body.y_m - self.y_m);
        let (ahead, left) = (dx * cos + dy * sin, dy * cos - dx * sin);
        Visible { ahead, left, material: body.material }
    }
}

impl Eye {
    fn of(scene: &Scene) -> Self {
        let frame = Frame::of(&scene.eye);
        let [column, row] = scene.ground.cell_of(frame.x_m, frame.y_m);
        let (mut bodies, count) = ([Visible::NONE; MAX_OBSTACLES], scene.obstacles.len());
        for (body, obstacle) in bodies.iter_mut().zip(scene.obstacles) {
            *body = frame.see(obstacle);
        }
        // Equal discs that do not overlap: along any ray the one with the nearer centre comes first.
        bodies[..count].sort_by(|a, b| a.distance2().total_cmp(&b.distance2()));
        Self { lens: Lens { column, row, sin: frame.sin, cos: frame.cos }, bodies, count }
    }

    /// The bodies that some ray of a wedge may meet, so that nearer ones are put before farther ones.
    fn farthest_first(&self, wedge: &Wedge) -> impl Iterator<Item = &Visible> {
        self.bodies[..self.count].iter().rev().filter(|body| wedge.may_show(body))
    }
}

impl Wedge {
    fn of(picture: &[Ray], window: Window) -> Self {
        let (bottom, right) = (window.bottom - 1, window.right - 1);
        let places = [(window.top, window.left), (bottom, window.left), (window.top, right), (bottom, right)];
        let corners = places.map(|(row, column)| picture[row * COLUMNS + column]);
        let reach_m = corners.iter().map(|ray| ray.reach_m).fold(0.0, f64::max) + BODY_RADIUS_M;
        Self { corners, reach_m }
    }

    /// Whether the wedge and the body may meet; cheap, and never wrongly false.
    fn may_show(&self, body: &Visible) -> bool {
        let beside = |ray: &Ray| ray.direction[0] * body.left - ray.direction[1] * body.ahead;
        body.ahead > -BODY_RADIUS_M
            && body.distance2() < self.reach_m * self.reach_m
            && !self.corners.iter().all(|ray| beside(ray) > BODY_RADIUS_M)
            && !self.corners.iter().all(|ray| beside(ray) < -BODY_RADIUS_M)
    }
}

/// The ray through the middle of a pixel.
fn ray(row: usize, column: usize) -> Ray {
    let focal_px = 0.5 * COLUMNS as f64 / num::tan(0.5 * FIELD_OF_VIEW_RAD);
    let up = (0.5 * ROWS as f64 - (row as f64 + 0.5)) / focal_px;
    let left = (0.5 * COLUMNS as f64 - (column as f64 + 0.5)) / focal_px;
    let (sin, cos) = num::sin_cos(PITCH_RAD);
    let (ahead, rise) = (cos + up * sin, up * cos - sin);
    let flat = num::hypot(ahead, left);
    Ray { direction: [ahead / flat, left / flat], reach_m: HEIGHT_M * flat / -rise }
}

#[cfg(test)]
mod tests {
    use super::super::ground::{CELL_M, Class};
    use super::super::road::{Direction, Road};
    use super::super::shape::ShapeRange;
    use super::*;
    use proptest::prelude::*;
    use std::sync::LazyLock;

    static CAMERA: LazyLock<Camera> = LazyLock::new(Camera::new);
    static GROUND: LazyLock<Ground> = LazyLock::new(|| Ground::new(Road::new(1, &ShapeRange::TRAINING)));

    fn picture(eye: Pose, obstacles: &[Obstacle], window: Window) -> Vec<Option<Material>> {
        let mut out = vec![None; ROWS * COLUMNS];
        CAMERA.render(&Scene { ground: &GROUND, eye, obstacles }, window, |i, m| out[i] = Some(m));
        out
    }

    #[test]
    fn rays_meet_the_ground_where_the_projection_says() {
        let camera = Camera::new();
        let focal = 26.0 / num::tan(0.42);
        for (row, column) in [(0, 0), (0, 51), (12, 20), (13, 40), (38, 0), (38, 51)] {
            let [x, y] = camera.ground_point_m(row, column);
            // Back through the pinhole: the point in the camera's own axes, divided by its depth.
            let (sin, cos) = num::sin_cos(PITCH_RAD);
            let depth = (x - AHEAD_M) * cos + HEIGHT_M * sin;
            let up = (x - AHEAD_M) * sin - HEIGHT_M * cos;
            assert!((26.0 - focal * y / depth - (column as f64 + 0.5)).abs() < 1e-9);
            assert!((19.5 - focal * up / depth - (row as f64 + 0.5)).abs() < 1e-9);
        }
        assert!(camera.ground_point_m(0, 26)[0] > 5.0, "the top row is just below the horizon");
        let split = camera.ground_point_m(13, 26)[0];
        assert!((0.14..0.17).contains(&split), "near ends at {split}");
    }

    #[test]
    fn regions_cover_the_picture_once() {
        let mut seen = vec![0; ROWS * COLUMNS];
        for region in Region::ALL {
            let painted = picture(Pose::default(), &[], region.window());
            assert_eq!(painted.iter().flatten().count(), region.window().pixels());
            painted.iter().enumerate().filter(|(_, m)| m.is_some()).for_each(|(i, _)| seen[i] += 1);
        }
        assert!(seen.iter().all(|&n| n == 1));
    }

    #[test]
    fn a_car_ahead_has_the_width_of_its_projection() {
        let focal = 26.0 / num::tan(0.42);
        for distance in [0.15, 0.3, 0.6] {
            let car = Obstacle { x_m: distance, y_m: 0.0, material: Material::RedBody };
            let eye = Pose { x_m: -AHEAD_M, ..Pose::default() };
            let painted = picture(eye, &[car], Window::WHOLE);
            let red = |i: usize| painted[i] == Some(Material::RedBody);
            let widest =
                (0..ROWS).map(|r| (0..COLUMNS).filter(|c| red(r * COLUMNS + c)).count()).max().unwrap();
            let half = BODY_RADIUS_M / (distance * distance - BODY_RADIUS_M * BODY_RADIUS_M).sqrt();
            let expected = 2.0 * focal * half / num::cos(PITCH_RAD);
            assert!((widest as f64 - expected).abs() < 2.0, "{distance}: {widest} against {expected}");
        }
    }

    #[test]
    fn the_nearer_car_hides_the_farther_and_grey_is_black() {
        let near = Obstacle { x_m: 0.15, y_m: 0.0, material: Material::GreyBody };
        let far = Obstacle { x_m: 0.4, y_m: 0.0, material: Material::RedBody };
        for order in [[near, far], [far, near]] {
            let painted = picture(Pose::default(), &order, Window::WHOLE);
            assert!(painted.iter().all(|m| m.unwrap().class() != Class::Red));
            assert!(painted.contains(&Some(Material::GreyBody)));
        }
    }

    proptest! {
        #[test]
        fn hiding_is_that_of_a_ray_marched_in_small_steps(
            row in 0..ROWS, column in 0..COLUMNS, ahead in 0.05..0.8, left in -0.3..0.3,
        ) {
            let ray = ray(row, column);
            let body = Visible { ahead, left, material: Material::RedBody };
            let steps = 20_000;
            let deepest = (0..steps).map(|k| {
                let d = ray.reach_m.min(2.0) * f64::from(k) / f64::from(steps);
                num::hypot(ray.direction[0] * d - ahead, ray.direction[1] * d - left)
            }).fold(f64::INFINITY, f64::min);
            prop_assume!((deepest - BODY_RADIUS_M).abs() > 1e-4);
            prop_assert_eq!(body.hides(&ray), deepest < BODY_RADIUS_M);
        }

        #[test]
        fn the_ground_is_that_of_each_ray_alone(x in -2.0..2.0, y in -2.0..2.0, heading in -3.1..3.1) {
            let eye = Pose { x_m: x, y_m: y, heading_rad: heading };
            let painted = picture(eye, &[], Window::WHOLE);
            let (sin, cos) = num::sin_cos(heading);
            let [column, row] = GROUND.cell_of(x + AHEAD_M * cos, y + AHEAD_M * sin);
            for (i, material) in painted.into_iter().enumerate() {
                let ray = ray(i / COLUMNS, i % COLUMNS);
                let [ahead, left] = ray.direction.map(|d| d * ray.reach_m / CELL_M);
                let at = GROUND.at_cell(column + ahead * cos - left * sin, row + ahead * sin + left * cos);
                prop_assert_eq!(material, Some(at));
            }
        }

        #[test]
        fn what_is_counted_by_blocks_is_what_is_painted(
            arc in 0.0..6.0, offset in -0.5..0.5, heading in -3.1..3.1, ahead in 0.08..0.6, left in -0.2..0.2,
        ) {
            let place = GROUND.road().pose_at(arc, offset, Direction::Along);
            let eye = Pose { heading_rad: heading, ..place };
            let (sin, cos) = num::sin_cos(heading);
            let [x_m, y_m] = [eye.x_m + ahead * cos - left * sin, eye.y_m + ahead * sin + left * cos];
            let car = Obstacle { x_m, y_m, material: Material::RedBody };
            let scene = Scene { ground: &GROUND, eye, obstacles: &[car] };
            for (region, counted) in Region::ALL.into_iter().zip(CAMERA.count_all(&scene)) {
                let mut counts = [0; 4];
                CAMERA.render(&scene, region.window(), |_, material| counts[material.class() as usize] += 1);
                prop_assert_eq!(counted, counts);
            }
        }

        #[test]
        fn a_body_out_of_sight_changes_nothing_and_one_in_a_picture_is_in_sight(
            x in -1.5..1.5, y in -1.0..1.0, heading in -3.1..3.1,
        ) {
            let eye = Pose { heading_rad: heading, ..Pose::default() };
            let car = Obstacle { x_m: x, y_m: y, material: Material::RedBody };
            prop_assume!(num::hypot(x, y) > 2.0 * BODY_RADIUS_M);
            let scene = Scene { ground: &GROUND, eye, obstacles: &[car] };
            let in_sight: Vec<_> = CAMERA.bodies_in_sight(&scene).collect();
            let alone = CAMERA.count_all(&Scene { obstacles: &[], ..scene });
            if in_sight == [None] {
                prop_assert_eq!(CAMERA.count_all(&scene), alone);
            } else {
                prop_assert_eq!(in_sight, [Some(&car)]);
            }
        }

        #[test]
        fn leaving_out_a_body_early_never_changes_the_picture(x in -0.5..0.8, y in -0.5..0.5, heading in -3.1..3.1) {
            let eye = Pose { heading_rad: heading, ..Pose::default() };
            let car = Obstacle { x_m: x, y_m: y, material: Material::RedBody };
            prop_assume!(num::hypot(x, y) > 2.0 * BODY_RADIUS_M);
            let whole = picture(eye, &[car], Window::WHOLE);
            for region in Region::ALL {
                let part = picture(eye, &[car], region.window());
                prop_assert!(part.iter().zip(&whole).all(|(p, w)| p.is_none() || p == w));
                let mut counts = [0; 4];
                part.iter().flatten().for_each(|material| counts[material.class() as usize] += 1);
                prop_assert_eq!(CAMERA.count(&Scene { ground: &GROUND, eye, obstacles: &[car] }, region), counts);
            }
        }
    }
}
