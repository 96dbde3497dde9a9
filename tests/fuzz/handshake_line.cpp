#include "tests/fuzz/handshake_line.h"

#include <algorithm>
#include <map>

#include "link/noise.h"
#include "tests/fuzz/fixed_random.h"

namespace hapton::fuzz {
namespace {

using namespace seal;

constexpr std::int64_t kStartNs = 1000 * kNanosecondsPerSecond;
constexpr KeyRole kNodeRole = KeyRole::haptics;
constexpr std::size_t kMaxHandshakes = 8;  // in a mutated input: each takes 0.2 ms or more

LinkKey make_master() {
  LinkKey::Bytes bytes;
  bytes.fill(1);
  return LinkKey(bytes);
}

// Restarts the random numbers before the first one is drawn: every connection has the same secrets.
std::int64_t start() {
  FixedRandom::install();
  FixedRandom::restart();
  return kStartNs;
}

std::size_t tag_offset(const Bytes& datagram) { return datagram.size() - kTagBytes; }

Tag tag_of(const Bytes& datagram, KeyRole role) {
  return compute_tag(derive_handshake_key(RoleKey(make_master(), role)), std::span(datagram).first(tag_offset(datagram)));
}

void set_tag(Bytes& datagram, KeyRole role) {
  const Tag tag = tag_of(datagram, role);
  std::copy(tag.begin(), tag.end(), datagram.begin() + static_cast<std::ptrdiff_t>(tag_offset(datagram)));
}

KeyRole role_in(const Bytes& request) { return find_node_key_role(request[kRoleAt]).value_or(KeyRole::haptics); }

// The role whose key gives the tag of a handshake message.
KeyRole tag_role(const Bytes& datagram, KeyRole node_role) {
  return datagram[2] == static_cast<std::uint8_t>(Kind::request) ? role_in(datagram) : node_role;
}

void set_noise_message(Bytes& request) {
  noise::Key secret;
  secret.fill(7);
  noise::HandshakeState state;
  state.begin(derive_psk(RoleKey(make_master(), role_in(request))), std::span(request).first(kPrologueBytes), secret);
  state.write_first({}, request.data() + kFirstAt);
}

}  // namespace

bool OneDatagramEndpoint::send(const Address& to, std::span<const std::byte> datagram) noexcept {
  const auto* const bytes = bytes_of(datagram);
  sent.push_back({to, Bytes(bytes, bytes + datagram.size())});
  return true;
}

Received OneDatagramEndpoint::receive(std::span<std::byte> into, std::int64_t) noexcept {
  const Bytes bytes = std::exchange(datagram_, {});
  std::copy(bytes.begin(), bytes.end(), bytes_of(into));
  return {.bytes = bytes.size(), .from = from_};
}

void OneDatagramEndpoint::hold(const Bytes& datagram, const Address& from) {
  datagram_ = datagram;
  from_ = from;
}

HandshakeLine::HandshakeLine()
    : clock_(start()),
      hub_end_(address_of_hub()),
      node_end_(address_of_node(0)),
      hub_(hub_end_, clock_, make_master()),
      node_(node_end_, clock_, RoleKey(make_master(), kNodeRole), address_of_hub(), {.host = 1}) {
  const std::byte word{1};
  node_.send(address_of_hub(), std::span(&word, 1));
}

std::size_t HandshakeLine::deliver(const ListedDatagram& datagram) {
  clock_.advance_ns(datagram.pause_ns());
  std::array<std::byte, kMaxDatagramBytes> into;
  if (datagram.is_to_node()) {
    node_end_.hold(datagram.bytes, address_of_hub());
    return node_.receive(into, clock_.now_ns()).bytes;
  }
  hub_end_.hold(datagram.bytes, address_of_node(datagram.node()));
  return hub_.receive(into, clock_.now_ns()).bytes;
}

std::optional<Kind> find_handshake_kind(const Bytes& datagram) {
  const SealedKind found = classify_sealed(as_datagram(datagram));
  if (found.status != OpenStatus::opened || found.kind == Kind::data) return std::nullopt;
  return found.kind;
}

bool has_tag(const Bytes& datagram, KeyRole node_role) {
  if (!find_handshake_kind(datagram)) return false;
  return is_tag(tag_of(datagram, tag_role(datagram, node_role)), datagram.data() + tag_offset(datagram));
}

Bytes make_request(KeyRole role, std::uint64_t host, std::int64_t timestamp_ns, const Cookie& cookie) {
  Bytes request(kRequestBytes);
  write_lead(Kind::request, request.data());
  request[kRoleAt] = static_cast<std::uint8_t>(role);
  store(host, request.data() + kHostAt);
  store(timestamp_ns, request.data() + kRequestTimestampAt);
  std::copy(cookie.begin(), cookie.end(), request.begin() + kRequestCookieAt);
  set_noise_message(request);
  set_tag(request, role);
  return request;
}

Bytes make_retry(std::int64_t timestamp_ns, const Cookie& cookie, KeyRole role) {
  Bytes retry(kRetryBytes);
  write_lead(Kind::retry, retry.data());
  store(timestamp_ns, retry.data() + kTimestampAt);
  std::copy(cookie.begin(), cookie.end(), retry.begin() + kCookieAt);
  set_tag(retry, role);
  return retry;
}

std::optional<Bytes> make_reply(const Bytes& request, std::uint32_t connection) {
  if (find_handshake_kind(request) != Kind::request) return std::nullopt;
  noise::Key secret;
  secret.fill(9);
  noise::HandshakeState state;
  state.begin(derive_psk(RoleKey(make_master(), role_in(request))), std::span(request).first(kPrologueBytes), secret);
  std::array<std::uint8_t, 1> nothing;
  if (!state.read_first(std::span(request).subspan(kFirstAt, kFirstBytes), nothing.data())) return std::nullopt;
  Bytes reply(kReplyBytes);
  write_lead(Kind::reply, reply.data());
  std::copy_n(request.begin() + kRequestTimestampAt, 8, reply.begin() + kTimestampAt);
  std::array<std::uint8_t, 4> payload;
  store(connection, payload.data());
  if (!state.write_second(payload, reply.data() + kSecondAt)) return std::nullopt;
  set_tag(reply, role_in(request));
  return reply;
}

Cookie find_cookie(std::uint8_t node, std::int64_t now_ns) {
  static std::map<std::pair<std::uint8_t, std::int64_t>, Cookie> cookies;
  const auto [cookie, is_new] = cookies.try_emplace({node, now_ns / HubHandshake::kCookieTimeNs});
  if (!is_new) return cookie->second;
  start();
  SimulatedClock clock(now_ns);
  OneDatagramEndpoint end(address_of_hub());
  SealedHub hub(end, clock, make_master());
  end.hold(make_request(KeyRole::haptics, 1, now_ns, {}), address_of_node(node));
  std::array<std::byte, kMaxDatagramBytes> into;
  hub.receive(into, now_ns);
  if (!end.sent.empty()) std::copy_n(end.sent[0].bytes.begin() + kCookieAt, kCookieBytes, cookie->second.begin());
  return cookie->second;
}

namespace {

// The node's own requests: the first is without a cookie, the second has the cookie that a retry gave the node.
const std::vector<Bytes>& node_requests() {
  static const std::vector<Bytes> requests = [] {
    HandshakeLine line;
    const Bytes first = line.from_node().at(0).bytes;
    line.deliver(
        {.flags = 1, .bytes = make_retry(load<std::int64_t>(first.data() + kRequestTimestampAt), find_cookie(0, kStartNs), kNodeRole)});
    return std::vector<Bytes>{first, line.from_node().back().bytes};
  }();
  return requests;
}

Cookie random_cookie(Mutation& mutation) {
  Cookie cookie;
  std::generate(cookie.begin(), cookie.end(), [&] { return static_cast<std::uint8_t>(mutation.number()); });
  return cookie;
}

// The time at which the datagram with this index is delivered.
std::int64_t time_at(const std::vector<ListedDatagram>& datagrams, std::size_t index) {
  std::int64_t now_ns = kStartNs;
  for (std::size_t i = 0; i <= index; ++i) now_ns += datagrams[i].pause_ns();
  return now_ns;
}

// The datagram with this index, as an honest sender would have made it.
Bytes make_honest(const std::vector<ListedDatagram>& datagrams, std::size_t index, Mutation& mutation) {
  const ListedDatagram& listed = datagrams[index];
  const std::int64_t now_ns = time_at(datagrams, index);
  if (!listed.is_to_node()) {
    return make_request(listed.role(), 1 + mutation.below(3), now_ns + static_cast<std::int64_t>(index + 1),
                        find_cookie(listed.node(), now_ns));
  }
  const Bytes& request = node_requests()[mutation.below(node_requests().size())];
  if (mutation.one_in(2)) return make_retry(load<std::int64_t>(request.data() + kRequestTimestampAt), random_cookie(mutation), kNodeRole);
  return make_reply(request, static_cast<std::uint32_t>(mutation.number())).value_or(request);
}

void change_part(Bytes& datagram, std::size_t at, std::size_t size, Mutation& mutation) {
  const auto begin = datagram.begin() + static_cast<std::ptrdiff_t>(at);
  const Bytes changed = mutation.change_in_place(Bytes(begin, begin + static_cast<std::ptrdiff_t>(size)));
  std::copy(changed.begin(), changed.end(), begin);
}

// Changes one field of a request, and mostly makes its Noise message and its cookie valid again.
void change_request(Bytes& request, std::int64_t now_ns, std::uint8_t node, Mutation& mutation) {
  bool is_noise_message_changed = false;
  switch (mutation.below(6)) {
    case 0:
      request[kRoleAt] =
          static_cast<std::uint8_t>(mutation.one_in(4) ? mutation.below(256) : kFirstKeyRole + mutation.below(kNodeKeyRoles));
      break;
    case 1:
      store(mutation.odd_number(), request.data() + kHostAt);
      break;
    case 2: {
      const auto odd = static_cast<std::int64_t>(mutation.odd_number());
      store(mutation.one_in(2) ? odd : now_ns + odd % kNanosecondsPerSecond, request.data() + kRequestTimestampAt);
      break;
    }
    case 3:
      change_part(request, kFirstAt, kFirstBytes, mutation);
      is_noise_message_changed = true;
      break;
    case 4:
      change_part(request, kRequestCookieAt, kCookieBytes, mutation);
      break;
    default:
      change_part(request, kRoleAt, kRequestTagAt - kRoleAt, mutation);
      is_noise_message_changed = mutation.one_in(2);
  }
  std::fill_n(request.begin() + kRoleAt + 1, 3, std::uint8_t{0});
  if (!is_noise_message_changed && mutation.below(8) != 0) set_noise_message(request);
  if (mutation.below(4) != 0) {
    const Cookie cookie = find_cookie(node, now_ns);
    std::copy(cookie.begin(), cookie.end(), request.begin() + kRequestCookieAt);
  }
}

void change_handshake(std::vector<ListedDatagram>& datagrams, std::size_t index, Mutation& mutation) {
  ListedDatagram& listed = datagrams[index];
  const auto kind = find_handshake_kind(listed.bytes);
  if (!kind || mutation.one_in(8)) {
    listed.bytes = make_honest(datagrams, index, mutation);
    return;
  }
  if (*kind == Kind::request) {
    change_request(listed.bytes, time_at(datagrams, index), listed.node(), mutation);
  } else {
    // The timestamp says to which request this message replies: it mostly stays unchanged.
    const std::size_t from = mutation.one_in(4) ? kTimestampAt : kTimestampAt + 8;
    change_part(listed.bytes, from, tag_offset(listed.bytes) - from, mutation);
  }
  set_tag(listed.bytes, tag_role(listed.bytes, kNodeRole));
}

}  // namespace

Bytes mutate_handshakes(std::span<const std::uint8_t> input, Mutation& mutation) {
  if (!FixedRandom::install()) return Bytes(input.begin(), input.end());
  std::vector<ListedDatagram> datagrams = split_datagrams(input);
  if (datagrams.empty() || mutation.one_in(12)) datagrams.push_back({static_cast<std::uint8_t>(mutation.below(32)), {}});
  const std::size_t index = mutation.below(datagrams.size());
  switch (mutation.below(8)) {
    case 0:
      mutation.change_order(datagrams);
      break;
    case 1:
      datagrams[index].flags ^= static_cast<std::uint8_t>(1U << mutation.below(5));
      datagrams[index].bytes = make_honest(datagrams, index, mutation);
      break;
    default:
      change_handshake(datagrams, index, mutation);
  }
  if (datagrams.size() > kMaxHandshakes) datagrams.resize(kMaxHandshakes);
  for (std::size_t i = 0; i < datagrams.size(); ++i) {
    if (datagrams[i].bytes.empty() || (!has_tag(datagrams[i].bytes, kNodeRole) && mutation.one_in(2)))
      datagrams[i].bytes = make_honest(datagrams, i, mutation);
  }
  return join_datagrams(datagrams);
}

Bytes cross_handshakes(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b, Mutation& mutation) {
  std::vector<ListedDatagram> both = mutation.cross(split_datagrams(a), split_datagrams(b));
  if (both.size() > kMaxHandshakes) both.resize(kMaxHandshakes);
  return join_datagrams(both);
}

}  // namespace hapton::fuzz
