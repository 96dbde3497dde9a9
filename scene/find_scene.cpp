#include "scene/find_scene.h"

#include <system_error>

namespace hapton {

std::filesystem::path find_scene(const std::filesystem::path& named) {
  std::error_code error;
  return find_scene(named, std::filesystem::read_symlink("/proc/self/exe", error).parent_path());
}

std::filesystem::path find_scene(const std::filesystem::path& named, const std::filesystem::path& program_folder) {
  std::error_code error;
  if (named.is_absolute() || std::filesystem::exists(named, error)) return named;
  // Beside an installed program, or in the source tree of a program in build/PRESET/bin.
  for (const char* root : {"../share/hapton", "../../.."}) {
    const auto found = (program_folder / root / named).lexically_normal();
    if (std::filesystem::exists(found, error)) return found;
  }
  return named;
}

}  // namespace hapton
