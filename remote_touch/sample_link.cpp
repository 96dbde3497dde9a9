#include "remote_touch/sample_link.h"

#include <utility>

#include "remote_touch/packet_size.h"

namespace hapton {

SampleLink::SampleLink(std::shared_ptr<ForceMethod> method, const RemoteNetwork& network, std::int64_t period_ns)
    : up_(network.up, network.seed),
      down_(network.down, back_seed(network.seed)),
      haptics_(std::move(method)),
      period_ns_(period_ns),
      state_bytes_(packet_bytes_of_state()),
      force_bytes_(packet_bytes_of_force()) {}

std::optional<ReplyOnTheWay> SampleLink::exchange(const SampleOnTheWay& sample) {
  const std::int64_t now_ns = sample.time_ns;
  if (!sent_ns_ || now_ns - *sent_ns_ >= period_ns_) {
    sent_ns_ = now_ns;
    up_.send(sample, state_bytes_, now_ns);
  }
  received_.reset();
  while (const auto received_sample = up_.receive(now_ns)) {
    const auto reply = haptics_.reply(*received_sample);
    if (!reply) continue;
    received_ = *received_sample;
    down_.send(*reply, force_bytes_, now_ns);
  }
  std::optional<ReplyOnTheWay> newest;
  while (const auto reply = down_.receive(now_ns)) {
    if (replied_ns_ && reply->sample.time_ns <= *replied_ns_) continue;
    replied_ns_ = reply->sample.time_ns;
    newest = *reply;
  }
  return newest;
}

}  // namespace hapton
