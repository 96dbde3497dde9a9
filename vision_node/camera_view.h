#pragma once

#include "vision_node/stereo_camera.h"

namespace hapton {

// How the viewer looks, compared with where the picture began: turned round the workspace, nearer, moved aside. What is felt stays where
// it is. Frame W. RT: no.
struct CameraView {
  double yaw_rad = 0.0;       // further to the right
  double pitch_rad = 0.0;     // further above
  double zoom = 1.0;          // so many times as large
  Vec3 pan_m = Vec3::Zero();  // of the centre of the picture

  void orbit(double yaw_by_rad, double pitch_by_rad);
  // Times the factor, from a tenth to a hundred times. A factor that is not positive and finite is ignored.
  void zoom_by(double factor);
  // The picture's centre on a sphere that then fills the picture.
  void look_at(const Framing& home, const Vec3& p_WO, double radius_m);

  // The framing seen so; home is how the picture began. Nobody looks from straight above or below, where up is not known. The eyes come
  // nearer to each other as the picture grows, so that depth looks the same.
  Framing apply(const Framing& home) const;

  friend bool operator==(const CameraView&, const CameraView&) = default;
};

}  // namespace hapton
