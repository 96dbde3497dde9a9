#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "link/codec.h"
#include "link/session_entry.h"

namespace hapton {

// A move of an object by a program. t_s: when the hub had it, from the beginning of the recording.
struct RecordedMove {
  double t_s = 0.0;
  std::uint64_t sender = 0;
  std::uint32_t process = 0;  // counts the haptics processes of the recording, from 0: in another one objects are at rest again
  ObjectMove move;
};

// A carve, or an undo of carves. t_s as above; NaN: it was made before the recording began.
struct RecordedCarve {
  double t_s = 0.0;
  std::uint64_t sender = 0;
  std::uint32_t process = 0;  // as above: in another one bodies are whole again
  std::uint32_t serial = 0;
  Carves::One carve;
};

// From t_s on, as above, the forces were computed with this scene and method.
struct RecordedSetup {
  double t_s = 0.0;
  std::uint64_t sender = 0;
  HapticsSetup setup;
};

// A column of numbers, for every writer.
template <class Row>
struct ChangeColumn {
  std::string_view name;
  std::string_view unit;
  double (*of)(const Row&);
};
std::span<const ChangeColumn<RecordedMove>> move_columns() noexcept;
std::span<const ChangeColumn<RecordedCarve>> carve_columns() noexcept;

// Which scene and method a recording has, what programs moved in it and the stylus carved, from what haptics nodes announced: each once, by
// process and serial. RT: no.
class ObjectChanges {
 public:
  // start_ns: of the recording.
  explicit ObjectChanges(std::int64_t start_ns) : start_ns_(start_ns) {}

  void add(const SessionEntry& entry, const Datagram* datagram);
  // At the end: puts the carves in the order of their serials. What was lost at first was sent again later.
  void finish();

  const std::vector<RecordedSetup>& setups() const noexcept { return setups_; }
  const std::vector<RecordedMove>& moves() const noexcept { return moves_; }
  const std::vector<RecordedCarve>& carves() const noexcept { return carves_; }

 private:
  void add_setup(const HapticsSetup& setup, std::uint64_t sender, double t_s);
  void add_move(const ObjectMove& move, std::uint64_t sender, double t_s);
  void add_carves(const Carves& carves, std::uint64_t sender, double t_s);
  // A file may name any serial.
  static constexpr std::uint32_t kMaxSerial = std::uint32_t{1} << 24;

  std::int64_t start_ns_;
  std::vector<RecordedSetup> setups_;
  std::uint32_t move_source_ = 0;
  std::uint32_t move_process_ = 0;
  std::map<std::int32_t, std::uint32_t> move_serials_;  // the newest, by object
  std::vector<RecordedMove> moves_;
  std::uint32_t carve_source_ = 0;
  std::uint32_t carve_process_ = 0;
  std::uint32_t made_before_ = 0;  // carves of this process up to this serial were made before the recording
  std::vector<bool> has_carve_;    // by serial, of this process
  std::vector<RecordedCarve> carves_;
};

}  // namespace hapton
