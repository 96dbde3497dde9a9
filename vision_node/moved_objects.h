#pragma once

#include <optional>
#include <vector>

#include "core/math/commanded_motion.h"
#include "link/known_shapes.h"
#include "link/messages.h"
#include "link/move_source.h"
#include "scene/scene_file.h"
#include "vision_node/stereo_view.h"

namespace hapton {

// Draws objects where the haptics node has them: one that the stylus picked up at the stylus, others where they were put down, and those
// that move by keyframes or programs, or deform, where they were, and in their shape, at the time of the sample that is shown. Threads: the
// window's. RT: no.
class MovedObjects {
 public:
  // Pre: both outlive this; the view was opened with the scene's objects.
  MovedObjects(StereoView& view, const Scene& scene);

  // True if the picture has changed. A pose of an object that the scene does not have is left out.
  bool take(const ObjectPose& pose);
  // A newer pose may have come before this one, of which the object may not be held any more. arrival: of the message.
  bool is_overtaken(const ObjectPose& pose, Arrival arrival) const;

  // A program moved an object: set_time() places it from then on. arrival: of the message. False: it is known already, not of an object
  // that programs may move, or of a haptics process that another one has replaced.
  bool take(const ObjectMove& move, Arrival arrival = Arrival::newest);

  // A program deforms an object: set_time() gives it its shape from then on. As above.
  void take(const ObjectShape& shape, Arrival arrival) { shapes_.take(shape, arrival); }
  void take(const ShapeStart& start, Arrival arrival) { shapes_.take(start, arrival); }
  // What is missing of the newest shapes.
  std::optional<ShapeStatus> take_shape_request(std::int64_t now_ns) { return shapes_.take_request(now_ns); }
  // The objects that programs deform are at rest, and no shape is known.
  void forget_shapes();
  // Of an object that a program deforms, at the time set last: between which shapes it is. None: that is not known, and it stays as it was.
  std::optional<KnownShapes::Place> shape_place(std::size_t object) const { return shapes_.find(object, time_ns_); }
  // ... and its vertices there, frame S.
  std::optional<std::vector<Vec3>> find_vertices(std::size_t object) const;
  std::size_t count_objects() const { return known_.size(); }

  // Takes over what is known of the objects of another scene, and its time, if both scenes have the same objects, by name: those that the
  // stylus picked up are where they are there, and those that programs move, if they move alike.
  void adopt(const MovedObjects& before);

  // Everything is where the scene file has it, and no pose or move is known. Shapes stay.
  void rewind();

  // Some move by keyframes or by programs, or deform.
  bool has_motion() const { return has_motion_; }
  // The time of ProbeState: true if one of them is then elsewhere than it is drawn, or has another shape. place_moving() draws them so.
  bool set_time(std::int64_t scene_time_ns);
  void place_moving();
  // By object, at the time set last: X_SO; the identity for what moves neither by keyframes nor by programs.
  const std::vector<Pose>& moving() const { return X_SO_; }

  // By object, at the time set last: X_SO of all; of the one that is held, where the scene file has it.
  std::vector<Pose> poses() const;

  // The object that is held; -1: none.
  std::int32_t held() const;
  // Where it is: X_TO; the identity if none is.
  Pose held_pose() const;

 private:
  std::optional<Pose> pose_of(std::size_t object, double time_s) const;
  void forget_moves();
  void draw_shape(std::size_t object);

  StereoView& view_;
  const Scene& scene_;
  std::vector<ObjectPose> known_;  // by object
  bool has_motion_ = false;
  std::vector<std::optional<CommandedMotion>> commanded_;  // by object; none: programs do not move it
  MoveSource source_;                                      // of their moves
  std::int64_t time_ns_ = 0;                               // set last
  std::vector<Pose> X_SO_;
  std::vector<MeshDeformation::Weights> weights_;                       // by object, at the time set last
  std::vector<std::optional<MeshDeformation::Weights>> drawn_weights_;  // none: as the mesh is
  KnownShapes shapes_;
  std::vector<std::optional<KnownShapes::Place>> shape_places_;  // by object, at the time set last; none: programs do not deform it
  std::vector<std::optional<KnownShapes::Place>> drawn_shapes_;  // likewise, as it is drawn
};

}  // namespace hapton
