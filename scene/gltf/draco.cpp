#include "scene/gltf/draco.h"

#include "scene/gltf/json.h"

#ifdef HAPTON_DRACO

// Draco's own headers cause these warnings.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wextra"
#include <draco/compression/config/compression_shared.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>
#pragma GCC diagnostic pop

#include <array>
#include <cstring>
#include <exception>
#include <limits>
#include <type_traits>

namespace hapton::gltf {
namespace {

// Draco allocates memory for the counts in its header. A regular mesh of one repeated pattern needs the fewest bits: a plane grid of half
// a million triangles has 22 triangles per byte (tests/scene/gltf/draco_test.cpp measures it). The limit is about ten times that. Small
// meshes stay far below it, because tables take most of their bytes.
constexpr std::size_t kMaxTrianglesPerByte = 256;
constexpr std::size_t kMaxAttributes = 64;
constexpr std::size_t kMaxBytesPerPoint = 1024;

// One of Draco's decoders, with limits at the two places where it allocates memory for counts that the stream states.
template <class Decoder>
class Bounded : public Decoder {
 public:
  explicit Bounded(std::size_t max_triangles) : max_triangles_(max_triangles) {}
  bool exceeded() const { return exceeded_; }

 protected:
  // Both kinds begin with two counts: vertices and faces (edgebreaker), or faces and points (sequential). Each is at most 3 per triangle.
  bool DecodeConnectivity() override {
    draco::DecoderBuffer ahead = *this->buffer();
    std::uint32_t first = 0;
    std::uint32_t second = 0;
    if (!draco::DecodeVarint(&first, &ahead) || !draco::DecodeVarint(&second, &ahead)) return false;
    exceeded_ = first > 3 * max_triangles_ || second > 3 * max_triangles_;
    return !exceeded_ && Decoder::DecodeConnectivity();
  }

  bool DecodeAllAttributes() override {
    const auto count = static_cast<std::size_t>(this->point_cloud()->num_attributes());
    std::size_t bytes = 0;
    for (std::size_t a = 0; a < count; ++a) {
      const draco::PointAttribute& attribute = *this->point_cloud()->attribute(static_cast<int>(a));
      bytes += attribute.num_components() * sizeof(std::int32_t) + static_cast<std::size_t>(draco::DataTypeLength(attribute.data_type()));
    }
    exceeded_ = count > kMaxAttributes || bytes > kMaxBytesPerPoint || this->point_cloud()->num_points() > 3 * max_triangles_;
    return !exceeded_ && Decoder::DecodeAllAttributes();
  }

 private:
  std::size_t max_triangles_;
  bool exceeded_ = false;
};

template <class Decoder>
std::optional<Error> decode_with(std::string_view bytes, std::size_t max_triangles, const std::string& where, draco::Mesh& mesh) {
  Bounded<Decoder> decoder(max_triangles);
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  // Draco throws no exceptions itself, but the standard library that it uses may, when memory runs out.
  try {
    const draco::Status status = decoder.Decode(draco::DecoderOptions(), &buffer, &mesh);
    if (status.ok()) return std::nullopt;
  } catch (const std::exception&) {
    return Error{fmt::format("{}: its Draco data need more memory than there is: simplify it", where)};
  }
  if (decoder.exceeded()) {
    return Error{fmt::format("{}: its Draco data promise more triangles or attributes than {} bytes can hold, or than are read: {}", where,
                             bytes.size(), kExportAgain)};
  }
  return Error{fmt::format("{}: its Draco data are broken: copy or export it again", where)};
}

std::optional<Error> decode_any(std::string_view bytes, std::size_t max_triangles, const std::string& where, draco::Mesh& mesh) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::DracoHeader header = {};
  if (!draco::PointCloudDecoder::DecodeHeader(&buffer, &header).ok())
    return Error{fmt::format("{}: holds no Draco data: {}", where, kExportAgain)};
  if (header.encoder_type != draco::TRIANGULAR_MESH)
    return Error{fmt::format("{}: its Draco data are not a triangle mesh: {}", where, kExportAgain)};
  if (header.version_major != 2 || header.version_minor != 2) {
    return Error{fmt::format("{}: its Draco data are of version {}.{}, and glTF has 2.2: {}", where, header.version_major,
                             header.version_minor, kExportAgain)};
  }
  if (header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING) {
    return decode_with<draco::MeshEdgebreakerDecoder>(bytes, max_triangles, where, mesh);
  }
  return decode_with<draco::MeshSequentialDecoder>(bytes, max_triangles, where, mesh);
}

// The number that glTF 2.0 gives this type as the component type of an accessor [3.6.2.2]. 0: glTF has no such type.
std::size_t component_type_of(draco::DataType type) {
  switch (type) {
    case draco::DT_INT8:
      return 5120;
    case draco::DT_UINT8:
      return 5121;
    case draco::DT_INT16:
      return 5122;
    case draco::DT_UINT16:
      return 5123;
    case draco::DT_UINT32:
      return 5125;
    case draco::DT_FLOAT32:
      return 5126;
    default:
      return 0;
  }
}

// A hostile stream may place values anywhere in its memory. So each value is copied, not read in place as by Draco's own ConvertValue.
DracoValues values_of(const draco::Mesh& mesh, std::uint32_t id) {
  const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(id);
  if (attribute == nullptr || attribute->buffer() == nullptr || attribute->num_components() < 1) return {};
  DracoValues values{static_cast<std::size_t>(attribute->num_components()), component_type_of(attribute->data_type()), {}};
  if (values.component_type == 0) return {};
  if (!attribute->is_mapping_identity() && attribute->indices_map_size() < mesh.num_points()) return {};
  const std::size_t item_bytes = values.components * static_cast<std::size_t>(draco::DataTypeLength(attribute->data_type()));
  values.bytes.resize(mesh.num_points() * item_bytes);
  for (std::uint32_t point = 0; point < mesh.num_points(); ++point) {
    const draco::AttributeValueIndex index = attribute->mapped_index(draco::PointIndex(point));
    if (index.value() >= attribute->size()) return {};
    const auto start = static_cast<std::size_t>(attribute->GetBytePos(index));
    if (start > attribute->buffer()->data_size() || attribute->buffer()->data_size() - start < item_bytes) return {};
    std::memcpy(values.bytes.data() + point * item_bytes, attribute->buffer()->data() + start, item_bytes);
  }
  return values;
}

template <class Component>
Eigen::Vector3f read_vector(const char* bytes, bool normalized) {
  std::array<Component, 3> components;
  std::memcpy(components.data(), bytes, sizeof components);
  const Eigen::Vector3f value(static_cast<float>(components[0]), static_cast<float>(components[1]), static_cast<float>(components[2]));
  if (!std::is_integral_v<Component> || !normalized) return value;
  return (value / static_cast<float>(std::numeric_limits<Component>::max())).cwiseMax(-1.0F);  // as in accessors [3.6.2.2]
}

using VectorReader = Eigen::Vector3f (*)(const char*, bool);

// Reads three components of a type that glTF or KHR_mesh_quantization allows for positions and normals. Null: it is another type.
VectorReader reader_of(std::size_t component_type) {
  switch (component_type) {
    case 5120:
      return read_vector<std::int8_t>;
    case 5121:
      return read_vector<std::uint8_t>;
    case 5122:
      return read_vector<std::int16_t>;
    case 5123:
      return read_vector<std::uint16_t>;
    case 5126:
      return read_vector<float>;
    default:
      return nullptr;
  }
}

// One vector per point. Empty: there is no such attribute, or its values are not three numbers of a type that reader_of knows.
std::vector<Eigen::Vector3f> vectors_of(const draco::Mesh& mesh, std::uint32_t id) {
  const DracoValues values = values_of(mesh, id);
  const VectorReader read = reader_of(values.component_type);
  if (values.bytes.empty() || values.components != 3 || read == nullptr) return {};
  const bool normalized = mesh.GetAttributeByUniqueId(id)->normalized();
  const std::size_t item_bytes = values.bytes.size() / mesh.num_points();
  std::vector<Eigen::Vector3f> vectors(mesh.num_points());
  for (std::size_t point = 0; point < vectors.size(); ++point) vectors[point] = read(values.bytes.data() + point * item_bytes, normalized);
  return vectors;
}

}  // namespace

Result<DracoMesh> decode_draco(std::string_view bytes, const DracoRequest& request, const std::string& where) {
  const std::size_t max_triangles = std::min(request.max_triangles, kMaxTrianglesPerByte * bytes.size());
  draco::Mesh mesh;
  if (auto error = decode_any(bytes, max_triangles, where, mesh)) return tl::unexpected(std::move(*error));
  if (mesh.num_faces() > max_triangles) return fail("{}: its Draco data hold more than {} triangles: simplify it", where, max_triangles);
  DracoMesh result;
  result.positions = vectors_of(mesh, request.position);
  if (result.positions.empty()) return fail("{}: its Draco data have no positions of id {}: {}", where, request.position, kExportAgain);
  if (request.normal) result.normals = vectors_of(mesh, *request.normal);
  for (const std::uint32_t id : request.others) result.others.push_back(values_of(mesh, id));
  result.corners.reserve(std::size_t{3} * mesh.num_faces());
  for (draco::FaceIndex face(0); face < mesh.num_faces(); ++face) {
    for (const draco::PointIndex& corner : mesh.face(face)) {
      if (corner.value() >= result.positions.size())
        return fail("{}: a triangle of its Draco data names a vertex that is not there: {}", where, kExportAgain);
      result.corners.push_back(corner.value());
    }
  }
  return result;
}

}  // namespace hapton::gltf

#else

namespace hapton::gltf {

Result<DracoMesh> decode_draco(std::string_view, const DracoRequest&, const std::string& where) {
  return fail("{}: is compressed with Draco, which this build lacks: install libdraco-dev and build again, or export it without", where);
}

}  // namespace hapton::gltf

#endif
