#pragma once

#include <cstdint>
#include <optional>

#include "link/hub_client.h"
#include "vision_node/knob_box.h"
#include "vision_node/probe_shown.h"
#include "vision_node/state_acks.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// Another hand in the same picture, of a device with its own hub (io_node --devices): its probe is drawn as well, and its hub gets the
// scene's pose and the frame acknowledgements. The mouse and the numbers in the picture belong to the first hub. Times: the hub client's
// clock, ns. RT: no. Threads: one.
class OtherHand {
 public:
  // Pre: the hub outlives this. stylus_lean: see make_shown_probe(). max_rate_hz: largest frame rate; 0: no limit.
  OtherHand(HubClient& hub, const Quat& stylus_lean, double max_rate_hz)
      : hub_(hub), stylus_lean_(stylus_lean), max_rate_hz_(max_rate_hz) {}

  // Receives without waiting, and sends the pose of the scene if the hub does not have it yet.
  void update(const Pose& X_WS, std::int64_t now_ns);

  // True: the probe of this hand looks different from that in the last frame. If only invisible motion came, the hub gets a FrameAck
  // `unchanged`.
  bool wants_picture(const ProbeSizes& sizes, const StereoScreen& screen, PictureSize size);
  // The probe to draw; none before the first state from its hub.
  std::optional<ProbeShown> shown() const;
  // Call it when a frame with shown() has been drawn.
  void end_frame(std::int64_t start_ns, std::int64_t end_ns, double frame_rate_hz, const ProbeSizes& sizes, const StereoScreen& screen,
                 PictureSize size);

 private:
  void receive_states();

  HubClient& hub_;
  Quat stylus_lean_;
  double max_rate_hz_;
  ViewTransformSender sender_;
  PictureWatch watch_;
  std::optional<ProbeState> state_;
  std::int64_t received_ns_ = 0;
  std::uint64_t joins_ = 0;
  bool was_joined_ = false;
  bool has_new_state_ = false;  // a state has come since the last wants_picture() or end_frame()
  StateAcks acks_;
};

}  // namespace hapton
