#include "vision_node/screenshot_moment.h"

#include <charconv>

namespace hapton {
namespace {

// Long enough for the hand to have settled on the surface rather than to have brushed it.
constexpr std::int64_t kMinContactNs = 300'000'000;

}  // namespace

Result<ScreenshotMoment> ScreenshotMoment::parse(std::string_view text) {
  ScreenshotMoment moment;
  if (text == "contact") return moment;
  if (text == "exit") {
    moment.kind_ = Kind::exit;
    return moment;
  }
  double seconds = 0.0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), seconds);
  if (status != std::errc() || end != text.data() + text.size() || !(seconds >= 0.0) || seconds > 1e6) {
    return fail("'{}' is not known; give contact, exit or a number of seconds", text);
  }
  moment.kind_ = Kind::time;
  moment.at_ns_ = static_cast<std::int64_t>(seconds * 1e9);
  return moment;
}

bool ScreenshotMoment::take_now(std::int64_t since_start_ns, bool contact) {
  if (is_taken_) return false;
  if (!contact)
    contact_since_ns_ = -1;
  else if (contact_since_ns_ < 0)
    contact_since_ns_ = since_start_ns;
  switch (kind_) {
    case Kind::contact:
      is_taken_ = contact && since_start_ns - contact_since_ns_ >= kMinContactNs;
      break;
    case Kind::time:
      is_taken_ = since_start_ns >= at_ns_;
      break;
    case Kind::exit:
      break;
  }
  return is_taken_;
}

}  // namespace hapton
