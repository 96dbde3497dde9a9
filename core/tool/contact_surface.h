#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "core/collision/touch_geometry.h"
#include "core/tool/obb_tree.h"
#include "core/tool/surface_features.h"

namespace hapton {

// One object prepared for contact with other meshes: its geometry, features and tree, in the local frame of a scene. The same object can be
// a tool (ToolSurface) and part of a scene (SceneSurface), in any number of tools and scenes.
// Threads: immutable. RT: set-up only.
class ContactSurface {
 public:
  // geometry: may be shared with others.
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

// The data of a tool for the search for contacts, the same for every scene. Frame: the tool's axes from the grip point, local units.
struct ToolSurface {
  // Pre: the geometry outlives this.
  explicit ToolSurface(const ObjectGeometry& tool);
  // Makes a tool of a prepared object, with its origin moved to `grip`. tool: surface->geometry().with_origin_at(grip).
  ToolSurface(const std::shared_ptr<const ContactSurface>& surface, const Vec3& grip, const ObjectGeometry& tool);

  std::shared_ptr<const SurfaceFeatures> features;  // positions of their surface may have an origin other than the grip point
  ObbTree tree;
  double radius;  // largest distance of a point from the grip point
};

// The data of a scene for the search for contacts, the same for every tool.
struct SceneSurface {
  // Pre: the geometry outlives this, and all its objects are built.
  explicit SceneSurface(const TouchGeometry& scene);
  // Makes a scene of prepared objects, whose trees it joins. Pre: `scene` is made of their geometries, in the same order.
  SceneSurface(const std::vector<std::shared_ptr<const ContactSurface>>& objects, const TouchGeometry& scene);

  std::vector<std::shared_ptr<const SurfaceFeatures>> features;  // by object
  ObbTree tree;                                                  // over all objects
};

}  // namespace hapton
