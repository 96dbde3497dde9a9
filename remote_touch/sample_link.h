#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "remote_touch/haptics_end.h"
#include "remote_touch/remote_touch.h"

namespace hapton {

// Transfers samples across the network to a simulated haptics node, and its replies back. The node replies at once. Units: SI, ns. RT: no.
class SampleLink {
 public:
  // period_ns: least time between two samples that are sent; 0: every sample is sent.
  SampleLink(std::shared_ptr<ForceMethod> method, const RemoteNetwork& network, std::int64_t period_ns = 0);

  // Sends this sample if one is due, and receives what has arrived by now. Returns the newest reply; none: no newer one has arrived.
  std::optional<ReplyOnTheWay> exchange(const SampleOnTheWay& sample);
  // The newest sample that reached the haptics node in the last exchange; none: none did.
  const std::optional<SampleOnTheWay>& received() const noexcept { return received_; }

  RemoteTraffic traffic() const noexcept { return {up_.traffic(), down_.traffic(), {}}; }

 private:
  NetworkPath<SampleOnTheWay> up_;
  NetworkPath<ReplyOnTheWay> down_;
  HapticsEnd haptics_;
  std::int64_t period_ns_;
  std::size_t state_bytes_;
  std::size_t force_bytes_;
  std::optional<std::int64_t> sent_ns_;
  std::optional<std::int64_t> replied_ns_;
  std::optional<SampleOnTheWay> received_;
};

// The seed of the path for replies, derived from that of the path for samples.
constexpr std::uint64_t back_seed(std::uint64_t seed) noexcept { return seed + 0x9e3779b97f4a7c15; }

}  // namespace hapton
