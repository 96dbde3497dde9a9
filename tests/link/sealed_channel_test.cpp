#include "link/sealed_channel.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

using Bytes = std::vector<std::byte>;
using Side = SealedChannel::Side;

constexpr std::uint32_t kConnection = 77;

seal::ChannelKeys keys_of(std::uint8_t session) {
  EXPECT_TRUE(seal::start_crypto());
  seal::ChannelKeys keys;
  keys.client_to_hub.fill(session);
  keys.hub_to_client.fill(static_cast<std::uint8_t>(session + 100));
  return keys;
}

Bytes random_bytes(std::size_t size, std::mt19937_64& random) {
  Bytes bytes(size);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
  return bytes;
}

class SealedChannelTest : public testing::Test {
 protected:
  static Bytes seal(SealedChannel& channel, const Bytes& payload) {
    Bytes sealed(kMaxDatagramBytes);
    sealed.resize(channel.seal(payload, sealed));
    return sealed;
  }

  OpenStatus open(SealedChannel& channel, const Bytes& sealed) {
    // A copy of exact size, so that the address sanitizer sees a read past the end.
    const Bytes exact(sealed.begin(), sealed.end());
    opened_.assign(kMaxDatagramBytes, std::byte{0});
    std::size_t bytes = 0;
    const OpenStatus status = channel.open(exact, opened_, bytes);
    opened_.resize(bytes);
    return status;
  }

  SealedChannel client_{keys_of(1), kConnection, Side::client};
  SealedChannel hub_{keys_of(1), kConnection, Side::hub};
  std::mt19937_64 random_{20261120};
  Bytes payload_ = random_bytes(150, random_);
  Bytes opened_;
};

TEST_F(SealedChannelTest, CarriesEveryLengthBothWays) {
  for (std::size_t size = 1; size <= seal::kMaxPayloadBytes; ++size) {
    const Bytes payload = random_bytes(size, random_);
    const Bytes up = seal(client_, payload);
    ASSERT_EQ(up.size(), size + seal::kOverheadBytes);
    ASSERT_EQ(open(hub_, up), OpenStatus::opened);
    ASSERT_EQ(opened_, payload);
    ASSERT_EQ(open(client_, seal(hub_, payload)), OpenStatus::opened);
    ASSERT_EQ(opened_, payload);
  }
}

TEST_F(SealedChannelTest, RejectsWhatDoesNotFit) {
  Bytes sealed(kMaxDatagramBytes);
  EXPECT_EQ(client_.seal(Bytes(seal::kMaxPayloadBytes + 1), sealed), 0U);
  EXPECT_EQ(client_.seal(payload_, std::span(sealed).first(payload_.size() + seal::kOverheadBytes - 1)), 0U);
  EXPECT_EQ(client_.seal(payload_, std::span(sealed).first(payload_.size() + seal::kOverheadBytes)),
            payload_.size() + seal::kOverheadBytes);
}

TEST_F(SealedChannelTest, ShowsNothingOfWhatItCarries) {
  const Bytes zeros(150);
  const Bytes first = seal(client_, zeros);
  const Bytes second = seal(client_, zeros);
  std::size_t alike = 0;
  for (std::size_t i = seal::kHeaderBytes; i < first.size(); ++i) alike += first[i] == second[i] ? 1 : 0;
  EXPECT_LT(alike, 20U);  // 0.6 bytes are alike by chance
}

TEST_F(SealedChannelTest, NoTruncatedDatagramOpens) {
  const Bytes sealed = seal(client_, payload_);
  for (std::size_t size = 0; size < sealed.size(); ++size) {
    EXPECT_NE(open(hub_, Bytes(sealed.begin(), sealed.begin() + static_cast<std::ptrdiff_t>(size))), OpenStatus::opened) << size;
  }
  EXPECT_EQ(open(hub_, sealed), OpenStatus::opened);
}

TEST_F(SealedChannelTest, NoLengthenedDatagramOpens) {
  Bytes sealed = seal(client_, payload_);
  const Bytes untouched = sealed;
  while (sealed.size() < kMaxDatagramBytes) {
    sealed.push_back(std::byte{0});
    ASSERT_NE(open(hub_, sealed), OpenStatus::opened);
  }
  EXPECT_EQ(open(hub_, untouched), OpenStatus::opened);
}

TEST_F(SealedChannelTest, NoFlippedBitOpens) {
  const Bytes sealed = seal(client_, payload_);
  for (std::size_t bit = 0; bit < 8 * sealed.size(); ++bit) {
    Bytes flipped = sealed;
    flipped[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
    ASSERT_NE(open(hub_, flipped), OpenStatus::opened) << "bit " << bit;
    ASSERT_TRUE(opened_.empty());
  }
  EXPECT_EQ(open(hub_, sealed), OpenStatus::opened) << "forgeries changed the channel";
}

TEST_F(SealedChannelTest, NoRandomBytesOpen) {
  const Bytes sealed = seal(client_, payload_);
  for (int i = 0; i < 50'000; ++i) {
    Bytes junk = random_bytes(random_() % 250, random_);
    // Half of the datagrams have a valid header.
    if (i % 2 == 0 && junk.size() > seal::kHeaderBytes) std::copy_n(sealed.begin(), seal::kHeaderBytes, junk.begin());
    ASSERT_NE(open(hub_, junk), OpenStatus::opened);
  }
}

TEST_F(SealedChannelTest, OpensEachOnce) {
  std::vector<Bytes> sent;
  for (int i = 0; i < 100; ++i) sent.push_back(seal(client_, payload_));
  std::shuffle(sent.begin(), sent.end(), random_);
  for (const Bytes& sealed : sent) EXPECT_EQ(open(hub_, sealed), OpenStatus::opened);
  for (const Bytes& sealed : sent) EXPECT_EQ(open(hub_, sealed), OpenStatus::replayed);
}

TEST_F(SealedChannelTest, DoesNotOpenItsOwnDatagrams) {
  EXPECT_EQ(open(client_, seal(client_, payload_)), OpenStatus::forged);
  EXPECT_EQ(open(hub_, seal(hub_, payload_)), OpenStatus::forged);
}

TEST_F(SealedChannelTest, DoesNotOpenAnotherSession) {
  SealedChannel other(keys_of(2), kConnection, Side::client);
  EXPECT_EQ(open(hub_, seal(other, payload_)), OpenStatus::forged);
  SealedChannel other_connection(keys_of(1), kConnection + 1, Side::client);
  EXPECT_EQ(open(hub_, seal(other_connection, payload_)), OpenStatus::unknown_session);
}

TEST_F(SealedChannelTest, ReportsAnotherVersion) {
  Bytes sealed = seal(client_, payload_);
  for (int version = 0; version < 256; ++version) {
    const auto byte = static_cast<std::byte>(version);
    if (byte == sealed[1]) continue;
    Bytes other = sealed;
    other[1] = byte;
    EXPECT_EQ(open(hub_, other), OpenStatus::wrong_version) << version;
  }
}

TEST_F(SealedChannelTest, AClosedOneSealsAndOpensNothing) {
  SealedChannel closed;
  EXPECT_FALSE(closed.is_open());
  EXPECT_TRUE(seal(closed, payload_).empty());
  EXPECT_EQ(open(closed, seal(client_, payload_)), OpenStatus::unknown_session);
}

TEST_F(SealedChannelTest, MovesWithItsCountersAndLeavesNothingBehind) {
  const Bytes first = seal(client_, payload_);
  SealedChannel moved = std::move(client_);
  EXPECT_TRUE(seal(client_, payload_).empty());  // NOLINT(bugprone-use-after-move): that is what is tested
  const Bytes second = seal(moved, payload_);
  EXPECT_NE(first, second);
  EXPECT_EQ(open(hub_, first), OpenStatus::opened);
  SealedChannel moved_hub = std::move(hub_);
  EXPECT_EQ(open(moved_hub, first), OpenStatus::replayed);
  EXPECT_EQ(open(moved_hub, second), OpenStatus::opened);
}

TEST_F(SealedChannelTest, UsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  std::array<std::byte, kMaxDatagramBytes> sealed;
  std::array<std::byte, kMaxDatagramBytes> opened;
  std::size_t bytes = 0;
  const AllocationGuard guard;
  for (int i = 0; i < 1000; ++i) {
    const std::size_t size = client_.seal(payload_, sealed);
    ASSERT_EQ(hub_.open(std::span(sealed).first(size), opened, bytes), OpenStatus::opened);
    ASSERT_EQ(hub_.open(std::span(sealed).first(size), opened, bytes), OpenStatus::replayed);
    sealed[50] ^= std::byte{1};
    ASSERT_NE(hub_.open(std::span(sealed).first(size), opened, bytes), OpenStatus::opened);
  }
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
