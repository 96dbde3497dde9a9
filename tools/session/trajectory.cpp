#include "tools/session/trajectory.h"

#include <array>
#include <string_view>

namespace hapton {
namespace {

struct Kind {
  std::string_view name;
  Result<TouchTrajectory> (*make)(const TriangleMesh&, const TrajectorySettings&);
};

constexpr std::array kKinds = {
    Kind{"slide", &make_slide_trajectory},
    Kind{"free", &make_free_trajectory},
    Kind{"tap", &make_tap_trajectory},
    Kind{"walk", &make_random_walk},
};

}  // namespace

std::string trajectory_kinds() {
  std::string names;
  for (const Kind& kind : kKinds) {
    if (!names.empty()) names += ", ";
    names += kind.name;
  }
  return names;
}

Result<TouchTrajectory> make_trajectory(const std::string& kind, const TriangleMesh& mesh, const TrajectorySettings& settings) {
  for (const Kind& known : kKinds) {
    if (known.name == kind) return known.make(mesh, settings);
  }
  return fail("trajectory kind '{}' is not known; choose one of: {}", kind, trajectory_kinds());
}

}  // namespace hapton
