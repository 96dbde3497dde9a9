// What a datagram with a part of a scene (a patch) may contain.
#include <gtest/gtest.h>

#include <limits>

#include "tests/link/codec_fixture.h"

namespace hapton {
namespace {

constexpr double kPatchNan = std::numeric_limits<double>::quiet_NaN();

struct PatchCodecTest : CodecTest {};

TEST_F(PatchCodecTest, RejectsBadBodies) {
  PatchBody good{.epoch = 1, .serial = 2, .body = 3, .motion = PatchBody::Motion::keyframes, .lowest = {0, 0, 0}, .highest = {1, 2, 3}};
  good.all_keys = 5;
  good.first_key = 3;
  good.key_count = 2;
  good.keys[0].time_s = 0.5;
  good.keys[1].time_s = 0.75;
  EXPECT_EQ(round_trip(good), DecodeStatus::ok);
  const auto with = [&](auto&& change) {
    PatchBody bad = good;
    change(bad);
    return round_trip(bad);
  };
  EXPECT_EQ(with([](PatchBody& m) { m.body = PatchBody::kMaxBodies; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](PatchBody& m) { m.motion = static_cast<PatchBody::Motion>(3); }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](PatchBody& m) { m.motion = PatchBody::Motion::still; }), DecodeStatus::bad_value) << "keyframes of what stands still";
  EXPECT_EQ(with([](PatchBody& m) { m.highest[1] = 1U << kPatchGridBits; }), DecodeStatus::bad_value) << "past the grid";
  EXPECT_EQ(with([](PatchBody& m) { m.lowest[1] = 7; }), DecodeStatus::bad_value) << "a box inside out";
  EXPECT_EQ(with([](PatchBody& m) { m.pivot_m.x() = kPatchNan; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](PatchBody& m) { m.radius_m = -1.0; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](PatchBody& m) { m.object = -1; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](PatchBody& m) { m.all_keys = 4; }), DecodeStatus::bad_value) << "more than there are";
  EXPECT_EQ(with([](PatchBody& m) { m.all_keys = PatchBody::kMaxAllKeys + 1; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](PatchBody& m) { m.first_key = ~0U; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](PatchBody& m) { m.key_count = 0; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](PatchBody& m) { m.keys[1].time_s = 0.5; }), DecodeStatus::bad_value) << "not after the one before";
  EXPECT_EQ(with([](PatchBody& m) { m.keys[0].time_s = -0.1; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](PatchBody& m) { m.keys[1].p_S.z() = kPatchNan; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](PatchBody& m) { m.keys[1].turn = Quat(0.5, 0, 0, 0); }), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(PatchBegin{.step_m = 1e-8, .body_count = PatchBody::kMaxBodies + 1}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(PatchCell{.body = PatchBody::kMaxBodies}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(PatchMaterial{.friction_static = 0.1, .friction_dynamic = 0.2}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(PatchMaterial{.stiffness_n_per_m = -1.0}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(PatchMaterial{.object = 0x7FFFFFFF}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(PatchMaterial{.object = 0x80000000}), DecodeStatus::bad_value) << "no index of an object";
  EXPECT_EQ(round_trip(PatchTile{.object = 0x7FFFFFFF, .vertex_count = 1, .triangle_count = 1}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(PatchTile{.object = 0x80000000, .vertex_count = 1, .triangle_count = 1}), DecodeStatus::bad_value);
}

TEST_F(PatchCodecTest, RejectsBadDeformations) {
  PatchDeformation good{.epoch = 1, .serial = 2, .body = 3, .tile_count = 4, .displaced_count = 8, .target_count = 2, .all_keys = 5};
  good.first_key = 3;
  good.key_count = 2;
  good.keys = {0.5, 1.0, -1.0, 0.75, 0.0, 0.0};
  EXPECT_EQ(round_trip(good), DecodeStatus::ok);
  const auto with = [&](auto&& change) {
    PatchDeformation bad = good;
    change(bad);
    return round_trip(bad);
  };
  EXPECT_EQ(with([](PatchDeformation& m) { m.body = PatchBody::kMaxBodies; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](PatchDeformation& m) { m.tile_count = 0; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](PatchDeformation& m) { m.target_count = 0; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](PatchDeformation& m) { m.target_count = PatchDeformation::kMaxTargets + 1; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](PatchDeformation& m) { m.all_keys = 4; }), DecodeStatus::bad_value) << "more than there are";
  EXPECT_EQ(with([](PatchDeformation& m) { m.all_keys = PatchDeformation::kMaxAllKeys + 1; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](PatchDeformation& m) { m.first_key = ~0U; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](PatchDeformation& m) { m.key_count = 0; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](PatchDeformation& m) { m.keys[0] = -0.1; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](PatchDeformation& m) { m.keys[3] = 0.5; }), DecodeStatus::bad_value) << "not after the one before";
  EXPECT_EQ(with([](PatchDeformation& m) { m.keys[4] = kPatchNan; }), DecodeStatus::bad_value);

  PatchStream stream{.epoch = 1, .serial = 2, .body = 3, .first_tile = 4, .tile_count = 2, .total = 30, .reach_m = 0.01};
  stream.tile = 5;
  stream.vertex_count = 2;
  stream.vertices = {29, 0};
  EXPECT_EQ(round_trip(stream), DecodeStatus::ok);
  const auto with_stream = [&](auto&& change) {
    PatchStream bad = stream;
    change(bad);
    return round_trip(bad);
  };
  EXPECT_EQ(with_stream([](PatchStream& m) { m.body = PatchBody::kMaxBodies; }), DecodeStatus::bad_value);
  EXPECT_EQ(with_stream([](PatchStream& m) { m.tile = 3; }), DecodeStatus::bad_value) << "none of its tiles";
  EXPECT_EQ(with_stream([](PatchStream& m) { m.tile = 6; }), DecodeStatus::bad_value) << "none of its tiles";
  EXPECT_EQ(with_stream([](PatchStream& m) { m.object = -1; }), DecodeStatus::bad_value);
  EXPECT_EQ(with_stream([](PatchStream& m) { m.total = 0; }), DecodeStatus::bad_value);
  EXPECT_EQ(with_stream([](PatchStream& m) { m.total = ShapePart::kMaxVertices + 1; }), DecodeStatus::bad_value);
  EXPECT_EQ(with_stream([](PatchStream& m) { m.reach_m = 0.0; }), DecodeStatus::bad_value);
  EXPECT_EQ(with_stream([](PatchStream& m) { m.reach_m = kPatchNan; }), DecodeStatus::bad_value);
  EXPECT_EQ(with_stream([](PatchStream& m) { m.to_scene(2, 2) = kPatchNan; }), DecodeStatus::bad_value);
  EXPECT_EQ(with_stream([](PatchStream& m) { m.vertex_count = 0; }), DecodeStatus::bad_value);
  EXPECT_EQ(with_stream([](PatchStream& m) { m.vertices[1] = 30; }), DecodeStatus::bad_value) << "not of the mesh";

  PatchEffects effects{.epoch = 1, .serial = 2, .part = 3, .byte_count = 4};
  EXPECT_EQ(round_trip(effects), DecodeStatus::ok);
  effects.part = PatchEffects::kMaxAllBytes / PatchEffects::kMaxBytes + 1;
  EXPECT_EQ(round_trip(effects), DecodeStatus::bad_value) << "no scene has so many parts";
  EXPECT_EQ(round_trip(PatchEffects{.epoch = 1, .serial = 2}), DecodeStatus::bad_value) << "no bytes";
  EXPECT_EQ(round_trip(PatchBegin{.epoch = 1, .step_m = 1e-8, .effect_bytes = PatchEffects::kMaxAllBytes + 1}), DecodeStatus::bad_value);

  PatchDisplacements displacements{.epoch = 1, .serial = 2, .tile = 3, .target = 1, .vertex_count = 2};
  EXPECT_EQ(round_trip(displacements), DecodeStatus::ok);
  displacements.target = PatchDeformation::kMaxTargets;
  EXPECT_EQ(round_trip(displacements), DecodeStatus::bad_value);
  displacements.target = 1;
  displacements.vertex_count = 0;
  EXPECT_EQ(round_trip(displacements), DecodeStatus::bad_value);
  displacements.vertex_count = 2;
  displacements.displacements_m[4] = std::numeric_limits<float>::infinity();
  EXPECT_EQ(round_trip(displacements), DecodeStatus::bad_value);

  PatchBody body{.epoch = 1, .serial = 2, .body = 3, .deforms = true};
  EXPECT_EQ(round_trip(body), DecodeStatus::ok);
  for (const auto motion : {PatchBody::Motion::still, PatchBody::Motion::commanded}) {
    PatchBody keyless{.epoch = 1, .serial = 2, .body = 3, .motion = motion};
    EXPECT_EQ(round_trip(keyless), DecodeStatus::ok);
    keyless.all_keys = ~0U;
    EXPECT_EQ(round_trip(keyless), DecodeStatus::bad_value) << "keyframes of what has none";
    keyless.all_keys = 0;
    keyless.first_key = 1;
    EXPECT_EQ(round_trip(keyless), DecodeStatus::bad_value);
  }
  body.motion = static_cast<PatchBody::Motion>(3);
  EXPECT_EQ(round_trip(body), DecodeStatus::bad_value);
}

}  // namespace
}  // namespace hapton
