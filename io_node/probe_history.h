#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/math/types.h"
#include "devices/device.h"
#include "io_node/device_loop.h"
#include "io_node/response_tracker.h"
#include "link/messages.h"

namespace hapton {

// Keeps the poses of the newest samples, and the probe's last position: for the picture, in which pose and visual offset must belong to one
// sample, and for a haptics node that replaces another and resumes contact from that position. Frame: W (world), with the device point D,
// the stylus T and the probe P. Units: m, ns of the hub's clock. RT: yes. Threads: one.
class ProbeHistory {
 public:
  // Samples kept: as many as the response tracker knows. Across a slow network every reply is to a sample of long ago, whose pose the place
  // of contact needs nevertheless. A force that replies to an older sample has no pose.
  static constexpr std::size_t kSamples = ResponseTracker::kCapacity;

  struct Pose {
    std::int64_t time_ns = 0;
    Vec3 p_WD = Vec3::Zero();
    Quat q_WT = Quat::Identity();
  };

  // Pre: samples count up.
  void note_sample(std::uint64_t number, const DeviceSample& sample) noexcept;
  // Notes the reply to the newest sample that has one.
  void note_reply(const ForceCommand& command) noexcept;
  // Notes the force of the newest sample, computed on the device side.
  void note_local(const ForceCommand& command) noexcept;
  // The haptics node has replied to that sample while the device side computes the force.
  void note_resumed(std::uint64_t echo_sample) noexcept {
    if (echo_sample > resume_request_sample_) is_haptics_new_ = false;
  }
  // A haptics node has joined, or is asked to go on from the probe's position, and has not replied yet. Replies to the samples noted so far
  // were computed without that position.
  void note_new_haptics() noexcept {
    is_haptics_new_ = true;
    was_local_ = false;
    resume_request_sample_ = newest_sample_;
  }
  // The same when the device side has computed the force until now: it knows where the probe is even without contact.
  void note_resume_request() noexcept {
    note_new_haptics();
    was_local_ = true;
  }
  bool is_haptics_new() const noexcept { return is_haptics_new_; }
  // True: a reply to that sample was computed without the position to go on from, and none that uses it has come yet.
  bool is_before_resume(std::uint64_t echo_sample) const noexcept { return is_haptics_new_ && echo_sample <= resume_request_sample_; }
  // The scene was turned: the last position is no longer valid.
  void forget_probe_position() noexcept {
    p_WP_.reset();
    was_local_ = false;
  }

  // Where a haptics node goes on, if the device is within 20 mm of it (kResumeReachM): at the place of contact, if the device has not left
  // the surface; or, where the device side has computed the force, near the last position of a probe without contact.
  std::optional<Vec3> find_resume_point(const Vec3& p_WD) const noexcept;
  const ForceCommand& last_reply() const noexcept { return last_reply_; }
  const Pose& newest() const noexcept { return poses_[newest_sample_ % kSamples]; }
  // Position of the probe in the sample of the last reply, if the pose of that sample is still kept.
  std::optional<Vec3> find_probe() const noexcept;

  // Sets pose, contact and visual offset of the newest sample with a reply: the offset of an older reply with the newest pose would draw
  // the probe off the surface by the device's motion in between. Without replies (has_timed_out): the newest sample, no offset.
  void show(bool has_timed_out, ProbeState& probe) const noexcept;

 private:
  std::optional<Vec3> find_resume_point_without_contact(const Vec3& p_WD) const noexcept;
  bool is_known(std::uint64_t sample) const noexcept { return sample != 0 && newest_sample_ - sample < kSamples; }

  std::vector<Pose> poses_ = std::vector<Pose>(kSamples);  // by number
  std::uint64_t newest_sample_ = 0;
  std::uint64_t resume_request_sample_ = 0;  // the newest sample at note_new_haptics
  ForceCommand last_reply_;
  std::optional<Vec3> p_WP_;       // last position in contact; none: no contact, or not known
  Vec3 outward_W_ = Vec3::Zero();  // ... from the device point to that position, m
  bool is_haptics_new_ = false;
  bool was_local_ = false;  // ... and the device side computed the force until note_resume_request
};

}  // namespace hapton
