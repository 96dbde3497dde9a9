#pragma once

#include <functional>
#include <string>

namespace hapton::doctor {

// The result of a call to foreign code.
struct ChildReply {
  std::string text;
  std::string failure;  // how it ended the process, or that it took too long; empty: it returned
};

// Calls a function in a child process, so that a library or driver that crashes, hangs or prints does not affect the doctor. Pre: the
// caller has no other threads. RT: no.
ChildReply run_in_child(const std::function<std::string()>& question, double at_most_s);

}  // namespace hapton::doctor
