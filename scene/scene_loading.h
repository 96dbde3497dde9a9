#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/math/types.h"
#include "scene/touch_mesh.h"
#include "scene/unit.h"

namespace hapton {

// Whether a plain mesh file is scaled and centred to fit into the workspace with room around it. Scene files have keys for that.
enum class MeshFit : std::uint8_t { off, workspace };

// The box that such a mesh fits into, around the origin of S, m: three quarters of the memo's workspace (docs/frames.md).
inline Vec3 fitted_size_m() { return 0.75 * Vec3(0.2667, 0.1905, 0.381); }

// Options for reading scene and mesh files that the files do not contain.
struct SceneLoading {
  std::optional<Unit> unit = {};  // for a plain mesh file only: the unit of its numbers; none: m
  CrackSealing sealing = CrackSealing::on;
  MeshFit fit = MeshFit::off;
  AppearanceReading appearance = AppearanceReading::off;  // not recorded: forces do not depend on it
  friend bool operator==(const SceneLoading&, const SceneLoading&) = default;
};

// Converts the options, without the appearance, to a number that is never 0, for recordings; and back. None: not such a number.
std::uint32_t to_code(const SceneLoading& loading);
std::optional<SceneLoading> from_code(std::uint32_t code);
// Text for users: "unit mm, cracks sealed, mesh files fitted to the workspace". Empty: not a number from to_code.
std::string describe_loading(std::uint32_t code);

}  // namespace hapton
