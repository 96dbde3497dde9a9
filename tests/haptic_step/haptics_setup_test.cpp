#include "haptic_step/haptics_setup.h"

#include <gtest/gtest.h>

#include <string>

#include "link/codec.h"
#include "link/endpoint.h"

namespace hapton {
namespace {

TEST(HapticsSetup, NamesSceneMethodAndBuildAndFitsADatagram) {
  const HapticsSetup setup = make_haptics_setup(std::string(2000, 'd') + "/car.toml", {.unit = Unit::mm}, 42, {.name = "sweep"});
  EXPECT_EQ(setup.scene_hash, 42U);
  EXPECT_EQ(from_code(setup.scene_loading), SceneLoading{.unit = Unit::mm});
  EXPECT_TRUE(std::string(setup.scene.data()).ends_with("ddd/car.toml"));
  EXPECT_EQ(std::string(setup.method.data()), "name=sweep");
  EXPECT_NE(std::string(setup.build.data()), "");
  std::array<std::byte, kMaxDatagramBytes> bytes;
  Codec codec;
  Datagram datagram{{1, 2, 3, 4}, setup};
  const std::size_t size = codec.encode(datagram, bytes);
  ASSERT_GT(size, 0U);
  EXPECT_EQ(codec.decode(std::span(bytes).first(size), datagram), DecodeStatus::ok);
}

TEST(HapticsSetup, WhatIsNotPrintableIsReplaced) {
  HapticsSetup::Text text;
  put_text("a\nb\x7f", text);
  EXPECT_STREQ(text.data(), "a?b?");
  put_text("a b \xC3\xA4", text);
  EXPECT_STREQ(text.data(), "a b \xC3\xA4") << "a space, and a letter beyond ASCII";
}

}  // namespace
}  // namespace hapton
