#include "tests/process/system.h"

#include <gtest/gtest.h>
#include <signal.h>

#include <fstream>

namespace hapton::process {
namespace {

// A cube of 0.1 m, and a motion that is 2 mm below its top for half of the time: contact comes soon, whenever the nodes start.
void write_cube_scene(const std::filesystem::path& folder) {
  std::ofstream(folder / "cube.obj") << "v -0.05 -0.05 -0.05\nv 0.05 -0.05 -0.05\nv 0.05 0.05 -0.05\nv -0.05 0.05 -0.05\n"
                                        "v -0.05 -0.05 0.05\nv 0.05 -0.05 0.05\nv 0.05 0.05 0.05\nv -0.05 0.05 0.05\n"
                                        "f 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\n"
                                        "f 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n";
  std::ofstream(folder / "cube.toml") << "[[object]]\nmesh = \"cube.obj\"\nunit = \"m\"\n";
  std::ofstream(folder / "taps.csv")
      << "t_s,x_m,y_m,z_m\n0,0.01,0.02,0.06\n0.2,0.01,0.02,0.048\n0.6,0.012,0.02,0.048\n0.8,0.01,0.02,0.06\n";
}

}  // namespace

System::System(std::vector<std::string> io_options) : io_options_(std::move(io_options)) { write_cube_scene(folder_.path()); }

std::int64_t count(const Json& report, const std::string& name) { return report.at("counters").at(name).get<std::int64_t>(); }

bool has_contact(const Json& report) { return count(report, "contact_samples") > 0; }
bool is_drawn(const Json& report) { return count(report, "drawn") > 0; }

void expect_sane(const Json& report) {
  ASSERT_TRUE(report.is_object()) << report;
  EXPECT_EQ(report.at("schema"), "hapton.report/4");
  EXPECT_EQ(report.at("program"), "io_node");
  EXPECT_GT(report.at("seconds").get<double>(), 0.0);
  for (const auto& [name, value] : report.at("counters").items()) EXPECT_GE(value.get<std::int64_t>(), 0) << name;
  for (const char* never : {"not_finite", "duplicate", "unknown_echo", "rejected_future", "bad_settings"})
    EXPECT_EQ(count(report, never), 0) << never;
  EXPECT_LE(count(report, "forces"), count(report, "states_sent"));
  EXPECT_LE(count(report, "contact_samples"), count(report, "forces"));
  for (const auto& [name, hop] : report.at("hops").items()) {
    if (hop.at("n") == 0) continue;
    double last_us = 0.0;
    for (const char* quantile : {"p50_us", "p90_us", "p99_us", "p99_9_us"}) {
      EXPECT_GE(hop.at(quantile).get<double>(), last_us) << name << " " << quantile;
      last_us = hop.at(quantile);
    }
    // A quantile is read from a bucket of 1.6 % width, the maximum is exact.
    EXPECT_LE(last_us, 1.02 * hop.at("max_us").get<double>()) << name;
  }
}

#ifdef HAPTON_WITH_VISION
const std::vector<std::string> kNodes = {"haptics_node", "io_node", "vision_node"};
bool is_complete(const Json& report) { return has_contact(report) && is_drawn(report); }
#else
const std::vector<std::string> kNodes = {"haptics_node", "io_node"};
bool is_complete(const Json& report) { return has_contact(report); }
#endif

}  // namespace hapton::process
