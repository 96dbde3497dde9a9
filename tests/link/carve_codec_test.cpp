// Carves that include undos: what a datagram may contain.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/link/codec_fixture.h"

namespace hapton {
namespace {

struct CarveCodecTest : CodecTest {
  Carves good{.source = 1, .newest = 9, .first = 7, .count = 3};

  CarveCodecTest() {
    good.carves[0] = good.carves[2] = {.object = 3, .to_m = {0.1F, 0.2F, 0.4F}, .radius_m = 0.01F};
    good.carves[0].begins = true;
    good.carves[1] = {.object = -1, .undone_first = 2, .undone_last = 7};
  }
  template <class Change>
  DecodeStatus with(Change&& change) {
    Carves changed = good;
    change(changed);
    return round_trip(changed);
  }
};

TEST_F(CarveCodecTest, AnUndoIsBetweenCarves) {
  ASSERT_EQ(round_trip(good), DecodeStatus::ok);
  expect_equal(std::get<Carves>(decoded_.message), good);
  EXPECT_TRUE(std::get<Carves>(decoded_.message).carves[1].is_undo());
}

// Nothing that the previous datagram left in a slot remains.
TEST_F(CarveCodecTest, ACarveAfterAnUndoIsACarve) {
  ASSERT_EQ(round_trip(good), DecodeStatus::ok);
  good.carves[1] = good.carves[2];
  ASSERT_EQ(round_trip(good), DecodeStatus::ok);
  EXPECT_FALSE(std::get<Carves>(decoded_.message).carves[1].is_undo());
}

TEST_F(CarveCodecTest, AnUndoNamesCarvesBeforeIt) {
  EXPECT_EQ(with([](Carves& m) { m.carves[1].undone_last = 8; }), DecodeStatus::bad_value) << "itself";
  EXPECT_EQ(with([](Carves& m) { m.carves[1].undone_last = 0xFFFFFFFF; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](Carves& m) { m.carves[1].undone_last = 1; }), DecodeStatus::bad_value) << "the last is before the first";
  EXPECT_EQ(with([](Carves& m) { m.carves[1].undone_first = 7; }), DecodeStatus::ok) << "one carve";
}

// A carve between the largest number and the next float is short.
TEST_F(CarveCodecTest, BothEndsAreWithinTheLargestNumber) {
  const auto large = static_cast<float>(kMaxWireMagnitude);
  const float larger = std::nextafter(large, 2.0F * large);
  const auto with_ends = [&](float from, float to) {
    return with([&](Carves& m) { m.carves[0].from_m = {0.0F, from, 0.0F}, m.carves[0].to_m = {0.0F, to, 0.0F}; });
  };
  EXPECT_EQ(with_ends(large, large), DecodeStatus::ok);
  EXPECT_EQ(with_ends(larger, large), DecodeStatus::bad_value);
  EXPECT_EQ(with_ends(large, larger), DecodeStatus::bad_value);
  EXPECT_EQ(with_ends(-larger, -large), DecodeStatus::bad_value);
  EXPECT_EQ(with_ends(-large, std::nanf("")), DecodeStatus::bad_value);
}

TEST_F(CarveCodecTest, ARequestNamesAProcessAndACarve) {
  EXPECT_EQ(round_trip(CarveUndo{.source = 1, .serial = 1}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(CarveUndo{.source = 1}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(CarveUndo{.serial = 1}), DecodeStatus::bad_value);
}

// Bytes written by hand. A mask may have bits only for entries that exist, and there must be as many numbers as the masks say.
TEST_F(CarveCodecTest, MasksAndNumbersMatch) {
  const auto decode_masks = [&](std::uint32_t begins, std::uint32_t undoes, std::size_t carves, std::size_t undone) {
    std::string inner("\x0D\x01\x00\x00\x00\x15\x40\x00\x00\x00\x1D\x05\x00\x00\x00", 15);  // source 1, newest 64, first 5
    const auto fixed = [](std::uint32_t value) {
      std::string bytes;
      for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(value >> shift & 0xFF);
      return bytes;
    };
    inner += std::string("\x22\x02\x00\x00", 4);  // two objects
    inner += '\x2A';
    inner += static_cast<char>(28 * carves);
    for (std::size_t n = 0; n < 7 * carves; ++n) inner += fixed(0x3F000000);  // 0.5
    inner += '\x35' + fixed(begins) + '\x3D' + fixed(undoes);
    inner += '\x42';
    inner += static_cast<char>(4 * undone);
    for (std::size_t n = 0; n < undone; ++n) inner += fixed(2);
    std::string whole("\x08\x03\xE2\x02", 4);  // version 3, field 44
    whole += static_cast<char>(inner.size());
    whole += inner;
    const auto* bytes = reinterpret_cast<const std::byte*>(whole.data());
    return decode(Bytes(bytes, bytes + whole.size()));
  };
  EXPECT_EQ(decode_masks(1, 2, 1, 2), DecodeStatus::ok);
  EXPECT_EQ(decode_masks(2, 1, 1, 2), DecodeStatus::ok);
  EXPECT_EQ(decode_masks(2, 2, 1, 2), DecodeStatus::bad_value) << "an undo begins no press";
  EXPECT_EQ(decode_masks(4, 2, 1, 2), DecodeStatus::bad_value) << "there is no third entry";
  EXPECT_EQ(decode_masks(1, 4, 1, 2), DecodeStatus::bad_value);
  EXPECT_EQ(decode_masks(1, 0x80000002, 1, 2), DecodeStatus::bad_value);
  EXPECT_EQ(decode_masks(1, 2, 2, 2), DecodeStatus::bad_value) << "numbers of a carve too many";
  EXPECT_EQ(decode_masks(1, 2, 1, 1), DecodeStatus::bad_value);
  EXPECT_EQ(decode_masks(0, 3, 0, 4), DecodeStatus::ok) << "undos only";
  EXPECT_EQ(decode_masks(0, 0, 1, 0), DecodeStatus::bad_value);
}

}  // namespace
}  // namespace hapton
