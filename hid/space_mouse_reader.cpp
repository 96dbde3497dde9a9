#include "hid/space_mouse_reader.h"

#include <utility>

namespace hapton {

SpaceMouseReader::SpaceMouseReader(HidOpener opener) : port_(std::move(opener), *this, "SpaceMouse") {}

SpaceMouseState SpaceMouseReader::state(std::int64_t now_ns) noexcept {
  newest_.take();
  const Received& received = newest_.value();
  return received.is_there ? received.decoder.state(now_ns) : SpaceMouseState{};
}

Result<void> SpaceMouseReader::on_opened(HidTransport& transport) {
  if (description_.path.empty()) description_ = transport.description();
  received_.decoder.reset();
  received_.is_there = true;
  newest_.publish(received_);
  return {};
}

void SpaceMouseReader::on_report(std::span<const std::uint8_t> report, std::int64_t now_ns) noexcept {
  has_news_ = received_.decoder.take(report, now_ns) || has_news_;
}

void SpaceMouseReader::on_drained(std::int64_t) noexcept {
  if (std::exchange(has_news_, false)) newest_.publish(received_);
}

void SpaceMouseReader::on_gone() noexcept {
  received_ = {};
  newest_.publish(received_);
}

}  // namespace hapton
