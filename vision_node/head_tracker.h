#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "vision_node/stereo_camera.h"
#include "vrpn/tracker_link.h"

namespace hapton {

// Where the head comes from.
struct HeadSource {
  std::optional<vrpn::TrackerName> tracker;  // none: only keys move the head
  std::int32_t sensor = 0;                   // number of the sensor on the head
  Pose X_RT = Pose::Identity();              // the tracker's frame T in the screen's frame R
  Vec3 p_BH = Vec3::Zero();                  // the middle between the eyes in the frame B of the sensor on the head, m
};

// What moves the head besides keys: nothing, a SpaceMouse or a tracker.
struct HeadInput {
  bool is_space_mouse = false;
  std::optional<vrpn::TrackerName> tracker;
};
// Parses "keys", "spacemouse", or "vrpn:" and a tracker's name (parse_tracker_name). Error: one line.
Result<HeadInput> parse_head_input(std::string_view text);

// The pose of the head from a VRPN tracker. Never waits. Logs one line when tracking begins and when it is lost. Threads: one. RT: no.
// Times: CLOCK_MONOTONIC, ns.
class HeadTracker {
 public:
  // The tracker counts as lost when its newest possible pose is that old.
  static constexpr std::int64_t kStaleNs = 500'000'000;

  // Pre: source.tracker has a value. Error: its host has no address.
  static Result<std::unique_ptr<HeadTracker>> open(const HeadSource& source, double ipd_m);

  // The head of the newest pose since the last call; none: no pose came, or its head is not possible (is_possible()): keep the last head.
  std::optional<Head> take_head(std::int64_t now_ns);

  // What is wrong, as a text for the corner of the picture; empty: nothing is wrong.
  std::string describe(std::int64_t now_ns) const;

 private:
  enum class State : std::uint8_t { beginning, absent, silent, tracked, lost, impossible };
  HeadTracker(const HeadSource& source, double ipd_m, std::unique_ptr<vrpn::TrackerLink> link);
  State find_state(std::int64_t now_ns) const;
  void report(std::int64_t now_ns);

  HeadSource source_;
  double ipd_m_;
  std::unique_ptr<vrpn::TrackerLink> link_;
  std::optional<std::int64_t> possible_ns_;  // time of the newest possible head
  std::optional<std::int64_t> impossible_ns_;
  Vec3 impossible_m_ = Vec3::Zero();
  State reported_state_ = State::beginning;
  std::optional<std::int64_t> reported_ns_;
  std::int64_t opened_ns_ = -1;
};

// The head, from the pose of the sensor in frame T. Frames: see HeadSource.
Head find_head(const HeadSource& source, const vrpn::TrackerPose& sensor);

}  // namespace hapton
