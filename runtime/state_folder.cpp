#include "runtime/state_folder.h"

#include <cstdlib>

namespace hapton {
namespace {

// The XDG specification requires that a relative path is ignored.
std::filesystem::path absolute_path_in(const char* variable) {
  const char* value = std::getenv(variable);
  const std::filesystem::path path = value != nullptr ? value : "";
  return path.is_absolute() ? path : std::filesystem::path();
}

}  // namespace

std::filesystem::path find_state_folder() {
  if (const auto given = absolute_path_in("STATE_DIRECTORY"); !given.empty()) return given;
  if (const auto xdg = absolute_path_in("XDG_STATE_HOME"); !xdg.empty()) return xdg / "hapton";
  if (const auto home = absolute_path_in("HOME"); !home.empty()) return home / ".local/state/hapton";
  return {};
}

std::filesystem::path find_runtime_folder() {
  if (const auto given = absolute_path_in("RUNTIME_DIRECTORY"); !given.empty()) return given;
  if (const auto xdg = absolute_path_in("XDG_RUNTIME_DIR"); !xdg.empty()) return xdg / "hapton";
  return {};
}

}  // namespace hapton
