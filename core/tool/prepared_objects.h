#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/collision/built_objects.h"
#include "core/collision/marked_objects.h"
#include "core/tool/contact_surface.h"
#include "core/tool/tool_step.h"

namespace hapton {

// The objects of a scene, each prepared once for contact with the others. Any of them can become the tool: nothing that depends on one
// object alone is built for that, or built again when another object has moved.
//
// All are prepared in one local frame, that of the scene's bounding box, which the held object is part of. The axes of the tool are those
// of the scene when it is gripped, so that its surface is the prepared one with another origin. A probe can feel the same objects (built):
// it shares their geometries. Frame: S, metres. Threads: one. RT: set-up only.
class PreparedObjects {
 public:
  // One mesh for each object. shading_crease_rad: of the smooth normals that a probe needs; none: it needs none.
  explicit PreparedObjects(std::vector<std::shared_ptr<const TriangleMesh>> meshes,
                           std::optional<double> shading_crease_rad = std::nullopt);

  // An object is elsewhere, or another. Only that object has to be prepared again, unless the scene no longer suits its local frame.
  void replace(std::size_t object, std::shared_ptr<const TriangleMesh> mesh);
  // Prepares one object that is not prepared. False: all are.
  bool prepare_next();

  // The object as a tool, against all others, gripped at the stylus' pose X_SD; prepares what is not. friction, parts: of the others, in
  // order, as ToolStep::make has them; what moves is prepared where it is at rest. Error: as ToolStep::make.
  Result<std::unique_ptr<ToolStep>> hold(std::size_t object, const Pose& X_SD, const ToolCoupling& coupling,
                                         std::vector<CoulombFriction> friction = {}, std::unique_ptr<WorkerTeam> team = nullptr,
                                         std::vector<int> parts = {});

  // All objects for a probe, where they are now. Builds the geometries that are missing; marks of each other only where an object was
  // replaced since the last call. Null: the objects are too many or too large for a TouchGeometry.
  std::shared_ptr<const BuiltObjects> build();

  const LocalFrame& frame() const { return frame_; }
  std::size_t bytes() const;  // of what is prepared

 private:
  bool suits_frame(const Box& bounds) const;
  Box scene_bounds() const;
  const std::shared_ptr<const ObjectGeometry>& build_geometry(std::size_t object);

  std::vector<std::shared_ptr<const TriangleMesh>> meshes_;
  std::optional<double> shading_crease_rad_;
  std::vector<Box> bounds_;                                        // of each mesh
  std::vector<std::shared_ptr<const ObjectGeometry>> geometries_;  // by object; null: not yet
  std::vector<std::shared_ptr<const ContactSurface>> prepared_;    // by object; null: not yet
  MarkedObjects marked_;
  LocalFrame frame_;
  std::size_t most_triangles_;
};

}  // namespace hapton
