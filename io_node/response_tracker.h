#pragma once

#include <array>
#include <cstdint>

#include "link/messages.h"

namespace hapton {

// Which device samples have been answered by a force, and what became of the others.
//
// A sample that a newer one's answer has overtaken is `superseded` when the haptics node says that it skipped it, else `lost` once
// kPatienceNs have passed (until then its answer may still come, reordered). Samples that no answer has passed wait until the haptics
// node answers, leaves or is replaced; in the latter cases they are `excused`: nobody was there to answer. So are samples
// taken while nobody had joined, or before the node had been there for kWarmUpNs.
// RT: yes. Threads: one.
class ResponseTracker {
 public:
  static constexpr std::int64_t kPatienceNs = 200'000'000;
  static constexpr std::int64_t kWarmUpNs = 50'000'000;
  static constexpr std::uint64_t kCapacity = 16384;  // 1.6 s at 10 kHz, longer than a silent node keeps its place

  enum class Verdict : std::uint8_t {
    in_time,    // answers the newest sample
    late,       // answers an older one, but no newer one has been answered
    reordered,  // a newer one has been answered before
    duplicate,  // answered before
    unknown,    // no sample of ours, or one forgotten long ago
  };

  // taken = in_time + late + reordered + superseded + lost + excused + those still waiting. An answer that comes after all is moved over.
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

  // A sample was taken and sent; samples count up, those that nobody was told of are left out. Pre: time rises.
  void take(std::uint64_t sample, std::int64_t time_ns, bool is_expected) noexcept;
  // A sample was taken and never sent: a newer one was there already. It is excused, and the haptics node knows nothing of it: it is none
  // of those that it says it skipped.
  void withhold(std::uint64_t sample, std::int64_t time_ns) noexcept;
  // A force came that says it answers this sample.
  Verdict answer(const ForceCommand& command) noexcept;
  // The haptics node left or another came: what waits has nobody to answer it.
  void excuse_waiting() noexcept;
  // Call now and then: gives up what has been overtaken for too long.
  void settle(std::int64_t now_ns) noexcept;
  // At the end of a run: everything overtaken is given up, what still waits is lost if the node was alive, else excused.
  void close(bool is_alive) noexcept;

  std::uint64_t newest_answered() const noexcept { return newest_answered_; }
  bool is_newest_answered() const noexcept { return newest_ != 0 && newest_answered_ == newest_; }
  const Counts& counts() const noexcept { return counts_; }

 private:
  enum class State : std::uint8_t { none, waiting, answered, superseded, lost, excused, withheld };
  struct Entry {
    std::uint64_t sample = 0;
    std::int64_t time_ns = 0;
    State state = State::none;
  };

  Entry& entry(std::uint64_t sample) noexcept { return entries_[sample % kCapacity]; }
  void note(std::uint64_t sample, std::int64_t time_ns, State state) noexcept;
  void put(Entry& into, State state) noexcept;
  void supersede_before(std::uint64_t sample, std::uint32_t count) noexcept;
  void settle_until(std::uint64_t end, State state) noexcept;

  std::array<Entry, kCapacity> entries_ = {};
  std::uint64_t newest_ = 0;  // 0: none taken; samples count from 1
  std::uint64_t newest_answered_ = 0;
  std::uint64_t settled_ = 0;  // all up to here are settled
  Counts counts_;
};

}  // namespace hapton
