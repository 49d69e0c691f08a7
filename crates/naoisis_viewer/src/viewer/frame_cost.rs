//! The cost of a frame: its time, the processor's share, draw calls and passes, and the images of robots' cameras.

use bevy::core_pipeline::core_3d::{AlphaMask3d, Opaque3d, Transparent3d};
use bevy::diagnostic::DiagnosticsStore;
use bevy::pbr::Shadow;
use bevy::prelude::*;
use bevy::render::diagnostic::RenderDiagnosticsPlugin;
use bevy::render::render_phase::{BinnedPhaseItem, SortedPhaseItem, ViewBinnedRenderPhases, ViewSortedRenderPhases};
use bevy::render::renderer::RenderAdapterInfo;
use bevy::render::{Render, RenderApp, RenderSystems};
use bevy_egui::egui::{self, Align2, Grid};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use super::camera_images::ShownImages;
use super::display_settings::DisplaySettings;
use super::floating::place_beside;
use super::layout::{self, LARGE_SCORE, LayoutSystems};
use super::shared::Playback;
use super::theme::{bright, card, dim, text_size};

/// The time over which numbers are averaged, s.
const MEAN_OVER_S: f32 = 0.5;

/// Measures frames, and shows their cost.
pub struct FrameCostPlugin;

impl Plugin for FrameCostPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(RenderDiagnosticsPlugin)
            .init_resource::<FrameCost>()
            .init_resource::<FrameClock>()
            .add_systems(First, begin_frame)
            .add_systems(Last, end_frame)
            .add_systems(
                EguiPrimaryContextPass,
                show_cost.run_if(|display: Res<DisplaySettings>| display.frame_cost).in_set(LayoutSystems::Floating),
            );
        let counts = DrawCounts::default();
        app.insert_resource(counts.clone());
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            render_app
                .insert_resource(counts)
                .add_systems(Render, begin_rendering.before(RenderSystems::ExtractCommands))
                .add_systems(Render, count_draws.in_set(RenderSystems::Render))
                .add_systems(Render, end_rendering.after(RenderSystems::PostCleanup));
        }
    }
}

/// The recent cost of frames.
#[derive(Resource, Clone, Copy, PartialEq, Debug, Default)]
pub struct FrameCost {
    /// Frames per second.
    pub frames_per_s: f32,
    /// Processor time per frame for the match and the panels, s.
    pub main_s: f32,
    /// The time in which the previous frame is drawn meanwhile, including waiting for the display, s.
    pub rendering_s: f32,
    /// Draw calls per frame, without panels.
    pub draw_calls: u32,
    /// Images of robots' cameras per second.
    pub eye_images_per_s: f32,
    /// The time from building the viewer to the first picture of the match, s.
    pub first_picture_s: Option<f32>,
}

/// The sums since the last average.
#[derive(Resource, Default)]
struct FrameClock {
    began: Option<Instant>,
    since: Option<Instant>,
    frames: u32,
    main: Duration,
    eye_images: u64,
}

/// The counts of the renderer, on its own thread.
#[derive(Resource, Clone)]
struct DrawCounts(Arc<Counts>);

impl Default for DrawCounts {
    fn default() -> Self {
        Self(Arc::new(Counts {
            start: Instant::now(),
            first_picture_ns: AtomicU64::default(),
            draw_calls: AtomicU32::default(),
            rendering_ns: AtomicU64::default(),
        }))
    }
}

struct Counts {
    /// The time at which the viewer was built.
    start: Instant,
    /// The time until the first picture, ns; 0 before it.
    first_picture_ns: AtomicU64,
    draw_calls: AtomicU32,
    /// The drawing time of all frames so far, ns.
    rendering_ns: AtomicU64,
}

fn begin_frame(mut clock: ResMut<FrameClock>) {
    clock.began = Some(Instant::now());
}

fn end_frame(
    mut clock: ResMut<FrameClock>,
    mut cost: ResMut<FrameCost>,
    counts: Res<DrawCounts>,
    images: Res<ShownImages>,
) {
    let now = Instant::now();
    let main = clock.began.map_or(Duration::ZERO, |began| now - began);
    clock.main += main;
    clock.frames += 1;
    let since = *clock.since.get_or_insert(now);
    let elapsed_s = (now - since).as_secs_f32();
    if elapsed_s < MEAN_OVER_S {
        return;
    }
    let frames = clock.frames as f32;
    let rendering = Duration::from_nanos(counts.0.rendering_ns.swap(0, Ordering::Relaxed));
    *cost = FrameCost {
        frames_per_s: frames / elapsed_s,
        main_s: clock.main.as_secs_f32() / frames,
        rendering_s: rendering.as_secs_f32() / frames,
        draw_calls: counts.0.draw_calls.load(Ordering::Relaxed),
        eye_images_per_s: (images.drawn - clock.eye_images) as f32 / elapsed_s,
        first_picture_s: match counts.0.first_picture_ns.load(Ordering::Relaxed) {
            0 => None,
            nanoseconds => Some(Duration::from_nanos(nanoseconds).as_secs_f32()),
        },
    };
    *clock = FrameClock { began: None, since: Some(now), frames: 0, main: Duration::ZERO, eye_images: images.drawn };
}

/// The time at which the renderer started a frame.
#[derive(Resource)]
struct RenderingSince(Instant);

fn begin_rendering(mut commands: Commands) {
    commands.insert_resource(RenderingSince(Instant::now()));
}

fn end_rendering(since: Option<Res<RenderingSince>>, counts: Res<DrawCounts>) {
    if let Some(since) = since {
        let took = u64::try_from(since.0.elapsed().as_nanos()).unwrap_or_default();
        counts.0.rendering_ns.fetch_add(took, Ordering::Relaxed);
        if counts.0.draw_calls.load(Ordering::Relaxed) > 0 && counts.0.first_picture_ns.load(Ordering::Relaxed) == 0 {
            let until_now = u64::try_from(counts.0.start.elapsed().as_nanos()).unwrap_or_default();
            counts.0.first_picture_ns.store(until_now.max(1), Ordering::Relaxed);
        }
    }
}

fn count_draws(
    counts: Res<DrawCounts>,
    opaque: Res<ViewBinnedRenderPhases<Opaque3d>>,
    masked: Res<ViewBinnedRenderPhases<AlphaMask3d>>,
    shadows: Res<ViewBinnedRenderPhases<Shadow>>,
    transparent: Res<ViewSortedRenderPhases<Transparent3d>>,
) {
    let draw_calls = binned(&opaque) + binned(&masked) + binned(&shadows) + sorted(&transparent);
    counts.0.draw_calls.store(draw_calls as u32, Ordering::Relaxed);
}

/// The number of draw calls of a phase, in which items that are drawn together count as one.
fn binned<Item: BinnedPhaseItem>(phases: &ViewBinnedRenderPhases<Item>) -> usize {
    let of_phase = |phase: &bevy::render::render_phase::BinnedRenderPhase<Item>| {
        let unbatchable: usize = phase.unbatchable_meshes.values().map(|bin| bin.entities.len()).sum();
        let others: usize = phase.non_mesh_items.values().map(|bin| bin.entities.len()).sum();
        phase.multidrawable_meshes.len() + phase.batchable_meshes.len() + unbatchable + others
    };
    phases.values().map(of_phase).sum()
}

fn sorted<Item: SortedPhaseItem>(phases: &ViewSortedRenderPhases<Item>) -> usize {
    phases.values().map(|phase| phase.items.len()).sum()
}

fn show_cost(
    mut contexts: EguiContexts,
    cost: Res<FrameCost>,
    diagnostics: Res<DiagnosticsStore>,
    playback: Res<Playback>,
    images: Res<ShownImages>,
    adapter: Option<Res<RenderAdapterInfo>>,
    meshes: Query<(), With<Mesh3d>>,
) -> Result {
    let passes: Vec<(String, f64)> = passes(&diagnostics);
    let adapter = adapter.map_or_else(String::new, |adapter| adapter.name.clone());
    let context = contexts.ctx_mut()?;
    let place = place_beside(context, "frame cost", Align2::LEFT_TOP, &["legend", LARGE_SCORE]);
    layout::floating(context, "frame cost", Align2::LEFT_TOP).fixed_pos(place.min).show(context, |ui| {
        card(ui).fill(ui.visuals().panel_fill).show(ui, |ui| {
            ui.label(bright("Costs of a frame").size(text_size::IMPORTANT));
            Grid::new("frame cost").num_columns(2).spacing([12.0, 1.0]).show(ui, |ui| {
                let milliseconds = |seconds: f32| format!("{:.1} ms", 1000.0 * seconds);
                line(ui, "frames", &format!("{:.1} /s", cost.frames_per_s));
                line(ui, "match and panels", &milliseconds(cost.main_s));
                line(ui, "drawing, meanwhile", &milliseconds(cost.rendering_s));
                line(ui, "draw calls", &format!("{}, of {} meshes", cost.draw_calls, meshes.iter().count()));
                line(ui, "passes", &passes.len().to_string());
                let images = format!(
                    "{:.0} /s, the last {} in {:.1} ms; {} so far",
                    cost.eye_images_per_s,
                    images.last_count,
                    1000.0 * images.last_took.as_secs_f32(),
                    images.drawn
                );
                line(ui, "robots' images", &images);
                line(ui, "match", &format!("{:.2}× real time", playback.achieved));
                let first = cost.first_picture_s.map_or(String::new(), |first| format!("{first:.2} s"));
                line(ui, "first picture after", &first);
                line(ui, "adapter", &adapter);
            });
            for (name, milliseconds) in passes {
                ui.label(dim(format!("{name}: {milliseconds:.2} ms of the processor")).size(text_size::SMALL));
            }
        });
    });
    Ok(())
}

fn line(ui: &mut egui::Ui, name: &str, value: &str) {
    ui.label(dim(name).size(text_size::ENTRY));
    ui.label(bright(value).size(text_size::ENTRY));
    ui.end_row();
}

/// The passes of a frame and their processor time, ms.
fn passes(diagnostics: &DiagnosticsStore) -> Vec<(String, f64)> {
    let mut passes: Vec<(String, f64)> = diagnostics
        .iter()
        .filter_map(|diagnostic| {
            let name = diagnostic.path().as_str().strip_prefix("render/")?.strip_suffix("/elapsed_cpu")?;
            Some((name.to_owned(), diagnostic.smoothed()?))
        })
        .collect();
    passes.sort_by(|(one, _), (other, _)| one.cmp(other));
    passes
}
