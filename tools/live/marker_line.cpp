#include "tools/live/marker_line.h"

#include <fcntl.h>
#include <linux/parport.h>
#include <linux/ppdev.h>
#include <linux/serial.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "link/marker_request.h"
#include "tools/live/vrpn_line.h"

namespace hapton {
namespace {

struct Pin {
  std::string_view name;
  bool is_parallel;
  int bit;
};
constexpr Pin kPins[] = {{"CTS", false, TIOCM_CTS},
                         {"DSR", false, TIOCM_DSR},
                         {"DCD", false, TIOCM_CD},
                         {"RI", false, TIOCM_RI},
                         {"ACK", true, PARPORT_STATUS_ACK},
                         {"BUSY", true, PARPORT_STATUS_BUSY},
                         {"PAPEROUT", true, PARPORT_STATUS_PAPEROUT},
                         {"SELECT", true, PARPORT_STATUS_SELECT},
                         {"ERROR", true, PARPORT_STATUS_ERROR}};

class SerialLine : public DigitalLine {
 public:
  SerialLine(int descriptor, LineInput input) : descriptor_(descriptor), input_(std::move(input)) { initial_count_ = count(); }
  ~SerialLine() override { ::close(descriptor_); }
  SerialLine(const SerialLine&) = delete;
  SerialLine& operator=(const SerialLine&) = delete;

  Result<bool> is_on() override {
    int bits = 0;
    if (::ioctl(descriptor_, TIOCMGET, &bits) != 0) return fail("{} cannot be read any more: {}", input_.device, std::strerror(errno));
    return (bits & input_.bit) != 0;
  }
  std::optional<std::uint64_t> changes() override {
    const auto now = count();
    if (!now || !initial_count_) return std::nullopt;
    return static_cast<std::uint32_t>(*now - *initial_count_);
  }

 private:
  std::optional<std::uint32_t> count() const {
    serial_icounter_struct counters = {};
    if (::ioctl(descriptor_, TIOCGICOUNT, &counters) != 0) return std::nullopt;
    switch (input_.bit) {
      case TIOCM_CTS:
        return static_cast<std::uint32_t>(counters.cts);
      case TIOCM_DSR:
        return static_cast<std::uint32_t>(counters.dsr);
      case TIOCM_CD:
        return static_cast<std::uint32_t>(counters.dcd);
      default:
        return std::nullopt;  // the kernel counts only one of the two edges of RI
    }
  }
  int descriptor_;
  LineInput input_;
  std::optional<std::uint32_t> initial_count_;
};

class ParallelLine : public DigitalLine {
 public:
  ParallelLine(int descriptor, LineInput input) : descriptor_(descriptor), input_(std::move(input)) {}
  ~ParallelLine() override { ::close(descriptor_); }  // closing it also releases the port
  ParallelLine(const ParallelLine&) = delete;
  ParallelLine& operator=(const ParallelLine&) = delete;

  // False: it is not a parallel port, or another program has it.
  bool claim() { return ::ioctl(descriptor_, PPCLAIM) == 0; }
  Result<bool> is_on() override {
    unsigned char status = 0;
    if (::ioctl(descriptor_, PPRSTATUS, &status) != 0) return fail("{} cannot be read any more: {}", input_.device, std::strerror(errno));
    return is_high(input_, status);
  }

 private:
  int descriptor_;
  LineInput input_;
};

}  // namespace

Result<LineInput> parse_line_input(std::string_view text) {
  if (text.starts_with(kVrpnLine)) return parse_vrpn_line(text);
  const std::size_t colon = text.rfind(':');
  if (colon != std::string_view::npos && colon > 0) {
    const std::string_view name = text.substr(colon + 1);
    const auto* pin = std::find_if(std::begin(kPins), std::end(kPins), [&](const Pin& one) { return one.name == name; });
    if (pin != std::end(kPins)) return LineInput{std::string(text.substr(0, colon)), std::string(name), pin->is_parallel, pin->bit};
  }
  return fail(
      "--line '{}' is not an input of a port: give DEVICE:PIN, as in /dev/ttyS0:CTS (serial: CTS, DSR, DCD, RI) or /dev/parport0:ACK "
      "(parallel: ACK, BUSY, PAPEROUT, SELECT, ERROR), or vrpn:NAME@HOST:BUTTON",
      text);
}

bool is_high(const LineInput& input, unsigned char status) noexcept { return ((status ^ PARPORT_STATUS_BUSY) & input.bit) != 0; }

Result<std::unique_ptr<DigitalLine>> open_line_input(const LineInput& input) {
  if (input.is_vrpn) return open_vrpn_line(input);
  // O_NONBLOCK: a serial port opens without waiting for a carrier signal.
  const int descriptor = ::open(input.device.c_str(), (input.is_parallel ? O_RDWR : O_RDONLY) | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) {
    const std::string group = input.is_parallel ? "lp" : "dialout";
    return fail("{} cannot be opened: {}{}", input.device, std::strerror(errno),
                errno == EACCES                        ? fmt::format("; `sudo adduser $USER {}`, then log in again", group)
                : input.is_parallel && errno == ENOENT ? "; `sudo modprobe ppdev` makes it, where there is such a port"
                                                       : std::string());
  }
  if (input.is_parallel) {
    auto line = std::make_unique<ParallelLine>(descriptor, input);
    if (!line->claim() || !line->is_on()) {
      return fail("{} is not a parallel port, or another program has it (`sudo rmmod lp` for the printer's)", input.device);
    }
    return line;
  }
  auto line = std::make_unique<SerialLine>(descriptor, input);
  if (!line->is_on()) return fail("{} is not a serial port with a {} input", input.device, input.name);
  return line;
}

Result<LineMarker> make_line_marker(const LineInput& input, std::string_view edges, const std::string& text) {
  const Edges marked_edges = edges == "on" ? Edges::on : edges == "off" ? Edges::off : Edges::both;
  const std::string& name = text.empty() ? input.name : text;
  const bool is_plain = !text.empty() && marked_edges != Edges::both;
  const std::string on = is_plain ? name : name + " on";
  const std::string off = is_plain ? name : name + " off";
  for (const std::string& each : {on, off}) {
    if (const auto valid = make_marker(each); !valid) return tl::unexpected(valid.error());
  }
  return LineMarker(marked_edges, on, off);
}

LineMarker::LineMarker(Edges edges, std::string on_text, std::string off_text)
    : edges_(edges), on_text_(std::move(on_text)), off_text_(std::move(off_text)) {}

void LineMarker::observe(bool is_on, std::int64_t now_ns) {
  if (!is_on_ || *is_on_ == is_on) {
    is_on_ = is_on;
    return;
  }
  is_on_ = is_on;
  ++counts_.changes;
  if (!is_marked(is_on)) return;
  const std::string& text = is_on ? on_text_ : off_text_;
  const auto marker = make_marker(text);
  if (!marker || pending_.size() >= kMaxPending) {
    ++counts_.given_up;
    return;
  }
  pending_.push_back({.marker = *marker, .text = text, .made_ns = now_ns, .next_ns = now_ns});
}

std::optional<Marker> LineMarker::next(std::int64_t now_ns) {
  while (!pending_.empty() && now_ns - pending_.front().made_ns >= kReplyTimeoutNs) {
    pending_.pop_front();
    ++counts_.given_up;
  }
  for (PendingMarker& one : pending_) {
    if (one.next_ns > now_ns) continue;
    one.next_ns = now_ns + kRepeatNs;
    return one.marker;
  }
  return std::nullopt;
}

std::optional<std::string> LineMarker::take(const MarkerReply& reply) {
  const auto found =
      std::find_if(pending_.begin(), pending_.end(), [&](const PendingMarker& one) { return one.marker.request == reply.request; });
  if (found == pending_.end()) return std::nullopt;
  const std::string text = found->text;
  pending_.erase(found);
  const auto sample = read_reply(reply);
  ++(sample ? counts_.marked : counts_.rejected);
  return sample ? fmt::format("marked sample {}: {}", *sample, text) : fmt::format("not marked: {}: {}", text, sample.error().what);
}

}  // namespace hapton
