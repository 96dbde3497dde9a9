#include "tools/live/vrpn_line.h"

#include <charconv>
#include <utility>

#include "runtime/clock.h"
#include "vrpn/tracker_link.h"

namespace hapton {
namespace {

constexpr int kMaxButton = 31;  // the highest of the 32 bits of a tracker link's buttons
// How long the server may take to accept the connection; a free choice.
constexpr std::int64_t kVrpnConnectTimeoutNs = 3 * kNanosecondsPerSecond;

class VrpnLine : public DigitalLine {
 public:
  VrpnLine(std::unique_ptr<vrpn::TrackerLink> link, int button) : link_(std::move(link)), button_(button) {}

  Result<bool> is_on() override {
    (void)link_->take_newest(clock_.now_ns());
    if ((link_->reported_buttons() >> button_ & 1U) != 0) is_on_ = (link_->buttons() >> button_ & 1U) != 0;
    return is_on_;
  }
  // Waits until the server accepts the connection. False: it did not do so in time.
  bool wait_for_connection() {
    for (const std::int64_t end_ns = clock_.now_ns() + kVrpnConnectTimeoutNs; clock_.now_ns() < end_ns && !link_->is_connected();) {
      (void)is_on();
      clock_.sleep_until_ns(clock_.now_ns() + kNanosecondsPerMillisecond);
    }
    return link_->is_connected();
  }

 private:
  SteadyClock clock_;
  std::unique_ptr<vrpn::TrackerLink> link_;
  int button_;
  bool is_on_ = false;
};

}  // namespace

Result<LineInput> parse_vrpn_line(std::string_view text) {
  const std::string_view name_and_button = text.substr(std::min(text.size(), kVrpnLine.size()));
  const std::size_t colon = name_and_button.rfind(':');
  const std::string_view digits = colon == std::string_view::npos ? std::string_view() : name_and_button.substr(colon + 1);
  int button = -1;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), button);
  const bool is_number = error == std::errc() && end == digits.data() + digits.size() && button >= 0 && button <= kMaxButton;
  if (!is_number) {
    return fail("--line '{}' names no button: give vrpn:NAME@HOST:BUTTON, as in vrpn:Button0@localhost:0 (buttons count from 0 to {})",
                text, kMaxButton);
  }
  const std::string_view name = name_and_button.substr(0, colon);
  if (const auto valid = vrpn::parse_tracker_name(name); !valid) return tl::unexpected(valid.error());
  return LineInput{.device = std::string(name), .name = fmt::format("button {}", button), .bit = button, .is_vrpn = true};
}

Result<std::unique_ptr<DigitalLine>> open_vrpn_line(const LineInput& input) {
  const auto name = vrpn::parse_tracker_name(input.device);
  if (!name) return tl::unexpected(name.error());
  auto link = vrpn::TrackerLink::open(*name, 0);
  if (!link) return tl::unexpected(link.error());
  auto line = std::make_unique<VrpnLine>(std::move(*link), input.bit);
  if (!line->wait_for_connection()) return fail("no VRPN server replies at {}: start it, or name another one", name->host);
  return line;
}

}  // namespace hapton
