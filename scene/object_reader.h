#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/math/keyframe_motion.h"
#include "core/math/types.h"
#include "scene/keyframe_reader.h"
#include "scene/mesh_animation.h"
#include "scene/morph_reader.h"
#include "scene/program_shape_reader.h"
#include "scene/scene_tool.h"
#include "scene/sculpt_reader.h"
#include "scene/table_reader.h"
#include "scene/unit.h"

namespace hapton {

// The table of the tool in a scene file; it has the keys of an object, a grip, and no material.
inline constexpr std::string_view kToolTable = "[tool]";
constexpr double kMaxLengthM = 1e6;
constexpr double kMaxScale = 1e9;  // and its inverse is the smallest one

// How a node of a mesh file deforms by an animation.
struct AnimatedMorphs {
  MeshMorphs morphs;
  std::vector<MorphKey> keys;  // times as in the file
};

// A mesh in its pose as a scene file has it: an [[object]] or the [tool].
struct ObjectSpec {
  std::string name;
  std::string mesh;
  std::string part;
  std::optional<Unit> unit;
  double scale = 1.0;
  Quat q_SM = Quat::Identity();
  Vec3 p_SM = Vec3::Zero();
  Quat q_SF = Quat::Identity();  // by which [workspace] has turned what the file says
  std::string material;
  std::string group = {};  // that the pose is in; empty: none
  bool seal_cracks = true;
  bool is_movable = false;
  SculptSpec sculpt = {};
  MotionSpec motion = {};
  ProgramShapeSpec program_shape = {};
  std::vector<MorphSpec> morphs = {};
  std::vector<std::size_t> nodes = {};          // only those of a glTF file, in place of `part`; no key: split_animated sets it
  std::optional<KeyframeMotion> animated = {};  // ... and how they move, in the file's frame
  std::shared_ptr<const AnimatedMorphs> animated_morphs = {};  // ... and how the one of them deforms
  std::array<double, 3> colour = {0.7, 0.7, 0.72};
  bool has_colour = false;                            // then it replaces all colours of the mesh file
  std::optional<std::uint32_t> haptic_material = {};  // only the triangles with this one of MeshHaptics; no key: load_scene sets it
  ToolGrip grip = ToolGrip::origin;
  bool deforms() const { return !morphs.empty() || animated_morphs != nullptr; }
  bool moves() const { return !motion.keyframes.empty() || animated.has_value(); }
  // It, or its vertices.
  bool moves_by_program() const { return motion.by_program || program_shape.is_on; }

  std::size_t mesh_line = 0;  // in the scene file
  std::size_t part_line = 0;
  std::size_t material_line = 0;
  std::size_t group_line = 0;
};

// Its name, or else its part's or its file's.
std::string name_of(const ObjectSpec& object);

// The factor of an object's lengths, or of a group's.
void read_scale(TableReader& reader, double& scale);

// name: as in error messages; kToolTable for a tool. RT: set-up only. Error: one line with the line in the file.
Result<ObjectSpec> read_object(const toml::table& table, const std::string& name);

}  // namespace hapton
