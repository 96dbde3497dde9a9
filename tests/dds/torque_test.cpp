// A rigid tool over DDS: the torque that another DDS implementation reads is the one on the motors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#if defined(HAPTON_WITH_DDS) && defined(HAPTON_WITH_FAST_DDS)

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/dds/bridge.h"
#include "tests/dds/fast_node.h"
#include "tests/process/trajectory_session.h"

namespace hapton::dds_test {
namespace {

using process::System;
using process::TrajectorySession;
using Numbers = std::array<double, 6>;

// The force and torque on the motors in each cycle of a table that `hapton session export` wrote.
std::set<Numbers> read_written(const std::string& csv) {
  std::istringstream lines(csv);
  std::string line;
  const auto cells_of = [](const std::string& text) {
    std::vector<std::string> cells(1);
    for (const char c : text) c == ',' ? (void)cells.emplace_back() : cells.back().push_back(c);
    return cells;
  };
  std::getline(lines, line);
  const std::vector<std::string> names = cells_of(line);
  std::set<Numbers> written;
  while (std::getline(lines, line)) {
    const std::vector<std::string> cells = cells_of(line);
    Numbers row = {};
    constexpr std::array kColumns = {"written_x_n", "written_y_n", "written_z_n", "written_tx_nm", "written_ty_nm", "written_tz_nm"};
    for (std::size_t i = 0; i < names.size() && i < cells.size(); ++i) {
      const auto column = std::find(kColumns.begin(), kColumns.end(), names[i]);
      if (column != kColumns.end()) row[static_cast<std::size_t>(column - kColumns.begin())] = std::stod(cells[i]);
    }
    written.insert(row);
  }
  return written;
}

// Half of the peg is beyond the edge of a block when it is pressed down, so that it tilts.
TEST(DdsTorque, AWrenchIsTheForceAndTheTorqueOnTheMotors) {
  TrajectorySession session("simulated-6dof",
                            "t_s,x_m,y_m,z_m,qw,qx,qy,qz\n0,0,0.014,0.06,0.99995,0.01,0,0\n1,0,0.014,0.024,0.99995,0.01,0,0\n"
                            "60,0,0.014,0.024,0.99995,0.01,0,0\n",
                            "pegs.toml", {"--vision-rate", "2000"});
  ASSERT_TRUE(System::wait_until([&] { return session.io.out().find("hub on ") != std::string::npos || !session.io.is_running(); }));
  Bridge bridge(session.hub, session.scratch.path(), {}, "127.0.0.1");
  ASSERT_TRUE(bridge.is_publishing()) << bridge.err();
  FastNode ros(domain());
  ros.subscribe("rt/hapton/measured_cf", kWrench);
  std::vector<Numbers> wrenches;
  std::size_t with_torque = 0;
  EXPECT_TRUE(System::wait_until([&] {
    for (const auto& bytes : ros.take("rt/hapton/measured_cf")) {
      const auto numbers = FastNode::read_stamped(bytes, 6).numbers;
      wrenches.push_back({});
      std::copy(numbers.begin(), numbers.end(), wrenches.back().begin());
      with_torque += std::hypot(numbers[3], numbers[4], numbers[5]) > 0.001 ? 1 : 0;
    }
    return with_torque > 500;
  })) << session.haptics.err();
  bridge.end();
  session.end();
  const std::string table = (session.scratch.path() / "table").string();
  const auto exported =
      process::run("hapton", {"session", "export", session.file, "--format", "csv", "--out", table}, session.scratch.path());
  ASSERT_TRUE(exported && exported->exit_code == 0);
  const std::set<Numbers> written = read_written(process::read_text(session.scratch.path() / "table" / "session.csv"));
  // A cycle is recorded at its end: if a force came late, another force was on the motors before that in the same cycle.
  const auto matching = std::count_if(wrenches.begin(), wrenches.end(), [&](const Numbers& wrench) { return written.contains(wrench); });
  EXPECT_GT(static_cast<double>(matching), 0.95 * static_cast<double>(wrenches.size())) << "to the last bit";
}

}  // namespace
}  // namespace hapton::dds_test

#endif
