// README puts the programs on the PATH before it uses them, systemd units restart, and links and test names in the docs exist.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>
#include <vector>

namespace hapton::structure {
namespace {

using ::testing::IsEmpty;
namespace fs = std::filesystem;

std::vector<std::string> read_lines(const fs::path& file) {
  std::ifstream in(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

fs::path source_root() { return HAPTON_SOURCE_DIR; }

bool is_command_of(const std::string& line, const std::string& program) { return line.starts_with(program + " ") || line == program; }

TEST(Readme, PutsTheProgramsOnThePathBeforeItsFirstCommandOfTheirs) {
  bool is_code = false;
  bool has_path = false;
  int commands = 0;
  for (const std::string& line : read_lines(source_root() / "README.md")) {
    if (line.starts_with("```")) is_code = !is_code;
    if (!is_code) continue;
    has_path = has_path || line.starts_with("export PATH=\"$PWD/build/release/bin:");
    for (const char* program : {"hapton", "io_node", "haptics_node", "vision_node"}) {
      if (!is_command_of(line, program)) continue;
      ++commands;
      EXPECT_TRUE(has_path) << line;
    }
  }
  EXPECT_GT(commands, 5);
}

// By default, systemd gives up a unit that ends five times in ten seconds. A node ends at once while the hub's host has no address.
TEST(Units, AreStartedAgainHoweverOftenTheyEnd) {
  int units = 0;
  for (const auto& entry : fs::directory_iterator(source_root() / "deploy/systemd")) {
    if (entry.path().extension() != ".service") continue;
    ++units;
    const std::vector<std::string> lines = read_lines(entry.path());
    const auto service = std::ranges::find(lines, "[Service]");
    EXPECT_NE(std::find(service, lines.end(), "Restart=on-failure"), lines.end()) << entry.path();
    EXPECT_NE(std::find(lines.begin(), service, "StartLimitIntervalSec=0"), service) << entry.path() << " in [Unit]";
    // There is no restart after exit status 3: the device has failed for good, and a person must start the unit again.
    const bool is_hub = entry.path().filename() == "hapton-io.service";
    EXPECT_EQ(std::find(service, lines.end(), "RestartPreventExitStatus=3") != lines.end(), is_hub) << entry.path();
  }
  EXPECT_EQ(units, 3);
}

// The links and pictures of a page, [text](file#part), whose file is not in the tree.
std::vector<std::string> find_broken_links(const fs::path& page) {
  static const std::regex link(R"(\]\(([^)\s#]+)(#[^)]*)?\))");
  std::vector<std::string> broken;
  bool is_code = false;
  for (const std::string& line : read_lines(page)) {
    if (line.starts_with("```")) is_code = !is_code;
    if (is_code) continue;
    for (std::sregex_iterator at(line.begin(), line.end(), link), end; at != end; ++at) {
      const std::string target = (*at)[1];
      if (target.find("://") != std::string::npos || target.starts_with("mailto:")) continue;
      if (!fs::exists(page.parent_path() / target)) broken.push_back(page.filename().string() + ": " + target);
    }
  }
  return broken;
}

TEST(Docs, EveryLinkAndPictureLeadsToAFileOfTheTree) {
  std::vector<fs::path> pages = {source_root() / "README.md", source_root() / "CONTRIBUTING.md"};
  for (const auto& entry : fs::recursive_directory_iterator(source_root() / "docs")) {
    if (entry.path().extension() == ".md") pages.push_back(entry.path());
  }
  EXPECT_GT(pages.size(), 30U);
  for (const fs::path& page : pages) EXPECT_THAT(find_broken_links(page), IsEmpty());
}

TEST(Docs, ABrokenLinkIsFound) {
  const fs::path page = fs::temp_directory_path() / "hapton_docs_test.md";
  std::ofstream(page) << "[a](nowhere.md#x) ![b](nowhere.png) [c](https://example.org/d)\n```\n[e](code)\n```\n";
  EXPECT_EQ(find_broken_links(page).size(), 2U);
  fs::remove(page);
}

// "Suite.Name" of every test of the tree.
std::vector<std::string> list_tests() {
  static const std::regex test(R"(\b(?:TYPED_)?TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\))");
  std::vector<std::string> tests;
  for (const auto& entry : fs::recursive_directory_iterator(source_root() / "tests")) {
    if (entry.path().extension() != ".cpp") continue;
    std::ifstream in(entry.path());
    const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    for (std::sregex_iterator at(text.begin(), text.end(), test), end; at != end; ++at)
      tests.push_back((*at)[1].str() + "." + (*at)[2].str());
  }
  return tests;
}

// The names of tests in a page, such as `link_test.Suite.Name` or `link_test.Suite.Beginning…`, that no test has.
std::vector<std::string> find_unknown_tests(const fs::path& page, const std::vector<std::string>& tests) {
  static const std::regex name(R"(`[a-z_]+_test\.(?:[A-Za-z]+/)?([A-Z]\w*\.[A-Za-z]\w*)(…)?`)");
  std::vector<std::string> unknown;
  for (const std::string& line : read_lines(page)) {
    for (std::sregex_iterator at(line.begin(), line.end(), name), end; at != end; ++at) {
      const std::string test_name = (*at)[1];
      const bool is_beginning = (*at)[2].matched;
      const bool is_known = std::any_of(
          tests.begin(), tests.end(), [&](const std::string& one) { return is_beginning ? one.starts_with(test_name) : one == test_name; });
      if (!is_known) unknown.push_back(page.filename().string() + ": " + test_name);
    }
  }
  return unknown;
}

TEST(Docs, EveryTestThatIsNamedIsThere) {
  const std::vector<std::string> tests = list_tests();
  EXPECT_GT(tests.size(), 3000U);
  for (const auto& entry : fs::directory_iterator(source_root() / "docs")) {
    if (entry.path().extension() != ".md") continue;
    EXPECT_THAT(find_unknown_tests(entry.path(), tests), IsEmpty());
  }
}

TEST(Docs, ATestThatIsNotThereIsFound) {
  const fs::path page = fs::temp_directory_path() / "hapton_docs_tests.md";
  std::ofstream(page) << "`a_test.Suite.Name`, `a_test.Suite.Na…`, `a_test.Suite.Other`, `a_test.All/Suite.Nam`, `a_test.Suite.…`\n";
  EXPECT_EQ(find_unknown_tests(page, {"Suite.Name"}).size(), 2U);
  fs::remove(page);
}

}  // namespace
}  // namespace hapton::structure
