#include "runtime/toml_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>

#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;

struct TomlFiles : testing::Test {
  ScratchFolder scratch;
  std::filesystem::path path = scratch.path() / "f.toml";

  TomlReader open(const std::string& text) {
    std::ofstream(path) << text;
    auto reader = TomlReader::open(path);
    EXPECT_TRUE(reader) << (reader ? "" : reader.error().what);
    return *reader;
  }
  // The error when `read` reads a file with this text.
  std::string rejection(const std::string& text, const std::function<void(TomlReader&)>& read) {
    TomlReader reader = open(text);
    read(reader);
    const auto result = reader.result();
    return result ? "nothing" : result.error().what;
  }
};

TEST_F(TomlFiles, AreReadKeyByKey) {
  TomlReader reader = open("text = \"a\"\nflag = true\nnumber = 2\nwhole = -7\nplace = [1, 2.5, -3]\nfile = \"x/../y.csv\"\n");
  std::string text, file;
  bool flag = false;
  double number = 0.0, absent = 5.0;
  std::int64_t whole = 0;
  Vec3 place = Vec3::Zero();
  reader.allow({"text", "flag", "number", "whole", "place", "file"});
  reader.require("text");
  reader.read("text", text);
  reader.read("flag", flag);
  reader.read("number", number, 0.0, 10.0);
  reader.read("absent", absent, 0.0, 10.0);
  reader.read("whole", whole, -10, 10);
  reader.read("place", place, -5.0, 5.0);
  reader.read_path("file", file);
  EXPECT_TRUE(reader.result()) << reader.result().error().what;
  EXPECT_EQ(text, "a");
  EXPECT_TRUE(flag);
  EXPECT_EQ(number, 2.0);
  EXPECT_EQ(absent, 5.0);
  EXPECT_EQ(whole, -7);
  EXPECT_EQ(place, Vec3(1.0, 2.5, -3.0));
  EXPECT_EQ(file, (scratch.path() / "y.csv").string());
}

TEST_F(TomlFiles, HaveTables) {
  TomlReader reader = open("[[device]]\nname = \"a\"\n[[device]]\nname = \"b\"\n[motor]\nk = 2.0\n");
  std::vector<TomlReader> devices = reader.tables("device");
  ASSERT_EQ(devices.size(), 2U);
  std::string name;
  devices[1].read("name", name);
  EXPECT_EQ(name, "b");
  double k = 0.0;
  reader.table("motor").read("k", k, 0.0, 5.0);
  EXPECT_EQ(k, 2.0);
  EXPECT_TRUE(reader.tables("none").empty());
  EXPECT_FALSE(reader.table("none").has("k"));
  EXPECT_TRUE(reader.result());
}

TEST_F(TomlFiles, SayWhereTheyAreWrong) {
  double number = 1.0;
  std::int64_t whole = 1;
  bool flag = false;
  std::string text;
  Vec3 place = Vec3::Ones();
  EXPECT_THAT(rejection("a = 1\nnmae = 2\n",
                        [](TomlReader& r) {
                          r.allow({"a", "name"});
                        }),
              AllOf(HasSubstr("f.toml:2: unknown key 'nmae'"), HasSubstr("a, name")));
  EXPECT_THAT(rejection("[[device]]\n", [](TomlReader& r) { r.tables("device").front().require("name"); }),
              HasSubstr("f.toml:1: 'name' is missing in [[device]] 1; add it"));
  EXPECT_THAT(rejection("n = 11", [&](TomlReader& r) { r.read("n", number, 0.0, 10.0); }), HasSubstr("'n' is 11: it must be at least 0"));
  EXPECT_THAT(rejection("n = nan", [&](TomlReader& r) { r.read("n", number, 0.0, 10.0); }), HasSubstr("'n' is nan"));
  EXPECT_THAT(rejection("n = true", [&](TomlReader& r) { r.read("n", number, 0.0, 10.0); }), HasSubstr("must be a number"));
  EXPECT_THAT(rejection("n = 1.5", [&](TomlReader& r) { r.read("n", whole, 0, 10); }), HasSubstr("must be a whole number"));
  EXPECT_THAT(rejection("n = -1", [&](TomlReader& r) { r.read("n", whole, 0, 10); }), HasSubstr("'n' is -1"));
  EXPECT_THAT(rejection("n = 1", [&](TomlReader& r) { r.read("n", flag); }), HasSubstr("true or false"));
  EXPECT_THAT(rejection("n = 1", [&](TomlReader& r) { r.read("n", text); }), HasSubstr("text in quotes"));
  EXPECT_THAT(rejection("n = \"\"", [&](TomlReader& r) { r.read_path("n", text); }), HasSubstr("'n' is empty"));
  text = "kept";
  EXPECT_THAT(rejection("n = 3", [&](TomlReader& r) { r.read_path("n", text); }), HasSubstr("'n' must be a text in quotes"));
  EXPECT_EQ(text, "kept");
  EXPECT_THAT(rejection("n = [1, 2]", [&](TomlReader& r) { r.read("n", place, 0.0, 1.0); }), HasSubstr("list of 3 numbers"));
  EXPECT_THAT(rejection("n = [0, 2, 0]", [&](TomlReader& r) { r.read("n", place, 0.0, 1.0); }), HasSubstr("number 2 of 'n' is 2"));
  EXPECT_THAT(rejection("n = [0]", [](TomlReader& r) { r.tables("n"); }), HasSubstr("[[n]]"));
  EXPECT_THAT(rejection("n = 0", [](TomlReader& r) { r.table("n"); }), HasSubstr("[n]"));
  EXPECT_THAT(rejection("\nn = 0", [](TomlReader& r) { r.reject("n", "no n wanted"); }), EndsWith("f.toml:2: no n wanted"));
  EXPECT_EQ(number, 1.0);
  EXPECT_EQ(place, Vec3::Ones());
}

TEST_F(TomlFiles, KeepTheirFirstError) {
  EXPECT_THAT(rejection("a = 1\nb = 2\n",
                        [](TomlReader& r) {
                          std::string text;
                          r.read("b", text);
                          r.read("a", text);
                        }),
              HasSubstr("f.toml:2"));
}

TEST_F(TomlFiles, MustBeReadableToml) {
  EXPECT_THAT(TomlReader::open(scratch.path() / "none.toml").error().what, HasSubstr("none.toml"));
  EXPECT_FALSE(TomlReader::open(scratch.path()));
  std::ofstream(path) << "a = 1\nb = = 2\n";
  EXPECT_THAT(TomlReader::open(path).error().what, HasSubstr("f.toml:2: "));
  std::ofstream(path) << "a = 1\nname = \"K\xf6rper\"\n";  // Latin-1
  EXPECT_THAT(TomlReader::open(path).error().what, AllOf(HasSubstr("f.toml:2: "), HasSubstr("; save the file as UTF-8")));
  std::ofstream(path) << std::string(2 << 20, '#');
  EXPECT_THAT(TomlReader::open(path).error().what, HasSubstr("bytes, more"));
}

}  // namespace
}  // namespace hapton
