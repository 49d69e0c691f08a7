//! Draws on images: lines, areas, words and other images.

use ab_glyph::{Font, FontRef, PxScale, ScaleFont};
use bevy::math::Vec2;
use resize::{Pixel, Type};
use rgb::FromSlice;
use std::sync::LazyLock;
use tiny_skia::{FillRule, LineCap, Paint, PathBuilder, Pixmap, Stroke, StrokeDash, Transform};

use naoisis_sensing::appearance::colours::Colour;
use naoisis_sensing::sensing::camera::image::Image;

/// Black ink.
pub const INK: Colour = Colour([32, 34, 38]);
/// Grey ink, for secondary content.
pub const GREY: Colour = Colour([130, 134, 140]);
/// Paper.
pub const PAPER: Colour = Colour([255, 255, 255]);

/// The font of all words; `None` if it cannot be read.
static FONT: LazyLock<Option<FontRef<'static>>> =
    LazyLock::new(|| FontRef::try_from_slice(epaint_default_fonts::UBUNTU_LIGHT).ok());

/// Position of words relative to their place.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Anchor {
    /// The words begin at the place.
    Left,
    /// The words are centred at the place.
    Middle,
    /// The words end at the place.
    Right,
}

/// An image that is being drawn. Places are points from the top left corner: pixels, unless the canvas is [scaled](Canvas::scaled).
pub struct Canvas {
    pixmap: Pixmap,
    /// Pixels in a point.
    scale: f32,
}

impl Canvas {
    /// Creates a canvas of one colour with a size in pixels, at least one in each direction.
    pub fn new([width, height]: [u32; 2], colour: Colour) -> Canvas {
        let [width, height] = [width.clamp(1, MOST_PIXELS), height.clamp(1, MOST_PIXELS)];
        let Some(mut pixmap) = Pixmap::new(width, height) else { unreachable!("sizes are positive and small") };
        pixmap.fill(skia(colour, 1.0));
        Canvas { pixmap, scale: 1.0 }
    }

    /// Creates a canvas of one colour with a size in points. A point is `scale` pixels wide and high, so that the same drawing can have any
    /// size.
    pub fn scaled(size: Vec2, scale: f32, colour: Colour) -> Canvas {
        let [width, height] = (size * scale).round().to_array();
        Canvas { scale, ..Canvas::new([width as u32, height as u32], colour) }
    }

    /// Returns the number of pixels in a point.
    pub fn scale(&self) -> f32 {
        self.scale
    }

    /// Returns the width and height, pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.pixmap.width(), self.pixmap.height()]
    }

    /// Returns the finished image.
    pub fn into_image(self) -> Image {
        self.image()
    }

    /// Returns the image as drawn so far.
    pub fn image(&self) -> Image {
        let [width, height] = self.size();
        let pixels = self.pixmap.data().as_chunks::<4>().0;
        let mut rgb = vec![0; 3 * pixels.len()];
        for (rgb, [red, green, blue, _]) in rgb.as_chunks_mut::<3>().0.iter_mut().zip(pixels) {
            *rgb = [*red, *green, *blue];
        }
        Image { width, height, rgb, ..Image::default() }
    }

    /// Draws an image with its top left corner at `at`, enlarged by the factor `scale`.
    pub fn picture(&mut self, image: &Image, at: Vec2, scale: f32) {
        let times = scale * self.scale;
        let size = [image.width, image.height].map(|side| (side as f32 * times).round() as u32);
        if times >= 1.0 && times.fract() == 0.0 {
            self.squares(image, at, times as usize);
        } else if let Some(resized) = resized(image, size) {
            self.pixels(&resized, at);
        }
    }

    /// Draws an image with its top left corner at `at`, pixel by pixel.
    pub fn pixels(&mut self, image: &Image, at: Vec2) {
        self.squares(image, at, 1);
    }

    /// Draws an image with its top left corner at `at`, each pixel as a square of `side` pixels.
    fn squares(&mut self, image: &Image, at: Vec2, side: usize) {
        let [left, top] = (at * self.scale).round().to_array().map(|pixel| pixel as i64);
        let [width, height] = self.size().map(i64::from);
        let columns = i64::from(image.width) * side as i64;
        // The part of each row that is on the canvas.
        let from = (-left).clamp(0, columns);
        let to = (width - left).clamp(from, columns);
        if from == to {
            return;
        }
        let mut widened = vec![[0; 3]; columns as usize];
        for (index, colours) in image.rgb.chunks_exact(3 * image.width as usize).enumerate() {
            for (square, colour) in widened.chunks_exact_mut(side).zip(colours.as_chunks::<3>().0) {
                square.fill(*colour);
            }
            let first = top + (index * side) as i64;
            for row in (first..first + side as i64).filter(|row| (0..height).contains(row)) {
                self.put_row(row as usize, (left + from) as usize, &widened[from as usize..to as usize]);
            }
        }
    }

    /// Copies colours into a row of pixels, starting at a column. All of them must be on the canvas.
    fn put_row(&mut self, row: usize, column: usize, colours: &[[u8; 3]]) {
        let first = 4 * (row * self.pixmap.width() as usize + column);
        let pixels = self.pixmap.data_mut()[first..].as_chunks_mut::<4>().0;
        for (pixel, [red, green, blue]) in pixels.iter_mut().zip(colours) {
            *pixel = [*red, *green, *blue, u8::MAX];
        }
    }

    /// Draws a line through `places`.
    pub fn line(&mut self, places: &[Vec2], colour: Colour, width: f32) {
        self.stroke(places, colour, width, None, false);
    }

    /// Draws a dashed line through `places`.
    pub fn dashes(&mut self, places: &[Vec2], colour: Colour, width: f32) {
        self.stroke(places, colour, width, StrokeDash::new(vec![5.0 * width, 4.0 * width], 0.0), false);
    }

    /// Draws the outline of an area.
    pub fn outline(&mut self, places: &[Vec2], colour: Colour, width: f32) {
        self.stroke(places, colour, width, None, true);
    }

    fn stroke(&mut self, places: &[Vec2], colour: Colour, width: f32, dash: Option<StrokeDash>, close: bool) {
        let Some(path) = path(places, close) else { return };
        let stroke = Stroke { width, line_cap: LineCap::Round, dash, ..Stroke::default() };
        self.pixmap.stroke_path(&path, &paint(colour, 1.0), &stroke, self.transform(), None);
    }

    /// Fills an area with an opacity from 0 to 1.
    pub fn fill(&mut self, places: &[Vec2], colour: Colour, cover: f32) {
        let Some(path) = path(places, true) else { return };
        self.pixmap.fill_path(&path, &paint(colour, cover), FillRule::Winding, self.transform(), None);
    }

    fn transform(&self) -> Transform {
        Transform::from_scale(self.scale, self.scale)
    }

    /// Fills a rectangle by its top left corner and its size.
    pub fn rectangle(&mut self, at: Vec2, size: Vec2, colour: Colour, cover: f32) {
        self.fill(&[at, at + Vec2::X * size.x, at + size, at + Vec2::Y * size.y], colour, cover);
    }

    /// Fills a disc.
    pub fn disc(&mut self, centre: Vec2, radius: f32, colour: Colour, cover: f32) {
        self.fill(&ellipse(centre, Vec2::X * radius, Vec2::Y * radius), colour, cover);
    }

    /// Draws a line with an arrow head at its end.
    pub fn arrow(&mut self, from: Vec2, to: Vec2, colour: Colour, width: f32) {
        let [tip, left, right] = arrow_head(from, to, width);
        self.line(&[from, (tip + (left + right) / 2.0) / 2.0], colour, width);
        self.fill(&[tip, left, right], colour, 1.0);
    }

    /// Writes words of a height, with their base line at a place.
    pub fn words(&mut self, words: &str, at: Vec2, height: f32, anchor: Anchor, colour: Colour) {
        let at = at * self.scale;
        self.write(words, height, anchor, colour, |along, down| at + Vec2::new(along, down));
    }

    /// Writes words from bottom to top, with their base line at a place.
    pub fn words_upwards(&mut self, words: &str, at: Vec2, height: f32, anchor: Anchor, colour: Colour) {
        let at = (at * self.scale).round();
        self.write(words, height, anchor, colour, |along, down| at + Vec2::new(down, -along));
    }

    /// Writes words. `place` returns the pixel at a distance along the words and a distance below their base line, pixels.
    fn write(&mut self, words: &str, height: f32, anchor: Anchor, colour: Colour, place: impl Fn(f32, f32) -> Vec2) {
        let Some(font) = FONT.as_ref() else { return };
        let height = height * self.scale;
        let font = font.as_scaled(PxScale::from(height));
        let start = match anchor {
            Anchor::Left => 0.0,
            Anchor::Middle => -width_of_words(words, height) / 2.0,
            Anchor::Right => -width_of_words(words, height),
        };
        // Letters may be at fractions of a pixel, but the pixels of a letter are whole ones.
        let origin = place(0.0, 0.0);
        let fraction = if place(1.0, 0.0).x > origin.x { origin.fract() } else { Vec2::ZERO };
        let mut pen = start;
        let [size_x, size_y] = self.size();
        let pixels = self.pixmap.data_mut();
        for letter in words.chars() {
            let glyph = font.scaled_glyph(letter);
            let advance = font.h_advance(glyph.id);
            let position = ab_glyph::point(pen + fraction.x, fraction.y);
            if let Some(outline) = font.outline_glyph(ab_glyph::Glyph { position, ..glyph }) {
                let corner = outline.px_bounds().min;
                outline.draw(|x, y, cover| {
                    let pixel = place(corner.x + x as f32 - fraction.x, corner.y + y as f32 - fraction.y).round();
                    if pixel.x < 0.0 || pixel.y < 0.0 || pixel.x >= size_x as f32 || pixel.y >= size_y as f32 {
                        return;
                    }
                    let first = 4 * (pixel.y as usize * size_x as usize + pixel.x as usize);
                    for (channel, ink) in pixels[first..first + 3].iter_mut().zip(colour.0) {
                        let mixed =
                            f32::from(*channel) + (f32::from(ink) - f32::from(*channel)) * cover.clamp(0.0, 1.0);
                        *channel = mixed.round() as u8;
                    }
                });
            }
            pen += advance;
        }
    }
}

/// Returns the tip and the corners of the head of an arrow with a line of `width`.
pub fn arrow_head(from: Vec2, to: Vec2, width: f32) -> [Vec2; 3] {
    let along = 5.6 * width * (to - from).normalize_or(Vec2::X);
    let side = 0.44 * along.perp();
    [to, to - along + side, to - along - side]
}

/// Returns the width of words of a height.
pub fn width_of_words(words: &str, height: f32) -> f32 {
    let Some(font) = FONT.as_ref() else { return 0.0 };
    let font = font.as_scaled(PxScale::from(height));
    words.chars().map(|letter| font.h_advance(font.glyph_id(letter))).sum()
}

/// Returns words of a height, cut and with an ellipsis if they are wider than `widest`.
pub fn shortened(words: &str, height: f32, widest: f32) -> String {
    let mut short = words.to_owned();
    while width_of_words(&short, height) > widest && short.pop().is_some() {}
    if short.len() < words.len() {
        short.pop();
        short.push('…');
    }
    short
}

/// Returns the corners of an ellipse from its centre and its half axes.
pub fn ellipse(centre: Vec2, one: Vec2, other: Vec2) -> Vec<Vec2> {
    const CORNERS: usize = 72;
    let at = |corner: usize| Vec2::from_angle(core::f32::consts::TAU * corner as f32 / CORNERS as f32);
    (0..CORNERS).map(|corner| centre + at(corner).x * one + at(corner).y * other).collect()
}

/// Greatest width and height of a canvas, pixels.
const MOST_PIXELS: u32 = 16_384;

/// Returns an image resized to a size in pixels, with the cubic filter of Mitchell and Netravali; `None` if a side is zero or larger than
/// any canvas.
fn resized(image: &Image, [width, height]: [u32; 2]) -> Option<Image> {
    if width.max(height) > MOST_PIXELS {
        return None;
    }
    let mut rgb = vec![0_u8; width as usize * height as usize * 3];
    let sides = [image.width, image.height, width, height].map(|side| side as usize);
    let [from_width, from_height, to_width, to_height] = sides;
    let mut resizer = resize::new(from_width, from_height, to_width, to_height, Pixel::RGB8, Type::Mitchell).ok()?;
    resizer.resize(image.rgb.as_rgb(), rgb.as_mut_slice().as_rgb_mut()).ok()?;
    Some(Image { width, height, rgb, ..Image::default() })
}

fn skia(Colour([red, green, blue]): Colour, cover: f32) -> tiny_skia::Color {
    tiny_skia::Color::from_rgba8(red, green, blue, (cover.clamp(0.0, 1.0) * 255.0).round() as u8)
}

fn paint(colour: Colour, cover: f32) -> Paint<'static> {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color(skia(colour, cover));
    paint
}

fn path(places: &[Vec2], close: bool) -> Option<tiny_skia::Path> {
    let (first, rest) = places.split_first()?;
    let mut path = PathBuilder::new();
    path.move_to(first.x, first.y);
    rest.iter().for_each(|place| path.line_to(place.x, place.y));
    if close {
        path.close();
    }
    path.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ink(image: &Image) -> usize {
        image.rgb.chunks_exact(3).filter(|pixel| *pixel != PAPER.0).count()
    }

    #[test]
    fn areas_are_as_large_as_they_should_be() {
        let mut canvas = Canvas::new([100, 80], PAPER);
        canvas.rectangle(Vec2::new(10.0, 20.0), Vec2::new(30.0, 10.0), INK, 1.0);
        let image = canvas.into_image();
        assert_eq!(ink(&image), 300);
        assert_eq!(image.colour(10, 20), Some(INK.0));
        assert_eq!(image.colour(9, 20), Some(PAPER.0));
    }

    #[test]
    fn words_stand_where_they_are_anchored() {
        let columns = |anchor| {
            let mut canvas = Canvas::new([200, 40], PAPER);
            canvas.words("Goal", Vec2::new(100.0, 30.0), 20.0, anchor, INK);
            let image = canvas.into_image();
            let inked = (0..200).filter(|&u| (0..40).any(|v| image.colour(u, v) != Some(PAPER.0)));
            let inked: Vec<u32> = inked.collect();
            [inked[0], inked[inked.len() - 1]]
        };
        assert!(columns(Anchor::Left)[0] >= 100);
        assert!(columns(Anchor::Right)[1] <= 100);
        let [first, last] = columns(Anchor::Middle);
        assert!(first.abs_diff(200 - last) <= 3, "{first} {last}");
    }

    #[test]
    fn words_upwards_are_the_same_turned_to_the_left() {
        let drawn = |upwards| {
            let mut canvas = Canvas::new([100, 100], PAPER);
            let draw = if upwards { Canvas::words_upwards } else { Canvas::words };
            draw(&mut canvas, "Goal", Vec2::splat(50.0), 20.0, Anchor::Middle, INK);
            canvas.into_image()
        };
        let [flat, upwards] = [false, true].map(drawn);
        assert!(ink(&flat) > 100);
        for (along, down) in (-40..40).flat_map(|along| (-30..30).map(move |down| (along, down))) {
            let [one, other] = [(50 + along, 50 + down), (50 + down, 50 - along)].map(|(u, v)| (u as u32, v as u32));
            assert_eq!(flat.colour(one.0, one.1), upwards.colour(other.0, other.1), "{along} {down}");
        }
    }

    #[test]
    fn a_scaled_canvas_has_the_same_drawing_in_another_size() {
        let mut canvas = Canvas::scaled(Vec2::new(50.0, 40.0), 2.0, PAPER);
        canvas.rectangle(Vec2::new(5.0, 10.0), Vec2::new(15.0, 5.0), INK, 1.0);
        canvas.pixels(&Image { width: 1, height: 1, rgb: vec![255, 0, 0], ..Image::default() }, Vec2::new(40.0, 30.0));
        let image = canvas.into_image();
        assert_eq!([image.width, image.height], [100, 80]);
        assert_eq!(ink(&image), 301);
        assert_eq!(image.colour(80, 60), Some([255, 0, 0]));
    }

    #[test]
    fn a_picture_is_put_as_it_is_or_scaled() {
        let image = Image { width: 2, height: 1, rgb: vec![255, 0, 0, 0, 0, 255], ..Image::default() };
        let mut canvas = Canvas::new([20, 20], PAPER);
        canvas.picture(&image, Vec2::new(3.0, 4.0), 1.0);
        canvas.picture(&image, Vec2::new(10.0, 10.0), 4.0);
        let drawn = canvas.image();
        assert_eq!([drawn.colour(3, 4), drawn.colour(4, 4)], [Some([255, 0, 0]), Some([0, 0, 255])]);
        assert_eq!([drawn.colour(2, 4), drawn.colour(5, 4)], [Some(PAPER.0); 2]);
        for (u, v, colour) in
            [(10, 10, [255, 0, 0]), (13, 13, [255, 0, 0]), (14, 10, [0, 0, 255]), (17, 13, [0, 0, 255])]
        {
            assert_eq!(drawn.colour(u, v), Some(colour), "{u} {v}");
        }
        canvas.picture(&image, Vec2::ZERO, 2.5);
        let drawn = canvas.into_image();
        assert!(drawn.colour(0, 0).unwrap()[0] > 200 && drawn.colour(4, 1).unwrap()[2] > 200);
    }

    #[test]
    fn what_is_beyond_the_edges_is_left_out() {
        let image = Image { width: 8, height: 6, rgb: vec![77; 3 * 8 * 6], ..Image::default() };
        for (at, drawn) in [([-6.0, 26.0], 10 * 4), ([35.0, -2.0], 5 * 10), ([41.0, 0.0], 0), ([0.0, -13.0], 0)] {
            let mut canvas = Canvas::new([40, 30], PAPER);
            canvas.picture(&image, at.into(), 2.0);
            let even = canvas.into_image().rgb.chunks_exact(3).filter(|pixel| *pixel == [77; 3]).count();
            assert_eq!(even, drawn, "{at:?}");
        }
    }
}
