#include "bench/measure/mesh_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

std::vector<MeshFigures> measure(const MeshRunSettings& settings) {
  const NamedMesh mesh{"bumpy", std::make_shared<TriangleMesh>(make_bumpy_sphere(0.045, 0.2, 1000, 3))};
  auto made = measure_mesh(settings, Stopwatch::calibrate(), mesh, [](const std::string&) {});
  EXPECT_TRUE(made.has_value());
  return std::move(*made);
}

const MeshRunSettings kSmall{.seeds = {1, 2}, .steps = 600, .repetitions = 1, .windows = 2, .window_steps = 30};

TEST(MeshRun, MeasuresEachProbeWithAndWithoutFriction) {
  const std::vector<MeshFigures> figures = measure(kSmall);
  ASSERT_EQ(figures.size(), 4u);
  for (const MeshFigures& f : figures) {
    EXPECT_GT(f.contact.count, 600u);
    EXPECT_GE(f.contact.worst_ns, f.contact.p99_ns);
    EXPECT_GE(f.over_10us, f.over_50us);
    EXPECT_GE(f.over_50us, f.over_100us);
    EXPECT_GT(f.facets_crossed, 5u);
    EXPECT_GT(f.ns_per_facet, 0.0);
    EXPECT_EQ(f.error.steps, 2u * 2u * 30u);
    EXPECT_GT(f.error.contact_steps, 100u);
    EXPECT_EQ(f.error.fall_throughs, 0u);
    EXPECT_EQ(f.converged.steps, f.error.steps);
    EXPECT_EQ(f.switches.size(), f.error.branch_switches);
    if (!f.friction) {
      EXPECT_LT(f.error.error.p50, 1e-6) << f.probe_radius_m;
    }
  }
}

TEST(MeshRun, TheSeedChoosesTheWindows) {
  const std::vector<MeshFigures> once = measure(kSmall), again = measure(kSmall);
  MeshRunSettings other = kSmall;
  other.seeds = {3, 4};
  const std::vector<MeshFigures> with_other_seeds = measure(other);
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(once[i].error.error.rms, again[i].error.error.rms);
    EXPECT_EQ(once[i].facets_crossed, again[i].facets_crossed);
    EXPECT_NE(once[i].error.error.rms, with_other_seeds[i].error.error.rms);
  }
}

TEST(MeshRun, MedianAndWorstOverMeshes) {
  std::vector<MeshFigures> figures(4);
  for (std::size_t i = 0; i < figures.size(); ++i) {
    figures[i].mesh = std::string(1, static_cast<char>('a' + i));
    figures[i].ns_per_facet = std::vector<double>{3.0, 9.0, 1.0, 4.0}[i];
  }
  const MedianAndWorst both = over_meshes(figures, [](const MeshFigures& f) { return f.ns_per_facet; });
  EXPECT_EQ(both.median, 4.0);
  EXPECT_EQ(both.worst, 9.0);
  EXPECT_EQ(both.worst_mesh, "b");
}

TEST(MeshRun, TextCsvAndJsonNameEveryMesh) {
  std::vector<MeshFigures> figures(2);
  figures[0].mesh = "one";
  figures[1].mesh = "two";
  const std::string csv = to_csv(figures);
  std::istringstream lines(csv);
  std::string header, line;
  std::getline(lines, header);
  while (std::getline(lines, line))
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), std::count(header.begin(), header.end(), ',')) << line;
  const nlohmann::ordered_json json = to_json(figures);
  ASSERT_EQ(json.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(json[i]["mesh"], figures[i].mesh);
    EXPECT_NE(csv.find("\n" + figures[i].mesh + ","), std::string::npos) << csv;
    EXPECT_NE(to_text(figures).find(figures[i].mesh), std::string::npos);
  }
}

TEST(MeshRun, EverySwitchIsARowWithItsCause) {
  std::vector<MeshFigures> figures(2);
  figures[1].mesh = "two";
  figures[1].probe_radius_m = 0.0005;
  figures[1].friction = true;
  figures[1].converged.error.most = 0.25;
  figures[1].converged.stuck_steps = 7;
  figures[1].switches = {{3, 120, {4, 2, 0.5, BranchSwitch::Cause::unconverged}}, {4, 30, {50, 1, 0.02, BranchSwitch::Cause::unexplained}}};
  EXPECT_EQ(switches_to_csv(figures),
            "mesh,probe_radius_m,friction,seed,step,steps,error_max,cause\n"
            "two,0.0005,1,3,120,2,0.5,unconverged\n"
            "two,0.0005,1,4,30,1,0.02,unexplained\n");
  const nlohmann::ordered_json json = to_json(figures);
  EXPECT_EQ(json[0]["switches"].size(), 0u);
  EXPECT_EQ(json[1]["switches"][0]["cause"], "unconverged");
  EXPECT_EQ(json[1]["switches"][1]["step"], 30);
  EXPECT_EQ(json[1]["converged"]["max"], 0.25);
  EXPECT_EQ(json[1]["converged"]["faults"], 7);
}

}  // namespace
}  // namespace hapton
