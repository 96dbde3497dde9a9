#pragma once

#include <gtest/gtest.h>

#include <string>

#include "runtime/log.h"

namespace hapton {

// What a program writes to its log while `work` runs.
template <class Work>
std::string log_of(Work&& work) {
  start_log("test");
  testing::internal::CaptureStderr();
  work();
  return testing::internal::GetCapturedStderr();
}

}  // namespace hapton
