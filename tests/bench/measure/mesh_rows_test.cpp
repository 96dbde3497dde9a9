#include "bench/measure/mesh_rows.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace hapton {
namespace {

const NumberRow& find_row(const std::vector<NumberRow>& rows, const std::string& metric) {
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const NumberRow& row) { return row.metric == metric; });
  EXPECT_NE(found, rows.end()) << metric;
  return found == rows.end() ? rows.front() : *found;
}

std::vector<MeshFigures> three_meshes() {
  std::vector<MeshFigures> figures(3);
  for (std::size_t i = 0; i < figures.size(); ++i) {
    figures[i].mesh = std::string(1, static_cast<char>('a' + i));
    figures[i].contact.count = 100;
    figures[i].contact.p99_ns = 1000.0 * static_cast<double>(3 - i);
    figures[i].over_100us = i;
    figures[i].error.error.most = 0.01 * static_cast<double>(i);
  }
  return figures;
}

TEST(MeshRows, NameTheWorstMeshBesideTheMedian) {
  const std::vector<NumberRow> rows = rows_over_meshes(three_meshes(), {});
  EXPECT_EQ(find_row(rows, "p99, median mesh").ours, 2000.0);
  EXPECT_TRUE(find_row(rows, "p99, median mesh").mesh.empty());
  EXPECT_EQ(find_row(rows, "p99, worst mesh").ours, 3000.0);
  EXPECT_EQ(find_row(rows, "p99, worst mesh").mesh, "a");
  EXPECT_FALSE(find_row(rows, "p99, worst mesh").is_met());
  EXPECT_EQ(find_row(rows, "steps above 100 us").ours, 3.0);
  EXPECT_EQ(find_row(rows, "max, worst mesh").ours, 2.0);
  EXPECT_EQ(find_row(rows, "max, worst mesh").mesh, "c");
}

TEST(MeshRows, FrictionHasNoErrorGoalButNoStepMayTakeLong) {
  std::vector<MeshFigures> figures = three_meshes();
  for (MeshFigures& one : figures) one.friction = true;
  const std::vector<NumberRow> rows = rows_over_meshes(figures, {});
  EXPECT_FALSE(find_row(rows, "max, worst mesh").target.has_value());
  EXPECT_EQ(find_row(rows, "steps above 100 us").target, 0.0);
}

TEST(MeshRows, StateTheCausesOfSwitchesAndWhatConvergedStepsDo) {
  std::vector<MeshFigures> figures = three_meshes();
  using Cause = BranchSwitch::Cause;
  figures[0].error.switches = {{.cause = Cause::unconverged}, {.cause = Cause::unconverged}, {.cause = Cause::unexplained}};
  figures[2].error.switches = {{.cause = Cause::unconverged}, {.cause = Cause::unsettled}};
  figures[0].error.branch_switches = 3;
  figures[2].error.branch_switches = 2;
  figures[1].error.stuck_steps = 4;
  figures[1].converged.discontinuities = 1;
  figures[1].converged.error.most = 0.005;
  const std::vector<NumberRow> rows = rows_over_meshes(figures, {});
  const std::string note = find_row(rows, "max, worst mesh").note;
  EXPECT_NE(note.find("5 branch switches"), std::string::npos) << note;
  EXPECT_NE(note.find("3 unconverged, 1 where the reference has not settled, 1 unexplained"), std::string::npos) << note;
  EXPECT_EQ(find_row(rows, "max, every step converged, worst mesh").ours, 0.5);
  EXPECT_EQ(find_row(rows, "fall-throughs, false contacts, stuck steps, force discontinuities").ours, 4.0);
  EXPECT_EQ(find_row(rows, "fall-throughs, false contacts, stuck steps, force discontinuities, every step converged").ours, 1.0);
}

TEST(MeshRows, OneMeshHasItsOwnRows) {
  MeshFigures one;
  one.mesh = "rough";
  one.contact.p50_ns = 140.0;
  const std::vector<NumberRow> rows = rows_of_mesh(one, {});
  EXPECT_TRUE(find_row(rows, "p50").is_met());
  EXPECT_NE(rows[0].what.find("rough"), std::string::npos);
}

}  // namespace
}  // namespace hapton
