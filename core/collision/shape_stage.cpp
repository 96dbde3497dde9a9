#include "core/collision/shape_stage.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/collision/deforming_geometry.h"

namespace hapton {
namespace {

constexpr double kBoxMargin = 0x1p-40;  // local units; rounding may put a share at the boundary of two parts into either

// Rounds as ObjectGeometry::move_vertex does; the difference of two such coordinates is exact.
double to_grid(double local) { return std::ldexp(std::rint(std::ldexp(local, 51)), -51); }

}  // namespace

Box bounds_with_reach(const TriangleMesh& mesh, double reach_m) {
  const Box box = Box::of(mesh.vertices);
  if (box.is_empty()) return box;
  return with_room_for_rounding(box.inflated(reach_m));
}

ShapeStager::ShapeStager(const TouchGeometry& geometry, std::shared_ptr<const TriangleMesh> mesh, double reach_m)
    : mesh_(std::move(mesh)),
      reach_m_(reach_m),
      frame_(geometry.frame()),
      new_vertex_(geometry.new_vertex()),
      vertex_count_(geometry.object_geometry(0).vertices().size()),
      tree_(geometry.object_geometry(0).tree()),
      mean_edge_m_(compute_mean_edge(*mesh_)) {
  const ObjectGeometry& object = geometry.object_geometry(0);
  for (std::uint32_t t = 0; t < object.triangle_count(); ++t) triangles_.push_back(object.triangle(t));
}

std::vector<double> ShapeStager::to_local(std::span<const Vec3> shape) const {
  std::vector<double> local(3 * vertex_count_, 0.0);
  for (std::size_t v = 0; v < shape.size(); ++v) {
    if (new_vertex_[v] == ObjectGeometry::kUnused) continue;
    const Vec3 p = frame_.to_local(shape[v]);
    for (int k = 0; k < 3; ++k) local[3 * std::size_t{new_vertex_[v]} + static_cast<std::size_t>(k)] = to_grid(p[k]);
  }
  return local;
}

std::unique_ptr<ShapeStage> ShapeStager::make_rest() const {
  auto stage = std::make_unique<ShapeStage>();
  stage->begin = stage->to = mesh_->vertices;
  stage->begin_local = to_local(mesh_->vertices);
  stage->motion_local.assign(stage->begin_local.size(), 0.0);
  stage->trees.push_back(tree_);
  return stage;
}

Result<void> ShapeStager::check(std::span<const Vec3> from, std::span<const Vec3> to) const {
  if (to.size() != rest().size()) return fail("{} vertices were given; the mesh has {}", to.size(), rest().size());
  for (std::size_t v = 0; v < to.size(); ++v) {
    if (!to[v].allFinite()) return fail("vertex {} has a number that is not finite", v);
    const double away_m = (to[v] - rest()[v]).norm();
    if (!(away_m <= reach_m_)) {
      return fail("vertex {} is {:.4g} m from where it is at rest; the largest distance is the reach, {:.4g} m", v, away_m, reach_m_);
    }
  }
  TriangleMesh shape{.vertices = {to.begin(), to.end()}, .triangles = mesh_->triangles};
  if (auto checked = check_shape(shape, frame_, "at its end"); !checked) return checked;
  for (std::size_t v = 0; v < to.size(); ++v) shape.vertices[v] = 0.5 * (from[v] + to[v]);
  return check_shape(shape, frame_, "half-way");
}

// The number of parts, as in DeformingGeometry: vertices move by at most half a mean edge in each, if kMaxTrees parts suffice for that.
std::size_t ShapeStager::choose_count(double most_m) const {
  const double desired_count = mean_edge_m_ > 0.0 ? std::ceil(2.0 * most_m / mean_edge_m_) : 1.0;
  return static_cast<std::size_t>(std::clamp(desired_count, 1.0, static_cast<double>(kMaxTrees)));
}

Result<std::unique_ptr<ShapeStage>> ShapeStager::make(std::span<const Vec3> from, std::span<const Vec3> to) const {
  if (auto checked = check(from, to); !checked) return tl::unexpected(checked.error());
  auto stage = std::make_unique<ShapeStage>();
  stage->begin.assign(from.begin(), from.end());
  stage->to.assign(to.begin(), to.end());
  stage->begin_local = to_local(from);
  stage->motion_local = to_local(to);
  for (std::size_t i = 0; i < stage->motion_local.size(); ++i) stage->motion_local[i] -= stage->begin_local[i];
  // Rounding both ends of a motion to the grid lengthens the motion by less than this.
  const double rounding_m = 0x1p-49 * frame_.unit_m;
  for (std::size_t v = 0; v < to.size(); ++v) stage->most_m = std::max(stage->most_m, (to[v] - from[v]).norm());
  if (stage->most_m > 0.0) stage->most_m += rounding_m;
  const std::size_t count = choose_count(stage->most_m);
  const auto corner_at = [&](std::uint32_t vertex, double share) {
    const std::size_t at = 3 * std::size_t{vertex};
    return Vec3(stage->begin_local[at] + share * stage->motion_local[at], stage->begin_local[at + 1] + share * stage->motion_local[at + 1],
                stage->begin_local[at + 2] + share * stage->motion_local[at + 2]);
  };
  for (std::size_t part = 0; part < count; ++part) {
    const double begin = static_cast<double>(part) / static_cast<double>(count);
    const double end = static_cast<double>(part + 1) / static_cast<double>(count);
    WideBvh tree = tree_;
    tree.refit_all([&](std::size_t t) {
      Box box;  // enough for all times of the part: vertices move straight
      for (const std::uint32_t vertex : triangles_[t]) {
        box.grow(corner_at(vertex, begin));
        box.grow(corner_at(vertex, end));
      }
      return box.inflated(kBoxMargin);
    });
    stage->trees.push_back(std::move(tree));
  }
  return stage;
}

StreamedGeometry::StreamedGeometry(TouchGeometry& geometry, std::unique_ptr<ShapeStage> rest)
    : geometry_(geometry), rest_(rest->begin_local) {
  present_.stage = std::move(rest);
  geometry_.deforming_object().swap_tree(present_.stage->trees[0]);
  shape(0.0);
}

// Takes the oldest stage that is no longer used. displacement_between() needs the motion of the stage before the present one also after
// that stage has been returned. It is swapped, because the step may neither copy nor free it.
std::unique_ptr<ShapeStage> StreamedGeometry::take_retired() noexcept {
  if (retired_count_ == 0) {
    if (ended_.stage != nullptr) ended_motion_.swap(ended_.stage->motion_local);
    return std::move(ended_.stage);
  }
  auto oldest = std::move(retired_[0]);
  std::move(retired_.begin() + 1, retired_.begin() + static_cast<std::ptrdiff_t>(retired_count_), retired_.begin());
  --retired_count_;
  return oldest;
}

StreamedGeometry::Released StreamedGeometry::offer(std::unique_ptr<ShapeStage> stage, double over_s, double now_s) noexcept {
  Released released;
  if (waiting_count_ > 0) released.replaced = std::move(waiting_[--waiting_count_].stage);
  released.ended = append(std::move(stage), over_s, now_s);
  return released;
}

std::unique_ptr<ShapeStage> StreamedGeometry::append(std::unique_ptr<ShapeStage> stage, double over_s, double start_s) noexcept {
  auto retired = take_retired();
  waiting_[waiting_count_] = {std::move(stage), std::max(start_s, end_s()), over_s};
  ++waiting_count_;
  return retired;
}

StreamedGeometry::StageAt StreamedGeometry::find(double time_s) const noexcept {
  const TimedStage* timed = &present_;
  double travelled_m = travelled_m_;
  for (std::size_t n = 0; n < waiting_count_ && time_s >= waiting_[n].start_s; ++n) {
    travelled_m += timed->stage->most_m;
    timed = &waiting_[n];
  }
  return {*timed, travelled_m};
}

double StreamedGeometry::travel_to(double time_s) const noexcept {
  const StageAt found = find(time_s);
  return std::fabs(found.travelled_m + found.timed.share_at(time_s) * found.timed.stage->most_m - travelled_at_shape_m_);
}

// Pre: at least one stage waits.
void StreamedGeometry::advance() noexcept {
  ObjectGeometry& object = geometry_.deforming_object();
  object.swap_tree(present_.stage->trees[part_]);
  travelled_m_ += present_.stage->most_m;
  if (ended_.stage != nullptr) retired_[retired_count_++] = std::move(ended_.stage);
  ended_ = std::move(present_);
  present_ = std::move(waiting_[0]);
  std::move(waiting_.begin() + 1, waiting_.begin() + static_cast<std::ptrdiff_t>(waiting_count_), waiting_.begin());
  --waiting_count_;
  ++serial_;
  part_ = 0;
  object.swap_tree(present_.stage->trees[0]);
}

void StreamedGeometry::skip_to(double time_s) noexcept {
  while (is_due(time_s)) advance();
}

void StreamedGeometry::shape(double time_s) noexcept {
  skip_to(time_s);
  ObjectGeometry& object = geometry_.deforming_object();
  ShapeStage& stage = *present_.stage;
  const double share = present_.share_at(time_s);
  for (std::size_t i = 0; i + 2 < stage.begin_local.size(); i += 3) {
    object.move_vertex(static_cast<std::uint32_t>(i / 3),
                       {stage.begin_local[i] + share * stage.motion_local[i], stage.begin_local[i + 1] + share * stage.motion_local[i + 1],
                        stage.begin_local[i + 2] + share * stage.motion_local[i + 2]});
  }
  travelled_at_shape_m_ = travelled_m_ + share * stage.most_m;
  const std::size_t count = stage.trees.size();
  const std::size_t part = std::min(static_cast<std::size_t>(share * static_cast<double>(count)), count - 1);
  if (part == part_) return;
  object.swap_tree(stage.trees[part_]);
  object.swap_tree(stage.trees[part]);
  part_ = part;
}

std::vector<Vec3> StreamedGeometry::vertices_at(double time_s) const {
  const TimedStage& timed = find(time_s).timed;
  const ShapeStage& stage = *timed.stage;
  const double share = timed.share_at(time_s);
  std::vector<Vec3> vertices = stage.begin;
  for (std::size_t v = 0; v < vertices.size(); ++v) vertices[v] += share * (stage.to[v] - stage.begin[v]);
  return vertices;
}

std::size_t StreamedGeometry::bytes() const noexcept {
  std::size_t bytes = (rest_.capacity() + ended_motion_.capacity()) * sizeof(double);
  const auto add = [&](const ShapeStage& stage) {
    bytes += (stage.begin.capacity() + stage.to.capacity()) * sizeof(Vec3) +
             (stage.begin_local.capacity() + stage.motion_local.capacity()) * sizeof(double);
    for (const WideBvh& tree : stage.trees) bytes += tree.bytes();
  };
  add(*present_.stage);
  if (ended_.stage != nullptr) add(*ended_.stage);
  for (std::size_t n = 0; n < waiting_count_; ++n) add(*waiting_[n].stage);
  for (std::size_t n = 0; n < retired_count_; ++n) add(*retired_[n]);
  return bytes;
}

}  // namespace hapton
