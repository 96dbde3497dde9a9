#include "haptic_step/haptics_setup.h"

#include <algorithm>

#include "haptic_step/method_text.h"
#include "runtime/build_id.h"

namespace hapton {

HapticsSetup make_haptics_setup(const std::filesystem::path& scene, const SceneLoading& loading, std::uint64_t scene_hash,
                                const MethodSettings& method) {
  HapticsSetup setup;
  setup.scene_hash = scene_hash;
  setup.scene_loading = to_code(loading);
  std::error_code error;
  const std::filesystem::path absolute = std::filesystem::absolute(scene, error);
  put_text(error ? scene.string() : absolute.lexically_normal().string(), setup.scene);
  put_text(build_id(), setup.build);
  put_text(to_text(method), setup.method);
  return setup;
}

void put_text(std::string_view text, HapticsSetup::Text& into) noexcept {
  const std::size_t room = into.size() - 1;
  if (text.size() > room) text.remove_prefix(text.size() - room);
  into = {};
  std::transform(text.begin(), text.end(), into.begin(), [](char c) {
    const bool is_printable = static_cast<unsigned char>(c) >= ' ' && c != '\x7f';
    return is_printable ? c : '?';
  });
}

}  // namespace hapton
