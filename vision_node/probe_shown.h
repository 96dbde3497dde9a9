#pragma once

#include <array>
#include <string_view>

#include "link/messages.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// Sizes of the drawn probe, metres. They are scaled with the view, so that the probe looks the same at every scale.
struct ProbeSizes {
  double tip_radius_m = 0.0018;
  double stylus_length_m = 0.105;
  double arrow_m_per_n = 0.02;
  double arrow_max_m = 0.12;
  double arrow_radius_m = 0.0016;
  double tool_radius_m = 0.0;  // radius of a rigid tool around its grip point; 0: there is none
};

// The probe's sizes for a view.
ProbeSizes scale_probe(const Framing& framing);

// The probe as it is drawn: the tip is at device position + visual offset, so that it rests on the surface while the hand is below it
// (memo 4.2.2). Frame W, metres, newtons.
struct ProbeShown {
  Vec3 p_WP = Vec3::Zero();      // tip
  Vec3 p_WD = Vec3::Zero();      // device point: the tip's position without contact
  Quat q_WT = Quat::Identity();  // orientation of the stylus, lean included
  Quat q_WP = Quat::Identity();  // orientation of a rigid tool, which does not lean
  Vec3 force_n = Vec3::Zero();
  double force_limit_n = 0.0;  // the largest force that the device may get; 0: not known
  bool contact = false;
};

// Makes the probe from a received state. The stylus' body points from its tip along z of T. If the device reports no rotation, this is
// towards the viewer, where it would hide tip and force: `lean` turns it aside, up and to the right; identity shows the reported rotation.
// Values that are not finite are shown at the origin or left out, since received data must never break the picture.
ProbeShown make_shown_probe(const ProbeState& state, const Quat& lean = Quat::Identity());

// Whether a surface is touched. A contact without object and without visual offset is a force in free space, of an effect.
bool touches_surface(const ProbeState& state);

// A lean for make_shown_probe() by this angle.
Quat make_lean(double angle_rad);

// The radius in a haptics node's method text ("name=proxy probe_radius_m=0.015"), m; 0 if there is none.
double find_probe_radius(std::string_view method);
// The number of triangles of the local set in such a text; 64 if the text has none.
int find_set_size(std::string_view method);

// Vector from the tip to the head of the force arrow, frame W: along the force, arrow_m_per_n long for each newton, at most arrow_max_m.
Vec3 compute_arrow(const ProbeShown& probe, const ProbeSizes& sizes);

// Whether a new frame would differ: whether any of the probe's marks (tip, stylus end, arrow head, two points of a rigid tool) moved in any
// eye's image by more than a fraction of a pixel, the force by a hundredth of its limit, or contact changed.
class PictureWatch {
 public:
  explicit PictureWatch(double threshold_px = 0.5) : threshold_px_(threshold_px) {}

  bool differs(const ProbeShown& probe, const ProbeSizes& sizes, const StereoScreen& screen, PictureSize size) const;

  // Call it when a frame with this probe has been drawn.
  void note_drawn(const ProbeShown& probe, const ProbeSizes& sizes, const StereoScreen& screen, PictureSize size);

 private:
  using Marks = std::array<Vec2, 10>;
  static Marks compute_marks(const ProbeShown&, const ProbeSizes&, const StereoScreen&, PictureSize);

  double threshold_px_;
  bool has_drawn_ = false;
  bool contact_ = false;
  double force_share_ = 0.0;  // share of the limit
  Marks marks_ = {};
};

}  // namespace hapton
