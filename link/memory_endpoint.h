#pragma once

#include <cstdint>
#include <memory>

#include "core/base/result.h"
#include "link/endpoint.h"
#include "runtime/clock.h"

namespace hapton {

// Faults of a MemoryNetwork. Probabilities, 0 .. 1, are for each datagram; the draws follow from the seed.
struct Impairments {
  std::uint64_t seed = 1;
  double loss = 0.0;
  double duplicate = 0.0;
  double reorder = 0.0;  // share that is held back by reorder_by_ns, so that later ones overtake it
  std::int64_t reorder_by_ns = 2'000'000;
  std::int64_t delay_ns = 0;   // delay of every datagram
  std::int64_t jitter_ns = 0;  // additional delay, uniform from 0 to this
};

// A network inside one process, for tests: any number of endpoints that exchange datagrams through memory, on an injected clock. Waiting
// sleeps on that clock, so with a SimulatedClock a receive moves time on to the next arrival or to its deadline.
// The endpoints share its state and may outlive it. RT: no (it allocates). Threads: one.
class MemoryNetwork {
 public:
  // Pre: the clock outlives the network and its endpoints.
  explicit MemoryNetwork(Clock& clock, const Impairments& impairments = {});

  // An endpoint at this address; port 0 takes a free one. Error: the address is taken. Closing it (destruction) frees the address.
  Result<std::unique_ptr<Endpoint>> open(const Address& address);

  // Changes what happens to datagrams sent from now on. The draws continue: the seed in it is not used.
  void set_impairments(const Impairments& impairments);

  struct State;

 private:
  std::shared_ptr<State> state_;
};

// The address 10.0.0.`host`:`port`.
Address memory_address(std::uint8_t host, std::uint16_t port);

}  // namespace hapton
