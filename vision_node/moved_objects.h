#pragma once

#include <optional>
#include <vector>

#include "core/math/commanded_motion.h"
#include "link/haptics_source.h"
#include "link/known_shapes.h"
#include "link/messages.h"
#include "scene/scene_file.h"
#include "vision_node/stereo_view.h"

namespace hapton {

// Draws objects where the haptics node has them: an object that the stylus picked up at the stylus, others where they were put down; those
// that move by keyframes or programs, or deform, in the place and shape that they have at the time of the sample that is shown. Threads:
// the window's. RT: no.
class MovedObjects {
 public:
  // Pre: both outlive this; the view was opened with the scene's objects.
  MovedObjects(StereoView& view, const Scene& scene);

  // Takes a pose. True: the picture has changed. The pose of an object that is not in the scene, or moves by itself, is left out.
  bool take(const ObjectPose& pose);
  // True: leave this pose out, as a newer one may have come before, with which the object is not held any more. arrival: of the message.
  bool is_overtaken(const ObjectPose& pose, Arrival arrival) const;

  // A program moved an object: set_time() places it from then on. arrival: of the message. False: the move is known already, the object is
  // not one that programs may move, or the haptics process that sent it has been replaced by another one.
  bool take(const ObjectMove& move, Arrival arrival = Arrival::newest);

  // A program deforms an object: set_time() gives it its shape from then on. arrival: of the message.
  void take(const ObjectShape& shape, Arrival arrival) { shapes_.take(shape, arrival); }
  void take(const ShapeStart& start, Arrival arrival) { shapes_.take(start, arrival); }
  // The message that requests the missing parts of the newest shapes, if it is time to send one.
  std::optional<ShapeStatus> take_shape_request(std::int64_t now_ns) { return shapes_.take_request(now_ns); }
  // Forgets all shapes: the objects that programs deform are then at rest.
  void forget_shapes();
  // Between which shapes an object that a program deforms is at the time set last. None: that is not known, and it stays as it was drawn.
  std::optional<KnownShapes::Place> shape_place(std::size_t object) const { return shapes_.find(object, scene_time_ns_); }
  // The vertices of that object at that time, frame S; none: as for shape_place().
  std::optional<std::vector<Vec3>> find_vertices(std::size_t object) const;
  std::size_t count_objects() const { return known_poses_.size(); }

  // Takes over the time of another scene, and, if both have objects of the same names in the same order, what is known of these: poses
  // of those that the stylus picked up, moves by programs if the objects move alike, and shapes if the meshes have as many vertices.
  void adopt(const MovedObjects& before);

  // Puts each object where the scene file has it; no pose or move is then known. Shapes stay.
  void rewind();

  // Whether some objects move by keyframes or by programs, or deform.
  bool has_motion() const { return has_motion_; }
  // Sets the time (ProbeState's). True: an object is elsewhere than at the time set before, or not drawn in its shape; call place_moving().
  bool set_time(std::int64_t scene_time_ns);
  void place_moving();
  // X_SO of each object at the time set last; the identity for objects that move neither by keyframes nor by programs.
  const std::vector<Pose>& moving() const { return X_SO_; }

  // X_SO of each object at the time set last; the identity, as in the scene file, for the object that is held.
  std::vector<Pose> poses() const;

  // The number of the object that is held; -1: none.
  std::int32_t held() const;
  // The pose of that object in the stylus, X_TO; the identity: none is held.
  Pose held_pose() const;

 private:
  std::optional<Pose> pose_of(std::size_t object, double time_s) const;
  void forget_moves();
  void draw_shape(std::size_t object);

  StereoView& view_;
  const Scene& scene_;
  std::vector<ObjectPose> known_poses_;  // newest pose of each object, if it does not move by itself
  bool has_motion_ = false;
  std::vector<std::optional<CommandedMotion>> commanded_motions_;  // by object; none: programs do not move it
  HapticsSource source_;                                           // the haptics process that the moves come from
  std::int64_t scene_time_ns_ = 0;                                 // the time set last
  std::vector<Pose> X_SO_;
  std::vector<MeshDeformation::Weights> weights_;                       // by object, at the time set last
  std::vector<std::optional<MeshDeformation::Weights>> drawn_weights_;  // as drawn; none: as the mesh is
  KnownShapes shapes_;
  std::vector<std::optional<KnownShapes::Place>> shape_places_;        // by object, the last one known; none: not known, or never deformed
  std::vector<std::optional<KnownShapes::Place>> drawn_shape_places_;  // likewise, as drawn
};

}  // namespace hapton
