#include "tools/check/reach_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <variant>

#include "link/messages.h"

namespace hapton {
namespace {

// A scene that was fitted into the workspace touches the faces of the workspace, up to rounding.
constexpr double kRounding = 1e-9;  // share of the workspace's longest side
// Nobody misses a thousandth of a surface: scenes are often fitted to a rounded size of the workspace.
constexpr double kMinShare = 1e-3;

// A triangle cut by six planes: a convex polygon with nine corners at most.
struct Polygon {
  std::array<Vec3, 9> corners;
  std::size_t count = 0;
  void add(const Vec3& p) { corners[count++] = p; }

  double area() const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 2; i < count; ++i) sum += (corners[i - 1] - corners[0]).cross(corners[i] - corners[0]);
    return 0.5 * sum.norm();
  }
};

// The part of the polygon where sign * (p[axis] - limit) <= 0 (Sutherland & Hodgman 1974).
Polygon clip(const Polygon& polygon, int axis, double limit, double sign) {
  Polygon clipped;
  for (std::size_t i = 0; i < polygon.count; ++i) {
    const Vec3& a = polygon.corners[i];
    const Vec3& b = polygon.corners[(i + 1) % polygon.count];
    const double over_a = sign * (a[axis] - limit);
    const double over_b = sign * (b[axis] - limit);
    if (over_a <= 0.0) clipped.add(a);
    if ((over_a < 0.0 && over_b > 0.0) || (over_a > 0.0 && over_b < 0.0)) clipped.add(a + over_a / (over_a - over_b) * (b - a));
  }
  return clipped;
}

double area_in_box(const TriangleMesh& mesh, std::size_t t, const Vec3& low, const Vec3& high) {
  Polygon polygon;
  for (int k = 0; k < 3; ++k) polygon.add(mesh.corner(t, k));
  for (int axis = 0; axis < 3; ++axis) {
    polygon = clip(polygon, axis, high[axis], 1.0);
    polygon = clip(polygon, axis, low[axis], -1.0);
  }
  return polygon.area();
}

// The ball's centre is the origin. A triangle that crosses the ball is split until it is so small that its middle decides.
double area_in_ball(const std::array<Vec3, 3>& corners, double radius) {
  constexpr double kMaxReachShare = 0.005;  // largest distance from the middle to a corner, as a share of the radius; a free choice
  const auto& [a, b, c] = corners;
  const double area = 0.5 * (b - a).cross(c - a).norm();
  if (std::max({a.norm(), b.norm(), c.norm()}) <= radius) return area;
  const Vec3 middle = (a + b + c) / 3.0;
  const double reach = std::max({(a - middle).norm(), (b - middle).norm(), (c - middle).norm()});
  if (!(middle.norm() - reach <= radius)) return 0.0;  // also if it is so far away that the distance is not a number
  if (reach < kMaxReachShare * radius) return middle.norm() <= radius ? area : 0.0;
  const Vec3 ab = 0.5 * (a + b);
  const Vec3 bc = 0.5 * (b + c);
  const Vec3 ca = 0.5 * (c + a);
  return area_in_ball({a, ab, ca}, radius) + area_in_ball({ab, b, bc}, radius) + area_in_ball({ca, bc, c}, radius) +
         area_in_ball({ab, bc, ca}, radius);
}

double area_inside(const TriangleMesh& mesh, std::size_t t, const Workspace& workspace) {
  if (!(workspace.radius_m > 0.0)) return area_in_box(mesh, t, workspace.low_m, workspace.high_m);
  const Vec3 centre = workspace.middle_m();
  return area_in_ball({mesh.corner(t, 0) - centre, mesh.corner(t, 1) - centre, mesh.corner(t, 2) - centre}, workspace.radius_m);
}

// Enlarges the workspace by more than the rounding of a fitted scene.
Workspace widen(const Workspace& workspace) {
  const double margin = kRounding * workspace.longest_m();
  const Vec3 margins = Vec3::Constant(margin);
  return {workspace.low_m - margins, workspace.high_m + margins, workspace.radius_m > 0.0 ? workspace.radius_m + margin : 0.0};
}

// How far outside the workspace the target of a snap lies. For a line or plane, it is the distance from the ball around the workspace: a
// target that is reported is certainly outside, but one that misses the box and passes through that ball is not reported.
double distance_of(const SnapEffect& snap, const Workspace& workspace) {
  if (snap.target == SnapEffect::Target::point) return workspace.distance_m(snap.position);
  const Vec3 to_middle = workspace.middle_m() - snap.position;
  const double along = to_middle.dot(snap.direction);
  const bool is_plane = snap.target == SnapEffect::Target::plane;
  const double distance = is_plane ? std::fabs(along) : (to_middle - along * snap.direction).norm();
  const double farthest = workspace.radius_m > 0.0 ? workspace.radius_m : 0.5 * (workspace.high_m - workspace.low_m).norm();
  return std::max(0.0, distance - farthest);
}

}  // namespace

double Workspace::distance_m(const Vec3& p) const {
  if (radius_m > 0.0) return std::max(0.0, (p - middle_m()).norm() - radius_m);
  return (low_m - p).cwiseMax(p - high_m).cwiseMax(0.0).norm();
}

Workspace workspace_of(const DevicePreset& device) {
  return {device.limits.workspace_min_m, device.limits.workspace_max_m, device.workspace_radius_m};
}

Unreached find_unreached(const TriangleMesh& mesh, const Workspace& exact_workspace) {
  const Workspace workspace = widen(exact_workspace);
  Unreached unreached;
  std::size_t outside = 0;
  for (const Vec3& p : mesh.vertices) {
    const double distance = workspace.distance_m(p);
    outside += distance > 0.0 ? 1 : 0;
    if (distance <= unreached.distance_m) continue;
    unreached.distance_m = distance;
    unreached.farthest = p;
  }
  if (outside == 0) return unreached;
  double total_area = 0.0;
  double inside_area = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    total_area += 0.5 * (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm();
    inside_area += area_inside(mesh, t, workspace);
  }
  unreached.share = total_area > 0.0 ? std::clamp(1.0 - inside_area / total_area, 0.0, 1.0)
                                     : static_cast<double>(outside) / static_cast<double>(mesh.vertices.size());
  return unreached;
}

namespace {

// For example "all of it lies" or "12 % of its surface lies".
std::string describe_share(double share) {
  return share > 1.0 - kMinShare ? "all of it lies" : fmt::format("{:.2g} % of its surface lies", 100.0 * share);
}

// The mesh in frame S at that time. Frame M is that of the mesh as the scene file places it.
TriangleMesh moved_mesh(const SceneObject& object, double time_s) {
  TriangleMesh moved = *object.mesh;
  const Pose X_SM = object.motion->pose_at(time_s);
  for (Vec3& p : moved.vertices) p = X_SM * p;
  return moved;
}

// Pre: at rest the object is within reach. Finds the keyframe at which it is farthest outside.
CheckFindings check_reach_of_motion(const SceneObject& object, const DevicePreset& device) {
  if (object.motion == nullptr) return {};
  const Workspace workspace = widen(workspace_of(device));
  double farthest_m = 0.0;
  double time_s = 0.0;
  for (const Keyframe& keyframe : object.motion->keyframes()) {
    const Pose X_SM = object.motion->pose_at(keyframe.time_s);
    for (const Vec3& p : object.mesh->vertices) {
      const double distance_m = workspace.distance_m(X_SM * p);
      if (distance_m <= farthest_m) continue;
      farthest_m = distance_m;
      time_s = keyframe.time_s;
    }
  }
  if (farthest_m == 0.0) return {};
  const Unreached moved = find_unreached(moved_mesh(object, time_s), workspace_of(device));
  if (moved.share < kMinShare) return {};
  return {{SceneFault::out_of_reach, object.name, moved.farthest,
           fmt::format("at {:.4g} s {} outside the workspace of {}, up to {:.3g} mm", time_s, describe_share(moved.share), device.name,
                       1e3 * moved.distance_m),
           "change its keyframes, or scale the scene"}};
}

}  // namespace

CheckFindings check_reach(const SceneObject& object, const DevicePreset& device) {
  const Unreached unreached = find_unreached(*object.mesh, workspace_of(device));
  if (unreached.share < kMinShare) return check_reach_of_motion(object, device);
  return {{SceneFault::out_of_reach, object.name, unreached.farthest,
           fmt::format("{} outside the workspace of {}, up to {:.3g} mm", describe_share(unreached.share), device.name,
                       1e3 * unreached.distance_m),
           "move or scale it, or let fit_m fit the scene to the workspace"}};
}

namespace {

// Null: the effect acts everywhere, or has no volume.
const EffectVolume* volume_of(const SpaceEffect& effect) {
  return std::visit(
      [](const auto& one) -> const EffectVolume* {
        if constexpr (requires { one.volume.is_everywhere(); }) {
          return one.volume.is_everywhere() ? nullptr : &one.volume;
        } else {
          return nullptr;
        }
      },
      effect);
}

// The point of a workspace that is nearest to p.
Vec3 nearest_in(const Workspace& workspace, const Vec3& p) {
  if (!(workspace.radius_m > 0.0)) return p.cwiseMax(workspace.low_m).cwiseMin(workspace.high_m);
  const Vec3 from_middle = p - workspace.middle_m();
  const double distance = from_middle.norm();
  return distance <= workspace.radius_m ? p : Vec3(workspace.middle_m() + workspace.radius_m / distance * from_middle);
}

// The distance between the two. Both are convex, so steps to the nearest point of each in turn lead to where they are nearest to each
// other (Cheney & Goldstein 1959).
double distance_of(const EffectVolume& volume, const Workspace& workspace) {
  constexpr int kMaxIterations = 100;  // a free choice
  Vec3 p = nearest_in(workspace, volume.centre());
  for (int iteration = 0; iteration < kMaxIterations && !volume.contains(p); ++iteration) p = nearest_in(workspace, volume.nearest(p));
  return (volume.nearest(p) - p).norm();
}

CheckFindings check_volume(const SceneEffect& effect, const EffectVolume& volume, const DevicePreset& device) {
  const Workspace workspace = workspace_of(device);
  const double distance_m = distance_of(volume, workspace);
  if (distance_m <= kRounding * workspace.longest_m()) return {};
  return {{SceneFault::out_of_reach, fmt::format("effect {}", effect.name), volume.centre(),
           fmt::format("acts in a volume {:.4g} mm outside the workspace of {}: nobody can feel it", 1e3 * distance_m, device.name),
           "move it into the workspace"}};
}

// The pull is computed where the hand gets nearest to the well's centre: beyond radius_m it decreases with the distance.
CheckFindings check_well(const SceneEffect& effect, const GravityWellEffect& well, const DevicePreset& device) {
  const Vec3 nearest = nearest_in(workspace_of(device), well.centre);
  const double distance_m = (nearest - well.centre).norm();
  if (distance_m <= well.radius_m) return {};
  EffectSample sample;
  sample.p_SD = nearest;
  const double pull_n = well.force(sample).norm();
  if (pull_n >= device.model.friction_n) return {};
  return {
      {SceneFault::out_of_reach, fmt::format("effect {}", effect.name), well.centre,
       fmt::format("lies {:.4g} mm outside the workspace of {} and pulls with {:.2g} N at most there, less than its friction ({:.3g} N)",
                   1e3 * distance_m, device.name, pull_n, device.model.friction_n),
       "move it into the workspace, or raise its radius_m"}};
}

}  // namespace

CheckFindings check_reach(const SceneEffect& effect, const DevicePreset& device) {
  if (const EffectVolume* volume = volume_of(effect.effect)) return check_volume(effect, *volume, device);
  if (const auto* well = std::get_if<GravityWellEffect>(&effect.effect)) return check_well(effect, *well, device);
  const auto* snap = std::get_if<SnapEffect>(&effect.effect);
  if (snap == nullptr) return {};
  const double distance_m = distance_of(*snap, workspace_of(device));
  if (distance_m < snap->range_m) return {};
  return {{SceneFault::out_of_reach, fmt::format("effect {}", effect.name), snap->position,
           fmt::format("pulls from within {:.4g} mm, and lies {:.4g} mm outside the workspace of {}: nobody can feel it",
                       1e3 * snap->range_m, 1e3 * distance_m, device.name),
           "move it into the workspace"}};
}

CheckFindings check_size(const Scene& scene, const DevicePreset& device) {
  Eigen::AlignedBox3d box;
  for (const SceneObject& object : scene.objects) {
    for (const Vec3& p : object.mesh->vertices) box.extend(p);
  }
  const double longest = box.isEmpty() ? 0.0 : box.sizes().maxCoeff();
  const double workspace = workspace_of(device).longest_m();
  if (longest >= SceneFacts::kSpeckShare * workspace) return {};
  return {{SceneFault::too_small, "", Vec3(box.isEmpty() ? Vec3(Vec3::Zero()) : Vec3(box.center())),
           fmt::format("the scene is {:.3g} mm long, far too small for a workspace of {:.3g} mm", 1e3 * longest, 1e3 * workspace),
           "check its unit, or let fit_m fit the scene to the workspace"}};
}

}  // namespace hapton
