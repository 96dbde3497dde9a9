#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "link/known_carves.h"
#include "link/messages.h"
#include "link/session_reader.h"
#include "recording/cycle_table.h"
#include "recording/earlier_carves.h"
#include "recording/shape_index.h"
#include "recording/timed.h"

namespace hapton {

// Summary of a part of a recording, RecordingIndex::kSpanS long.
struct RecordingSpan {
  std::int64_t number = 0;     // the span begins number * kSpanS after the start of the recording
  std::uint32_t samples = 0;   // number of samples of the device
  float written_n = 0.0F;      // largest force on the motors
  float round_trip_s = -1.0F;  // longest one; below 0: no force came
  bool is_contact = false;     // there was contact in at least one sample
};

// A marker, or the faults, at a sample.
struct RecordingMark {
  double t_s = 0.0;
  std::string text;
  bool is_fault = false;
};

// An ObjectMove without its name, as there may be very many.
struct IndexedMove {
  std::uint32_t source = 0;
  std::uint32_t serial = 0;
  std::int32_t object = 0;
  std::int64_t start_ns = 0;
  std::int64_t end_ns = 0;
  Vec3 from_p_m = Vec3::Zero();
  Quat from_q = Quat::Identity();
  Vec3 to_p_m = Vec3::Zero();
  Quat to_q = Quat::Identity();

  static IndexedMove of(const ObjectMove& move) {
    return {move.source, move.serial, move.object, move.start_ns, move.end_ns, move.from_p_m, move.from_q, move.to_p_m, move.to_q};
  }
  ObjectMove to_message() const {
    return {.source = source,
            .serial = serial,
            .object = object,
            .start_ns = start_ns,
            .end_ns = end_ns,
            .from_p_m = from_p_m,
            .from_q = from_q,
            .to_p_m = to_p_m,
            .to_q = to_q};
  }
};

// An entry of Carves with its serial.
struct NumberedCarve {
  std::uint32_t serial = 0;
  Carves::One carve;
};

// The entries of Carves that one message added.
struct CarveNews {
  bool starts_anew = false;  // another haptics process: all entries before are void
  std::vector<NumberedCarve> carves;
};

// The state of the device in the ProbeState of a vision node.
struct DeviceNotice {
  ProbeStatus status = ProbeStatus::ok;
  std::uint32_t energy_percent = 0;
  float force_limit_n = 0.0F;
  friend bool operator==(const DeviceNotice&, const DeviceNotice&) = default;
};

// The time line of a recording: spans, marks, and the messages that set a state until the next one of their kind. Its size grows by 1.2 kB
// a second and with the number of these messages, not with the samples. Times: seconds since the beginning of the recording
// (SessionHeader::start_ns), as in the tables that `hapton session export` writes. RT: no. Threads: const calls from any number.
class RecordingIndex {
 public:
  static constexpr double kSpanS = 0.02;  // resolution of plots and time line: about a frame

  // Reads everything that can be read; SessionReader::problem() then says whether the file was complete. Error, one line: the recording has
  // no sample of the device.
  static Result<RecordingIndex> read(SessionReader& reader);

  // Times of the first and the last sample.
  double begin_s() const { return begin_s_; }
  double end_s() const { return end_s_; }
  // Sorted by number. There is no span for times without a sample.
  std::span<const RecordingSpan> spans() const { return spans_; }
  // The spans that overlap [from_s, to_s].
  std::span<const RecordingSpan> spans_between(double from_s, double to_s) const;
  // The markers and faults, in ascending order of time.
  std::span<const RecordingMark> marks() const { return marks_; }
  // The position (SessionReader::seek) at which to begin reading in order to get the samples from that time on.
  std::uint64_t find_position(double t_s) const;

  // The newest pose of the static scene until that time that has this revision. If revision is none, or not found: the newest pose until
  // that time, or else the first one. The identity if the recording has no pose.
  Pose find_view(std::optional<std::uint32_t> revision, double t_s) const;
  // The newest setup until that time, or else the first one; null: the recording has none.
  const HapticsSetup* find_setup(double t_s) const;
  // The newest notice until that time; null: there is none.
  const DeviceNotice* find_notice(double t_s) const;
  // The newest Scene::given_hash of the haptics node until that time, or else the first one; 0: not known.
  std::uint64_t find_scene_hash(double t_s) const;
  // Poses of objects that the stylus picked up, and moves of objects by programs, in ascending order of time.
  std::span<const Timed<ObjectPose>> poses() const { return poses_; }
  std::span<const Timed<IndexedMove>> moves() const { return moves_; }
  // Carves in order of time. Repeated messages are left out, but an entry that came early may be here twice (KnownCarves). What was
  // carved before the recording began is in the first one.
  std::span<const Timed<CarveNews>> carves() const { return carves_; }
  // The shapes of objects that programs deform.
  const ShapeIndex& shapes() const { return shapes_; }

 private:
  struct View {
    std::uint32_t revision = 0;
    std::array<float, 12> X_WS = {};
    friend bool operator==(const View&, const View&) = default;
  };
  // A position in the file at which reading can begin.
  struct SeekPoint {
    double t_s = 0.0;
    std::uint64_t position = 0;  // SessionReader::position()
  };

  // The last message about an object by a haptics process, which repeats it once a second.
  struct MessageId {
    std::uint64_t process = 0;  // ObjectMove::source, or the sender; another process has its own serials
    std::uint32_t serial = 0;
    friend bool operator==(const MessageId&, const MessageId&) = default;
  };

  // False: the message is a repetition.
  static bool note_message(std::map<std::int32_t, MessageId>& last, std::int32_t object, const MessageId& id);
  void add_row(const CycleRow& row);
  void add_received(const Datagram& datagram, double t_s, std::uint64_t position);
  void add_view(const View& view, double t_s);
  void add_carves(const Carves& carves, double t_s);
  bool is_haptics(std::uint64_t sender) const;

  double begin_s_ = 0.0;
  double end_s_ = 0.0;
  std::vector<RecordingSpan> spans_;
  std::vector<RecordingMark> marks_;
  std::vector<SeekPoint> seek_points_;
  std::vector<Timed<View>> views_;
  std::vector<Timed<HapticsSetup>> setups_;
  std::vector<Timed<DeviceNotice>> notices_;
  std::vector<Timed<std::uint64_t>> scene_hashes_;
  std::vector<Timed<ObjectPose>> poses_;
  std::vector<Timed<IndexedMove>> moves_;
  std::vector<Timed<CarveNews>> carves_;
  ShapeIndex shapes_;
  std::map<std::int32_t, MessageId> last_poses_;  // by object
  std::map<std::int32_t, MessageId> last_moves_;  // likewise
  KnownCarves known_carves_;
  EarlierCarves earlier_;
  bool is_first_carver_ = true;                 // the newest carves are of the first haptics process
  std::vector<std::uint64_t> haptics_senders_;  // sender numbers of the haptics nodes
};

}  // namespace hapton
