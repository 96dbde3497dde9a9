#include "tests/hid_guest/wall_haptics.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "link/hub_client.h"
#include "link/sealed_client.h"
#include "link/udp_endpoint.h"

namespace hapton::guest {

WallHaptics::WallHaptics(const std::string& hub, const LinkKey& key, double wall_z_m)
    : wall_z_m_(wall_z_m), thread_([this, hub, key] { run(hub, key); }) {}

WallHaptics::~WallHaptics() {
  ends_ = true;
  thread_.join();
}

void WallHaptics::run(const std::string& hub, const LinkKey& key) {
  SteadyClock clock;
  const auto address = parse_address(hub);
  auto endpoint = open_udp_endpoint("127.0.0.1:0");
  ASSERT_TRUE(endpoint) << endpoint.error().what;
  SealedClient sealed(**endpoint, clock, RoleKey(key, KeyRole::haptics), *address);
  HubClient client(sealed, clock, NodeRole::haptics, *address);
  Datagram datagram;
  while (!ends_) {
    if (!client.receive(datagram, clock.now_ns() + 10 * kNanosecondsPerMillisecond)) continue;
    const auto* state = std::get_if<DeviceState>(&datagram.message);
    if (state == nullptr) continue;
    ForceCommand command;
    command.echo_sample = state->sample;
    command.echo_sample_time_ns = state->sample_time_ns;
    command.force_n.z() = kStiffnessNPerM * std::max(wall_z_m_ - state->p_WD.z(), 0.0);
    command.contact = command.force_n.z() > 0.0;
    client.send(command);
    ++states_;
    const std::lock_guard lock(mutex_);
    newest_ = *state;
  }
}

}  // namespace hapton::guest
