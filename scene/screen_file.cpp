#include "scene/screen_file.h"

#include <algorithm>
#include <array>

#include "scene/file_bytes.h"
#include "scene/rotation_reader.h"
#include "scene/table_reader.h"

namespace hapton {
namespace {

constexpr std::string_view kScreenSchema = "hapton.screen/1";
constexpr std::size_t kMaxScreenBytes = std::size_t{1} << 20;
// Largest size and distance: more than any wall of projectors needs.
constexpr double kMaxScreenM = 100.0;
constexpr std::array<std::string_view, 6> kScreenKeys = {"schema", "position_m", "rotation", "rotation_deg", "width_m", "height_m"};

Result<ScreenRectangle> read_screen_table(const toml::table& table) {
  TableReader reader(table, "the file");
  reader.allow(kScreenKeys);
  for (const std::string_view key : {"schema", "position_m", "width_m", "height_m"}) reader.require(key);
  if (!table.contains("rotation") && !table.contains("rotation_deg")) reader.require("rotation");
  std::string schema;
  reader.read("schema", schema);
  if (!reader.error() && schema != kScreenSchema) {
    reader.fail_at("schema", "the schema is '{}', and this program reads '{}': calibrate the screen with a program of this version",
                   printable(schema), kScreenSchema);
  }
  ScreenRectangle screen;
  Vec3 position_m = Vec3::Zero();
  Quat rotation = Quat::Identity();
  reader.read("position_m", position_m, kMaxScreenM);
  read_rotation(table, reader, rotation);
  reader.read("width_m", screen.width_m, kMinSideM, kMaxScreenM);
  reader.read("height_m", screen.height_m, kMinSideM, kMaxScreenM);
  if (reader.error()) return tl::unexpected(*reader.error());
  screen.X_WR = Eigen::Translation3d(position_m) * rotation;
  return screen;
}

}  // namespace

Result<void> check_screen(const ScreenRectangle& screen) {
  const double farthest_m = screen.X_WR.translation().cwiseAbs().maxCoeff();
  if (std::max({screen.width_m, screen.height_m, farthest_m}) <= kMaxScreenM) return {};
  return fail(
      "the picture would be {:.5g} x {:.5g} m, its centre up to {:.5g} m away along an axis, and {:.0f} m are the most: give the corners "
      "in metres",
      screen.width_m, screen.height_m, farthest_m, kMaxScreenM);
}

std::string write_screen(const ScreenRectangle& screen) {
  const Vec3 p = screen.X_WR.translation();
  const Quat q(screen.X_WR.linear());
  return fmt::format(
      "schema = \"{}\"\n"
      "# The picture of vision_node on the screen, in frame W: x to the user's right, y up, z towards the user.\n"
      "position_m = [{}, {}, {}]  # of its centre\n"
      "rotation = [{}, {}, {}, {}]  # w, x, y, z\n"
      "width_m = {}\n"
      "height_m = {}\n",
      kScreenSchema, p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z(), screen.width_m, screen.height_m);
}

Result<ScreenRectangle> parse_screen(std::string_view text) {
  const auto parsed = parse_toml(text);
  if (!parsed) return tl::unexpected(parsed.error());
  return read_screen_table(*parsed);
}

Result<ScreenRectangle> read_screen(const std::filesystem::path& path) {
  const Result<std::string> bytes = read_file_bytes(path, kMaxScreenBytes);
  if (!bytes) return tl::unexpected(bytes.error());
  auto screen = parse_screen(*bytes);
  if (!screen) return fail("{}: {}", path.string(), screen.error().what);
  return screen;
}

}  // namespace hapton
