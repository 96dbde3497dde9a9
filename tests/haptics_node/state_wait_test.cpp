#include "haptics_node/state_wait.h"

#include <gtest/gtest.h>

#include "link/hub_peers.h"
#include "link/memory_endpoint.h"
#include "tests/support/ticking_clock.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

constexpr std::int64_t kStateDelayNs = 50 * kUs;
constexpr std::int64_t kSleepLateNs = 20 * kUs;

// An endpoint whose sleeps all end late, by kSleepLateNs.
class LateEndpoint final : public Endpoint {
 public:
  LateEndpoint(std::unique_ptr<Endpoint> inner, SimulatedClock& clock) : inner_(std::move(inner)), clock_(clock) {}
  bool send(const Address& to, std::span<const std::byte> datagram) noexcept override { return inner_->send(to, datagram); }
  Received receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept override {
    if (delivers_nothing_to_spins && deadline_ns <= clock_.now_ns()) return {};
    const std::int64_t before_ns = clock_.now_ns();
    const Received received = inner_->receive(into, deadline_ns);
    if (clock_.now_ns() > before_ns) clock_.advance_ns(kSleepLateNs);
    return received;
  }
  Address local_address() const override { return inner_->local_address(); }

  bool delivers_nothing_to_spins = false;  // a spinning receiver gets nothing, as if the sender needed its CPU

 private:
  std::unique_ptr<Endpoint> inner_;
  SimulatedClock& clock_;
};

class StateWaits : public ::testing::Test {
 protected:
  StateWaits() {
    Datagram datagram;
    while (client_.state() != JoinState::joined) {
      client_.receive(datagram, clock_.now_ns() + kMs);
      hub_.receive(datagram, clock_.now_ns() + kMs);
    }
    sample_ = static_cast<std::uint64_t>(clock_.now_ns() / kMs);
  }

  // Waits for the sample `step` numbers after the last one, taken at a whole millisecond. Returns the time from its arrival to its receipt.
  std::int64_t receive_next(std::uint64_t step = 1) {
    sample_ += step;
    const std::int64_t tick_ns = static_cast<std::int64_t>(sample_) * kMs;
    network_.set_impairments({.delay_ns = tick_ns + kStateDelayNs - clock_.now_ns()});
    hub_.send_to_role(NodeRole::haptics, DeviceState{.sample = sample_, .sample_time_ns = tick_ns});
    Datagram datagram;
    while (!wait_.receive(datagram, clock_.now_ns() + 50 * kMs) || !std::holds_alternative<DeviceState>(datagram.message)) {
    }
    wait_.note(std::get<DeviceState>(datagram.message), client_.receive_time_ns());
    const std::int64_t took_ns = clock_.now_ns() - tick_ns - kStateDelayNs;
    network_.set_impairments({});
    hub_.receive(datagram, 0);  // takes the client's Hello
    return took_ns;
  }
  std::int64_t find_longest_delay(int states) {
    std::int64_t longest_ns = 0;
    for (int n = 0; n < states; ++n) longest_ns = std::max(longest_ns, receive_next());
    return longest_ns;
  }

  SimulatedClock clock_;
  TickingClock ticking_{clock_};
  MemoryNetwork network_{clock_};
  std::unique_ptr<Endpoint> hub_endpoint_ = *network_.open(memory_address(1, 4950));
  LateEndpoint endpoint_{*network_.open(memory_address(2, 0)), clock_};
  HubPeers hub_{*hub_endpoint_, clock_, 1, 1000.0};
  HubClient client_{endpoint_, ticking_, NodeRole::haptics, memory_address(1, 4950)};
  StateWait wait_{client_, ticking_};
  std::uint64_t sample_ = 0;
};

TEST_F(StateWaits, WakesBeforeAStateIsDueAndHasItAtOnce) {
  EXPECT_GE(find_longest_delay(200), kSleepLateNs);
  EXPECT_EQ(wait_.spins(), 0U);
  wait_.set_longest_spin(100 * kUs);
  find_longest_delay(200);
  EXPECT_LT(find_longest_delay(200), 1 * kUs);
  EXPECT_GE(wait_.arrivals(), 300U);
  EXPECT_GT(wait_.spun_ns(), 0);
  EXPECT_LE(wait_.spun_ns(), static_cast<std::int64_t>(wait_.spins()) * 100 * kUs);
}

TEST_F(StateWaits, DoesNotSpinWhereNothingArrivesMeanwhile) {
  wait_.set_longest_spin(100 * kUs);
  endpoint_.delivers_nothing_to_spins = true;
  find_longest_delay(500);
  EXPECT_EQ(wait_.spins(), SpinTrial::kWaits);
  EXPECT_EQ(wait_.arrivals(), 0U);
}

TEST_F(StateWaits, DoesNotSpinForSamplesThatAreNotSent) {
  wait_.set_longest_spin(100 * kUs);
  for (int n = 0; n < 200; ++n) receive_next(16);
  EXPECT_EQ(wait_.spins(), 0U);
}

// The system would throttle a thread that is always busy.
TEST_F(StateWaits, SleepsAQuarterOfEachPeriodOrDoesNotSpin) {
  wait_.set_longest_spin(1 * kMs);
  find_longest_delay(100);
  const std::uint64_t spins = wait_.spins();
  EXPECT_GT(spins, 0U);
  EXPECT_LE(wait_.spun_ns(), static_cast<std::int64_t>(spins) * 500 * kUs);
  for (int n = 0; n < 100; ++n) {
    clock_.advance_ns(800 * kUs);
    receive_next();
  }
  EXPECT_LE(wait_.spins(), spins + 1);
}

}  // namespace
}  // namespace hapton
