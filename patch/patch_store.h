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

// The material that a tile has of its object. RT: yes.
inline Material material_of(const PatchTile& tile) noexcept {
  return {.stiffness_n_per_m = tile.stiffness_n_per_m,
          .damping_ns_per_m = tile.damping_ns_per_m,
          .friction_static = tile.friction_static,
          .friction_dynamic = tile.friction_dynamic,
          .two_sided = tile.two_sided};
}

// Other numbers on the same surface. RT: yes.
inline Material with_numbers_of(const Material& surface, Material numbers) noexcept {
  numbers.two_sided = surface.two_sided;
  return numbers;
}

// The parts of a scene that io_node has received. Within the known radius of a point no triangle of a body is missing. Parts may arrive
// in any order, repeatedly or never. The memory is bounded: a part that does not fit is dropped, and never confirmed. So is one that
// announces a body which moves as no scene may: faster than kMaxSurfaceSpeed, or farther from its pivot than it says. Shapes are known of
// no more objects than there may be bodies.
//
// Frame: that of the body, S where it stands still. Units: m. RT: no. Threads: one.
class PatchStore {
 public:
  static constexpr std::size_t kMaxTiles = 8192;      // bounds the memory for triangles
  static constexpr std::size_t kMaxCells = 32768;     // ... and for the tree of cells above the tiles
  static constexpr std::size_t kMaxDisplaced = 8192;  // ... and for displacements

  // The triangles near a point, as a scene of their own, and how far from the point none is missing.
  struct Piece {
    TouchScene scene;          // no objects if no triangle is near
    std::vector<int> objects;  // for each of its objects the number in the whole scene
    double radius_m = 0.0;     // no triangle within this distance of the point is missing
    std::size_t triangles = 0;
  };
  struct Counts {
    std::uint64_t parts = 0;
    std::uint64_t repeated = 0;
    std::uint64_t rejected = 0;  // parts of an earlier epoch, or without room
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
  // Any of these, which kIsScenePart lists. False: another message.
  bool accept_part(const Message& message);
  // What programs deform, and how: ObjectShape and ShapeStart, of whatever epoch. False: another message. arrival: as KnownShapes has it.
  bool accept_shape(const Message& message, Arrival arrival);
  // Drops everything, for another sender, whose epochs start again.
  void clear();

  bool has_begun() const noexcept { return begin_.has_value(); }
  const PatchBegin& begin() const noexcept { return *begin_; }
  // The parts of this epoch received so far. The caller sets is_wanted and round_trip_s.
  const PatchStatus& status() const noexcept { return status_; }
  // Another one whenever there is more than before.
  std::uint64_t revision() const noexcept { return counts_.parts + shape_news_; }
  const Counts& counts() const noexcept { return counts_; }

  // The radius around a point within which no triangle of the scene is missing here; infinity if none is missing. Of a body that deforms,
  // all is missing until all is there, and of one that programs deform until a shape is known that it has, or had since. Pre: has_begun().
  double known_radius(const Vec3& p_S, std::uint32_t body = 0) const;

  // The triangles around a point, up to its known radius and most_m. The radius is reduced until there are at most most_triangles, or twice
  // as many as the tiles at the point itself have, if that is more. Of a body that deforms: the whole of it, or nothing. Pre: has_begun().
  Piece make_piece(const Vec3& p_S, double most_m, std::size_t most_triangles, std::uint32_t body = 0) const;

  // All bodies are announced, and all effects are there. Before that nothing can be felt: something that moves may be anywhere.
  bool has_bodies() const noexcept;
  // Pre: has_bodies().
  std::unique_ptr<PatchBodies> make_bodies(std::uint32_t generation) const;

  // Of a body that programs deform; null: another one.
  const StreamedParts* find_stream(std::uint32_t body) const noexcept;
  const KnownShapes& shapes() const noexcept { return shapes_; }
  // As KnownShapes: what is to be sent to the haptics node.
  std::optional<ShapeStatus> take_shape_request(std::int64_t now_ns) { return shapes_.take_request(now_ns); }
  void take_shape_requests_ahead(std::int64_t now_ns, std::vector<ShapeStatus>& into) { shapes_.take_requests_ahead(now_ns, into); }

  // Materials that are not those of the tiles, by object, and how often they have changed.
  const std::map<std::uint32_t, Material>& materials() const noexcept { return materials_; }
  std::uint32_t material_version() const noexcept { return material_version_; }

 private:
  struct Cell {
    bool is_divided = false;
    std::vector<std::uint32_t> tiles;
  };
  struct Body {
    PatchBody head;  // of what came first
    std::vector<Keyframe> keys;
    std::vector<bool> has_key;
    bool has_begun = false;
    bool is_known = false;  // all of its motion
    // Of one that deforms: what has come, and all of it once that is whole.
    DeformingParts parts;
    StreamedParts stream;
    TouchObject whole;
  };
  struct Search {
    std::uint32_t body = 0;
    Vec3 p = Vec3::Zero();  // in steps
    double least = 0.0;     // the body is nowhere nearer
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
  std::optional<SceneEffectSet> effects_;  // once all of it has come
  std::map<std::uint32_t, Material> materials_;
  std::map<std::uint32_t, std::uint32_t> material_serials_;
  std::uint32_t material_version_ = 0;
  std::unordered_map<std::uint64_t, Cell> cells_;  // by body and cell
  std::unordered_map<std::uint32_t, PatchTile> tiles_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, PatchDisplacements> displaced_;  // by tile and target
  KnownShapes shapes_;
  std::uint64_t shape_news_ = 0;
  PatchStatus status_;
  Counts counts_;
};

}  // namespace hapton
