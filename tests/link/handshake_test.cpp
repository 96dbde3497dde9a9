#include "link/handshake.h"

#include <gtest/gtest.h>

#include <optional>
#include <random>
#include <vector>

#include "link/memory_endpoint.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

using Bytes = std::vector<std::byte>;
using Heard = ClientHandshake::Heard;
using Verdict = HubHandshake::Verdict;

constexpr std::int64_t kNow = 100 * HubHandshake::kCookieTimeNs;

LinkKey key_of(std::uint8_t number) {
  EXPECT_TRUE(seal::start_crypto());
  LinkKey::Bytes bytes;
  bytes.fill(number);
  return LinkKey(bytes);
}

Bytes flip(Bytes bytes, std::size_t bit) {
  bytes[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
  return bytes;
}

class HandshakeTest : public testing::Test {
 protected:
  HandshakeTest() { client_.begin(); }

  Bytes request() const {
    Bytes bytes(seal::kRequestBytes);
    EXPECT_EQ(client_.write_request(bytes), bytes.size());
    return bytes;
  }
  Bytes retry(const Bytes& to) const {
    Bytes bytes(seal::kRequestBytes);
    EXPECT_EQ(hub_.write_retry(HubHandshake::nonce_of(to), from_, kNow, bytes), bytes.size());
    return bytes;
  }
  // A request that shows the hub's cookie.
  Bytes good_request() {
    EXPECT_EQ(hear(retry(request())), Heard::cookie);
    return request();
  }
  Bytes answer(const Bytes& to) {
    Bytes bytes(seal::kAnswerBytes);
    hub_channel_ = hub_.agree(HubHandshake::nonce_of(to), 5, bytes);
    return bytes;
  }
  Heard hear(const Bytes& bytes) {
    const SealedKind found = classify_sealed(bytes);
    return found.status == OpenStatus::opened ? client_.read(found.kind, bytes) : Heard::nothing;
  }
  Verdict judge(const Bytes& bytes) const { return hub_.judge(bytes, from_, kNow); }

  bool carries(SealedChannel& from, SealedChannel& to) const {
    Bytes sealed(kMaxDatagramBytes);
    sealed.resize(from.seal(Bytes(20), sealed));
    Bytes opened(kMaxDatagramBytes);
    std::size_t bytes = 0;
    return to.open(sealed, opened, bytes) == OpenStatus::opened;
  }

  ClientHandshake client_{key_of(1)};
  HubHandshake hub_{key_of(1)};
  Address from_ = memory_address(2, 20);
  SealedChannel hub_channel_;
};

TEST_F(HandshakeTest, TwoHoldersOfAKeyAgreeOnASession) {
  const Bytes first = request();
  EXPECT_EQ(judge(first), Verdict::wants_cookie);
  EXPECT_EQ(hear(retry(first)), Heard::cookie);
  const Bytes second = request();
  EXPECT_EQ(judge(second), Verdict::shows_cookie);
  EXPECT_EQ(hear(answer(second)), Heard::agreement);
  EXPECT_FALSE(client_.is_pending());
  SealedChannel channel = client_.take_channel();
  EXPECT_EQ(channel.connection(), 5U);
  EXPECT_TRUE(carries(channel, hub_channel_));
  EXPECT_TRUE(carries(hub_channel_, channel));
}

TEST_F(HandshakeTest, WithoutTheKeyNothingIsHeard) {
  HubHandshake stranger(key_of(2));
  const Bytes shown = good_request();
  EXPECT_EQ(stranger.judge(shown, from_, kNow), Verdict::stranger);
  Bytes forged(seal::kRequestBytes);
  stranger.write_retry(HubHandshake::nonce_of(shown), from_, kNow, forged);
  EXPECT_EQ(hear(forged), Heard::nothing);
  Bytes false_answer(seal::kAnswerBytes);
  stranger.agree(HubHandshake::nonce_of(shown), 5, false_answer);
  EXPECT_EQ(hear(false_answer), Heard::nothing);
  EXPECT_TRUE(client_.is_pending());
}

TEST_F(HandshakeTest, NoFlippedBitPasses) {
  const Bytes shown = good_request();
  for (std::size_t bit = 0; bit < 8 * shown.size(); ++bit) {
    const Bytes flipped = flip(shown, bit);
    if (classify_sealed(flipped).status == OpenStatus::opened) {
      ASSERT_EQ(judge(flipped), Verdict::stranger) << bit;
    }
  }
  const Bytes good_retry = retry(shown);
  for (std::size_t bit = 0; bit < 8 * good_retry.size(); ++bit) ASSERT_EQ(hear(flip(good_retry, bit)), Heard::nothing) << bit;
  const Bytes good_answer = answer(shown);
  for (std::size_t bit = 0; bit < 8 * good_answer.size(); ++bit) ASSERT_EQ(hear(flip(good_answer, bit)), Heard::nothing) << bit;
  EXPECT_EQ(hear(good_answer), Heard::agreement);
}

TEST_F(HandshakeTest, NoOtherLengthOrVersionIsAHandshake) {
  for (const Bytes& message : {request(), retry(request()), answer(request())}) {
    for (std::size_t size = 0; size < 2 * message.size(); ++size) {
      Bytes other = message;
      other.resize(size);
      EXPECT_EQ(classify_sealed(other).status == OpenStatus::opened, size == message.size()) << size;
    }
    Bytes other = message;
    other[1] = std::byte{1};
    EXPECT_EQ(classify_sealed(other).status, OpenStatus::wrong_version);
  }
}

TEST_F(HandshakeTest, ACookieIsGoodForItsAddressOnly) {
  const Bytes shown = good_request();
  EXPECT_EQ(hub_.judge(shown, memory_address(3, 20), kNow), Verdict::wants_cookie);
  EXPECT_EQ(hub_.judge(shown, memory_address(2, 21), kNow), Verdict::wants_cookie);
}

TEST_F(HandshakeTest, ACookieIsGoodForAWhileOnly) {
  const Bytes shown = good_request();
  EXPECT_EQ(hub_.judge(shown, from_, kNow + HubHandshake::kCookieTimeNs), Verdict::shows_cookie);
  EXPECT_EQ(hub_.judge(shown, from_, kNow + 2 * HubHandshake::kCookieTimeNs), Verdict::wants_cookie);
}

TEST_F(HandshakeTest, ACookieIsGoodForItsHubOnly) {
  HubHandshake restarted(key_of(1));
  EXPECT_EQ(restarted.judge(good_request(), from_, kNow), Verdict::wants_cookie);
}

TEST_F(HandshakeTest, ARequestCannotBringASessionBack) {
  const Bytes shown = good_request();
  const Bytes first = answer(shown);
  SealedChannel old_hub = std::move(hub_channel_);
  ASSERT_EQ(hear(first), Heard::agreement);
  SealedChannel channel = client_.take_channel();
  // The same request, heard again: other keys, which the node that sent it never had.
  const Bytes second = answer(shown);
  EXPECT_NE(first, second);
  EXPECT_TRUE(carries(channel, old_hub));
  EXPECT_FALSE(carries(channel, hub_channel_));
  EXPECT_EQ(hear(second), Heard::nothing);
}

TEST_F(HandshakeTest, AnAnswerIsGoodForItsAttemptOnly) {
  const Bytes old_retry = retry(request());
  const Bytes old_answer = answer(request());
  client_.begin();
  EXPECT_EQ(hear(old_retry), Heard::nothing);
  EXPECT_EQ(hear(old_answer), Heard::nothing);
}

TEST_F(HandshakeTest, ARequestReflectedIsNoRetry) {
  Bytes reflected = request();
  EXPECT_EQ(hear(reflected), Heard::nothing);
  reflected[2] = static_cast<std::byte>(seal::Kind::retry);
  EXPECT_EQ(hear(reflected), Heard::nothing);
}

TEST_F(HandshakeTest, NobodyIsSentMoreThanHeSent) {
  EXPECT_LE(retry(request()).size(), request().size());
  EXPECT_LE(answer(request()).size(), request().size());
}

TEST_F(HandshakeTest, EveryAttemptHasANonceOfItsOwn) {
  const Bytes first = request();
  client_.begin();
  EXPECT_NE(HubHandshake::nonce_of(first), HubHandshake::nonce_of(request()));
}

TEST_F(HandshakeTest, UsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  std::array<std::byte, seal::kRequestBytes> request;
  std::array<std::byte, seal::kRequestBytes> retry;
  std::array<std::byte, seal::kAnswerBytes> answer;
  const AllocationGuard guard;
  for (int i = 0; i < 100; ++i) {
    client_.begin();
    client_.write_request(request);
    ASSERT_EQ(hub_.judge(request, from_, kNow), Verdict::wants_cookie);
    hub_.write_retry(HubHandshake::nonce_of(request), from_, kNow, retry);
    ASSERT_EQ(client_.read(seal::Kind::retry, retry), Heard::cookie);
    client_.write_request(request);
    ASSERT_EQ(hub_.judge(request, from_, kNow), Verdict::shows_cookie);
    SealedChannel hub_channel = hub_.agree(HubHandshake::nonce_of(request), 1, answer);
    ASSERT_EQ(client_.read(seal::Kind::answer, answer), Heard::agreement);
    SealedChannel channel = client_.take_channel();
    ASSERT_TRUE(channel.is_open());
  }
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
