#pragma once

#include <functional>
#include <string>

namespace hapton::doctor {

// The result of a function that was called in a child process.
struct ChildReply {
  std::string text;
  std::string failure;  // how it ended the child, that it took too long, or that no child could start; empty: it returned `text`
};

// Calls `task` in a child process, so that a library or driver that crashes, hangs or prints does not affect the doctor. Pre: this
// process has no other threads; task does not throw. RT: no.
ChildReply run_in_child(const std::function<std::string()>& task, double timeout_s);

}  // namespace hapton::doctor
