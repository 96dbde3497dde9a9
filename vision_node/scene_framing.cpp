#include "vision_node/scene_framing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "core/geometry/mesh_measures.h"
#include "link/messages.h"
#include "vision_node/camera_view.h"
#include "vision_node/depth_cues.h"
#include "vision_node/knob_box.h"

namespace hapton {
namespace {

// Smallest framed radius, so that even a scene of one point gives a picture.
constexpr double kMinRadius = 1e-6;
// A scene lies apart if its middle is farther from the workspace's centre than the workspace's radius and kApartRadii of its own radii: a
// sphere round that centre would be mostly empty. Beyond kFarApart times the sum of both radii, a picture of both would show neither.
constexpr double kApartRadii = 2.0;
constexpr double kFarApart = 10.0;
// Leaves some space around the workspace.
constexpr double kMargin = 1.04;
constexpr int kFitIterations = 8;

double workspace_radius_m() { return 0.5 * workspace_size_m().norm(); }

// Frames a sphere around the workspace's centre that contains the scene.
Framing frame_in_workspace(const Scene& scene, double ipd_m) {
  double squared_radius = kMinRadius * kMinRadius;
  for (const SceneObject& object : scene.objects) {
    for (const Vec3& p_S : object.mesh->vertices) squared_radius = std::max(squared_radius, p_S.squaredNorm());
  }
  return frame_sphere(Vec3::Zero(), std::sqrt(squared_radius), ipd_m);
}

Framing frame_with_workspace(const Vec3& p_WO, double radius_m, double ipd_m) {
  const double distance_m = p_WO.norm();
  const double from_m = std::min(-workspace_radius_m(), distance_m - radius_m);
  const double to_m = std::max(workspace_radius_m(), distance_m + radius_m);
  return frame_sphere(0.5 * (from_m + to_m) * p_WO / distance_m, 0.5 * (to_m - from_m), ipd_m);
}

// Widens the view until the picture shows all points as well as the present disc, and moves the screen in its plane until they are in the
// middle.
void fit(Framing& framing, PictureSize size, std::span<const Eye> eyes, const std::vector<Vec3>& points) {
  const Vec2 disc = Vec2::Constant(0.5 * framing.view_m);
  const double narrow_px = std::min(size.width_px, size.height_px);
  const Vec2 sides = Vec2(size.width_px, size.height_px) / narrow_px;
  // The eye moves with the screen, which shifts nearer points: each iteration leaves a small part of the error.
  for (int turn = 0; turn < kFitIterations; ++turn) {
    Vec2 low = -disc;
    Vec2 high = disc;
    const StereoScreen screen = compute_screen(framing, size);
    for (const Eye eye : eyes) {
      for (const Vec3& p_W : points) {
        const Vec2 from_middle = project_to_pixel(screen, eye, size, p_W) - Vec2(0.5 * size.width_px, 0.5 * size.height_px);
        const Vec2 at_m = framing.centre_offset_m + framing.view_m / narrow_px * from_middle;
        low = low.cwiseMin(at_m);
        high = high.cwiseMax(at_m);
      }
    }
    framing.centre_offset_m = 0.5 * (low + high);
    framing.view_m = (high - low).cwiseQuotient(sides).maxCoeff() * kMargin;
  }
}

std::vector<Vec3> workspace_corners() {
  std::vector<Vec3> corners;
  for (const auto& edge : make_workspace_box()) corners.insert(corners.end(), edge.begin(), edge.end());
  return corners;
}

// Mode `auto` uses one eye on an ordinary screen. On others, where it uses two, little of the workspace is cut off.
std::span<const Eye> eyes_of(StereoMode mode) {
  static constexpr std::array<Eye, 1> kOne = {Eye::centre};
  static constexpr std::array<Eye, 2> kTwo = {Eye::left, Eye::right};
  return mode == StereoMode::mono || mode == StereoMode::automatic || mode == StereoMode::openxr ? std::span<const Eye>(kOne)
                                                                                                 : std::span<const Eye>(kTwo);
}

PictureSize eye_size(const ViewSettings& view) {
  return {view.stereo == StereoMode::side_by_side ? view.width_px / 2 : view.width_px, view.height_px};
}

Pose start_pose(const VisionOptions& options) {
  Dials dials;
  for (int axis = 0; axis < 3; ++axis) dials.turn(axis, options.dials_degrees[axis]);
  return dials.compute_pose(Vec3::Zero());
}

// Frames in true size: the scene and the workspace stay where they are.
Framing frame_on_screen(const Scene& scene, const VisionOptions& options) {
  Framing framing = frame_in_workspace(scene, 1e-3 * options.ipd_mm);
  framing.distance_m = kDeskDistance;
  framing.ipd_m = 1e-3 * options.ipd_mm;
  framing.depth_m = std::max(framing.depth_m, 2.0 * workspace_radius_m());
  framing.view_m = std::min({Framing().view_m, options.screen->width_m, options.screen->height_m});  // the probe is drawn as at a desk
  framing.screen = options.screen;
  framing.head = options.head;
  return framing;
}

// Sets yaw, pitch and roll for a screen with that normal, whose y axis is as near to `up` as possible.
void turn_to(const Vec3& towards_viewer, const Vec3& up, Framing& framing) {
  const Vec3 z = towards_viewer.normalized();
  const Vec3 x = up.cross(z).normalized();
  const Vec3 y = z.cross(x);
  const double steepness = std::clamp(z.y(), -1.0, 1.0);
  framing.pitch_rad = std::clamp(std::asin(steepness), -kSteepestPitch, kSteepestPitch);
  // From straight above or below, yaw and roll turn about the same axis: the picture's top, or its bottom, gives the yaw.
  const bool is_steep = std::abs(std::asin(steepness)) > kSteepestPitch;
  const Vec3 ahead = !is_steep ? z : steepness > 0.0 ? Vec3(-y) : y;
  framing.yaw_rad = std::atan2(ahead.x(), ahead.z());
  if (is_steep) return;
  const Vec3 level(std::cos(framing.yaw_rad), 0.0, -std::sin(framing.yaw_rad));
  framing.roll_rad = std::atan2(level.cross(x).dot(z), level.dot(x));
}

// The distance of the eyes grows with the viewing distance, so depth looks the same at every scale.
Framing frame_by_camera(const SceneCamera& camera, const Scene& scene, const VisionOptions& options) {
  Framing framing;
  framing.p_WC = camera.p_WC;
  framing.distance_m = (camera.p_WE - camera.p_WC).norm();
  framing.ipd_m = 1e-3 * options.ipd_mm * framing.distance_m / kDeskDistance;
  framing.view_m = 2.0 * framing.distance_m * std::tan(0.5 * camera.view_angle_deg * std::numbers::pi / 180.0);
  turn_to(camera.p_WE - camera.p_WC, camera.up, framing);
  // The depth is enough for the scene in every position of the dials.
  double squared_radius = workspace_radius_m() * workspace_radius_m();
  for (const SceneObject& object : scene.objects) {
    for (const Vec3& p_S : object.mesh->vertices) squared_radius = std::max(squared_radius, p_S.squaredNorm());
  }
  framing.depth_m = std::sqrt(squared_radius) + camera.p_WC.norm();
  if (options.is_view_yaw_given) framing.yaw_rad = options.view_yaw_deg * std::numbers::pi / 180.0;
  if (options.is_view_pitch_given) framing.pitch_rad = options.view_pitch_deg * std::numbers::pi / 180.0;
  if (options.view_mm > 0.0) framing.view_m = options.view_mm * 1e-3;
  framing.head = options.head;
  return framing;
}

}  // namespace

SceneSphere bound_scene(const Scene& scene) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  for (const SceneObject& object : scene.objects) {
    const MeshBounds bounds = compute_bounds(*object.mesh);
    low = low.cwiseMin(bounds.low);
    high = high.cwiseMax(bounds.high);
  }
  if (!(low.array() <= high.array()).all()) return {};
  SceneSphere sphere{0.5 * (low + high), 0.0};
  double squared = 0.0;
  for (const SceneObject& object : scene.objects) {
    for (const Vec3& p_S : object.mesh->vertices) squared = std::max(squared, (p_S - sphere.p_SO).squaredNorm());
  }
  sphere.radius_m = std::sqrt(squared);
  return sphere;
}

Framing frame_scene(const Scene& scene, const VisionOptions& options) {
  if (options.screen) return frame_on_screen(scene, options);
  if (scene.view.camera && find_view_flag(options).empty()) return frame_by_camera(*scene.view.camera, scene, options);
  const double ipd_m = options.ipd_mm * 1e-3;
  const SceneSphere sphere = bound_scene(scene);
  const double radius_m = std::max(kMinRadius, sphere.radius_m);
  const Vec3 p_WO = start_pose(options) * sphere.p_SO;
  const double distance_m = p_WO.norm();
  const bool is_speck = 2.0 * radius_m < SceneFacts::kSpeckShare * workspace_size_m().maxCoeff();
  const bool is_apart = distance_m > std::max(workspace_radius_m(), kApartRadii * radius_m);
  const bool is_far = distance_m > kFarApart * (radius_m + workspace_radius_m());
  Framing framing = is_speck || is_far ? frame_sphere(p_WO, radius_m, ipd_m)
                    : is_apart         ? frame_with_workspace(p_WO, radius_m, ipd_m)
                                       : frame_in_workspace(scene, ipd_m);
  framing.yaw_rad = options.view_yaw_deg * std::numbers::pi / 180.0;
  framing.pitch_rad = options.view_pitch_deg * std::numbers::pi / 180.0;
  if (!is_speck && !is_far) fit(framing, eye_size(options.view), eyes_of(options.view.stereo), workspace_corners());
  if (options.view_mm > 0.0) framing.view_m = options.view_mm * 1e-3;
  framing.screen_width_m = options.screen_width_mm * 1e-3;
  framing.head = options.head;
  return framing;
}

std::string_view find_view_flag(const VisionOptions& options) {
  if (options.screen) return "--screen";
  if (options.screen_width_mm > 0.0) return "--screen-width-mm";
  if (options.view.stereo == StereoMode::openxr) return "--stereo openxr";
  return options.head_source.tracker || options.has_space_head ? "--head" : "";
}

}  // namespace hapton
