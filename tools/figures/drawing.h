#pragma once

#include <fmt/format.h>

#include <iterator>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/force/force_method.h"
#include "tools/figures/figures.h"

// Most figures are cross-sections: the scene is a prism along z, and the probe moves in the plane z = kSlice, which is not 0, because there
// triangles may share an edge. Lengths are drawn in millimetres.
namespace hapton::figures {

using Outline = std::vector<Eigen::Vector2d>;

constexpr double kSlice = 0.0013;  // m; see above
constexpr double kPi = 3.14159265358979323846;

constexpr const char* kBlue = "#0050c8";
constexpr const char* kRed = "#d02020";
constexpr const char* kGreen = "#009e60";
constexpr const char* kOrange = "#d07000";
constexpr const char* kSolid = "#dcdcd4";

// The points of one data block of gnuplot: given in metres, written in millimetres.
class Points {
 public:
  Points& add(const Vec3& p) {
    fmt::format_to(std::back_inserter(text_), "{:.6g} {:.6g}\n", 1e3 * p.x(), 1e3 * p.y());
    return *this;
  }
  Points& add(const Vec3& from, const Vec3& motion) {  // for gnuplot's style `vectors`
    fmt::format_to(std::back_inserter(text_), "{:.6g} {:.6g} {:.6g} {:.6g}\n", 1e3 * from.x(), 1e3 * from.y(), 1e3 * motion.x(),
                   1e3 * motion.y());
    return *this;
  }
  // Ends a line: the next point is not connected with the last.
  Points& gap() {
    text_ += "\n";
    return *this;
  }
  Points& line(const Vec3& from, const Vec3& to) { return add(from).add(to).gap(); }
  std::string block(std::string_view name) const { return fmt::format("${} << EOD\n{}EOD\n", name, text_); }

 private:
  std::string text_;
};

// The outline as a closed line.
inline Points outline_of(const Outline& outline) {
  Points points;
  for (const auto& p : outline) points.add({p.x(), p.y(), 0.0});
  return points.add({outline.front().x(), outline.front().y(), 0.0});
}

// The first lines of a script that writes NAME.png.part, of this size in pixels.
inline std::string begin(std::string_view name, int width, int height) {
  return fmt::format(
      "set terminal pngcairo size {},{} font 'sans,13' background '#ffffff'\n"
      "set output '{}.png.part'\n"
      "set border 3 linecolor rgb '#909090'\n"
      "set tics nomirror textcolor rgb '#404040'\n"
      "set key below height 1.2 samplen 2 width 1 textcolor rgb '#202020'\n",
      width, height, name);
}

inline TouchScene scene_of(TriangleMesh mesh) {
  TouchScene scene;
  scene.objects.push_back({std::make_shared<TriangleMesh>(std::move(mesh)), Material{}});
  return scene;
}

// A point in the plane of the cross-section.
inline Vec3 at(double x_mm, double y_mm) { return {1e-3 * x_mm, 1e-3 * y_mm, kSlice}; }

// The device point, m, and the output of the method there.
struct Sample {
  Vec3 device;
  MethodOutput output;
};

// Runs a new method along the path, one step of 1 ms for each point.
inline Result<std::vector<Sample>> follow(const MethodSettings& settings, const TouchScene& scene, const std::vector<Vec3>& path) {
  auto method = make_method(settings, scene);
  if (!method) return tl::unexpected(method.error());
  (*method)->reset(path.front());
  std::vector<Sample> samples;
  for (const Vec3& p : path) samples.push_back({p, (*method)->step({p, 1e-3})});
  return samples;
}

Result<Figure> draw_hulls();           // hull_figure.cpp
Result<Figure> draw_contact_offset();  // contact_offset_figure.cpp

}  // namespace hapton::figures
