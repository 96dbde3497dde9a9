#include "core/collision/touch_geometry.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/math/side_sign.h"

namespace hapton {
namespace {

std::vector<std::shared_ptr<const TriangleMesh>> borrowed(const std::vector<const TriangleMesh*>& meshes) {
  std::vector<std::shared_ptr<const TriangleMesh>> shared;
  for (const TriangleMesh* mesh : meshes) shared.emplace_back(std::shared_ptr<void>(), mesh);
  return shared;
}

std::size_t most_triangles_of(const std::vector<std::shared_ptr<const TriangleMesh>>& meshes) {
  std::size_t most = 1;
  for (const auto& mesh : meshes) most = std::max(most, mesh->triangles.size());
  return most;
}

bool encloses(const Box& box, const std::vector<std::shared_ptr<const TriangleMesh>>& meshes) {
  const auto has = [&box](const Vec3& v) { return (box.low.array() <= v.array()).all() && (v.array() <= box.high.array()).all(); };
  return box.low.allFinite() && box.high.allFinite() && std::isfinite(box.diagonal()) &&
         std::all_of(meshes.begin(), meshes.end(), [&](const auto& mesh) { return std::ranges::all_of(mesh->vertices, has); });
}

constexpr int kMaxBits = 28;  // of a triangle's number: SurfaceAdjacency packs it with an edge and a side into 32 bits

// The bits for twice the number of triangles, if so many are free: sealing cracks splits triangles (ObjectGeometry::make).
int bits_for_triangles(const std::vector<std::shared_ptr<const TriangleMesh>>& meshes) {
  const int bits = static_cast<int>(std::bit_width(most_triangles_of(meshes)));
  const bool has_room = bits < kMaxBits && meshes.size() <= (std::size_t{1} << (31 - bits));
  return has_room ? bits + 1 : bits;
}

std::vector<Box> bounds_of(const std::vector<std::shared_ptr<const ObjectGeometry>>& objects) {
  std::vector<Box> bounds;
  for (const auto& object : objects) bounds.push_back(object->bounds());
  return bounds;
}

std::size_t most_triangles_of(const std::vector<std::shared_ptr<const ObjectGeometry>>& objects) {
  std::size_t most = 1;
  for (const auto& object : objects) most = std::max<std::size_t>(most, object->triangle_count());
  return most;
}

}  // namespace

Box TouchGeometry::local_bounds(const LocalFrame& frame, const Box& bounds) {
  if (bounds.is_empty()) return bounds;
  return Box{frame.to_local(bounds.low), frame.to_local(bounds.high)}.inflated(0x1p-48);
}

LocalFrame TouchGeometry::frame_of(const Box& bounds) {
  LocalFrame frame;
  if (bounds.is_empty()) return frame;
  frame.origin = bounds.centre();
  const double diagonal = bounds.diagonal();
  if (diagonal > 0.0) frame.unit_m = std::ldexp(1.0, std::ilogb(diagonal));
  return frame;
}

std::size_t TouchGeometry::most_triangles(const std::vector<std::shared_ptr<const TriangleMesh>>& meshes) {
  return (std::size_t{1} << bits_for_triangles(meshes)) - 1;
}

Result<void> TouchGeometry::check(const std::vector<std::shared_ptr<const TriangleMesh>>& meshes, const Box& part_of) {
  if (!part_of.is_empty() && !encloses(part_of, meshes)) {
    return fail("the box given for the whole scene does not contain this part: give a larger box, or none");
  }
  if (part_of.is_empty()) {  // a box that encloses the meshes has shown it already
    const auto is_finite = [](const auto& mesh) {
      return std::ranges::all_of(mesh->vertices, [](const Vec3& v) { return v.allFinite(); });
    };
    if (const auto bad = std::ranges::find_if_not(meshes, is_finite); bad != meshes.end()) {
      return fail("object {} of {} has a vertex that is not finite: every coordinate must be a number", bad - meshes.begin() + 1,
                  meshes.size());
    }
  }
  const std::size_t most = most_triangles_of(meshes);
  const int bits = static_cast<int>(std::bit_width(most));
  if (bits <= kMaxBits && meshes.size() <= (std::size_t{1} << (32 - bits))) return {};
  return fail(
      "{} objects, the largest with {} triangles, are too many; with an object of this size a scene may have {} objects: join small ones",
      meshes.size(), most, bits <= kMaxBits ? std::size_t{1} << (32 - bits) : 0);
}

TouchGeometry::TouchGeometry(const std::vector<const TriangleMesh*>& meshes) : TouchGeometry(borrowed(meshes)) {}

TouchGeometry::TouchGeometry(std::vector<std::shared_ptr<const TriangleMesh>> meshes, BuildPolicy policy,
                             std::optional<double> shading_crease_rad, const Box& part_of)
    : shading_crease_rad_(shading_crease_rad),
      policy_(policy),
      triangle_bits_(bits_for_triangles(meshes)),
      triangle_mask_((1U << triangle_bits_) - 1U),
      active_(meshes.size(), nullptr),
      slots_(meshes.size()),
      requested_(meshes.size()),
      finished_(meshes.size()),
      enclosing_(meshes.size()) {
  std::vector<Box> bounds;
  Box scene;
  for (const auto& mesh : meshes) {
    bounds.push_back(policy == BuildPolicy::to_deform ? part_of : Box::of(mesh->vertices));
    scene.grow(bounds.back());
  }
  frame_ = frame_of(part_of.is_empty() ? scene : part_of);
  units_per_m_ = 1.0 / frame_.unit_m;
  std::vector<Box> approach;
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    slots_[i].mesh = std::move(meshes[i]);
    approach.emplace_back();
    if (bounds[i].is_empty()) continue;
    bounds[i] = local_bounds(frame_, bounds[i]);
    slots_[i].size = bounds[i].diagonal();
    approach[i] = bounds[i].inflated(slots_[i].size);
    ++waiting_count_;
  }
  hierarchy_ = ObjectHierarchy(bounds);
  if (policy == BuildPolicy::on_approach) {
    approach_ = ObjectHierarchy(approach);
    return;
  }
  for (std::uint32_t i = 0; i < slots_.size(); ++i) {
    request(i);
    build_requested();
    active_[i] = slots_[i].built.get();
  }
  active_count_ = received_count_ = static_cast<std::uint32_t>(slots_.size());
  waiting_count_ = 0;
  for (std::uint32_t i = 0; i < slots_.size(); ++i) mark_unwalkable_near_others(i);
}

TouchGeometry::TouchGeometry(std::vector<std::shared_ptr<const ObjectGeometry>> objects, const LocalFrame& frame)
    : TouchGeometry(objects, bounds_of(objects), frame, static_cast<int>(std::bit_width(most_triangles_of(objects)))) {}

TouchGeometry::TouchGeometry(const BuiltObjects& built)
    : TouchGeometry(built.objects, built.bounds, built.frame, bits_for_triangles(built.meshes)) {}

TouchGeometry::TouchGeometry(std::vector<std::shared_ptr<const ObjectGeometry>> objects, std::span<const Box> bounds,
                             const LocalFrame& frame, int triangle_bits)
    : frame_(frame),
      units_per_m_(1.0 / frame.unit_m),
      triangle_bits_(triangle_bits),
      triangle_mask_((1U << triangle_bits_) - 1U),
      hierarchy_(bounds),
      slots_(objects.size()),
      finished_(objects.size()),
      finished_count_(static_cast<std::uint32_t>(objects.size())),
      received_count_(static_cast<std::uint32_t>(objects.size())),
      active_count_(objects.size()) {
  for (std::uint32_t i = 0; i < slots_.size(); ++i) {
    active_.push_back(objects[i].get());
    slots_[i].shared = std::move(objects[i]);
    finished_[i] = i;
  }
}

void TouchGeometry::mark_unwalkable_near_others(std::uint32_t object) {
  ObjectGeometry& own = *slots_[object].built;
  const Box& bounds = hierarchy_.bounds(object);
  hierarchy_.for_each_overlapping(bounds.inflated(ObjectGeometry::kWalkableMargin), [&](std::uint32_t other) {
    if (other == object) return;
    if (slots_[other].built != nullptr) {
      own.mark_unwalkable(own.find_near(*slots_[other].built, bounds));
    } else {
      own.mark_unwalkable_near(hierarchy_.bounds(other));
    }
  });
}

void TouchGeometry::clip(const Box& box, const Vec3& p, const Vec3& motion, double& from, double& until) noexcept {
  constexpr double kRounding = 0x1p-40;  // far above the rounding of a quotient: a slightly longer part of the motion is searched
  for (int k = 0; k < 3; ++k) {
    if (motion[k] == 0.0) continue;
    const double a = (box.low[k] - p[k]) / motion[k];
    const double b = (box.high[k] - p[k]) / motion[k];
    from = std::max(from, std::min(a, b) * (1.0 - kRounding) - kRounding);
    until = std::min(until, std::max(a, b) * (1.0 + kRounding) + kRounding);
  }
}

TouchGeometry::Hit TouchGeometry::pierce(std::uint32_t id, const Vec3& p, const Vec3& q) const noexcept {
  const auto [a, b, c, vertices] = corners(id);
  const double side_p = side_sign(a, b, c, p);
  const double side_q = side_sign(a, b, c, q);
  if ((side_p > 0.0) == (side_q > 0.0)) return {};
  const double ab = pass_sign(p, q, a, b);
  const double bc = pass_sign(p, q, b, c);
  const double ca = pass_sign(p, q, c, a);
  const bool none_below = ab >= 0.0 && bc >= 0.0 && ca >= 0.0;
  const bool none_above = ab <= 0.0 && bc <= 0.0 && ca <= 0.0;
  if (!none_below && !none_above) return {};
  // The parameter comes from exact determinants, not from side_p and side_q. It must be accurate even if both ends are near the plane,
  // because the order in which a segment passes two triangles decides on which side it arrives.
  const double from = orient3d(a, b, c, p);
  const double to = orient3d(a, b, c, q);
  return {from != to ? std::clamp(from / (from - to), 0.0, 1.0) : 1.0, side_p < 0.0};
}

void TouchGeometry::place_probe(const Vec3& p) noexcept {
  if (waiting_count_ == 0) return;
  ++placement_number_;
  hierarchy_.for_each_overlapping(Box{p, p}, [&](std::uint32_t o) {
    slots_[o].placed_in = placement_number_;
    request(o);
  });
}

void TouchGeometry::request(std::uint32_t object) noexcept {
  if (slots_[object].is_requested) return;
  slots_[object].is_requested = true;
  const std::uint32_t at = requested_count_.load(std::memory_order_relaxed);
  requested_[at] = object;
  requested_count_.store(at + 1, std::memory_order_release);
}

double TouchGeometry::request_ahead(const Vec3& p, double range) noexcept {
  if (waiting_count_ == 0) return std::numeric_limits<double>::infinity();
  activate(p);
  // Every object's distance shrinks by at most the motion of p; the range it is compared with grows by at most the change of `range`.
  double travelled = (p - searched_from_).norm() + std::max(0.0, range - searched_range_);
  if (!(travelled < unrequested_distance_)) {
    find_unrequested(p, range);
    travelled = 0.0;
  }
  const bool is_any_pending = requested_count_.load(std::memory_order_relaxed) > active_count_;
  return is_any_pending ? 0.0 : unrequested_distance_ - travelled;
}

// Activates objects that were built since the last call, and those whose bounds the probe has left.
void TouchGeometry::activate(const Vec3& p) noexcept {
  const std::uint32_t finished = finished_count_.load(std::memory_order_acquire);
  while (received_count_ < finished) enclosing_[enclosing_count_++] = finished_[received_count_++];
  for (std::size_t i = 0; i < enclosing_count_;) {
    const std::uint32_t o = enclosing_[i];
    const bool encloses_start = placement_number_ > 0 && slots_[o].placed_in == placement_number_;
    if (!(hierarchy_.bounds(o).distance_squared(p) > 0.0) && !encloses_start) {
      ++i;
      continue;
    }
    active_[o] = slots_[o].built.get();
    ++active_count_;
    --waiting_count_;
    enclosing_[i] = enclosing_[--enclosing_count_];
  }
}

// Finds how far p may move until an object that was not requested yet comes within reach (`range`, or the object's size if that is more).
// The search visits boxes grown by each object's size: their distances are at most those of the objects less their sizes.
void TouchGeometry::find_unrequested(const Vec3& p, double range) noexcept {
  searched_from_ = p;
  searched_range_ = range;
  unrequested_distance_ = std::numeric_limits<double>::infinity();
  approach_.visit_nearest(p, unrequested_distance_, [&](std::uint32_t o, double bound) {
    if (slots_[o].is_requested) return bound;
    const double beyond = std::sqrt(hierarchy_.bounds(o).distance_squared(p)) - std::max(range, slots_[o].size);
    if (!(beyond > 0.0)) {
      request(o);
      return bound;
    }
    unrequested_distance_ = std::min(unrequested_distance_, beyond);
    const double farthest = range + unrequested_distance_;
    return std::min(bound, farthest * farthest);
  });
}

bool TouchGeometry::build_requested() {
  if (next_request_ == requested_count_.load(std::memory_order_acquire)) return false;
  const std::uint32_t o = requested_[next_request_++];
  Slot& slot = slots_[o];
  slot.built = policy_ == BuildPolicy::to_deform
                   ? std::make_unique<ObjectGeometry>(*slot.mesh, frame_, shading_crease_rad_, &new_vertex_)
                   : std::make_unique<ObjectGeometry>(ObjectGeometry::make(*slot.mesh, frame_, triangle_mask_, shading_crease_rad_));
  // Objects that are not built yet are represented by their boxes; those built before have taken the box of this one into account.
  if (approach_.object_count() > 0) mark_unwalkable_near_others(o);
  slot.mesh.reset();
  const std::uint32_t at = finished_count_.load(std::memory_order_relaxed);
  finished_[at] = o;
  finished_count_.store(at + 1, std::memory_order_release);
  return true;
}

bool TouchGeometry::may_have_large_fans() const {
  bool any = built_count() < object_count();
  for (std::size_t i = 0, n = built_count(); i < n; ++i) any = any || object_geometry(finished_[i]).adjacency().has_large_fans();
  return any;
}

std::size_t TouchGeometry::triangle_count() const {
  std::size_t count = 0;
  for (std::size_t i = 0, n = built_count(); i < n; ++i) count += object_geometry(finished_[i]).triangle_count();
  return count;
}

std::size_t TouchGeometry::bytes() const {
  std::size_t bytes = hierarchy_.bytes() + approach_.bytes();
  for (std::size_t i = 0, n = built_count(); i < n; ++i) bytes += object_geometry(finished_[i]).bytes();
  return bytes;
}

}  // namespace hapton
