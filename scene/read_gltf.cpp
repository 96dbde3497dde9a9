#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "scene/file_bytes.h"
#include "scene/raw_mesh.h"
#include "scene/text_cursor.h"

// The glTF 2.0 specification is cited by section, e.g. [3.6.2.4].
namespace hapton {
namespace {

using Json = nlohmann::json;

static_assert(std::endian::native == std::endian::little, "glTF buffers are little-endian");

constexpr double kMaxExactInteger = 9007199254740992.0;  // 2^53
constexpr std::string_view kExportAgain = "export the file again";

// Extensions a file may require that do not change its triangles.
bool is_harmless(std::string_view extension) {
  return extension.starts_with("KHR_materials_") || extension.starts_with("KHR_texture_") || extension.starts_with("EXT_texture_") ||
         extension.starts_with("KHR_lights_") || extension == "KHR_mesh_quantization" || extension == "KHR_xmp_json_ld";
}

// A member of a JSON object; a null value when the object lacks it or is none.
const Json& member(const Json& object, const char* key) {
  static const Json kNone;
  if (!object.is_object()) return kNone;
  const auto found = object.find(key);
  return found == object.end() ? kNone : *found;
}

std::size_t size_of_array(const Json& array) { return array.is_array() ? array.size() : 0; }

std::string text_of(const Json& value) { return value.is_string() ? value.get<std::string>() : std::string(); }

Result<std::size_t> count_of(const Json& value, const std::string& where) {
  if (!value.is_number()) return fail("{} is missing or not a number: {}", where, kExportAgain);
  const double number = value.get<double>();
  if (!(number >= 0 && number < kMaxExactInteger) || number != std::floor(number)) {
    return fail("{} is {}, not a count: {}", where, number, kExportAgain);
  }
  return static_cast<std::size_t>(number);
}

Result<std::size_t> count_or(const Json& value, std::size_t absent, const std::string& where) {
  if (value.is_null()) return absent;
  return count_of(value, where);
}

// An index into one of the file's top-level arrays.
Result<std::size_t> index_of(const Json& value, const Json& array, const std::string& where) {
  Result<std::size_t> index = count_of(value, where);
  if (index && *index >= size_of_array(array)) {
    return fail("{} is {}, out of range: there are {}; {}", where, *index, size_of_array(array), kExportAgain);
  }
  return index;
}

template <std::size_t N>
Result<std::array<double, N>> numbers_of(const Json& value, const std::string& where) {
  std::array<double, N> numbers = {};
  if (size_of_array(value) != N) return fail("{} does not have {} numbers: {}", where, N, kExportAgain);
  for (std::size_t i = 0; i < N; ++i) {
    if (!value[i].is_number()) return fail("{} holds something that is not a number: {}", where, kExportAgain);
    numbers[i] = value[i].get<double>();
    if (!std::isfinite(numbers[i])) return fail("{} is not finite: {}", where, kExportAgain);
  }
  return numbers;
}

// A node's own transform: a matrix, column by column, or T R S [3.5.2].
Result<Eigen::Affine3d> transform_of(const Json& node, const std::string& where) {
  Eigen::Affine3d X_PN = Eigen::Affine3d::Identity();
  if (!member(node, "matrix").is_null()) {
    const auto m = numbers_of<16>(member(node, "matrix"), where + ".matrix");
    if (!m) return tl::unexpected(m.error());
    X_PN.matrix() = Eigen::Map<const Eigen::Matrix4d>(m->data());
    if (X_PN.matrix().row(3) != Eigen::RowVector4d(0, 0, 0, 1)) return fail("{}.matrix is not affine: {}", where, kExportAgain);
    return X_PN;
  }
  if (!member(node, "translation").is_null()) {
    const auto t = numbers_of<3>(member(node, "translation"), where + ".translation");
    if (!t) return tl::unexpected(t.error());
    X_PN.translate(Vec3((*t)[0], (*t)[1], (*t)[2]));
  }
  if (!member(node, "rotation").is_null()) {
    const auto q = numbers_of<4>(member(node, "rotation"), where + ".rotation");
    if (!q) return tl::unexpected(q.error());
    const Quat rotation((*q)[3], (*q)[0], (*q)[1], (*q)[2]);
    if (!(rotation.norm() > 0)) return fail("{}.rotation is zero: {}", where, kExportAgain);
    X_PN.rotate(rotation.normalized());
  }
  if (!member(node, "scale").is_null()) {
    const auto s = numbers_of<3>(member(node, "scale"), where + ".scale");
    if (!s) return tl::unexpected(s.error());
    X_PN.scale(Vec3((*s)[0], (*s)[1], (*s)[2]));
  }
  return X_PN;
}

constexpr std::array<std::int8_t, 256> make_base64_values() {
  std::array<std::int8_t, 256> values = {};
  for (std::int8_t& value : values) value = -1;
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i < kDigits.size(); ++i) values[static_cast<unsigned char>(kDigits[i])] = static_cast<std::int8_t>(i);
  return values;
}

Result<std::string> decode_base64(std::string_view text, const std::string& where) {
  static constexpr std::array<std::int8_t, 256> kValues = make_base64_values();
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3 + 3);
  std::uint32_t bits = 0;
  int held = 0;
  while (text.ends_with('=')) text.remove_suffix(1);
  for (const char c : text) {
    const std::int8_t value = kValues[static_cast<unsigned char>(c)];
    if (value < 0) return fail("{} is not base64: {}", where, kExportAgain);
    bits = bits << 6 | static_cast<std::uint32_t>(value);
    held += 6;
    if (held >= 8) {
      held -= 8;
      bytes.push_back(static_cast<char>(bits >> held & 0xff));
    }
  }
  return bytes;
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

// Addresses write a blank as %20.
std::string decode_percent(const std::string& uri) {
  std::string path;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    const bool escaped = uri[i] == '%' && i + 2 < uri.size() && hex_digit(uri[i + 1]) >= 0 && hex_digit(uri[i + 2]) >= 0;
    path += escaped ? static_cast<char>(16 * hex_digit(uri[i + 1]) + hex_digit(uri[i + 2])) : uri[i];
    if (escaped) i += 2;
  }
  return path;
}

// Typed values in a buffer [3.6.2].
struct Accessor {
  const char* first = nullptr;
  std::size_t count = 0;
  std::size_t stride = 0;
  int component_type = 0;
  bool normalized = false;
  std::string where;

  // KHR_mesh_quantization allows integers for positions; normalised ones by [3.6.2.2].
  template <class T>
  double as(const char* at) const {
    T value;
    std::memcpy(&value, at, sizeof value);
    if (!normalized || !std::is_integral_v<T>) return static_cast<double>(value);
    return std::max(static_cast<double>(value) / static_cast<double>(std::numeric_limits<T>::max()), -1.0);
  }

  double component(std::size_t item, std::size_t k) const {
    const char* at = first + item * stride;
    switch (component_type) {
      case 5120:
        return as<std::int8_t>(at + k);
      case 5121:
        return as<std::uint8_t>(at + k);
      case 5122:
        return as<std::int16_t>(at + 2 * k);
      case 5123:
        return as<std::uint16_t>(at + 2 * k);
      case 5125:
        return as<std::uint32_t>(at + 4 * k);
      default:
        return as<float>(at + 4 * k);
    }
  }
};

std::size_t component_bytes(std::size_t component_type) {
  switch (component_type) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    case 5125:
    case 5126:
      return 4;
    default:
      return 0;
  }
}

class GltfReader {
 public:
  GltfReader(std::string_view json, std::optional<std::string_view> binary, const std::filesystem::path& folder, std::string format)
      : json_(json), binary_(binary), folder_(folder) {
    raw_.format = std::move(format);
  }

  Result<RawMesh> read() {
    if (auto error = parse()) return tl::unexpected(std::move(*error));
    if (auto error = check_version()) return tl::unexpected(std::move(*error));
    const Result<std::vector<std::size_t>> roots = root_nodes();
    if (!roots) return tl::unexpected(roots.error());
    if (auto error = walk(*roots)) return tl::unexpected(std::move(*error));
    add_notes();
    raw_.end_parts();
    return std::move(raw_);
  }

 private:
  std::optional<Error> parse() {
    try {
      root_ = Json::parse(json_);
    } catch (const Json::exception& reason) {
      // "[json.exception.parse_error.101] parse error at line 1, column 5: ...; last read: ..."
      std::string what = reason.what();
      if (const auto bracket = what.find("] "); bracket != std::string::npos) what = what.substr(bracket + 2);
      if (const auto last = what.find("; last read"); last != std::string::npos) what = what.substr(0, last);
      for (char& c : what) c = c >= ' ' && c <= '~' ? c : '?';
      return Error{fmt::format("the JSON is broken or cut short ({}): copy or export the file again", what.substr(0, 160))};
    }
    return std::nullopt;
  }

  std::optional<Error> check_version() const {
    const std::string version = text_of(member(member(root_, "asset"), "version"));
    if (!version.starts_with("2.")) {
      return Error{fmt::format("is glTF version '{}', only 2.x can be read: export it as glTF 2.0", printable(version))};
    }
    for (const Json& extension : member(root_, "extensionsRequired")) {
      if (is_harmless(text_of(extension))) continue;
      return Error{fmt::format("needs the glTF extension '{}', which is not read: export it without (no compression)",
                               printable(text_of(extension)))};
    }
    return std::nullopt;
  }

  // The nodes of the scene to show [3.5.1]; of a file without scenes, those that are no one's children.
  Result<std::vector<std::size_t>> root_nodes() const {
    const Json& nodes = member(root_, "nodes");
    const Json& scenes = member(root_, "scenes");
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
    if (!member(root_, "scene").is_null()) {
      const auto index = index_of(member(root_, "scene"), scenes, "scene");
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

  struct Pending {
    std::size_t node;
    Eigen::Affine3d X_SP;  // parent in the scene
  };

  // Depth first with its own stack, so that a deep chain of nodes cannot exhaust ours. Each node hangs in one place [3.5.2].
  std::optional<Error> walk(const std::vector<std::size_t>& roots) {
    const Json& nodes = member(root_, "nodes");
    std::vector<bool> visited(size_of_array(nodes), false);
    std::vector<Pending> pending;
    for (auto root = roots.rbegin(); root != roots.rend(); ++root) pending.push_back({*root, Eigen::Affine3d::Identity()});
    while (!pending.empty()) {
      const Pending next = pending.back();
      pending.pop_back();
      const std::string where = fmt::format("nodes[{}]", next.node);
      if (visited[next.node]) return Error{fmt::format("{} hangs in two places or under itself: {}", where, kExportAgain)};
      visited[next.node] = true;
      const Json& node = nodes[next.node];
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

  std::optional<Error> add_node(const Json& node, std::size_t index, const Eigen::Affine3d& X_SN) {
    if (member(node, "mesh").is_null()) return std::nullopt;
    const Json& meshes = member(root_, "meshes");
    const auto mesh = index_of(member(node, "mesh"), meshes, fmt::format("nodes[{}].mesh", index));
    if (!mesh) return mesh.error();
    skinned_ += member(node, "skin").is_null() ? 0 : 1;
    std::string name = text_of(member(node, "name"));
    if (name.empty()) name = text_of(member(meshes[*mesh], "name"));
    raw_.begin_part(name.empty() ? fmt::format("node {}", index) : name);
    const Json& primitives = member(meshes[*mesh], "primitives");
    for (std::size_t p = 0; p < size_of_array(primitives); ++p) {
      if (auto error = add_primitive(primitives[p], fmt::format("meshes[{}].primitives[{}]", *mesh, p), X_SN)) return error;
    }
    return std::nullopt;
  }

  std::optional<Error> add_primitive(const Json& primitive, const std::string& where, const Eigen::Affine3d& X_SN) {
    const auto mode = count_or(member(primitive, "mode"), 4, where + ".mode");
    if (!mode) return mode.error();
    if (*mode < 4) {
      ++not_triangles_;
      return std::nullopt;
    }
    if (*mode > 6) return Error{fmt::format("{}.mode is {}, unknown: {}", where, *mode, kExportAgain)};
    morphed_ += size_of_array(member(primitive, "targets")) > 0 ? 1 : 0;
    const Json& position = member(member(primitive, "attributes"), "POSITION");
    if (position.is_null()) {
      ++not_triangles_;
      return std::nullopt;
    }
    const auto positions = accessor(position, where + ".attributes.POSITION", "VEC3", 3);
    if (!positions) return positions.error();
    const std::size_t first = raw_.mesh.vertices.size();
    if (auto error = add_vertices(*positions, X_SN)) return error;
    std::vector<std::uint32_t> corners;
    if (auto error = read_corners(primitive, where, first, positions->count, corners)) return error;
    read_normals(member(member(primitive, "attributes"), "NORMAL"), where, first, positions->count, X_SN);
    return add_triangles(corners, *mode, X_SN.linear().determinant() < 0, where);
  }

  std::optional<Error> add_vertices(const Accessor& positions, const Eigen::Affine3d& X_SN) {
    if (raw_.mesh.vertices.size() + positions.count > 3 * kMaxMeshTriangles) return too_large();
    for (std::size_t i = 0; i < positions.count; ++i) {
      const Vec3 p_NV(positions.component(i, 0), positions.component(i, 1), positions.component(i, 2));
      const Vec3 p_SV = X_SN * p_NV;
      if (!p_SV.allFinite())
        return Error{fmt::format("{}: vertex {} has a coordinate that is not finite: repair the mesh", positions.where, i)};
      raw_.mesh.vertices.push_back(p_SV);
    }
    return std::nullopt;
  }

  // By the inverse transpose, which keeps them at right angles to the surface [3.7.4]. Normals are welcome, not needed: where they cannot
  // be read they are computed.
  void read_normals(const Json& normal, const std::string& where, std::size_t first, std::size_t vertex_count,
                    const Eigen::Affine3d& X_SN) {
    normals_.clear();
    first_normal_ = first;
    if (normal.is_null()) return;
    const auto normals = accessor(normal, where + ".attributes.NORMAL", "VEC3", 3);
    if (!normals || normals->count != vertex_count) {
      ++bad_normals_;
      return;
    }
    const Eigen::Matrix3d turn = X_SN.linear().inverse().transpose();
    for (std::size_t i = 0; i < vertex_count; ++i) {
      const Vec3 n_S = turn * Vec3(normals->component(i, 0), normals->component(i, 1), normals->component(i, 2));
      normals_.push_back(n_S.normalized().cast<float>());
    }
  }

  std::optional<Error> read_corners(const Json& primitive, const std::string& where, std::size_t first, std::size_t vertex_count,
                                    std::vector<std::uint32_t>& corners) {
    const Json& indices = member(primitive, "indices");
    if (indices.is_null()) {
      for (std::size_t i = 0; i < vertex_count; ++i) corners.push_back(static_cast<std::uint32_t>(first + i));
      return std::nullopt;
    }
    const auto values = accessor(indices, where + ".indices", "SCALAR", 1);
    if (!values) return values.error();
    if (values->component_type == 5126) return Error{fmt::format("{} are not whole numbers: {}", values->where, kExportAgain)};
    corners.reserve(values->count);
    for (std::size_t i = 0; i < values->count; ++i) {
      const double index = values->component(i, 0);
      if (!(index >= 0 && index < static_cast<double>(vertex_count))) {
        return Error{fmt::format("{}: index {} is {}, out of range: there are {} vertices; {}", values->where, i, index, vertex_count,
                                 kExportAgain)};
      }
      corners.push_back(static_cast<std::uint32_t>(first) + static_cast<std::uint32_t>(index));
    }
    return std::nullopt;
  }

  // Lists, strips and fans [3.7.2.1]; a mirroring transform turns the winding round [3.7.4].
  std::optional<Error> add_triangles(const std::vector<std::uint32_t>& corners, std::size_t mode, bool mirrored, const std::string& where) {
    const std::size_t n = corners.size();
    if (mode == 4 && n % 3 != 0) return Error{fmt::format("{} has {} corners, not a multiple of 3: {}", where, n, kExportAgain)};
    if (raw_.mesh.triangles.size() + n > kMaxMeshTriangles) return too_large();
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      const Triangle triangle = mirrored ? Triangle{a, c, b} : Triangle{a, b, c};
      if (normals_.empty()) return raw_.mesh.triangles.push_back(triangle);
      raw_.add_triangle(
          triangle, {normals_[triangle[0] - first_normal_], normals_[triangle[1] - first_normal_], normals_[triangle[2] - first_normal_]});
    };
    if (mode == 4) {
      for (std::size_t i = 0; i + 2 < n; i += 3) add(corners[i], corners[i + 1], corners[i + 2]);
    } else {
      for (std::size_t i = 0; i + 2 < n; ++i) {
        if (mode == 6)
          add(corners[0], corners[i + 1], corners[i + 2]);
        else
          add(corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]);
      }
    }
    return std::nullopt;
  }

  static Error too_large() { return {fmt::format("has more than {} triangles with all its instances: simplify it", kMaxMeshTriangles)}; }

  Result<Accessor> accessor(const Json& index_json, const std::string& where, std::string_view type, std::size_t components) {
    const Json& accessors = member(root_, "accessors");
    const auto index = index_of(index_json, accessors, where);
    if (!index) return tl::unexpected(index.error());
    const Json& json = accessors[*index];
    Accessor result;
    result.where = fmt::format("accessors[{}]", *index);
    if (!member(json, "sparse").is_null()) return fail("{} is sparse, which is not read: export it without", result.where);
    if (text_of(member(json, "type")) != type) return fail("{} is not of type {}: {}", result.where, type, kExportAgain);
    const auto count = count_of(member(json, "count"), result.where + ".count");
    const auto component_type = count_of(member(json, "componentType"), result.where + ".componentType");
    const auto offset = count_or(member(json, "byteOffset"), 0, result.where + ".byteOffset");
    if (!count) return tl::unexpected(count.error());
    if (!component_type) return tl::unexpected(component_type.error());
    if (!offset) return tl::unexpected(offset.error());
    const std::size_t item_bytes = components * component_bytes(*component_type);
    if (item_bytes == 0) return fail("{}.componentType is {}, unknown: {}", result.where, *component_type, kExportAgain);
    std::size_t stride = 0;
    const Result<std::string_view> view = buffer_view(member(json, "bufferView"), result.where + ".bufferView", stride);
    if (!view) return tl::unexpected(view.error());
    result.stride = stride == 0 ? item_bytes : stride;
    if (result.stride < item_bytes) return fail("{}: its items overlap (stride {}): {}", result.where, stride, kExportAgain);
    const std::size_t room = *offset + item_bytes > view->size() ? 0 : (view->size() - *offset - item_bytes) / result.stride + 1;
    if (*count > room)
      return fail("{} promises {} items but its buffer view holds {}: cut short; copy or export it again", result.where, *count, room);
    result.first = view->data() + *offset;
    result.count = *count;
    result.component_type = static_cast<int>(*component_type);
    result.normalized = member(json, "normalized") == true;
    return result;
  }

  Result<std::string_view> buffer_view(const Json& index_json, const std::string& where, std::size_t& stride) {
    const Json& views = member(root_, "bufferViews");
    const auto index = index_of(index_json, views, where);
    if (!index) return tl::unexpected(index.error());
    const Json& json = views[*index];
    const std::string name = fmt::format("bufferViews[{}]", *index);
    const auto length = count_of(member(json, "byteLength"), name + ".byteLength");
    const auto offset = count_or(member(json, "byteOffset"), 0, name + ".byteOffset");
    const auto step = count_or(member(json, "byteStride"), 0, name + ".byteStride");
    if (!length) return tl::unexpected(length.error());
    if (!offset) return tl::unexpected(offset.error());
    if (!step) return tl::unexpected(step.error());
    Result<std::string_view> bytes = buffer(member(json, "buffer"), name + ".buffer");
    if (!bytes) return bytes;
    if (*offset + *length > bytes->size()) {
      return fail("{} ends at byte {} but its buffer has {}: cut short; copy or export it again", name, *offset + *length, bytes->size());
    }
    stride = *step;
    return bytes->substr(*offset, *length);
  }

  // Buffers are read when something needs them: what only textures need is never missed.
  Result<std::string_view> buffer(const Json& index_json, const std::string& where) {
    const Json& buffers = member(root_, "buffers");
    const auto index = index_of(index_json, buffers, where);
    if (!index) return tl::unexpected(index.error());
    const Json& uri = member(buffers[*index], "uri");
    const std::string name = fmt::format("buffers[{}]", *index);
    const auto length = count_of(member(buffers[*index], "byteLength"), name + ".byteLength");
    if (!length) return tl::unexpected(length.error());
    std::string_view bytes;
    if (uri.is_null() && *index == 0 && binary_) {
      bytes = *binary_;
    } else {
      auto loaded = loaded_.find(*index);
      if (loaded == loaded_.end()) {
        Result<std::string> read = load_buffer(text_of(uri), name);
        if (!read) return tl::unexpected(read.error());
        loaded = loaded_.emplace(*index, std::move(*read)).first;
      }
      bytes = loaded->second;
    }
    if (bytes.size() < *length)
      return fail("{} should have {} bytes but has {}: cut short; copy or export it again", name, *length, bytes.size());
    return bytes.substr(0, *length);
  }

  Result<std::string> load_buffer(const std::string& uri, const std::string& name) const {
    if (uri.empty()) return fail("{} has no uri and no binary chunk stands for it: {}", name, kExportAgain);
    if (uri.starts_with("data:")) {
      const auto comma = uri.find(";base64,");
      if (comma == std::string::npos) return fail("{} is inline but not base64: {}", name, kExportAgain);
      return decode_base64(std::string_view(uri).substr(comma + 8), name);
    }
    if (uri.find("://") != std::string::npos) return fail("{} is on the network ({}): fetch it beside the file", name, printable(uri));
    Result<std::string> bytes = read_file_bytes(folder_ / decode_percent(uri), kMaxMeshFileBytes);
    if (!bytes) return fail("{} cannot be read: {}", name, bytes.error().what);
    return bytes;
  }

  void add_notes() {
    if (not_triangles_ > 0)
      raw_.notes.push_back(fmt::format("{} primitives of points or lines, or without positions, were skipped", not_triangles_));
    if (skinned_ > 0) raw_.notes.push_back(fmt::format("{} skinned nodes are shown as they rest, not posed by their skeleton", skinned_));
    if (bad_normals_ > 0) raw_.notes.push_back(fmt::format("the normals of {} primitives cannot be read: computed there", bad_normals_));
    if (morphed_ > 0) raw_.notes.push_back(fmt::format("{} primitives have morph targets, which were skipped", morphed_));
  }

  std::string_view json_;
  std::optional<std::string_view> binary_;  // a GLB's second chunk
  std::filesystem::path folder_;
  RawMesh raw_;
  Json root_;
  std::map<std::size_t, std::string> loaded_;
  std::vector<Eigen::Vector3f> normals_;  // of this primitive's vertices; empty: it has none
  std::size_t first_normal_ = 0;          // the vertex of normals_[0]
  std::size_t bad_normals_ = 0;
  std::size_t not_triangles_ = 0;
  std::size_t skinned_ = 0;
  std::size_t morphed_ = 0;
};

std::uint32_t word_at(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, sizeof word);
  return word;
}

}  // namespace

Result<RawMesh> read_gltf(std::string_view bytes, const std::filesystem::path& folder) {
  return GltfReader(bytes, std::nullopt, folder, "glTF").read();
}

// Header and chunks of section [4.4].
Result<RawMesh> read_glb(std::string_view bytes, const std::filesystem::path& folder) {
  constexpr std::size_t kHeaderBytes = 12;
  constexpr std::size_t kChunkHeaderBytes = 8;
  constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
  constexpr std::uint32_t kBinaryChunk = 0x004E4942;
  if (!bytes.starts_with("glTF")) return fail("does not begin with 'glTF', so not a GLB file: check its extension");
  if (bytes.size() < kHeaderBytes) return fail("has {} bytes, fewer than a GLB header: copy or export it again", bytes.size());
  if (word_at(bytes, 4) != 2) return fail("is GLB version {}, only 2 can be read: export it as glTF 2.0", word_at(bytes, 4));
  if (word_at(bytes, 8) > bytes.size()) {
    return fail("should have {} bytes but has {}: cut short; copy or export it again", word_at(bytes, 8), bytes.size());
  }
  bytes = bytes.substr(0, word_at(bytes, 8));
  std::optional<std::string_view> json;
  std::optional<std::string_view> binary;
  for (std::size_t at = kHeaderBytes; at + kChunkHeaderBytes <= bytes.size();) {
    const std::size_t length = word_at(bytes, at);
    const std::uint32_t type = word_at(bytes, at + 4);
    if (length > bytes.size() - at - kChunkHeaderBytes) return fail("byte {}: a chunk reaches past the end: copy or export it again", at);
    const std::string_view chunk = bytes.substr(at + kChunkHeaderBytes, length);
    if (type == kJsonChunk && !json) json = chunk;
    if (type == kBinaryChunk && !binary) binary = chunk;
    at += kChunkHeaderBytes + length;
  }
  if (!json) return fail("has no JSON chunk: copy or export it again");
  return GltfReader(*json, binary, folder, "GLB").read();
}

}  // namespace hapton
