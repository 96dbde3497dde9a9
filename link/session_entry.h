#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/math/types.h"
#include "link/endpoint.h"
#include "link/messages.h"

namespace hapton {

// Why cycles were left out.
enum class MissCause : std::uint8_t {
  none,
  late_wake_up,     // the loop was waiting in time and woke late
  device_slow,      // reading and writing the device took more than half a period
  work_long,        // the loop's own work took too long
  machine_stalled,  // late by more than any work of the loop takes: the process or the machine was stopped
};
std::string_view to_string(MissCause cause) noexcept;

// What makes the flight recorder write.
enum class SessionFault : std::uint8_t {
  none,
  command_timeout,  // no force for 20 ms, in contact
  not_finite,       // a force that is not finite
  rejected_future,  // a force for a sample that was not taken
  clamped,          // a force above the limit
  stalled,          // the loop stopped for longer than the command timeout
  device,           // the device failed
  overrun,          // a cycle was missed under --overrun stop
  speed,            // from here on the faults latched by the safety governor (safety/safety_fault.h)
  position,
  jump,
  thermal,
  torque,
  energy,  // not latched: the energy budget has taken all force away
};
std::string_view to_string(SessionFault fault) noexcept;

// What a cycle read from the device: the device point D and the stylus T. Frame: W (world). Units: m.
struct CycleSample {
  std::int64_t time_ns = 0;  // hub's clock
  Vec3 p_WD = Vec3::Zero();
  Quat q_WT = Quat::Identity();
  std::uint32_t buttons = 0;
};

// The force that io_node computed for a sample from parts of the scene, before the governor. N, m, frame W.
struct CycleLocal {
  Vec3 force_n = Vec3::Zero();
  Vec3 visual_offset_m = Vec3::Zero();  // probe minus device point
  std::int32_t object = -1;             // number of the touched object in the scene; -1: none, or an older recording
};

// One cycle of the servo, noted at its end. Forces: N, frame W.
struct CycleNote {
  std::uint64_t sample = 0;
  std::int64_t late_ns = 0;        // from its tick until it began
  Vec3 written_n = Vec3::Zero();   // force on the motors
  Vec3 written_nm = Vec3::Zero();  // torque on the motors
  std::uint32_t missed = 0;        // cycles left out before this one
  MissCause cause = MissCause::none;
  std::optional<CycleSample> device = {};  // none in older recordings
  std::optional<CycleLocal> local = {};    // none: the force is remote
};

// A marker, at the sample that was the newest when the hub received it.
struct MarkerNote {
  std::uint64_t sample = 0;
  NodeRole source = NodeRole::tool;
  std::string_view text = {};  // MarkerText::is_valid; not owned
};

// What happened at a sample, for export to other file formats.
struct SessionEvent {
  std::string_view kind;
  std::string name;
  std::uint64_t sample = 0;
};

// A shape that a program gave to an object, for export to other file formats.
struct SessionShape {
  std::uint32_t process = 0;  // counts the haptics processes of the recording, from 0
  ShapeStart start;
  std::span<const ShapePart::Displacement> displacements_m = {};  // one for each vertex; empty: a part is not in the recording; not owned
};

// One thing that happened in a recorded session.
struct SessionEntry {
  enum class Kind : std::uint8_t {
    received,
    sent,
    cycle,
    fault,
    dropped,
    marker,
    end,  // the last entry; SessionReader::next() does not return it
  };
  Kind kind = Kind::received;
  std::int64_t time_ns = 0;             // hub's clock
  Address peer;                         // set for received and sent
  std::span<const std::byte> datagram;  // set for received and sent: as it is before sealing and after opening; not owned
  CycleNote cycle;
  SessionFault fault = SessionFault::none;
  MarkerNote marker;
  std::uint64_t dropped = 0;  // entries that found no room since the previous entry of this kind
};

// The header before the entries.
struct SessionHeader {
  std::string build = {};
  std::int64_t start_ns = 0;
  std::int64_t start_unix_ns = 0;
  std::uint64_t session = 0;
  std::string fault = {};  // why a flight record was written; empty: a whole session
  std::vector<std::pair<std::string, std::string>> settings = {};
  bool has_end = false;  // a complete file ends with an entry of kind `end`; older recordings have none
};

}  // namespace hapton
