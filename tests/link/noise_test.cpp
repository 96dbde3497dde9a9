#include "link/noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include "link/key_schedule.h"

namespace hapton::noise {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes from_hex(std::string_view text) {
  const auto digit = [](char c) { return static_cast<std::uint8_t>(c <= '9' ? c - '0' : c - 'a' + 10); };
  Bytes bytes;
  for (std::size_t i = 0; i + 1 < text.size(); i += 2) bytes.push_back(static_cast<std::uint8_t>(digit(text[i]) << 4 | digit(text[i + 1])));
  return bytes;
}

Key key_from_hex(std::string_view text) {
  const Bytes bytes = from_hex(text);
  Key key = {};
  EXPECT_EQ(bytes.size(), key.size());
  std::copy(bytes.begin(), bytes.end(), key.begin());
  return key;
}

// The vector named Noise_NNpsk0_25519_AESGCM_SHA256 of the Cacophony library (John Galt), public domain, as the Noise wiki lists it and the
// snow library ships it (tests/vectors/cacophony.txt).
constexpr std::string_view kPrologue = "4a6f686e2047616c74";
constexpr std::string_view kPsk = "54686973206973206d7920417573747269616e20706572737065637469766521";
constexpr std::string_view kInitiatorSecret = "893e28b9dc6ca8d611ab664754b8ceb7bac5117349a4439a6b0569da977c464a";
constexpr std::string_view kResponderSecret = "bbdb4cdbd309f1a1f2e1456967fe288cadd6f712d65dc7b7793d5e63da6b375b";
constexpr std::string_view kHandshakeHash = "9f3b1f9afd7767767b5b9d1069844a6154fdbdcc36dfb3e31c0fffc5c973d530";
struct Message {
  std::string_view payload;
  std::string_view sealed;
};
constexpr std::array<Message, 6> kMessages = {
    {{"4c756477696720766f6e204d69736573",
      "ca35def5ae56cec33dc2036731ab14896bc4c75dbb07a61f879f8e3afa4c79447c37a89fc17813788d30df2d59501d6066f5f8aecc3406bbd9829f2d24a531b1"},
     {"4d757272617920526f746862617264",
      "95ebc60d2b1fa672c1f46a8aa265ef51bfe38e7ccb39ec5be34069f1448088432f29d79368ef9de4e1ae7a362fb05bf0ad668e026bf5714554497b3a720461"},
     {"462e20412e20486179656b", "7c01e898a6201f36aecee532e29cd0b7f8ffa29d3366ad0dce39a6"},
     {"4361726c204d656e676572", "a9ff535aace3db6a1da1a7fb00fe2de2622bb373abad9fb42c00e0"},
     {"4a65616e2d426170746973746520536179", "6cfc49a3e65472edc2d0152abe5ce950170a8a47c959f30bd48b5f0aacf29adbfd"},
     {"457567656e2042f6686d20766f6e2042617765726b", "9bc86e6d974ed21ba04604a94aa68de21677eb409ead070c0cd569b069ee19ba142aa4c1a9"}}};

class NoiseTest : public testing::Test {
 protected:
  NoiseTest() {
    EXPECT_TRUE(seal::start_crypto());
    initiator_.begin(key_from_hex(kPsk), from_hex(kPrologue), key_from_hex(kInitiatorSecret));
    responder_.begin(key_from_hex(kPsk), from_hex(kPrologue), key_from_hex(kResponderSecret));
  }

  Bytes first(const Bytes& payload = {}) {
    Bytes message(payload.size() + kMessageOverhead);
    initiator_.write_first(payload, message.data());
    return message;
  }
  Bytes second(const Bytes& payload = {}) {
    Bytes message(payload.size() + kMessageOverhead);
    EXPECT_TRUE(responder_.write_second(payload, message.data()));
    return message;
  }

  HandshakeState initiator_;
  HandshakeState responder_;
};

TEST_F(NoiseTest, MakesThePublishedMessages) {
  const Bytes one = first(from_hex(kMessages[0].payload));
  EXPECT_EQ(one, from_hex(kMessages[0].sealed));
  Bytes arrived(one.size() - kMessageOverhead);
  ASSERT_TRUE(responder_.read_first(one, arrived.data()));
  EXPECT_EQ(arrived, from_hex(kMessages[0].payload));

  const Bytes two = second(from_hex(kMessages[1].payload));
  EXPECT_EQ(two, from_hex(kMessages[1].sealed));
  arrived.resize(two.size() - kMessageOverhead);
  ASSERT_TRUE(initiator_.read_second(two, arrived.data()));
  EXPECT_EQ(arrived, from_hex(kMessages[1].payload));

  const Bytes hash(initiator_.handshake_hash().begin(), initiator_.handshake_hash().end());
  EXPECT_EQ(hash, from_hex(kHandshakeHash));
  EXPECT_EQ(initiator_.handshake_hash(), responder_.handshake_hash());
}

TEST_F(NoiseTest, MakesThePublishedTransportMessages) {
  Bytes none(64);
  ASSERT_TRUE(responder_.read_first(first(from_hex(kMessages[0].payload)), none.data()));
  ASSERT_TRUE(initiator_.read_second(second(from_hex(kMessages[1].payload)), none.data()));
  const TransportKeys keys = initiator_.split();
  EXPECT_EQ(keys.initiator_to_responder, responder_.split().initiator_to_responder);
  EXPECT_EQ(keys.responder_to_initiator, responder_.split().responder_to_initiator);
  for (std::size_t n = 2; n < kMessages.size(); ++n) {
    const Bytes payload = from_hex(kMessages[n].payload);
    const Key& key = n % 2 == 0 ? keys.initiator_to_responder : keys.responder_to_initiator;
    Bytes sealed(payload.size() + kTagBytes);
    encrypt(key, n / 2 - 1, {}, payload, sealed.data());
    EXPECT_EQ(sealed, from_hex(kMessages[n].sealed)) << n;
    Bytes opened(payload.size());
    EXPECT_TRUE(decrypt(key, n / 2 - 1, {}, sealed, opened.data()));
    EXPECT_EQ(opened, payload);
  }
}

TEST_F(NoiseTest, NoFlippedBitOfTheFirstMessagePasses) {
  const Bytes message = first();
  std::uint8_t none = 0;
  for (std::size_t bit = 0; bit < 8 * message.size(); ++bit) {
    Bytes flipped = message;
    flipped[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    HandshakeState responder = responder_;
    ASSERT_FALSE(responder.read_first(flipped, &none)) << bit;
  }
  EXPECT_TRUE(responder_.read_first(message, &none));
}

TEST_F(NoiseTest, NoFlippedBitOfTheSecondMessagePasses) {
  std::uint8_t none = 0;
  ASSERT_TRUE(responder_.read_first(first(), &none));
  const Bytes message = second();
  for (std::size_t bit = 0; bit < 8 * message.size(); ++bit) {
    Bytes flipped = message;
    flipped[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    HandshakeState initiator = initiator_;
    ASSERT_FALSE(initiator.read_second(flipped, &none)) << bit;
  }
  EXPECT_TRUE(initiator_.read_second(message, &none));
}

TEST_F(NoiseTest, AnotherPskOrPrologueOpensNothing) {
  const Bytes message = first();
  std::uint8_t none = 0;
  HandshakeState other;
  Key psk = key_from_hex(kPsk);
  psk[31] ^= 1;
  other.begin(psk, from_hex(kPrologue), key_from_hex(kResponderSecret));
  EXPECT_FALSE(other.read_first(message, &none));
  other.begin(key_from_hex(kPsk), from_hex("00"), key_from_hex(kResponderSecret));
  EXPECT_FALSE(other.read_first(message, &none));
}

// A public key of small order fixes the shared secret for any other key: the key exchange would then add nothing.
TEST_F(NoiseTest, APublicKeyOfSmallOrderEndsTheHandshake) {
  for (const std::uint8_t value : {std::uint8_t{0}, std::uint8_t{1}}) {
    first();
    Bytes message(kMessageOverhead);
    message[0] = value;
    HandshakeState initiator = initiator_;
    std::uint8_t none = 0;
    EXPECT_FALSE(initiator.read_second(message, &none));
    initiator_.begin(key_from_hex(kPsk), from_hex(kPrologue), key_from_hex(kInitiatorSecret));
  }
}

// Forward secrecy: the attacker has the psk, the prologue and every byte that was sent, but neither of the ephemeral secrets.
TEST_F(NoiseTest, AnAttackerWithThePskCannotOpenTheSecondMessageLater) {
  std::uint8_t none = 0;
  const Bytes one = first();
  ASSERT_TRUE(responder_.read_first(one, &none));
  const Bytes payload = from_hex("0102030405060708");
  const Bytes two = second(payload);
  // Reads the first message as the hub did, which restores all of the state but the secret, and then the second one.
  const auto opens = [&](const Key& guessed_secret) {
    HandshakeState later;
    later.begin(key_from_hex(kPsk), from_hex(kPrologue), guessed_secret);
    Bytes arrived(payload.size());
    return later.read_first(one, &none) && later.read_second(two, arrived.data());
  };
  EXPECT_TRUE(opens(key_from_hex(kInitiatorSecret)));
  Key guess = key_from_hex(kInitiatorSecret);
  guess[4] ^= 16;
  EXPECT_FALSE(opens(guess));
  std::copy(one.begin(), one.begin() + kKeyBytes, guess.begin());
  EXPECT_FALSE(opens(guess));
  EXPECT_FALSE(opens(Key{}));
}

TEST_F(NoiseTest, TheOwnSecretIsGoneOnceItHasBeenUsed) {
  const Key secret = key_from_hex(kResponderSecret);
  const auto holds = [&](const HandshakeState& state) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(&state);
    return std::search(bytes, bytes + sizeof state, secret.begin(), secret.end()) != bytes + sizeof state;
  };
  std::uint8_t none = 0;
  ASSERT_TRUE(responder_.read_first(first(), &none));
  EXPECT_TRUE(holds(responder_));
  second();
  EXPECT_FALSE(holds(responder_));
}

}  // namespace
}  // namespace hapton::noise
