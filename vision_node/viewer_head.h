#pragma once

#include <string>

#include "vision_node/stereo_camera.h"

namespace hapton {

// The pose of the viewer's head: its pose at the start, or the one that a tracker measured, plus the moves by keys. is_possible() is always
// true for it. Frame R, metres: see Head. RT: no.
class ViewerHead {
 public:
  // Pre: is_possible(start, ipd_m).
  ViewerHead(const Head& start, double ipd_m) : tracked_head_(start), ipd_m_(ipd_m) {}

  // Sets the pose that a tracker measured. Pre: is_possible(head, ipd_m).
  void track(const Head& head) { tracked_head_ = head; }
  // Adds a move, unless is_possible() would then be false.
  void move(const Vec3& by_m);
  // Undoes all moves.
  void reset() { key_motion_m_.setZero(); }

  Head head() const;

 private:
  Head tracked_head_;
  Vec3 key_motion_m_ = Vec3::Zero();
  double ipd_m_;
};

// The larger of the distances that the two eyes move.
double compute_eye_motion_m(const Head& from, const Head& to, double ipd_m);

// Position of the head in whole centimetres, for the picture's corner. Empty: less than half a centimetre from home.
std::string describe_head(const Head& head, const Head& home);

}  // namespace hapton
