// Any bytes as a recorded motion.
#include <cmath>

#include "runtime/trajectory_csv.h"
#include "tests/fuzz/fuzz_target.h"

FUZZ_TARGET(trajectory) {
  using namespace hapton;
  const auto rows = parse_trajectory_csv({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, "a.csv");
  if (!rows) {
    fuzz::require(rows.error().what.starts_with("a.csv"));
    return;
  }
  fuzz::require(!rows->empty());
  for (std::size_t i = 0; i < rows->size(); ++i) {
    const TrajectoryRow& row = (*rows)[i];
    fuzz::require(std::isfinite(row.t_s) && row.p_WD.allFinite() && std::abs(row.q_WT.norm() - 1.0) < 1e-9);
    fuzz::require(i == 0 || row.t_s > (*rows)[i - 1].t_s);
  }
}
