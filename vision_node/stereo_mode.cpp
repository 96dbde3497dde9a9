#include "vision_node/stereo_mode.h"

#include <array>
#include <utility>

#include <fmt/ranges.h>

namespace hapton {
namespace {

constexpr auto kNames = std::to_array<std::pair<StereoMode, std::string_view>>({
    {StereoMode::automatic, "auto"},
    {StereoMode::mono, "mono"},
    {StereoMode::side_by_side, "side_by_side"},
    {StereoMode::top_bottom, "top_bottom"},
    {StereoMode::crystal_eyes, "crystal_eyes"},
    {StereoMode::red_blue, "red_blue"},
    {StereoMode::interlaced, "interlaced"},
    {StereoMode::left, "left"},
    {StereoMode::right, "right"},
    {StereoMode::dresden, "dresden"},
    {StereoMode::anaglyph, "anaglyph"},
    {StereoMode::checkerboard, "checkerboard"},
    {StereoMode::split_viewport, "split_viewport"},
    {StereoMode::fake, "fake"},
    {StereoMode::emulate, "emulate"},
    {StereoMode::openxr, "openxr"},
});
static_assert(kNames.size() == static_cast<std::size_t>(StereoMode::openxr) + 1, "each mode has a name; openxr is the last");

}  // namespace

std::string_view stereo_mode_name(StereoMode mode) {
  for (const auto& [known, name] : kNames) {
    if (known == mode) return name;
  }
  return "unknown";
}

std::vector<std::string> stereo_mode_names() {
  std::vector<std::string> names;
  for (const auto& [mode, name] : kNames) names.emplace_back(name);
  return names;
}

Result<StereoMode> find_stereo_mode(std::string_view name) {
  for (const auto& [mode, known] : kNames) {
    if (known == name) return mode;
  }
  return fail("unknown stereo mode '{}'; use one of: {}", name, fmt::join(stereo_mode_names(), ", "));
}

}  // namespace hapton
