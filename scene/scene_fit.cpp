#include "scene/scene_fit.h"

#include <fmt/format.h>

namespace hapton {
namespace {

// For example "scaled by 0.1"; empty: the scale is 1.
std::string describe_scale(double scale) {
  const std::string digits = fmt::format("{:.4g}", scale);
  return digits == "1" ? std::string() : fmt::format("scaled by {}", digits);
}

}  // namespace

void SceneFit::apply(TriangleMesh& mesh, SealReport& sealed) const {
  for (Vec3& vertex : mesh.vertices) vertex = apply(vertex);
  scale_widths(sealed, scale);
}

void scale_widths(SealReport& sealed, double scale) {
  sealed.widest_gap *= scale;
  sealed.tolerance *= scale;
  sealed.widest_unsealed *= scale;
}

Result<SceneFit> find_fit(const Eigen::AlignedBox3d& box, const Vec3& size_m) {
  if (!(box.sizes().maxCoeff() > 0.0)) return fail("all vertices are at one point, so the scene cannot be scaled to a size");
  constexpr double kMax = 1e100;  // largest coordinate, m; 1/kMax is the least size: squares stay finite and keep their digits
  const double longest_m = box.sizes().maxCoeff();
  if (!(longest_m > 1.0 / kMax && box.min().cwiseAbs().maxCoeff() < kMax && box.max().cwiseAbs().maxCoeff() < kMax)) {
    return fail("the scene is {:.4g} m long and begins at x = {:.4g} m: it cannot be scaled to a size", longest_m, box.min().x());
  }
  return SceneFit{box.center(), (size_m.array() / box.sizes().array()).minCoeff()};
}

void note_scale(std::string_view by, const SceneFit& fit, std::vector<std::string>& notes) {
  const std::string shown = describe_scale(fit.scale);
  if (!shown.empty()) notes.push_back(fmt::format("{}: scene {}", by, shown));
}

std::string describe_fit(const std::string& path, const Eigen::AlignedBox3d& box, const SceneFit& fit) {
  const std::string shown = describe_scale(fit.scale);
  return fmt::format("{}: is {:.4g} m long, {}centred in the workspace; --no-fit leaves it as it is", path, box.sizes().maxCoeff(),
                     shown.empty() ? shown : shown + " and ");
}

}  // namespace hapton
