// Sealing and opening the datagrams of a session makes no system call.
#include <gtest/gtest.h>

#include <unistd.h>

#include <array>
#include <memory>

#include "link/codec.h"
#include "link/endpoint.h"
#include "link/sealed_channel.h"
#include "tests/support/system_call_guard.h"

namespace hapton {
namespace {

struct BothSides {
  SealedChannel client;
  SealedChannel hub;
  Codec codec;

  BothSides() {
    seal::start_crypto();
    seal::ChannelKeys keys;
    keys.client_to_hub.fill(1);
    keys.hub_to_client.fill(2);
    client = SealedChannel(keys, 7, SealedChannel::Side::client);
    hub = SealedChannel(keys, 7, SealedChannel::Side::hub);
  }

  bool exchange(std::uint64_t n) {
    std::array<std::byte, kMaxDatagramBytes> plain;
    std::array<std::byte, kMaxDatagramBytes> sealed;
    std::array<std::byte, kMaxDatagramBytes> opened;
    ForceCommand force;
    force.echo_sample = n;
    const std::size_t size = codec.encode({{1, 2, n, 4}, force}, plain);
    const std::size_t sealed_size = client.seal(std::span(plain).first(size), sealed);
    std::size_t opened_size = 0;
    if (hub.open(std::span(sealed).first(sealed_size), opened, opened_size) != OpenStatus::opened) return false;
    Datagram arrived;
    return codec.decode(std::span(opened).first(opened_size), arrived) == DecodeStatus::ok;
  }
};

TEST(SealSystemCalls, ADatagramSealedAndOpenedMakesNone) {
  if (!SystemCallGuard::is_available()) GTEST_SKIP() << "system calls cannot be forbidden in this build or on this kernel";
  std::unique_ptr<BothSides> sides;
  EXPECT_EQ(SystemCallGuard::run([&] { sides = std::make_unique<BothSides>(); },
                                 [&] {
                                   for (std::uint64_t n = 1; n <= 2000; ++n) {
                                     if (!sides->exchange(n)) _exit(9);
                                   }
                                 }),
            "");
}

}  // namespace
}  // namespace hapton
