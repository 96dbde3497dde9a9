#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "link/codec.h"
#include "link/session_entry.h"
#include "recording/earlier_carves.h"
#include "recording/haptics_process_count.h"

namespace hapton {

// A move of an object by a program. t_s: when the hub received it, from the beginning of the recording.
struct RecordedMove {
  double t_s = 0.0;
  std::uint64_t sender = 0;
  std::uint32_t process = 0;  // HapticsProcessCount::number
  ObjectMove move;
};

// A carve, or an undo of carves. t_s as above; NaN: it was made before the recording began.
struct RecordedCarve {
  double t_s = 0.0;
  std::uint64_t sender = 0;
  std::uint32_t process = 0;  // HapticsProcessCount::number
  std::uint32_t serial = 0;
  Carves::One carve;
};

// A scene and method with which the forces were computed from t_s on. t_s as above.
struct RecordedSetup {
  double t_s = 0.0;
  std::uint64_t sender = 0;
  HapticsSetup setup;
};

// A column of numbers, the same for the writers of all formats.
template <class Row>
struct ChangeColumn {
  std::string_view name;
  std::string_view unit;
  double (*of)(const Row&);
};
std::span<const ChangeColumn<RecordedMove>> move_columns() noexcept;
std::span<const ChangeColumn<RecordedCarve>> carve_columns() noexcept;

// Collects from the messages of the haptics nodes in a recording: the scenes and methods that were in use, what programs moved and what the
// stylus carved. A repeated message counts once: moves and carves by process and serial, setups by content. RT: no.
class ObjectChanges {
 public:
  // start_ns: the start of the recording.
  explicit ObjectChanges(std::int64_t start_ns) : start_ns_(start_ns) {}

  void add(const SessionEntry& entry, const Datagram* datagram);
  // To be called at the end: puts the carves in the order of their serials, because a lost one was sent again later.
  void finish();

  const std::vector<RecordedSetup>& setups() const noexcept { return setups_; }
  const std::vector<RecordedMove>& moves() const noexcept { return moves_; }
  const std::vector<RecordedCarve>& carves() const noexcept { return carves_; }

 private:
  void add_setup(const HapticsSetup& setup, std::uint64_t sender, double t_s);
  void add_move(const ObjectMove& move, std::uint64_t sender, double t_s);
  void add_carves(const Carves& carves, std::uint64_t sender, double t_s);
  // Larger serials are ignored: a damaged file may name any, and has_carve_ would grow to it. Far above the carves of a session.
  static constexpr std::uint32_t kMaxSerial = std::uint32_t{1} << 24;

  std::int64_t start_ns_;
  HapticsProcessCount processes_;
  std::vector<RecordedSetup> setups_;
  std::uint32_t move_process_ = 0;                      // of the newest move
  std::map<std::int32_t, std::uint32_t> move_serials_;  // the newest, by object
  std::vector<RecordedMove> moves_;
  std::optional<std::uint32_t> carve_process_;  // of the newest Carves
  EarlierCarves earlier_;
  std::vector<bool> has_carve_;  // by serial, of this process
  std::vector<RecordedCarve> carves_;
};

}  // namespace hapton
