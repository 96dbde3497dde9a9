#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

// Runs the tests where there is a display; starts itself again under Xvfb where there is none; is skipped (77) only where there is neither.
int main(int argc, char** argv) {
  const char* display = std::getenv("DISPLAY");
  const bool listing = argc > 1 && std::string_view(argv[1]) == "--gtest_list_tests";
  if (!listing && (display == nullptr || *display == '\0')) {
    std::vector<char*> arguments;
    for (const char* word : {"xvfb-run", "-a", "-s", "-screen 0 1280x1024x24"}) arguments.push_back(const_cast<char*>(word));
    for (int i = 0; i < argc; ++i) arguments.push_back(argv[i]);
    arguments.push_back(nullptr);
    execvp(arguments[0], arguments.data());
    std::puts("skipped: no display, and no xvfb-run to make one (install xvfb)");
    return 77;
  }
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
