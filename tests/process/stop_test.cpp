// A node that gets a stop request while it still loads its scene ends in order.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>

#include "tests/process/program.h"

namespace hapton::process {
namespace {

// Large enough that the test can look at the node while it reads the mesh.
void write_large_mesh(const std::filesystem::path& path) {
  constexpr int kSide = 400;
  std::ofstream file(path);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) file << "v " << 0.001 * x << ' ' << 0.001 * y << " 0\n";
  }
  for (int y = 0; y + 1 < kSide; ++y) {
    for (int x = 1; x < kSide; ++x) {
      const int v = y * kSide + x;
      file << "f " << v << ' ' << v + 1 << ' ' << v + kSide + 1 << ' ' << v + kSide << '\n';
    }
  }
}

bool catches_sigterm(pid_t pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind("SigCgt:", 0) == 0) return (std::strtoull(line.c_str() + 7, nullptr, 16) >> (SIGTERM - 1) & 1U) != 0;
  }
  return false;
}

// The node names its method as soon as the scene is loaded.
bool has_loaded(const Program& node) { return node.err().find("proxy:") != std::string::npos; }

TEST(Stopping, WhileItLoadsItsSceneEndsInOrder) {
  const TestFolder folder;
  write_large_mesh(folder.path() / "large.obj");
  // On a busy machine the test may be too late for one node: then it starts another.
  bool was_loading = false;
  for (int attempt = 0; attempt < 10 && !was_loading; ++attempt) {
    Program node("haptics_node", {"--scene", (folder.path() / "large.obj").string()}, folder.path());
    while (node.is_running() && !catches_sigterm(node.pid()) && !has_loaded(node))
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    node.send_signal(SIGTERM);
    was_loading = !has_loaded(node);
    const auto ended = node.wait(kPatience);
    ASSERT_TRUE(ended) << "still runs";
    EXPECT_EQ(ended->exit_code, 0) << ended->err;
  }
  EXPECT_TRUE(was_loading);
}

// As `io_node 2>&1 | tee log` after tee has ended: the end of the program that reads the node's output must not end the force.
TEST(Stopping, ANodeOutlivesTheProgramThatReadsItsOutput) {
  const TestFolder folder;
  const std::string code = (folder.path() / "code").string();
  // Requests enough reports to fill more than one buffer of the output.
  const std::string script = std::string(HAPTON_BIN_DIR) +
                             "/io_node --bind 127.0.0.1:0 2>&1 & node=$!; "
                             "for n in 1 2 3 4 5 6 7 8 9 10; do sleep 0.2; kill -USR1 $node; done; "
                             "sleep 0.2; kill $node; wait $node; echo $? > " +
                             code;
  Program shell("/bin/sh", {"-c", "(" + script + ") | head -n 1"}, folder.path());
  const auto ended = shell.wait(kPatience);
  ASSERT_TRUE(ended) << "still runs";
  EXPECT_FALSE(ended->out.empty());
  std::ifstream file(code);
  int exit_code = -1;
  file >> exit_code;
  EXPECT_EQ(exit_code, 0) << "128 + n: signal n";
}

}  // namespace
}  // namespace hapton::process
