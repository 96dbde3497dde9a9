#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "core/collision/touch_geometry.h"
#include "core/tool/obb_tree.h"
#include "core/tool/surface_features.h"

namespace hapton {

// One object prepared for contact with other meshes: its geometry, features and tree, in the local frame of a scene. The same object can be
// a tool (ToolSurface) and part of a scene (SceneSurface), in any number of them.
// Threads: immutable. RT: set-up only.
class ContactSurface {
 public:
  // Of a geometry that may be shared.
  explicit ContactSurface(std::shared_ptr<const ObjectGeometry> geometry);
  ContactSurface(const ContactSurface&) = delete;
  ContactSurface& operator=(const ContactSurface&) = delete;

  const ObjectGeometry& geometry() const { return *geometry_; }
  const SurfaceFeatures& features() const { return features_; }
  const ObbTree& tree() const { return tree_; }
  std::size_t bytes() const { return geometry_->bytes() + features_.bytes() + tree_.bytes(); }

 private:
  std::shared_ptr<const ObjectGeometry> geometry_;
  SurfaceFeatures features_;
  ObbTree tree_;
};

// What the search for contacts needs of a tool, whatever the scene is.
struct ToolSurface {
  // Pre: the geometry outlives this.
  explicit ToolSurface(const ObjectGeometry& tool);
  // Of a prepared object with its origin at the grip point. tool: surface->geometry().about(grip).
  ToolSurface(const std::shared_ptr<const ContactSurface>& surface, const Vec3& grip, const ObjectGeometry& tool);

  std::shared_ptr<const SurfaceFeatures> features;  // the positions of their surface may have another origin
  ObbTree tree;
  double radius;  // largest distance of a point from the grip point
};

// What the search for contacts needs of a scene, whatever the tool is.
struct SceneSurface {
  // Pre: the geometry outlives this, and is built.
  explicit SceneSurface(const TouchGeometry& scene);
  // Of prepared objects, whose trees are joined. Pre: scene is made of their geometries.
  SceneSurface(const std::vector<std::shared_ptr<const ContactSurface>>& objects, const TouchGeometry& scene);

  std::vector<std::shared_ptr<const SurfaceFeatures>> features;  // by object
  ObbTree tree;                                                  // of all
};

}  // namespace hapton
