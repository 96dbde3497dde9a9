#include "scene/scene_loading.h"

#include <fmt/core.h>

namespace hapton {
namespace {

constexpr std::uint32_t kKnownBit = 1;
constexpr std::uint32_t kSealedBit = 2;
constexpr std::uint32_t kFittedBit = 4;
constexpr std::uint32_t kUnitShift = 3;  // the unit is in the bits from this one on: 0 for no unit, otherwise 1 + its number
constexpr std::uint32_t kUnits = static_cast<std::uint32_t>(Unit::in) + 1;

}  // namespace

std::uint32_t to_code(const SceneLoading& loading) {
  std::uint32_t code = kKnownBit;
  if (loading.sealing == CrackSealing::on) code |= kSealedBit;
  if (loading.fit == MeshFit::workspace) code |= kFittedBit;
  if (loading.unit) code |= (static_cast<std::uint32_t>(*loading.unit) + 1) << kUnitShift;
  return code;
}

std::optional<SceneLoading> from_code(std::uint32_t code) {
  const std::uint32_t unit = code >> kUnitShift;
  if ((code & kKnownBit) == 0 || unit > kUnits) return std::nullopt;
  SceneLoading loading;
  loading.sealing = (code & kSealedBit) != 0 ? CrackSealing::on : CrackSealing::off;
  loading.fit = (code & kFittedBit) != 0 ? MeshFit::workspace : MeshFit::off;
  if (unit > 0) loading.unit = static_cast<Unit>(unit - 1);
  return loading;
}

std::string describe_loading(std::uint32_t code) {
  const auto loading = from_code(code);
  if (!loading) return {};
  return fmt::format("unit {}, cracks {}{}", loading->unit ? name_of(*loading->unit) : "of the file",
                     loading->sealing == CrackSealing::on ? "sealed" : "left open",
                     loading->fit == MeshFit::workspace ? ", mesh files fitted to the workspace" : "");
}

}  // namespace hapton
