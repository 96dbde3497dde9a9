#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "core/math/keyframe_motion.h"
#include "core/math/types.h"

namespace hapton {

// --- ContactPatch: the scene's surface in parts, from which the hub computes forces itself (docs/decisions/0116-contact-patch.md).
// Positions lie on a grid of the static scene: p_S = origin_m + step_m * (x, y, z), each a whole number below 2^kPatchGridBits. The content
// of a part stays valid within its epoch; a new epoch begins without parts. A serial counts the parts sent within an epoch, repeats
// included, from 1.

constexpr int kPatchGridBits = 24;      // three bytes for a coordinate
constexpr int kPatchDeepestLevel = 14;  // cubes of 2^10 steps

// haptics -> hub: what the parts of this epoch have in common.
struct PatchBegin {
  std::uint32_t epoch = 0;
  std::uint32_t serial = 0;
  Vec3 origin_m = Vec3::Zero();
  double step_m = 0.0;
  double probe_radius_m = 0.0;
  std::uint64_t scene_hash = 0;
  std::uint32_t body_count = 1;     // bodies, each announced by PatchBody; 1: nothing moves, and no PatchBody comes
  std::uint32_t request = 0;        // PatchStatus::request that it replies to; after a later request the hub ignores it. 0: any
  std::uint32_t method_serial = 0;  // the hub's force begins at the proxy of a ForceCommand with this or a later method_serial. 0: any
  std::uint32_t effect_bytes = 0;   // size of the effects, which come in PatchEffects; 0: there are none
};

// haptics -> hub: some bytes of the scene's effects (patch/effect_codec.h), in order. The hub computes no force before all have come.
struct PatchEffects {
  static constexpr std::size_t kMaxBytes = 960;             // in a part, one datagram; all parts but the last have as many
  static constexpr std::uint32_t kMaxAllBytes = 1U << 21U;  // all of a scene: 17 s at 1 Mbit/s
  std::uint32_t epoch = 0;
  std::uint32_t serial = 0;
  std::uint32_t part = 0;  // from 0
  std::uint32_t byte_count = 0;
  std::array<std::uint8_t, kMaxBytes> bytes = {};
};

// haptics -> hub: a cluster of triangles of one object.
struct PatchTile {
  static constexpr std::size_t kMaxVertices = 88;  // with kMaxTriangles 984 bytes: a part is one datagram
  static constexpr std::size_t kMaxTriangles = 64;
  static constexpr std::size_t kVertexBytes = 9;  // x, y, z, 3 bytes each, lowest first
  std::uint32_t epoch = 0;
  std::uint32_t serial = 0;
  std::uint32_t tile = 0;
  std::uint32_t object = 0;
  double stiffness_n_per_m = 0.0;
  double damping_ns_per_m = 0.0;
  double friction_static = 0.0;
  double friction_dynamic = 0.0;
  bool two_sided = true;
  std::uint8_t vertex_count = 0;
  std::uint8_t triangle_count = 0;
  std::array<std::uint8_t, kMaxVertices* kVertexBytes> vertices = {};
  std::array<std::uint8_t, kMaxTriangles* 3> triangles = {};  // vertex numbers in this tile
};

// haptics -> hub: a body, which is objects that move together, or all that stand still (body 0). Its parts have the positions of the scene
// at rest; its motion says where it is. A motion with more keyframes than fit into one message takes several.
struct PatchBody {
  static constexpr std::size_t kMaxBodies = 32;
  static constexpr std::size_t kMaxKeys = 12;          // in a message
  static constexpr std::uint32_t kMaxAllKeys = 1'536;  // of a body
  enum class Motion : std::uint8_t { still = 0, keyframes = 1, commanded = 2 };

  std::uint32_t epoch = 0;
  std::uint32_t serial = 0;
  std::uint32_t body = 0;
  Motion motion = Motion::still;
  bool deforms = false;  // it is one object that deforms (PatchDeformation, PatchStream); the motion moves its deformed shape
  // All its triangles, in all its shapes, are between these points of the grid; lowest above highest: it has none.
  std::array<std::uint32_t, 3> lowest = {1, 1, 1};
  std::array<std::uint32_t, 3> highest = {};
  // Only if the body moves:
  Vec3 pivot_m = Vec3::Zero();  // as in ObjectMove, at rest
  double radius_m = 0.0;        // no point of the body is farther from the pivot
  // Only if it moves by commands: the object in ObjectMove, and the serial of its newest move when this was sent, 0: none.
  std::int32_t object = 0;
  std::uint32_t move_serial = 0;
  // Only if it moves by keyframes (KeyframeMotion):
  bool loops = false;
  std::uint32_t all_keys = 0;   // number of keyframes of the motion
  std::uint32_t first_key = 0;  // number of the first keyframe here
  std::uint32_t key_count = 0;
  std::array<Keyframe, kMaxKeys> keys = {};
};

// haptics -> hub: how a body deforms (MeshDeformation): its weights over time. The body is felt once all of this has come, with all of its
// tiles, which have consecutive numbers and are in no PatchCell. More weights than fit into one message take several.
struct PatchDeformation {
  static constexpr std::uint32_t kMaxTargets = 16;    // as MeshDeformation has it
  static constexpr std::size_t kMaxNumbers = 120;     // in a message
  static constexpr std::uint32_t kMaxAllKeys = 4096;  // of a body

  std::uint32_t epoch = 0;
  std::uint32_t serial = 0;
  std::uint32_t body = 0;
  std::uint32_t first_tile = 0;
  std::uint32_t tile_count = 0;
  std::uint32_t displaced_count = 0;  // number of its PatchDisplacements: none for a tile that a target does not move
  std::uint32_t target_count = 0;
  bool loops = false;
  std::uint32_t all_keys = 0;   // number of keys of the deformation
  std::uint32_t first_key = 0;  // number of the first key here
  std::uint32_t key_count = 0;
  std::array<double, kMaxNumbers> keys = {};  // each: time in s, the weight of each target

  static constexpr std::size_t numbers_of_key(std::uint32_t targets) noexcept { return 1 + std::size_t{targets}; }
};

// haptics -> hub: how far a target moves the vertices of a tile, at a weight of 1.
struct PatchDisplacements {
  std::uint32_t epoch = 0;
  std::uint32_t serial = 0;
  std::uint32_t tile = 0;
  std::uint32_t target = 0;
  std::uint8_t vertex_count = 0;                                        // as in the tile
  std::array<float, 3 * PatchTile::kMaxVertices> displacements_m = {};  // x, y, z of each
};

// haptics -> hub: that programs deform a body, which is one object (ShapeStart), and which vertices of its mesh the vertices of a tile are.
// The body is felt once all its tiles have come, as with PatchDeformation, with one of these messages for each, and its present shape.
struct PatchStream {
  std::uint32_t epoch = 0;
  std::uint32_t serial = 0;
  std::uint32_t body = 0;
  std::uint32_t first_tile = 0;
  std::uint32_t tile_count = 0;
  std::int32_t object = 0;         // index in the scene
  std::uint32_t total = 0;         // number of vertices of its mesh, as in ShapePart
  double reach_m = 0.0;            // no vertex is farther from where it is at rest
  Mat3 to_scene = Mat3::Zero();    // turns displacements in ObjectShape into frame S
  std::uint32_t shape_serial = 0;  // of the newest ShapeStart when this was sent; 0: at rest
  std::uint32_t tile = 0;
  std::uint8_t vertex_count = 0;                                     // as in the tile
  std::array<std::uint32_t, PatchTile::kMaxVertices> vertices = {};  // vertex numbers in the mesh
};

// haptics -> hub: an object has another material than its tiles say. Of several such messages the one with the highest serial counts.
struct PatchMaterial {
  std::uint32_t epoch = 0;
  std::uint32_t serial = 0;
  std::uint32_t object = 0;
  double stiffness_n_per_m = 0.0;
  double damping_ns_per_m = 0.0;
  double friction_static = 0.0;
  double friction_dynamic = 0.0;
};

// haptics -> hub: all tiles with a triangle in one cube of the octree over the grid: its side is 2^-level of that of the whole grid.
struct PatchCell {
  static constexpr std::size_t kMaxTiles = 128;  // a scene with more in one place is not sent in parts (decision 197)
  std::uint32_t epoch = 0;
  std::uint32_t serial = 0;
  std::uint32_t level = 0;
  std::array<std::uint32_t, 3> index = {};
  // For each cube that contains this one, from the whole grid on: bit x + 2 y + 4 z is set if that child of it has no triangle.
  std::array<std::uint8_t, kPatchDeepestLevel> empty_children = {};
  std::uint32_t tile_count = 0;
  std::array<std::uint32_t, kMaxTiles> tiles = {};
  std::uint32_t body = 0;
};

template <class Kind, class... Kinds>
constexpr bool kIsOneOf = (std::is_same_v<Kind, Kinds> || ...);

// The messages above, which PatchStore keeps and only a haptics node sends.
template <class Kind>
constexpr bool kIsScenePart = kIsOneOf<Kind, PatchBegin, PatchCell, PatchTile, PatchBody, PatchMaterial, PatchDeformation,
                                       PatchDisplacements, PatchStream, PatchEffects>;

// hub -> haptics, while the hub wants parts, and when it no longer does: which it has received.
struct PatchStatus {
  static constexpr std::size_t kSerials = 512;  // 64 bytes: parts of a tenth of a second at 5 MB/s
  bool is_wanted = false;
  std::uint32_t epoch = 0;                               // of the newest part received; 0: none
  std::uint32_t newest_serial = 0;                       // received in that epoch
  std::array<std::uint8_t, kSerials / 8> received = {};  // bit i, from the lowest of byte 0: newest_serial - i
  float round_trip_s = 0.0F;                             // as the hub measures it
  std::uint32_t newest_move = 0;                         // serial of ObjectMove; 0: none
  std::uint64_t moves_received = 0;                      // bit i: newest_move - i
  std::uint32_t request = 0;                             // changes whenever the hub has dropped all parts
  bool knows_effects = false;                            // PatchEffects is understood
  float shape_s_per_vertex = 0.0F;                       // recent time per vertex to prepare a shape of a program; 0: not known
};

}  // namespace hapton
