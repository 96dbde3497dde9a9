#include "core/force/smooth/smooth_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

namespace hapton {
namespace {

// Share of the scene's diagonal. Positions are accurate to 1e-15 of the diagonal (and 1e-16 of their distance from the origin).
constexpr double kTolerance = 1e-7;

}  // namespace

Result<SmoothScene> SmoothScene::build(const TouchScene& scene, const SmoothSceneSettings& settings) {
  SmoothScene built;
  built.directions_ = settings.directions;
  built.objects_.resize(scene.objects.size());
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    Object& object = built.objects_[o];
    auto surface = make_smooth_surface(*scene.objects[o].mesh, settings.surface, object.report);
    if (!surface) return fail("object {}: {}", o, surface.error().what);
    object.surface = std::move(*surface);
    object.material = scene.objects[o].material;
    object.vertex_count = scene.objects[o].mesh->vertices.size();
  }
  const auto build_with = [&]<int K>(std::integral_constant<int, K>) -> Result<void> {
    std::vector<typename FdhScene<K>::Object> views;
    for (const Object& object : built.objects_) views.push_back({object.surface.mesh.vertices, object.surface.mesh.triangles});
    auto tree = FdhScene<K>::build(views);
    if (!tree) return tl::unexpected(tree.error());
    built.tree_ = std::move(*tree);
    return {};
  };
  Result<void> done;
  switch (settings.directions) {
    case 6:
      done = build_with(std::integral_constant<int, 6>());
      break;
    case 14:
      done = build_with(std::integral_constant<int, 14>());
      break;
    case 18:
      done = build_with(std::integral_constant<int, 18>());
      break;
    case 26:
      done = build_with(std::integral_constant<int, 26>());
      break;
    default:
      return fail("hulls of {} directions are not known; choose 6, 14, 18 or 26", settings.directions);
  }
  if (!done) return tl::unexpected(done.error());
  for (Object& object : built.objects_) built.measure(object);
  built.measure_all();
  return built;
}

void SmoothScene::measure(Object& object) {
  object.bounds = Box();
  for (const Vec3& v : object.surface.mesh.vertices) object.bounds.grow(v);
}

// Uses the objects' bounds, so that after an object has moved only its own vertices need to be visited.
void SmoothScene::measure_all() {
  Box all;
  for (const Object& object : objects_) all.grow(object.bounds);
  diagonal_ = all.diagonal();
  centre_ = 0.5 * all.low + 0.5 * all.high;
  // Far from the origin the coordinates themselves are coarse.
  tolerance_ = std::max(kTolerance * diagonal_, 1e-12 * std::max(all.low.cwiseAbs().maxCoeff(), all.high.cwiseAbs().maxCoeff()));
}

SetTriangle SmoothScene::triangle_at(std::uint32_t object, std::uint32_t triangle) const noexcept {
  const Object& from = objects_[object];
  const ShadedMesh& mesh = from.surface.mesh;
  SetTriangle out;
  for (int k = 0; k < 3; ++k) {
    out.corner[k] = mesh.corner(triangle, k);
    out.normal[k] = mesh.normal(triangle, k);
  }
  out.object = object;
  out.triangle = triangle;
  out.kind = from.surface.kind(triangle);
  out.two_sided = from.material.two_sided;
  out.consistently_oriented = from.report.repair.unorientable_pieces == 0;
  if (out.kind == SurfaceKind::face) {
    const Vec3 ab = out.corner[1] - out.corner[0];
    const Vec3 ac = out.corner[2] - out.corner[0];
    const Vec3 n = ab.cross(ac);
    const double length = n.norm();
    if (length > 1e-12 * std::max({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()})) out.face_normal = n / length;
  }
  return out;
}

// An upper bound on the search radius: the farthest triangle of an earlier set of that size. Rounding may make the set smaller, but
// never incomplete.
double SmoothScene::bound_search_radius(const LocalSetRequest& request, std::uint32_t count, const LocalSet& old_set) const noexcept {
  using Three = detail::Of3<Lanes4>;
  constexpr double kRoundingFactor = 1.0 + 0x1p-20;  // far above the rounding of a distance
  if (old_set.version != version_ || old_set.count < count) return std::numeric_limits<double>::infinity();
  const Three p = detail::lanes_of(request.from);
  const std::uint32_t last = old_set.count - 1;
  Lanes4 farthest = {};
  for (std::uint32_t i = 0; i < old_set.count; i += 4) {
    const std::array<const SetTriangle*, 4> t = {&old_set.triangles[i], &old_set.triangles[std::min(i + 1, last)],
                                                 &old_set.triangles[std::min(i + 2, last)], &old_set.triangles[std::min(i + 3, last)]};
    const auto corner = [&t](std::size_t k) {
      const auto lanes = [&](int axis) {
        return Lanes4{t[0]->corner[k][axis], t[1]->corner[k][axis], t[2]->corner[k][axis], t[3]->corner[k][axis]};
      };
      return Three{lanes(0), lanes(1), lanes(2)};
    };
    farthest = detail::lane_max(farthest, triangle_distance_squared<Lanes4>(p, corner(0), corner(1), corner(2)));
  }
  const double most = std::max(std::max(farthest[0], farthest[1]), std::max(farthest[2], farthest[3]));
  return std::sqrt(most) * kRoundingFactor + tolerance_;
}

FdhVisits SmoothScene::select(const LocalSetRequest& request, std::uint32_t count, LocalSet& set) const noexcept {
  FdhNearest nearest(count, bound_search_radius(request, count, set));
  const auto search = [&] {
    return std::visit([&](const auto& tree) { return tree.collect_nearest(request.from, request.to, nearest); }, tree_);
  };
  FdhVisits visits = search();
  if (nearest.count() < count && std::isfinite(nearest.bound_squared())) {  // the old set belonged to another scene
    nearest = FdhNearest(count, std::numeric_limits<double>::infinity());
    visits = search();
  }
  const auto found = nearest.finish();
  set.from = request.from;
  set.to = request.to;
  set.radius = nearest.complete_radius();
  set.version = version_;
  set.count = 0;
  double least = std::numeric_limits<double>::infinity();
  for (const FdhNear& near : found) {
    least = std::min(least, near.distance_squared);
    set.triangles[set.count++] = triangle_at(near.object, near.triangle);
  }
  set.nearest = std::sqrt(least) * (1.0 - 1e-12) - tolerance_;
  return visits;
}

Result<void> SmoothScene::move_vertices(std::uint32_t object, std::span<const Vec3> vertices) {
  if (object >= objects_.size()) return fail("there is no object {}; the scene has {}", object, objects_.size());
  Object& moved = objects_[object];
  if (vertices.size() != moved.vertex_count) {
    return fail("object {} has {} vertices, not {}; build the scene again when a mesh itself changes", object, moved.vertex_count,
                vertices.size());
  }
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (!vertices[i].allFinite()) return fail("object {}: vertex {} is not finite", object, i);
  }
  moved.surface.move_vertices(vertices);
  ++version_;
  const auto done = std::visit([&](auto& tree) { return tree.refit(object, moved.surface.mesh.vertices); }, tree_);
  measure(moved);
  measure_all();
  return done;
}

FdhStats SmoothScene::tree_stats() const {
  return std::visit([](const auto& tree) { return tree.stats(); }, tree_);
}

double SmoothScene::compute_typical_radius(std::uint32_t count) const {
  std::vector<double> radii;
  std::size_t faces = 0;
  for (const Object& object : objects_) faces += object.surface.face_count;
  const std::size_t stride = std::max<std::size_t>(1, faces / 256);
  for (const Object& object : objects_) {
    const ShadedMesh& mesh = object.surface.mesh;
    for (std::size_t t = 0; t < object.surface.face_count; t += stride) {
      const Vec3 middle = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3.0;
      FdhNearest nearest(count, std::numeric_limits<double>::infinity());
      std::visit([&](const auto& tree) { tree.collect_nearest(middle, middle, nearest); }, tree_);
      nearest.finish();
      radii.push_back(nearest.complete_radius());
    }
  }
  if (radii.empty()) return 0.0;
  const auto low = radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 50);
  std::nth_element(radii.begin(), low, radii.end());
  return *low;
}

std::string SmoothScene::describe() const {
  std::string text;
  for (std::size_t o = 0; o < objects_.size(); ++o) {
    for (const std::string& line : objects_[o].report.lines()) {
      text += objects_.size() > 1 ? fmt::format("object {}: {}\n", o, line) : line + "\n";
    }
  }
  const FdhStats stats = tree_stats();
  text += fmt::format(
      "tree: hulls of {} directions, {} triangles ({} degenerate), {} nodes, depth {}, {:.1f} MB\n", directions_, stats.triangles,
      [this] {
        std::size_t degenerate = 0;
        for (const Object& object : objects_) degenerate += object.surface.mesh.triangles.size() - object.surface.face_count;
        return degenerate;
      }(),
      stats.nodes, stats.depth, static_cast<double>(stats.bytes) * 1e-6);
  return text;
}

}  // namespace hapton
