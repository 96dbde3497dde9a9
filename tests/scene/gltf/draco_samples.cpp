#include "tests/scene/gltf/draco_samples.h"

#ifdef HAPTON_DRACO

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wextra"
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#pragma GCC diagnostic pop

#include "tests/scene/gltf/gltf_samples.h"

namespace hapton::sample {
namespace {

template <class Value>
void add_values(draco::Mesh& mesh, draco::GeometryAttribute::Type type, const std::vector<Value>& values) {
  constexpr bool kIsBytes = sizeof(Value) == 4;
  draco::GeometryAttribute attribute;
  attribute.Init(type, nullptr, kIsBytes ? 4 : sizeof(Value) / sizeof(float), kIsBytes ? draco::DT_UINT8 : draco::DT_FLOAT32, kIsBytes,
                 sizeof(Value), 0);
  const int id = mesh.AddAttribute(attribute, true, static_cast<std::uint32_t>(values.size()));
  for (std::uint32_t i = 0; i < values.size(); ++i) mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i), values[i].data());
}

void add_mesh(draco::Mesh& packed, const TriangleMesh& mesh) {
  packed.set_num_points(static_cast<std::uint32_t>(mesh.vertices.size()));
  std::vector<Eigen::Vector3f> positions;
  for (const Vec3& v : mesh.vertices) positions.push_back(v.cast<float>());
  add_values(packed, draco::GeometryAttribute::POSITION, positions);
  for (const Triangle& t : mesh.triangles) packed.AddFace({draco::PointIndex(t[0]), draco::PointIndex(t[1]), draco::PointIndex(t[2])});
}

std::string encode(const draco::Mesh& packed, DracoKind kind, int quantization, int speed) {
  draco::Encoder encoder;
  encoder.SetEncodingMethod(kind == DracoKind::edgebreaker ? draco::MESH_EDGEBREAKER_ENCODING : draco::MESH_SEQUENTIAL_ENCODING);
  encoder.SetSpeedOptions(speed, speed);
  if (quantization > 0) encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, quantization);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeMeshToBuffer(packed, &buffer).ok()) return {};
  return {buffer.data(), buffer.size()};
}

}  // namespace

std::string draco(const TriangleMesh& mesh, DracoKind kind, const std::vector<Eigen::Vector3f>& normals, int quantization, int speed) {
  draco::Mesh packed;
  add_mesh(packed, mesh);
  if (!normals.empty()) add_values(packed, draco::GeometryAttribute::NORMAL, normals);
  return encode(packed, kind, quantization, speed);
}

namespace {

template <class Component>
void add_integers(draco::Mesh& mesh, draco::DataType type, bool is_normalized, const std::vector<std::array<std::int32_t, 3>>& values) {
  draco::GeometryAttribute attribute;
  attribute.Init(draco::GeometryAttribute::POSITION, nullptr, 3, type, is_normalized, 3 * sizeof(Component), 0);
  const int id = mesh.AddAttribute(attribute, true, static_cast<std::uint32_t>(values.size()));
  for (std::uint32_t i = 0; i < values.size(); ++i) {
    const std::array<Component, 3> value = {static_cast<Component>(values[i][0]), static_cast<Component>(values[i][1]),
                                            static_cast<Component>(values[i][2])};
    mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i), value.data());
  }
}

}  // namespace

std::string draco_of_integers(const std::vector<std::array<std::int32_t, 3>>& corners, std::size_t component_type, bool is_normalized) {
  draco::Mesh packed;
  packed.set_num_points(static_cast<std::uint32_t>(corners.size()));
  if (component_type == 5120) add_integers<std::int8_t>(packed, draco::DT_INT8, is_normalized, corners);
  if (component_type == 5121) add_integers<std::uint8_t>(packed, draco::DT_UINT8, is_normalized, corners);
  if (component_type == 5122) add_integers<std::int16_t>(packed, draco::DT_INT16, is_normalized, corners);
  if (component_type == 5123) add_integers<std::uint16_t>(packed, draco::DT_UINT16, is_normalized, corners);
  for (std::uint32_t c = 0; c < corners.size(); c += 3)
    packed.AddFace({draco::PointIndex(c), draco::PointIndex(c + 1), draco::PointIndex(c + 2)});
  return encode(packed, DracoKind::sequential, 0, 5);
}

Eigen::Vector2f draco_texcoord(const Vec3& p) { return {static_cast<float>(0.5 + 0.5 * p.x()), static_cast<float>(0.5 - 0.5 * p.z())}; }

std::array<std::uint8_t, 4> draco_colour(const Vec3& p) {
  return {p.x() > 0.0 ? std::uint8_t{255} : std::uint8_t{0}, p.y() > 0.0 ? std::uint8_t{255} : std::uint8_t{0}, 0, 128};
}

std::string draco_with_appearance(const TriangleMesh& mesh, DracoKind kind) {
  draco::Mesh packed;
  add_mesh(packed, mesh);
  std::vector<Eigen::Vector2f> texcoords;
  std::vector<std::array<std::uint8_t, 4>> colours;
  for (const Vec3& v : mesh.vertices) {
    texcoords.push_back(draco_texcoord(v));
    colours.push_back(draco_colour(v));
  }
  add_values(packed, draco::GeometryAttribute::TEX_COORD, texcoords);
  add_values(packed, draco::GeometryAttribute::COLOR, colours);
  return encode(packed, kind, 0, 5);
}

std::string draco_appearance_glb(const TriangleMesh& mesh, const std::string& packed, const std::string& image,
                                 const std::string& mesh_members, const std::string& document_members) {
  Pieces pieces;
  pieces.add(packed);
  pieces.add(image);
  const std::string accessors =
      fmt::format(R"({{"componentType":5126,"count":{0},"type":"VEC3"}},{{"componentType":5125,"count":{1},"type":"SCALAR"}},)"
                  R"({{"componentType":5126,"count":{0},"type":"VEC2"}},)"
                  R"({{"componentType":5121,"count":{0},"type":"VEC4","normalized":true}})",
                  mesh.vertices.size(), 3 * mesh.triangles.size());
  const std::string rest = fmt::format(
      R"({}"materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}},"alphaMode":"BLEND"}}],"textures":[{{"source":0}}],)"
      R"("images":[{{"bufferView":1,"mimeType":"image/png"}}],"nodes":[{{"mesh":0}}],)"
      R"("meshes":[{{{}"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":2,"COLOR_0":3}},"indices":1,"material":0,"extensions":)"
      R"({{"KHR_draco_mesh_compression":{{"bufferView":0,"attributes":{{"POSITION":0,"TEXCOORD_0":1,"COLOR_0":2}}}}}}}}]}}])",
      document_members, mesh_members);
  return pieces.glb(accessors, rest);
}

std::string draco_glb(const TriangleMesh& mesh, const std::string& packed, bool has_normals) {
  Pieces pieces;
  pieces.add(packed);
  const std::string normal = has_normals ? R"(,"NORMAL":2)" : "";
  const std::string accessors =
      fmt::format(R"({{"componentType":5126,"count":{0},"type":"VEC3"}},{{"componentType":5125,"count":{1},"type":"SCALAR"}},)"
                  R"({{"componentType":5126,"count":{0},"type":"VEC3"}})",
                  mesh.vertices.size(), 3 * mesh.triangles.size());
  const std::string rest = fmt::format(
      R"("extensionsUsed":["KHR_draco_mesh_compression"],"extensionsRequired":["KHR_draco_mesh_compression"],"nodes":[{{"mesh":0}}],)"
      R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":0{}}},"indices":1,"extensions":{{"KHR_draco_mesh_compression":)"
      R"({{"bufferView":0,"attributes":{{"POSITION":0{}}}}}}}}}]}}])",
      normal, has_normals ? R"(,"NORMAL":1)" : "");
  return pieces.glb(accessors, rest);
}

}  // namespace hapton::sample

#endif
