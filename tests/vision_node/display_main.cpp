#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/timed/stall_watch.h"

namespace {

// Collects the names of the tests that have failed, as a filter of GoogleTest.
class FailedTests : public testing::EmptyTestEventListener {
 public:
  const std::string& filter() const { return filter_; }

 private:
  void OnTestEnd(const testing::TestInfo& test) override {
    if (test.result()->Failed()) filter_ += std::string(filter_.empty() ? "" : ":") + test.test_suite_name() + "." + test.name();
  }

  std::string filter_;
};

// Replaces this process. Returns only if there is no such program.
void replace_process_by(std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  std::fflush(nullptr);
  execvp(arguments[0], arguments.data());
}

}  // namespace

// Runs the tests. Without a display the program starts itself again under Xvfb; without a display and Xvfb it is skipped (77).
// The tests take minutes, in which a busy machine nearly always stalls once. So if the machine stalled, hapton_timed runs the tests that
// failed again alone: they take only seconds.
int main(int argc, char** argv) {
  const std::vector<std::string> command_line(argv, argv + argc);
  const char* display = std::getenv("DISPLAY");
  const bool is_listing = argc > 1 && std::string_view(argv[1]) == "--gtest_list_tests";
  if (!is_listing && (display == nullptr || *display == '\0')) {
    std::vector<std::string> words = {"xvfb-run", "-a", "-s", "-screen 0 1280x1024x24"};
    words.insert(words.end(), command_line.begin(), command_line.end());
    replace_process_by(std::move(words));
    std::puts("skipped: no display, and no xvfb-run to make one (install xvfb)");
    return 77;
  }
  constexpr const char* kAgain = "HAPTON_RUN_AGAIN";
  const bool is_second_run = std::getenv(kAgain) != nullptr;
  testing::InitGoogleTest(&argc, argv);
  auto* failed = new FailedTests;  // belongs to GoogleTest
  testing::UnitTest::GetInstance()->listeners().Append(failed);
  hapton::StallWatch watch;
  const int code = RUN_ALL_TESTS();
  const std::int64_t stall_ns = watch.end();
  if (code == 0 || is_second_run || failed->filter().empty() || stall_ns < hapton::StallWatch::kForceLifeNs / 2) return code;
  std::printf("this machine stood still for %.1f ms meanwhile: %s is run again\n", 1e-6 * static_cast<double>(stall_ns),
              failed->filter().c_str());
  setenv(kAgain, "1", 1);
  // The filter names only tests of this shard, and all of them must run.
  unsetenv("GTEST_TOTAL_SHARDS");
  unsetenv("GTEST_SHARD_INDEX");
  replace_process_by({HAPTON_TIMED, command_line[0], "--gtest_filter=" + failed->filter()});
  return code;
}
