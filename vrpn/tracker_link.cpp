#include "vrpn/tracker_link.h"

#include <algorithm>
#include <utility>

namespace hapton::vrpn {
namespace {

constexpr std::size_t kLongestDevice = 64;
// Largest number of reads in one call. Each takes up to the endpoint's buffer: a quarter of a megabyte in all, enough for 2,500 reports.
constexpr int kMaxReads = 4;

}  // namespace

Result<TrackerName> parse_tracker_name(std::string_view text) {
  constexpr std::string_view kTcp = "tcp://";
  const std::size_t at = text.find('@');
  const bool has_both = at != std::string_view::npos && at > 0 && at + 1 < text.size();
  if (!has_both) return fail("'{}' is not a VRPN tracker; give NAME@HOST or NAME@HOST:PORT", text);
  const std::string_view device = text.substr(0, at);
  const bool is_printable = std::all_of(device.begin(), device.end(), [](char letter) { return letter > ' ' && letter <= '~'; });
  if (device.size() > kLongestDevice || !is_printable) {
    return fail("'{}' is not the name of a VRPN device; give at most {} letters without spaces before the '@'", device, kLongestDevice);
  }
  std::string_view host = text.substr(at + 1);
  if (host.starts_with(kTcp)) host.remove_prefix(kTcp.size());
  if (host.empty()) return fail("'{}' names no host; give NAME@HOST or NAME@HOST:PORT", text);
  return TrackerName{std::string(device), std::string(host)};
}

Result<std::unique_ptr<TrackerLink>> TrackerLink::open(const TrackerName& name, std::int32_t sensor) {
  const auto server = parse_address(name.host, kServerPort);
  if (!server) return tl::unexpected(server.error());
  auto streams = StreamEndpoint::open_to_connect();
  if (!streams) return tl::unexpected(streams.error());
  return std::unique_ptr<TrackerLink>(new TrackerLink(std::move(*streams), *server, name.device, sensor));
}

TrackerLink::TrackerLink(std::unique_ptr<StreamEndpoint> streams, const Address& server, std::string device, std::int32_t sensor)
    : streams_(std::move(streams)), server_(server), device_(std::move(device)), sensor_(sensor) {}

std::optional<TrackerPose> TrackerLink::take_newest(std::int64_t now_ns) {
  keep_connected(now_ns);
  for (int n = 0; n < kMaxReads; ++n) {
    has_arrived_ = false;
    streams_->wait(0, *this);
    if (!has_arrived_) break;
    received_ns_ = now_ns;
  }
  send_pending();
  return client_ ? client_->take_newest() : std::nullopt;
}

void TrackerLink::keep_connected(std::int64_t now_ns) {
  if (id_ == 0) {
    if (now_ns < retry_ns_) return;
    retry_ns_ = now_ns + kRetryNs;
    received_ns_ = last_ping_ns_ = now_ns;
    id_ = streams_->connect(server_);
    if (id_ != 0) client_.emplace(device_, sensor_);
    return;
  }
  if (now_ns - received_ns_ >= kReceiveTimeoutNs) return streams_->close(id_);
  if (is_connected() && now_ns - std::max(received_ns_, last_ping_ns_) >= kPingNs) {
    client_->ping();
    last_ping_ns_ = now_ns;
  }
}

void TrackerLink::send_pending() {
  if (!client_ || client_->out().empty()) return;
  streams_->send(id_, client_->out());
  client_->out().clear();
}

void TrackerLink::on_connected(StreamEndpoint::Id, const Address&) { has_arrived_ = true; }

void TrackerLink::on_bytes(StreamEndpoint::Id id, std::span<const std::byte> bytes) {
  if (id != id_ || !client_) return;
  has_arrived_ = true;
  if (!client_->receive(bytes)) streams_->close(id);
}

void TrackerLink::on_closed(StreamEndpoint::Id id) {
  if (id != id_) return;
  id_ = 0;
  client_.reset();
}

}  // namespace hapton::vrpn
