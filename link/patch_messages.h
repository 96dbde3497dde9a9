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
  std::uint32_t request = 0;        // PatchStatus::request that it replies to: the epoch is of no use to a later one. 0: any
  std::uint32_t method_serial = 0;  // a patch begins where a reply with this one or a later one has the probe. 0: any
  std::uint32_t effect_bytes = 0;   // of the effects, which come in PatchEffects; 0: there are none
};

// haptics -> hub: some bytes of the scene's effects (patch/effect_codec.h), in order. Nothing is felt before all have come.
struct PatchEffects {
  static constexpr std::size_t kMaxBytes = 960;             // in a part: one datagram. All but the last have as many
  static constexpr std::uint32_t kMaxAllBytes = 1U << 21U;  // of a scene: 17 s at 1 Mbit/s
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

// haptics -> hub: objects that move together, or what stands still (body 0). Positions of its parts are those of the scene at rest; where
// it is, its motion says. A motion with more keyframes than one message holds takes several.
struct PatchBody {
  static constexpr std::size_t kMaxBodies = 32;
  static constexpr std::size_t kMaxKeys = 12;          // in a message
  static constexpr std::uint32_t kMaxAllKeys = 1'536;  // of a body
  enum class Motion : std::uint8_t { still = 0, keyframes = 1, commanded = 2 };

  std::uint32_t epoch = 0;
  std::uint32_t serial = 0;
  std::uint32_t body = 0;
  Motion motion = Motion::still;
  bool deforms = false;  // one object, before the motion: PatchDeformation or PatchStream says how
  // All its triangles, in all its shapes, are between these points of the grid; lowest above highest: it has none.
  std::array<std::uint32_t, 3> lowest = {1, 1, 1};
  std::array<std::uint32_t, 3> highest = {};
  // Of one that moves:
  Vec3 pivot_m = Vec3::Zero();  // as in ObjectMove, at rest
  double radius_m = 0.0;        // no point is farther from the pivot
  // Of a commanded one: the object in ObjectMove, and the newest move of it when this was sent, 0: none.
  std::int32_t object = 0;
  std::uint32_t move_serial = 0;
  // Of one with keyframes (KeyframeMotion):
  bool loops = false;
  std::uint32_t all_keys = 0;   // of the motion
  std::uint32_t first_key = 0;  // of those here
  std::uint32_t key_count = 0;
  std::array<Keyframe, kMaxKeys> keys = {};
};

// haptics -> hub: how a body deforms (MeshDeformation): its weights over time. It is felt once all of it has come, with all of its tiles,
// which have consecutive numbers and are in no PatchCell. More weights than one message holds take several.
struct PatchDeformation {
  static constexpr std::uint32_t kMaxTargets = 16;    // as MeshDeformation has it
  static constexpr std::size_t kMaxNumbers = 120;     // in a message
  static constexpr std::uint32_t kMaxAllKeys = 4096;  // of a body

  std::uint32_t epoch = 0;
  std::uint32_t serial = 0;
  std::uint32_t body = 0;
  std::uint32_t first_tile = 0;
  std::uint32_t tile_count = 0;
  std::uint32_t displaced_count = 0;  // its PatchDisplacements: of a tile that a target does not move, there is none
  std::uint32_t target_count = 0;
  bool loops = false;
  std::uint32_t all_keys = 0;   // of the deformation
  std::uint32_t first_key = 0;  // of those here
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
  std::uint8_t vertex_count = 0;                             // as the tile has them
  std::array<float, 3 * PatchTile::kMaxVertices> by_m = {};  // x, y, z of each
};

// haptics -> hub: programs deform a body, one object (ShapeStart), and which vertices of its mesh those of a tile are. It is felt once all
// its tiles have come, in which it is as a deforming body, with one of these for each, and the shape that it has.
struct PatchStream {
  std::uint32_t epoch = 0;
  std::uint32_t serial = 0;
  std::uint32_t body = 0;
  std::uint32_t first_tile = 0;
  std::uint32_t tile_count = 0;
  std::int32_t object = 0;         // of the scene
  std::uint32_t total = 0;         // vertices of its mesh, as in ShapePart
  double reach_m = 0.0;            // no vertex is farther from where it is at rest
  Mat3 to_scene = Mat3::Zero();    // of displacements in ObjectShape
  std::uint32_t shape_serial = 0;  // of ShapeStart, the newest when this was sent; 0: at rest
  std::uint32_t tile = 0;
  std::uint8_t vertex_count = 0;                                     // as the tile has them
  std::array<std::uint32_t, PatchTile::kMaxVertices> vertices = {};  // of the mesh
};

// haptics -> hub: an object has another material than its tiles say. Of several the one of the highest serial counts.
struct PatchMaterial {
  std::uint32_t epoch = 0;
  std::uint32_t serial = 0;
  std::uint32_t object = 0;
  double stiffness_n_per_m = 0.0;
  double damping_ns_per_m = 0.0;
  double friction_static = 0.0;
  double friction_dynamic = 0.0;
};

// haptics -> hub: all tiles that have a triangle in one cube of the octree over the grid: at level n it is 2^-n of the whole wide.
struct PatchCell {
  static constexpr std::size_t kMaxTiles = 128;  // a scene with more in one place is not sent in parts (decision 197)
  std::uint32_t epoch = 0;
  std::uint32_t serial = 0;
  std::uint32_t level = 0;
  std::array<std::uint32_t, 3> index = {};
  // Of the cubes around it, the whole one first: bit x + 2 y + 4 z: that child of it has no triangle.
  std::array<std::uint8_t, kPatchDeepestLevel> empty_children = {};
  std::uint32_t tile_count = 0;
  std::array<std::uint32_t, kMaxTiles> tiles = {};
  std::uint32_t body = 0;
};

template <class Kind, class... Kinds>
constexpr bool kIsOneOf = (std::is_same_v<Kind, Kinds> || ...);

// The messages above: what PatchStore keeps, and only a haptics node sends.
template <class Kind>
constexpr bool kIsScenePart = kIsOneOf<Kind, PatchBegin, PatchCell, PatchTile, PatchBody, PatchMaterial, PatchDeformation,
                                       PatchDisplacements, PatchStream, PatchEffects>;

// hub -> haptics, while it wants parts: which it has received.
struct PatchStatus {
  static constexpr std::size_t kSerials = 512;  // 64 bytes: parts of a tenth of a second at 5 MB/s
  bool is_wanted = false;
  std::uint32_t epoch = 0;                               // of the newest part received; 0: none
  std::uint32_t newest_serial = 0;                       // received in that epoch
  std::array<std::uint8_t, kSerials / 8> received = {};  // bit i, from the lowest of byte 0: newest_serial - i
  float round_trip_s = 0.0F;                             // as the hub measures it
  std::uint32_t newest_move = 0;                         // serial of ObjectMove; 0: none
  std::uint64_t moves_received = 0;                      // bit i: newest_move - i
  std::uint32_t request = 0;                             // another one whenever the hub has dropped all parts
  bool knows_effects = false;                            // PatchEffects is understood
  float shape_s_per_vertex = 0.0F;                       // that making a shape of a program ready took lately; 0: not known
};

}  // namespace hapton
