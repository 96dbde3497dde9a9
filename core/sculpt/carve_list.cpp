#include "core/sculpt/carve_list.h"

#include <algorithm>
#include <array>

namespace hapton {
namespace {

using Corner = std::array<int, 3>;

Corner least(const Corner& a, const Corner& b) { return {std::min(a[0], b[0]), std::min(a[1], b[1]), std::min(a[2], b[2])}; }
Corner most(const Corner& a, const Corner& b) { return {std::max(a[0], b[0]), std::max(a[1], b[1]), std::max(a[2], b[2])}; }

bool has_common_nodes(const CarvedFieldBox& a, const CarvedFieldBox& b) {
  return !CarvedFieldBox{most(a.low, b.low), least(a.high, b.high)}.is_empty();
}

CarvedFieldBox join_boxes(const CarvedFieldBox& a, const CarvedFieldBox& b) {
  if (a.is_empty()) return b;
  return b.is_empty() ? a : CarvedFieldBox{least(a.low, b.low), most(a.high, b.high)};
}

}  // namespace

bool CarveList::add(const MadeCarve& added) {
  if (added.serial == 0 || added.serial > kMax) return false;
  if (added.is_undo() && (added.undone.last < added.undone.first || added.undone.last >= added.serial)) return false;
  if (added.serial > newest()) entries_.resize(added.serial);
  Entry& stored = entries_[added.serial - 1];
  if (stored.is_present) return false;
  stored.is_present = true;
  if (added.is_undo()) {
    undo(added.undone);
    return true;
  }
  stored.is_carve = true;
  stored.begins = added.begins;
  stored.object = added.object;
  for (int axis = 0; axis < 3; ++axis) {
    stored.numbers[static_cast<std::size_t>(axis)] = static_cast<float>(added.carve.from_m[axis]);
    stored.numbers[static_cast<std::size_t>(axis) + 3] = static_cast<float>(added.carve.to_m[axis]);
  }
  stored.numbers[6] = static_cast<float>(added.carve.radius_m);
  // The undo of this carve may have arrived before it.
  if (stored.is_undone) return true;
  ++active_count_;
  newest_active_ = std::max(newest_active_, added.serial);
  return true;
}

void CarveList::undo(const CarveRange& range) {
  for (std::uint32_t serial = range.first; !range.is_empty() && serial <= std::min(range.last, newest()); ++serial) {
    active_count_ -= is_active(serial) ? 1 : 0;
    entries_[serial - 1].is_undone = true;
  }
  while (newest_active_ > 0 && !is_active(newest_active_)) --newest_active_;
}

bool CarveList::is_active(std::uint32_t serial) const {
  if (serial == 0 || serial > newest()) return false;
  const Entry& stored = entries_[serial - 1];
  return stored.is_carve && !stored.is_undone;
}

MadeCarve CarveList::entry(std::uint32_t serial) const {
  const Entry& stored = entries_[serial - 1];
  const auto& n = stored.numbers;
  return {.object = stored.object,
          .serial = serial,
          .carve = {.from_m = Vec3(n[0], n[1], n[2]), .to_m = Vec3(n[3], n[4], n[5]), .radius_m = n[6]},
          .begins = stored.begins};
}

CarveRange CarveList::find_press(std::uint32_t serial) const {
  if (serial == 0 || serial > newest() || !entries_[serial - 1].is_carve) return {};
  CarveRange press = {.first = serial, .last = serial};
  while (press.first > 1 && !entries_[press.first - 1].begins) --press.first;
  for (std::uint32_t next = serial + 1; next <= newest() && !entries_[next - 1].begins; ++next) {
    if (entries_[next - 1].is_carve) press.last = next;
  }
  return press;
}

CarvedFieldBox restore_undone(const CarveList& list, int object, const CarveRange& undone, const CarvedField& whole, CarvedField& field) {
  CarvedFieldBox box;
  list.for_each(undone, [&](const MadeCarve& made) {
    if (made.object == object) box = join_boxes(box, field.reach(made.carve));
  });
  if (box.is_empty()) return box;
  field.copy(whole, box);
  list.for_each_active({}, [&](const MadeCarve& made) {
    if (made.object == object && has_common_nodes(field.reach(made.carve), box)) field.carve_within(made.carve, box);
  });
  return box;
}

}  // namespace hapton
