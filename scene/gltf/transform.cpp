#include "scene/gltf/transform.h"

#include <array>

namespace hapton::gltf {
namespace {

// An attribute of the instances of a node (EXT_mesh_gpu_instancing). A missing attribute stands for the identity.
struct InstanceAttribute {
  const char* name;
  std::string_view type;
  std::size_t components;
};

constexpr std::array kInstanceAttributes = {InstanceAttribute{"TRANSLATION", "VEC3", 3}, InstanceAttribute{"ROTATION", "VEC4", 4},
                                            InstanceAttribute{"SCALE", "VEC3", 3}};

Result<Quat> rotation_of(const Accessor& accessor, std::size_t i) {
  const Quat rotation(accessor.component(i, 3), accessor.component(i, 0), accessor.component(i, 1), accessor.component(i, 2));
  if (!rotation.coeffs().allFinite() || !(rotation.norm() > 0)) {
    return fail("{}: the rotation of instance {} is zero or not finite: {}", accessor.json_path, i, kExportAgain);
  }
  return rotation.normalized();
}

Result<Vec3> vector_of(const Accessor& accessor, std::size_t i) {
  const Vec3 vector(accessor.component(i, 0), accessor.component(i, 1), accessor.component(i, 2));
  if (!vector.allFinite()) return fail("{}: instance {} is not finite: {}", accessor.json_path, i, kExportAgain);
  return vector;
}

}  // namespace

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

Mat3 rest_rotation_of(const Json& node, const Eigen::Affine3d& X_PN) {
  if (!member(node, "matrix").is_null()) return X_PN.rotation();
  const auto q = numbers_of<4>(member(node, "rotation"), "");
  return q ? Quat((*q)[3], (*q)[0], (*q)[1], (*q)[2]).normalized().toRotationMatrix() : Mat3(Mat3::Identity());
}

Result<std::vector<Eigen::Affine3d>> instances_of(const Json& node, const Document& document, const std::string& where) {
  const Json& attributes = member(extension_of(node, "EXT_mesh_gpu_instancing"), "attributes");
  std::array<std::optional<Accessor>, kInstanceAttributes.size()> found;
  std::optional<std::size_t> count;
  for (std::size_t k = 0; k < found.size(); ++k) {
    const auto& [name, type, components] = kInstanceAttributes[k];
    if (member(attributes, name).is_null()) continue;
    Result<Accessor> values =
        read_accessor(document, member(attributes, name), fmt::format("{} of the instances of {}", name, where), type, components);
    if (!values) return tl::unexpected(values.error());
    if (count.value_or(values->count) != values->count) {
      return fail("{}: its instances have {} of one attribute and {} of another: {}", where, *count, values->count, kExportAgain);
    }
    count = values->count;
    found[k] = std::move(*values);
  }
  std::vector<Eigen::Affine3d> poses(count.value_or(1), Eigen::Affine3d::Identity());
  const auto& [translations, rotations, scales] = found;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Result<Vec3> translation = translations ? vector_of(*translations, i) : Vec3(Vec3::Zero());
    const Result<Quat> rotation = rotations ? rotation_of(*rotations, i) : Quat(Quat::Identity());
    const Result<Vec3> scale = scales ? vector_of(*scales, i) : Vec3(Vec3::Ones());
    if (!translation) return tl::unexpected(translation.error());
    if (!rotation) return tl::unexpected(rotation.error());
    if (!scale) return tl::unexpected(scale.error());
    poses[i].translate(*translation).rotate(*rotation).scale(*scale);
  }
  return poses;
}

}  // namespace hapton::gltf
