// Floods a UDP port with datagrams that need no key: junk, captured datagrams repeatedly, oversized ones. For deploy/attack and for testing
// a network; it floods loopback and private addresses only.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/ip.h>
#include <netinet/udp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "link/udp_endpoint.h"
#include "runtime/clock.h"

namespace {

using namespace hapton;

struct Options {
  std::string to = "127.0.0.1:4950";
  std::string kind = "junk";
  double rate_per_s = 100'000.0;
  double seconds = 5.0;
  int sources = 1;
  std::uint64_t seed = 1;
  std::string listen;   // address at which the datagrams of a node are captured
  std::string capture;  // file of captured datagrams
  std::string spoof;    // source address written into the datagrams
};

using Datagram = std::vector<std::uint8_t>;
constexpr std::uint8_t kRequestKind = 1, kDataKind = 4;  // seal::Kind::request, seal::Kind::data

sockaddr_in v4_of(const Address& address) {
  sockaddr_in at = {};
  at.sin_family = AF_INET;
  at.sin_port = htons(address.port);
  std::memcpy(&at.sin_addr, address.ip.data() + 12, 4);
  return at;
}

// Loopback, 10/8, 172.16/12, 192.168/16: a mistyped address must not reach anyone else.
bool is_private_v4(const Address& address) {
  if (address.ip[10] != 0xFF || address.ip[11] != 0xFF) return false;
  const std::uint8_t* ip = address.ip.data() + 12;
  return ip[0] == 127 || ip[0] == 10 || (ip[0] == 172 && (ip[1] & 0xF0) == 16) || (ip[0] == 192 && ip[1] == 168);
}

// Relays between a node and the hub for a while, and records the node's datagrams, as an eavesdropper could.
int capture(const Options& options, const Address& hub) {
  const auto listen = parse_address(options.listen);
  auto node_side = open_udp_endpoint(options.listen);
  auto hub_side = open_udp_endpoint("127.0.0.1:0");
  if (!listen || !node_side || !hub_side) {
    std::fprintf(stderr, "hapton_flood: cannot listen at %s\n", options.listen.c_str());
    return 1;
  }
  SteadyClock clock;
  std::ofstream file(options.capture, std::ios::binary);
  std::array<std::byte, kMaxDatagramBytes> bytes = {};
  Address node;
  std::size_t captured_count = 0;
  const std::int64_t end_ns = clock.now_ns() + static_cast<std::int64_t>(1e9 * options.seconds);
  while (clock.now_ns() < end_ns && captured_count < 64) {
    if (const Received received = (*node_side)->receive(bytes, clock.now_ns() + kNanosecondsPerMillisecond); received.bytes > 0) {
      node = received.from;
      const auto size = static_cast<std::uint16_t>(received.bytes);
      file.write(reinterpret_cast<const char*>(&size), sizeof size);
      file.write(reinterpret_cast<const char*>(bytes.data()), size);
      ++captured_count;
      (*hub_side)->send(hub, std::span(bytes).first(received.bytes));
    }
    if (const Received received = (*hub_side)->receive(bytes, clock.now_ns() + kNanosecondsPerMillisecond);
        received.bytes > 0 && node.port != 0) {
      (*node_side)->send(node, std::span(bytes).first(received.bytes));
    }
  }
  std::printf("captured %zu datagrams\n", captured_count);
  return captured_count > 0 && file ? 0 : 1;
}

// kind: the third byte of a sealed datagram, which is its kind; 0: all datagrams.
std::vector<Datagram> read_captured(const std::string& path, std::uint8_t kind) {
  std::vector<Datagram> captured;
  std::ifstream file(path, std::ios::binary);
  for (std::uint16_t size = 0; file.read(reinterpret_cast<char*>(&size), sizeof size);) {
    Datagram datagram(size);
    if (!file.read(reinterpret_cast<char*>(datagram.data()), size)) break;
    if (size > 3 && (kind == 0 || datagram[2] == kind)) captured.push_back(std::move(datagram));
  }
  return captured;
}

std::vector<Datagram> make_load(const Options& options) {
  if (options.kind == "handshake") return read_captured(options.capture, kRequestKind);
  if (options.kind == "data") return read_captured(options.capture, kDataKind);
  std::mt19937_64 random(options.seed);
  std::vector<Datagram> load;
  for (int n = 0; n < 64; ++n) {
    Datagram datagram(options.kind == "oversized" ? 1400 : 1 + random() % 160);
    for (std::uint8_t& byte : datagram) byte = static_cast<std::uint8_t>(random());
    load.push_back(std::move(datagram));
  }
  return load;
}

// Several datagrams of one size, sent by one system call: the kernel cuts them apart at the receiver (UDP_SEGMENT). That costs the sender a
// tenth of the time.
struct Burst {
  Datagram bytes;
  std::uint16_t size = 0;
  std::size_t count = 0;
};

std::vector<Burst> make_bursts(const std::vector<Datagram>& load, bool is_junk, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Burst> bursts;
  for (const Datagram& datagram : load) {
    Burst burst{{}, static_cast<std::uint16_t>(datagram.size()), std::clamp<std::size_t>(60'000 / datagram.size(), 1, 32)};
    for (std::size_t n = 0; n < burst.count; ++n) {
      burst.bytes.insert(burst.bytes.end(), datagram.begin(), datagram.end());
      if (is_junk) std::generate(burst.bytes.end() - burst.size, burst.bytes.end(), [&] { return static_cast<std::uint8_t>(random()); });
    }
    bursts.push_back(std::move(burst));
  }
  return bursts;
}

bool send_burst(int socket, const sockaddr_in& to, Burst& burst) {
  iovec part = {burst.bytes.data(), burst.bytes.size()};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof burst.size)> control = {};
  msghdr message = {};
  message.msg_name = const_cast<sockaddr_in*>(&to);
  message.msg_namelen = sizeof to;
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  cmsghdr* const header = CMSG_FIRSTHDR(&message);
  header->cmsg_level = SOL_UDP;
  header->cmsg_type = UDP_SEGMENT;
  header->cmsg_len = CMSG_LEN(sizeof burst.size);
  std::memcpy(CMSG_DATA(header), &burst.size, sizeof burst.size);
  return ::sendmsg(socket, &message, MSG_DONTWAIT) >= 0;
}

// Makes whole IP packets with the source address `from`. Over IPv4 a UDP datagram needs no checksum.
std::vector<Datagram> make_packets(const std::vector<Datagram>& load, const sockaddr_in& from, const sockaddr_in& to) {
  std::vector<Datagram> packets;
  for (const Datagram& datagram : load) {
    ip network = {};
    network.ip_hl = sizeof network / 4;
    network.ip_v = 4;
    network.ip_ttl = 64;
    network.ip_p = IPPROTO_UDP;
    network.ip_src = from.sin_addr;
    network.ip_dst = to.sin_addr;
    udphdr transport = {};
    transport.source = from.sin_port;
    transport.dest = to.sin_port;
    transport.len = htons(static_cast<std::uint16_t>(sizeof transport + datagram.size()));
    Datagram packet(sizeof network + sizeof transport + datagram.size());
    std::memcpy(packet.data(), &network, sizeof network);
    std::memcpy(packet.data() + sizeof network, &transport, sizeof transport);
    std::memcpy(packet.data() + sizeof network + sizeof transport, datagram.data(), datagram.size());
    packets.push_back(std::move(packet));
  }
  return packets;
}

int flood_as_another(const Options& options, const Address& hub, const std::vector<Datagram>& load) {
  const auto from = parse_address(options.spoof);
  const int socket = ::socket(AF_INET, SOCK_RAW | SOCK_CLOEXEC, IPPROTO_RAW);
  if (!from || socket < 0) {
    std::fprintf(stderr, "hapton_flood: this user may not send in another's name\n");
    return 77;
  }
  const sockaddr_in to = v4_of(hub);
  std::vector<Datagram> packets = make_packets(load, v4_of(*from), to);
  constexpr std::size_t kBatch = 32;
  std::array<iovec, kBatch> parts = {};
  std::array<mmsghdr, kBatch> messages = {};
  for (std::size_t n = 0; n < kBatch; ++n) {
    Datagram& packet = packets[n % packets.size()];
    parts[n] = {packet.data(), packet.size()};
    messages[n].msg_hdr.msg_name = const_cast<sockaddr_in*>(&to);
    messages[n].msg_hdr.msg_namelen = sizeof to;
    messages[n].msg_hdr.msg_iov = &parts[n];
    messages[n].msg_hdr.msg_iovlen = 1;
  }
  SteadyClock clock;
  const std::int64_t begin_ns = clock.now_ns();
  const std::int64_t end_ns = begin_ns + static_cast<std::int64_t>(1e9 * options.seconds);
  std::uint64_t sent = 0;
  for (std::int64_t now_ns = begin_ns; now_ns < end_ns; now_ns = clock.now_ns()) {
    if (1e-9 * static_cast<double>(now_ns - begin_ns) * options.rate_per_s < static_cast<double>(sent)) {
      clock.sleep_until_ns(now_ns + 50'000);
      continue;
    }
    const int count = ::sendmmsg(socket, messages.data(), kBatch, MSG_DONTWAIT);
    sent += count > 0 ? static_cast<std::uint64_t>(count) : 0;
  }
  ::close(socket);
  std::printf("{\"sent_per_s\": %.0f, \"sent\": %llu}\n", static_cast<double>(sent) / options.seconds,
              static_cast<unsigned long long>(sent));
  return 0;
}

int flood(const Options& options, const Address& hub, const std::vector<Datagram>& load) {
  std::vector<int> sockets;
  const sockaddr_in to = v4_of(hub);
  for (int n = 0; n < options.sources; ++n) {
    const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (socket < 0) break;
    sockets.push_back(socket);
  }
  if (sockets.empty()) return 1;
  std::vector<Burst> bursts = make_bursts(load, options.kind == "junk" || options.kind == "oversized", options.seed);
  SteadyClock clock;
  const std::int64_t begin_ns = clock.now_ns();
  const std::int64_t end_ns = begin_ns + static_cast<std::int64_t>(1e9 * options.seconds);
  std::uint64_t sent = 0;
  std::uint64_t skipped = 0;
  std::size_t next = 0;
  for (std::int64_t now_ns = begin_ns; now_ns < end_ns; now_ns = clock.now_ns()) {
    const auto due = static_cast<std::uint64_t>(1e-9 * static_cast<double>(now_ns - begin_ns) * options.rate_per_s);
    if (due <= sent + skipped) {
      clock.sleep_until_ns(now_ns + 50'000);
      continue;
    }
    // A sender that did not get its CPU for a while does not make up for it in one burst.
    const auto max_behind = static_cast<std::uint64_t>(0.02 * options.rate_per_s) + 64;
    if (due > sent + skipped + max_behind) skipped = due - sent - max_behind;
    Burst& burst = bursts[next % bursts.size()];
    sent += send_burst(sockets[next % sockets.size()], to, burst) ? burst.count : 0;
    ++next;
  }
  const double seconds = 1e-9 * static_cast<double>(clock.now_ns() - begin_ns);
  std::printf("{\"sent_per_s\": %.0f, \"sent\": %llu}\n", static_cast<double>(sent) / seconds, static_cast<unsigned long long>(sent));
  for (const int file : sockets) ::close(file);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"Floods a hub with what an unknown peer without its key can send, or captures what a node says to it.", "hapton_flood"};
  app.add_option("--to", options.to, "The hub, on this machine or a private network")->capture_default_str();
  app.add_option("--kind", options.kind, "Kind of datagram")
      ->check(CLI::IsMember({"junk", "oversized", "handshake", "data"}))
      ->capture_default_str();
  app.add_option("--rate", options.rate_per_s, "Datagrams a second")->check(CLI::Range(1.0, 1e8))->capture_default_str();
  app.add_option("--seconds", options.seconds, "How long")->check(CLI::Range(0.01, 1e6))->capture_default_str();
  app.add_option("--sources", options.sources, "Number of source ports")->check(CLI::Range(1, 1000))->capture_default_str();
  app.add_option("--seed", options.seed, "Seed of the junk")->capture_default_str();
  app.add_option("--capture", options.capture, "File of captured datagrams: to replay (handshake, data), or with --listen to write");
  app.add_option("--spoof", options.spoof, "Sends as if from this address (root only)");
  app.add_option("--listen", options.listen, "Captures: a node whose hub is this address is passed on to --to");
  CLI11_PARSE(app, argc, argv);
  const auto hub = parse_address(options.to);
  if (!hub || !is_private_v4(*hub)) {
    std::fprintf(stderr, "hapton_flood: %s is not an IPv4 address of this machine or a private network\n", options.to.c_str());
    return 2;
  }
  if (!options.listen.empty()) return capture(options, *hub);
  const std::vector<Datagram> load = make_load(options);
  if (load.empty()) {
    std::fprintf(stderr, "hapton_flood: %s holds no captured %s; make one with --listen\n", options.capture.c_str(), options.kind.c_str());
    return 2;
  }
  return options.spoof.empty() ? flood(options, *hub, load) : flood_as_another(options, *hub, load);
}
