// Writes the initial inputs of the fuzzers of sealed datagrams, of handshakes and of the parts of scenes to tests/fuzz/corpus/, and sets
// the protocol version in the inputs of target codec. Run it again when the protocol version changes: seals and tags of another version are
// invalid, and fuzz_test reports them.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <initializer_list>

#include "link/codec.h"
#include "patch/patch_source.h"
#include "patch/tile_partition.h"
#include "runtime/clock.h"
#include "tests/fuzz/fixed_random.h"
#include "tests/fuzz/handshake_line.h"
#include "tests/fuzz/sealed_session.h"
#include "tests/support/made_meshes.h"

namespace hapton::fuzz {
namespace {

constexpr std::int64_t kStartNs = 1000 * kNanosecondsPerSecond;
// Flags of ListedDatagram: bits 1 and 2 select the node; bit 0: from the hub to the node; bits 3 and 4 select the pause (here 1.1 s).
constexpr std::uint8_t kHaptics = 0 << 1;
constexpr std::uint8_t kVision = 1 << 1;
constexpr std::uint8_t kTool = 2 << 1;
constexpr std::uint8_t kOperator = 3 << 1;
constexpr std::uint8_t kToNode = 1;
constexpr std::uint8_t kSecondLater = 3 << 3;

bool write(const char* target, const char* name, const std::vector<ListedDatagram>& datagrams) {
  const auto folder = std::filesystem::path(HAPTON_SOURCE_DIR) / "tests/fuzz/corpus" / target;
  std::filesystem::create_directories(folder);
  const Bytes bytes = join_datagrams(datagrams);
  std::ofstream file(folder / name, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file.flush()) std::fprintf(stderr, "cannot write %s\n", (folder / name).c_str());
  return file.good();
}

struct SentMessage {
  std::uint8_t flags = 0;
  Message message;
};

std::vector<ListedDatagram> sealed(std::initializer_list<SentMessage> all) {
  Codec codec;
  std::vector<ListedDatagram> datagrams;
  std::uint64_t number = 0;
  for (const SentMessage& sent : all) {
    ++number;
    const ListedDatagram route{.flags = sent.flags, .bytes = {}};
    Datagram datagram;
    const std::uint64_t sender = route.is_to_node() ? 1U : 10U + route.node();
    datagram.header = {.session = 1, .sender = sender, .sequence = number, .send_time_ns = kStartNs};
    datagram.message = sent.message;
    std::array<std::byte, kMaxDatagramBytes> into;
    const std::size_t size = codec.encode(datagram, into);
    const auto* const bytes = seal::bytes_of(std::span<std::byte>(into));
    const OpenedData data{.connection = connection_of(route.node()), .counter = number, .payload = Bytes(bytes, bytes + size)};
    datagrams.push_back({sent.flags, seal_data(data, route)});
  }
  return datagrams;
}

bool write_sealed() {
  const MaterialRequest change{
      .request = 1, .object = {"hull"}, .change = {.fields = MaterialChange::kStiffness, .stiffness_n_per_m = 800}};
  const MoveRequest move{.request = 1, .object = {"lid"}, .p_m = Vec3(0.1, 0, 0), .q = Quat::Identity(), .over_s = 0.5};
  Carves carves{.source = 1, .newest = 2, .first = 1, .count = 2};
  carves.carves.fill({.to_m = {0.0F, 0.01F, 0.0F}, .radius_m = 0.005F});
  ForceCommand force{.echo_sample = 1, .force_n = Vec3(1, 2, 3), .contact = true, .object = 0};
  return write("sealed", "haptics",
               sealed({{kHaptics, Hello{NodeRole::haptics}}, {kHaptics, force}, {kHaptics, HapticsSetup()}, {kHaptics, Bye()}})) &&
         write("sealed", "patch",
               sealed({{kHaptics, Hello{NodeRole::haptics}},
                       {kHaptics, PatchBegin{.epoch = 1, .serial = 1, .step_m = 1e-8}},
                       {kHaptics, PatchCell{.epoch = 1, .serial = 2, .tile_count = 1}},
                       {kHaptics, PatchTile{.epoch = 1, .serial = 3, .vertex_count = 3, .triangle_count = 1}},
                       {kHaptics, PatchBody{.epoch = 1, .serial = 4, .body = 1, .motion = PatchBody::Motion::commanded}},
                       {kHaptics, PatchMaterial{.epoch = 1, .serial = 5, .stiffness_n_per_m = 500.0}},
                       {kHaptics, PatchBody{.epoch = 1, .serial = 6, .body = 2, .deforms = true}},
                       {kHaptics, PatchDeformation{.epoch = 1,
                                                   .serial = 7,
                                                   .body = 2,
                                                   .tile_count = 1,
                                                   .displaced_count = 1,
                                                   .target_count = 1,
                                                   .all_keys = 1,
                                                   .key_count = 1}},
                       {kHaptics, PatchDisplacements{.epoch = 1, .serial = 8, .vertex_count = 3}},
                       {kHaptics,
                        PatchStream{.epoch = 1, .serial = 9, .body = 2, .tile_count = 1, .total = 3, .reach_m = 0.01, .vertex_count = 3}},
                       {kHaptics, PatchEffects{.epoch = 1, .serial = 10, .byte_count = 2}},
                       {kVision, PatchTile{.epoch = 1, .serial = 4, .vertex_count = 3, .triangle_count = 1}},
                       {kToNode, PatchStatus{.is_wanted = true}}})) &&
         write("sealed", "vision",
               sealed({{kVision, Hello{NodeRole::vision}}, {kVision, ViewTransform()}, {kVision, FrameAck()}, {kVision, HandTarget()}})) &&
         write("sealed", "object",
               sealed({{kHaptics, Hello{NodeRole::haptics}},
                       {kHaptics, ObjectPose{.serial = 1}},
                       {kVision, ObjectPose{.serial = 1}},
                       {kToNode, ObjectPose{.serial = 1}}})) &&
         write("sealed", "tool",
               sealed({{kTool, Hello{NodeRole::tool}}, {kTool, Settings{.servo_rate_hz = 1000.0}}, {kTool, ReportRequest()}})) &&
         write("sealed", "material",
               sealed({{kTool, Hello{NodeRole::tool}},
                       {kTool, change},
                       {kVision, change},
                       {kHaptics, Hello{NodeRole::haptics}},
                       {kHaptics, MaterialState{.serial = 1, .request = 1, .object_count = 1, .objects = {{{-1, change.change}}}}},
                       {kToNode, change}})) &&
         write("sealed", "marker",
               sealed({{kTool, Hello{NodeRole::tool}},
                       {kTool, Marker{.request = 1,
                                      .text = {"gez\xC3\xBC"
                                               "ckt"}}},
                       {kTool, Marker{.request = 1, .text = {"again"}}},
                       {kVision, Marker{.request = 2, .text = {"no node"}}},
                       {kToNode, MarkerReply{1, 2, MarkerStatus::recorded}}})) &&
         write("sealed", "move",
               sealed({{kTool, Hello{NodeRole::tool}},
                       {kTool, move},
                       {kVision, move},
                       {kHaptics, Hello{NodeRole::haptics}},
                       {kHaptics, MoveReply{.request = 1, .over_s = 0.5, .serial = 1}},
                       {kHaptics, ObjectMove{.source = 1, .serial = 1, .end_ns = 500'000'000}},
                       {kToNode, move}})) &&
         write("sealed", "shape",
               sealed({{kTool, Hello{NodeRole::tool}},
                       {kTool, ShapeRequest{.stream = 1, .shape = 1, .object = {"skin"}, .over_s = 0.03, .part = {.total = 65}}},
                       {kVision, ShapeRequest{.stream = 2, .shape = 1, .part = {.total = 65, .first = 64}}},
                       {kHaptics, Hello{NodeRole::haptics}},
                       {kHaptics, ObjectShape{.source = 1, .serial = 1, .part = {.total = 65, .first = 64}}},
                       {kHaptics, ShapeStart{.source = 1, .serial = 1, .total = 65, .start_ns = 1, .end_ns = 2}},
                       {kHaptics, ShapeReply{.stream = 1, .shape = 1, .over_s = 0.03, .serial = 1}},
                       {kVision, ShapeStatus{.source = 1, .serial = 1, .first = 64}}})) &&
         write("sealed", "carve",
               sealed({{kVision, Hello{NodeRole::vision}},
                       {kVision, CarveStatus{.source = 1, .complete = 2}},
                       {kHaptics, Hello{NodeRole::haptics}},
                       {kHaptics, carves},
                       {kHaptics, Carves{.source = 1, .newest = 2}},
                       {kVision, carves},
                       {kVision, CarveStatus{.source = 1}},
                       {kVision, CarveUndo{.source = 1, .serial = 2}},
                       {kToNode, carves}})) &&
         write("sealed", "operator", sealed({{kOperator, Hello{NodeRole::tool}}, {kOperator, Settings{.reset_faults = true}}})) &&
         write("sealed", "wrong_role",
               sealed({{kVision, Hello{NodeRole::haptics}}, {kVision, Hello{NodeRole::vision}}, {kVision, force}})) &&
         write("sealed", "silence",
               sealed({{kHaptics, Hello{NodeRole::haptics}}, {kSecondLater | kTool, Hello{NodeRole::tool}}, {kHaptics, force}})) &&
         write("sealed", "to_node",
               sealed({{kToNode, Welcome{true, 1000.0}},
                       {kToNode, DeviceState()},
                       {kToNode, ViewTransform()},
                       {kToNode, ViewRejected{1}},
                       {kToNode, LoopFacts{}},
                       {kToNode, Settings()},
                       {kToNode, Bye()}}));
}

ListedDatagram request(std::uint8_t flags, std::int64_t later_ns, bool has_cookie) {
  ListedDatagram datagram{.flags = flags, .bytes = {}};
  const seal::Cookie cookie = has_cookie ? find_cookie(datagram.node(), kStartNs) : seal::Cookie();
  datagram.bytes = make_request(datagram.role(), 1, kStartNs + later_ns, cookie);
  return datagram;
}

bool write_request() {
  HandshakeLine line;
  const Bytes first = line.from_node().at(0).bytes;
  const auto timestamp_ns = seal::load<std::int64_t>(first.data() + seal::kRequestTimestampAt);
  const ListedDatagram retry{.flags = kToNode, .bytes = make_retry(timestamp_ns, {1}, KeyRole::haptics)};
  const ListedDatagram reply{.flags = kToNode, .bytes = make_reply(first, 64).value_or(first)};
  ListedDatagram changed = request(kTool, 1, true);
  changed.bytes[seal::kFirstAt] ^= 1U;
  return write("request", "haptics", {request(kHaptics, 1, false), request(kHaptics, 2, true)}) &&
         write("request", "all_roles",
               {request(kHaptics, 1, true), request(kVision, 1, true), request(kTool, 1, true), request(kOperator, 1, true)}) &&
         write("request", "replayed", {request(kTool, 1, true), request(kTool, 1, true)}) &&
         write("request", "old_cookie",
               {request(kSecondLater, 1, false), request(kSecondLater, 2, false), request(kSecondLater, 3, true),
                request(kSecondLater, 4, true)}) &&
         write("request", "without_tag", {changed}) && write("request", "to_node", {retry, reply}) &&
         write("request", "from_hub_to_hub", {{.flags = 0, .bytes = retry.bytes}, request(kVision, 1, true)});
}

Bytes encode(const Message& message, std::uint64_t number) {
  Codec codec;
  std::array<std::byte, kMaxDatagramBytes> into;
  const Datagram datagram{.header = {.session = 1, .sender = 10, .sequence = number, .send_time_ns = kStartNs}, .message = message};
  const auto* const bytes = seal::bytes_of(std::span<std::byte>(into));
  return {bytes, bytes + codec.encode(datagram, into)};
}

// All parts of a scene, then the messages of `later`. Flag 1: the hand moves after that message (patch_fuzz.cpp).
std::vector<ListedDatagram> parts_of(const TouchScene& scene, std::initializer_list<Message> later = {}) {
  std::vector<ListedDatagram> parts;
  PatchSource source(make_tiles(scene), 0.0, 7, 1, {.bits_per_s = 1e15, .least_reach_m = 1e3});
  for (std::int64_t now_ns = kStartNs; now_ns < kStartNs + 100'000'000; now_ns += 1'000'000) {
    if (const auto part = source.take(now_ns)) parts.push_back({.flags = 0, .bytes = encode(*part, parts.size() + 1)});
  }
  for (const Message& message : later) parts.push_back({.flags = 1, .bytes = encode(message, parts.size() + 1)});
  return parts;
}

// A square of two triangles that rises by 2 mm and sinks again.
TouchObject heaving_square() {
  TouchObject square{.mesh = made::shared(made::sheet(0.01, 0.0, 1)), .material = {}};
  MorphTarget rise;
  for (std::uint32_t v = 0; v < 4; ++v) {
    rise.vertices.push_back(v);
    rise.displacements.emplace_back(0.0, 0.0, 0x1p-9);
  }
  square.deformation =
      std::make_shared<const MeshDeformation>(std::vector{rise}, std::vector<MorphKey>{{0.0, {0.0}}, {0.1, {1.0}}, {0.2, {0.0}}}, true);
  return square;
}

// A square that programs deform, by at most 4 mm.
TouchObject swelling_square() {
  TouchObject square{.mesh = made::shared(made::sheet(0.01, 0.0, 1)), .material = {}};
  square.stream_reach_m = 0.004;
  return square;
}

// A square with layers, bumps and a snap.
TouchObject needle_block() {
  TouchObject square{.mesh = made::shared(made::sheet(0.01, 0.0, 1)), .material = {}};
  square.effects.bumps = {.height_m = 0.0005, .length_m = 0.002};
  square.effects.snap.range_m = 0.001;
  square.effects.layers.add({.depth_m = 0.0, .stiffness_n_per_m = 400.0, .pop_force_n = 0.4});
  square.effects.layers.add({.depth_m = 0.002});
  return square;
}

bool write_patch() {
  const TouchObject floor{.mesh = made::shared(made::sheet(0.02, 0.0, 1)), .material = {}};
  TouchObject rising = floor;
  rising.motion = std::make_shared<const KeyframeMotion>(
      Vec3::Zero(), std::vector<Keyframe>{{0.0, Vec3::Zero(), Quat::Identity()}, {0.01, Vec3(0, 0, 0.001), Quat::Identity()}}, false);
  TouchObject lid = floor;
  lid.command_pivot = Vec3::Zero();
  const ObjectMove lifted{.source = 1, .serial = 1, .object = 1, .end_ns = 8'000'000, .to_p_m = Vec3(0, 0, 0.002)};
  const PatchMaterial softer{.epoch = 1, .serial = 99, .stiffness_n_per_m = 300.0};
  return write("patch", "still", parts_of({.objects = {floor}}, {softer})) &&
         write("patch", "keyframes", parts_of({.objects = {floor, rising}})) &&
         write("patch", "commanded", parts_of({.objects = {floor, lid}}, {lifted})) &&
         write("patch", "deforms", parts_of({.objects = {floor, heaving_square()}})) &&
         write("patch", "streams",
               parts_of({.objects = {floor, swelling_square()}},
                        {ObjectShape{.source = 7, .serial = 1, .object = 1, .part = {.total = 4, .displacements_m = {{{0, 0, 0.002F}}}}},
                         ShapeStart{.source = 7, .serial = 1, .object = 1, .total = 4, .start_ns = 2'000'000, .end_ns = 12'000'000},
                         ObjectShape{.source = 7, .serial = 2, .object = 1, .part = {.total = 4}},
                         ShapeStart{.source = 7, .serial = 2, .before = 1, .object = 1, .total = 4, .start_ns = 3, .end_ns = 4}})) &&
         write("patch", "effects", parts_of({.objects = {needle_block(), floor}, .effects = {SpringEffect(), WaveEffect()}})) &&
         write("patch", "next_epoch", parts_of({.objects = {heaving_square()}}, {PatchBegin{.epoch = 2, .serial = 1, .step_m = 1e-8}}));
}

// Writes messages with parts of a scene, one of each of these kinds, for target codec.
bool write_codec_parts() {
  const auto write_message = [](const char* name, const Message& message) {
    const Bytes bytes = encode(message, 1);
    std::ofstream file(std::filesystem::path(HAPTON_SOURCE_DIR) / "tests/fuzz/corpus/codec" / name, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (!file.flush()) std::fprintf(stderr, "cannot write tests/fuzz/corpus/codec/%s\n", name);
    return file.good();
  };
  PatchBody body{.epoch = 1, .serial = 2, .body = 1, .motion = PatchBody::Motion::keyframes, .deforms = true, .lowest = {1, 2, 3}};
  body.highest = {4, 5, 6};
  body.all_keys = body.key_count = 2;
  body.keys[1].time_s = 1.0;
  PatchDeformation weights{.epoch = 1, .serial = 3, .body = 1, .tile_count = 1, .displaced_count = 1, .target_count = 2};
  weights.all_keys = weights.key_count = 2;
  weights.keys = {0.0, 0.0, 0.5, 1.0, 1.0, -0.5};
  PatchDisplacements displaced{.epoch = 1, .serial = 4, .target = 1, .vertex_count = 2};
  displaced.displacements_m = {0.001F, 0.0F, -0.002F, 0.0F, 0.003F, 0.0F};
  PatchStream stream{.epoch = 1, .serial = 5, .body = 1, .tile_count = 1, .total = 3, .reach_m = 0.01, .to_scene = Mat3::Identity()};
  stream.vertex_count = 3;
  stream.vertices = {0, 2, 1};
  return write_message("patch_body", body) && write_message("patch_stream", stream) && write_message("patch_deformation", weights) &&
         write_message("patch_displacements", displaced) &&
         write_message("patch_effects", PatchEffects{.epoch = 1, .serial = 6, .part = 1, .byte_count = 3, .bytes = {8, 1, 7}}) &&
         write_message("patch_material", PatchMaterial{.epoch = 1, .serial = 5, .stiffness_n_per_m = 300.0, .friction_static = 0.4});
}

// Leaves the messages of target codec as they are, except for their protocol version, the byte at offset 1.
bool renew_codec() {
  for (const auto& entry : std::filesystem::directory_iterator(std::string(HAPTON_SOURCE_DIR) + "/tests/fuzz/corpus/codec")) {
    std::fstream file(entry.path(), std::ios::binary | std::ios::in | std::ios::out);
    static_assert(kProtocolVersion < 128, "the version is one byte");
    file.seekp(1);
    file.put(static_cast<char>(kProtocolVersion));
    if (!file.flush()) {
      std::fprintf(stderr, "cannot write %s\n", entry.path().c_str());
      return false;
    }
  }
  return true;
}

}  // namespace
}  // namespace hapton::fuzz

int main() {
  using namespace hapton::fuzz;
  return FixedRandom::install() && write_sealed() && write_request() && write_patch() && write_codec_parts() && renew_codec() ? 0 : 1;
}
