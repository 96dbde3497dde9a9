#include "bench/measure/mesh_rows.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace hapton {
namespace {

const NumberRow& find(const std::vector<NumberRow>& rows, const std::string& metric) {
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const NumberRow& row) { return row.metric == metric; });
  EXPECT_NE(found, rows.end()) << metric;
  return found == rows.end() ? rows.front() : *found;
}

std::vector<MeshFigures> three_meshes() {
  std::vector<MeshFigures> all(3);
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].mesh = std::string(1, static_cast<char>('a' + i));
    all[i].contact.count = 100;
    all[i].contact.p99_ns = 1000.0 * static_cast<double>(3 - i);
    all[i].over_100us = i;
    all[i].error.error.most = 0.01 * static_cast<double>(i);
  }
  return all;
}

TEST(MeshRows, NameTheWorstMeshBesideTheMedian) {
  const std::vector<NumberRow> rows = rows_over_meshes(three_meshes(), {});
  EXPECT_EQ(find(rows, "p99, median mesh").ours, 2000.0);
  EXPECT_TRUE(find(rows, "p99, median mesh").mesh.empty());
  EXPECT_EQ(find(rows, "p99, worst mesh").ours, 3000.0);
  EXPECT_EQ(find(rows, "p99, worst mesh").mesh, "a");
  EXPECT_FALSE(find(rows, "p99, worst mesh").is_met());
  EXPECT_EQ(find(rows, "steps above 100 us").ours, 3.0);
  EXPECT_EQ(find(rows, "max, worst mesh").ours, 2.0);
  EXPECT_EQ(find(rows, "max, worst mesh").mesh, "c");
}

TEST(MeshRows, FrictionHasNoErrorGoalButNoStepMayTakeLong) {
  std::vector<MeshFigures> all = three_meshes();
  for (MeshFigures& one : all) one.friction = true;
  const std::vector<NumberRow> rows = rows_over_meshes(all, {});
  EXPECT_FALSE(find(rows, "max, worst mesh").target.has_value());
  EXPECT_EQ(find(rows, "steps above 100 us").target, 0.0);
}

TEST(MeshRows, StateTheCausesOfSwitchesAndWhatConvergedStepsDo) {
  std::vector<MeshFigures> all = three_meshes();
  using Cause = BranchSwitch::Cause;
  all[0].error.switches = {{.cause = Cause::unconverged}, {.cause = Cause::unconverged}, {.cause = Cause::unexplained}};
  all[2].error.switches = {{.cause = Cause::unconverged}, {.cause = Cause::unsettled}};
  all[0].error.branch_switches = 3;
  all[2].error.branch_switches = 2;
  all[1].error.stuck_steps = 4;
  all[1].converged.discontinuities = 1;
  all[1].converged.error.most = 0.005;
  const std::vector<NumberRow> rows = rows_over_meshes(all, {});
  const std::string note = find(rows, "max, worst mesh").note;
  EXPECT_NE(note.find("5 branch switches"), std::string::npos) << note;
  EXPECT_NE(note.find("3 unconverged, 1 where the reference has not settled, 1 unexplained"), std::string::npos) << note;
  EXPECT_EQ(find(rows, "max, every step converged, worst mesh").ours, 0.5);
  EXPECT_EQ(find(rows, "fall-throughs, false contacts, stuck steps, force discontinuities").ours, 4.0);
  EXPECT_EQ(find(rows, "fall-throughs, false contacts, stuck steps, force discontinuities, every step converged").ours, 1.0);
}

TEST(MeshRows, OneMeshHasItsOwnRows) {
  MeshFigures one;
  one.mesh = "rough";
  one.contact.p50_ns = 140.0;
  const std::vector<NumberRow> rows = rows_of_mesh(one, {});
  EXPECT_TRUE(find(rows, "p50").is_met());
  EXPECT_NE(rows[0].what.find("rough"), std::string::npos);
}

}  // namespace
}  // namespace hapton
