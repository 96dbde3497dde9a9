// An attacker between a hub and a node does what the bytes say: he holds back, repeats, swaps, reflects, changes and forges datagrams, and
// lets time pass. He also has the key of the role: he can give a changed handshake message its valid tag, so that the code behind the check
// of the tag is reached. Nothing may be handed out that was not sent, and nothing twice within a session.
#include <algorithm>
#include <set>
#include <vector>

#include "link/memory_endpoint.h"
#include "link/sealed_client.h"
#include "link/sealed_hub.h"
#include "runtime/clock.h"
#include "tests/fuzz/fixed_random.h"
#include "tests/fuzz/fuzz_target.h"

namespace hapton {
namespace {

using Bytes = std::vector<std::byte>;

// One end of the connection. The attacker gets all that is sent, and chooses what is received.
class AttackedEndpoint final : public Endpoint {
 public:
  explicit AttackedEndpoint(const Address& at) : at_(at) {}
  bool send(const Address&, std::span<const std::byte> datagram) noexcept override {
    if (sent.size() < 64) sent.emplace_back(datagram.begin(), datagram.end());
    return true;
  }
  Received receive(std::span<std::byte> into, std::int64_t) noexcept override {
    if (!has_next) return {};
    has_next = false;
    std::copy(next.begin(), next.end(), into.begin());
    return {.bytes = next.size(), .from = from};
  }
  Address local_address() const override { return at_; }

  std::vector<Bytes> sent;
  bool has_next = false;
  Bytes next;
  Address from;

 private:
  Address at_;
};

// Reads the bytes as commands; after their end, it reads zeros.
class Script {
 public:
  explicit Script(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  bool is_over() const { return at_ >= bytes_.size(); }
  std::uint8_t next() { return is_over() ? std::uint8_t{0} : bytes_[at_++]; }
  Bytes take(std::size_t most) {
    const std::size_t size = std::min(most, bytes_.size() - std::min(at_, bytes_.size()));
    Bytes taken(size);
    std::transform(bytes_.begin() + static_cast<std::ptrdiff_t>(at_), bytes_.begin() + static_cast<std::ptrdiff_t>(at_ + size),
                   taken.begin(), [](std::uint8_t byte) { return std::byte{byte}; });
    at_ += size;
    return taken;
  }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

LinkKey some_key() {
  LinkKey::Bytes bytes;
  bytes.fill(1);
  return LinkKey(bytes);
}

// A hub and a node whose datagrams pass through the attacker. A word is a number that one of them sends to the other.
class AttackedConnection {
 public:
  void run(Script script) {
    while (!script.is_over()) step(script);
  }

 private:
  void step(Script& script) {
    switch (script.next() % 12) {
      case 0:
        return send_word(true);
      case 1:
        return send_word(false);
      case 2:
        return deliver(pick(node_end_.sent, script), true);
      case 3:
        return deliver(pick(hub_end_.sent, script), false);
      case 4:  // reflected to the sender
        return deliver(pick(node_end_.sent, script), false);
      case 5:
        return deliver(pick(hub_end_.sent, script), true);
      case 6:
        return deliver(changed(pick(node_end_.sent, script), script), true);
      case 7:
        return deliver(changed(pick(hub_end_.sent, script), script), false);
      case 8:
        return deliver(tagged(changed(pick(node_end_.sent, script), script)), true);
      case 9:
        return deliver(tagged(changed(pick(hub_end_.sent, script), script)), false);
      case 10: {
        const bool to_hub = script.next() % 2 == 0;
        return deliver(script.take(script.next()), to_hub);
      }
      default:
        clock_.advance_ns((std::int64_t{script.next()} + 1) * 10 * kNanosecondsPerMillisecond);
    }
  }

  void send_word(bool from_node) {
    const std::uint32_t number = ++sent_words_;
    const auto word = std::as_bytes(std::span(&number, 1));
    (from_node ? sent_by_node_ : sent_by_hub_).insert(number);
    if (from_node) {
      node_.send(hub_end_.local_address(), word);
    } else {
      hub_.send(node_end_.local_address(), word);
    }
  }

  static Bytes pick(const std::vector<Bytes>& from, Script& script) {
    const std::uint8_t which = script.next();
    return from.empty() ? Bytes() : from[which % from.size()];
  }

  static Bytes changed(Bytes bytes, Script& script) {
    const std::size_t place = script.next() | static_cast<std::size_t>(script.next() << 8);
    const auto mask = std::byte{script.next()};
    if (!bytes.empty()) bytes[place % bytes.size()] ^= mask;
    if (mask == std::byte{0} && !bytes.empty()) bytes.resize(place % bytes.size());
    return bytes;
  }

  // Gives a handshake message the tag that is valid for its bytes; leaves any other datagram unchanged.
  Bytes tagged(Bytes bytes) const {
    if (classify_sealed(bytes).status != OpenStatus::opened || classify_sealed(bytes).kind == seal::Kind::data) return bytes;
    std::uint8_t* const text = seal::bytes_of(std::span(bytes));
    const std::size_t tag_offset = bytes.size() - seal::kTagBytes;
    const seal::Tag tag = seal::compute_tag(handshake_key_, {text, tag_offset});
    std::copy(tag.begin(), tag.end(), text + tag_offset);
    return bytes;
  }

  void deliver(Bytes bytes, bool to_hub) {
    if (bytes.empty() || bytes.size() > kMaxDatagramBytes) return;
    AttackedEndpoint& end = to_hub ? hub_end_ : node_end_;
    end.next = std::move(bytes);
    end.from = (to_hub ? node_end_ : hub_end_).local_address();
    end.has_next = true;
    std::array<std::byte, kMaxDatagramBytes> into;
    const Received received = to_hub ? hub_.receive(into, 0) : node_.receive(into, 0);
    end.has_next = false;
    if (received.bytes != 0) check_received(std::span(into).first(received.bytes), to_hub);
  }

  void check_received(std::span<const std::byte> word, bool by_hub) {
    std::uint32_t number = 0;
    fuzz::require(word.size() == sizeof number);
    std::copy(word.begin(), word.end(), std::as_writable_bytes(std::span(&number, 1)).begin());
    // The other side sent it. While a new session is requested, a datagram is sent in both sessions: it may arrive once in each.
    fuzz::require((by_hub ? sent_by_node_ : sent_by_hub_).contains(number));
    const std::size_t times = (by_hub ? received_by_hub_ : received_by_node_).insert(number).second ? 1 : 2;
    if (times == 2) fuzz::require(by_hub && ++received_twice_ <= node_.seal_counts().handshakes);
  }

  SimulatedClock clock_;
  AttackedEndpoint hub_end_{memory_address(1, 4950)};
  AttackedEndpoint node_end_{memory_address(2, 9)};
  SealedHub hub_{hub_end_, clock_, some_key()};
  SealedClient node_{node_end_,
                     clock_,
                     RoleKey(some_key(), KeyRole::haptics),
                     memory_address(1, 4950),
                     {.host = 1, .rekey_every_ns = 500 * kNanosecondsPerMillisecond}};
  seal::Secret handshake_key_ = seal::derive_handshake_key(RoleKey(some_key(), KeyRole::haptics));
  std::uint32_t sent_words_ = 0;
  std::set<std::uint32_t> sent_by_node_;
  std::set<std::uint32_t> sent_by_hub_;
  std::set<std::uint32_t> received_by_hub_;
  std::set<std::uint32_t> received_by_node_;
  std::uint64_t received_twice_ = 0;
};

}  // namespace
}  // namespace hapton

FUZZ_TARGET(handshake) {
  hapton::fuzz::require(hapton::fuzz::FixedRandom::install());
  hapton::fuzz::FixedRandom::restart();
  hapton::AttackedConnection().run(hapton::Script(bytes));
}
