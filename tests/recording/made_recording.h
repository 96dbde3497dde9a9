#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "link/session_codec.h"
#include "tests/recording/made_entries.h"
#include "tests/support/scratch_folder.h"

namespace hapton {

// A recording of four seconds at 1 kHz. Every second sample has a reply. There is contact from 2 s to 3 s, markers at 1 s and 3.5 s, and a
// fault at 2.5 s. The scene is shifted by 0.25 m at 1.5 s, object 1 is held from 0.5 s to 0.8 s, and a program moves object 2 at 1.2 s.
// Object 0 is carved at 1.6 s (and the message repeated), and is whole again from 3.2 s on, in another haptics process. A test can add what
// it needs.
struct MadeRecording {
  std::uint64_t samples = 4000;
  bool has_device = true;  // each cycle contains its sample
  std::string scene = "made.toml";
  std::uint64_t given_hash = 77;
  std::uint32_t scene_loading = 0;
  bool is_carved_before = false;  // the carve was made before the recording, as the forces say
  bool announces_carve = true;    // if it was, a message at 0.05 s says so, too
  std::uint64_t lost_from = 0;    // the samples from this one to the one before lost_to are missing
  std::uint64_t lost_to = 0;
  bool has_replies = true;
  Vec3 written_nm = Vec3::Zero();                // torque on the motors, in each cycle
  std::vector<std::uint64_t> marks_at = {};      // more markers, at these samples
  std::int64_t slower_ns = 0;                    // the reply to each fourth sample comes this much later than the others
  std::function<void(std::uint64_t)> also = {};  // called after each sample

  std::uint64_t session = kSession;  // session in the headers of the datagrams

  static constexpr std::uint64_t kSession = 0xAB;
  static constexpr std::uint64_t kHaptics = 2;
  static constexpr std::uint64_t kVision = 3;

  std::filesystem::path write(const ScratchFolder& scratch) {
    bytes = std::string(kSessionMagic);
    codec.append(SessionHeader{.build = "b1", .start_ns = kCyclesStartNs, .session = kSession}, bytes);
    add_setup(0);
    for (std::uint64_t sample = 1; sample <= samples; ++sample) {
      if (sample >= lost_from && sample < lost_to) continue;
      add_sample(sample);
      add_events(sample);
      if (also) also(sample);
    }
    return scratch.write("made.hapton", bytes);
  }

  // The hub receives a message at the time of a sample, or delay_ns after it.
  void receive(std::uint64_t sender, const Message& message, std::uint64_t sample, std::int64_t delay_ns = 0) {
    add(SessionEntry::Kind::received, sender, message, sample_ns(sample) + delay_ns);
  }

  // The hub sends a probe state to a vision node.
  void notice(const ProbeState& state, std::uint64_t sample) { add(SessionEntry::Kind::sent, 1, state, sample_ns(sample)); }

  static Carves through_middle(std::uint32_t source, std::uint32_t serial) {
    Carves carves{.source = source, .newest = serial, .first = serial, .count = 1};
    carves.carves[0] = {.object = 0, .from_m = {0.0F, 0.01F, -0.04F}, .to_m = {0.0F, 0.01F, 0.04F}, .radius_m = 0.006F};
    return carves;
  }

 private:
  void add(SessionEntry::Kind kind, std::uint64_t sender, const Message& message, std::int64_t time_ns) {
    SessionEntry entry;
    entry.kind = kind;
    entry.time_ns = time_ns + 300'000;
    const Datagram datagram{{.session = session, .sender = sender, .sequence = ++sequence}, message};
    entry.datagram = std::span(wire).first(datagram_codec.encode(datagram, wire));
    codec.append(entry, bytes);
  }

  void add_setup(std::uint64_t sample) {
    HapticsSetup setup{.method_serial = 1, .scene_hash = 5, .scene_loading = scene_loading};
    std::strncpy(setup.scene.data(), scene.c_str(), setup.scene.size() - 1);
    std::strncpy(setup.method.data(), "name=proxy probe_radius_m=0.004", setup.method.size() - 1);
    receive(kHaptics, setup, sample);
    receive(kVision, SceneFacts{.given_hash = 99}, sample);
    receive(kHaptics, SceneFacts{.given_hash = given_hash}, sample);
  }

  void add_sample(std::uint64_t sample) {
    SessionEntry cycle = cycle_of(sample);
    if (!has_device) cycle.cycle.device.reset();
    cycle.cycle.written_nm = written_nm;
    codec.append(cycle, bytes);
    if (sample % 2 != 0 || !has_replies) return;
    ForceCommand force = force_of(sample);
    force.contact = sample >= 2000 && sample < 3000;
    if (!force.contact) {
      force.visual_offset_m.setZero();
      force.object = -1;
    }
    force.view_revision = sample >= 1500 ? 4 : 0;
    force.scene_time_ns = static_cast<std::int64_t>(sample) * 1'000'000;
    force.carve_serial = (is_carved_before || sample > 1600) && sample <= 3200 ? 1 : 0;
    receive(kHaptics, force, sample, sample % 4 == 0 ? slower_ns : 0);
  }

  void add_events(std::uint64_t sample) {
    if (std::ranges::count(marks_at, sample) > 0) codec.append(marker_of(sample, "one more"), bytes);
    if (sample == 1000) codec.append(marker_of(sample, "trial 7"), bytes);
    if (sample == 3500) codec.append(marker_of(sample, "trial 8"), bytes);
    if (sample == 1500) receive(kVision, ViewTransform{4, {1, 0, 0, 0.25F, 0, 1, 0, 0, 0, 0, 1, 0}}, sample);
    if (sample == 500 || sample == 600) receive(kHaptics, ObjectPose{.serial = 1, .object = 1, .is_held = true}, sample);
    if (sample == 700) receive(kVision, ObjectPose{.serial = 9, .object = 1}, sample);
    if (sample == 800) receive(kHaptics, ObjectPose{.serial = 2, .object = 1, .p_m = Vec3(0.0, 0.05, 0.0)}, sample);
    if (sample == 1200 || sample == 2200) {
      receive(kHaptics,
              ObjectMove{
                  .source = 6, .serial = 1, .object = 2, .start_ns = 1'200'000'000, .end_ns = 1'700'000'000, .to_p_m = Vec3(0.0, 0.1, 0.0)},
              sample);
    }
    if (sample == 50 && is_carved_before && announces_carve) receive(kHaptics, Carves{.source = 8, .newest = 1}, sample);
    if (sample == 1600 || sample == 1700) receive(kHaptics, through_middle(8, 1), sample);
    if (sample == 3200) receive(kHaptics, Carves{.source = 9}, sample);
    if (sample == 2499) {
      SessionEntry fault;
      fault.kind = SessionEntry::Kind::fault;
      fault.time_ns = sample_ns(sample) + 400'000;
      fault.fault = SessionFault::clamped;
      codec.append(fault, bytes);
    }
    if (sample == 100 || sample == 2600) {
      notice(ProbeState{.status = sample == 100 ? ProbeStatus::ok : ProbeStatus::fault_latched}, sample);
    }
  }

  std::string bytes;
  std::uint64_t sequence = 0;
  SessionCodec codec;
  Codec datagram_codec;
  std::array<std::byte, kMaxDatagramBytes> wire;
};

}  // namespace hapton
