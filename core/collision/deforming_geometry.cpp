#include "core/collision/deforming_geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

namespace hapton {
namespace {

constexpr std::size_t kMinShapes = 4;                    // shapes checked of a mesh too large for more: at rest, at keys and half-way
constexpr std::size_t kMaxCheckedTriangles = 4'000'000;  // in all shapes that are checked at start-up, which takes some seconds

// Times at which the shape is checked, about `count`: those of all keys, or of every second, third ... key, and half-way between them.
std::vector<double> times_of_shapes(const MeshDeformation& deformation, std::size_t count) {
  const auto& keys = deformation.keys();
  const std::size_t step = 1 + 2 * keys.size() / count;
  std::vector<double> times = {0.0};
  for (std::size_t i = 0; i < keys.size(); i += step) {
    if (keys[i].time_s > times.back()) times.push_back(0.5 * (times.back() + keys[i].time_s));
    times.push_back(keys[i].time_s);
  }
  const double end_s = deformation.duration_s();
  if (end_s > times.back()) times.push_back(0.5 * (times.back() + end_s));
  times.push_back(end_s);
  return times;
}

}  // namespace

double compute_mean_edge(const TriangleMesh& mesh) {
  double sum = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    sum += (mesh.vertices[b] - mesh.vertices[a]).norm() + (mesh.vertices[c] - mesh.vertices[b]).norm() +
           (mesh.vertices[a] - mesh.vertices[c]).norm();
  }
  return mesh.triangles.empty() ? 0.0 : sum / (3.0 * static_cast<double>(mesh.triangles.size()));
}

Box with_room_for_rounding(const Box& box) { return box.inflated(0x1p-40 * (box.diagonal() + box.low.norm() + box.high.norm())); }

Result<void> check_shape(const TriangleMesh& shape, const LocalFrame& frame, std::string_view when) {
  const ObjectGeometry geometry(shape, frame);
  const std::size_t walkable = geometry.adjacency().walkable_count();
  if (walkable == shape.triangles.size()) return {};
  std::uint32_t first = 0;
  while (geometry.adjacency().is_walkable(first)) ++first;
  const Vec3 at = frame.to_scene(geometry.corner(first, 0));
  return fail(
      "{} {} of its {} triangles touch or nearly touch another part of the surface or are not locally manifold, one at "
      "({:.4g}, {:.4g}, {:.4g}) m",
      when, shape.triangles.size() - walkable, shape.triangles.size(), at.x(), at.y(), at.z());
}

// Vertices move straight between keys, so the box around the shapes at all keys holds every shape.
Box bounds_of_all_shapes(const TriangleMesh& mesh, const MeshDeformation& deformation) {
  Box box = Box::of(mesh.vertices);
  for (const MorphKey& key : deformation.keys()) {
    box.grow(Box::of(deformation.vertices_at(mesh.vertices, deformation.weights_at(key.time_s))));
  }
  return with_room_for_rounding(box);
}

Result<void> check_shapes(const TriangleMesh& mesh, const MeshDeformation& deformation) {
  const LocalFrame frame = TouchGeometry::frame_of(bounds_of_all_shapes(mesh, deformation));
  TriangleMesh shape{.vertices = mesh.vertices, .triangles = mesh.triangles};
  if (auto checked = check_shape(shape, frame, "at rest"); !checked) return checked;
  const std::size_t count = std::clamp(kMaxCheckedTriangles / std::max<std::size_t>(1, mesh.triangles.size()), kMinShapes, kMaxShapes);
  for (const double time : times_of_shapes(deformation, count)) {
    shape.vertices = deformation.vertices_at(mesh.vertices, deformation.weights_at(time));
    if (auto checked = check_shape(shape, frame, fmt::format("at {:.3g} s", time)); !checked) return checked;
  }
  return {};
}

DeformingGeometry::DeformingGeometry(TouchGeometry& geometry, std::shared_ptr<const TriangleMesh> mesh,
                                     std::shared_ptr<const MeshDeformation> deformation)
    : geometry_(geometry), mesh_(std::move(mesh)), deformation_(std::move(deformation)) {
  make_arrays();
  make_trees();
  shape(0.0);
}

void DeformingGeometry::make_arrays() {
  std::vector<std::pair<std::uint32_t, std::size_t>> order;  // vertex of the object; its index in moved()
  for (std::size_t i = 0; i < deformation_->moved().size(); ++i) {
    const std::uint32_t vertex = geometry_.new_vertex()[deformation_->moved()[i]];
    if (vertex != ObjectGeometry::kUnused) order.emplace_back(vertex, i);
  }
  std::sort(order.begin(), order.end());
  for (const auto& [vertex, i] : order) {
    moving_vertices_.push_back(vertex);
    const Vec3 rest = geometry_.to_local(mesh_->vertices[deformation_->moved()[i]]);
    rest_coordinates_.insert(rest_coordinates_.end(), rest.begin(), rest.end());
  }
  for (std::size_t j = 0; j < deformation_->targets().size(); ++j) {
    for (const auto& [vertex, i] : order) {
      MeshDeformation::Weights unit_weights = {};
      unit_weights[j] = 1.0;
      const Vec3 displacement = deformation_->position_of(i, Vec3::Zero(), unit_weights) / geometry_.unit_m();
      displacements_.insert(displacements_.end(), displacement.begin(), displacement.end());
    }
  }
}

// Works in blocks that fit into the first-level cache, one coordinate after the other, so that vector instructions compute eight at once.
void DeformingGeometry::move_vertices(const MeshDeformation::Weights& weights) noexcept {
  constexpr std::size_t kBlock = 3 * 128;  // coordinates: 3 KB, of 32 KB and more
  ObjectGeometry& object = geometry_.deforming_object();
  std::array<double, kBlock> p;
  for (std::size_t begin = 0; begin < rest_coordinates_.size(); begin += kBlock) {
    const std::size_t count = std::min(kBlock, rest_coordinates_.size() - begin);
    std::copy_n(&rest_coordinates_[begin], count, p.begin());
    for (std::size_t j = 0; j < deformation_->targets().size(); ++j) {
      if (weights[j] == 0.0) continue;
      const double* displacement = &displacements_[j * rest_coordinates_.size() + begin];
      for (std::size_t k = 0; k < count; ++k) p[k] += weights[j] * displacement[k];
    }
    for (std::size_t k = 0; k < count; k += 3) object.move_vertex(moving_vertices_[(begin + k) / 3], {p[k], p[k + 1], p[k + 2]});
  }
}

// The number of parts of the time, chosen so that vertices move by at most half a mean edge in a part, on average over the parts.
std::size_t DeformingGeometry::choose_count() const {
  double path = 0.0;
  const auto& keys = deformation_->keys();
  for (std::size_t i = 1; i < keys.size(); ++i) {
    path += deformation_->most_displacement(deformation_->weights_at(keys[i - 1].time_s), deformation_->weights_at(keys[i].time_s));
  }
  const double edge = compute_mean_edge(*mesh_);
  const std::size_t max_trees = kMaxBytes / std::max<std::size_t>(1, geometry_.deforming_object().tree().bytes());
  const double desired_count = edge > 0.0 ? std::ceil(2.0 * path / edge) : 1.0;
  return std::clamp<std::size_t>(static_cast<std::size_t>(std::min<double>(desired_count, kMaxTrees)), 1,
                                 std::max<std::size_t>(1, max_trees));
}

void DeformingGeometry::make_trees() {
  ObjectGeometry& object = geometry_.deforming_object();
  const std::size_t count = choose_count();
  const double duration = deformation_->duration_s();
  const auto& keys = deformation_->keys();
  const auto grow = [&](double time, std::vector<Box>& boxes) {
    move_vertices(deformation_->weights_at(time));
    for (std::uint32_t t = 0; t < object.triangle_count(); ++t) {
      for (int k = 0; k < 3; ++k) boxes[t].grow(object.corner(t, k));
    }
  };
  for (std::size_t part = 0; part < count; ++part) {
    const double begin = duration * static_cast<double>(part) / static_cast<double>(count);
    const double end = duration * static_cast<double>(part + 1) / static_cast<double>(count);
    std::vector<Box> boxes(object.triangle_count());
    grow(begin, boxes);
    for (const MorphKey& key : keys) {
      if (key.time_s > begin && key.time_s < end) grow(key.time_s, boxes);
    }
    grow(end, boxes);
    // A time at the boundary of two parts may be rounded to either part.
    WideBvh tree = object.tree();
    tree.refit_all([&](std::size_t t) { return boxes[t].inflated(0x1p-40); });
    trees_.push_back(std::move(tree));
  }
  object.swap_tree(trees_[0]);
}

std::size_t DeformingGeometry::part_at(double time_s) const noexcept {
  const double duration = deformation_->duration_s();
  if (!(duration > 0.0)) return 0;
  const double share = deformation_->time_in_loop(time_s) / duration;
  return std::min(static_cast<std::size_t>(share * static_cast<double>(trees_.size())), trees_.size() - 1);
}

void DeformingGeometry::shape(double time_s) noexcept {
  ObjectGeometry& object = geometry_.deforming_object();
  weights_ = deformation_->weights_at(time_s);
  move_vertices(weights_);
  const std::size_t part = part_at(time_s);
  if (part == part_) return;
  object.swap_tree(trees_[part_]);
  object.swap_tree(trees_[part]);
  part_ = part;
}

std::optional<std::size_t> DeformingGeometry::find_moving(std::uint32_t vertex) const noexcept {
  const auto found = std::lower_bound(moving_vertices_.begin(), moving_vertices_.end(), vertex);
  if (found == moving_vertices_.end() || *found != vertex) return std::nullopt;
  return static_cast<std::size_t>(found - moving_vertices_.begin());
}

Vec3 DeformingGeometry::rest_of(std::uint32_t vertex) const noexcept {
  const auto moving = find_moving(vertex);
  if (!moving) return geometry_.deforming_object().vertices()[vertex];
  return {rest_coordinates_[3 * *moving], rest_coordinates_[3 * *moving + 1], rest_coordinates_[3 * *moving + 2]};
}

Vec3 DeformingGeometry::displacement_between(std::uint32_t vertex, double from_s, double to_s) const noexcept {
  const auto moving = find_moving(vertex);
  Vec3 moved = Vec3::Zero();
  if (!moving) return moved;
  const MeshDeformation::Weights from = deformation_->weights_at(from_s);
  const MeshDeformation::Weights to = deformation_->weights_at(to_s);
  for (std::size_t j = 0; j < deformation_->targets().size(); ++j) {
    const double* displacement = &displacements_[j * rest_coordinates_.size() + 3 * *moving];
    for (int k = 0; k < 3; ++k) moved[k] += (to[j] - from[j]) * displacement[k];
  }
  return moved;
}

std::size_t DeformingGeometry::bytes() const {
  std::size_t bytes =
      moving_vertices_.capacity() * sizeof(std::uint32_t) + (rest_coordinates_.capacity() + displacements_.capacity()) * sizeof(double);
  for (const WideBvh& tree : trees_) bytes += tree.bytes();
  return bytes;
}

}  // namespace hapton
