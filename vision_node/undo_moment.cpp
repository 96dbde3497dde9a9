#include "vision_node/undo_moment.h"

#include <algorithm>
#include <array>
#include <map>

namespace hapton {
namespace {

using Place = std::array<double, 4>;  // number of the carved object, and where the carve begins

Place place_of(int object, const Carve& carve) {
  return {static_cast<double>(object), carve.from_m.x(), carve.from_m.y(), carve.from_m.z()};
}

// The serials of the list's carves by their places, in ascending order for each place.
std::map<Place, std::vector<std::uint32_t>> list_places(const CarveList& list) {
  std::map<Place, std::vector<std::uint32_t>> places;
  list.for_each({}, [&](const MadeCarve& made) { places[place_of(made.object, made.carve)].push_back(made.serial); });
  return places;
}

}  // namespace

// Both lists are in the order of the actions, so the search for a press begins after the press before it. Carves that change nothing are
// not in the list, so a press is found by its first carve that is.
CarveMoments::CarveMoments(const CarveList& list, std::uint32_t source, const std::vector<CarvedPress>& saved) : source_(source) {
  serials_.assign(1, 0);
  if (saved.empty()) return;
  const auto places = list_places(list);
  for (const CarvedPress& press : saved) {
    std::uint32_t last = serials_.back();
    for (const Carve& carve : press.carves) {
      const auto at = places.find(place_of(press.object, carve));
      if (at == places.end()) continue;
      const auto next = std::upper_bound(at->second.begin(), at->second.end(), last);
      if (next == at->second.end()) continue;
      last = list.find_press(*next).last;
      break;
    }
    serials_.push_back(last);
  }
}

std::uint32_t CarveMoments::find_serial(const UndoMoment& moment) const {
  return std::max(moment.source == source_ ? moment.serial : 0, serials_[std::min(moment.saved_presses, serials_.size() - 1)]);
}

}  // namespace hapton
