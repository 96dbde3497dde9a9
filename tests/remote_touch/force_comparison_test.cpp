#include "remote_touch/force_comparison.h"

#include <gtest/gtest.h>

#include <cmath>

namespace hapton {
namespace {

constexpr double kRowPeriodS = 1e-3;
constexpr double kFloorNPerM = 1000.0;
constexpr double kDepthM = 1e-3;

// The device moves down along z to kDepthM below a floor, rests there, and moves up again.
std::vector<ForceRow> press_rows(std::size_t late_rows, const Vec3& added = Vec3::Zero()) {
  std::vector<double> depths;
  for (int i = -20; i <= 100; ++i) depths.push_back(kDepthM * i / 100.0);
  depths.insert(depths.end(), 200, kDepthM);
  for (int i = 100; i >= -20; --i) depths.push_back(kDepthM * i / 100.0);
  depths.insert(depths.end(), late_rows + 10, -0.2 * kDepthM);
  const auto force_at = [&](std::ptrdiff_t i) {
    return Vec3(0.0, 0.0, i < 0 ? 0.0 : kFloorNPerM * std::max(depths[static_cast<std::size_t>(i)], 0.0));
  };
  std::vector<ForceRow> rows;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    const auto at = static_cast<std::ptrdiff_t>(i);
    const Vec3 zero_delay = force_at(at);
    const bool touches = !zero_delay.isZero(0.0);
    rows.push_back({Vec3(0.0, 0.0, -depths[i]), force_at(at - static_cast<std::ptrdiff_t>(late_rows)) + (touches ? added : Vec3::Zero()),
                    zero_delay, std::max(depths[i], 0.0)});
  }
  return rows;
}

TEST(ForceComparison, OfTheSameForceIsZero) {
  const ForceComparison comparison = compare_forces(press_rows(0), kRowPeriodS, 0.05);
  EXPECT_EQ(comparison.error_rms, 0.0);
  EXPECT_EQ(comparison.error_max_n, 0.0);
  EXPECT_EQ(comparison.direction_max_deg, 0.0);
  EXPECT_EQ(comparison.time_offset_s, 0.0);
  EXPECT_EQ(comparison.value_offset, 0.0);
  EXPECT_EQ(comparison.falls, 0U);
  EXPECT_EQ(comparison.generated_j, comparison.zero_delay_generated_j);
  EXPECT_NEAR(comparison.contact_s, 0.4, 2e-3);
}

// The machine stalled for 50 periods while the device rested.
TEST(ForceComparison, PeriodsWithoutARowAddToNoDurationAndNoDelay) {
  auto rows = press_rows(0);
  const double contact_s = compare_forces(rows, kRowPeriodS, 0.05).contact_s;
  rows.erase(rows.begin() + 150, rows.begin() + 200);
  const ForceComparison comparison = compare_forces(rows, kRowPeriodS, 0.05);
  EXPECT_NEAR(comparison.contact_s, contact_s - 50.0 * kRowPeriodS, 1e-9);
  EXPECT_EQ(comparison.error_rms, 0.0);
  EXPECT_EQ(comparison.time_offset_s, 0.0);
}

// The force is a tenth too strong: the errors are a tenth, relative to the root mean square of the force over the contact.
TEST(ForceComparison, AForceThatIsTooStrongByAShareHasThatError) {
  auto rows = press_rows(0);
  double squares = 0.0;
  std::size_t contact_rows = 0;
  double error_sum_n = 0.0;
  std::size_t compared_rows = 0;
  for (ForceRow& row : rows) {
    const double force_n = row.zero_delay_n.norm();
    squares += force_n * force_n;
    contact_rows += force_n > 0.0 ? 1 : 0;
    row.force_n *= 1.1;
    if (1.1 * force_n <= kMinN) continue;
    error_sum_n += 0.1 * force_n;
    ++compared_rows;
  }
  const double rms_n = std::sqrt(squares / static_cast<double>(contact_rows));
  const ForceComparison comparison = compare_forces(rows, kRowPeriodS, 0.0);
  EXPECT_NEAR(comparison.error_rms, 0.1, 1e-12);
  EXPECT_NEAR(comparison.error_max_n, 0.1, 1e-12);
  EXPECT_NEAR(comparison.value_offset, error_sum_n / static_cast<double>(compared_rows) / rms_n, 1e-9);
  EXPECT_EQ(comparison.time_offset_s, 0.0);
  EXPECT_NEAR(comparison.contact_s, kRowPeriodS * static_cast<double>(contact_rows), 1e-12);
  EXPECT_NEAR(comparison.direction_max_deg, 0.0, 1e-9);
  EXPECT_EQ(comparison.falls, 0U);
}

// The force is turned by 45 degrees in some of the rows in which both forces are above kMinN.
TEST(ForceComparison, AnglesAreInDegrees) {
  auto rows = press_rows(0);
  std::size_t compared_rows = 0;
  std::size_t turned_rows = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].zero_delay_n.norm() <= kMinN) continue;
    ++compared_rows;
    if (i % 4 != 0) continue;
    ++turned_rows;
    rows[i].force_n += rows[i].zero_delay_n.norm() * Vec3::UnitY();
  }
  const ForceComparison comparison = compare_forces(rows, kRowPeriodS, 0.0);
  EXPECT_NEAR(comparison.direction_max_deg, 45.0, 1e-9);
  EXPECT_NEAR(comparison.direction_rms_deg, 45.0 * std::sqrt(static_cast<double>(turned_rows) / static_cast<double>(compared_rows)), 1e-6);
}

TEST(ForceComparison, AForceAcrossIsAnErrorOfDirection) {
  const ForceComparison comparison = compare_forces(press_rows(0, Vec3(1.0, 0.0, 0.0)), kRowPeriodS, 0.05);
  EXPECT_NEAR(comparison.error_max_n, 1.0, 1e-12);
  EXPECT_GE(comparison.direction_max_deg, 80.0) << "where the floor pushes lightly";
  EXPECT_GT(comparison.direction_rms_deg, 45.0);
  EXPECT_EQ(comparison.falls, 0U);
}

// At a speed v, the force of a spring k that is late by t absorbs about k v t d less energy down to a depth d, and gives out about k v t d
// more on the way back.
TEST(ForceComparison, ALateForceGivesEnergyAndFallsAtFirst) {
  constexpr std::size_t kLate = 60;
  const ForceComparison comparison = compare_forces(press_rows(kLate), kRowPeriodS, 0.1);
  EXPECT_GT(comparison.time_offset_s, 0.5 * kRowPeriodS * kLate);
  EXPECT_EQ(comparison.falls, 1U);
  EXPECT_NEAR(comparison.fall_s, kRowPeriodS * (kLate - 100.0 * kFallM / kDepthM), 2e-3) << "from kFallM deep until the first force";
  double absorbed_j = 0.0;
  double given_out_j = 0.0;
  const auto rows = press_rows(kLate);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double work = rows[i - 1].force_n.dot(rows[i].p_WD - rows[i - 1].p_WD);
    (work < 0.0 ? absorbed_j : given_out_j) += work;
  }
  EXPECT_NEAR(comparison.generated_j, std::max(given_out_j + absorbed_j, 0.0), 1e-9);
  EXPECT_GT(comparison.generated_j, 0.3 * kFloorNPerM * kDepthM * kDepthM);
  EXPECT_LT(comparison.zero_delay_generated_j, 0.05 * kFloorNPerM * kDepthM * kDepthM);
}

TEST(ForceComparison, AForceOnTheWrongSideIsAFallThrough) {
  auto rows = press_rows(0);
  for (std::size_t i = 200; i < 210; ++i) rows[i].force_n *= -1.0;
  for (std::size_t i = 230; i < 235; ++i) rows[i].force_n.setZero();
  const ForceComparison comparison = compare_forces(rows, kRowPeriodS, 0.05);
  EXPECT_EQ(comparison.falls, 2U);
  EXPECT_NEAR(comparison.fall_s, 0.015, 1e-9);
}

TEST(ForceComparison, WithoutContactThereIsNothingToCompare) {
  const ForceComparison comparison = compare_forces({ForceRow{}, ForceRow{}}, kRowPeriodS, 0.05);
  EXPECT_EQ(comparison.error_rms, 0.0);
  EXPECT_EQ(comparison.contact_s, 0.0);
}

}  // namespace
}  // namespace hapton
