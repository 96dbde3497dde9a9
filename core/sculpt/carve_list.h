#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/sculpt/carve.h"
#include "core/sculpt/carved_field.h"

namespace hapton {

// Serials first to last; empty: first is 0.
struct CarveRange {
  std::uint32_t first = 0;
  std::uint32_t last = 0;

  bool is_empty() const { return first == 0; }
  friend bool operator==(const CarveRange&, const CarveRange&) = default;
};

// An entry of the list of what was done to the bodies of a scene: a carve, or the undo of earlier carves.
struct MadeCarve {
  int object = -1;           // number in the scene; of an undo -1
  std::uint32_t serial = 0;  // counts all entries, from 1
  Carve carve = {};          // rounded(); of an undo without radius
  bool begins = false;       // the first carve of a press of the button
  CarveRange undone = {};    // of an undo: the carves that count no longer; empty: this is a carve

  bool is_undo() const { return !undone.is_empty(); }
};

// What was done to the bodies of a scene, by serial. The shape of a body is that of its mesh without the carves that are in the list and
// not undone: it depends neither on the order in which entries come nor on repetitions. RT: no. Threads: one at a time. Source: decision
// 192.
class CarveList {
 public:
  static constexpr std::uint32_t kMax = 1'000'000;  // larger serials are left out

  void clear() { *this = {}; }
  // False: it is in the list already, its serial is beyond kMax, or an undo names carves after itself.
  bool add(const MadeCarve& entry);

  // Counts carves as undone before the entry that says so is there.
  void undo(const CarveRange& range);

  // The largest serial in the list.
  std::uint32_t newest() const { return static_cast<std::uint32_t>(entries_.size()); }
  // It is a carve in the list that is not undone.
  bool is_active(std::uint32_t serial) const;
  // The largest serial of these; 0: there is none.
  std::uint32_t newest_active() const { return newest_active_; }
  // Of all carves that are not undone.
  std::uint32_t count_active() const { return active_; }

  // The carves of one press of the button, of which the carve with that serial is one: from the one that begins it to the last before the
  // next press. Empty: it is not a carve in the list.
  CarveRange find_press(std::uint32_t serial) const;

  // Calls visit(const MadeCarve&) for the active carves in the range, in order. A range that begins with 0 is that of all.
  template <class Visit>
  void for_each_active(const CarveRange& range, Visit&& visit) const {
    for (std::uint32_t serial = range.is_empty() ? 1 : range.first; serial <= last_of(range); ++serial) {
      if (is_active(serial)) visit(entry(serial));
    }
  }
  // The same for all carves, also those that are undone.
  template <class Visit>
  void for_each(const CarveRange& range, Visit&& visit) const {
    for (std::uint32_t serial = range.is_empty() ? 1 : range.first; serial <= last_of(range); ++serial) {
      if (entries_[serial - 1].is_carve) visit(entry(serial));
    }
  }

 private:
  // The numbers as messages have them: a million carves are 36 MB.
  struct Kept {
    std::array<float, 7> numbers = {};  // of from_m, to_m and radius_m
    std::int32_t object = -1;
    bool is_there = false;
    bool is_carve = false;
    bool begins = false;
    bool is_undone = false;
  };

  std::uint32_t last_of(const CarveRange& range) const { return range.is_empty() || range.last > newest() ? newest() : range.last; }
  MadeCarve entry(std::uint32_t serial) const;

  std::vector<Kept> entries_;  // by serial - 1
  std::uint32_t newest_active_ = 0;
  std::uint32_t active_ = 0;
};

// Puts the material back that the carves in `undone` removed from an object: its field is then what its other active carves make of
// `whole`, to the last bit. Returns a box around all nodes that may have changed; empty if none of these carves was of this object. Pre:
// the list has the undo, `whole` is the field before any carve, and `field` has all active carves. Time: that of the active carves near the
// undone ones. RT: no.
CarvedFieldBox restore_undone(const CarveList& list, int object, const CarveRange& undone, const CarvedField& whole, CarvedField& field);

}  // namespace hapton
