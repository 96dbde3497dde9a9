#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>

#include "core/geometry/mesh_measures.h"
#include "remote_touch/remote_methods.h"
#include "scene/touch_mesh.h"

namespace hapton {

// A mesh of the project, scaled to a longest side of 100 mm, with its middle at the origin.
inline std::shared_ptr<const TriangleMesh> real_mesh(const std::string& name) {
  auto file = load_touch_mesh(std::string(HAPTON_SOURCE_DIR) + "/meshes/" + name);
  if (!file) {
    ADD_FAILURE() << file.error().what;
    return nullptr;
  }
  const MeshBounds bounds = compute_bounds(file->mesh);
  for (Vec3& vertex : file->mesh.vertices) vertex = 0.1 / bounds.extent() * (vertex - bounds.centre());
  return std::make_shared<const TriangleMesh>(std::move(file->mesh));
}

}  // namespace hapton
