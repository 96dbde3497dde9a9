#include "link/message_payload.h"

#include "tests/link/codec_fixture.h"

namespace hapton {
namespace {

// The payload is the end of the encoded datagram: only the header and the length stand before it.
TEST_F(CodecTest, ThePayloadIsTheMessageOfAnyKind) {
  for (std::size_t kind = 0; kind < kKinds; ++kind) {
    const Datagram datagram = random_.draw(kind);
    const Bytes bytes = encode(datagram);
    const std::string_view payload = find_message_payload(bytes);
    const std::string_view all(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    EXPECT_TRUE(all.ends_with(payload)) << kind;
    EXPECT_LE(bytes.size() - payload.size(), 64U) << kind << ": nothing but the header and the length is before it";
  }
}

TEST_F(CodecTest, BytesThatAreNoEnvelopeHaveNoPayload) {
  EXPECT_EQ(find_message_payload({}), "");
  const Bytes bytes = encode(random_.draw(kForceCommand));
  for (std::size_t size = 0; size < bytes.size(); ++size) EXPECT_EQ(find_message_payload(std::span(bytes).first(size)), "") << size;
  for (int n = 0; n < 20'000; ++n) {
    Bytes noise(random_.bits() % 64);
    for (std::byte& byte : noise) byte = static_cast<std::byte>(random_.bits());
    EXPECT_LE(find_message_payload(noise).size(), noise.size());
  }
}

// A field of a later build in front of the message is skipped.
TEST_F(CodecTest, ThePayloadIsOfAKindThatThisBuildKnows) {
  Bytes bytes = encode(random_.draw(kForceCommand));
  const std::string payload(find_message_payload(bytes));
  const Bytes later = {std::byte{0xC2}, std::byte{0x3E}, std::byte{2}, std::byte{'h'}, std::byte{'i'}};  // field 1000
  bytes.insert(bytes.begin() + 2, later.begin(), later.end());
  EXPECT_EQ(find_message_payload(bytes), payload);
}

}  // namespace
}  // namespace hapton
