#include "scene/gltf/primitive.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>

#include "scene/gltf/draco.h"

namespace hapton::gltf {
namespace {

constexpr std::size_t kTriangleList = 4;
constexpr std::size_t kTriangleFan = 6;

Vec3 vector_at(const Accessor& accessor, std::size_t i) {
  return {accessor.component(i, 0), accessor.component(i, 1), accessor.component(i, 2)};
}

Error not_finite(const std::string& where, std::size_t vertex) {
  return {fmt::format("{}: vertex {} has a coordinate that is not finite: repair the mesh", where, vertex)};
}

Error too_many(const std::string& where, std::size_t max_triangles) {
  return {fmt::format("{} has more than {} triangles: simplify it", where, max_triangles)};
}

// All targets may use the same accessor, or none, so the size of the file does not bound how many displacements they have together.
std::optional<Error> check_morphs(std::size_t targets, std::size_t vertices, const std::string& where, std::size_t max_triangles) {
  const std::size_t most = most_morph_displacements(max_triangles);
  if (vertices == 0 || targets <= most / vertices) return std::nullopt;
  return Error{
      fmt::format("{} has {} morph targets of {} vertices, more than {} displacements: simplify it", where, targets, vertices, most)};
}

std::optional<Error> read_positions(const Accessor& accessor, Primitive& primitive) {
  primitive.positions.reserve(accessor.count);
  for (std::size_t i = 0; i < accessor.count; ++i) {
    primitive.positions.push_back(vector_at(accessor, i));
    if (!primitive.positions.back().allFinite()) return not_finite(accessor.json_path, i);
  }
  return std::nullopt;
}

// Normals are optional: if they cannot be read, they are computed later.
void read_normals(const Document& document, const Json& index, const std::string& where, Primitive& primitive) {
  if (index.is_null()) return;
  const auto normals = read_accessor(document, index, where + ".attributes.NORMAL", "VEC3", 3);
  primitive.has_bad_normals = !normals || normals->count != primitive.positions.size();
  if (primitive.has_bad_normals) return;
  for (std::size_t i = 0; i < normals->count; ++i) primitive.normals.push_back(vector_at(*normals, i));
}

// Reads displacements of positions only. If a target cannot be read, all are dropped: only an object that deforms needs them.
void read_morphs(const Document& document, const Json& targets, const std::string& where, Primitive& primitive) {
  for (std::size_t t = 0; t < size_of_array(targets); ++t) {
    std::vector<Vec3>& displacements = primitive.morphs.emplace_back(primitive.positions.size(), Vec3::Zero());
    const Json& index = member(targets[t], "POSITION");
    if (index.is_null()) continue;
    const auto read = read_accessor(document, index, fmt::format("{}.targets[{}].POSITION", where, t), "VEC3", 3);
    bool is_good = read && read->count == primitive.positions.size();
    for (std::size_t i = 0; is_good && i < displacements.size(); ++i) {
      displacements[i] = vector_at(*read, i);
      is_good = displacements[i].allFinite();
    }
    primitive.has_bad_morphs = primitive.has_bad_morphs || !is_good;
  }
  if (primitive.has_bad_morphs) primitive.morphs.clear();
}

// Morph targets may also change the normals (glTF 2.0 [3.7.2.2]). Pre: the morphs are read.
void turn_normals(const Document& document, const Json& targets, std::span<const double> weights, const std::string& where,
                  Primitive& primitive) {
  for (std::size_t t = 0; t < std::min(weights.size(), size_of_array(targets)) && !primitive.normals.empty(); ++t) {
    const Json& index = member(targets[t], "NORMAL");
    if (index.is_null() || weights[t] == 0.0) continue;
    const auto read = read_accessor(document, index, fmt::format("{}.targets[{}].NORMAL", where, t), "VEC3", 3);
    primitive.has_bad_normals = !read || read->count != primitive.normals.size();
    if (primitive.has_bad_normals) return primitive.normals.clear();
    for (std::size_t i = 0; i < read->count; ++i) primitive.normals[i] += weights[t] * vector_at(*read, i);
  }
}

// Moves the positions to the shape at rest. Error: a position is not finite.
std::optional<Error> deform(std::span<const double> weights, const std::string& where, Primitive& primitive) {
  for (std::size_t t = 0; t < std::min(weights.size(), primitive.morphs.size()); ++t) {
    if (weights[t] == 0.0) continue;
    for (std::size_t i = 0; i < primitive.positions.size(); ++i) {
      primitive.positions[i] += weights[t] * primitive.morphs[t][i];
      if (!primitive.positions[i].allFinite()) return not_finite(where, i);
    }
  }
  return std::nullopt;
}

Result<std::vector<std::uint32_t>> read_corners(const Document& document, const Json& indices, const std::string& where,
                                                std::size_t vertex_count) {
  std::vector<std::uint32_t> corners;
  if (indices.is_null()) {
    for (std::size_t i = 0; i < vertex_count; ++i) corners.push_back(static_cast<std::uint32_t>(i));
    return corners;
  }
  const auto values = read_accessor(document, indices, where + ".indices", "SCALAR", 1);
  if (!values) return tl::unexpected(values.error());
  if (values->component_type == 5126 || values->normalized) return fail("{} are not whole numbers: {}", values->json_path, kExportAgain);
  corners.reserve(values->count);
  for (std::size_t i = 0; i < values->count; ++i) {
    const double index = values->component(i, 0);
    if (!(index >= 0 && index < static_cast<double>(vertex_count))) {
      return fail("{}: index {} is {}, out of range: there are {} vertices; {}", values->json_path, i, index, vertex_count, kExportAgain);
    }
    corners.push_back(static_cast<std::uint32_t>(index));
  }
  return corners;
}

std::optional<Error> make_triangles(const std::vector<std::uint32_t>& corners, std::size_t mode, const std::string& where,
                                    std::size_t max_triangles, Primitive& primitive) {
  const std::size_t n = corners.size();
  if (mode == kTriangleList && n % 3 != 0) {
    return Error{fmt::format("{} has {} corners, not a multiple of 3: {}", where, n, kExportAgain)};
  }
  if ((mode == kTriangleList ? n / 3 : n) > max_triangles) return too_many(where, max_triangles);
  for (std::size_t i = 0; i + 2 < n; i += mode == kTriangleList ? 3 : 1) {
    if (mode == kTriangleList) {
      primitive.triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
    } else if (mode == kTriangleFan) {
      primitive.triangles.push_back({corners[0], corners[i + 1], corners[i + 2]});
    } else {
      primitive.triangles.push_back({corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]});
    }
  }
  return std::nullopt;
}

constexpr std::size_t kMaxUnfolded = 16;  // more attributes than any material uses; each needs memory of its own

// The names of the attributes of a compressed primitive to decompress: texture coordinates and colours.
std::vector<std::string> unfoldable_attributes(const Json& draco) {
  std::vector<std::string> names;
  const Json& attributes = member(draco, "attributes");
  if (!attributes.is_object()) return names;
  for (const auto& [name, id] : attributes.items()) {
    const bool is_id = id.is_number_unsigned() && id.get<std::uint64_t>() <= std::numeric_limits<std::uint32_t>::max();
    if (names.size() < kMaxUnfolded && is_id && (name.starts_with("TEXCOORD_") || name == "COLOR_0")) names.push_back(name);
  }
  return names;
}

// The accessor that describes the attribute says whether its integers stand for fractions (key normalized, [3.6.2.2]).
Accessor unfolded_accessor(const Document& document, const Json& json, const std::string& name, const std::string& where,
                           const DracoValues& values, std::size_t count) {
  Accessor result;
  result.json_path = fmt::format("{}.{}", where, name);
  result.storage = std::make_shared<const std::string>(values.bytes);
  result.first = result.storage->data();
  result.count = count;
  result.stride = values.bytes.size() / count;
  result.component_type = values.component_type;
  const Json& accessors = member(document.root, "accessors");
  const auto index = index_of(member(member(json, "attributes"), name.c_str()), accessors, where);
  result.normalized = index && member(accessors[*index], "normalized") == true;
  return result;
}

// The unique id of an attribute in the compressed data.
Result<std::uint32_t> draco_id_of(const Json& draco, const char* attribute, const std::string& where) {
  const std::string name = fmt::format("{}.attributes.{}", where, attribute);
  const auto id = count_of(member(member(draco, "attributes"), attribute), name);
  if (!id) return tl::unexpected(id.error());
  if (*id > std::numeric_limits<std::uint32_t>::max()) return fail("{} is {}, beyond 32 bits: {}", name, *id, kExportAgain);
  return static_cast<std::uint32_t>(*id);
}

// If the exporter says so, integers stand for fractions of their range [3.6.2.2]. Draco itself keeps the integers.
Result<std::optional<Primitive>> read_draco(const Document& document, const Json& json, const Json& draco, const std::string& where,
                                            std::size_t max_triangles) {
  const std::string name = where + ".extensions.KHR_draco_mesh_compression";
  const auto view = document.buffers.view(member(draco, "bufferView"), name + ".bufferView");
  if (!view) return tl::unexpected(view.error());
  const auto position = draco_id_of(draco, "POSITION", name);
  if (!position) return tl::unexpected(position.error());
  DracoRequest request{.position = *position, .normal = {}, .max_triangles = max_triangles};
  const auto normal = draco_id_of(draco, "NORMAL", name);
  if (normal) request.normal = *normal;
  const std::vector<std::string> names = unfoldable_attributes(draco);
  for (const std::string& each : names) request.others.push_back(member(member(draco, "attributes"), each.c_str()).get<std::uint32_t>());
  const Result<DracoMesh> mesh = decode_draco(view->bytes, request, name);
  if (!mesh) return tl::unexpected(mesh.error());
  Primitive primitive;
  primitive.has_bad_normals = normal && mesh->normals.empty();
  for (const Eigen::Vector3f& p : mesh->positions) {
    if (!p.allFinite()) return tl::unexpected(not_finite(name, primitive.positions.size()));
    primitive.positions.push_back(p.cast<double>());
  }
  for (const Eigen::Vector3f& n : mesh->normals) primitive.normals.push_back(n.cast<double>());
  primitive.unfolded.emplace();
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (mesh->others[i].bytes.empty()) continue;
    primitive.unfolded->emplace(names[i], unfolded_accessor(document, json, names[i], name, mesh->others[i], mesh->positions.size()));
  }
  // The decompressed data are a triangle list, whatever the mode of the primitive is.
  if (auto error = make_triangles(mesh->corners, kTriangleList, name, max_triangles, primitive)) return tl::unexpected(std::move(*error));
  const auto promised = accessor_count(document, member(json, "indices"), where + ".indices");
  const auto mode = count_or(member(json, "mode"), kTriangleList, where + ".mode");
  if (promised && mode && *mode == kTriangleList && *promised != mesh->corners.size()) {
    return fail("{} holds {} corners where the file promises {}: {}", name, mesh->corners.size(), *promised, kExportAgain);
  }
  return std::optional(std::move(primitive));
}

Result<std::optional<Primitive>> read_plain(const Document& document, const Json& json, std::size_t mode, const std::string& where,
                                            std::size_t max_triangles) {
  const Json& attributes = member(json, "attributes");
  const auto positions = read_accessor(document, member(attributes, "POSITION"), where + ".attributes.POSITION", "VEC3", 3);
  if (!positions) return tl::unexpected(positions.error());
  if (positions->count > 3 * max_triangles) return tl::unexpected(too_many(where, max_triangles));
  Primitive primitive;
  if (auto error = read_positions(*positions, primitive)) return tl::unexpected(std::move(*error));
  const auto corners = read_corners(document, member(json, "indices"), where, positions->count);
  if (!corners) return tl::unexpected(corners.error());
  if (auto error = make_triangles(*corners, mode, where, max_triangles, primitive)) return tl::unexpected(std::move(*error));
  read_normals(document, member(attributes, "NORMAL"), where, primitive);
  return std::optional(std::move(primitive));
}

}  // namespace

Result<std::optional<Primitive>> read_primitive(const Document& document, const Json& json, std::span<const double> weights,
                                                const std::string& where, std::size_t max_triangles) {
  const auto mode = count_or(member(json, "mode"), kTriangleList, where + ".mode");
  if (!mode) return tl::unexpected(mode.error());
  if (*mode > kTriangleFan) return fail("{}.mode is {}, unknown: {}", where, *mode, kExportAgain);
  const bool has_positions = !member(member(json, "attributes"), "POSITION").is_null();
  if (*mode < kTriangleList || !has_positions) return std::optional<Primitive>();
  const Json& draco = extension_of(json, "KHR_draco_mesh_compression");
  auto primitive =
      draco.is_object() ? read_draco(document, json, draco, where, max_triangles) : read_plain(document, json, *mode, where, max_triangles);
  const Json& targets = member(json, "targets");
  if (!primitive || !*primitive || size_of_array(targets) == 0) return primitive;
  // Draco changes the order of the vertices, so the displacements of the targets cannot be assigned to them.
  (*primitive)->has_bad_morphs = draco.is_object();
  if (draco.is_object()) return primitive;
  if (auto error = check_morphs(size_of_array(targets), (*primitive)->positions.size(), where, max_triangles)) {
    return tl::unexpected(std::move(*error));
  }
  read_morphs(document, targets, where, **primitive);
  if ((*primitive)->has_bad_morphs) return primitive;
  if (auto error = deform(weights, where, **primitive)) return tl::unexpected(std::move(*error));
  turn_normals(document, targets, weights, where, **primitive);
  return primitive;
}

bool has_attribute(const Json& json, const Primitive& primitive, const std::string& attribute) {
  if (primitive.unfolded) return primitive.unfolded->contains(attribute);
  return !member(member(json, "attributes"), attribute.c_str()).is_null();
}

Result<Accessor> read_attribute(const Document& document, const Json& json, const Primitive& primitive, const std::string& attribute,
                                const std::string& where, std::string_view type, std::size_t components) {
  const std::string name = fmt::format("{}.attributes.{}", where, attribute);
  const auto mismatch = [&](const std::string& path, std::size_t count) {
    return fail("{}: {} values for {} vertices: {}", path, count, primitive.positions.size(), kExportAgain);
  };
  if (!primitive.unfolded) {
    auto values = read_accessor(document, member(member(json, "attributes"), attribute.c_str()), name, type, components);
    if (values && values->count != primitive.positions.size()) return mismatch(values->json_path, values->count);
    return values;
  }
  const auto found = primitive.unfolded->find(attribute);
  if (found == primitive.unfolded->end()) return fail("{} is not in its compressed data: {}", name, kExportAgain);
  const Accessor& values = found->second;
  if (values.stride != components * component_bytes(values.component_type)) {
    return fail("{} is not of type {}: {}", values.json_path, type, kExportAgain);
  }
  return values;
}

}  // namespace hapton::gltf
