#include "link/codec.h"

#include <gtest/gtest.h>

#include "tests/link/codec_fixture.h"

namespace hapton {
namespace {

TEST_F(CodecTest, RoundTripsEveryMessage) {
  for (int repeat = 0; repeat < 500; ++repeat) {
    for (std::size_t kind = 0; kind < kKinds; ++kind) {
      const Datagram sent = random_.draw(kind);
      ASSERT_EQ(sent.message.index(), kind);
      const Bytes bytes = encode(sent);
      ASSERT_GT(bytes.size(), 0U);
      ASSERT_EQ(decode(bytes), DecodeStatus::ok) << "kind " << kind;
      expect_equal(sent, decoded_);
    }
  }
}

// The length of the message's text: the name in a request or a move, or the reason for a rejection; 0: it has none.
std::size_t length_of_text(const Message& message) {
  const auto length = [](const auto& text) { return std::string_view(text.data()).size(); };
  if (const auto* request = std::get_if<MoveRequest>(&message)) return length(request->object);
  if (const auto* reply = std::get_if<MoveReply>(&message)) return length(reply->rejection);
  if (const auto* move = std::get_if<ObjectMove>(&message)) return length(move->name);
  if (const auto* reply = std::get_if<ShapeReply>(&message)) return length(reply->rejection);
  return 0;
}

// Bytes that only sessions with a tool have: two vectors, each with 2 bytes of tag and 1 of length, and a number with 2 bytes of tag.
std::size_t length_of_tool(const Message& message) {
  const auto* probe = std::get_if<ProbeState>(&message);
  return probe == nullptr ? 0U : (probe->push ? 2U * (2 + 1 + 24) : 0U) + (probe->haptons ? 2U + 4U : 0U);
}

TEST_F(CodecTest, KeepsWithinTheByteBudget) {
  for (std::size_t kind = 0; kind < kKinds; ++kind) {
    // A setup and a part of a report carry texts. Scenes for a slow network, shapes and changed materials (21) fill datagrams.
    const bool is_large = kind == 16 || kind == 17 || kind == 21 || kind == 28 || kind == 30 || kind == 33 || kind == 35 || kind >= 38;
    const std::size_t max_bytes = is_large ? 1168U : kind == 10 ? 900U : kind == 12 ? 1000U : 300U;
    const Datagram drawn = random_.draw(kind);
    EXPECT_LE(encode(drawn).size(), max_bytes + length_of_text(drawn.message) + length_of_tool(drawn.message)) << "kind " << kind;
  }
}

// An eavesdropper must not learn from lengths whether there is contact, or with which force.
TEST_F(CodecTest, WhatTheHandFeelsHasOneLengthWhateverItSays) {
  const Vec3 long_numbers(-1.0 / 3.0, 1e8 / 3.0, -1e-8 / 3.0);
  const std::vector<std::vector<Message>> kinds = {
      {DeviceState{}, DeviceState{~std::uint64_t{0}, -1, long_numbers, Quat(0.5, -0.5, 0.5, -0.5), ~0U},
       DeviceState{.sample = 1, .is_resumed = true, .p_WP = long_numbers}},
      {ForceCommand{}, ForceCommand{.contact = true},
       ForceCommand{.force_n = long_numbers, .visual_offset_m = long_numbers, .contact = true},
       ForceCommand{~std::uint64_t{0}, -1, long_numbers, long_numbers, true, ~0U, ~0U, ~0U, ~0U, ~std::uint64_t{0}, ~0U, 7, long_numbers,
                    long_numbers}},
      {ProbeState{},
       ProbeState{~std::uint64_t{0}, -1, long_numbers, Quat(0.5, -0.5, 0.5, -0.5), long_numbers, long_numbers, true, ~0U, 1e9F, 1e9F, 1e9F,
                  ~0U},
       ProbeState{.object = 7, .torque_nm = long_numbers, .visual_turn = long_numbers}},
      // With a tool that can push objects: whether it pushes one or not.
      {ForceCommand{.push = ObjectPush(), .haptons = 0},
       ForceCommand{.contact = true, .push = ObjectPush{long_numbers, long_numbers}, .haptons = ~0U}},
      // With layers: whether a needle is in them or not.
      {ForceCommand{.held_offset_m = Vec3::Zero()}, ForceCommand{.contact = true, .held_offset_m = long_numbers}},
      {ProbeState{.push = ObjectPush(), .haptons = 0},
       ProbeState{.contact = true, .push = ObjectPush{long_numbers, long_numbers}, .haptons = ~0U}}};
  for (const auto& messages : kinds) {
    std::set<std::size_t> lengths;
    for (const Message& message : messages) {
      for (const Header& header : {Header{}, Header{~std::uint64_t{0}, ~std::uint64_t{0}, ~std::uint64_t{0}, -1}}) {
        const Bytes bytes = encode({header, message});
        lengths.insert(bytes.size());
        EXPECT_EQ(decode(bytes), DecodeStatus::ok);
      }
    }
    EXPECT_EQ(lengths.size(), 1U) << "kind " << messages.front().index();
    EXPECT_GT(*lengths.begin(), 100U);
  }
}

// A haptics node of an earlier build sends nothing about objects, a tool or motion.
TEST_F(CodecTest, AForceCommandWithoutAnObjectNamesNone) {
  Bytes bytes = encode({{},
                        ForceCommand{.echo_sample = 9,
                                     .contact = true,
                                     .object = 3,
                                     .torque_nm = Vec3(1, 2, 3),
                                     .scene_time_ns = 7,
                                     .move_serial = 5,
                                     .carve_serial = 6,
                                     .shape_serial = 7}});
  // The message is the last field of the envelope. Its last fields are cut off: the object (1 byte of tag, 4 of number), torque and turn
  // (each 1 byte of tag, 1 of length, three numbers), the time of the scene (1 byte of tag, 8 of number), and the serials of the newest
  // move, carve and shape (each 2 bytes of tag, 4 of number).
  constexpr std::size_t kLeftOutBytes = 5 + 2 * (2 + 24) + 9 + 3 * 6;
  const auto low_bits = [&](std::size_t i) { return std::to_integer<std::size_t>(bytes[i]) & 0x7FU; };
  std::size_t length_at = 2;
  while (length_at + 1 < bytes.size() && !(bytes[length_at - 2] == std::byte{0xA2} && bytes[length_at - 1] == std::byte{1} &&
                                           low_bits(length_at) + 128 * low_bits(length_at + 1) == bytes.size() - length_at - 2)) {
    ++length_at;
  }
  ASSERT_LT(length_at + 1, bytes.size()) << "its tag and its length, which is two bytes";
  const std::size_t length = bytes.size() - length_at - 2 - kLeftOutBytes;
  bytes[length_at] = static_cast<std::byte>(0x80U | (length & 0x7FU));
  bytes[length_at + 1] = static_cast<std::byte>(length >> 7U);
  bytes.resize(bytes.size() - kLeftOutBytes);
  Datagram decoded;
  ASSERT_EQ(Codec().decode(bytes, decoded), DecodeStatus::ok);
  const auto& force = std::get<ForceCommand>(decoded.message);
  EXPECT_EQ(force.object, -1);
  EXPECT_EQ(force.torque_nm, Vec3(Vec3::Zero()));
  EXPECT_EQ(force.scene_time_ns, 0);
  EXPECT_EQ((std::array{force.move_serial, force.carve_serial, force.shape_serial}), (std::array{0U, 0U, 0U}));
  EXPECT_EQ(force.echo_sample, 9U);
}

TEST_F(CodecTest, RoundTripsDefaults) {
  EXPECT_EQ(round_trip(Hello{}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(Welcome{}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(DeviceState{}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(ForceCommand{}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(ViewTransform{}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(ProbeState{}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(HandTarget{}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(Settings{}), DecodeStatus::ok);
}

TEST_F(CodecTest, CarriesTheVersionFirst) {
  const Bytes bytes = encode(random_.draw(kDeviceState));
  EXPECT_EQ(bytes[0], std::byte{0x08});
  EXPECT_EQ(bytes[1], std::byte{kProtocolVersion});
}

// A message that the codec writes itself, and one of Protobuf.
TEST_F(CodecTest, RejectsABufferThatIsTooSmall) {
  for (const Datagram& datagram : {random_.draw(kDeviceState), Datagram{{7, 8, 9, 10}, Hello{NodeRole::haptics}}}) {
    const std::size_t size = encode(datagram).size();
    Bytes exact(size, std::byte{0});
    Bytes small(size - 1, std::byte{0xEE});
    EXPECT_EQ(codec_.encode(datagram, exact), size);
    EXPECT_EQ(codec_.encode(datagram, small), 0U);
    EXPECT_EQ(codec_.encode(datagram, {}), 0U);
    EXPECT_EQ(small, Bytes(size - 1, std::byte{0xEE}));
  }
}

TEST_F(CodecTest, LeavesTheDatagramAloneWhenItRejects) {
  decoded_ = Datagram{{7, 8, 9, 10}, Welcome{true, 1234.0}};
  Bytes bytes = encode(random_.draw(kDeviceState));
  bytes.resize(bytes.size() / 2);
  ASSERT_NE(decode(bytes), DecodeStatus::ok);
  expect_equal(decoded_, Datagram{{7, 8, 9, 10}, Welcome{true, 1234.0}});
}

TEST_F(CodecTest, ReportsAnotherVersion) {
  Bytes bytes = encode(random_.draw(kDeviceState));
  bytes[1] = std::byte{kProtocolVersion + 1};
  EXPECT_EQ(decode(bytes), DecodeStatus::wrong_version);
  // Whatever a later version has after its version number.
  EXPECT_EQ(decode({std::byte{0x08}, std::byte{kProtocolVersion + 1}, std::byte{0xFF}, std::byte{0xFF}}), DecodeStatus::wrong_version);
  EXPECT_EQ(decode({std::byte{0x08}, std::byte{0x80}, std::byte{0x01}}), DecodeStatus::wrong_version);
  EXPECT_EQ(decode({std::byte{0x08}, std::byte{0x00}}), DecodeStatus::wrong_version);
}

TEST_F(CodecTest, ReportsAnUnknownMessageAndSkipsUnknownFields) {
  // Field 100, length-delimited, two bytes: a message of a later build.
  const Bytes later = {std::byte{0xA2}, std::byte{0x06}, std::byte{0x02}, std::byte{0x08}, std::byte{0x01}};
  Bytes unknown = {std::byte{0x08}, std::byte{kProtocolVersion}};
  unknown.insert(unknown.end(), later.begin(), later.end());
  EXPECT_EQ(decode(unknown), DecodeStatus::unknown_message);

  const Datagram sent = random_.draw(kDeviceState);
  Bytes extended = encode(sent);
  extended.insert(extended.end(), later.begin(), later.end());
  ASSERT_EQ(decode(extended), DecodeStatus::ok);
  expect_equal(sent, decoded_);
}

TEST_F(CodecTest, RejectsTwoMessagesInOne) {
  Bytes both = encode(Datagram{{}, Hello{}});
  const Bytes drawn = encode(Datagram{{}, FrameAck{1, 2, 3.0F}});
  both.insert(both.end(), drawn.begin(), drawn.end());
  EXPECT_EQ(decode(both), DecodeStatus::bad_value);
}

TEST_F(CodecTest, RejectsAVectorOfTheWrongLength) {
  // Concatenating the same message merges its repeated fields: six numbers where three belong.
  Bytes doubled = encode(random_.draw(kDeviceState));
  const Bytes once = doubled;
  doubled.insert(doubled.end(), once.begin(), once.end());
  EXPECT_EQ(decode(doubled), DecodeStatus::bad_value);
}

TEST_F(CodecTest, RejectsValuesOutsideTheContract) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, infinity, -infinity, 2 * kMaxWireMagnitude}) {
    EXPECT_EQ(round_trip(DeviceState{.p_WD = Vec3(0, bad, 0)}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(DeviceState{.q_WT = Quat(1, 0, bad, 0)}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(DeviceState{.is_resumed = true, .p_WP = Vec3(0, bad, 0)}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(ForceCommand{.force_n = Vec3(0, 0, bad)}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(ForceCommand{.visual_offset_m = Vec3(bad, 0, 0)}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(ProbeState{.visual_offset_m = Vec3(bad, 0, 0)}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(ForceCommand{.torque_nm = Vec3(0, bad, 0)}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(ForceCommand{.visual_turn = Vec3(0, bad, 0)}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(ProbeState{.torque_nm = Vec3(0, bad, 0)}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(ProbeState{.visual_turn = Vec3(0, bad, 0)}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(ForceCommand{.push = ObjectPush{.force_n = Vec3(0, bad, 0)}}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(ForceCommand{.push = ObjectPush{.torque_nm = Vec3(0, bad, 0)}}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(ProbeState{.push = ObjectPush{.force_n = Vec3(bad, 0, 0)}}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(ProbeState{.force_limit_n = static_cast<float>(bad)}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(ProbeState{.round_trip_p99_us = static_cast<float>(bad)}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(HandTarget{true, Vec3(bad, 0, 0)}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(Welcome{true, bad}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(FrameAck{1, 2, static_cast<float>(bad)}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(Settings{.servo_rate_hz = bad}), DecodeStatus::bad_value);
    for (const std::size_t place : {0U, 3U, 11U}) {
      ViewTransform view;
      view.X_WS[place] = static_cast<float>(bad);
      EXPECT_EQ(round_trip(view), DecodeStatus::not_rigid) << place;
    }
  }
  EXPECT_EQ(round_trip(DeviceState{.q_WT = Quat(0, 0, 0, 0)}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(DeviceState{.q_WT = Quat(1.01, 0, 0, 0)}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(ViewTransform{.X_WS = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0}}), DecodeStatus::not_rigid);  // a mirror
  EXPECT_EQ(round_trip(ViewTransform{.X_WS = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0}}), DecodeStatus::not_rigid);   // a scale
  EXPECT_EQ(round_trip(HapticsSetup{.X_WS = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0}}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(Hello{static_cast<NodeRole>(0)}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(Hello{static_cast<NodeRole>(5)}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(Settings{.servo_rate_hz = 100.0}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(Settings{.servo_rate_hz = 20'000.0}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(Settings{.method = {'a', '\n'}}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(HapticsSetup{.rejection = {'a', '\n'}}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(HapticsSetup{.rejection = {'\x1b', '['}}), DecodeStatus::bad_value);
  HapticsSetup endless;
  endless.rejection.fill('x');  // the last byte is NUL
  EXPECT_EQ(round_trip(endless), DecodeStatus::bad_value);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(round_trip(SceneFacts{.lowest_m = {0, kNan, 0}}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(SceneFacts{.preparing_s = kNan}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(SceneFacts{.preparing_s = -1.0F}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(SceneFacts{.point_count = 1, .points_m = {{{0, 0, 2e9F}}}}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(FrameAck{1, 2, -1.0F}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(LoopFacts{{'s'}, 1000.0, 0.001F}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(LoopFacts{{'s'}, 20'000.0, 0.001F}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(LoopFacts{{'s'}, 1000.0, kNan}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(LoopFacts{{'s'}, 1000.0, -0.001F}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(LoopFacts{{'s'}, 1000.0, 0.001F, 0.17F}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(LoopFacts{{'s'}, 1000.0, 0.001F, HUGE_VALF}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(LoopFacts{{'\n'}, 1000.0, 0.001F}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(ReportPart{.part = 2, .parts = 2}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(ReportRequest{.document = static_cast<ReportDocument>(2)}), DecodeStatus::bad_value);
}

TEST_F(CodecTest, RejectsChangesOfMaterialsThatMeanNothing) {
  const MaterialRequest good{
      .request = 1, .object = {"hull"}, .change = {.fields = MaterialChange::kStiffness, .stiffness_n_per_m = 800.0}};
  EXPECT_EQ(round_trip(good), DecodeStatus::ok);
  MaterialRequest bad = good;
  bad.request = 0;
  EXPECT_EQ(round_trip(bad), DecodeStatus::bad_value) << "nobody could match the reply";
  bad = good;
  bad.change.fields = 0;
  EXPECT_EQ(round_trip(bad), DecodeStatus::bad_value);
  bad = good;
  bad.object = {'a', '\n'};
  EXPECT_EQ(round_trip(bad), DecodeStatus::bad_value);
  for (const double number : {std::numeric_limits<double>::quiet_NaN(), -1.0, 2e9}) {
    bad = good;
    bad.change.stiffness_n_per_m = number;
    EXPECT_EQ(round_trip(bad), DecodeStatus::bad_value) << number;
  }

  MaterialState state{.serial = 1, .object_count = 2};
  state.objects[0] = {-1, good.change};
  state.objects[1] = {3, good.change};
  EXPECT_EQ(round_trip(state), DecodeStatus::ok);
  for (const std::int32_t object : {-2, -1}) {
    state.objects[1].object = object;
    EXPECT_EQ(round_trip(state), DecodeStatus::bad_value) << object;
  }
  state.objects[1] = {3, {.fields = MaterialChange::kDamping, .stiffness_n_per_m = 1.0}};
  EXPECT_EQ(round_trip(state), DecodeStatus::bad_value) << "a number that is not given";
  state.objects[1] = {3, {.fields = MaterialChange::kAll + 1}};
  EXPECT_EQ(round_trip(state), DecodeStatus::bad_value);
}

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

TEST_F(CodecTest, RejectsBadRequestsToMove) {
  const MoveRequest good{.request = 1, .object = {"lid"}, .p_m = Vec3(0.1, 0, 0), .q = Quat::Identity(), .over_s = 0.5};
  EXPECT_EQ(round_trip(good), DecodeStatus::ok);
  const auto with = [&](auto&& change) {
    MoveRequest bad = good;
    change(bad);
    return round_trip(bad);
  };
  EXPECT_EQ(with([](MoveRequest& m) { m.request = 0; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](MoveRequest& m) { m.object = {'a', '\n'}; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](MoveRequest& m) { m.number = -1; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](MoveRequest& m) { m.p_m->x() = kNotANumber; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](MoveRequest& m) { m.p_m->x() = 2e9; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](MoveRequest& m) { m.q = Quat(1.0, 0.1, 0.0, 0.0); }), DecodeStatus::bad_value) << "not of unit length";
  EXPECT_EQ(with([](MoveRequest& m) { m.q->w() = kNotANumber; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](MoveRequest& m) { m.p_m.reset(); }), DecodeStatus::ok);
  EXPECT_EQ(with([](MoveRequest& m) { m.q.reset(); }), DecodeStatus::ok);
  EXPECT_EQ(with([](MoveRequest& m) { m.over_s.reset(); }), DecodeStatus::ok);
  EXPECT_EQ(with([](MoveRequest& m) { m.p_m.reset(), m.q.reset(); }), DecodeStatus::bad_value) << "it moves nothing";
  for (const double seconds : {0.0, -1.0, kNotANumber, 86'401.0}) {
    EXPECT_EQ(with([&](MoveRequest& m) { m.over_s = seconds; }), DecodeStatus::bad_value) << seconds;
  }
}

TEST_F(CodecTest, RejectsBadMovesOfObjects) {
  const ObjectMove good{.source = 1, .serial = 2, .object = 3, .start_ns = 4, .end_ns = 5};
  EXPECT_EQ(round_trip(good), DecodeStatus::ok);
  const auto with = [&](auto&& change) {
    ObjectMove bad = good;
    change(bad);
    return round_trip(bad);
  };
  EXPECT_EQ(with([](ObjectMove& m) { m.serial = 0; }), DecodeStatus::ok) << "not moved yet";
  EXPECT_EQ(with([](ObjectMove& m) { m.source = 0; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](ObjectMove& m) { m.object = -1; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](ObjectMove& m) { m.start_ns = -1; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](ObjectMove& m) { m.end_ns = 3; }), DecodeStatus::bad_value) << "before it starts";
  EXPECT_EQ(with([](ObjectMove& m) { m.from_p_m.y() = kNotANumber; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](ObjectMove& m) { m.to_p_m.y() = kNotANumber; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](ObjectMove& m) { m.from_q = Quat(0.5, 0, 0, 0); }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](ObjectMove& m) { m.to_q = Quat(0.5, 0, 0, 0); }), DecodeStatus::bad_value);
  MoveReply reply{.request = 1, .over_s = 0.5};
  EXPECT_EQ(round_trip(reply), DecodeStatus::ok);
  reply.over_s = -1.0;
  EXPECT_EQ(round_trip(reply), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(MoveReply{.request = 0}), DecodeStatus::bad_value);
}

TEST_F(CodecTest, ASampleHasASceneTimeOnlyFromAHubThatComputesTheForce) {
  EXPECT_EQ(round_trip(DeviceState{.sample = 1}), DecodeStatus::ok);
  EXPECT_LT(std::get<DeviceState>(decoded_.message).scene_time_ns, 0);
  EXPECT_EQ(round_trip(DeviceState{.sample = 1, .scene_time_ns = 5}), DecodeStatus::ok);
  EXPECT_EQ(std::get<DeviceState>(decoded_.message).scene_time_ns, 5);
}

TEST_F(CodecTest, RejectsBadCarves) {
  const Carves::One one{.object = 3, .from_m = {0.1F, 0.2F, 0.3F}, .to_m = {0.1F, 0.2F, 0.4F}, .radius_m = 0.01F};
  Carves good{.source = 1, .newest = 9, .first = 8, .count = 2};
  good.carves[0] = good.carves[1] = one;
  EXPECT_EQ(round_trip(good), DecodeStatus::ok);
  EXPECT_EQ(round_trip(Carves{.source = 1}), DecodeStatus::ok) << "none yet";
  EXPECT_EQ(round_trip(Carves{.source = 1, .newest = 9}), DecodeStatus::ok) << "how many there are";
  const auto with = [&](auto&& change) {
    Carves bad = good;
    change(bad);
    return round_trip(bad);
  };
  EXPECT_EQ(with([](Carves& m) { m.source = 0; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](Carves& m) { m.first = 0; }), DecodeStatus::bad_value) << "serials begin with 1";
  EXPECT_EQ(with([](Carves& m) { m.count = 0; }), DecodeStatus::bad_value) << "the first one of none";
  EXPECT_EQ(with([](Carves& m) { m.newest = 8; }), DecodeStatus::bad_value) << "the last one is newer than the newest";
  EXPECT_EQ(with([](Carves& m) { m.newest = 7; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](Carves& m) { m.first = 0xFFFFFFFF; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](Carves& m) { m.carves[1].object = -1; }), DecodeStatus::bad_value);
  for (const float radius : {0.0F, -0.01F, 1000.1F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    EXPECT_EQ(with([&](Carves& m) { m.carves[1].radius_m = radius; }), DecodeStatus::bad_value) << radius;
  }
  for (const float x : {1000.2F, 2e9F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    EXPECT_EQ(with([&](Carves& m) { m.carves[1].from_m[0] = x; }), DecodeStatus::bad_value) << x;
    EXPECT_EQ(with([&](Carves& m) { m.carves[1].to_m[2] = x + 0.3F; }), DecodeStatus::bad_value) << x;
  }
  // The largest values that are allowed.
  EXPECT_EQ(with([](Carves& m) { m.carves[1].radius_m = static_cast<float>(Carves::kMaxRadiusM); }), DecodeStatus::ok);
  EXPECT_EQ(with([](Carves& m) { m.carves[1].object = std::numeric_limits<std::int32_t>::max(); }), DecodeStatus::ok);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const float share : {-1.0F, 1.0F, 1.01F}) {
      const auto stretched = [&](Carves& m) {
        m.carves[1].from_m = {0.0F, 0.0F, 0.0F};
        m.carves[1].to_m = {0.0F, 0.0F, 0.0F};
        m.carves[1].to_m[axis] = share * static_cast<float>(Carves::kMaxLengthM);
      };
      EXPECT_EQ(with(stretched), share > 1.0F ? DecodeStatus::bad_value : DecodeStatus::ok) << axis << " " << share;
    }
  }
  EXPECT_EQ(with([](Carves& m) { m.carves[1].from_m = m.carves[1].to_m = {3e9F, 0.0F, 0.0F}; }), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(CarveStatus{.source = 1, .complete = 4}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(CarveStatus{.complete = 4}), DecodeStatus::bad_value);
}

// Written by hand, because the struct has no room for as many as the count claims.
TEST_F(CodecTest, RejectsCarvesWhoseNumbersDoNotMatchTheirCount) {
  const auto decode_carves = [&](int objects, int numbers) {
    const auto varint = [](std::string& to, std::size_t value) {
      for (; value > 127; value >>= 7) to.push_back(static_cast<char>(value | 0x80));
      to.push_back(static_cast<char>(value));
    };
    std::string inner("\x0D\x01\x00\x00\x00\x15\x40\x00\x00\x00\x1D\x01\x00\x00\x00", 15);  // source 1, newest 64, first 1
    inner += '\x22';
    varint(inner, static_cast<std::size_t>(objects));
    inner.append(static_cast<std::size_t>(objects), '\x01');
    inner += '\x2A';
    varint(inner, 4 * static_cast<std::size_t>(numbers));
    for (int n = 0; n < numbers; ++n) inner += std::string("\x00\x00\x00\x3F", 4);  // 0.5
    std::string whole("\x08\x03\xE2\x02", 4);                                       // version 3, field 44
    varint(whole, inner.size());
    whole += inner;
    const auto* bytes = reinterpret_cast<const std::byte*>(whole.data());
    return decode(Bytes(bytes, bytes + whole.size()));
  };
  EXPECT_EQ(decode_carves(32, 32 * 7), DecodeStatus::ok);
  EXPECT_EQ(decode_carves(33, 33 * 7), DecodeStatus::bad_value) << "more than there is room for";
  EXPECT_EQ(decode_carves(32, 31 * 7), DecodeStatus::bad_value);
  EXPECT_EQ(decode_carves(31, 32 * 7), DecodeStatus::bad_value);
  EXPECT_EQ(decode_carves(2, 2 * 7 - 1), DecodeStatus::bad_value);
  EXPECT_EQ(decode_carves(0, 7), DecodeStatus::bad_value);
}

TEST_F(CodecTest, RejectsBadPosesOfObjects) {
  const ObjectPose good{.serial = 1, .object = 2, .is_held = true};
  EXPECT_EQ(round_trip(good), DecodeStatus::ok);
  ObjectPose bad = good;
  bad.serial = 0;
  EXPECT_EQ(round_trip(bad), DecodeStatus::bad_value);
  bad = good;
  bad.object = -1;
  EXPECT_EQ(round_trip(bad), DecodeStatus::bad_value);
  bad = good;
  bad.p_m.x() = std::numeric_limits<double>::infinity();
  EXPECT_EQ(round_trip(bad), DecodeStatus::bad_value);
  bad = good;
  bad.q = Quat(1.0, 1.0, 0.0, 0.0);
  EXPECT_EQ(round_trip(bad), DecodeStatus::bad_value) << "not of unit length";
}

TEST_F(CodecTest, RejectsMarkersThatNoTableCanHold) {
  EXPECT_EQ(round_trip(Marker{.request = 1, .text = {"trial 1"}}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(Marker{.request = 0, .text = {"trial 1"}}), DecodeStatus::bad_value) << "nobody could match the reply";
  EXPECT_EQ(round_trip(Marker{.request = 1}), DecodeStatus::bad_value) << "empty";
  EXPECT_EQ(round_trip(Marker{.request = 1, .text = {'a', '\n'}}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(Marker{.request = 1, .text = {'a', '\xFF'}}), DecodeStatus::bad_value);
  // One byte more than the longest: written by hand, as the struct has no room for it.
  Marker longest{.request = 1};
  std::fill(longest.text.begin(), longest.text.end() - 1, 'x');
  Bytes bytes = encode(Datagram{{1, 2, 3, 4}, longest});
  EXPECT_EQ(decode(bytes), DecodeStatus::ok);
  const std::size_t text = bytes.size() - MarkerText::kMaxBytes;
  std::byte& text_length = bytes[text - 2];            // low byte of the 2-byte varint before the text
  std::byte& marker_length = bytes[text - 3 - 5 - 2];  // same for the message: before the text's tag, the request (5), its own length (2)
  ASSERT_EQ(text_length, std::byte{0xA0});
  ASSERT_EQ(marker_length, std::byte{0xA8});
  text_length = std::byte{0xA1};
  marker_length = std::byte{0xA9};
  bytes.push_back(std::byte{'x'});
  EXPECT_EQ(decode(bytes), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(MarkerReply{1, 2, static_cast<MarkerStatus>(4)}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(MarkerReply{0, 2, MarkerStatus::recorded}), DecodeStatus::bad_value);
}

TEST_F(CodecTest, RejectsMoreThanADatagramHolds) {
  EXPECT_EQ(decode(Bytes(kMaxDatagramBytes + 1, std::byte{0x08})), DecodeStatus::bad_value);
  for (const std::size_t size : {kMaxDatagramBytes, kMaxDatagramBytes + 1}) {
    Bytes bytes = encode(Datagram{{1, 2, 3, 4}, Hello{NodeRole::haptics}});
    // A field of a later version fills the datagram: its tag in two bytes, its length in two more.
    const std::size_t left = size - bytes.size() - 4;
    for (const std::size_t byte : {std::size_t{0xC2}, std::size_t{0x3E}, 0x80U | (left & 0x7FU), left >> 7U}) {
      bytes.push_back(static_cast<std::byte>(byte));
    }
    bytes.resize(size);
    EXPECT_EQ(decode(bytes), size == kMaxDatagramBytes ? DecodeStatus::ok : DecodeStatus::bad_value) << size;
  }
}

// The compiler may drop a new-expression that has no effect, but not this call.
TEST(AllocationGuardTest, SeesAnAllocation) {
  if (!AllocationGuard::is_available()) {
    GTEST_SKIP() << "heap use cannot be counted in this build";
  }
  const AllocationGuard guard;
  void* memory = ::operator new(32);
  EXPECT_EQ(guard.count(), 1U);
  ::operator delete(memory);
  EXPECT_EQ(guard.count(), 1U);
}

}  // namespace
}  // namespace hapton
