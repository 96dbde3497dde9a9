#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "core/force/touch_scene.h"
#include "link/known_shapes.h"
#include "link/messages.h"
#include "patch/deforming_parts.h"
#include "patch/effect_codec.h"
#include "patch/effect_parts.h"
#include "patch/patch_bodies.h"
#include "patch/patch_grid.h"
#include "patch/streamed_parts.h"

namespace hapton {

// The material of its object that a tile carries. RT: yes.
inline Material material_of(const PatchTile& tile) noexcept {
  return {.stiffness_n_per_m = tile.stiffness_n_per_m,
          .damping_ns_per_m = tile.damping_ns_per_m,
          .friction_static = tile.friction_static,
          .friction_dynamic = tile.friction_dynamic,
          .two_sided = tile.two_sided};
}

// `numbers`, with one or two sides as `surface` has. RT: yes.
inline Material with_numbers_of(const Material& surface, Material numbers) noexcept {
  numbers.two_sided = surface.two_sided;
  return numbers;
}

// The parts of a scene that io_node has received. Within the known radius of a point no triangle of a body is missing. Parts may arrive
// in any order, repeatedly or never. The memory is bounded: a part that does not fit is dropped, and never confirmed. So is a part
// that announces a body with a motion that no scene may have: faster than kMaxSurfaceSpeed, or farther from its pivot than announced. The
// shapes of no more objects are kept than there may be bodies.
//
// Frame: that of the body, which is S if it stands still. Units: m. RT: no. Threads: one.
class PatchStore {
 public:
  static constexpr std::size_t kMaxTiles = 8192;      // bounds the memory for triangles
  static constexpr std::size_t kMaxCells = 32768;     // ... and for the tree of cells above the tiles
  static constexpr std::size_t kMaxDisplaced = 8192;  // ... and for displacements

  // The triangles near a point, as a scene of their own, and how far from the point none is missing.
  struct Piece {
    TouchScene scene;          // no objects if no triangle is near
    std::vector<int> objects;  // for each object of `scene` its number in the whole scene
    double radius_m = 0.0;     // no triangle within this distance of the point is missing
    std::size_t triangles = 0;
  };
  struct Counts {
    std::uint64_t parts = 0;
    std::uint64_t repeated = 0;
    std::uint64_t rejected = 0;  // parts of an earlier epoch, without room, or not valid
  };

  // Takes a part. A part of a newer epoch (another scene, or the same one sent anew) drops all parts of the one before.
  void accept(const PatchBegin& begin);
  void accept(const PatchCell& cell);
  void accept(const PatchTile& tile);
  void accept(const PatchBody& body);
  void accept(const PatchMaterial& material);
  void accept(const PatchDeformation& deformation);
  void accept(const PatchDisplacements& displaced);
  void accept(const PatchStream& stream);
  void accept(const PatchEffects& effects);
  // Takes any of these parts, which kIsScenePart lists. False: it is another message.
  bool accept_part(const Message& message);
  // Takes an ObjectShape or a ShapeStart, whatever the epoch. False: it is another message. arrival: as in KnownShapes.
  bool accept_shape(const Message& message, Arrival arrival);
  // Drops everything, for another sender, whose epochs start again.
  void clear();

  bool has_begun() const noexcept { return begin_.has_value(); }
  const PatchBegin& begin() const noexcept { return *begin_; }
  // The parts of this epoch received so far. The caller sets is_wanted and round_trip_s.
  const PatchStatus& status() const noexcept { return status_; }
  // Changes whenever a part or a shape has been taken.
  std::uint64_t revision() const noexcept { return counts_.parts + shape_revision_; }
  const Counts& counts() const noexcept { return counts_; }

  // The radius around a point within which no triangle of a body is missing here; infinity if none is missing. If the body deforms, it is
  // missing until all of it is there, and if programs deform it, until a shape is known that it has, or has had since. Pre: has_begun().
  double known_radius(const Vec3& p_S, std::uint32_t body = 0) const;

  // The triangles around a point, up to its known radius and max_radius_m. The radius is reduced until there are at most max_triangles, or
  // twice as many as the tiles at the point itself have, if that is more. A body that deforms is in it as a whole, or not. Pre:
  // has_begun().
  Piece make_piece(const Vec3& p_S, double max_radius_m, std::size_t max_triangles, std::uint32_t body = 0) const;

  // True if all bodies are announced, and all effects are here. Before that nothing can be felt: a body that moves may be anywhere.
  bool has_bodies() const noexcept;
  // Pre: has_bodies().
  std::unique_ptr<PatchBodies> make_bodies(std::uint32_t generation) const;

  // The parts of a body that programs deform; null: programs do not deform it, or parts are missing.
  const StreamedParts* find_stream(std::uint32_t body) const noexcept;
  const KnownShapes& shapes() const noexcept { return shapes_; }
  // The requests to send to the haptics node, as in KnownShapes.
  std::optional<ShapeStatus> take_shape_request(std::int64_t now_ns) { return shapes_.take_request(now_ns); }
  void take_shape_requests_ahead(std::int64_t now_ns, std::vector<ShapeStatus>& into) { shapes_.take_requests_ahead(now_ns, into); }

  // Materials that replace those of the tiles, by object, and how often they have changed.
  const std::map<std::uint32_t, Material>& materials() const noexcept { return materials_; }
  std::uint32_t material_version() const noexcept { return material_version_; }

 private:
  struct Cell {
    bool is_divided = false;
    std::vector<std::uint32_t> tiles;
  };
  struct Body {
    PatchBody head;  // the message that came first
    std::vector<Keyframe> keys;
    std::vector<bool> has_key;
    bool has_begun = false;
    bool is_known = false;  // all of its motion is here
    // If it deforms: what has come, and the whole body once nothing is missing.
    DeformingParts parts;
    StreamedParts stream;
    TouchObject whole;
  };
  struct Search {
    std::uint32_t body = 0;
    Vec3 p = Vec3::Zero();        // in steps
    double least_distance = 0.0;  // in steps; no point of the body is nearer than this
  };

  void drop_parts();
  bool complete_effects();
  bool adopt(std::uint32_t epoch, std::uint32_t serial);
  void confirm(std::uint32_t serial) noexcept;
  std::size_t count_new_cells(const PatchCell& cell) const;
  bool is_whole(const Cell& cell) const;
  bool complete(Body& body) const;
  bool is_possible(const Body& body) const;
  bool is_wide_enough(const PatchBody& body) const noexcept;
  Body* find_deforming(std::uint32_t tile) noexcept;
  std::size_t count_streams() const noexcept;
  bool is_of_another_body(const PatchStream& stream) const noexcept;
  void add_shaped_object(const PatchStream& stream);
  bool is_felt(const Body& body) const;
  bool complete_deforming(Body& body);
  TouchObject join_deforming(const Body& body) const;
  TouchObject join_streamed(Body& body) const;
  bool is_within_bounds(const Body& body, const TouchObject& whole) const;
  Piece make_deforming(const Body& body, double radius_m) const;
  void use_material_of(std::uint32_t object, Material& material) const;
  Search search_at(const Vec3& p_S, std::uint32_t body) const;
  double find_unknown(const CellKey& key, const Search& search, double best) const;
  void find_tiles(const CellKey& key, const Search& search, double radius, std::unordered_set<std::uint32_t>& found) const;
  static std::uint64_t key_of(std::uint32_t body, const CellKey& key) noexcept { return (std::uint64_t{body} << 48) | key.packed(); }

  std::optional<PatchBegin> begin_;
  PatchGrid grid_;
  std::array<Body, PatchBody::kMaxBodies> bodies_;
  EffectParts effect_parts_;
  std::optional<SceneEffectSet> effects_;  // none until all of them have come
  std::map<std::uint32_t, Material> materials_;
  std::map<std::uint32_t, std::uint32_t> material_serials_;
  std::uint32_t material_version_ = 0;
  std::unordered_map<std::uint64_t, Cell> cells_;  // by body and cell
  std::unordered_map<std::uint32_t, PatchTile> tiles_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, PatchDisplacements> displaced_;  // by tile and target
  KnownShapes shapes_;
  std::uint64_t shape_revision_ = 0;
  PatchStatus status_;
  Counts counts_;
};

}  // namespace hapton
