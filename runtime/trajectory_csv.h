#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/math/types.h"

namespace hapton {

// One step of a recorded or planned motion, of the device point D and the stylus T. Frame W, metres, seconds; q_WT is of unit length.
struct TrajectoryRow {
  double t_s = 0.0;
  Vec3 p_WD = Vec3::Zero();
  Quat q_WT = Quat::Identity();
  std::uint32_t buttons = 0;  // held down from this row to the next, one bit each, lowest first
  bool has_turn = false;      // the file gives q_WT, even if it is the identity
};

// Reads the project's trajectory format: a header line `t_s,x_m,y_m,z_m` or `t_s,x_m,y_m,z_m,qw,qx,qy,qz`, either of them optionally with
// `,buttons`, `,sample` or both at its end, in this order (`sample` joins the rows with other tables, and is ignored), one row per step,
// `#` comments and empty lines anywhere, LF or CRLF. Strict: every field is a finite number and nothing else, positions within 1,000 km of
// the origin and times within 30 years of zero (beyond, the unit is another one or the file damaged), times increasing, quaternions of unit
// length within 1 % (they are normalised), at least one row, at most 16 GiB. Error: one line that names the file, the line and the column.
// RT: set-up only; about 10 million numbers a second.
Result<std::vector<TrajectoryRow>> read_trajectory_csv(const std::string& path);

// The same from text in memory; name is used for the file in errors.
Result<std::vector<TrajectoryRow>> parse_trajectory_csv(std::string_view text, const std::string& name);

// The times and positions as text of such a file, which reads back equal to the bit. RT: set-up only.
std::string positions_to_csv(const std::vector<TrajectoryRow>& rows);

}  // namespace hapton
