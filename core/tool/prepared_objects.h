#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/collision/built_objects.h"
#include "core/collision/marked_objects.h"
#include "core/tool/contact_surface.h"
#include "core/tool/tool_step.h"

namespace hapton {

// The objects of a scene, each prepared once for contact with the others. Any of them can become the tool: what depends on one object
// alone is not built again for that, nor when another object has moved.
//
// All are prepared in one local frame, that of the bounding box of all objects, the held one included. The tool's axes are those of the
// scene at the moment when it is gripped, so that its surface is the prepared one with another origin. A probe can feel the same objects
// (build()): it shares their geometries. Frame: S, metres. Threads: one. RT: set-up only.
class PreparedObjects {
 public:
  // One mesh for each object. shading_crease_rad: crease angle of the smooth normals for a probe; nullopt: no smooth normals.
  explicit PreparedObjects(std::vector<std::shared_ptr<const TriangleMesh>> meshes,
                           std::optional<double> shading_crease_rad = std::nullopt);

  // The object has moved or changed. Only it has to be prepared again, unless the local frame or the triangle numbering no longer suits.
  void replace(std::size_t object, std::shared_ptr<const TriangleMesh> mesh);
  // Prepares one object that is not prepared yet. False: all objects are prepared.
  bool prepare_next();

  // The object as a tool, in contact with all others, gripped at the stylus' pose X_SD; prepares the objects that are not yet. friction,
  // parts: of the others, in order, as in ToolStep::make; objects that move are prepared in their pose at rest. Error: as ToolStep::make.
  Result<std::unique_ptr<ToolStep>> hold(std::size_t object, const Pose& X_SD, const ToolCoupling& coupling,
                                         std::vector<CoulombFriction> friction = {}, std::unique_ptr<WorkerTeam> team = nullptr,
                                         std::vector<int> parts = {});

  // All objects for a probe, in their present places. Builds the missing geometries; updates the marks that objects have because of each
  // other (MarkedObjects) only for objects replaced since the last call. Null: the objects are too many or too large for a TouchGeometry.
  std::shared_ptr<const BuiltObjects> build();

  const LocalFrame& frame() const { return frame_; }
  std::size_t bytes() const;  // memory of the prepared objects

 private:
  bool suits_frame(const Box& bounds) const;
  Box scene_bounds() const;
  const std::shared_ptr<const ObjectGeometry>& build_geometry(std::size_t object);

  std::vector<std::shared_ptr<const TriangleMesh>> meshes_;
  std::optional<double> shading_crease_rad_;
  std::vector<Box> bounds_;                                        // of each mesh
  std::vector<std::shared_ptr<const ObjectGeometry>> geometries_;  // by object; null: not built yet
  std::vector<std::shared_ptr<const ContactSurface>> prepared_;    // by object; null: not prepared yet
  MarkedObjects marked_;
  LocalFrame frame_;
  std::size_t most_triangles_;
};

}  // namespace hapton
