#include "core/collision/touch_geometry.h"

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

Box bounds_of(const TriangleMesh& mesh) {
  Box box;
  for (const Vec3& v : mesh.vertices) box.grow(v);
  return box;
}

LocalFrame frame_of(const Box& bounds) {
  LocalFrame frame;
  if (!(bounds.low.array() <= bounds.high.array()).all()) return frame;
  frame.origin = bounds.center();
  const double diagonal = bounds.diagonal();
  if (diagonal > 0.0) frame.unit_m = std::ldexp(1.0, std::ilogb(diagonal));
  return frame;
}

}  // namespace

TouchGeometry::TouchGeometry(const std::vector<const TriangleMesh*>& meshes) : TouchGeometry(borrowed(meshes)) {}

TouchGeometry::TouchGeometry(std::vector<std::shared_ptr<const TriangleMesh>> meshes, BuildPolicy policy,
                             std::optional<double> shading_crease_rad)
    : shading_crease_rad_(shading_crease_rad), slots_(meshes.size()) {
  Box scene;
  std::size_t most_triangles = 1;
  for (const auto& mesh : meshes) {
    const Box bounds = bounds_of(*mesh);
    if ((bounds.low.array() <= bounds.high.array()).all()) {
      scene.grow(bounds.low);
      scene.grow(bounds.high);
    }
    most_triangles = std::max(most_triangles, mesh->triangles.size());
  }
  frame_ = frame_of(scene);
  units_per_m_ = 1.0 / frame_.unit_m;
  triangle_bits_ = static_cast<int>(std::bit_width(most_triangles));
  triangle_mask_ = (1U << triangle_bits_) - 1U;
  waiting_ = slots_.size();
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    Slot& slot = slots_[i];
    slot.mesh = std::move(meshes[i]);
    slot.first_id = static_cast<std::uint32_t>(i) << triangle_bits_;
    const Box bounds = bounds_of(*slot.mesh);
    slot.bounds = Box{frame_.to_local(bounds.low), frame_.to_local(bounds.high)}.inflated(0x1p-48);
  }
  if (policy == BuildPolicy::on_approach) return;
  for (Slot& slot : slots_) {
    slot.wanted = true;
    slot.built = std::make_unique<ObjectGeometry>(*slot.mesh, frame_, shading_crease_rad_);
    slot.mesh.reset();
    slot.ready = slot.built.get();
    slot.active = slot.ready;
    --waiting_;
  }
  mark_unwalkable_between_objects();
}

void TouchGeometry::mark_unwalkable_between_objects() {
  for (Slot& slot : slots_) {
    for (const Slot& other : slots_) {
      if (&slot == &other || !slot.bounds.inflated(ObjectGeometry::kWalkableMargin).overlaps(other.bounds)) continue;
      slot.built->mark_unwalkable_near(*other.built);
    }
  }
}

void TouchGeometry::clip(const Box& box, const Vec3& p, const Vec3& motion, double& from, double& until) noexcept {
  constexpr double kSlack = 0x1p-40;
  for (int k = 0; k < 3; ++k) {
    if (motion[k] == 0.0) continue;
    const double a = (box.low[k] - p[k]) / motion[k];
    const double b = (box.high[k] - p[k]) / motion[k];
    from = std::max(from, std::min(a, b) * (1.0 - kSlack) - kSlack);
    until = std::min(until, std::max(a, b) * (1.0 + kSlack) + kSlack);
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
  // To many digits, however near the plane both ends are: which of two triangles comes first decides on which side a segment arrives.
  const double from = orient3d(a, b, c, p);
  const double to = orient3d(a, b, c, q);
  return {from != to ? std::clamp(from / (from - to), 0.0, 1.0) : 1.0, side_p < 0.0};
}

void TouchGeometry::place(const Vec3& p) noexcept {
  if (waiting_ == 0) return;
  for (Slot& slot : slots_) {
    slot.encloses_start = distance_squared(slot.bounds, p) == 0.0;
    if (slot.encloses_start) slot.wanted.store(true, std::memory_order_relaxed);
  }
}

double TouchGeometry::look_ahead(const Vec3& p, double reach) noexcept {
  double may_go = std::numeric_limits<double>::infinity();
  if (waiting_ == 0) return may_go;
  for (Slot& slot : slots_) {
    if (slot.active != nullptr) continue;
    const double distance = std::sqrt(distance_squared(slot.bounds, p));
    const double near = std::max(reach, slot.bounds.diagonal());
    if (distance > near) {
      may_go = std::min(may_go, distance - near);
      continue;
    }
    slot.wanted.store(true, std::memory_order_relaxed);
    const ObjectGeometry* ready = slot.ready.load(std::memory_order_acquire);
    if (ready != nullptr && (distance > 0.0 || slot.encloses_start)) {
      slot.active = ready;
      --waiting_;
    } else {
      may_go = 0.0;
    }
  }
  return may_go;
}

bool TouchGeometry::build_wanted() {
  for (Slot& slot : slots_) {
    if (slot.built != nullptr || !slot.wanted.load(std::memory_order_relaxed)) continue;
    slot.built = std::make_unique<ObjectGeometry>(*slot.mesh, frame_, shading_crease_rad_);
    // Those built before took this one's box for it.
    for (const Slot& other : slots_) {
      if (&other == &slot || !slot.bounds.inflated(ObjectGeometry::kWalkableMargin).overlaps(other.bounds)) continue;
      if (other.built != nullptr) {
        slot.built->mark_unwalkable_near(*other.built);
      } else {
        slot.built->mark_unwalkable_near(other.bounds);
      }
    }
    slot.mesh.reset();
    slot.ready.store(slot.built.get(), std::memory_order_release);
    return true;
  }
  return false;
}

std::size_t TouchGeometry::built_count() const {
  std::size_t count = 0;
  for (const Slot& slot : slots_) count += slot.ready.load(std::memory_order_acquire) != nullptr ? 1 : 0;
  return count;
}

std::size_t TouchGeometry::triangle_count() const {
  std::size_t count = 0;
  for (const Slot& slot : slots_) {
    if (const ObjectGeometry* ready = slot.ready.load(std::memory_order_acquire)) count += ready->triangle_count();
  }
  return count;
}

std::size_t TouchGeometry::bytes() const {
  std::size_t bytes = 0;
  for (const Slot& slot : slots_) {
    if (const ObjectGeometry* ready = slot.ready.load(std::memory_order_acquire)) bytes += ready->bytes();
  }
  return bytes;
}

}  // namespace hapton
