#include "link/handshake.h"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "link/codec.h"
#include "link/memory_endpoint.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

using Bytes = std::vector<std::byte>;
using Finished = ClientHandshake::Finished;
using Verdict = HubHandshake::Verdict;
using Where = AgreementWorker::Where;

constexpr std::int64_t kHubNowNs = 100 * HubHandshake::kCookieTimeNs;  // a time of the hub's clock, later than two cookie times
constexpr std::uint64_t kHost = 77;                                    // any value

LinkKey master_of(std::uint8_t number) {
  EXPECT_TRUE(seal::start_crypto());
  LinkKey::Bytes bytes;
  bytes.fill(number);
  return LinkKey(bytes);
}

RoleKey key_of(std::uint8_t number, KeyRole role = KeyRole::haptics) { return {master_of(number), role}; }

Bytes flip(Bytes bytes, std::size_t bit) {
  bytes[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
  return bytes;
}

class HandshakeTest : public testing::Test {
 protected:
  HandshakeTest() { client_.begin(); }

  Bytes request_of(ClientHandshake& client) {
    EXPECT_TRUE(client.start_request(now_ns_ += 50'000'000));
    Bytes bytes(seal::kRequestBytes);
    EXPECT_EQ(client.poll(bytes), Finished::request);
    EXPECT_EQ(client.poll(bytes), Finished::nothing);
    return bytes;
  }
  Bytes request() { return request_of(client_); }
  Bytes retry(const Bytes& to) const {
    Bytes bytes(seal::kRetryBytes);
    EXPECT_EQ(hub_.write_retry(to, from_, kHubNowNs, bytes), bytes.size());
    return bytes;
  }
  // A request that contains the hub's cookie.
  Bytes request_with_cookie() {
    EXPECT_TRUE(client_.read_retry(retry(request())));
    return request();
  }
  HubHandshake::Agreement agree(HubHandshake& hub, const Bytes& to, std::uint32_t connection = 5) {
    HubHandshake::Agreement agreement;
    EXPECT_TRUE(hub.agree(to, connection));
    EXPECT_TRUE(hub.poll(agreement));
    return agreement;
  }
  Bytes reply(const Bytes& to) {
    HubHandshake::Agreement agreement = agree(hub_, to);
    EXPECT_TRUE(agreement.is_valid);
    hub_channel_ = std::move(agreement.channel);
    return {agreement.reply.begin(), agreement.reply.end()};
  }
  bool leads_to_session(const Bytes& reply) {
    if (!client_.read_reply(reply)) return false;
    Bytes none(seal::kRequestBytes);
    return client_.poll(none) == Finished::agreement;
  }
  Verdict check_request(const Bytes& bytes) { return hub_.check_request(bytes, from_, kHubNowNs); }

  static bool carries(SealedChannel& from, SealedChannel& to) {
    Bytes sealed(kMaxDatagramBytes);
    sealed.resize(from.seal(Bytes(20), sealed));
    Bytes opened(kMaxDatagramBytes);
    std::size_t bytes = 0;
    return to.open(sealed, opened, bytes) == OpenStatus::opened;
  }

  std::int64_t now_ns_ = 1'000'000'000;
  ClientHandshake client_{key_of(1), kHost, Where::caller};
  HubHandshake hub_{master_of(1), Where::caller};
  Address from_ = memory_address(2, 20);
  SealedChannel hub_channel_;
};

TEST_F(HandshakeTest, ANodeAndItsHubAgreeOnASession) {
  const Bytes first = request();
  EXPECT_EQ(check_request(first), Verdict::wants_cookie);
  EXPECT_TRUE(client_.read_retry(retry(first)));
  const Bytes second = request();
  EXPECT_EQ(check_request(second), Verdict::shows_cookie);
  EXPECT_TRUE(leads_to_session(reply(second)));
  EXPECT_FALSE(client_.is_pending());
  SealedChannel channel = client_.take_channel();
  EXPECT_EQ(channel.connection(), 5U);
  EXPECT_TRUE(carries(channel, hub_channel_));
  EXPECT_TRUE(carries(hub_channel_, channel));
}

TEST_F(HandshakeTest, WithAThreadOfItsOwnItIsTheSame) {
  ClientHandshake client(key_of(1), kHost, Where::own_thread);
  HubHandshake hub(master_of(1), Where::own_thread);
  client.begin();
  const auto next = [&](Bytes& into) {
    Finished finished = Finished::nothing;
    while (finished == Finished::nothing) finished = client.poll(into);
    return finished;
  };
  Bytes bytes(seal::kRequestBytes);
  ASSERT_TRUE(client.start_request(1));
  ASSERT_EQ(next(bytes), Finished::request);
  Bytes cookie(seal::kRetryBytes);
  hub.write_retry(bytes, from_, kHubNowNs, cookie);
  ASSERT_TRUE(client.read_retry(cookie));
  ASSERT_TRUE(client.start_request(2));
  ASSERT_EQ(next(bytes), Finished::request);
  ASSERT_EQ(hub.check_request(bytes, from_, kHubNowNs), Verdict::shows_cookie);
  ASSERT_TRUE(hub.agree(bytes, 9));
  HubHandshake::Agreement agreement;
  while (!hub.poll(agreement)) {
  }
  ASSERT_TRUE(client.read_reply(agreement.reply));
  ASSERT_EQ(next(bytes), Finished::agreement);
  SealedChannel channel = client.take_channel();
  EXPECT_TRUE(carries(channel, agreement.channel));
}

TEST_F(HandshakeTest, WithoutTheKeyNothingIsAccepted) {
  HubHandshake unknown(master_of(2), Where::caller);
  const Bytes with_cookie = request_with_cookie();
  EXPECT_EQ(unknown.check_request(with_cookie, from_, kHubNowNs), Verdict::wrong_key);
  Bytes forged(seal::kRetryBytes);
  unknown.write_retry(with_cookie, from_, kHubNowNs, forged);
  EXPECT_FALSE(client_.read_retry(forged));
  EXPECT_FALSE(agree(unknown, with_cookie).is_valid);
  EXPECT_TRUE(client_.is_pending());
}

TEST_F(HandshakeTest, TheRoleIsPartOfTheKeys) {
  Bytes with_cookie = request_with_cookie();
  for (const KeyRole other : {KeyRole::vision, KeyRole::tool, KeyRole::operator_role}) {
    with_cookie[seal::kRoleAt] = static_cast<std::byte>(other);
    EXPECT_EQ(check_request(with_cookie), Verdict::wrong_key);
  }
  for (const int none : {0, 1, 6, 255}) {  // unsealed, master, one above the last, the largest byte
    with_cookie[seal::kRoleAt] = static_cast<std::byte>(none);
    EXPECT_EQ(check_request(with_cookie), Verdict::malformed) << none;
  }
}

// Whoever has another role's key, and has recorded every byte of a handshake, cannot open its session.
TEST_F(HandshakeTest, AnotherRolesKeyOpensNoHandshakeThatWasListenedTo) {
  const Bytes with_cookie = request_with_cookie();
  const Bytes reply_bytes = reply(with_cookie);
  const RoleKey vision = key_of(1, KeyRole::vision);
  // The owner of this key poses as a hub: it cannot read the request.
  AgreementTask task;
  task.kind = AgreementTask::Kind::reply_to_request;
  task.psk = seal::derive_psk(vision);
  std::copy_n(seal::bytes_of(std::span(with_cookie)), seal::kPrologueBytes, task.prologue.begin());
  std::copy_n(seal::bytes_of(std::span(with_cookie)) + seal::kFirstAt, seal::kFirstBytes, task.first.begin());
  run_agreement(task);
  EXPECT_FALSE(task.is_valid);
  // The owner of this key poses as the node: it cannot read the reply.
  ClientHandshake vision_node(vision, kHost, Where::caller);
  vision_node.begin();
  EXPECT_FALSE(vision_node.read_reply(reply_bytes));
  EXPECT_TRUE(leads_to_session(reply_bytes));
}

// Forward secrecy: whoever has recorded every byte and later learns the role's key, or the master key that it is derived from, cannot open
// the session, because both ephemeral key pairs are erased.
TEST_F(HandshakeTest, AKeyLearntLaterOpensNoRecordedDatagram) {
  const Bytes with_cookie = request_with_cookie();
  ASSERT_TRUE(leads_to_session(reply(with_cookie)));
  SealedChannel channel = client_.take_channel();
  Bytes recorded(kMaxDatagramBytes);
  recorded.resize(channel.seal(Bytes(20), recorded));
  // The most that the attacker can do is to reply to the same request with a new handshake, which gives other keys.
  AgreementTask task;
  task.kind = AgreementTask::Kind::reply_to_request;
  task.connection = 5;
  task.psk = seal::derive_psk(key_of(1));
  std::copy_n(seal::bytes_of(std::span(with_cookie)), seal::kPrologueBytes, task.prologue.begin());
  std::copy_n(seal::bytes_of(std::span(with_cookie)) + seal::kFirstAt, seal::kFirstBytes, task.first.begin());
  run_agreement(task);
  ASSERT_TRUE(task.is_valid);
  SealedChannel later(task.keys, 5, SealedChannel::Side::hub);
  Bytes opened(kMaxDatagramBytes);
  std::size_t bytes = 0;
  EXPECT_EQ(later.open(recorded, opened, bytes), OpenStatus::forged);
  EXPECT_EQ(hub_channel_.open(recorded, opened, bytes), OpenStatus::opened);
}

TEST_F(HandshakeTest, NoFlippedBitPasses) {
  const Bytes with_cookie = request_with_cookie();
  for (std::size_t bit = 0; bit < 8 * with_cookie.size(); ++bit) {
    const Bytes flipped = flip(with_cookie, bit);
    if (classify_sealed(flipped).status != OpenStatus::opened) continue;
    const Verdict verdict = check_request(flipped);
    ASSERT_TRUE(verdict == Verdict::wrong_key || verdict == Verdict::malformed) << bit;
  }
  const Bytes good_retry = retry(with_cookie);
  for (std::size_t bit = 0; bit < 8 * good_retry.size(); ++bit) ASSERT_FALSE(client_.read_retry(flip(good_retry, bit))) << bit;
  const Bytes good_reply = reply(with_cookie);
  for (std::size_t bit = 0; bit < 8 * good_reply.size(); ++bit) ASSERT_FALSE(leads_to_session(flip(good_reply, bit))) << bit;
  EXPECT_TRUE(leads_to_session(good_reply));
}

TEST_F(HandshakeTest, NoOtherLengthOrVersionIsAHandshake) {
  const Bytes first = request();
  for (const Bytes& message : {first, retry(first), reply(first)}) {
    for (std::size_t size = 0; size < 2 * message.size(); ++size) {
      Bytes other = message;
      other.resize(size);
      EXPECT_EQ(classify_sealed(other).status == OpenStatus::opened, size == message.size()) << size;
    }
    Bytes other = message;
    other[1] = std::byte{kProtocolVersion - 1};
    EXPECT_EQ(classify_sealed(other).status, OpenStatus::wrong_version);
  }
}

TEST_F(HandshakeTest, ARequestIsGoodOnceFromAnyAddress) {
  const Bytes first = request();
  EXPECT_EQ(check_request(first), Verdict::wants_cookie);
  EXPECT_EQ(check_request(first), Verdict::replayed);
  EXPECT_EQ(hub_.check_request(first, memory_address(3, 20), kHubNowNs), Verdict::replayed);
  const Bytes with_cookie = request_with_cookie();
  EXPECT_EQ(check_request(with_cookie), Verdict::shows_cookie);
  EXPECT_EQ(check_request(with_cookie), Verdict::replayed);
  EXPECT_EQ(check_request(first), Verdict::replayed);
}

TEST_F(HandshakeTest, ACookieIsGoodForItsAddressOnly) {
  EXPECT_EQ(hub_.check_request(request_with_cookie(), memory_address(3, 20), kHubNowNs), Verdict::wants_cookie);
  EXPECT_EQ(hub_.check_request(request(), memory_address(2, 21), kHubNowNs), Verdict::wants_cookie);
  EXPECT_EQ(hub_.check_request(request(), from_, kHubNowNs), Verdict::shows_cookie);
}

TEST_F(HandshakeTest, ACookieIsGoodForAWhileOnly) {
  EXPECT_EQ(hub_.check_request(request_with_cookie(), from_, kHubNowNs + HubHandshake::kCookieTimeNs), Verdict::shows_cookie);
  EXPECT_EQ(hub_.check_request(request(), from_, kHubNowNs + 2 * HubHandshake::kCookieTimeNs), Verdict::wants_cookie);
}

TEST_F(HandshakeTest, ACookieIsGoodForItsHubOnly) {
  HubHandshake restarted(master_of(1), Where::caller);
  EXPECT_EQ(restarted.check_request(request_with_cookie(), from_, kHubNowNs), Verdict::wants_cookie);
}

TEST_F(HandshakeTest, TwoRepliesToARequestAreTwoSessions) {
  const Bytes with_cookie = request_with_cookie();
  const Bytes first = reply(with_cookie);
  SealedChannel old_hub = std::move(hub_channel_);
  const Bytes second = reply(with_cookie);
  EXPECT_NE(first, second);
  ASSERT_TRUE(leads_to_session(first));
  SealedChannel channel = client_.take_channel();
  EXPECT_TRUE(carries(channel, old_hub));
  EXPECT_FALSE(carries(channel, hub_channel_));
  EXPECT_FALSE(leads_to_session(second));
}

// The second copy comes before the worker has finished with the first: it is neither an error nor another session.
TEST_F(HandshakeTest, AReplyThatTheNetworkDeliversTwiceLeadsToOneSession) {
  const Bytes reply_bytes = reply(request_with_cookie());
  EXPECT_TRUE(client_.read_reply(reply_bytes));
  EXPECT_TRUE(client_.read_reply(reply_bytes));
  EXPECT_FALSE(client_.read_reply(flip(reply_bytes, 8 * seal::kSecondAt))) << "forged";
  Bytes none(seal::kRequestBytes);
  EXPECT_EQ(client_.poll(none), Finished::agreement);
  EXPECT_EQ(client_.poll(none), Finished::nothing);
}

TEST_F(HandshakeTest, AReplyMayComeLateButNotToAnEarlierHandshake) {
  const Bytes with_cookie = request_with_cookie();
  const Bytes late = reply(with_cookie);
  for (std::size_t i = 1; i < ClientHandshake::kAttempts; ++i) request();
  EXPECT_TRUE(leads_to_session(late));
  client_.begin();
  const Bytes old_retry = retry(request());
  const Bytes old_reply = reply(request());
  client_.begin();
  EXPECT_FALSE(client_.read_retry(old_retry));
  EXPECT_FALSE(leads_to_session(old_reply));
}

TEST_F(HandshakeTest, ARequestReflectedIsNoRetry) {
  Bytes reflected = request();
  reflected.resize(seal::kRetryBytes);
  reflected[2] = static_cast<std::byte>(seal::Kind::retry);
  EXPECT_FALSE(client_.read_retry(reflected));
}

TEST_F(HandshakeTest, NoSenderIsSentMoreThanItSent) {
  EXPECT_LE(seal::kRetryBytes, seal::kRequestBytes);
  EXPECT_LE(seal::kReplyBytes, seal::kRequestBytes);
}

TEST_F(HandshakeTest, EveryRequestHasALaterTimestampAndAKeyPairOfItsOwn) {
  ASSERT_TRUE(client_.start_request(500));
  ASSERT_TRUE(client_.start_request(500));
  ASSERT_TRUE(client_.start_request(3));  // the clock was set back
  std::int64_t last_ns = 0;
  std::vector<Bytes> first_fields;
  Bytes bytes(seal::kRequestBytes);
  while (client_.poll(bytes) == Finished::request) {
    const auto timestamp_ns = seal::load<std::int64_t>(seal::bytes_of(std::span(bytes)) + seal::kRequestTimestampAt);
    EXPECT_GT(timestamp_ns, last_ns);
    last_ns = timestamp_ns;
    first_fields.emplace_back(bytes.begin() + seal::kFirstAt, bytes.begin() + seal::kRequestCookieAt);
  }
  ASSERT_EQ(first_fields.size(), 3U);
  EXPECT_NE(first_fields[0], first_fields[1]);
  EXPECT_NE(first_fields[1], first_fields[2]);
}

TEST_F(HandshakeTest, NodesOfOneRoleOnSeveralHostsHaveClocksOfTheirOwn) {
  ClientHandshake other(key_of(1), kHost + 1, Where::caller);
  other.begin();
  const Bytes late = request();
  EXPECT_EQ(check_request(late), Verdict::wants_cookie);
  now_ns_ = 5;
  EXPECT_EQ(check_request(request_of(other)), Verdict::wants_cookie);
}

// An eavesdropper must not learn which nodes of different roles are on the same host.
TEST_F(HandshakeTest, TheHostIsHiddenAndAlikeForOneRoleAlone) {
  const auto host_in_request = [&](KeyRole role, std::uint64_t host) {
    ClientHandshake client(key_of(1, role), host, Where::caller);
    client.begin();
    const Bytes bytes = request_of(client);
    return seal::load<std::uint64_t>(seal::bytes_of(std::span(bytes)) + seal::kHostAt);
  };
  const std::uint64_t hidden_host = host_in_request(KeyRole::haptics, kHost);
  EXPECT_NE(hidden_host, kHost);
  EXPECT_EQ(hidden_host, host_in_request(KeyRole::haptics, kHost));
  EXPECT_NE(hidden_host, host_in_request(KeyRole::vision, kHost));
  EXPECT_NE(hidden_host, host_in_request(KeyRole::haptics, kHost + 1));
}

TEST_F(HandshakeTest, UsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  std::array<std::byte, seal::kRequestBytes> request;
  std::array<std::byte, seal::kRetryBytes> retry;
  HubHandshake::Agreement agreement;
  const AllocationGuard guard;
  for (int i = 0; i < 20; ++i) {
    client_.begin();
    ASSERT_TRUE(client_.start_request(now_ns_ += 1000));
    ASSERT_EQ(client_.poll(request), Finished::request);
    ASSERT_EQ(hub_.check_request(request, from_, kHubNowNs), Verdict::wants_cookie);
    hub_.write_retry(request, from_, kHubNowNs, retry);
    ASSERT_TRUE(client_.read_retry(retry));
    ASSERT_TRUE(client_.start_request(now_ns_ += 1000));
    ASSERT_EQ(client_.poll(request), Finished::request);
    ASSERT_EQ(hub_.check_request(request, from_, kHubNowNs), Verdict::shows_cookie);
    ASSERT_TRUE(hub_.agree(request, 1));
    ASSERT_TRUE(hub_.poll(agreement));
    ASSERT_TRUE(client_.read_reply(agreement.reply));
    ASSERT_EQ(client_.poll(request), Finished::agreement);
    SealedChannel channel = client_.take_channel();
    ASSERT_TRUE(channel.is_open());
  }
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
