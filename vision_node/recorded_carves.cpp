#include "vision_node/recorded_carves.h"

#include <utility>
#include <vector>

namespace hapton {

void RecordedCarves::show(double t_s) {
  const std::size_t until = count_until(index_.carves(), t_s);
  if (until == applied_carves_) return;
  bool starts_anew = until < applied_carves_;
  std::vector<NumberedCarve> carves;
  for (std::size_t i = starts_anew ? 0 : applied_carves_; i < until; ++i) {
    const CarveNews& news = index_.carves()[i].message;
    if (news.starts_anew) {
      starts_anew = true;
      carves.clear();
    }
    carves.insert(carves.end(), news.carves.begin(), news.carves.end());
  }
  applied_carves_ = until;
  carved_.carve(carves, starts_anew);
}

}  // namespace hapton
