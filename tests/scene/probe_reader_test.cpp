#include "scene/probe_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scene/probe_tables.h"
#include "scene/scene_file.h"
#include "scene/scene_report.h"
#include "tests/scene/sample_files.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

std::vector<ProbeSpec> read_probe_text(const std::string& text) {
  const auto table = parse_toml(text);
  EXPECT_TRUE(table);
  auto probes = read_probes(*table);
  EXPECT_TRUE(probes) << (probes ? "" : probes.error().what);
  return probes ? *probes : std::vector<ProbeSpec>();
}

std::string error_of_probes(const std::string& text) {
  const auto table = parse_toml(text);
  if (!table) return table.error().what;
  const auto probes = read_probes(*table);
  return probes ? "it was read" : probes.error().what;
}

const std::string kTwoProbes =
    "[[probe]]\nname = 'left'\n[[probe]]\nname = 'right'\nradius_m = 0.003\nmethod = 'reference'\nshading = 0.5\n";

TEST(ProbeReader, ReadsEveryKeyAndLeavesOutWhatIsNotGiven) {
  const auto probes = read_probe_text(kTwoProbes);
  ASSERT_EQ(probes.size(), 2U);
  EXPECT_EQ(probes[0].name, "left");
  EXPECT_FALSE(probes[0].radius_m || probes[0].method || probes[0].shading);
  EXPECT_EQ(probes[1].radius_m, 0.003);
  EXPECT_EQ(probes[1].method, "reference");
  EXPECT_EQ(probes[1].shading, 0.5);
  EXPECT_EQ(probes[1].line, 3U);
  EXPECT_TRUE(read_probe_text("fit_m = [1, 1, 1]\n").empty());
}

TEST(ProbeReader, IsFoundByItsNameOrIsTheFirst) {
  const auto probes = read_probe_text(kTwoProbes);
  EXPECT_EQ(*find_probe(probes, ""), &probes[0]);
  EXPECT_EQ(*find_probe(probes, "right"), &probes[1]);
  EXPECT_EQ(*find_probe({}, ""), nullptr);
  EXPECT_THAT(find_probe(probes, "rihgt").error().what, HasSubstr("no [[probe]] named 'rihgt'; did you mean 'right'?"));
  EXPECT_THAT(find_probe({}, "left").error().what, HasSubstr("no [[probe]] named 'left': add it"));
}

TEST(ProbeReader, SaysHowItTouches) {
  const auto probes = read_probe_text(kTwoProbes + "[[probe]]\nname = 'tip'\nradius_m = 0\n");
  EXPECT_EQ(describe(probes[0]), "probe 'left'");
  EXPECT_EQ(describe(probes[1]), "probe 'right': radius 0.003 m, method reference, shading 0.5");
  EXPECT_EQ(describe(probes[2]), "probe 'tip': a point");
}

TEST(ProbeReader, NamesLineKeyAndWhatIsAllowed) {
  EXPECT_THAT(error_of_probes("[probe]\nname = 'a'\n"), HasSubstr("line 1: 'probe' must be tables that begin with [[probe]]"));
  EXPECT_THAT(error_of_probes("[[probe]]\nradius_m = 1\n"), HasSubstr("[[probe]] 1 has no 'name': add it"));
  EXPECT_THAT(error_of_probes("[[probe]]\nname = ''\n"), HasSubstr("line 2: 'name' in [[probe]] 1 has 0 bytes: give 1 to 60"));
  EXPECT_THAT(error_of_probes("[[probe]]\nname = 'a'\nradius = 1\n"),
              HasSubstr("unknown key 'radius' in [[probe]] 1; did you mean 'radius_m'?"));
  EXPECT_THAT(error_of_probes("[[probe]]\nname = 'a'\nradius_m = -1\n"), HasSubstr("line 3: 'radius_m' in [[probe]] 1 is -1"));
  EXPECT_THAT(error_of_probes("[[probe]]\nname = 'a'\nradius_m = 1.5\n"), HasSubstr("line 3: 'radius_m' in [[probe]] 1 is 1.5"));
  EXPECT_THAT(error_of_probes("[[probe]]\nname = 'a'\nshading = 2\n"), HasSubstr("'shading' in [[probe]] 1 is 2"));
  EXPECT_THAT(error_of_probes("[[probe]]\nname = 'a'\nmethod = 'smoth'\n"),
              HasSubstr("line 3: 'method' in [[probe]] 1 is 'smoth': choose one of proxy, reference, smooth, sweep"));
  EXPECT_THAT(error_of_probes(kTwoProbes + "[[probe]]\nname = 'left'\n"), HasSubstr("line 8: there are two probes named 'left'"));
}

// The probes of a scene file change neither its shapes nor its hash, which haptics node and vision node compare.
TEST(ProbeReader, IsNoPartOfTheSceneButOfItsReport) {
  const ScratchFolder folder;
  folder.write("a.obj", sample::obj(sample::tetrahedron()));
  const auto without_probes = load_scene(folder.write("plain.toml", "[[object]]\nmesh = 'a.obj'\n"));
  const auto file = folder.write("two.toml", "[[object]]\nmesh = 'a.obj'\n" + kTwoProbes);
  const auto with_probes = load_scene(file);
  ASSERT_TRUE(without_probes && with_probes) << (with_probes ? "" : with_probes.error().what);
  EXPECT_EQ(without_probes->given_hash, with_probes->given_hash);
  const auto report = make_scene_report(file);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_THAT(to_text(*report), HasSubstr("\nprobe 'left'\nprobe 'right': radius 0.003 m, method reference, shading 0.5\n"));
  EXPECT_THAT(to_json(*report), HasSubstr("\"radius_m\": 0.003"));
  const auto wrong = load_scene(folder.write("wrong.toml", "[[object]]\nmesh = 'a.obj'\n[[probe]]\nname = 'a'\nmethod = 'magic'\n"));
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().what, HasSubstr("wrong.toml: line 5: 'method' in [[probe]] 1"));
}

}  // namespace
}  // namespace hapton
