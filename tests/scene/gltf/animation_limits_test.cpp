// Data that channels or parts share is in a file once, but the reader copies it for each of them: the total must be bounded.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>

#include "scene/gltf/animation.h"
#include "tests/scene/sample_files.h"

namespace hapton {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

// One mesh of one triangle for all nodes, and one sampler of translations for all channels. The tests add the nodes.
struct SharedAnimation {
  explicit SharedAnimation(std::size_t keys) {
    for (const float x : {0.0F, 0.0F, 0.0F, 0.1F, 0.0F, 0.0F, 0.0F, 0.1F, 0.0F}) sample::append(buffer, x);
    for (std::size_t k = 0; k < keys; ++k) sample::append(buffer, 0.01F * static_cast<float>(k));
    for (std::size_t k = 0; k < 3 * keys; ++k) sample::append(buffer, static_cast<float>(k % 2));
    const std::size_t times = 36;
    const std::size_t values = times + 4 * keys;
    json["asset"]["version"] = "2.0";
    json["buffers"] = {{{"byteLength", buffer.size()}}};
    json["bufferViews"] = {{{"buffer", 0}, {"byteLength", times}},
                           {{"buffer", 0}, {"byteOffset", times}, {"byteLength", 4 * keys}},
                           {{"buffer", 0}, {"byteOffset", values}, {"byteLength", 12 * keys}}};
    json["accessors"] = {{{"bufferView", 0}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}},
                         {{"bufferView", 1}, {"componentType", 5126}, {"count", keys}, {"type", "SCALAR"}},
                         {{"bufferView", 2}, {"componentType", 5126}, {"count", keys}, {"type", "VEC3"}}};
    json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", 0}}}}}}}};
    json["animations"] = nlohmann::json::array();
  }

  void add_animation(std::size_t channels) {
    nlohmann::json animation;
    animation["samplers"] = {{{"input", 1}, {"output", 2}}};
    for (std::size_t c = 0; c < channels; ++c) {
      animation["channels"].push_back({{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}});
    }
    json["animations"].push_back(animation);
  }
  RawMesh read() const {
    auto raw = read_glb(sample::glb(json.dump(), buffer), ".");
    EXPECT_TRUE(raw) << raw.error().what;
    return raw ? std::move(*raw) : RawMesh();
  }

  nlohmann::json json;
  std::string buffer;
};

TEST(GltfAnimationLimits, ChannelsMayShareASamplerAFewTimes) {
  for (const std::size_t channels : {50U, 500U}) {
    SharedAnimation shared(20'000);
    shared.json["nodes"] = {{{"mesh", 0}}};
    shared.add_animation(channels);
    const RawMesh raw = shared.read();
    const auto is_noted = Contains(HasSubstr("its animations cannot be read: animations[0].samplers[0]: the channels of all animations"));
    EXPECT_EQ(raw.mesh.triangles.size(), 1U) << "the shape is what matters";
    EXPECT_EQ(raw.animations.size(), channels == 50U ? 1U : 0U);
    if (channels == 50U) {
      EXPECT_THAT(raw.notes, Not(is_noted));
    } else {
      EXPECT_THAT(raw.notes, is_noted);
    }
  }
}

// All parts move with the one animated node above them.
TEST(GltfAnimationLimits, TheKeyframesOfAllPartsAreBounded) {
  for (const std::size_t parts : {50U, 1'000U}) {
    SharedAnimation shared(5'000);
    shared.json["nodes"] = {{{"children", nlohmann::json::array()}}};
    shared.json["scenes"] = {{{"nodes", {0}}}};
    for (std::size_t n = 1; n <= parts; ++n) {
      shared.json["nodes"][0]["children"].push_back(n);
      shared.json["nodes"].push_back({{"mesh", 0}});
    }
    shared.add_animation(1);
    const RawMesh raw = shared.read();
    ASSERT_EQ(raw.animations.size(), parts == 50U ? 1U : 0U);
    if (parts == 50U) {
      EXPECT_EQ(raw.animations[0].motions.size(), parts);
    } else {
      EXPECT_THAT(raw.notes, Contains(HasSubstr("its animations cannot be read: the parts have too many keyframes")));
    }
  }
}

// A chain of nodes with a part at each, and animations without channels.
TEST(GltfAnimationLimits, TheNodesAboveAllPartsAreBounded) {
  for (const std::size_t animations : {1U, 5U}) {
    SharedAnimation shared(2);
    constexpr std::size_t kDepth = 3000;
    for (std::size_t n = 0; n + 1 < kDepth; ++n) shared.json["nodes"].push_back({{"mesh", 0}, {"children", {n + 1}}});
    shared.json["nodes"].push_back({{"mesh", 0}});
    shared.json["scenes"] = {{{"nodes", {0}}}};
    for (std::size_t a = 0; a < animations; ++a) shared.add_animation(0);
    const RawMesh raw = shared.read();
    EXPECT_EQ(raw.parts.size(), kDepth);
    EXPECT_EQ(raw.animations.size() == animations, animations == 1U);
    if (animations > 1U) {
      EXPECT_THAT(raw.notes, Contains(HasSubstr("too many nodes above them")));
    }
  }
}

}  // namespace
}  // namespace hapton
