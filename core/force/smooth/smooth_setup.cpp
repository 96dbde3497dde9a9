// Set-up of method smooth, its exchange of sets with the slow task, and moving vertices.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/force/smooth/smooth_method.h"
#include "core/geometry/closest_point.h"
#include "core/geometry/triangle_distance.h"

namespace hapton {
namespace {

// Prediction time of the path: the slow task's period, 10 ms in haptics_node, with a margin.
constexpr double kPredictionSeconds = 0.015;
// Share of RADIUS: if less than this is left at the end of the path, a new set is requested.
constexpr double kMargin = 0.5;
// Share of the scene's diagonal: largest RADIUS derived from the data.
constexpr double kLargestRadius = 0.01;
// A distance within which a set of this size is complete nearly everywhere, with half of the set left as a margin for motion.
double make_radius(const SmoothScene& scene, std::uint32_t set_size) {
  return std::min(kLargestRadius * scene.diagonal(), scene.compute_typical_radius(std::max(1U, set_size / 2)));
}

// A line for describe() about what is not rendered as in the scene if the force builds up in a layer outside the surface; empty: nothing.
std::string note_bare_layer(const TouchScene& scene) {
  const auto has_effects = [](const TouchObject& object) {
    return object.effects.any() || object.material.friction_static > 0.0 || object.material.damping_ns_per_m > 0.0;
  };
  const auto count = std::ranges::count_if(scene.objects, has_effects);
  if (count == 0) return {};
  return fmt::format(
      "note: {} of {} object{}: their effects, damping and friction begin at the surface, and not in the layer outside of "
      "it; choose --layer 0\n",
      count, scene.objects.size(), scene.objects.size() == 1 ? "" : "s");
}

}  // namespace

Result<std::unique_ptr<ForceMethod>> SmoothMethod::make(const MethodSettings& settings, const TouchScene& scene) {
  if (settings.set_size < 16 || settings.set_size > static_cast<int>(LocalSet::kCapacity)) {
    return fail("smooth: a set of {} triangles; give 16 to {}", settings.set_size, LocalSet::kCapacity);
  }
  if (settings.probe_radius_m != 0.0) {
    return fail("smooth: the probe is a point, not a sphere of {:g} m; set its radius to 0 or choose proxy", settings.probe_radius_m);
  }
  if (!(settings.crease_deg >= 0.0 && settings.crease_deg <= 180.0)) {
    return fail("smooth: a crease angle of {:g} degrees; give 0 to 180", settings.crease_deg);
  }
  if (!(settings.smooth_radius_m >= 0.0) || !std::isfinite(settings.smooth_radius_m)) {
    return fail("smooth: the radius {:g} m is not 0 or more", settings.smooth_radius_m);
  }
  if (!(settings.smooth_layer >= 0.0 && settings.smooth_layer <= 1.0))
    return fail("smooth: the layer {:g} is a share of the radius; give 0 to 1", settings.smooth_layer);
  SmoothSceneSettings scene_settings{.surface = {}, .directions = settings.hull_directions};
  scene_settings.surface.crease_angle_rad = settings.crease_deg * std::numbers::pi / 180.0;
  scene_settings.surface.simplify_error_m = settings.simplify_m;
  auto prepared = SmoothScene::build(scene, scene_settings);
  if (!prepared) return fail("smooth: {}", prepared.error().what);
  std::unique_ptr<SmoothMethod> method(new SmoothMethod());
  method->scene_ = std::make_unique<SmoothScene>(std::move(*prepared));
  for (const TouchObject& object : scene.objects) method->materials_.push_back(object.material);
  if (settings.smooth_layer > 0.0) method->unrendered_notes_ = note_bare_layer(scene);
  method->set_size_ = static_cast<std::uint32_t>(settings.set_size);
  method->radius_ = settings.smooth_radius_m > 0.0 ? settings.smooth_radius_m : make_radius(*method->scene_, method->set_size_);
  method->layer_ = settings.smooth_layer * method->radius_;
  return std::unique_ptr<ForceMethod>(std::move(method));
}

// The scene that the slow task reads keeps the materials it was built with: it needs only whether they are two-sided.
void SmoothMethod::set_materials(std::span<const Material> materials) noexcept {
  std::copy_n(materials.begin(), std::min(materials.size(), materials_.size()), materials_.begin());
}

// ---- sets ------------------------------------------------------------------------------------------------------------

LocalSetRequest SmoothMethod::request() const noexcept {
  const Vec3& from = is_inside_ ? V_ : P_;
  Vec3 path = kPredictionSeconds * velocity_;
  // Around a path longer than the set's radius, the set's triangles would be used up along its length.
  const double length = path.norm();
  const double longest = 0.5 * std::max(set_.radius, 0.0);
  if (length > longest) path = longest > 0.0 ? Vec3(path * (longest / length)) : Vec3(Vec3::Zero());
  return {from, from + path};
}

bool SmoothMethod::prepare() {
  if (!requests_.take()) return false;
  scene_->select(requests_.value(), set_size_, sets_.draft());
  sets_.publish_draft();
  return true;
}

// Requests a set from the slow task before the current one is used up.
void SmoothMethod::request_ahead() noexcept {
  const LocalSetRequest ahead = request();
  const double radius = (1.0 + kMargin) * radius_;
  const bool is_clear = !is_inside_ && set_.clearance_at(ahead.from) > radius && set_.clearance_at(ahead.to) > radius;
  if (is_fresh() && (is_clear || (set_.radius_at(ahead.from) > radius && set_.radius_at(ahead.to) > radius))) return;
  requests_.publish(ahead);
}

void SmoothMethod::offer(const LocalSet& set) noexcept {
  has_slow_task_ = true;
  const Vec3& at = is_inside_ ? V_ : P_;
  if (set.version != scene_->version() || (is_fresh() && set.radius_at(at) <= set_.radius_at(at))) return;
  set_ = set;
  ++counters_.offered;
}

// Whether a set about p could cover more than `radius`: not if the current set was taken near p and covers no more at its own centre.
bool SmoothMethod::new_set_could_cover(const Vec3& p, double radius) const {
  return set_.radius > radius || set_.distance_to_path(p) > 0.5 * radius;
}

void SmoothMethod::select_at(const Vec3& p) noexcept {
  ++counters_.selections;
  counters_.late += has_slow_task_ ? 1 : 0;
  const LocalSetRequest ahead = request();
  scene_->select({p, p + (ahead.to - ahead.from)}, set_size_, set_);
}

Result<void> SmoothMethod::move_vertices(std::uint32_t object, std::span<const Vec3> vertices) {
  if (object >= scene_->object_count()) return scene_->move_vertices(object, vertices);
  const SmoothSurface& surface = scene_->surface(object);
  const bool is_moved = is_inside_ && T_.object == object;
  const Vec3 weights = is_moved ? closest_point(T_.corner[0], T_.corner[1], T_.corner[2], V_).barycentric : Vec3(Vec3::Zero());
  std::vector<std::array<Vec3, 3>> old_corners(has_started_ && !is_inside_ ? surface.face_count : 0);
  for (std::size_t t = 0; t < old_corners.size(); ++t)
    old_corners[t] = {surface.mesh.corner(t, 0), surface.mesh.corner(t, 1), surface.mesh.corner(t, 2)};

  const auto refitted = scene_->move_vertices(object, vertices);
  if (!refitted) return refitted;
  if (all_triangles_) use_all_triangles();
  if (is_moved) {
    T_ = scene_->triangle_at(object, T_.triangle);
    V_ = weights[0] * T_.corner[0] + weights[1] * T_.corner[1] + weights[2] * T_.corner[2];
  }
  // In the frame of a triangle that has moved, a free probe has moved the opposite way, by the motion of its closest point on the triangle.
  Hit best;
  for (std::uint32_t t = 0; t < old_corners.size(); ++t) {
    const SetTriangle moved_triangle = scene_->triangle_at(object, t);
    if (!is_face(moved_triangle)) continue;
    const ClosestPoint old_closest = closest_point(old_corners[t][0], old_corners[t][1], old_corners[t][2], P_);
    const Vec3 moved_closest = old_closest.barycentric[0] * moved_triangle.corner[0] +
                               old_closest.barycentric[1] * moved_triangle.corner[1] +
                               old_closest.barycentric[2] * moved_triangle.corner[2];
    const Vec3 from = P_ + (moved_closest - old_closest.point);
    const Vec3 old_normal = (old_corners[t][1] - old_corners[t][0]).cross(old_corners[t][2] - old_corners[t][0]);
    const double side = old_normal.dot(P_ - old_corners[t][0]) < 0.0 ? -1.0 : 1.0;
    if (side < 0.0 && !moved_triangle.two_sided) continue;
    if (side * moved_triangle.face_normal.dot(P_ - moved_triangle.corner[0]) > 0.0) continue;
    const double tolerance = scene_->tolerance();
    if (!(segment_triangle_distance_squared<double>(of3(from), of3(P_), of3(moved_triangle.corner[0]), of3(moved_triangle.corner[1]),
                                                    of3(moved_triangle.corner[2])) <= tolerance * tolerance)) {
      continue;
    }
    const ClosestPoint at = closest_point(moved_triangle.corner[0], moved_triangle.corner[1], moved_triangle.corner[2], P_);
    if (best.is_worse_than(at.distance, moved_triangle)) best = {moved_triangle, at.point, at.distance, side, true};
  }
  if (best.found) {
    ++counters_.entries;
    enter(best);
  }
  return {};
}

void SmoothMethod::use_all_triangles() {
  all_triangles_ = true;
  all_.clear();
  scene_->for_each([this](const SetTriangle& t) { all_.push_back(t); });
}

std::string SmoothMethod::describe() const {
  const SmoothCounters& c = counters_;
  std::string text = fmt::format("smooth: RADIUS {:g} m, layer {:g} m, sets of {} triangles\n", radius_, layer_, set_size_);
  text += unrendered_notes_;
  text += scene_->describe();
  text += fmt::format(
      "steps {}: {} skipped in free space, {} entries, {} releases, {} without a point on the line; {} hidden VCPs\n"
      "sets: {} selected here ({} late), {} offered by the slow task, {} queries larger than a set, answered by the tree\n",
      c.steps, c.skipped, c.entries, c.releases, c.missed_lines, c.hidden, c.selections, c.late, c.offered, c.overflows);
  return text;
}

}  // namespace hapton
