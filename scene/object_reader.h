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

// The table of the tool in a scene file. Its keys: a grip, and those of an object for name, mesh, pose, colour and sealing.
inline constexpr std::string_view kToolTable = "[tool]";
constexpr double kMaxLengthM = 1e6;
constexpr double kMaxScale = 1e9;  // the smallest scale is the inverse of this

// How a node of a mesh file deforms in an animation.
struct AnimatedMorphs {
  MeshMorphs morphs;
  std::vector<MorphKey> keys;  // times as in the file
};

// A mesh and its pose as a scene file gives them: an [[object]] or the [tool].
struct ObjectSpec {
  std::string name;
  std::string mesh;
  std::string part;
  std::optional<Unit> unit;
  double scale = 1.0;
  Quat q_SM = Quat::Identity();
  Vec3 p_SM = Vec3::Zero();
  Quat q_SF = Quat::Identity();  // from the scene file's frame F to S: the turn by [workspace], which q_SM and p_SM contain already
  std::string material;
  std::string group = {};  // the group in which the pose is; empty: none
  bool seal_cracks = true;
  bool is_movable = false;
  SculptSpec sculpt = {};
  MotionSpec motion = {};
  ProgramShapeSpec program_shape = {};
  std::vector<MorphSpec> morphs = {};
  std::vector<std::size_t> nodes = {};          // only these nodes of a glTF file, in place of `part`; no key: split_animated sets it
  std::optional<KeyframeMotion> animated = {};  // how these nodes move, in the file's frame; likewise
  std::shared_ptr<const AnimatedMorphs> animated_morphs = {};  // how the only node deforms; likewise
  std::array<double, 3> colour = {0.7, 0.7, 0.72};
  bool has_colour = false;                            // if true, `colour` replaces all colours of the mesh file
  std::optional<std::uint32_t> haptic_material = {};  // only the triangles with this haptic material; no key: load_scene sets it
  ToolGrip grip = ToolGrip::origin;
  bool deforms() const { return !morphs.empty() || animated_morphs != nullptr; }
  bool moves() const { return !motion.keyframes.empty() || animated.has_value(); }
  // Whether a program moves the object or its vertices.
  bool moves_by_program() const { return motion.by_program || program_shape.is_on; }

  std::size_t mesh_line = 0;  // lines of the keys in the scene file; without such a key that of the table
  std::size_t part_line = 0;
  std::size_t material_line = 0;
  std::size_t group_line = 0;
};

// The object's name; if it has none, that of its part, or else that of its file.
std::string name_of(const ObjectSpec& object);

// Reads the key `scale` of an object or a group. The reader keeps the error.
void read_scale(TableReader& reader, double& scale);

// name: the object's name in error messages; kToolTable for a tool. RT: set-up only. Error: one line with the line in the file.
Result<ObjectSpec> read_object(const toml::table& table, const std::string& name);

}  // namespace hapton
