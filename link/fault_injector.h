#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>

#include "core/base/result.h"

namespace hapton {

// Faults of a bad network in one direction. Shares are probabilities, 0 .. 1, independent for each datagram.
struct LinkFaults {
  std::int64_t delay_ns = 0;   // delay of every datagram
  std::int64_t jitter_ns = 0;  // additional delay, uniform in [0, jitter_ns]; reorders datagrams if it exceeds the time between two of them
  double loss = 0.0;           // probability of loss outside bursts
  double burst_share = 0.0;    // share of the datagrams within bursts
  double burst_length = 8.0;   // mean number of datagrams in a burst (bad state), 1 or more
  double burst_loss = 1.0;     // probability of loss within a burst
  double reorder = 0.0;        // share that is delayed by reorder_by_ns more, so that later datagrams overtake it
  std::int64_t reorder_by_ns = 2'000'000;
  double duplicate = 0.0;
  double corrupt = 0.0;    // share of the datagrams in which one byte is changed
  bool partition = false;  // all datagrams are lost
};

// Error: one line that names the field, its value and its range.
Result<void> check_faults(const LinkFaults& faults);

// What the network does with one datagram.
struct Fate {
  enum class Kind : std::uint8_t { passed, lost, lost_in_burst, partitioned };
  Kind kind = Kind::passed;
  // The following are valid for passed datagrams only.
  std::size_t copies = 1;
  std::array<std::int64_t, 2> due_ns = {};  // arrival time of each copy
  bool held_back = false;                   // the first copy is delayed by reorder_by_ns
  bool corrupt = false;
  std::uint64_t damage = 0;  // argument of damage_bytes
};

// Decides the fate of the datagrams of one direction, from the faults, a seed and the given time alone, so that a run can be
// repeated. Every datagram takes the same number of draws, so enabling one fault does not change the draws of the others. Bursts:
// a Markov chain of two states, good and bad, that takes one step before each datagram. Source: E. N. Gilbert, "Capacity of a
// burst-noise channel" (1960), and E. O. Elliott (1963). LinkFaults::loss is the probability of loss in the good state,
// burst_loss in the bad one; the chain's two probabilities follow from burst_share and burst_length. RT: draw and set yes.
// Threads: one.
class FaultInjector {
 public:
  explicit FaultInjector(std::uint64_t seed) : random_(seed) {}

  // Sets the faults from now on. Pre: check_faults(faults) succeeds.
  void set(const LinkFaults& faults) noexcept { faults_ = faults; }

  // The fate of the next datagram, which is sent at now_ns.
  Fate draw(std::int64_t now_ns) noexcept;

 private:
  double draw_share() noexcept;
  void draw_state() noexcept;

  std::mt19937_64 random_;
  LinkFaults faults_;
  bool is_bad_state_ = false;
};

// Changes one byte, as given by Fate::damage; an empty datagram is unchanged. RT: yes.
void damage_bytes(std::span<std::byte> bytes, std::uint64_t damage) noexcept;

}  // namespace hapton
