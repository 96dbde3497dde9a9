#include "scene/find_scene.h"

#include <system_error>

namespace hapton {

std::filesystem::path find_scene(const std::filesystem::path& name) {
  std::error_code error;
  return find_scene(name, std::filesystem::read_symlink("/proc/self/exe", error).parent_path());
}

std::filesystem::path find_scene(const std::filesystem::path& name, const std::filesystem::path& program_folder) {
  std::error_code error;
  if (name.is_absolute() || std::filesystem::exists(name, error)) return name;
  // Beside an installed program, or in the source tree of a program in build/PRESET/bin.
  for (const char* root : {"../share/hapton", "../../.."}) {
    const auto found = (program_folder / root / name).lexically_normal();
    if (std::filesystem::exists(found, error)) return found;
  }
  return name;
}

}  // namespace hapton
