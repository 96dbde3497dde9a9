#include "vision_node/scene_layers.h"

#include <limits>
#include <utility>

namespace hapton {
namespace {

// Triangles that are drawn at a time. They take some milliseconds; a frame that shows the probe can wait that long.
constexpr std::size_t kPartTriangles = 60'000;
// More triangles than any scene has. It is not the largest number, because ScenePainter multiplies it by 3.
constexpr std::size_t kAllTriangles = std::numeric_limits<std::size_t>::max() / 8;

bool same_screen(const StereoScreen& a, const StereoScreen& b) {
  return a.X_WV.matrix() == b.X_WV.matrix() && a.width_m == b.width_m && a.height_m == b.height_m && a.distance_m == b.distance_m &&
         a.eyes_offset_m == b.eyes_offset_m && a.to_right_V == b.to_right_V && a.ipd_m == b.ipd_m && a.near_m == b.near_m &&
         a.far_m == b.far_m && a.light_V == b.light_V;
}

bool same_pass(const ScenePass& a, const ScenePass& b) {
  return a.eye == b.eye && a.size == b.size && a.cull == b.cull && a.plain == b.plain && a.depth_cues == b.depth_cues &&
         a.is_even == b.is_even && a.X_WS.matrix() == b.X_WS.matrix() && same_screen(a.screen, b.screen);
}

}  // namespace

Result<std::unique_ptr<SceneLayers>> SceneLayers::make(const std::vector<ShownObject>& objects, std::vector<SceneLight> lights) {
  auto painter = ScenePainter::make(objects, std::move(lights));
  if (!painter) return tl::unexpected(painter.error());
  return std::unique_ptr<SceneLayers>(new SceneLayers(std::move(*painter)));
}

void SceneLayers::reshape_object(std::size_t object, std::vector<Vec3> vertices) {
  painter_->reshape_object(object, std::move(vertices));
  for (Layer& each : layers_) each.is_valid = false;
}

void SceneLayers::replace_object(std::size_t object, std::vector<FlatLevel> levels) {
  painter_->replace_object(object, std::move(levels));
  for (Layer& each : layers_) each.is_valid = false;
}

bool SceneLayers::has_new_levels() {
  has_new_levels_ = painter_->take_levels() || has_new_levels_;
  return has_new_levels_;
}

void SceneLayers::place_object(std::size_t object, const Pose& X_SO, bool is_shown) {
  painter_->place_object(object, X_SO, is_shown);
  for (Layer& each : layers_) each.is_valid = false;
}

void SceneLayers::prepare(std::span<const ScenePass> passes, const GlFormat& format) {
  const GlStateGuard guard;
  const bool has_better_levels = std::exchange(has_new_levels_, false) || painter_->take_levels();
  for (Layer& each : layers_) each.is_active = false;
  for (const ScenePass& pass : passes) {
    Layer& here = layer(pass.eye);
    here.is_active = true;
    const bool is_same = here.is_valid && same_pass(here.pass, pass) && here.shown.format() == format;
    if (is_same && (here.is_full || !has_better_levels)) continue;
    here.pass = pass;
    here.shown.resize(pass.size, format);
    begin(here, here.shown);
    count_ = painter_->paint(pass);
    here.surface.reset();
    ++pictures_drawn_;
    here.is_valid = true;
    here.is_full = painter_->is_full(pass);
    here.is_finer_complete = false;
    here.cursor = {};
  }
}

// Binds the target and copies the background into it.
void SceneLayers::begin(Layer& here, GlTarget& target) {
  const bool is_new = here.background.resize(target.size(), target.format());
  if (is_new || !same_screen(here.background_pass.screen, here.pass.screen) || here.background_pass.depth_cues != here.pass.depth_cues ||
      here.background_pass.is_even != here.pass.is_even) {
    here.background_pass = here.pass;
    here.background.bind();
    painter_->paint_background(here.pass);
  }
  target.bind();
  here.background.copy_to_bound(0, 0);
}

bool SceneLayers::wants_refining() const {
  if (painter_->progress() < 1.0) return false;
  for (const Layer& here : layers_) {
    if (here.is_active && here.is_valid && !here.is_full) return true;
  }
  return false;
}

bool SceneLayers::refine() {
  const GlStateGuard guard;
  painter_->take_levels();
  for (Layer& here : layers_) {
    if (!here.is_active || !here.is_valid || here.is_full || here.is_finer_complete) continue;
    here.finer.resize(here.shown.size(), here.shown.format());
    here.cursor.is_at_start() ? begin(here, here.finer) : here.finer.bind();
    here.is_finer_complete = painter_->paint_full(here.pass, here.cursor, kPartTriangles);
    if (!here.is_finer_complete) return false;
  }
  for (Layer& here : layers_) {
    if (!std::exchange(here.is_finer_complete, false)) continue;
    here.shown.swap(here.finer);
    here.surface.reset();
    here.is_full = true;
  }
  return true;
}

void SceneLayers::refine_whole() {
  const GlStateGuard guard;
  painter_->take_levels();
  painter_->complete();
  for (Layer& here : layers_) {
    if (!here.is_active || !here.is_valid || here.is_full) continue;
    begin(here, here.shown);
    here.cursor = {};
    while (!painter_->paint_full(here.pass, here.cursor, kAllTriangles)) {
    }
    here.is_full = true;
    here.is_finer_complete = false;
    here.surface.reset();
  }
}

void SceneLayers::copy_to_bound(Eye eye, int x, int y) const {
  const GlStateGuard guard;
  glDisable(GL_SCISSOR_TEST);
  layers_[static_cast<std::size_t>(eye)].shown.copy_to_bound(x, y);
}

std::shared_ptr<const VisibleDepth> SceneLayers::read_surface(Eye eye) {
  Layer& here = layer(eye);
  if (!here.is_valid || here.shown.format().samples > 0) return nullptr;
  if (here.surface == nullptr) {
    const GlStateGuard guard;
    here.surface = std::make_shared<const VisibleDepth>(here.pass.screen, eye, here.pass.size, here.shown.read_depths());
  }
  return here.surface;
}

std::optional<Vec3> SceneLayers::find_surface(Eye eye, int x, int y) const {
  const Layer& here = layers_[static_cast<std::size_t>(eye)];
  if (!here.is_valid || x < 0 || y < 0 || x >= here.pass.size.width_px || y >= here.pass.size.height_px) return std::nullopt;
  if (here.shown.format().samples > 0) return std::nullopt;
  const GlStateGuard guard;
  const double depth = here.shown.read_depth(x, y);
  if (!(depth < 1.0)) return std::nullopt;
  const Mat4 to_clip = compute_projection_matrix(here.pass.screen, eye) * compute_view_matrix(here.pass.screen, eye);
  const Eigen::Vector4d clip(2.0 * (x + 0.5) / here.pass.size.width_px - 1.0, 2.0 * (y + 0.5) / here.pass.size.height_px - 1.0,
                             2.0 * depth - 1.0, 1.0);
  return Vec3((to_clip.inverse() * clip).hnormalized());
}

}  // namespace hapton
