#include "hid/space_mouse_reader.h"

#include <utility>

namespace hapton {

SpaceMouseReader::SpaceMouseReader(HidOpener opener) : port_(std::move(opener), *this, "SpaceMouse") {}

SpaceMouseState SpaceMouseReader::state(std::int64_t now_ns) noexcept {
  newest_.take();
  const Heard& heard = newest_.value();
  return heard.is_there ? heard.decoder.state(now_ns) : SpaceMouseState{};
}

Result<void> SpaceMouseReader::on_opened(HidTransport& transport) {
  if (description_.path.empty()) description_ = transport.description();
  heard_.decoder.reset();
  heard_.is_there = true;
  newest_.publish(heard_);
  return {};
}

void SpaceMouseReader::on_report(std::span<const std::uint8_t> report, std::int64_t now_ns) noexcept {
  has_news_ = heard_.decoder.take(report, now_ns) || has_news_;
}

void SpaceMouseReader::on_drained(std::int64_t) noexcept {
  if (std::exchange(has_news_, false)) newest_.publish(heard_);
}

void SpaceMouseReader::on_gone() noexcept {
  heard_ = {};
  newest_.publish(heard_);
}

}  // namespace hapton
