//! Takes the image of a moment, with the objects in it.

use bevy::math::{Vec2, Vec3};

use super::looks::{ImageLooks, MatchLooks};
use super::moments::Moment;
use super::staging::{Object, Surroundings, staged};
use super::texture::Texture;
use naoisis_core::camera_model::{CameraIntrinsics, Distortion};
use naoisis_core::random::RandomStream;
use naoisis_sensing::appearance::view::View;
use naoisis_sensing::sensing::camera::image::Image;
use naoisis_sensing::sensing::camera::lens::Lens;
use naoisis_sensing::sensing::camera::noise::ImageNoise;
use naoisis_sensing::sensing::camera::software::stage_camera::StageCamera;

/// Samples along each side of a pixel. The number is odd, because the middle sample decides which object the pixel shows.
const SUPERSAMPLING: u32 = 3;

/// An image, and the objects in it.
pub struct Shot {
    /// The image. Its labels are the numbers of objects.
    pub image: Image,
    /// The objects of the scene.
    pub objects: Vec<Object>,
    /// The share of each object's area in the image that nothing hides. `None` for objects that are not in the image.
    pub visible: Vec<Option<f32>>,
    /// The view from the camera, without the distortion of its lens.
    pub view: View,
    /// The camera with its distortion.
    pub intrinsics: CameraIntrinsics,
}

impl Shot {
    /// Returns the pixel of a point, inside the image or not. Returns `None` if the point is behind the camera.
    pub fn pixel(&self, point: Vec3) -> Option<Vec2> {
        let in_camera = self.view.to_camera(point);
        (in_camera.z > 0.02).then(|| self.intrinsics.pixel(in_camera.truncate() / in_camera.z))
    }

    /// Returns the number of the object or of the ground at a pixel. Returns `None` outside the image.
    pub fn number_at(&self, pixel: Vec2) -> Option<u8> {
        let size = Vec2::new(self.image.width as f32, self.image.height as f32);
        let is_inside = pixel.cmpge(Vec2::ZERO).all() && pixel.cmplt(size).all();
        is_inside.then(|| self.image.labels[pixel.y as usize * self.image.width as usize + pixel.x as usize])
    }
}

/// The setting of a match, the same for all its moments.
pub struct MatchSetting {
    /// Its looks.
    pub looks: MatchLooks,
    /// What is beside the pitch.
    pub surroundings: Surroundings,
    /// The textures.
    pub texture: Texture,
}

/// Takes the image of a moment. Returns `None` if its robot or camera is missing.
pub fn take(
    camera: &mut StageCamera,
    moment: &Moment,
    setting: &MatchSetting,
    looks: &ImageLooks,
    stream: &mut RandomStream,
) -> Option<Shot> {
    let robot = moment.scene.robot(moment.robot)?;
    let mut camera_view = moment.settings.view(moment.camera, &robot.body, robot.head)?;
    camera_view.intrinsics = with_distortion(camera_view.intrinsics, setting.looks.distortion);
    let intrinsics = camera_view.intrinsics;
    let view = View {
        supersampling: SUPERSAMPLING,
        shadows: true,
        ..View::of_robot(&camera_view, robot.world_from_robot(), robot.id)
    };
    let (stage, objects) = staged(moment, &setting.looks, &setting.surroundings, stream);
    camera.set(&stage);
    let mut image = Image::default();
    camera.draw(&view, &mut image);
    let mut counts = [0_usize; 256];
    for number in &image.labels {
        counts[usize::from(*number)] += 1;
    }
    let whole = camera.silhouettes(&view);
    let share = |(object, whole): (&Object, &usize)| {
        let count = counts[usize::from(object.number)];
        // The samples of a silhouette differ slightly from those of the picture.
        (count > 0).then(|| (count as f32 / (*whole).max(1) as f32).min(1.0))
    };
    let visible = objects.iter().zip(&whole).map(share).collect();
    let gains = setting.looks.white_balance.map(|gain| gain * looks.exposure);
    setting.texture.paint(&mut image, &view, &setting.looks, gains);
    let lens = Lens { vignetting: setting.looks.vignetting, exposure_s: looks.exposure_s, ..Lens::default() };
    let noise = ImageNoise { pixel_sd: looks.pixel_sd, blur_px: looks.blur_px, ..ImageNoise::default() };
    camera.develop(&mut image, &lens, intrinsics, moment.turn, &noise, stream);
    Some(Shot { image, objects, visible, view, intrinsics })
}

/// Adds a lens distortion to a camera without a known one. `corners` is the displacement of the image corners, as a share of their distance
/// from the middle.
fn with_distortion(intrinsics: CameraIntrinsics, corners: f32) -> CameraIntrinsics {
    if !intrinsics.distortion.is_none() || corners == 0.0 {
        return intrinsics;
    }
    let slope = intrinsics.centre / intrinsics.focal;
    intrinsics.with_distortion(Distortion::new([corners / slope.length_squared(), 0.0, 0.0], [0.0; 2]))
}
