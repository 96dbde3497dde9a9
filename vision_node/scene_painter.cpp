#include "vision_node/scene_painter.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include <GL/glew.h>

#include "runtime/log.h"
#include "vision_node/back_face_visibility.h"
#include "vision_node/background_colours.h"
#include "vision_node/depth_cues.h"
#include "vision_node/depth_order.h"
#include "vision_node/detail_choice.h"
#include "vision_node/face_culling.h"
#include "vision_node/flat_buffers.h"
#include "vision_node/scene_lights.h"
#include "vision_node/scene_shaders.h"
#include "vision_node/surface_paint.h"
#include "vision_node/texture_layers.h"
#include "vision_node/view_culling.h"

namespace hapton {
namespace {

// Triangles of the preview of a large mesh, until its first level of detail is made.
constexpr std::size_t kPreviewTriangles = 150'000;
// A level with more triangles casts no shadow, as drawing it costs too much. A large mesh has no smaller level until its levels are made.
constexpr std::size_t kShadowTriangles = 20'000;
// An object larger than the workspace extends through its ground, and a shadow there has no meaning.
constexpr double kShadowShare = 1.0;
// Height of the shadow above the grid, as a share of the eyes' distance from the screen: enough for a depth buffer of 24 bits.
constexpr double kShadowLift = 1e-3;

}  // namespace

struct ScenePainter::Object {
  ShownObject shown;
  DetailFrame frame;
  Vec3 colour;
  double radius_m = 0.0;         // around frame.centre
  Pose X_SO = Pose::Identity();  // pose in frame S of an object that moves
  bool is_shown = true;
  std::shared_ptr<const DetailLevel> whole;       // read by the builder
  std::shared_ptr<const TextureLayers> textures;  // null: none
  bool is_painted = false;                        // its vertices have colours of their own
  bool has_finish = false;                        // some of those have alpha, or a texture that does not repeat
  bool has_blended = false;                       // some of its triangles show what is behind them
  FlatLevel full;
  bool is_preview = false;  // full is only a part of its triangles, until all of them are ready to be drawn
  FlatBuffers full_vertices;
  std::vector<FlatLevel> coarser;  // from the finest to the coarsest
  std::vector<FlatBuffers> coarser_vertices;
  bool has_rough = false;
  bool is_reshaped = false;       // the builder's levels do not have its present shape
  std::size_t triangles = 0;      // in full detail
  std::vector<LevelFacts> facts;  // of full, then of coarser

  const FlatLevel& level(std::size_t i) const { return i > 0 ? coarser[i - 1] : full; }
  GLuint vertices(std::size_t i) const { return i > 0 ? coarser_vertices[i - 1].array : full_vertices.array; }

  Vec3 centre() const { return X_SO * frame.centre; }
  Mat4 X_SU() const { return X_SO.matrix() * frame.matrix(); }

  void list_facts() {
    facts = {{triangles, 0.0}};
    for (const FlatLevel& made : coarser) facts.push_back({made.triangles(), made.error * frame.scale_m});
  }
};

ScenePainter::ScenePainter() = default;

// Makes the full level, with the mesh's colours and images if it has any.
DetailLevel ScenePainter::make_whole_level(const ShownObject& shown, SharedTextures& textures, Object& object) {
  object.is_painted = shown.appearance != nullptr && shown.appearance->triangles.size() == shown.mesh->triangles.size();
  if (!object.is_painted) return make_level_of(*shown.mesh, object);
  std::vector<std::string> notes;
  object.textures = textures.make(shown.appearance, notes);
  for (const std::string& note : notes) log_warning("{}", note);
  DetailLevel level = make_level_of(*shown.mesh, object);
  for (const VertexPaint& paint : level.paints) {
    object.has_finish = object.has_finish || !paint.is_plain();
    object.has_blended = object.has_blended || paint.is_blended != 0;
  }
  return level;
}

DetailLevel ScenePainter::make_level_of(const TriangleMesh& mesh, const Object& object) {
  if (!object.is_painted) return make_full_level(mesh, object.frame);
  return make_painted_level(mesh, object.frame, *object.shown.appearance, object.shown.colour,
                            object.textures != nullptr ? object.textures->layer_of() : std::vector<std::uint8_t>());
}

ScenePainter::~ScenePainter() {
  for (const auto& object : objects_) {
    release(object->full_vertices);
    for (FlatBuffers& vertices : object->coarser_vertices) release(vertices);
  }
  const GLuint arrays[] = {line_vertices_, empty_vertices_}, buffers[] = {line_buffer_, index_buffer_};  // OpenGL ignores 0
  glDeleteVertexArrays(2, arrays);
  glDeleteBuffers(2, buffers);
}

Result<void> ScenePainter::make_programs() {
  struct Sources {
    std::unique_ptr<GlProgram>& program;
    std::string vertex;
    std::string fragment;
  };
  const std::string head = shader_head(lights_.size());
  const Sources all[] = {
      {shaded_program_, fmt::format("{}{}{}", head, kLighting, kVertexShader), fmt::format("{}{}", head, kFragmentShader)},
      {painted_program_, fmt::format("{}{}{}", head, kLighting, kPaintedVertexShader), fmt::format("{}{}", head, kPaintedFragmentShader)},
      {finish_program_, fmt::format("{}{}{}", head, kLighting, kFinishedVertexShader), fmt::format("{}{}", head, kFinishedFragmentShader)},
      {background_program_, std::string(kBackgroundVertexShader), std::string(kBackgroundFragmentShader)},
      {colour_program_, std::string(kSingleVertexShader), std::string(kSingleFragmentShader)}};
  for (const Sources& sources : all) {
    auto made = GlProgram::make(sources.vertex, sources.fragment);
    if (!made) return tl::unexpected(made.error());
    sources.program = std::make_unique<GlProgram>(std::move(*made));
  }
  return {};
}

Result<std::unique_ptr<ScenePainter>> ScenePainter::make(const std::vector<ShownObject>& objects, std::vector<SceneLight> lights) {
  std::unique_ptr<ScenePainter> painter(new ScenePainter);
  painter->lights_ = std::move(lights);
  if (auto made = painter->make_programs(); !made) return tl::unexpected(made.error());
  glGenBuffers(1, &painter->index_buffer_);
  glGenVertexArrays(1, &painter->empty_vertices_);
  painter->upload_lines();
  std::vector<std::shared_ptr<const DetailLevel>> levels;
  SharedTextures textures;
  for (const ShownObject& shown : objects) {
    auto object = std::make_unique<Object>();
    object->shown = shown;
    object->frame = make_detail_frame(*shown.mesh);
    object->colour = shown.colour;
    const auto whole = std::make_shared<DetailLevel>(make_whole_level(shown, textures, *object));
    if (shown.shows_backs) mark_without_back(*shown.mesh, shown.appearance.get(), *whole);
    object->radius_m = whole->clusters.front().radius * object->frame.scale_m;
    object->triangles = whole->triangles();
    levels.push_back(object->whole = whole);
    painter->objects_.push_back(std::move(object));
  }
  painter->builder_ = std::make_unique<DetailBuilder>(std::move(levels));
  for (const auto& object : painter->objects_) {
    // Preparing all triangles of a large mesh would take a tenth of a second here; the builder does it in its thread.
    object->is_preview = object->whole->triangles() > kPreviewTriangles;
    DetailLevel first = object->is_preview ? thin_out(*object->whole, kPreviewTriangles) : *object->whole;
    if (object->whole->triangles() < DetailBuilder::kMinTriangles) divide_into_clusters(first);  // the builder divides the others
    object->full = make_flat(first);
    painter->all_triangles_ += object->whole->triangles();
    object->list_facts();
    object->full_vertices = upload(object->full, painter->index_buffer_);
  }
  return painter;
}

void ScenePainter::place_object(std::size_t object, const Pose& X_SO, bool is_shown) {
  objects_[object]->X_SO = X_SO;
  objects_[object]->is_shown = is_shown;
}

// Drops what was made of the object's shape before.
void ScenePainter::begin_reshape(Object& object) {
  object.is_reshaped = true;
  object.is_preview = false;
  release(object.full_vertices);
  object.coarser.clear();
  for (FlatBuffers& coarser : object.coarser_vertices) release(coarser);
  object.coarser_vertices.clear();
}

void ScenePainter::reshape_object(std::size_t number, std::vector<Vec3> vertices) {
  Object& object = *objects_[number];
  TriangleMesh mesh{.vertices = std::move(vertices), .triangles = object.shown.mesh->triangles};
  begin_reshape(object);
  object.full = make_flat(make_level_of(mesh, object));
  object.full_vertices = upload(object.full, index_buffer_);
  object.list_facts();
}

void ScenePainter::replace_object(std::size_t number, std::vector<FlatLevel> levels) {
  Object& object = *objects_[number];
  begin_reshape(object);
  object.textures.reset();
  object.is_painted = object.has_finish = object.has_blended = false;
  all_triangles_ -= object.triangles;
  object.triangles = levels.front().triangles();
  all_triangles_ += object.triangles;
  object.full = std::move(levels.front());
  object.full_vertices = upload(object.full, index_buffer_);
  for (std::size_t i = 1; i < levels.size(); ++i) {
    object.coarser.push_back(std::move(levels[i]));
    object.coarser_vertices.push_back(upload(object.coarser.back(), index_buffer_));
  }
  object.list_facts();
}

bool ScenePainter::take_levels() {
  auto made = builder_->take_levels();
  for (DetailBuilder::MadeLevel& one : made) {
    Object& object = *objects_[one.object];
    if (object.is_reshaped) continue;
    if (one.is_full) {
      object.full = std::move(one.level);
      object.is_preview = false;
      release(object.full_vertices);
      object.full_vertices = upload(object.full, index_buffer_);
      continue;
    }
    if (object.has_rough && !one.is_rough) {
      object.coarser.clear();
      for (FlatBuffers& vertices : object.coarser_vertices) release(vertices);
      object.coarser_vertices.clear();
    }
    object.has_rough = one.is_rough;
    object.coarser.push_back(std::move(one.level));
    object.coarser_vertices.push_back(upload(object.coarser.back(), index_buffer_));
    object.list_facts();
  }
  return !made.empty();
}

void ScenePainter::complete() {
  for (const auto& object : objects_) {
    if (!object->is_preview) continue;
    object->full = make_flat(*object->whole);
    object->is_preview = false;
    release(object->full_vertices);
    object->full_vertices = upload(object->full, index_buffer_);
  }
}

std::size_t ScenePainter::choose_level_of(const Object& object, const ScenePass& pass, double* error_px) const {
  // A metre has the most pixels where the object comes nearest to the viewer.
  const Vec3 p_VO = pass.screen.X_WV.inverse(Eigen::Isometry) * (pass.X_WS * object.centre());
  const EyeDepths depths = compute_eye_depths(pass.screen, pass.eye);
  const double nearest_m = std::max(depths.near_m, depths.eye_m - p_VO.z() - object.radius_m);
  const double pixels_per_m = pass.size.width_px / pass.screen.width_m * depths.eye_m / nearest_m;
  const auto budget = static_cast<std::size_t>(static_cast<double>(kTriangleBudget) * static_cast<double>(object.triangles) /
                                               static_cast<double>(std::max<std::size_t>(1, all_triangles_)));
  const std::size_t level = choose_level(object.facts, pixels_per_m, budget);
  if (error_px != nullptr) *error_px = object.facts[level].error_m * pixels_per_m;
  return level;
}

bool ScenePainter::is_full(const ScenePass& pass) const {
  if (builder_->progress() < 1.0) return false;
  return std::all_of(objects_.begin(), objects_.end(), [&](const auto& object) { return choose_level_of(*object, pass) == 0; });
}

void ScenePainter::paint_background(const ScenePass& pass) const {
  glDepthMask(GL_TRUE);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glClearColor(0.0F, 0.0F, 0.0F, 1.0F);
  glClear(GL_DEPTH_BUFFER_BIT | (pass.plain ? GL_COLOR_BUFFER_BIT : 0));
  if (pass.plain) return;
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  background_program_->use();
  background_program_->set("low", pass.is_even ? kSceneEven : kSceneLow);
  background_program_->set("high", pass.is_even ? kSceneEven : kSceneHigh);
  glBindVertexArray(empty_vertices_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  if (pass.depth_cues) paint_lines(pass);
}

void ScenePainter::upload_lines() {
  std::vector<Vec3f> corners;
  for (const auto& segment : make_ground_grid()) {
    for (const Vec3& p : segment) corners.push_back(p.cast<float>());
  }
  grid_corners_ = static_cast<int>(corners.size());
  for (const auto& segment : make_workspace_box()) {
    for (const Vec3& p : segment) corners.push_back(p.cast<float>());
  }
  glGenVertexArrays(1, &line_vertices_);
  glGenBuffers(1, &line_buffer_);
  glBindVertexArray(line_vertices_);
  glBindBuffer(GL_ARRAY_BUFFER, line_buffer_);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(corners.size() * sizeof(Vec3f)), corners.data(), GL_STATIC_DRAW);
  glEnableVertexAttribArray(0);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(Vec3f), nullptr);
  glBindVertexArray(0);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
}

void ScenePainter::paint_lines(const ScenePass& pass) const {
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LEQUAL);
  colour_program_->use();
  colour_program_->set("to_clip", Mat4(compute_projection_matrix(pass.screen, pass.eye) * compute_view_matrix(pass.screen, pass.eye)));
  glBindVertexArray(line_vertices_);
  glLineWidth(1.0F);
  colour_program_->set("colour", kSceneGrid);
  glDrawArrays(GL_LINES, 0, grid_corners_);
  colour_program_->set("colour", kSceneBox);
  // Draws all edges except the three at the corner nearest to the viewer, which would be in front of the scene.
  const auto edges = make_workspace_box();
  const Vec3 nearest = find_nearest_corner(compute_eye_position(pass.screen, Eye::centre));
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (edges[i][0] == nearest || edges[i][1] == nearest) continue;
    glDrawArrays(GL_LINES, grid_corners_ + 2 * static_cast<int>(i), 2);
  }
  glBindVertexArray(0);
}

// Draws the shadow from the coarsest levels, since it is flat and of one colour. What lies below the ground has no visible shadow.
void ScenePainter::paint_shadow(const ScenePass& pass) {
  if (pass.plain || !pass.depth_cues) return;
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LESS);  // so that no pixel of the shadow is drawn twice
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  Mat4 raise = Mat4::Identity();
  raise(1, 3) = kShadowLift * pass.screen.distance_m;
  const Mat4 to_ground = raise * compute_shadow_matrix(direction_to_shadow_light()) * pass.X_WS.matrix();
  const Mat4 to_clip = compute_projection_matrix(pass.screen, pass.eye) * compute_view_matrix(pass.screen, pass.eye) * to_ground;
  colour_program_->use();
  colour_program_->set("colour", kSceneShadow);
  for (const auto& object : objects_) {
    const std::size_t coarsest = object->facts.size() - 1;
    const FlatLevel& level = object->level(coarsest);
    if (!object->is_shown || level.triangles() > kShadowTriangles || object->radius_m > kShadowShare * workspace_size_m().norm()) continue;
    colour_program_->set("to_clip", Mat4(to_clip * object->X_SU()));
    glBindVertexArray(object->vertices(coarsest));
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(level.indices.size() * sizeof(std::uint32_t)), level.indices.data(),
                 GL_STREAM_DRAW);
    glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(level.indices.size()), GL_UNSIGNED_INT, nullptr);
  }
  glBindVertexArray(0);
}

void ScenePainter::begin_objects(const ScenePass& pass) const {
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LEQUAL);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
  glFrontFace(GL_CCW);
  // Haze from a little before the picture's centre to the scene's far end, in eyes' distances; without haze both are beyond every depth.
  const bool is_hazy = pass.depth_cues && !pass.plain;
  for (const GlProgram* program : {finish_program_.get(), painted_program_.get(), shaded_program_.get()}) {
    program->use();
    set_lights(*program, lights_, pass.screen, pass.eye);
    program->set("plain", pass.plain ? 1 : 0);
    program->set("haze", kSceneHaze);
    program->set("haze_from", is_hazy ? 1.0 - 0.1 * (pass.screen.far_m / pass.screen.distance_m - 1.0) : 1e6);
    program->set("haze_to", is_hazy ? 1.0 + 1.0 * (pass.screen.far_m / pass.screen.distance_m - 1.0) : 2e6);
  }
}

void ScenePainter::begin_stage(PaintStage stage) {
  const GLboolean has_colour = stage == PaintStage::blended_depth ? GL_FALSE : GL_TRUE;
  glColorMask(has_colour, has_colour, has_colour, has_colour);
  glDepthMask(stage == PaintStage::blended ? GL_FALSE : GL_TRUE);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  stage == PaintStage::blended ? glEnable(GL_BLEND) : glDisable(GL_BLEND);
}

bool ScenePainter::has_blended() const {
  return std::any_of(objects_.begin(), objects_.end(), [](const auto& object) { return object->has_blended; });
}

std::vector<std::size_t> ScenePainter::order_objects(PaintStage stage, const ScenePass& pass) const {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    if (objects_[i]->is_shown && (stage == PaintStage::solid || objects_[i]->has_blended)) order.push_back(i);
  }
  if (stage == PaintStage::solid) return order;
  const Vec3 p_WE = compute_eye_position(pass.screen, pass.eye);
  const auto distance_squared = [&](std::size_t i) { return (pass.X_WS * objects_[i]->centre() - p_WE).squaredNorm(); };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return distance_squared(a) > distance_squared(b); });
  return order;
}

// Clusters [from, to) in the stage's order.
struct ScenePainter::ClusterRange {
  PaintStage stage = PaintStage::solid;
  std::size_t from = 0;
  std::size_t to = 0;
};

void ScenePainter::gather(const Object& object, const FlatLevel& level, const ClusterRange& range, const Mat4& to_clip, const Vec3& p_UE,
                          DrawnSides sides) {
  const ViewCulling culling(to_clip, p_UE, sides);
  const bool is_solid = range.stage == PaintStage::solid;
  std::vector<std::uint32_t> order;
  if (!is_solid) order = order_far_to_near(level.clusters, p_UE.cast<float>());
  visible_.clear();
  for (std::size_t i = range.from; i < range.to; ++i) {
    const DetailCluster& cluster = level.clusters[is_solid ? i : order[i]];
    if (!culling.may_see(cluster)) continue;
    const auto first = level.indices.begin() + cluster.first;
    if (!object.has_blended) {
      visible_.insert(visible_.end(), first, first + cluster.count);
      continue;
    }
    for (std::uint32_t k = 0; k + 2 < cluster.count; k += 3) {
      if ((level.paints[first[k]].is_blended == 0) != is_solid) continue;
      visible_.insert(visible_.end(), first + k, first + k + 3);
    }
  }
  if (range.stage == PaintStage::blended) sort_far_to_near(visible_, level.vertices, p_UE.cast<float>());
}

std::size_t ScenePainter::paint_part(const Object& object, std::size_t level, const ScenePass& pass, const ClusterRange& range) {
  const Mat4 X_WU = pass.X_WS.matrix() * object.X_SU();
  const Mat4 X_EU = compute_view_matrix(pass.screen, pass.eye) * X_WU;
  const Mat4 to_clip = compute_projection_matrix(pass.screen, pass.eye) * X_EU;
  const Vec3 p_UE = (X_WU.inverse() * compute_eye_position(pass.screen, pass.eye).homogeneous()).head<3>();
  // The unit is the eyes' distance from the screen, so that a scene of any size is in the range of single precision.
  Mat4 to_eye = X_EU;
  to_eye.topRows<3>() /= pass.screen.distance_m;
  const bool shows_backs = !pass.cull || object.shown.shows_backs;
  const bool culls = !shows_backs || range.stage == PaintStage::solid;  // if it also shows backs, fronts are drawn first, then backs
  std::size_t sent = 0;
  for (const bool backs : {false, true}) {
    if (backs && !(shows_backs && culls)) break;
    set_drawn_side(culls, backs);
    gather(object, object.level(level), range, to_clip, p_UE, !culls ? DrawnSides::both : backs ? DrawnSides::backs : DrawnSides::fronts);
    if (!visible_.empty()) paint_visible(object, object.vertices(level), to_clip, to_eye);
    sent += visible_.size() / 3;
  }
  set_drawn_side(false, false);
  return sent;
}

void ScenePainter::paint_visible(const Object& object, std::uint32_t vertices, const Mat4& to_clip, const Mat4& to_eye) const {
  const GlProgram& program = object.has_finish ? *finish_program_ : object.is_painted ? *painted_program_ : *shaded_program_;
  program.use();
  program.set("to_clip", to_clip);
  program.set("to_eye", to_eye);
  if (object.is_painted) {
    program.set("textured", object.textures != nullptr ? 1 : 0);
    program.set("images", TextureLayers::unit());
  } else {
    program.set("colour", object.colour);
  }
  if (object.textures != nullptr) object.textures->bind();
  glBindVertexArray(vertices);
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(visible_.size() * sizeof(std::uint32_t)), visible_.data(), GL_STREAM_DRAW);
  glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(visible_.size()), GL_UNSIGNED_INT, nullptr);
  glBindVertexArray(0);
  if (object.textures != nullptr) TextureLayers::unbind();
}

PaintCount ScenePainter::paint(const ScenePass& pass) {
  paint_shadow(pass);
  begin_objects(pass);
  PaintCount count;
  for (const PaintStage stage : {PaintStage::solid, PaintStage::blended, PaintStage::blended_depth}) {
    if (stage != PaintStage::solid && !has_blended()) break;
    begin_stage(stage);
    for (const std::size_t number : order_objects(stage, pass)) {
      const Object& object = *objects_[number];
      double error_px = 0.0;
      const std::size_t i = choose_level_of(object, pass, &error_px);
      const FlatLevel& level = object.level(i);
      const std::size_t sent = paint_part(object, i, pass, {stage, 0, level.clusters.size()});
      if (stage != PaintStage::blended_depth) count.sent_triangles += sent;
      if (stage != PaintStage::solid) continue;
      count.triangles += level.triangles();
      count.largest_error_px = std::max(count.largest_error_px, error_px);
    }
  }
  begin_stage(PaintStage::solid);
  builder_->begin();
  return count;
}

bool ScenePainter::paint_full(const ScenePass& pass, PaintCursor& cursor, std::size_t triangles) {
  if (cursor.is_at_start()) paint_shadow(pass);
  begin_objects(pass);
  std::size_t drawn = 0;
  for (; cursor.stage != PaintStage::done; cursor = {static_cast<PaintStage>(static_cast<int>(cursor.stage) + 1), 0, 0}) {
    begin_stage(cursor.stage);
    const std::vector<std::size_t> order = order_objects(cursor.stage, pass);
    while (cursor.object < order.size() && drawn < triangles) {
      const Object& object = *objects_[order[cursor.object]];
      const std::vector<DetailCluster>& clusters = object.level(0).clusters;
      std::size_t to = cursor.cluster;
      for (std::size_t sum = 0; to < clusters.size() && sum < 3 * (triangles - drawn); ++to) sum += clusters[to].count;
      drawn += std::max<std::size_t>(1, paint_part(object, 0, pass, {cursor.stage, cursor.cluster, to}));
      cursor.cluster = to;
      if (cursor.cluster == clusters.size()) {
        ++cursor.object;
        cursor.cluster = 0;
      }
    }
    if (cursor.object < order.size()) break;
  }
  begin_stage(PaintStage::solid);
  return cursor.stage == PaintStage::done;
}

}  // namespace hapton
