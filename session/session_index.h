#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "link/known_carves.h"
#include "link/messages.h"
#include "link/session_reader.h"
#include "session/joined_table.h"

namespace hapton {

// What happened in a short time of a recording.
struct SessionSpan {
  std::int64_t number = 0;     // it begins number * kSpanS after the recording's start
  std::uint32_t samples = 0;   // of the device
  float written_n = 0.0F;      // largest force on the motors
  float round_trip_s = -1.0F;  // longest; below 0: no force came
  bool is_contact = false;     // in one of its samples
};

// A marker, or faults, at a sample.
struct SessionMark {
  double t_s = 0.0;
  std::string text;
  bool is_fault = false;
};

// What a node said, and when the hub had it.
template <class Message>
struct Timed {
  double t_s = 0.0;
  Message message;
};

// Of what was said, in the order of its times, so much was said until then.
template <class Message>
std::size_t count_until(std::span<const Timed<Message>> all, double t_s) {
  return static_cast<std::size_t>(std::ranges::upper_bound(all, t_s, {}, &Timed<Message>::t_s) - all.begin());
}

// What the stylus carved.
struct CarveNews {
  bool starts_anew = false;  // by another haptics process: what was carved before is whole again
  std::vector<Carves::One> carves;
};

// What the hub told a vision node about the device.
struct DeviceNotice {
  ProbeStatus status = ProbeStatus::ok;
  std::uint32_t energy_percent = 0;
  float force_limit_n = 0.0F;
  friend bool operator==(const DeviceNotice&, const DeviceNotice&) = default;
};

// The time line of a recording, and what applies from a moment on until something else is said. Its size grows with the duration, by 1.2 kB
// a second, and with what was said, not with the samples. Times: seconds from the beginning of the recording (SessionHeader::start_ns),
// those of the tables that `hapton session export` writes. RT: no.
class SessionIndex {
 public:
  static constexpr double kSpanS = 0.02;

  // Reads everything that can be read; the reader then knows whether that was all. Error, one line: no sample of the device is in it.
  static Result<SessionIndex> read(SessionReader& reader);

  // Of the first and the last sample.
  double begin_s() const { return begin_s_; }
  double end_s() const { return end_s_; }
  // Sorted by number; times without a sample have none.
  std::span<const SessionSpan> spans() const { return spans_; }
  // Those that overlap the given times.
  std::span<const SessionSpan> spans_between(double from_s, double to_s) const;
  // In the order of their times.
  std::span<const SessionMark> marks() const { return marks_; }
  // Where to begin reading for the samples from that time on, a position of SessionReader.
  std::uint64_t find_position(double t_s) const;

  // The pose of the static scene of that revision, as it was known at that time; none: the newest one then.
  Pose find_view(std::optional<std::uint32_t> revision, double t_s) const;
  // The newest until then, or the first one; null: there is none.
  const HapticsSetup* find_setup(double t_s) const;
  // The newest until then; null: none.
  const DeviceNotice* find_notice(double t_s) const;
  // Scene::given_hash of the haptics node, the newest until then or the first one; 0: not known.
  std::uint64_t find_scene_hash(double t_s) const;
  // Of objects that the stylus picked up, and that programs moved, in the order of their times.
  std::span<const Timed<ObjectPose>> poses() const { return poses_; }
  std::span<const Timed<ObjectMove>> moves() const { return moves_; }
  // Without repetitions, as far as the serials tell.
  std::span<const Timed<CarveNews>> carves() const { return carves_; }

 private:
  struct View {
    std::uint32_t revision = 0;
    std::array<float, 12> X_WS = {};
    friend bool operator==(const View&, const View&) = default;
  };
  struct Place {
    double t_s = 0.0;
    std::uint64_t position = 0;
  };

  void add_row(const JoinedRow& row);
  void add_received(const Datagram& datagram, double t_s);
  void add_view(const View& view, double t_s);
  void add_carves(const Carves& carves, double t_s);
  bool is_haptics(std::uint64_t sender) const;

  double begin_s_ = 0.0;
  double end_s_ = 0.0;
  std::vector<SessionSpan> spans_;
  std::vector<SessionMark> marks_;
  std::vector<Place> places_;
  std::vector<Timed<View>> views_;
  std::vector<Timed<HapticsSetup>> setups_;
  std::vector<Timed<DeviceNotice>> notices_;
  std::vector<Timed<std::uint64_t>> scene_hashes_;
  std::vector<Timed<ObjectPose>> poses_;
  std::vector<Timed<ObjectMove>> moves_;
  std::vector<Timed<CarveNews>> carves_;
  KnownCarves known_carves_;
  std::vector<std::uint64_t> haptics_;  // senders
};

}  // namespace hapton
