#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <string>
#include <vector>

#include "tools/hapton_command.h"

namespace hapton {

// What a person sees of a command.
struct CommandRun {
  int code = -1;
  std::string out;
  std::string err;
};

// Runs `hapton` with these words in this process.
inline CommandRun run_hapton(std::vector<std::string> words) {
  words.insert(words.begin(), "hapton");
  std::vector<const char*> argv;
  for (const std::string& word : words) argv.push_back(word.c_str());
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
