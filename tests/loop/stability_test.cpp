#include "loop/stability.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "loop/passivity.h"

namespace hapton {
namespace {

SampledPlant ideal(double mass_kg, double damping, double stiffness, double period_s, double delay_s) {
  return SampledPlant(make_axis_plant({.mass_kg = mass_kg, .damping_ns_per_m = damping}, {.stiffness_n_per_m = stiffness}), period_s,
                      delay_s);
}

struct Cell {
  double mass_kg, damping, stiffness, delay_s, expected, linear_rule;
};

// Largest stable stiffness from the eigenvalues of the exactly sampled loop at 1 kHz, worked out elsewhere and rounded to 1 N/m.
constexpr Cell kCells[] = {
    {0.875, 5.5, 30.0, 0.0, 11'012.0, 11'000.0},
    {0.875, 5.5, 30.0, 0.1, 63.0, 55.0},
    {0.225, 5.0, 500.0, 0.01, 513.0, 476.0},
    {0.225, 5.0, 500.0, 0.1, 359.0, 50.0},
};

TEST(StableStiffness, AgreesWithCellsWorkedOutElsewhere) {
  for (const Cell& cell : kCells) {
    const SampledPlant plant = ideal(cell.mass_kg, cell.damping, cell.stiffness, 1e-3, cell.delay_s);
    EXPECT_EQ(std::round(find_stable_stiffness(plant, 0.0).value), cell.expected);
    EXPECT_EQ(std::round(find_stable_stiffness_by_eigenvalues(plant, 0.0, 1.0, 1.1)), cell.expected);
    EXPECT_EQ(std::round(linear_rule_n_per_m(cell.damping, 1e-3, cell.delay_s)), cell.linear_rule);
  }
}

}  // namespace
}  // namespace hapton
