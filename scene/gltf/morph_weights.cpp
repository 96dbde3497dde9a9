#include "scene/gltf/morph_weights.h"

#include <fmt/format.h>

namespace hapton::gltf {

Result<std::vector<double>> weights_at_rest(const Json& root, const Json& node, const std::string& where) {
  const Json& own = member(node, "weights");
  const auto mesh = index_of(member(node, "mesh"), member(root, "meshes"), where + ".mesh");
  if (!mesh) return tl::unexpected(mesh.error());
  const Json& given = own.is_null() ? member(member(root, "meshes")[*mesh], "weights") : own;
  const std::string place = own.is_null() ? fmt::format("meshes[{}].weights", *mesh) : where + ".weights";
  if (!given.is_null() && !given.is_array()) return fail("{} is not a list of numbers: {}", place, kExportAgain);
  std::vector<double> weights;
  for (const Json& each : given) {
    const double weight = each.is_number() ? each.get<double>() : NAN;
    if (!std::isfinite(weight)) return fail("{} holds something that is not a finite number: {}", place, kExportAgain);
    weights.push_back(weight);
  }
  return weights;
}

}  // namespace hapton::gltf
