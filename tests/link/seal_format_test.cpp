#include "link/seal_format.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <utility>
#include <variant>
#include <vector>

#include "link/codec.h"
#include "link/messages.h"

namespace hapton {
namespace {

constexpr std::uint32_t kMax32 = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint64_t kMax64 = std::numeric_limits<std::uint64_t>::max();
constexpr std::int64_t kMinTime = -kMaxWireTimeNs;
// None of these values is left out of a message for being zero, and none has a short encoding.
const Vec3 kVector(-1.0 / 3.0, 1e8 / 3.0, -1e-8 / 3.0);
const Quat kRotation(0.5, -0.5, 0.5, -0.5);
constexpr float kRate = 1e9F;
constexpr std::array<float, 12> kPose = {0, 0, 1, -1e9F, 1, 0, 0, 1e9F, 0, 1, 0, -1e-9F};

template <std::size_t N>
void fill_text(std::array<char, N>& text) {
  std::fill(text.begin(), text.end() - 1, 'x');
}

// Each kind of message at its longest. A new kind of message needs its own function here.
void lengthen(Hello& m) { m.role = NodeRole::tool; }
void lengthen(Welcome& m) { m = {true, kMaxServoRateHz}; }
void lengthen(Bye&) {}
void lengthen(DeviceState& m) { m = {kMax64, kMinTime, kVector, kRotation, kMax32, true, kVector, kMaxWireTimeNs}; }
void lengthen(ForceCommand& m) {
  m = {kMax64, kMinTime, kVector, kVector, true, kMax32, kMax32, kMax32, kMax32, kMax64, kMax32, 5, kVector, kVector, kMaxWireTimeNs};
  m.move_serial = m.carve_serial = m.shape_serial = kMax32;
  m.push = {kVector, kVector};
  m.haptons = kMax32;
  m.held_offset_m = kVector;
}
void lengthen(ViewTransform& m) { m = {kMax32, kPose}; }
void lengthen(ProbeState& m) {
  m = {kMax64, kMinTime, kVector, kRotation, kVector, kVector, true, kMax32, kRate, kRate, kRate, kMax32, ProbeStatus::too_small, 100, 5};
  m.torque_nm = m.visual_turn = kVector;
  m.force_limit_n = kRate;
  m.scene_time_ns = kMaxWireTimeNs;
  m.push = {kVector, kVector};
  m.haptons = kMax32;
}
void lengthen(FrameAck& m) { m = {kMax64, kMinTime, kRate, kMax32, kMax32, true, true}; }
void lengthen(HandTarget& m) { m = {true, kVector, kMax32, kVector}; }
void lengthen(Settings& m) {
  m.servo_rate_hz = kMaxServoRateHz;
  m.method.fill('x');
  m.report_now = true;
  m.reset_faults = true;
  m.method_request = kMax32;
}
void lengthen(HapticsSetup& m) {
  m = {kMax32, kMax32, kPose, kMax64, {}, {}, {}, kMax32, {}, kMax32, kMax32};
  fill_text(m.scene);
  fill_text(m.build);
  fill_text(m.method);
  fill_text(m.rejection);
}
void lengthen(SceneFacts& m) {
  m = {kMax64, {1, 1, 1}, {2, 2, 2}, SceneFacts::kMaxPoints, {}, 1.0F, true, kMax64};
  m.points_m.fill({3, 3, 3});
}
void lengthen(ReportRequest& m) { m = {ReportDocument::csv, kMax32, kMax32 - 1}; }
void lengthen(ViewRejected& m) { m = {kMax32}; }
void lengthen(LoopFacts& m) {
  m = {{}, kMaxServoRateHz, 1e3F / 3.0F, 1.0F / 3.0F};
  fill_text(m.device);
}
void lengthen(PatchBegin& m) {
  m = {kMax32, kMax32, kVector, 1.0 / 3.0, 1.0 / 3.0, kMax64, PatchBody::kMaxBodies, kMax32, kMax32, PatchEffects::kMaxAllBytes};
}
void lengthen(PatchBody& m) {
  constexpr std::uint32_t kLast = (1U << kPatchGridBits) - 1;
  m = {.epoch = kMax32, .serial = kMax32, .body = PatchBody::kMaxBodies - 1, .motion = PatchBody::Motion::keyframes};
  m.lowest = m.highest = {kLast, kLast, kLast};
  m.pivot_m = kVector;
  m.radius_m = 1.0 / 3.0;
  m.object = std::numeric_limits<std::int32_t>::max();
  m.move_serial = kMax32;
  m.loops = true;
  m.all_keys = PatchBody::kMaxAllKeys;
  m.key_count = PatchBody::kMaxKeys;
  m.first_key = m.all_keys - m.key_count;
  for (std::size_t n = 0; n < m.keys.size(); ++n) m.keys[n] = {static_cast<double>(n) + 1.0 / 3.0, kVector, kRotation};
}
void lengthen(PatchMaterial& m) { m = {kMax32, kMax32, kMax32 >> 1, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0}; }
void lengthen(PatchCell& m) {
  constexpr std::uint32_t kLast = (1U << kPatchDeepestLevel) - 1;
  m = {kMax32, kMax32, kPatchDeepestLevel, {kLast, kLast, kLast}, {}, PatchCell::kMaxTiles, {}, PatchBody::kMaxBodies - 1};
  m.empty_children.fill(0xFF);
  m.tiles.fill(kMax32);
}
void lengthen(PatchTile& m) {
  m = {kMax32, kMax32, kMax32, kMax32 >> 1, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, false};
  m.vertex_count = PatchTile::kMaxVertices;
  m.triangle_count = PatchTile::kMaxTriangles;
  m.vertices.fill(0xFF);
}
void lengthen(PatchDeformation& m) {
  m = {kMax32, kMax32, PatchBody::kMaxBodies - 1, kMax32, kMax32, kMax32, 1, true, PatchDeformation::kMaxAllKeys};
  m.key_count = static_cast<std::uint32_t>(PatchDeformation::kMaxNumbers / PatchDeformation::numbers_of_key(m.target_count));
  m.first_key = m.all_keys - m.key_count;
  for (std::size_t i = 0; i < m.keys.size(); ++i) m.keys[i] = static_cast<double>(i) + 1.0 / 3.0;
}
void lengthen(PatchDisplacements& m) {
  m = {kMax32, kMax32, kMax32, PatchDeformation::kMaxTargets - 1, PatchTile::kMaxVertices};
  m.displacements_m.fill(1.0F / 3.0F);
}
void lengthen(PatchStream& m) {
  m = {kMax32, kMax32, PatchBody::kMaxBodies - 1, kMax32 - 1, kMax32, kMax32 >> 1, ShapePart::kMaxVertices, 1.0 / 3.0};
  m.to_scene.setConstant(1.0 / 3.0);
  m.shape_serial = kMax32;
  m.tile = m.first_tile;
  m.vertex_count = PatchTile::kMaxVertices;
  m.vertices.fill(m.total - 1);
}
void lengthen(PatchEffects& m) {
  m = {kMax32, kMax32, PatchEffects::kMaxAllBytes / PatchEffects::kMaxBytes, PatchEffects::kMaxBytes};
  m.bytes.fill(0xFF);
}
void lengthen(PatchStatus& m) { m = {true, kMax32, kMax32, {}, kRate, kMax32, kMax64, kMax32, true, kRate}; }
constexpr MaterialChange kChange = {MaterialChange::kAll, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0};
void lengthen(MaterialRequest& m) {
  m = {kMax32, {}, kChange};
  fill_text(m.object);
}
void lengthen(MaterialState& m) {
  m = {kMax32, kMax32, {}, MaterialState::kMaxObjects, {}};
  fill_text(m.rejection);
  for (std::size_t i = 0; i < m.objects.size(); ++i) {
    m.objects[i] = {std::numeric_limits<std::int32_t>::max() - static_cast<std::int32_t>(m.objects.size() - i), kChange};
  }
}
void lengthen(ObjectPose& m) { m = {kMax32, std::numeric_limits<std::int32_t>::max(), true, kVector, kRotation}; }
void lengthen(MoveRequest& m) {
  m = {kMax32, {}, std::numeric_limits<std::int32_t>::max(), kVector, kRotation, 1.0 / 3.0};
  fill_text(m.object);
}
void lengthen(MoveReply& m) {
  m = {kMax32, {}, std::numeric_limits<std::int32_t>::max(), 1.0 / 3.0, kMax32};
  fill_text(m.rejection);
}
void lengthen(ObjectMove& m) {
  m = {kMax32, kMax32, std::numeric_limits<std::int32_t>::max(), kMaxWireTimeNs, kMaxWireTimeNs, kVector, kRotation, kVector, kRotation};
  fill_text(m.name);
}
// An undo is shorter than a carve, also with the two fields that it adds.
void lengthen(Carves& m) {
  m = {kMax32, kMax32, kMax32 - Carves::kMax, Carves::kMax, {}};
  m.carves.fill({std::numeric_limits<std::int32_t>::max(), {0.1F, 0.2F, 0.3F}, {0.2F, 0.3F, 0.4F}, 0.1F, true});
}
void lengthen(CarveUndo& m) { m = {kMax32, kMax32}; }
ShapePart make_long_part() {
  ShapePart part{.total = ShapePart::kMaxVertices};
  part.first = (part.total / ShapePart::kVerticesPerPart - 1) * ShapePart::kVerticesPerPart;
  part.displacements_m.fill({0.1F, 0.2F, 0.3F});
  return part;
}
void lengthen(ShapeRequest& m) {
  m = {kMax32, kMax32, {}, std::numeric_limits<std::int32_t>::max(), 1.0 / 3.0, make_long_part()};
  fill_text(m.object);
}
void lengthen(ShapeReply& m) {
  m = {kMax32, kMax32, {}, std::numeric_limits<std::int32_t>::max(), 1.0 / 3.0, kMax32};
  fill_text(m.rejection);
}
void lengthen(ObjectShape& m) { m = {kMax32, kMax32, std::numeric_limits<std::int32_t>::max(), make_long_part()}; }
void lengthen(ShapeStart& m) {
  m = {kMax32, kMax32, kMax32 - 1, std::numeric_limits<std::int32_t>::max(), ShapePart::kMaxVertices, kMaxWireTimeNs, kMaxWireTimeNs};
}
void lengthen(ShapeStatus& m) {
  m = {kMax32, kMax32, std::numeric_limits<std::int32_t>::max(), make_long_part().first, 9984};  // 156 parts of 64 vertices
}
void lengthen(CarveStatus& m) { m = {kMax32, kMax32}; }
void lengthen(Marker& m) {
  m.request = kMax32;
  std::fill(m.text.begin(), m.text.end() - 1, 'x');
}
void lengthen(MarkerReply& m) { m = {kMax32, kMax64, MarkerStatus::no_room}; }
void lengthen(ReportPart& m) {
  m.document = ReportDocument::csv;
  m.revision = kMax32;
  m.part = kMax32 - 1;
  m.parts = kMax32;
  m.size = static_cast<std::uint16_t>(m.text.size());
  m.text.fill('x');
}

template <std::size_t kKind>
Message longest_of_kind() {
  Message message(std::in_place_index<kKind>);
  lengthen(std::get<kKind>(message));
  return message;
}

template <std::size_t... kKinds>
std::vector<Message> longest_of_all(std::index_sequence<kKinds...>) {
  return {longest_of_kind<kKinds>()...};
}

// Every message fits into one datagram, so there is no fragmentation.
TEST(SealFormatTest, EveryMessageAtItsLongestFitsOneSealedDatagram) {
  Codec codec;
  for (const Message& message : longest_of_all(std::make_index_sequence<std::variant_size_v<Message>>())) {
    std::array<std::byte, kMaxDatagramBytes> bytes;
    const Datagram datagram{{kMax64, kMax64, kMax64, kMinTime}, message};
    const std::size_t size = codec.encode(datagram, bytes);
    ASSERT_GT(size, 0U) << "kind " << message.index();
    EXPECT_LE(size, seal::kMaxPayloadBytes) << "kind " << message.index();
    Datagram decoded;
    EXPECT_EQ(codec.decode(std::span(bytes).first(size), decoded), DecodeStatus::ok) << "kind " << message.index();
  }
}

TEST(SealFormatTest, ASealedDatagramIsNoLongerThanAnyOther) {
  EXPECT_EQ(seal::kMaxPayloadBytes + seal::kOverheadBytes, kMaxDatagramBytes);
  EXPECT_LE(kMaxDatagramBytes, 1200U);
}

TEST(SealFormatTest, ClassifiesByLeadAndLength) {
  std::vector<std::byte> bytes(seal::kRequestBytes);
  seal::write_lead(seal::Kind::request, seal::bytes_of(std::span(bytes)));
  EXPECT_EQ(classify_sealed(bytes).status, OpenStatus::opened);
  EXPECT_EQ(classify_sealed(bytes).kind, seal::Kind::request);
  for (int kind = 0; kind < 256; ++kind) {
    bytes[2] = static_cast<std::byte>(kind);
    // The length is valid for data (kind 4), too.
    EXPECT_EQ(classify_sealed(bytes).status == OpenStatus::opened, kind == 1 || kind == 4) << kind;
  }
  bytes[2] = std::byte{1};
  for (std::size_t spare = seal::kRoleAt + 1; spare < seal::kHostAt; ++spare) {
    bytes[spare] = std::byte{1};
    EXPECT_EQ(classify_sealed(bytes).status, OpenStatus::malformed);
    bytes[spare] = std::byte{0};
  }
  bytes[3] = std::byte{1};
  EXPECT_EQ(classify_sealed(bytes).status, OpenStatus::malformed);
  EXPECT_EQ(classify_sealed({}).status, OpenStatus::malformed);
}

TEST(SealFormatTest, EachResultOfOpeningIsCountedAsItself) {
  using Counter = std::uint64_t SealCounts::*;
  const std::pair<OpenStatus, Counter> members[] = {{OpenStatus::opened, &SealCounts::opened},
                                                    {OpenStatus::malformed, &SealCounts::malformed},
                                                    {OpenStatus::wrong_version, &SealCounts::wrong_version},
                                                    {OpenStatus::unknown_session, &SealCounts::unknown_session},
                                                    {OpenStatus::replayed, &SealCounts::replayed},
                                                    {OpenStatus::forged, &SealCounts::forged}};
  for (const auto& [status, own] : members) {
    SealCounts counts;
    count(status, counts);
    for (const auto& [other, member] : members) EXPECT_EQ(counts.*member, member == own ? 1U : 0U) << static_cast<int>(status);
  }
}

TEST(SealFormatTest, TheVersionIsWhereAnEnvelopeHasIt) {
  std::array<std::byte, seal::kLeadBytes> lead;
  seal::write_lead(seal::Kind::data, seal::bytes_of(std::span<std::byte>(lead)));
  std::array<std::byte, kMaxDatagramBytes> envelope;
  Codec codec;
  ASSERT_GT(codec.encode({{}, Hello{}}, envelope), 0U);
  EXPECT_EQ(lead[0], envelope[0]);
  EXPECT_EQ(lead[1], envelope[1]);
}

}  // namespace
}  // namespace hapton
