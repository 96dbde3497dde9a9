#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"
#include "scene/mesh_appearance.h"
#include "scene/scene_view.h"
#include "vision_node/detail_builder.h"
#include "vision_node/gl_program.h"
#include "vision_node/stereo_camera.h"
#include "vision_node/view_culling.h"

namespace hapton {

class SharedTextures;

// A mesh of the static scene. Frame S.
struct ShownObject {
  std::shared_ptr<const TriangleMesh> mesh;
  Vec3 colour = {0.7, 0.7, 0.72};
  std::shared_ptr<const MeshAppearance> appearance = {};  // instead of the colour; null: none
  bool shows_backs = false;                               // its triangles are drawn from behind, too, even in a pass that culls
};

// One eye's picture of the scene, and its drawing options.
struct ScenePass {
  Eye eye = Eye::centre;
  StereoScreen screen;
  PictureSize size;
  Pose X_WS = Pose::Identity();
  bool cull = true;        // leave out triangles seen from behind (memo 4.2.1), except those of objects with shows_backs
  bool plain = false;      // black background, no light
  bool depth_cues = true;  // ground, shadow, workspace, haze; none if plain
  bool is_even = false;    // the background has one colour only, as for a picture that turns with the viewer's head
};

// Counts for reports.
struct PaintCount {
  std::size_t triangles = 0;       // those of the levels drawn
  std::size_t sent_triangles = 0;  // those sent to the driver: without clusters out of sight
  double largest_error_px = 0.0;   // largest error of the levels drawn
};

// The stages in which the scene is drawn, in this order: what hides all behind it; what shows through, from the farthest to the nearest;
// and the depth of the latter, so that the pointer finds its surface where the hand feels it.
enum class PaintStage : std::uint8_t { solid, blended, blended_depth, done };

// Where paint_full() continues a picture.
struct PaintCursor {
  PaintStage stage = PaintStage::solid;
  std::size_t object = 0;   // index in the stage's order of objects
  std::size_t cluster = 0;  // index in the stage's order of clusters
  bool is_at_start() const { return stage == PaintStage::solid && object == 0 && cluster == 0; }
};

// Draws the static scene with OpenGL in the window's context, in its colours and textures, flat shaded under its lights or one that moves
// with the viewer, each mesh in a level of detail. A mesh is sent to the graphics driver once for all eyes. Threads: the window's; its
// context is current, also in the destructor.
class ScenePainter {
 public:
  // Triangles of a frame while the scene moves, of all objects together, unless a level with an invisible error has fewer (choose_level()).
  static constexpr std::size_t kTriangleBudget = 60'000;

  // Prepares the levels of detail, which other threads make. Error: the driver rejects the shaders.
  static Result<std::unique_ptr<ScenePainter>> make(const std::vector<ShownObject>& objects, std::vector<SceneLight> lights = {});
  ~ScenePainter();

  // From now on draws an object moved by X_SO from where its mesh has it, or leaves it out.
  void place_object(std::size_t object, const Pose& X_SO, bool is_shown);

  // Gives an object's mesh other vertices, as many as it has. From now on it has one level of detail, the new mesh. Linear in the mesh.
  void reshape_object(std::size_t object, std::vector<Vec3> vertices);

  // Draws these levels, from the finest to the coarsest, in place of an object's mesh, in the object's one colour. Frame: U of that mesh
  // (make_detail_frame). Pre: at least one level.
  void replace_object(std::size_t object, std::vector<FlatLevel> levels);

  // Makes all triangles of large meshes ready at once; otherwise only a part of them is drawn until the builder has prepared all. Takes a
  // tenth of a second.
  void complete();

  // Takes the levels made since the last call. True if there are any, so that a picture may look better than the last one.
  bool take_levels();
  // Share of all levels of detail that has been made, 0 to 1.
  double progress() const { return builder_->progress(); }

  // Draws what lies behind and around the scene over everything in the bound framebuffer; it does not depend on the scene's pose.
  void paint_background(const ScenePass& pass) const;
  // Draws the scene and its shadow, with their depth, in levels that are good enough while the scene moves.
  PaintCount paint(const ScenePass& pass);
  // Draws a part of the scene in full detail: from the cursor on, about that many triangles. True when the picture is complete.
  bool paint_full(const ScenePass& pass, PaintCursor& cursor, std::size_t triangles);
  // Whether paint() draws the meshes themselves in that pass; false while levels are being made.
  bool is_full(const ScenePass& pass) const;

 private:
  struct Object;
  ScenePainter();
  std::size_t choose_level_of(const Object& object, const ScenePass& pass, double* error_px = nullptr) const;
  static DetailLevel make_whole_level(const ShownObject& shown, SharedTextures& textures, Object& object);
  static DetailLevel make_level_of(const TriangleMesh& mesh, const Object& object);
  void begin_reshape(Object& object);
  Result<void> make_programs();
  void upload_lines();
  void paint_lines(const ScenePass& pass) const;
  void paint_shadow(const ScenePass& pass);
  void begin_objects(const ScenePass& pass) const;
  static void begin_stage(PaintStage stage);
  bool has_blended() const;
  // Numbers of the objects that the stage draws, in the order in which it draws them.
  std::vector<std::size_t> order_objects(PaintStage stage, const ScenePass& pass) const;
  struct ClusterRange;
  void gather(const Object& object, const FlatLevel& level, const ClusterRange& range, const Mat4& to_clip, const Vec3& p_UE,
              DrawnSides sides);
  std::size_t paint_part(const Object& object, std::size_t level, const ScenePass& pass, const ClusterRange& range);
  void paint_visible(const Object& object, std::uint32_t vertices, const Mat4& to_clip, const Mat4& to_eye) const;

  std::vector<SceneLight> lights_;  // empty: the one that moves with the viewer
  std::vector<std::unique_ptr<Object>> objects_;
  std::size_t all_triangles_ = 0;
  std::unique_ptr<GlProgram> shaded_program_, painted_program_, finish_program_, background_program_, colour_program_;
  std::uint32_t index_buffer_ = 0, empty_vertices_ = 0;
  std::uint32_t line_vertices_ = 0, line_buffer_ = 0;
  int grid_corners_ = 0;
  std::vector<std::uint32_t> visible_;
  std::unique_ptr<DetailBuilder> builder_;
};

}  // namespace hapton
