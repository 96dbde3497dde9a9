#include "tools/check/place_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <numbers>

#include "core/geometry/boundary_loops.h"
#include "core/geometry/point_in_mesh.h"

namespace hapton {
namespace {

bool stands_still(const SceneObject& object) { return !object.moves() && !object.is_movable && !object.sculpt; }

struct Extent {
  Vec3 low = Vec3::Zero();
  Vec3 high = Vec3::Zero();

  explicit Extent(const TriangleMesh& mesh) {
    if (mesh.vertices.empty()) return;
    low = high = mesh.vertices.front();
    for (const Vec3& v : mesh.vertices) {
      low = low.cwiseMin(v);
      high = high.cwiseMax(v);
    }
  }
  bool contains(const Vec3& p) const { return (p.array() > low.array()).all() && (p.array() < high.array()).all(); }
  bool contains(const Extent& other) const { return contains(other.low) && contains(other.high); }
};

// True for two objects of the same shape in the same place: from two files, or from one file that is used twice. Empty ones have no place.
bool coincide(const TriangleMesh& a, const TriangleMesh& b) {
  if (a.vertices.empty() || a.vertices.size() != b.vertices.size() || a.triangles != b.triangles) return false;
  const Extent extent(a);
  const double tolerance_m = 1e-9 * (extent.high - extent.low).maxCoeff();  // rounding of poses
  return std::equal(a.vertices.begin(), a.vertices.end(), b.vertices.begin(),
                    [tolerance_m](const Vec3& p, const Vec3& q) { return (p - q).norm() <= tolerance_m; });
}

// An object that may contain other objects, the camera or lights. Its inside test is built when it is first needed.
class ClosedBody {
 public:
  ClosedBody(const SceneObject& object, std::size_t index) : object_(&object), index_(index), extent_(*object.mesh) {}

  const SceneObject& object() const { return *object_; }
  std::size_t index() const { return index_; }  // in Scene::objects
  bool contains(const Vec3& p) { return extent_.contains(p) && is_closed() && inside_test_->is_inside(p); }
  bool contains(const TriangleMesh& mesh) {
    if (mesh.vertices.empty() || !extent_.contains(Extent(mesh)) || !is_closed()) return false;
    const std::size_t stride = 1 + mesh.vertices.size() / kMaxPlaces;
    for (std::size_t i = 0; i < mesh.vertices.size(); i += stride) {
      if (!inside_test_->is_inside(mesh.vertices[i])) return false;
    }
    return true;
  }

 private:
  bool is_closed() {
    if (!is_closedness_known_ && find_boundary_loops(*object_->mesh).empty()) inside_test_ = std::make_unique<PointInMesh>(*object_->mesh);
    is_closedness_known_ = true;
    return inside_test_ != nullptr;
  }

  const SceneObject* object_;
  std::size_t index_;
  Extent extent_;
  bool is_closedness_known_ = false;
  std::unique_ptr<PointInMesh> inside_test_ = {};
};

std::vector<ClosedBody> list_bodies(const Scene& scene) {
  std::vector<ClosedBody> bodies;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (stands_still(scene.objects[i])) bodies.emplace_back(scene.objects[i], i);
  }
  return bodies;
}

void check_view(const SceneView& view, std::vector<ClosedBody>& bodies, CheckFindings& findings) {
  const auto find = [&](const Vec3& p) {
    return std::find_if(bodies.begin(), bodies.end(), [&](ClosedBody& body) { return body.contains(p); });
  };
  if (view.camera) {
    const Vec3& p = view.camera->p_WE;
    if (const auto body = find(p); body != bodies.end()) {
      findings.push_back({SceneFault::view_inside, "", p,
                          fmt::format("the camera is inside object '{}', and shows it from there", body->object().name),
                          "move position_m of [camera] out of it"});
    }
  }
  for (std::size_t i = 0; i < view.lights.size(); ++i) {
    if (!view.lights[i].has_position) continue;
    const Vec3& p = view.lights[i].towards_or_p_W;
    if (const auto body = find(p); body != bodies.end()) {
      findings.push_back({SceneFault::view_inside, "", p,
                          fmt::format("[[light]] {} is inside object '{}', and does not light its outside", i + 1, body->object().name),
                          "move its position_m out of it, or give a direction"});
    }
  }
}

}  // namespace

CheckFindings check_places(const Scene& scene) {
  CheckFindings findings;
  std::vector<ClosedBody> bodies = list_bodies(scene);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const SceneObject& object = bodies[i].object();
    const auto twin = std::find_if(bodies.begin(), bodies.begin() + static_cast<std::ptrdiff_t>(i),
                                   [&](const ClosedBody& other) { return coincide(*other.object().mesh, *object.mesh); });
    if (twin != bodies.begin() + static_cast<std::ptrdiff_t>(i)) {
      findings.push_back(
          {SceneFault::coincides, object.name, object.mesh->vertices.front(),
           fmt::format("the same shape in the same place as object '{}': it is left to chance which of the two is felt and drawn",
                       twin->object().name),
           "move one of them, or leave it out", bodies[i].index()});
      continue;
    }
    const auto outer = std::find_if(bodies.begin(), bodies.end(), [&](ClosedBody& other) {
      return &other.object() != &object && !other.object().effects.layers.is_on() && other.contains(*object.mesh);
    });
    if (outer == bodies.end()) continue;
    findings.push_back(
        {SceneFault::enclosed, object.name, object.mesh->vertices.front(),
         fmt::format("altogether inside object '{}', whose surface keeps the probe out: nobody can touch it", outer->object().name),
         "move it out, or give the material of the outer one layers that give way", bodies[i].index()});
  }
  check_view(scene.view, bodies, findings);
  return findings;
}

CheckFindings check_friction(const SceneObject& object) {
  const double friction = object.material.friction_static;
  if (!(friction > kMaxFriction)) return {};
  const double degrees = std::atan(friction) * 180.0 / std::numbers::pi;
  return {
      {SceneFault::rough, object.name, std::nullopt,
       fmt::format("friction_static = {:.3g}: the tip sticks until it is pulled {:.3g} degrees away from the normal, as on no dry surface",
                   friction, degrees),
       fmt::format("give friction_static up to {:g} (0.8 is rough, 1.2 rubber)", kMaxFriction)}};
}

}  // namespace hapton
