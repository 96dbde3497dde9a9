#pragma once

#include <utility>

#include "core/force/touch_scene.h"
#include "tests/support/made_meshes.h"

namespace hapton {

// A scene with one object.
inline TouchScene scene_of(TriangleMesh mesh, const Material& material = {}) {
  TouchScene scene;
  scene.objects.push_back({made::shared(std::move(mesh)), material});
  return scene;
}

}  // namespace hapton
