#include "remote_touch/packet_size.h"

#include <array>

#include "link/codec.h"
#include "link/endpoint.h"
#include "link/seal_format.h"

namespace hapton {
namespace {

constexpr std::size_t kIpAndUdpBytes = 28;
// Numbers as in a session that has run for an hour at 1 kHz.
constexpr std::uint64_t kSequence = 3'600'000;
constexpr std::int64_t kTimeNs = 3'600'000'000'000;

}  // namespace

std::size_t packet_bytes_of(const Message& message) {
  thread_local Codec codec;
  std::array<std::byte, kMaxDatagramBytes> bytes;
  const Header header{.session = ~0ULL, .sender = ~0ULL, .sequence = kSequence, .send_time_ns = kTimeNs};
  return codec.encode({header, message}, bytes) + seal::kOverheadBytes + kIpAndUdpBytes;
}

std::size_t packet_bytes_of_state() {
  DeviceState state;
  state.sample = kSequence;
  state.sample_time_ns = kTimeNs;
  state.p_WD = Vec3(0.01, 0.02, 0.03);
  state.q_WT = Quat(0.4, 0.1, 0.2, 0.3).normalized();
  return packet_bytes_of(state);
}

std::size_t packet_bytes_of_force() {
  ForceCommand force;
  force.echo_sample = kSequence;
  force.echo_sample_time_ns = kTimeNs;
  force.force_n = Vec3(0.1, 0.2, 0.3);
  force.visual_offset_m = Vec3(0.001, 0.002, 0.003);
  force.contact = true;
  force.compute_ns = 2000;
  force.replied_before = ~0ULL;
  return packet_bytes_of(force);
}

}  // namespace hapton
