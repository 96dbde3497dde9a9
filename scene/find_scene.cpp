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
  const auto installed = (program_folder / "../share/hapton" / named).lexically_normal();
  return std::filesystem::exists(installed, error) ? installed : named;
}

}  // namespace hapton
