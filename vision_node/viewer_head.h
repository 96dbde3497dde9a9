#pragma once

#include <string>

#include "vision_node/stereo_camera.h"

namespace hapton {

// Where the viewer's head is: where it was at first, or where a tracker says, moved on by keys. Always possible (is_possible()). Frame R,
// metres: see Head. RT: no.
class ViewerHead {
 public:
  // Pre: is_possible(start, ipd_m).
  ViewerHead(const Head& start, double ipd_m) : seen_(start), ipd_m_(ipd_m) {}

  // A tracker's. Pre: possible.
  void track(const Head& head) { seen_ = head; }
  // Ignored where it would lead to an impossible place.
  void move(const Vec3& by_m);
  // Takes all moves back.
  void reset() { moved_m_.setZero(); }

  Head head() const;

 private:
  Head seen_;
  Vec3 moved_m_ = Vec3::Zero();
  double ipd_m_;
};

// How far the eye moves that moves farther.
double compute_eye_motion_m(const Head& from, const Head& to, double ipd_m);

// In centimetres, for the picture's corner: a tracker's noise does not change it. Empty: less than a centimetre from home.
std::string describe_head(const Head& head, const Head& home);

}  // namespace hapton
