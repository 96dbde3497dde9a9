#include "devices/dhd_library.h"

#include <gtest/gtest.h>

#include <string>

namespace hapton::dhd {
namespace {

// The limits are those that docs/vendor-devices.md lists: limits above a device's own would overheat its motors.
TEST(DhdLibrary, EachTypeHasTheLimitsOfTheDocument) {
  struct Row {
    int type;
    const char* name;
    double max_force_n, continuous_force_n, max_torque_nm;
    Vec3 half_workspace_m;
  };
  const Vec3 omega(0.08, 0.055, 0.08), delta(0.18, 0.13, 0.18), sigma(0.095, 0.065, 0.095), lambda(0.12, 0.1, 0.1), small(0.05, 0.05, 0.05);
  const Row rows[] = {{33, "omega.3", 12, 6, 0, omega},        {34, "omega.6", 12, 6, 0, omega},
                      {36, "omega.6 (left)", 12, 6, 0, omega}, {35, "omega.7", 12, 6, 0, omega},
                      {37, "omega.7 (left)", 12, 6, 0, omega}, {63, "delta.3", 20, 10, 0, delta},
                      {104, "sigma.7", 20, 10, 0.4, sigma},    {105, "sigma.7 (left)", 20, 10, 0.4, sigma},
                      {108, "lambda.7", 20, 10, 0, lambda},    {109, "lambda.7 (left)", 20, 10, 0, lambda},
                      {60, "Falcon", 8, 4, 0, small}};
  for (const Row& row : rows) {
    const System& system = find_system(row.type);
    EXPECT_EQ(system.name, row.name);
    EXPECT_EQ(system.max_force_n, row.max_force_n) << row.name;
    EXPECT_EQ(system.continuous_force_n, row.continuous_force_n) << row.name;
    EXPECT_EQ(system.max_torque_nm, row.max_torque_nm) << row.name;
    EXPECT_EQ(system.half_workspace_m, row.half_workspace_m) << row.name;
  }
}

TEST(DhdLibrary, AnUnknownTypeHasNoNameAndTheLowestLimits) {
  for (const int type : {0, 1, 32, 38, 61, 110, -1, -2}) {
    const System& system = find_system(type);
    EXPECT_EQ(system.name, "") << type;
    EXPECT_EQ(system.max_force_n, 3.0) << type;
    EXPECT_EQ(system.continuous_force_n, 1.5) << type;
    EXPECT_EQ(system.max_torque_nm, 0.0) << type;
  }
}

TEST(DhdLibrary, EachCauseOfAReleaseHasItsWords) {
  EXPECT_EQ(name_of_force_off_cause(0), "none");
  EXPECT_EQ(name_of_force_off_cause(1), "its force button");
  EXPECT_EQ(name_of_force_off_cause(2), "the arm moved faster than its velocity threshold");
  EXPECT_EQ(name_of_force_off_cause(3), "its watchdog: no force had come in time");
  EXPECT_EQ(name_of_force_off_cause(5), "its USB cable was pulled");
  EXPECT_EQ(name_of_force_off_cause(6), "its dead-man switch");
  for (const int unknown : {-1, 7, 1000}) EXPECT_EQ(name_of_force_off_cause(unknown), "an unknown cause") << unknown;
}

}  // namespace
}  // namespace hapton::dhd
