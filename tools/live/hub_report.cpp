#include "tools/live/hub_report.h"

#include <string_view>
#include <utility>

#include "link/hub_client.h"
#include "link/link_key.h"
#include "link/sealed_client.h"
#include "link/udp_endpoint.h"

namespace hapton {
namespace {

// How long to wait until the hub accepts this tool, and for each part of its report; a free choice.
constexpr std::int64_t kHubReplyTimeoutNs = 5 * kNanosecondsPerSecond;
constexpr std::int64_t kRepeatRequestNs = 200 * kNanosecondsPerMillisecond;  // the hub needs a moment to make a fresh report
constexpr std::int64_t kHubMaxWaitNs = 20 * kNanosecondsPerMillisecond;      // the longest wait for one datagram; a free choice
constexpr int kMaxTries = 20;                                                // of reading both documents of the same report
constexpr std::uint32_t kMaxParts = 1U << 14;  // 15 MB; a report has about 30 parts, but a broken hub may announce any number

}  // namespace

struct HubReader::State {
  State(std::unique_ptr<Endpoint> endpoint_in, const RoleKey& key, const Address& hub_in)
      : hub(hub_in), endpoint(std::move(endpoint_in)), sealed(*endpoint, clock, key, hub), client(sealed, clock, NodeRole::tool, hub) {}

  bool wait_for_hub();
  Result<std::string> read(ReportDocument document, std::uint32_t& revision);
  bool receive_part(const ReportRequest& request, ReportPart& part);

  SteadyClock clock;
  Address hub;
  std::unique_ptr<Endpoint> endpoint;
  SealedClient sealed;
  HubClient client;
};

bool HubReader::State::wait_for_hub() {
  const std::int64_t end_ns = clock.now_ns() + kHubReplyTimeoutNs;
  Datagram ignored;
  while (client.state() != JoinState::joined && clock.now_ns() < end_ns) client.receive(ignored, clock.now_ns() + kHubMaxWaitNs);
  return client.state() == JoinState::joined;
}

// Waits for the requested part, or for the first part of another report. False: neither came, so the request must be repeated.
bool HubReader::State::receive_part(const ReportRequest& request, ReportPart& part) {
  const std::int64_t end_ns = clock.now_ns() + kRepeatRequestNs;
  Datagram datagram;
  while (client.receive(datagram, end_ns)) {
    const auto* received = std::get_if<ReportPart>(&datagram.message);
    if (received == nullptr || received->document != request.document) continue;
    const bool is_next = received->revision == request.revision && received->part == request.part;
    const bool is_first_of_another = received->revision != request.revision && received->part == 0;
    if (!is_next && !is_first_of_another) continue;
    part = *received;
    return true;
  }
  return false;
}

Result<std::string> HubReader::State::read(ReportDocument document, std::uint32_t& revision) {
  ReportRequest request{document, revision, 0};
  ReportPart part;
  std::string text;
  std::int64_t end_ns = clock.now_ns() + kHubReplyTimeoutNs;
  while (clock.now_ns() < end_ns) {
    client.send(request);
    if (!receive_part(request, part)) continue;
    if (part.parts > kMaxParts) {
      return fail("the hub at {} announces a report of {} parts, above {}; is it of another version?", to_string(hub), part.parts,
                  kMaxParts);
    }
    if (part.part == 0) text.clear();
    text.append(part.text.data(), part.size);
    revision = request.revision = part.revision;
    request.part = part.part + 1;
    end_ns = clock.now_ns() + kHubReplyTimeoutNs;
    if (request.part == part.parts) return text;
  }
  return fail("the hub at {} sent no report; see its terminal", to_string(hub));
}

HubReader::HubReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
HubReader::~HubReader() = default;

Result<std::unique_ptr<HubReader>> HubReader::open(const std::string& hub, const std::string& key_file) {
  const auto address = parse_address(hub);
  if (!address) return tl::unexpected(address.error());
  const auto key = find_role_key(key_file, *address, KeyRole::tool);
  if (!key) return tl::unexpected(key.error());
  auto endpoint = open_udp_endpoint(any_address_like(*address));
  if (!endpoint) return tl::unexpected(endpoint.error());
  auto state = std::make_unique<State>(std::move(*endpoint), *key, *address);
  if (!state->wait_for_hub()) {
    return fail("no reply from a hub at {}; start io_node there, give another address with --hub, or give the hub's --key",
                to_string(*address));
  }
  return std::unique_ptr<HubReader>(new HubReader(std::move(state)));
}

// A slow report is requested twice, and the second one may replace the first between the two documents: both are then read again.
Result<HubReport> HubReader::read() {
  std::uint32_t revision = 0;
  for (int tries = 0; tries < kMaxTries; ++tries) {
    auto json = state_->read(ReportDocument::json, revision);
    if (!json) return tl::unexpected(json.error());
    const std::uint32_t json_revision = revision;
    auto csv = state_->read(ReportDocument::csv, revision);
    if (!csv) return tl::unexpected(csv.error());
    if (revision == json_revision) return HubReport{std::move(*json), std::move(*csv)};
  }
  return fail("the hub at {} makes reports faster than they can be read; too many readers?", to_string(state_->hub));
}

bool HubReader::idle(double seconds) {
  const std::int64_t end_ns = state_->clock.now_ns() + static_cast<std::int64_t>(1e9 * seconds);
  Datagram ignored;
  while (state_->client.receive(ignored, end_ns)) {
  }
  return state_->client.state() == JoinState::joined;
}

}  // namespace hapton
