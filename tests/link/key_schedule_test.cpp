#include "link/key_schedule.h"

#include <gtest/gtest.h>

#include <string>

#include <fmt/core.h>

#include "link/noise.h"
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

  LinkKey master_{counting_from<LinkKey::Bytes>(1)};
  RoleKey key_{master_, KeyRole::haptics};
};

// The expected values come from an independent implementation (tests/link/known_answers.py). A change of the schedule, of the order of the
// fields or of the protocol version changes them: this is a new wire format, and needs a new version.
TEST_F(KeyScheduleTest, GivesTheKnownRoleKeys) {
  const auto role_key = [&](KeyRole role) { return hex(derive_role_key(master_, role)); };
  EXPECT_EQ(role_key(KeyRole::haptics), "b4ce355e13f44bad8ce76dc2ef7e9fdc7796efe368978f0a14488e66fc8429e5");
  EXPECT_EQ(role_key(KeyRole::vision), "3066c49c04fa4fa0d2c1aa9983719b6671b38598adc7aa8868d8ecaa634b2c50");
  EXPECT_EQ(role_key(KeyRole::tool), "d10146fe6a551618f3952b059b2bc5049b888c4d14b2b5df6c4c004edd9a0169");
  EXPECT_EQ(role_key(KeyRole::operator_role), "c5e68b6d3b87e478ec7e4cc6aa3f37872c1f57e5d43cbbbfb80b039f59201e77");
  EXPECT_EQ(hex(derive_handshake_key(key_)), "5864f1468268820568c38cb5880588c18e319f3de4de798435e9c2670047b38d");
  EXPECT_EQ(hex(derive_psk(key_)), "2a2149c18cef641e52d4a6ec28142f133b3348edd518740ab6070ab10aee7f34");
}

TEST_F(KeyScheduleTest, AgreesOnTheKnownSessionAndSealsToTheKnownDatagram) {
  std::array<std::uint8_t, kPrologueBytes> prologue = {};
  write_lead(Kind::request, prologue.data());
  prologue[kRoleAt] = static_cast<std::uint8_t>(KeyRole::haptics);
  store(std::uint64_t{0x1122334455667788}, prologue.data() + kHostAt);
  store(std::int64_t{1234567890}, prologue.data() + kRequestTimestampAt);
  EXPECT_EQ(hex(compute_tag(derive_handshake_key(key_), prologue)), "37bd889b3354ca336fb4686b20231ae9");

  noise::HandshakeState node;
  noise::HandshakeState hub;
  node.begin(derive_psk(key_), prologue, counting_from<noise::Key>(100));
  hub.begin(derive_psk(key_), prologue, counting_from<noise::Key>(200));
  std::array<std::uint8_t, kFirstBytes> first;
  node.write_first({}, first.data());
  EXPECT_EQ(hex(first), "7d9c24316539825c1896e57f28197746793ce60cbee3ad47da9d07b85fa55e2a60224a8b73505c238a8ea9740c791bf5");
  std::array<std::uint8_t, 4> connection;
  ASSERT_TRUE(hub.read_first(first, connection.data()));
  store(std::uint32_t{0x01020304}, connection.data());
  std::array<std::uint8_t, kSecondBytes> second;
  ASSERT_TRUE(hub.write_second(connection, second.data()));
  EXPECT_EQ(hex(second), "4d5bab89b0733d9d8dcecf04f321c90b761b7765a6bdb2bddbfad3e7abdf1f6655f842cf1a3c8cc6a1b75fe06b832bf049fcab02");
  ASSERT_TRUE(node.read_second(second, connection.data()));

  ChannelKeys keys;
  keys.client_to_hub = node.split().initiator_to_responder;
  keys.hub_to_client = hub.split().responder_to_initiator;
  EXPECT_EQ(hex(keys.client_to_hub), "464447173a5c77ecf57305daf11b7a9ea67d0c3f618671d236ba07fd43245728");
  EXPECT_EQ(hex(keys.hub_to_client), "0a4d43867baed6b3957ee6a956020fc17f52c6db29536dc4eac4dd34d3ceab28");
  SealedChannel channel(keys, load<std::uint32_t>(connection.data()), SealedChannel::Side::client);
  constexpr std::string_view kText = "known answer, of two blocks";  // two blocks of AES, the second one incomplete
  std::array<std::byte, 64> sealed;
  const std::size_t bytes = channel.seal(std::as_bytes(std::span(kText)), sealed);
  EXPECT_EQ(hex(std::span(sealed).first(bytes)),
            "0803040004030201010000000000000054a20c58a2f32dc32d23a0e5ff2da22f62909ce726a2b7159fb4dd8fa1ef0597a17af8bc80c3d175ab9c47");
}

TEST_F(KeyScheduleTest, EveryRoleAndEveryMasterHasKeysOfItsOwn) {
  std::vector<Secret> secrets;
  for (const LinkKey& master : {master_, LinkKey(counting_from<LinkKey::Bytes>(2))}) {
    secrets.push_back(master.bytes());
    for (std::uint8_t role = kFirstKeyRole; role <= kLastKeyRole; ++role) {
      const RoleKey key(master, static_cast<KeyRole>(role));
      EXPECT_EQ(static_cast<std::uint8_t>(key.role()), role);
      for (const Secret& secret : {key.bytes(), derive_handshake_key(key), derive_psk(key)}) secrets.push_back(secret);
    }
  }
  for (std::size_t i = 0; i < secrets.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(secrets[i], secrets[j]) << i << " " << j;
  }
}

TEST_F(KeyScheduleTest, ATagHoldsForItsTextAndKeyOnly) {
  const Secret key = derive_handshake_key(key_);
  const auto text = counting_from<Secret>(100);
  const Tag tag = compute_tag(key, text);
  EXPECT_TRUE(is_tag(tag, compute_tag(key, text).data()));
  EXPECT_FALSE(is_tag(tag, compute_tag(key, counting_from<Secret>(101)).data()));
  EXPECT_FALSE(is_tag(tag, compute_tag(derive_handshake_key(RoleKey(master_, KeyRole::vision)), text).data()));
  for (std::size_t bit = 0; bit < 8 * tag.size(); ++bit) {
    Tag flipped = tag;
    flipped[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    EXPECT_FALSE(is_tag(tag, flipped.data())) << bit;
  }
}

}  // namespace
}  // namespace hapton::seal
