#include "scene/gltf/reader.h"

#include <string>
#include <vector>

#include "scene/gltf/animation.h"
#include "scene/gltf/base_colour.h"
#include "scene/gltf/buffers.h"
#include "scene/gltf/extensions.h"
#include "scene/gltf/haptics.h"
#include "scene/gltf/json.h"
#include "scene/gltf/materials.h"
#include "scene/gltf/morph_weights.h"
#include "scene/gltf/primitive.h"
#include "scene/gltf/transform.h"
#include "scene/text_cursor.h"

// The glTF 2.0 specification is cited by section, e.g. [3.6.2.4].
namespace hapton::gltf {
namespace {

Result<Json> parse(std::string_view text) {
  try {
    return Json::parse(text);
  } catch (const Json::exception& reason) {
    // "[json.exception.parse_error.101] parse error at line 1, column 5: ...; last read: ..."
    std::string what = reason.what();
    if (const auto bracket = what.find("] "); bracket != std::string::npos) what = what.substr(bracket + 2);
    if (const auto last = what.find("; last read"); last != std::string::npos) what = what.substr(0, last);
    for (char& c : what) c = c >= ' ' && c <= '~' ? c : '?';
    return fail("the JSON is broken or cut short ({}): copy or export the file again", what.substr(0, 160));
  }
}

std::optional<Error> check_version(const Json& root) {
  const std::string version = text_of(member(member(root, "asset"), "version"));
  if (version.starts_with("2.")) return std::nullopt;
  return Error{fmt::format("is glTF version '{}', only 2.x can be read: export it as glTF 2.0", printable(version))};
}

// The root nodes of the scene to show [3.5.1]. If the file has no scenes: all nodes that are not a child of another node.
Result<std::vector<std::size_t>> root_nodes(const Json& root) {
  const Json& nodes = member(root, "nodes");
  const Json& scenes = member(root, "scenes");
  std::vector<std::size_t> roots;
  if (size_of_array(scenes) == 0) {
    std::vector<bool> is_child(size_of_array(nodes), false);
    for (std::size_t n = 0; n < is_child.size(); ++n) {
      for (const Json& child : member(nodes[n], "children")) {
        const auto index = index_of(child, nodes, fmt::format("a child of nodes[{}]", n));
        if (!index) return tl::unexpected(index.error());
        is_child[*index] = true;
      }
    }
    for (std::size_t n = 0; n < is_child.size(); ++n) {
      if (!is_child[n]) roots.push_back(n);
    }
    return roots;
  }
  std::size_t scene = 0;
  if (!member(root, "scene").is_null()) {
    const auto index = index_of(member(root, "scene"), scenes, "scene");
    if (!index) return tl::unexpected(index.error());
    scene = *index;
  }
  for (const Json& node : member(scenes[scene], "nodes")) {
    const auto index = index_of(node, nodes, fmt::format("a node of scenes[{}]", scene));
    if (!index) return tl::unexpected(index.error());
    roots.push_back(*index);
  }
  return roots;
}

// A node is shown unless KHR_node_visibility hides it. All nodes below a hidden node are hidden too.
bool is_hidden(const Json& node) { return member(extension_of(node, "KHR_node_visibility"), "visible") == false; }

// The number of materials that have a normal map [3.9.3].
std::size_t count_normal_maps(const Json& materials) {
  std::size_t count = 0;
  for (std::size_t m = 0; m < size_of_array(materials); ++m) count += member(materials[m], "normalTexture").is_null() ? 0 : 1;
  return count;
}

class SceneReader {
 public:
  // places: the texture place of each material; empty if the appearance is not wanted. haptic_places: the same for the haptic materials.
  SceneReader(const Document& document, std::size_t max_triangles, std::vector<TexturePlace> places, bool wants_appearance,
              std::vector<HapticPlace> haptic_places, RawMesh& raw)
      : document_(document),
        max_triangles_(max_triangles),
        places_(std::move(places)),
        wants_appearance_(wants_appearance),
        haptic_places_(std::move(haptic_places)),
        raw_(raw) {}

  // Goes depth first, with a list instead of recursion: a deep chain of nodes could exhaust the stack. Each node has one parent [3.5.2].
  std::optional<Error> read(const std::vector<std::size_t>& roots) {
    const Json& nodes = member(document_.root, "nodes");
    std::vector<bool> visited(size_of_array(nodes), false);
    std::vector<Pending> pending;
    for (auto root = roots.rbegin(); root != roots.rend(); ++root) pending.push_back({*root, Eigen::Affine3d::Identity()});
    while (!pending.empty()) {
      const Pending next = pending.back();
      pending.pop_back();
      const std::string where = fmt::format("nodes[{}]", next.node);
      if (visited[next.node]) return Error{fmt::format("{} appears twice in the node tree, or below itself: {}", where, kExportAgain)};
      visited[next.node] = true;
      const Json& node = nodes[next.node];
      if (is_hidden(node)) {
        ++hidden_;
        continue;
      }
      const auto X_PN = transform_of(node, where);
      if (!X_PN) return X_PN.error();
      const Eigen::Affine3d X_SN = next.X_SP * *X_PN;
      if (auto error = add_node(node, next.node, X_SN)) return error;
      const Json& children = member(node, "children");
      for (std::size_t c = size_of_array(children); c-- > 0;) {
        const auto child = index_of(children[c], nodes, "a child of " + where);
        if (!child) return child.error();
        pending.push_back({*child, X_SN});
      }
    }
    return std::nullopt;
  }

  void add_notes() {
    const std::pair<std::size_t, std::string_view> notes[] = {
        {not_triangles_, "{} primitives of points or lines, or without positions, were skipped"},
        {hidden_, "{} nodes are marked as not visible and were skipped, with all under them"},
        {skinned_, "{} skinned nodes are shown at rest, not posed by their skeleton"},
        {bad_normals_, "the normals of {} primitives cannot be read: computed there"},
        {bad_morphs_, "{} primitives have morph targets that cannot be read, which were skipped"},
        {odd_weights_, "{} primitives have another number of morph targets than weights: the missing weights are 0"},
        {count_normal_maps(member(document_.root, "materials")),
         "the normal maps of {} materials are not drawn, and felt only where a material of the scene file has normal_map = true"}};
    for (const auto& [count, text] : notes) {
      if (count > 0) raw_.notes.push_back(fmt::format(fmt::runtime(text), count));
    }
  }

 private:
  struct Pending {
    std::size_t node;
    Eigen::Affine3d X_SP;  // pose of the parent in the scene
  };

  std::optional<Error> add_node(const Json& node, std::size_t index, const Eigen::Affine3d& X_SN) {
    if (member(node, "mesh").is_null()) return std::nullopt;
    const std::string where = fmt::format("nodes[{}]", index);
    const Json& meshes = member(document_.root, "meshes");
    const auto mesh = index_of(member(node, "mesh"), meshes, where + ".mesh");
    if (!mesh) return mesh.error();
    skinned_ += member(node, "skin").is_null() ? 0 : 1;
    std::string name = text_of(member(node, "name"));
    if (name.empty()) name = text_of(member(meshes[*mesh], "name"));
    if (auto error = count_read(name.size())) return error;
    raw_.begin_part(name.empty() ? fmt::format("node {}", index) : name);
    raw_.parts.back().node = index;
    const Json& primitives = member(meshes[*mesh], "primitives");
    const auto poses = instances_of(node, document_, where);
    if (!poses) return poses.error();
    const auto haptic = haptic_material_of(document_, *mesh, raw_.haptics);
    if (!haptic) return haptic.error();
    const auto weights = weights_at_rest(document_.root, node, where);
    if (!weights) return weights.error();
    if (auto error = count_read(poses->size() + weights->size())) return error;
    for (std::size_t p = 0; p < size_of_array(primitives); ++p) {
      const std::string place = fmt::format("meshes[{}].primitives[{}]", *mesh, p);
      const auto primitive = read_primitive(document_, primitives[p], *weights, place, max_triangles_);
      if (!primitive) return primitive.error();
      const std::size_t vertices = *primitive ? (*primitive)->positions.size() : 0;
      if (auto error = count_read(1 + vertices + (1 + vertices) * size_of_array(member(primitives[p], "targets")))) return error;
      count_flaws(*primitive);
      odd_weights_ += *primitive && !weights->empty() && weights->size() != size_of_array(member(primitives[p], "targets")) ? 1 : 0;
      if (!*primitive || (*primitive)->triangles.empty()) continue;
      VertexAppearances appearances;
      if (wants_appearance_) appearances = read_vertex_appearances(document_, primitives[p], **primitive, places_, where);
      VertexAppearances haptics;
      if (*haptic) {
        const auto read = read_haptics(primitives[p], **haptic, **primitive, place);
        if (!read) return read.error();
        haptics = *read;
      }
      for (const Eigen::Affine3d& X_NI : *poses) {
        if (auto error = add_instance(**primitive, where, X_SN * X_NI, {appearances, haptics})) return error;
      }
    }
    return std::nullopt;
  }

  // How the vertices of a primitive feel, in the form in which their appearance is stored.
  Result<VertexAppearances> read_haptics(const Json& json, std::uint32_t material, const Primitive& primitive, const std::string& where) {
    const std::size_t vertices = primitive.positions.size();
    VertexAppearances haptics{.material = material, .has_colours = false, .vertices = std::vector<CornerAppearance>(vertices)};
    if (!raw_.haptics.materials[material].has_maps()) return haptics;
    const auto places = read_haptic_places(document_, json, primitive, haptic_places_[material], where);
    if (!places) return tl::unexpected(places.error());
    for (std::size_t i = 0; i < vertices; ++i) haptics.vertices[i].texcoord = (*places)[i];
    return haptics;
  }

  // How a primitive's vertices look and feel.
  struct Surface {
    const VertexAppearances& appearances;
    const VertexAppearances& haptics;
  };

  // Counts what is read. Any number of nodes and primitives may share data that the file contains once. If they add triangles, these are
  // limited. But without triangles, the same data could be read again for each node, which would take hours.
  std::optional<Error> count_read(std::size_t items) {
    read_count_ += items;
    if (read_count_ <= kMaxReadPerTriangle * max_triangles_) return std::nullopt;
    return Error{
        fmt::format("has more than {} vertices, morph targets, instances, primitives and bytes of names with all its nodes: simplify it",
                    kMaxReadPerTriangle * max_triangles_)};
  }

  void count_flaws(const std::optional<Primitive>& primitive) {
    not_triangles_ += primitive ? 0 : 1;
    bad_morphs_ += primitive && primitive->has_bad_morphs ? 1 : 0;
    bad_normals_ += primitive && primitive->has_bad_normals ? 1 : 0;
  }

  std::optional<Error> add_instance(const Primitive& primitive, const std::string& where, const Eigen::Affine3d& X_SN,
                                    const Surface& surface) {
    const std::size_t first = raw_.mesh.vertices.size();
    if (first + primitive.positions.size() > 3 * max_triangles_ ||
        raw_.mesh.triangles.size() + primitive.triangles.size() > max_triangles_) {
      return Error{fmt::format("has more than {} triangles with all its instances: simplify it", max_triangles_)};
    }
    for (const Vec3& p_NV : primitive.positions) {
      const Vec3 p_SV = X_SN * p_NV;
      if (!p_SV.allFinite()) return Error{fmt::format("{}: its pose makes a coordinate of a vertex overflow: {}", where, kExportAgain)};
      raw_.mesh.vertices.push_back(p_SV);
    }
    add_triangles(primitive, static_cast<std::uint32_t>(first), X_SN, surface);
    return add_morphs(primitive, first, X_SN);
  }

  // All primitives of a mesh have the same number of targets [3.7.2.2]. If one has fewer, the other targets do not move it.
  std::optional<Error> add_morphs(const Primitive& primitive, std::size_t first, const Eigen::Affine3d& X_SN) {
    if (primitive.morphs.empty()) return std::nullopt;
    MeshMorphs& morphs = raw_.morphs[raw_.parts.back().node];
    const std::size_t before = morphs.at_rest.size();
    const std::size_t targets = std::max(morphs.displacements.size(), primitive.morphs.size());
    displacements_ += targets * (before + primitive.positions.size()) - morphs.displacements.size() * before;
    if (displacements_ > most_morph_displacements(max_triangles_)) {
      return Error{fmt::format("has more than {} displacements of morph targets with all its instances: simplify it",
                               most_morph_displacements(max_triangles_))};
    }
    morphs.at_rest.insert(morphs.at_rest.end(), raw_.mesh.vertices.begin() + static_cast<std::ptrdiff_t>(first), raw_.mesh.vertices.end());
    morphs.displacements.resize(targets);
    for (std::size_t t = 0; t < targets; ++t) {
      std::vector<Vec3>& into = morphs.displacements[t];
      into.resize(before, Vec3::Zero());
      if (t < primitive.morphs.size()) {
        for (const Vec3& displacement : primitive.morphs[t]) into.push_back(X_SN.linear() * displacement);
      }
      into.resize(morphs.at_rest.size(), Vec3::Zero());
    }
    return std::nullopt;
  }

  // A mirroring transform reverses the winding [3.7.4]. Normals are multiplied by the inverse transpose, which keeps them at right angles
  // to the surface.
  void add_triangles(const Primitive& primitive, std::uint32_t first, const Eigen::Affine3d& X_SN, const Surface& surface) {
    const bool is_mirrored = X_SN.linear().determinant() < 0;
    const Eigen::Matrix3d turn = X_SN.linear().inverse().transpose();
    const auto normal_of = [&](std::uint32_t corner) -> Eigen::Vector3f {
      return (turn * primitive.normals[corner]).normalized().cast<float>();
    };
    for (const auto& [a, b, c] : primitive.triangles) {
      const Triangle local = is_mirrored ? Triangle{a, c, b} : Triangle{a, b, c};
      const Triangle triangle = {first + local[0], first + local[1], first + local[2]};
      if (primitive.normals.empty()) {
        raw_.mesh.triangles.push_back(triangle);
      } else {
        raw_.add_triangle(triangle, {normal_of(local[0]), normal_of(local[1]), normal_of(local[2])});
      }
      add_appearance(surface.appearances, local, raw_.appearance);
      add_appearance(surface.haptics, local, raw_.haptics.maps);
    }
  }

  // Adds the appearance of the last triangle.
  void add_appearance(const VertexAppearances& appearances, const Triangle& local, MeshAppearance& into) {
    if (appearances.vertices.empty()) return;
    const auto& seen = appearances.vertices;
    into.resize(raw_.mesh.triangles.size() - 1);
    into.triangles.push_back({appearances.material, appearances.has_colours, {seen[local[0]], seen[local[1]], seen[local[2]]}});
  }

  // Items per permitted triangle: three vertices, three displacements, and a morph target, a weight, an instance and a primitive.
  static constexpr std::size_t kMaxReadPerTriangle = 10;

  const Document& document_;
  std::size_t max_triangles_;
  std::vector<TexturePlace> places_;
  bool wants_appearance_;
  std::vector<HapticPlace> haptic_places_;
  RawMesh& raw_;
  std::size_t not_triangles_ = 0;
  std::size_t hidden_ = 0;
  std::size_t skinned_ = 0;
  std::size_t bad_normals_ = 0;
  std::size_t bad_morphs_ = 0;
  std::size_t odd_weights_ = 0;
  std::size_t displacements_ = 0;  // of the morph targets of all instances
  std::size_t read_count_ = 0;     // items read for all nodes, see count_read
};

}  // namespace

Result<RawMesh> read_document(std::string_view json, std::optional<std::string_view> binary, const std::filesystem::path& folder,
                              std::string_view format, std::size_t max_triangles, AppearanceReading appearance) {
  const Result<Json> root = parse(json);
  if (!root) return tl::unexpected(root.error());
  if (auto error = check_version(*root)) return tl::unexpected(std::move(*error));
  if (auto error = check_required_extensions(*root)) return tl::unexpected(std::move(*error));
  const Result<std::vector<std::size_t>> roots = root_nodes(*root);
  if (!roots) return tl::unexpected(roots.error());
  Buffers buffers(*root, binary, folder);
  const Document document{*root, buffers};
  RawMesh raw;
  raw.format = format;
  const bool wants_appearance = appearance != AppearanceReading::off;
  auto haptic_places = read_haptic_materials(document, folder, raw);
  if (!haptic_places) return tl::unexpected(haptic_places.error());
  SceneReader reader(document, max_triangles,
                     wants_appearance ? read_materials(document, folder, appearance, raw) : std::vector<TexturePlace>(), wants_appearance,
                     std::move(*haptic_places), raw);
  if (auto error = reader.read(*roots)) return tl::unexpected(std::move(*error));
  reader.add_notes();
  for (std::string& note : describe_undrawn_materials(*root)) raw.notes.push_back(std::move(note));
  for (std::string& note : describe_unsupported_extensions(*root)) raw.notes.push_back(std::move(note));
  raw.end_parts();
  // An error here becomes only a note, because a scene that plays no animation does not need them.
  if (const auto read = read_animations(document, raw); !read) {
    raw.notes.push_back(fmt::format("its animations cannot be read: {}", read.error().what));
  }
  return raw;
}

}  // namespace hapton::gltf

namespace hapton {

Result<RawMesh> read_gltf(std::string_view bytes, const std::filesystem::path& folder, std::size_t max_triangles,
                          AppearanceReading appearance) {
  return gltf::read_document(bytes, std::nullopt, folder, "glTF", max_triangles, appearance);
}

}  // namespace hapton
