#pragma once

#include <array>
#include <cstdint>

#include "link/messages.h"

namespace hapton {

// Tracks which device samples got a force in response, and the fate of the others.
//
// A sample older than the newest one with a response is `superseded` if the haptics node reports that it skipped it, otherwise `lost` after
// kReplyTimeoutNs (until then its response may still arrive, reordered). Newer samples wait until the haptics node responds, leaves or is
// replaced; in the latter cases they are `excused`: no node was there to respond. So are samples taken while no haptics node had joined, or
// in its first kWarmUpNs. RT: yes. Threads: one.
class ResponseTracker {
 public:
  // Ten times the age at which a force is rejected: a response so late is of no use, but still tells a slow sample from a lost one.
  static constexpr std::int64_t kReplyTimeoutNs = 200'000'000;
  static constexpr std::int64_t kWarmUpNs = 50'000'000;  // a choice
  static constexpr std::uint64_t kCapacity = 16384;      // 1.6 s at 10 kHz, longer than a silent node keeps its slot

  enum class Verdict : std::uint8_t {
    in_time,    // responds to the newest sample
    late,       // responds to an older sample, but no newer one has a response
    reordered,  // a newer one already has a response
    duplicate,  // the sample already has a response
    unknown,    // no sample of ours, or one forgotten long ago
  };

  // taken = in_time + late + reordered + superseded + lost + excused + waiting. A response after all moves its sample to another count.
  struct Counts {
    std::uint64_t taken = 0;
    std::uint64_t in_time = 0;
    std::uint64_t late = 0;
    std::uint64_t reordered = 0;
    std::uint64_t duplicate = 0;
    std::uint64_t unknown = 0;
    std::uint64_t superseded = 0;
    std::uint64_t lost = 0;
    std::uint64_t excused = 0;
  };

  // A sample was sent; is_expected false: no reply is expected, so it is excused. Numbers and times increase; numbers may be skipped.
  void take(std::uint64_t sample, std::int64_t time_ns, bool is_expected) noexcept;
  // A sample was taken and not sent, as a newer one was there already or the device side computes the force. It is excused, and is not
  // among those that the haptics node reports as skipped.
  void withhold(std::uint64_t sample, std::int64_t time_ns) noexcept;
  // A force arrived in response to this sample.
  Verdict reply(const ForceCommand& command) noexcept;
  // The haptics node left or was replaced: waiting samples will get no response.
  void excuse_waiting() noexcept;
  // Call periodically: declares samples lost that have been overtaken for too long.
  void settle(std::int64_t now_ns) noexcept;
  // At the end of a run: overtaken samples are lost; waiting ones are lost if the node was alive, else excused.
  void close(bool is_alive) noexcept;

  std::uint64_t newest_replied() const noexcept { return newest_replied_; }
  bool has_newest_reply() const noexcept { return newest_sample_ != 0 && newest_replied_ == newest_sample_; }
  const Counts& counts() const noexcept { return counts_; }

 private:
  enum class State : std::uint8_t { none, waiting, replied, superseded, lost, excused, withheld };
  struct Entry {
    std::uint64_t sample = 0;
    std::int64_t time_ns = 0;
    State state = State::none;
  };

  Entry& entry(std::uint64_t sample) noexcept { return entries_[sample % kCapacity]; }
  void note(std::uint64_t sample, std::int64_t time_ns, State state) noexcept;
  void set_state(Entry& into, State state) noexcept;
  void supersede_before(std::uint64_t sample, std::uint32_t count) noexcept;
  void settle_until(std::uint64_t end, State state) noexcept;

  std::array<Entry, kCapacity> entries_ = {};
  std::uint64_t newest_sample_ = 0;  // 0: none taken; samples count from 1
  std::uint64_t newest_replied_ = 0;
  std::uint64_t settled_until_ = 0;  // all up to here are settled
  Counts counts_;
};

}  // namespace hapton
