#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "core/collision/box.h"
#include "core/collision/built_objects.h"
#include "core/effects/space_effect.h"
#include "core/effects/surface_effects.h"
#include "core/geometry/mesh_deformation.h"
#include "core/geometry/triangle_mesh.h"
#include "core/math/keyframe_motion.h"
#include "core/sculpt/sculpt_settings.h"

namespace hapton {

class MappedSurface;

// Contact properties of a surface. SI units.
struct Material {
  double stiffness_n_per_m = 1000.0;
  double damping_ns_per_m = 0.0;
  double friction_static = 0.0;   // Coulomb, |F_t| <= mu_s F_n while stuck
  double friction_dynamic = 0.0;  // Coulomb, |F_t| = mu_d F_n while sliding; <= friction_static
  bool two_sided = true;          // false: contact only on the side that the normals point to
};

// One object of a scene: a mesh posed in the static scene. RT: set-up only.
struct TouchObject {
  std::shared_ptr<const TriangleMesh> mesh;  // frame S, metres
  Material material;
  SurfaceEffects effects = {};                                   // in addition to the material; TouchStep applies them
  std::shared_ptr<const KeyframeMotion> motion = nullptr;        // prescribed motion of the mesh from its rest pose; null: static
  std::shared_ptr<const MeshDeformation> deformation = nullptr;  // prescribed deformation of the mesh, before the motion; null: rigid
  std::optional<Vec3> command_pivot =
      {};  // the pivot about which a program may move the mesh (CommandedMotion), in place of `motion`; none: it may not

  // The largest distance, m, to which a program may move a vertex of the mesh from its position at rest (StreamedMethod), in place of
  // `deformation`. None: a program may not deform the mesh.
  std::optional<double> stream_reach_m = {};
  Mat3 stream_to_scene = Mat3::Identity();  // maps the displacements that the program gives to frame S

  std::optional<SculptSettings> sculpt = {};  // the mesh is a body of material that can be carved; none: it keeps its shape

  bool deforms() const { return deformation != nullptr || stream_reach_m.has_value(); }
  bool moves() const { return motion != nullptr || deforms() || command_pivot.has_value(); }
};

// All objects that can be touched. Frame S.
struct TouchScene {
  std::vector<TouchObject> objects;
  std::vector<SwitchedEffect> effects = {};  // in free space
  // If the objects are a part of a larger scene: the bounding box of that scene. All its parts then have the same local frame and the
  // same contact offset (object_geometry.h). Empty: the objects are the whole scene.
  Box part_of = {};
  // The objects as they were built before: a method that can use them (proxy) does not build these meshes again, and takes over their local
  // frame. Null, or built from other meshes: it builds all.
  std::shared_ptr<const BuiltObjects> built = nullptr;
  // By object: its surface with images, if it was prepared before, for TouchStep. Null, made from other triangles, or no entry for the
  // object: TouchStep prepares it.
  std::vector<std::shared_ptr<const MappedSurface>> mapped = {};

  bool has_effects() const {
    return !effects.empty() || std::ranges::any_of(objects, [](const TouchObject& object) { return object.effects.any(); });
  }
  bool has_deformation() const { return std::ranges::any_of(objects, &TouchObject::deforms); }
  bool has_streamed() const {
    return std::ranges::any_of(objects, [](const TouchObject& object) { return object.stream_reach_m.has_value(); });
  }
  bool has_commanded() const {
    return std::ranges::any_of(objects, [](const TouchObject& object) { return object.command_pivot.has_value(); });
  }
  bool has_sculpt() const {
    return std::ranges::any_of(objects, [](const TouchObject& object) { return object.sculpt.has_value(); });
  }
  // Whether any object moves by keyframes or by commands, or deforms.
  bool has_motion() const { return std::ranges::any_of(objects, &TouchObject::moves); }
};

}  // namespace hapton
