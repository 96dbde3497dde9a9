#include "scene/texture_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "tests/scene/made_texture_file.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(TextureFile, ReadsModelsAndTriangles) {
  for (const std::size_t ma : {std::size_t{18}, std::size_t{0}}) {
    const auto nine = made::nine_models(20, ma);
    const auto read = parse_texture(made::texture_file(nine, made::eight_triangles(), 2000.0));
    ASSERT_TRUE(read) << read.error().what;
    EXPECT_EQ(read->rate_hz(), 2000.0);
    ASSERT_EQ(read->models().size(), nine.size());
    for (std::size_t m = 0; m < nine.size(); ++m) {
      const TextureModel& model = read->models()[m];
      EXPECT_NEAR(model.speed_m_per_s, nine[m].speed_m_per_s, 1e-9) << "mm/s in the file";
      EXPECT_NEAR(model.force_n, nine[m].force_n, 1e-9);
      EXPECT_NEAR(model.variance, nine[m].variance, 1e-9);
      EXPECT_NEAR(model.gain, ma == 0 ? 1.0 : nine[m].gain, 1e-9) << "of the MA part";
      ASSERT_EQ(model.ar.size(), 20U);
      ASSERT_EQ(model.ma.size(), ma);
      for (std::size_t i = 0; i < 20; ++i) EXPECT_NEAR(model.ar[i], nine[m].ar[i], 1e-9);
      for (std::size_t i = 0; i < ma; ++i) EXPECT_NEAR(model.ma[i], nine[m].ma[i], 1e-9);
    }
    const auto triangles = made::eight_triangles();
    EXPECT_TRUE(std::equal(triangles.begin(), triangles.end(), read->triangles().begin(), read->triangles().end()));
  }
}

// The file with the first `from` replaced by `to`.
std::string changed_file(const std::string& from, const std::string& to) {
  std::string text = made::texture_file();
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string texture_error(const std::string& text) {
  const auto read = parse_texture(text);
  if (read) return "it was read";
  EXPECT_EQ(read.error().what.find('\n'), std::string::npos) << read.error().what;
  return read.error().what;
}

TEST(TextureFile, SaysInOneLineWhatIsBroken) {
  EXPECT_THAT(texture_error("not XML"), HasSubstr("is not XML"));
  EXPECT_THAT(texture_error(made::texture_file().substr(0, 2000)), HasSubstr("is not XML"));
  EXPECT_THAT(texture_error("<tapSet></tapSet>"), HasSubstr("its root is <tapSet>, not <modelSet>"));
  EXPECT_THAT(texture_error("<!-- nothing -->"), HasSubstr("its root is <>"));
  EXPECT_THAT(texture_error("<modelSet/>"), AllOf(StartsWith("line 1: "), HasSubstr("no <SampleRate>")));
  EXPECT_THAT(texture_error(changed_file("<SpeedUnits>mm/s", "<SpeedUnits>m/s")),
              AllOf(StartsWith("line 5: "), HasSubstr("'m/s': convert the models to mm/s")));
  EXPECT_THAT(texture_error(changed_file("<ForceUnits>N", "<ForceUnits>lbf")), HasSubstr("'lbf': convert the models to N"));
  EXPECT_THAT(texture_error(changed_file("m/s^2", "g")), HasSubstr("'g': convert the models to m/s^2"));
  EXPECT_THAT(texture_error(changed_file("<SampleRate>1000", "<SampleRate>0")), HasSubstr("sample rate is 0 Hz"));
  EXPECT_THAT(texture_error(changed_file("<SampleRate>1000", "<SampleRate>often")),
              AllOf(StartsWith("line 7: "), HasSubstr("<SampleRate> is 'often'")));
  EXPECT_THAT(texture_error(changed_file("<numMod>9", "<numMod>10")), HasSubstr("there are 9 <model>s, but <numMod> is 10"));
  EXPECT_THAT(texture_error(changed_file("<numTri>8", "<numTri>7")), HasSubstr("there are 8 <tri>s, but <numTri> is 7"));
  EXPECT_THAT(texture_error(changed_file("<numARCoeff>20", "<numARCoeff>21")), HasSubstr("there are 20 <value>s, but <numARCoeff> is 21"));
  EXPECT_THAT(texture_error(changed_file("<numMACoeff>18", "<numMACoeff>17")), HasSubstr("there are 18 <value>s, but <numMACoeff> is 17"));
  EXPECT_THAT(texture_error(changed_file("<numMod>9", "<numMod>2.5")), HasSubstr("must be a whole number"));
  EXPECT_THAT(texture_error(changed_file("<numMod>9", "<numMod>1e18")), HasSubstr("must be a whole number"));
  EXPECT_THAT(texture_error(changed_file("<numMod>9", "<numMod>1001")),
              AllOf(StartsWith("line 10: "), HasSubstr("<numMod> is 1001: it must be a whole number from 0 to 1000")));
  EXPECT_THAT(texture_error(changed_file("<numMod>9", "<numMod>1000")), HasSubstr("there are 9 <model>s, but <numMod> is 1000"));
  EXPECT_THAT(texture_error(changed_file("<numMod>9", "<numMod>0")), HasSubstr("there are 9 <model>s, but <numMod> is 0"));
  EXPECT_THAT(texture_error(changed_file("<numMod>9", "<numMod>-1")), HasSubstr("<numMod> is -1: it must be a whole number"));
  EXPECT_THAT(texture_error(changed_file("<value>1</value>", "<value>10</value>")),
              HasSubstr("<tri> names model 10: give numbers from 1 to 9"));
  EXPECT_THAT(texture_error(changed_file("<value>1</value>", "<value>1.5</value>")), HasSubstr("<tri> names model 1.5"));
  EXPECT_THAT(texture_error(changed_file("<value>1</value>", "<value>0</value>")), HasSubstr("<tri> names model 0: give"));
  EXPECT_THAT(texture_error(changed_file("<value>1</value>", "<value>0.5</value>")), HasSubstr("<tri> names model 0.5"));
  EXPECT_THAT(texture_error(changed_file("<value>1</value>", "<value>-1</value>")), HasSubstr("<tri> names model -1"));
  EXPECT_THAT(texture_error(changed_file("      <value>1</value>\n", "")), HasSubstr("<tri> has 2 <value>s"));
  EXPECT_THAT(texture_error(changed_file("      <value>1</value>\n", "<value>1</value><value>1</value>")),
              HasSubstr("<tri> has 4 <value>s"));
  EXPECT_THAT(texture_error(changed_file("<value>1</value>", "<value>2</value>")), HasSubstr("triangle 1 has no area"));
  EXPECT_THAT(texture_error(changed_file("<var>0.000000000", "<var>nan")), HasSubstr("<var> is 'nan': it must be a finite number"));
  EXPECT_THAT(texture_error(changed_file("<gain>1.0", "<gain>inf")), HasSubstr("it must be a finite number"));
  EXPECT_THAT(texture_error(changed_file("<speedMod>0.0", "<speedMod>1 2 0.0")), HasSubstr("it must be a finite number"));
  EXPECT_THAT(texture_error(changed_file("<speedMod>0.0", "<speedMod>-5")), HasSubstr("model 1: its speed"));
  EXPECT_THAT(texture_error(changed_file("ARlsf>", "lsf>")), HasSubstr("is not XML"));
  auto models = made::nine_models(20, 18);
  std::swap(models[4].ar[3], models[4].ar[4]);
  EXPECT_THAT(texture_error(made::texture_file(models, made::eight_triangles())), HasSubstr("model 5 is not stable"));
  models = made::nine_models(20, 18);
  EXPECT_THAT(texture_error(made::texture_file(models, {})), HasSubstr("there are 0 triangles"));
  EXPECT_THAT(texture_error(std::string(10000, '<')), HasSubstr("is not XML"));
  std::string deep;
  for (int n = 0; n < 100000; ++n) deep += "<a>";
  EXPECT_THAT(texture_error(deep), HasSubstr("is not XML"));
  std::string many;
  for (int n = 0; n < 5000; ++n) many += "<tri><value>1</value><value>2</value><value>4</value></tri>";
  EXPECT_THAT(texture_error(changed_file("<numTri>8</numTri>", many + "<numTri>5008</numTri>")), HasSubstr("<numTri> is 5008"));
  EXPECT_THAT(texture_error(changed_file("<numTri>8</numTri>", many.substr(0, 992 * 59) + "<numTri>1000</numTri>")),
              HasSubstr("1000 triangles"));
}

TEST(TextureFile, NamesThePath) {
  const ScratchFolder folder;
  const auto missing = read_texture_file(folder.path() / "gone.xml");
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error().what, AllOf(StartsWith((folder.path() / "gone.xml").string()), HasSubstr("no such file")));
  const auto broken = read_texture_file(folder.write("a.xml", "<modelSet/>"));
  ASSERT_FALSE(broken);
  EXPECT_THAT(broken.error().what, StartsWith((folder.path() / "a.xml").string() + ": line 1: "));
  EXPECT_FALSE(read_texture_file(folder.path()));
  EXPECT_FALSE(read_texture_file(folder.write("big.xml", std::string((std::size_t{1} << 22) + 1, ' '))));
  EXPECT_TRUE(read_texture_file(folder.write("good.xml", made::texture_file())));
}

// Whichever bytes change, vanish or are inserted: the result is an error of one line, or models that are finite.
TEST(TextureFile, SurvivesRandomChanges) {
  const std::string good = made::texture_file(made::nine_models(4, 2), made::eight_triangles());
  std::mt19937_64 random(3);
  int read_count = 0;
  for (int n = 0; n < 800; ++n) {
    std::string text = good;
    for (std::size_t k = 0; k <= random() % 3; ++k) {
      const std::size_t at = random() % text.size();
      const std::size_t kind = random() % 3;
      if (kind == 0) text[at] = static_cast<char>(random());
      if (kind == 1) text.erase(at, random() % 20);
      if (kind == 2) text.insert(at, text.substr(random() % text.size(), random() % 20));
    }
    const auto read = parse_texture(text);
    if (!read) {
      EXPECT_FALSE(read.error().what.empty());
      EXPECT_EQ(read.error().what.find('\n'), std::string::npos) << read.error().what;
      continue;
    }
    ++read_count;
    TextureModels::Blend blend;
    std::size_t triangle = 0;
    read->blend(0.1, 1.0, triangle, blend);
    EXPECT_TRUE(std::isfinite(blend.deviation));
    for (const double coefficient : read->ar(blend)) EXPECT_TRUE(std::isfinite(coefficient));
  }
  EXPECT_GT(read_count, 30);
}

}  // namespace
}  // namespace hapton
