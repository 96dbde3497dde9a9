#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/sculpt/carve.h"
#include "core/sculpt/carved_field.h"

namespace hapton {

// The serials of a carve list from first to last, both included. If first is 0, the range is empty.
struct CarveRange {
  std::uint32_t first = 0;
  std::uint32_t last = 0;

  bool is_empty() const { return first == 0; }
  friend bool operator==(const CarveRange&, const CarveRange&) = default;
};

// An entry of the list of what was done to the bodies of a scene: a carve, or the undo of earlier carves.
struct MadeCarve {
  int object = -1;           // number in the scene of the carved object; an undo has -1
  std::uint32_t serial = 0;  // number of this entry among all entries, from 1
  Carve carve = {};          // as rounded() returns it; an undo has the radius 0
  bool begins = false;       // whether this is the first carve of a press of the button
  CarveRange undone = {};    // the serials of the carves that this undo undoes; empty: this is a carve

  bool is_undo() const { return !undone.is_empty(); }
};

// What was done to the bodies of a scene, by serial. The shape of a body is that of its mesh without the carves that are in the list and
// not undone: it depends neither on the order in which entries come nor on repetitions. RT: no. Threads: one at a time. Source: decision
// 192.
class CarveList {
 public:
  static constexpr std::uint32_t kMax = 1'000'000;  // add() rejects larger serials

  void clear() { *this = {}; }
  // False, without effect: the serial is 0, above kMax or in the list already; or the range of an undo is reversed or not all before it.
  bool add(const MadeCarve& entry);

  // Marks the carves with these serials as undone, before the list has the entry of their undo. Serials above newest() are ignored.
  void undo(const CarveRange& range);

  // The largest serial in the list.
  std::uint32_t newest() const { return static_cast<std::uint32_t>(entries_.size()); }
  // Whether the entry with this serial is an active carve: one that is in the list and not undone.
  bool is_active(std::uint32_t serial) const;
  // The largest serial of an active carve; 0: there is none.
  std::uint32_t newest_active() const { return newest_active_; }
  // The number of active carves.
  std::uint32_t count_active() const { return active_count_; }

  // The press of the button to which the carve with this serial belongs: from the carve that begins the press to the last carve before the
  // next press. Empty: the list has no carve with this serial.
  CarveRange find_press(std::uint32_t serial) const;

  // Calls visit(const MadeCarve&) for the active carves in the range, in the order of their serials. An empty range stands for all serials.
  template <class Visit>
  void for_each_active(const CarveRange& range, Visit&& visit) const {
    for (std::uint32_t serial = range.is_empty() ? 1 : range.first; serial <= last_of(range); ++serial) {
      if (is_active(serial)) visit(entry(serial));
    }
  }
  // Like for_each_active, but for all carves in the list, also those that are undone.
  template <class Visit>
  void for_each(const CarveRange& range, Visit&& visit) const {
    for (std::uint32_t serial = range.is_empty() ? 1 : range.first; serial <= last_of(range); ++serial) {
      if (entries_[serial - 1].is_carve) visit(entry(serial));
    }
  }

 private:
  // An entry, with its numbers in single precision as in messages: a million entries take 36 MB.
  struct Entry {
    std::array<float, 7> numbers = {};  // from_m, to_m, radius_m
    std::int32_t object = -1;
    bool is_present = false;
    bool is_carve = false;
    bool begins = false;
    bool is_undone = false;
  };

  std::uint32_t last_of(const CarveRange& range) const { return range.is_empty() || range.last > newest() ? newest() : range.last; }
  MadeCarve entry(std::uint32_t serial) const;

  std::vector<Entry> entries_;  // the index is serial - 1
  std::uint32_t newest_active_ = 0;
  std::uint32_t active_count_ = 0;
};

// Puts the material back that the carves in `undone` removed from an object. `field` then equals, bit for bit, `whole` with the object's
// remaining active carves. Returns a box around all nodes that may have changed; empty if no carve in `undone` carved this object. Pre:
// the list has the undo, `whole` is the field before any carve, and `field` has all active carves. Time: repeating the active carves near
// the undone ones, and one pass over the list. RT: no.
CarvedFieldBox restore_undone(const CarveList& list, int object, const CarveRange& undone, const CarvedField& whole, CarvedField& field);

}  // namespace hapton
