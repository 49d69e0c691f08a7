//! Areas that float over the match: where they are, so that none covers another.

use bevy_egui::egui::{Align, Align2, Context, Id, Rect, Vec2};

use super::layout::{free_area, shown_at};
use super::theme::MARGIN;

/// The least distance between two areas, logical pixels.
const GAP: f32 = 6.0;

/// Returns the place of a floating area at an edge or in a corner of the free area, moved away from that edge until it covers none of the
/// `others` that were shown in the last frame. It has the size of the last frame.
pub fn place_beside(context: &Context, name: &str, align: Align2, others: &[&str]) -> Rect {
    let size = context.memory(|memory| memory.area_rect(Id::new(name))).map_or(Vec2::ZERO, |area| area.size());
    let edge = align.pos_in_rect(&free_area(context).shrink(MARGIN));
    let others: Vec<Rect> = others.iter().filter_map(|other| shown_at(context, other)).collect();
    moved_clear(align.anchor_size(edge, size), &others, align.y() != Align::Max)
}

/// Returns an area moved down, or else up, until it covers none of the others.
pub fn moved_clear(area: Rect, others: &[Rect], is_down: bool) -> Rect {
    let mut others = others.to_vec();
    others.sort_by(|one, other| one.min.y.total_cmp(&other.min.y));
    if !is_down {
        others.reverse();
    }
    others.iter().fold(area, |area, other| {
        if !area.intersects(other.expand(GAP - 1.0)) {
            return area;
        }
        let way = if is_down { other.max.y + GAP - area.min.y } else { other.min.y - GAP - area.max.y };
        area.translate(Vec2::new(0.0, way))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_egui::egui::{Area, Pos2, RawInput, Ui, vec2};

    fn area(x: f32, y: f32) -> Rect {
        Rect::from_min_size(Pos2::new(x, y), vec2(100.0, 20.0))
    }

    #[test]
    fn an_area_is_moved_past_all_others_in_its_way_and_stays_where_it_covers_none() {
        let legend = area(0.0, 10.0);
        assert_eq!(moved_clear(area(50.0, 15.0), &[legend], true), area(50.0, 36.0));
        assert_eq!(moved_clear(area(50.0, 15.0), &[legend], false), area(50.0, -16.0));
        assert_eq!(moved_clear(area(150.0, 15.0), &[legend], true), area(150.0, 15.0));
        // Below the first one is another.
        assert_eq!(moved_clear(area(50.0, 15.0), &[area(20.0, 40.0), legend], true), area(50.0, 66.0));
    }

    #[test]
    fn an_area_that_is_no_longer_shown_is_in_nobodys_way() {
        let context = Context::default();
        let mut frame = |is_shown: bool| {
            let screen_rect = Some(Rect::from_min_size(Pos2::ZERO, vec2(400.0, 300.0)));
            let mut place = Rect::NOTHING;
            let mut output = context.run_ui(RawInput { screen_rect, ..RawInput::default() }, |ui: &mut Ui| {
                place = place_beside(ui.ctx(), "notice", Align2::LEFT_TOP, &["legend"]);
                if is_shown {
                    let legend = Area::new(Id::new("legend")).fixed_pos(Pos2::new(10.0, 10.0));
                    legend.show(ui.ctx(), |ui| ui.allocate_space(vec2(100.0, 40.0)));
                }
            });
            output.textures_delta.clear();
            place.min.y
        };
        let tops: Vec<f32> = [true, true, true, false, false, false].map(&mut frame).into_iter().collect();
        assert!(tops[2] >= 50.0 + GAP && tops[5] == MARGIN, "{tops:?}");
    }
}
