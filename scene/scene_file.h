#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/force/touch_scene.h"
#include "core/geometry/triangle_mesh.h"
#include "core/sculpt/sculpt_settings.h"
#include "scene/commanded_object.h"
#include "scene/library_effect.h"
#include "scene/program_shape.h"
#include "scene/scene_loading.h"
#include "scene/scene_tool.h"
#include "scene/scene_view.h"

namespace hapton {

// An object of the scene, drawn and touched.
struct SceneObject {
  std::string name;
  std::shared_ptr<const TriangleMesh> mesh;  // frame S, metres, pose and scale baked in
  Material material;
  std::array<double, 3> colour = {0.7, 0.7, 0.72};          // sRGB, 0..1
  SealReport sealed = {};                                   // how cracks in the mesh were sealed; widths in S
  std::shared_ptr<const MeshAppearance> appearance = {};    // from the mesh file, in place of the colour; null: none
  SurfaceEffects effects = {};                              // those of its material
  std::string material_name = {};                           // as in the scene file; empty: the default material
  bool is_movable = false;                                  // the stylus can pick it up
  std::shared_ptr<const KeyframeMotion> motion = {};        // moves it by itself; null: it stands still
  std::shared_ptr<const MeshDeformation> deformation = {};  // deforms its mesh by itself, before the motion; null: it is rigid
  std::shared_ptr<const CommandedObject> commanded = {};    // programs may move it; null: they may not
  std::shared_ptr<const ProgramShape> program_shape = {};   // programs deform it; null: they do not
  std::optional<SculptSettings> sculpt = {};                // a body of material that can be carved; none: it keeps its shape
  double mass_kg = 0.0;                                     // above 0: it can be pushed (`hapton dynamics`), and `commanded` is set
  std::size_t line = 0;                                     // line in the scene file; 0: none

  bool deforms() const { return deformation != nullptr || program_shape != nullptr; }
  bool moves() const { return motion != nullptr || deforms() || commanded != nullptr; }
};

// An effect in free space.
struct SceneEffect {
  std::string name;
  SpaceEffect effect;    // frame S
  EffectSwitch on = {};  // when it acts: always, or while a button is held
};

// All objects of a scene. Frame S.
struct Scene {
  std::vector<SceneObject> objects;  // at least one
  std::vector<SceneEffect> effects;
  std::vector<LibraryEffect> libraries = {};  // effects from plug-ins, which are not loaded here
  std::vector<std::string> notes;             // warnings: skipped or suspicious content, one line each
  // Hash of the meshes' files, poses, motions, shapes and fit, independent of file paths and (without morphs) of sealing. Never 0.
  std::uint64_t given_hash = 0;
  std::optional<SceneTool> tool = {};  // held by the stylus in place of a probe; none: there is a probe
  double fit_scale = 1.0;              // factor of all lengths by which the scene was fitted
  SceneView view = {};                 // camera and lights

  // The scene as input of the force methods; the meshes are shared.
  TouchScene touch_scene() const;
};

// Reads a scene file (TOML, docs/scene-files.md has every key) or a plain mesh file, which makes a scene of one object or, with several
// haptic materials, of one for each. With loading.sealing off no cracks are sealed; a scene file can also switch sealing off for one
// object. Sealing does not move anything else: the scene is fitted to the meshes before sealing. RT: set-up only. Error: one line with the
// file, the line in it and what to do: unknown keys with the nearest known one, values out of their range, whatever load_mesh_file
// rejects.
Result<Scene> load_scene(const std::filesystem::path& path, const SceneLoading& loading = {});

}  // namespace hapton
