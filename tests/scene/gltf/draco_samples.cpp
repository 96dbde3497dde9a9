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

void add_values(draco::Mesh& mesh, draco::GeometryAttribute::Type type, const std::vector<Eigen::Vector3f>& values) {
  draco::GeometryAttribute attribute;
  attribute.Init(type, nullptr, 3, draco::DT_FLOAT32, false, 3 * sizeof(float), 0);
  const int id = mesh.AddAttribute(attribute, true, static_cast<std::uint32_t>(values.size()));
  for (std::uint32_t i = 0; i < values.size(); ++i) mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i), values[i].data());
}

}  // namespace

std::string draco(const TriangleMesh& mesh, DracoKind kind, const std::vector<Eigen::Vector3f>& normals, int quantization, int speed) {
  draco::Mesh packed;
  packed.set_num_points(static_cast<std::uint32_t>(mesh.vertices.size()));
  std::vector<Eigen::Vector3f> positions;
  for (const Vec3& v : mesh.vertices) positions.push_back(v.cast<float>());
  add_values(packed, draco::GeometryAttribute::POSITION, positions);
  if (!normals.empty()) add_values(packed, draco::GeometryAttribute::NORMAL, normals);
  for (const Triangle& t : mesh.triangles) packed.AddFace({draco::PointIndex(t[0]), draco::PointIndex(t[1]), draco::PointIndex(t[2])});
  draco::Encoder encoder;
  encoder.SetEncodingMethod(kind == DracoKind::edgebreaker ? draco::MESH_EDGEBREAKER_ENCODING : draco::MESH_SEQUENTIAL_ENCODING);
  encoder.SetSpeedOptions(speed, speed);
  if (quantization > 0) encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, quantization);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeMeshToBuffer(packed, &buffer).ok()) return {};
  return {buffer.data(), buffer.size()};
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
