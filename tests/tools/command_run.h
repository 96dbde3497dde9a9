#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <string>
#include <vector>

#include "tools/hapton_command.h"

namespace hapton {

// Exit code and output of a command.
struct CommandRun {
  int code = -1;
  std::string out;
  std::string err;
};

// Runs `hapton` with these arguments in this process.
inline CommandRun run_hapton(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "hapton");
  std::vector<const char*> argv;
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  CommandRun run;
  run.code = run_hapton_command(static_cast<int>(argv.size()), argv.data());
  std::fflush(stdout);
  run.out = testing::internal::GetCapturedStdout();
  run.err = testing::internal::GetCapturedStderr();
  return run;
}

}  // namespace hapton
