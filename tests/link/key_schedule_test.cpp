#include "link/key_schedule.h"

#include <gtest/gtest.h>

#include <string>

#include <fmt/core.h>

#include "link/sealed_channel.h"

namespace hapton::seal {
namespace {

template <class Bytes>
std::string hex(const Bytes& bytes) {
  std::string text;
  for (const auto byte : bytes) text += fmt::format("{:02x}", static_cast<unsigned>(byte));
  return text;
}

template <class Bytes>
Bytes counting_from(std::uint8_t first) {
  Bytes bytes;
  for (auto& byte : bytes) byte = first++;
  return bytes;
}

class KeyScheduleTest : public testing::Test {
 protected:
  KeyScheduleTest() { EXPECT_TRUE(start_crypto()); }

  LinkKey key_{counting_from<LinkKey::Bytes>(1)};
  Nonce client_ = counting_from<Nonce>(100);
  Nonce hub_ = counting_from<Nonce>(200);
};

// The answers come from an implementation of its own (Python's hashlib.blake2b, tests/link/known_answers.py): a change of the schedule, of
// the order of the fields or of the protocol version is a new wire format, and must come with a new version.
TEST_F(KeyScheduleTest, GivesTheKnownKeys) {
  EXPECT_EQ(hex(derive_handshake_key(key_)), "66052bbe1931a72d3783a72af4090165d86863c5682a596a35ebded79f450725");
  const SessionKeys keys = derive_session_keys(key_, client_, hub_);
  EXPECT_EQ(hex(keys.client_to_hub), "0893ba3b6211acd75f08b28bc0c427383a4ac9bef982bf5885bda408af214064");
  EXPECT_EQ(hex(keys.hub_to_client), "ac3c6a1156891ab6cdb40ce68009e60694df629ee4a76844ba73488ab497a656");
  EXPECT_EQ(hex(keys.answer), "d956c38867dd141a5b0627f5a2a2d87dbb8f39cd728a5691e9b23054c559c580");
  EXPECT_EQ(hex(compute_tag(keys.answer, client_)), "aa938fa4e08957ff24a0688e5bfaccd6");
}

TEST_F(KeyScheduleTest, SealsToTheKnownDatagram) {
  SealedChannel channel(derive_session_keys(key_, client_, hub_), 0x01020304, SealedChannel::Side::client);
  constexpr std::string_view kText = "known answer, of two blocks";
  std::array<std::byte, 64> sealed;
  const std::size_t bytes = channel.seal(std::as_bytes(std::span(kText)), sealed);
  EXPECT_EQ(hex(std::span(sealed).first(bytes)),
            "080204000403020101000000000000000999b2a51638b5a05cac30f4b22b1e1e8fb6670e8652d5b5e3efba57fe3b12460f007c18a7ba552a0e9f95");
}

TEST_F(KeyScheduleTest, EveryInputChangesEveryKey) {
  const SessionKeys keys = derive_session_keys(key_, client_, hub_);
  EXPECT_NE(keys.client_to_hub, keys.hub_to_client);
  EXPECT_NE(keys.client_to_hub, keys.answer);
  EXPECT_NE(keys.hub_to_client, keys.answer);
  const auto expect_others = [&](const SessionKeys& others) {
    EXPECT_NE(others.client_to_hub, keys.client_to_hub);
    EXPECT_NE(others.hub_to_client, keys.hub_to_client);
    EXPECT_NE(others.answer, keys.answer);
  };
  expect_others(derive_session_keys(LinkKey(counting_from<LinkKey::Bytes>(2)), client_, hub_));
  expect_others(derive_session_keys(key_, hub_, client_));
  Nonce other = client_;
  other.back() ^= 1;
  expect_others(derive_session_keys(key_, other, hub_));
  expect_others(derive_session_keys(key_, client_, other));
  EXPECT_NE(derive_handshake_key(key_), keys.answer);
}

TEST_F(KeyScheduleTest, ATagHoldsForItsTextAndKeyOnly) {
  const Secret key = derive_handshake_key(key_);
  const Tag tag = compute_tag(key, client_);
  EXPECT_TRUE(is_tag(tag, compute_tag(key, client_).data()));
  EXPECT_FALSE(is_tag(tag, compute_tag(key, hub_).data()));
  EXPECT_FALSE(is_tag(tag, compute_tag(derive_handshake_key(LinkKey(counting_from<LinkKey::Bytes>(9))), client_).data()));
  for (std::size_t bit = 0; bit < 8 * tag.size(); ++bit) {
    Tag flipped = tag;
    flipped[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    EXPECT_FALSE(is_tag(tag, flipped.data())) << bit;
  }
}

}  // namespace
}  // namespace hapton::seal
