#pragma once

#include <cstdint>
#include <optional>

#include "link/hub_client.h"
#include "vision_node/knob_box.h"
#include "vision_node/probe_shown.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// Another hand in the same picture, of a device that is a hub of its own (io_node --devices): its probe is drawn as well, and its hub is
// told how the scene is turned and what has been drawn. The mouse and the figures in the picture are the first hub's. Times: the hub
// client's clock, ns. RT: no. Threads: one.
class OtherHand {
 public:
  // Pre: the hub outlives it. max_rate_hz: of pictures; 0: as many as can be drawn.
  OtherHand(HubClient& hub, const Quat& stylus_lean, double max_rate_hz)
      : hub_(hub), stylus_lean_(stylus_lean), max_rate_hz_(max_rate_hz) {}

  // Takes what has come, waiting for nothing, and says how the scene stands where the hub does not know.
  void attend(const Pose& X_WS, std::int64_t now_ns);

  // The hand has moved since the last picture, or gone; where it only seems to have, the hub is told that nothing changed.
  bool wants_picture(const ProbeSizes& sizes, const StereoScreen& screen, PictureSize size);
  // Where it is; none before its hub has spoken.
  std::optional<ProbeShown> shown() const;
  // The picture with what shown() said is in the window.
  void drew(std::int64_t start_ns, std::int64_t end_ns, double frame_rate_hz, const ProbeSizes& sizes, const StereoScreen& screen,
            PictureSize size);

 private:
  void hear();

  HubClient& hub_;
  Quat stylus_lean_;
  double max_rate_hz_;
  ViewTransformSender sender_;
  PictureWatch watch_;
  std::optional<ProbeState> state_;
  std::int64_t heard_ns_ = 0;
  std::uint64_t joins_ = 0;
  bool was_joined_ = false;
  bool moved_ = false;   // a state has come since the hand was looked at
  bool untold_ = false;  // and its hub has not heard what became of it
};

}  // namespace hapton
