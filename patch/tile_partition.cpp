#include "patch/tile_partition.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <numeric>
#include <span>
#include <utility>

#include "patch/effect_codec.h"
#include "patch/patch_store.h"

namespace hapton {
namespace {

// A cell with more tiles than this is divided. They hold up to 1,536 triangles; a datagram can list more (PatchCell::kMaxTiles).
constexpr std::size_t kTilesInCell = 24;
// The tiles of eight children together, over those of their parent (2 to 4 for a surface). If the ratio is larger, tiles overlap each other
// and dividing would separate little, so the cell is not divided.
constexpr std::size_t kMaxSpread = 5;

struct GridTriangle {
  std::array<GridPoint, 3> corners;
  Vec3 centre = Vec3::Zero();  // times three, in steps
};

std::vector<GridTriangle> to_grid(const TriangleMesh& mesh, const PatchGrid& grid) {
  std::vector<GridPoint> vertices;
  vertices.reserve(mesh.vertices.size());
  for (const Vec3& v : mesh.vertices) vertices.push_back(grid.round(v));
  std::vector<GridTriangle> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    GridTriangle on_grid{{vertices[t[0]], vertices[t[1]], vertices[t[2]]}};
    const auto& [a, b, c] = on_grid.corners;
    if (a == b || b == c || c == a) continue;
    on_grid.centre = to_vector(a) + to_vector(b) + to_vector(c);
    triangles.push_back(on_grid);
  }
  return triangles;
}

// False: the triangles do not fit into one tile.
bool fill_tile(std::span<const GridTriangle> triangles, PatchTile& tile, Box& bounds) {
  if (triangles.size() > PatchTile::kMaxTriangles) return false;
  std::array<GridPoint, PatchTile::kMaxVertices> known;
  std::size_t count = 0;
  std::size_t corner = 0;
  for (const GridTriangle& triangle : triangles) {
    for (const GridPoint& g : triangle.corners) {
      const auto found = std::find(known.begin(), known.begin() + static_cast<std::ptrdiff_t>(count), g);
      const auto vertex = static_cast<std::size_t>(found - known.begin());
      if (vertex == known.size()) return false;
      if (vertex == count) {
        known[count++] = g;
        write_vertex(tile, vertex, g);
        bounds.grow(to_vector(g));
      }
      tile.triangles[corner++] = static_cast<std::uint8_t>(vertex);
    }
  }
  tile.vertex_count = static_cast<std::uint8_t>(count);
  tile.triangle_count = static_cast<std::uint8_t>(triangles.size());
  return true;
}

// Calls visit with vertices of shapes that bound all other shapes: between two keys each vertex moves on a straight line.
template <class Visit>
void visit_shapes(const TouchObject& object, Visit&& visit) {
  for (const Vec3& vertex : object.mesh->vertices) visit(vertex);
  const Vec3 reach = Vec3::Constant(object.stream_reach_m.value_or(0.0));
  for (const Vec3& vertex : object.mesh->vertices) {
    if (!object.stream_reach_m) break;
    visit(vertex - reach);
    visit(vertex + reach);
  }
  if (object.deformation == nullptr) return;
  for (const MorphKey& key : object.deformation->keys()) {
    for (const Vec3& vertex : object.deformation->vertices_at(object.mesh->vertices, object.deformation->weights_at(key.time_s))) {
      visit(vertex);
    }
  }
}

int longest_axis(std::span<const GridTriangle> triangles) {
  Box centres;
  for (const GridTriangle& triangle : triangles) centres.grow(triangle.centre);
  int axis = 0;
  (centres.high - centres.low).maxCoeff(&axis);
  return axis;
}

// The number of triangles on the lower side of a cut: those of whole tiles, so that few tiles are half empty.
std::size_t find_cut(std::size_t count) {
  constexpr std::size_t kWhole = PatchTile::kMaxTriangles;
  const std::size_t tiles = (count + kWhole - 1) / kWhole;
  return tiles > 1 ? tiles / 2 * kWhole : count / 2;
}

void split_into_tiles(std::span<GridTriangle> triangles, const PatchTile& of_object, TiledScene& into) {
  if (triangles.empty()) return;
  PatchTile tile = of_object;
  Box bounds;
  if (fill_tile(triangles, tile, bounds)) {
    tile.tile = static_cast<std::uint32_t>(into.tiles.size());
    into.tiles.push_back(tile);
    into.tile_bounds.push_back(bounds);
    return;
  }
  const int axis = longest_axis(triangles);
  const std::size_t cut = find_cut(triangles.size());
  std::nth_element(triangles.begin(), triangles.begin() + static_cast<std::ptrdiff_t>(cut), triangles.end(),
                   [axis](const GridTriangle& a, const GridTriangle& b) { return a.centre[axis] < b.centre[axis]; });
  split_into_tiles(triangles.first(cut), of_object, into);
  split_into_tiles(triangles.subspan(cut), of_object, into);
}

PatchTile tile_of(std::size_t object, const Material& material) {
  PatchTile tile;
  tile.object = static_cast<std::uint32_t>(object);
  tile.stiffness_n_per_m = material.stiffness_n_per_m;
  tile.damping_ns_per_m = material.damping_ns_per_m;
  tile.friction_static = material.friction_static;
  tile.friction_dynamic = material.friction_dynamic;
  tile.two_sided = material.two_sided;
  return tile;
}

// Makes the octree breadth first, so that, if it has to end early, it is equally coarse everywhere.
class CellDivider {
 public:
  CellDivider(TiledScene& scene, std::uint32_t body) : scene_(scene), body_(body) {}

  // first: the first of the body's tiles, which are the last ones of the scene so far.
  void divide(std::size_t first) {
    std::vector<std::uint32_t> body_tiles(scene_.tiles.size() - first);
    std::iota(body_tiles.begin(), body_tiles.end(), static_cast<std::uint32_t>(first));
    scene_.bodies[body_].root = static_cast<std::int32_t>(scene_.nodes.size());
    open_nodes_.push_back({scene_.nodes.size(), std::move(body_tiles), {}});
    scene_.nodes.push_back({body_, CellKey()});
    while (!open_nodes_.empty()) {
      OpenNode open = std::move(open_nodes_.front());
      open_nodes_.pop_front();
      divide(open);
    }
  }

 private:
  struct OpenNode {
    std::size_t node = 0;
    std::vector<std::uint32_t> tiles;  // those that overlap the node's cube
    std::array<std::uint8_t, kPatchDeepestLevel> empty_children = {};
  };

  void divide(OpenNode& open) {
    const CellKey key = scene_.nodes[open.node].key;
    const bool can_divide = key.level < kPatchDeepestLevel && scene_.nodes.size() + 8 <= PatchStore::kMaxCells;
    if (open.tiles.size() <= kTilesInCell || !can_divide) return close(open);
    std::array<std::vector<std::uint32_t>, 8> octant_tiles;
    std::size_t tile_sum = 0;
    for (std::uint32_t octant = 0; octant < 8; ++octant) {
      const Box bounds = key.child(octant).bounds();
      std::copy_if(open.tiles.begin(), open.tiles.end(), std::back_inserter(octant_tiles[octant]),
                   [&](std::uint32_t tile) { return scene_.tile_bounds[tile].overlaps(bounds); });
      tile_sum += octant_tiles[octant].size();
    }
    if (tile_sum > kMaxSpread * open.tiles.size() && open.tiles.size() <= PatchCell::kMaxTiles) return close(open);
    scene_.nodes[open.node].first_child = static_cast<std::int32_t>(scene_.nodes.size());
    std::uint8_t& empty_octants = open.empty_children[key.level];
    for (std::uint32_t octant = 0; octant < 8; ++octant) {
      if (octant_tiles[octant].empty()) empty_octants = static_cast<std::uint8_t>(empty_octants | (1U << octant));
    }
    for (std::uint32_t octant = 0; octant < 8; ++octant) {
      scene_.nodes.push_back({body_, key.child(octant)});
      if (!octant_tiles[octant].empty())
        open_nodes_.push_back({scene_.nodes.size() - 1, std::move(octant_tiles[octant]), open.empty_children});
    }
  }

  // Makes a leaf. A leaf with more tiles than a datagram can list is never sent: to the hub its place stays unknown.
  void close(OpenNode& open) {
    if (open.tiles.size() > PatchCell::kMaxTiles) scene_.has_unlisted_tiles = true;
    if (open.tiles.empty() || open.tiles.size() > PatchCell::kMaxTiles) return;
    scene_.nodes[open.node].cell = static_cast<std::int32_t>(scene_.cells.size());
    scene_.cells.push_back({body_, scene_.nodes[open.node].key, open.empty_children, std::move(open.tiles)});
  }

  TiledScene& scene_;
  std::uint32_t body_;
  std::deque<OpenNode> open_nodes_;
};

double radius_about(const Vec3& point, const TouchObject& object) {
  double radius = 0.0;
  visit_shapes(object, [&](const Vec3& vertex) { radius = std::max(radius, (vertex - point).norm()); });
  return radius;
}

// Adds to the scene how far each morph target moves the vertices of the tiles of a body.
class Displacer {
 public:
  Displacer(const TouchObject& object, TiledScene& tiled) : deformation_(*object.deformation), tiled_(tiled) {
    const std::vector<MorphTarget>& targets = deformation_.targets();
    displacements_.resize(object.mesh->vertices.size() * targets.size(), Vec3::Zero());
    for (std::size_t j = 0; j < targets.size(); ++j) {
      for (std::size_t k = 0; k < targets[j].vertices.size(); ++k) {
        displacements_[targets[j].vertices[k] * targets.size() + j] = targets[j].displacements[k];
      }
    }
    for (std::size_t v = 0; v < object.mesh->vertices.size(); ++v) {
      const auto [known, is_new] = vertices_.try_emplace(tiled.grid.round(object.mesh->vertices[v]), v);
      if (!is_new && !is_same_motion(known->second, v)) tiled.comes_apart = true;
    }
  }

  void add(const PatchTile& tile) {
    for (std::uint32_t j = 0; j < deformation_.targets().size(); ++j) {
      PatchDisplacements displaced{.tile = tile.tile, .target = j, .vertex_count = tile.vertex_count};
      bool moves_any_vertex = false;
      for (std::size_t v = 0; v < tile.vertex_count; ++v) {
        const Vec3& by = displacement(vertices_.at(read_vertex(tile, v)), j);
        moves_any_vertex = moves_any_vertex || !by.isZero(0.0);
        for (int axis = 0; axis < 3; ++axis)
          displaced.displacements_m[3 * v + static_cast<std::size_t>(axis)] = static_cast<float>(by[axis]);
      }
      if (moves_any_vertex) tiled_.displaced.push_back(displaced);
    }
  }

 private:
  const Vec3& displacement(std::size_t vertex, std::size_t target) const {
    return displacements_[vertex * deformation_.targets().size() + target];
  }
  bool is_same_motion(std::size_t a, std::size_t b) const {
    for (std::size_t j = 0; j < deformation_.targets().size(); ++j) {
      if (displacement(a, j) != displacement(b, j)) return false;
    }
    return true;
  }

  const MeshDeformation& deformation_;
  TiledScene& tiled_;
  std::vector<Vec3> displacements_;  // by vertex and target
  std::map<GridPoint, std::size_t> vertices_;
};

// Bounds of all shapes, rounded outwards to whole steps, and one step more for the rounding of displacements.
Box bounds_in_steps(const TouchObject& object, const PatchGrid& grid) {
  Box bounds;
  visit_shapes(object, [&](const Vec3& vertex) { bounds.grow(grid.to_steps(vertex)); });
  const double highest = std::ldexp(1.0, kPatchGridBits) - 1.0;
  return {(bounds.low.array().floor() - 1.0).max(0.0), (bounds.high.array().ceil() + 1.0).min(highest)};
}

void add_deformation(const TouchObject& object, TileBody& body, TiledScene& tiled) {
  body.deformation = object.deformation;
  body.first_displaced = tiled.displaced.size();
  body.bounds = bounds_in_steps(object, tiled.grid);
  Displacer displacer(object, tiled);
  for (std::uint32_t n = 0; n < body.tile_count; ++n) displacer.add(tiled.tiles[body.first_tile + n]);
  body.displaced_count = tiled.displaced.size() - body.first_displaced;
}

// Adds which vertex of the mesh each vertex of a body's tiles is. Of several vertices in one place the last counts, as in ShapeStager.
void add_streams(const TouchObject& object, std::uint32_t number, TileBody& body, TiledScene& tiled) {
  const TriangleMesh& mesh = *object.mesh;
  std::map<GridPoint, std::uint32_t> vertices;
  std::vector<bool> is_used(mesh.vertices.size(), false);
  for (const Triangle& triangle : mesh.triangles) {
    for (const std::uint32_t vertex : triangle) is_used[vertex] = true;
  }
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    if (!is_used[v]) continue;
    const auto [known, is_new] = vertices.try_emplace(tiled.grid.round(mesh.vertices[v]), v);
    if (!is_new && mesh.vertices[known->second] != mesh.vertices[v]) tiled.comes_apart = true;
    known->second = v;
  }
  body.bounds = bounds_in_steps(object, tiled.grid);
  body.first_stream = tiled.streams.size();
  body.stream_count = body.tile_count;
  for (std::uint32_t n = 0; n < body.tile_count; ++n) {
    const PatchTile& tile = tiled.tiles[body.first_tile + n];
    PatchStream stream{.body = static_cast<std::uint32_t>(tiled.bodies.size()),
                       .first_tile = body.first_tile,
                       .tile_count = body.tile_count,
                       .object = static_cast<std::int32_t>(number),
                       .total = static_cast<std::uint32_t>(mesh.vertices.size()),
                       .reach_m = *object.stream_reach_m,
                       .to_scene = object.stream_to_scene,
                       .tile = tile.tile,
                       .vertex_count = tile.vertex_count};
    for (std::size_t v = 0; v < tile.vertex_count; ++v) stream.vertices[v] = vertices.at(read_vertex(tile, v));
    tiled.streams.push_back(stream);
  }
}

void add_body(const TouchScene& scene, MotionGroup group, TiledScene& tiled) {
  const std::size_t first = tiled.tiles.size();
  TileBody body;
  const TouchObject* first_object = group.objects.empty() ? nullptr : &scene.objects[static_cast<std::size_t>(group.objects.front())];
  if (group.motion != nullptr) body.pivot_m = group.motion->pivot();
  if (first_object != nullptr && first_object->command_pivot) body.pivot_m = *first_object->command_pivot;
  for (const int object : group.objects) {
    const TouchObject& touch_object = scene.objects[static_cast<std::size_t>(object)];
    if (group.moves()) body.radius_m = std::max(body.radius_m, radius_about(body.pivot_m, touch_object));
    std::vector<GridTriangle> triangles = to_grid(*touch_object.mesh, tiled.grid);
    split_into_tiles(triangles, tile_of(static_cast<std::size_t>(object), touch_object.material), tiled);
  }
  for (std::size_t tile = first; tile < tiled.tiles.size(); ++tile) {
    body.bounds.grow(tiled.tile_bounds[tile].low);
    body.bounds.grow(tiled.tile_bounds[tile].high);
  }
  body.first_tile = static_cast<std::uint32_t>(first);
  body.tile_count = static_cast<std::uint32_t>(tiled.tiles.size() - first);
  const bool deforms = group.is_deforming;
  if (deforms && first_object->stream_reach_m) {
    add_streams(*first_object, static_cast<std::uint32_t>(group.objects.front()), body, tiled);
  } else if (deforms) {
    add_deformation(*first_object, body, tiled);
  }
  body.group = std::move(group);
  tiled.bodies.push_back(std::move(body));
  if (first < tiled.tiles.size() && !deforms) CellDivider(tiled, static_cast<std::uint32_t>(tiled.bodies.size() - 1)).divide(first);
}

SceneEffectSet effects_of(const TouchScene& scene, const std::vector<TileBody>& bodies) {
  SceneEffectSet effects;
  effects.space = scene.effects;
  for (const TouchObject& object : scene.objects) effects.surfaces.push_back(object.effects);
  effects.body_of.resize(effects.surfaces.size(), 0);
  for (std::size_t body = 1; body < bodies.size(); ++body) {
    for (const int object : bodies[body].group.objects) effects.body_of[static_cast<std::size_t>(object)] = static_cast<int>(body);
  }
  return effects;
}

}  // namespace

TiledScene make_tiles(const TouchScene& scene) {
  TiledScene tiled;
  Box bounds;
  for (const TouchObject& object : scene.objects) {
    visit_shapes(object, [&](const Vec3& vertex) { bounds.grow(vertex); });
  }
  if (bounds.is_empty()) return tiled;
  tiled.grid = PatchGrid::around(bounds);
  std::vector<MotionGroup> groups = group_by_motion(scene);
  if (groups.front().moves()) groups.insert(groups.begin(), MotionGroup());
  for (MotionGroup& group : groups) add_body(scene, std::move(group), tiled);
  tiled.effects = encode_effects(effects_of(scene, tiled.bodies));
  return tiled;
}

}  // namespace hapton
