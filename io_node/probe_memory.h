#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/math/types.h"
#include "devices/device.h"
#include "io_node/device_loop.h"
#include "link/messages.h"

namespace hapton {

// Where the probe was at the newest samples, and where it rests: for the picture, whose pose and visual offset are one sample's, and for a
// haptics node that comes in another's stead and goes on from there.
// Frames: world. Units: m, ns of the hub's clock. RT: yes. Threads: one.
class ProbeMemory {
 public:
  // How many samples are known: a force that answers an older one has no pose.
  static constexpr std::size_t kSamples = 256;

  // Pre: samples count up.
  void note_sample(std::uint64_t number, const DeviceSample& sample) noexcept;
  // The answer to the newest sample that has one.
  void note_answer(const ForceCommand& command) noexcept;
  // A haptics node has joined that has not answered yet.
  void note_new_haptics() noexcept { is_haptics_new_ = true; }
  // The scene was turned: where the probe rests is known no more.
  void forget_rest() noexcept { p_WP_.reset(); }

  // Where a haptics node that has not answered yet goes on from, if the device is still near (kResumeReachM).
  std::optional<Vec3> find_resume_point(const Vec3& p_WD) const noexcept;
  const ForceCommand& last_answer() const noexcept { return last_; }

  // Pose, contact and visual offset: of the newest sample that was answered; an older answer's offset beside the newest pose would draw the
  // probe beside the surface by what the device moved meanwhile. While nobody answers it is the newest sample, as it is.
  void show(bool is_silent, ProbeState& probe) const noexcept;

 private:
  struct Pose {
    std::int64_t time_ns = 0;
    Vec3 p_WD = Vec3::Zero();
    Quat q_WT = Quat::Identity();
  };

  bool is_known(std::uint64_t sample) const noexcept { return sample != 0 && newest_ - sample < kSamples; }

  std::array<Pose, kSamples> poses_ = {};  // by number
  std::uint64_t newest_ = 0;
  ForceCommand last_;
  std::optional<Vec3> p_WP_;  // in contact, as far as known
  bool is_haptics_new_ = false;
};

}  // namespace hapton
