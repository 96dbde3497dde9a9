#include "scene/view_reader.h"

#include "scene/object_reader.h"

namespace hapton {
namespace {

constexpr double kMinViewAngleDeg = 1.0;
constexpr double kMaxViewAngleDeg = 120.0;
constexpr double kMaxIntensity = 10.0;
// Smallest sine of the angle between `up` and the line of sight. Below it, `up` gives no clear direction in the picture. It is far above
// the rounding of numbers that people write.
constexpr double kMinUprightness = 1e-3;

Result<SceneCamera> read_camera(const toml::table& table) {
  SceneCamera camera;
  TableReader reader(table, "[camera]");
  reader.allow({"position_m", "look_at_m", "up", "view_angle_deg"});
  reader.require("position_m");
  reader.read("position_m", camera.p_WE, kMaxLengthM);
  reader.read("look_at_m", camera.p_WC, kMaxLengthM);
  reader.read_direction("up", camera.up);
  reader.read("view_angle_deg", camera.view_angle_deg, kMinViewAngleDeg, kMaxViewAngleDeg);
  if (camera.p_WE == camera.p_WC) {
    reader.fail_at("position_m", "'position_m' in [camera] is the point that it looks at: move one of them");
  }
  if (!reader.error() && (camera.p_WE - camera.p_WC).normalized().cross(camera.up).norm() < kMinUprightness) {
    reader.fail_at("up", "[camera] looks along 'up' ([0, 1, 0] by default): give another direction for 'up', such as [0, 0, -1]");
  }
  if (reader.error()) return tl::unexpected(*reader.error());
  return camera;
}

Result<SceneLight> read_light(const toml::table& table, const std::string& where) {
  SceneLight light;
  TableReader reader(table, where);
  reader.allow({"direction", "position_m", "color", "intensity"});
  light.has_position = reader.has("position_m");
  if (light.has_position == reader.has("direction")) {
    reader.fail_at("position_m", "{} needs either 'direction', in which it shines, or 'position_m', from where it shines", where);
  }
  Vec3 shines = -Vec3::UnitY();
  reader.read_direction("direction", shines);
  light.towards_or_p_W = -shines;
  if (light.has_position) reader.read("position_m", light.towards_or_p_W, kMaxLengthM);
  std::array<double, 3> colour = {1.0, 1.0, 1.0};
  reader.read("color", colour, 0.0, 1.0);
  double intensity = 1.0;
  reader.read("intensity", intensity, 0.0, kMaxIntensity);
  light.colour = intensity * Vec3(colour.data());
  if (reader.error()) return tl::unexpected(*reader.error());
  return light;
}

Result<void> read_lights(const toml::node& node, std::vector<SceneLight>& lights) {
  const toml::array* tables = node.as_array();
  if (tables == nullptr || !tables->is_array_of_tables()) {
    return fail("{}'light' must be tables that begin with [[light]]", line_prefix(node));
  }
  for (const toml::node& table : *tables) {
    const auto light = read_light(*table.as_table(), fmt::format("[[light]] {}", lights.size() + 1));
    if (!light) return tl::unexpected(light.error());
    if (lights.size() == SceneView::kMaxLights) {
      return fail("{}there are more than {} [[light]] tables: leave some out", line_prefix(table), SceneView::kMaxLights);
    }
    lights.push_back(*light);
  }
  return {};
}

}  // namespace

Result<SceneView> read_view(const toml::table& scene) {
  SceneView view;
  if (const toml::node* node = scene.get("camera")) {
    if (!node->is_table()) return fail("{}'camera' must be one table [camera]", line_prefix(*node));
    const auto camera = read_camera(*node->as_table());
    if (!camera) return tl::unexpected(camera.error());
    view.camera = *camera;
  }
  if (const toml::node* node = scene.get("light")) {
    if (const auto read = read_lights(*node, view.lights); !read) return tl::unexpected(read.error());
  }
  return view;
}

}  // namespace hapton
